"""The deformed shell at several instants."""

from typing import Annotated

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from corovec.solver.checks import numbers
from corovec.solver.errors import InputError
from corovec.solver.signatures import checked

from .colours import ENERGY, Color, coloured
from .recording import Recording
from .space import Angles, Space, View, best_view, bounds
from .style import WIDTH, styled
from .symbols import Drawing

MOVED = 0.5
"""A shell that travels this multiple of its size has its way drawn above its frames."""

HIGHEST = 0.45
"""Largest height of the picture of a way relative to its width."""

MOST_NAMED = 11
"""Instants along a way that have their times beside them, at most."""

COLUMNS = {12: 4, 20: 5}
"""Most frames, and in how many columns they stand; of more, in ``MOST_COLUMNS``."""

MOST_COLUMNS = 7

FRAMES = 8
"""Instants of a sequence, if none are asked for."""


def _times(name, times):
    items = numbers(name, times)
    if not items:
        raise InputError(f"{name} must not be empty")
    return items


@checked
@styled
def sequence(recording: Recording, times: Annotated[tuple, _times] = None, scale: float = 1.0,
             view: Angles = None, color: Color = ENERGY):
    """Deformed shells at several instants, coloured by strain energy density or a stress.

    Figs. 6, 9, 13, 17.  Frame beside frame, all with the same axes.  Those of a shell that travels
    are each about its centre, the mean over the initial area, which is the mass centre of an even
    shell; above them is the way of the centre, with the shell where it stands clear of others.

    Args:
        recording: ``Recording``.
        times: [s], in statics load factors; the nearest frames are taken.  Default: 8 evenly.
        scale: factor of the displacements.
        view: as of ``mesh_and_loads``.
        color: ``strain_energy_density`` [J/m^2], ``von_mises``, or a component, see ``coloured``.

    Returns:
        (Figure, DataFrame): columns time, element, corner, x, y, z, that of ``color``, and
        centre_x, centre_y, centre_z of a shell that travels.

    Raises:
        InputError: a time outside the recorded ones, or no stresses to colour by.
    """
    if times is None:
        frames = np.unique(np.linspace(0, len(recording.times) - 1, FRAMES).round().astype(int))
    else:
        frames = recording.frames_at(times)
    corners = recording.positions(scale)[frames][:, recording.quads]
    colours, times = coloured(recording, color).at(frames), recording.times[frames]
    centres = np.average(corners.mean(axis=2), axis=1, weights=recording.areas)
    travels = np.ptp(centres, axis=0).max() > MOVED * np.ptp(recording.nodes, axis=0).max()
    framed = corners - centres[:, None, None] if travels else corners
    view = best_view(framed.reshape(-1, 4, 3)) if view is None else View(*view)
    captions = [instant(recording, time) for time in times]
    way = (corners, centres) if travels and len(frames) > 1 else None
    places = recording.symbol_places(frames, scale)
    figure = side_by_side(framed, colours, captions, view, way, (
        recording.symbols, places - centres[:, None] if travels else places))
    n, n_elem = corners.shape[:2]
    x, y, z = corners.reshape(-1, 3).T
    return figure, pd.DataFrame({
        "factor" if recording.static else "time": np.repeat(times, 4 * n_elem),
        "element": np.tile(np.repeat(np.arange(n_elem), 4), n),
        "corner": np.tile(np.arange(4), n * n_elem), "x": x, "y": y, "z": z,
        color: np.repeat(colours.values.ravel(), 4),
        **({f"centre_{c}": np.repeat(centres[:, k], 4 * n_elem) for k, c in enumerate("xyz")}
           if travels else {})})


def instant(recording, time):
    """What is written beside a frame."""
    return f"λ = {time:.4g}" if recording.static else f"{time:.4g} s"


def side_by_side(corners, coloured, captions, view, way=None, joined=None):
    """A panel for each frame (n, n_elem, 4, 3), all of one scale, below the ``way`` (corners and
    centres on it) if there is one; ``joined``: ``Symbols``, and places (n, n_points, 3) of their
    points."""
    most = next((columns for n, columns in COLUMNS.items() if len(corners) <= n), MOST_COLUMNS)
    columns, scale, values = min(most, len(corners)), coloured.scale, coloured.values
    symbols, places = joined or (None, np.zeros((len(corners), 0, 3)))
    seen = np.concatenate([view(part).reshape(-1, 2) for part in (corners, places)])
    (left, low), (right, high) = seen.min(axis=0), seen.max(axis=0)
    heights = [0.25 + 0.95 * WIDTH / columns * (high - low) / (right - left)] * -(
        -len(corners) // columns)
    if way:
        heights.insert(0, 0.3 + WIDTH * min(HIGHEST, 0.8 * view.aspect(bounds(way[0]))))
    figure = Figure(figsize=(WIDTH, 0.65 + sum(heights)), layout="constrained")
    grid = figure.add_gridspec(len(heights), columns, height_ratios=heights)
    panels = [figure.add_subplot(grid[bool(way) + k // columns, k % columns])
              for k in range(len(corners))]
    looks = {"norm": scale.norm, "cmap": scale.cmap, "edge": (0.0, 0.0, 0.0, 0.45), "line": 0.15}
    for k, caption in enumerate(captions):
        space = Space(panels[k], view, bounds(corners), ruled=False)
        space.elements(corners[k:k + 1], array=values[k:k + 1], **looks)
        if symbols:
            Drawing(space, symbols, places[k], size=0.6)
        panels[k].set(xlim=(left, right), ylim=(low, high))
        panels[k].set_title(caption, size=7.5, pad=3.0)
    space.scale_bar()
    coloured.bar(figure, scale, panels, location="bottom", shrink=0.5, aspect=35)
    if way:
        _draw_way(figure.add_subplot(grid[0, :]), *way, values, captions, view, looks)
    return figure


def _draw_way(axes, corners, centres, values, captions, view, looks):
    """The line of the centres, a dot for each instant, and the shell where it stands clear."""
    space = Space(axes, view, bounds(corners))
    seen = view(corners.reshape(len(corners), -1, 3))
    shells, size = _clear(seen), np.ptp(seen, axis=1).max() / np.ptp(seen, axis=(0, 1)).max()
    space.elements(corners[shells], array=values[shells],
                   **{**looks, "edge": (0.0, 0.0, 0.0, min(0.45, 2.0 * size))})
    line, dots = {"linewidth": 0.5, "zorder": 1.5}, {"marker": ".", "markersize": 3.0, "zorder": 4}
    for looks in (line, {"linestyle": "", "markeredgewidth": 0.0, **dots}):
        axes.plot(*view(centres).T, color="0.1", clip_on=False, **looks)
    named = range(0, len(captions), -(-len(captions) // MOST_NAMED))
    space.names([(centres[k], captions[k], (1.0, -1.0), {"size": 7.0}) for k in named],
                [(corners[shells].mean(axis=2), 0.5)])


def _clear(seen):
    """Numbers of the shells ``seen`` on the screen (n, n_points, 2) whose boxes are apart: the
    first, the last, and of the others each that is clear of those before."""
    low, high = seen.min(axis=1), seen.max(axis=1)
    kept = []
    for k in (0, *range(len(seen) - 1, 0, -1)):
        if all(np.any((low[k] > high[one]) | (high[k] < low[one])) for one in kept):
            kept.append(k)
    return sorted(kept)
