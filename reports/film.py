"""Films of runs: the shell in motion, coloured by what is asked for, beside its energies."""

import shutil
from pathlib import Path

import numpy as np
from matplotlib import rcParams
from matplotlib.animation import FFMpegWriter, FuncAnimation, HTMLWriter, PillowWriter
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from corovec.solver.checks import integer, number, positive
from corovec.solver.dynamics.result import total_energy
from corovec.solver.errors import InputError
from corovec.solver.results.files import replacing, writable_path

from .colours import ENERGY, coloured
from .scenes import instant
from .space import Space, View, best_view, bounds
from .style import BLACK, BLUE, VERMILLION, styled
from .symbols import FEW_NAMES, Drawing, key_of_symbols

FORMATS = (".gif", ".mp4", ".html")

SIZE, DOTS = (8.0, 4.5), 100
"""Inches, and dots an inch: even numbers of dots, which MP4 needs."""

FASTEST_GIF = 50.0
"""Frames a second beyond which browsers slow a GIF down."""

SLOWEST_GIF = 0.002
"""Frames a second below which a GIF cannot tell how long a frame stays (65535 hundredths of a
second at most)."""


@styled
def animate(recording, path, *, fps=25.0, frames=None, scale=1.0, view=None, follow=False,
            color=ENERGY, overwrite=False, progress=None):
    """Write a film of ``recording`` to ``path``, by its ending a GIF, an MP4 or a page (HTML).

    Args:
        recording: ``Recording``.
        fps: frames a second.
        frames: number of recorded frames that are shown, evenly spaced; default: all.
        scale: factor of the displacements.
        view: (elevation, azimuth) [degrees]; default: where most is seen.
        follow: keep the middle of the shell in the middle of the picture.
        color: what colours the elements, see ``coloured``.
        overwrite: replace ``path`` if it exists.
        progress: called after every frame with (number, frames of the film).

    Returns:
        Path of the film.

    Raises:
        InputError: a wrong parameter, no stresses to colour by, or no ffmpeg for an MP4.
        ResultFileError: ``path`` exists and is not to be overwritten, or cannot be written.
    """
    path = film_path(path, overwrite)
    kind = path.suffix.lower()
    fps, scale = positive("fps", fps), number("scale", scale)
    if kind == ".gif" and not SLOWEST_GIF <= fps <= FASTEST_GIF:
        raise InputError(f"fps must lie in [{SLOWEST_GIF:g}, {FASTEST_GIF:g}] in a GIF, is {fps:g}")
    shown = np.arange(len(recording.times))
    if frames is not None:
        if integer("frames", frames) < 2:
            raise InputError(f"frames must be 2 at least, is {frames}")
        shown = np.unique(np.linspace(0, shown[-1], min(frames, len(shown))).round().astype(int))
    writer = _writer(kind, fps)
    colours = coloured(recording, color).at(shown)
    figure, draw = _scene(recording, shown, scale, view, follow, colours)
    with replacing(path) as partial:
        FuncAnimation(figure, draw, len(shown), init_func=lambda: None).save(
            partial, writer=writer, dpi=DOTS,
            progress_callback=None if progress is None else lambda k, n: progress(k + 1, n))
    return path


def film_path(path, overwrite=False):
    """``path`` as that of a film.

    Raises:
        InputError: it has no ending of ``FORMATS``.
        ResultFileError: it exists and is not to be overwritten, or cannot be written.
    """
    if Path(path).suffix.lower() not in FORMATS:
        raise InputError(f"{path}: the ending of a film must be one of: {', '.join(FORMATS)}")
    return writable_path(path, overwrite)


def _writer(kind, fps):
    if kind == ".gif":
        return PillowWriter(fps=fps)
    if kind == ".html":
        return HTMLWriter(fps=fps, embed_frames=True, embed_limit=np.inf)
    rcParams["animation.ffmpeg_path"] = _ffmpeg()
    return FFMpegWriter(fps=fps, codec="libx264")


def _ffmpeg():
    """The program ffmpeg, of the system or of the package imageio-ffmpeg."""
    if found := shutil.which("ffmpeg"):
        return found
    try:
        from imageio_ffmpeg import get_ffmpeg_exe
        return get_ffmpeg_exe()
    except (ImportError, RuntimeError):
        raise InputError("an MP4 needs ffmpeg: install it, or pip install 'corovec[mp4]', or write "
                         "a .gif or .html") from None


def _scene(recording, shown, scale, view, follow, coloured):
    """The figure, and the function that draws frame k of ``shown`` into it."""
    positions, places = recording.positions(scale)[shown], recording.symbol_places(shown, scale)
    if follow:
        shift = positions.mean(axis=1, keepdims=True)
        positions, places = positions - shift, places - shift
    corners, values = positions[:, recording.quads], coloured.values
    view = best_view(corners.reshape(-1, 4, 3)) if view is None else View(*view)
    figure = Figure(figsize=SIZE, dpi=DOTS, layout="constrained")
    canvas = FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2, width_ratios=(2.6, 1.0))
    space = Space(left, view, bounds(positions, places), ruled=not follow)
    if follow:
        space.scale_bar()
    colours = coloured.scale
    polygons = space.elements(corners[:1], array=values[:1], norm=colours.norm,
                              cmap=colours.cmap, line=0.25)
    coloured.bar(figure, colours, left, location="bottom", shrink=0.6, aspect=30)
    drawing = Drawing(space, recording.symbols, places[0], named=FEW_NAMES)
    key_of_symbols(left, recording.symbols)
    now = _energies(right, recording)
    title = figure.suptitle(instant(recording, recording.times[shown[-1]]))
    canvas.draw()
    figure.set_layout_engine("none")

    def draw(k):
        space.move(polygons, corners[k:k + 1], values[k:k + 1])
        drawing.move(places[k])
        title.set_text(instant(recording, recording.times[shown[k]]))
        now.set_xdata([recording.times[shown[k]]] * 2)

    return figure, draw


def _energies(axes, recording):
    """Energies over time, or over the load factor; returns the line that marks the instant."""
    history = recording.history
    if recording.static:
        axes.plot(history["factor"], history["strain_energy"], color=VERMILLION)
        axes.set(xlabel="load factor", ylabel="strain energy [J]")
    else:
        for values, name, colour, dashes in (
                (total_energy(history), "total", BLACK, "-"),
                (history["kinetic_energy"], "kinetic", BLUE, "-"),
                (history["strain_energy"], "strain", VERMILLION, (0, (5, 1.5)))):
            axes.plot(history["time"], values, color=colour, linestyle=dashes, label=name)
        axes.set(xlabel="time [s]", ylabel="energy [J]")
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, handlelength=1.5,
                    columnspacing=0.8)
    return axes.axvline(recording.times[0], color="0.4", linewidth=0.9)
