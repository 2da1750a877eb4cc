"""Data of the interactive player: frames of a run, quantised and packed for the page.

Positions are 16-bit integers over their range (1e-5 of it is lost), strain energy densities 8-bit
colours; both gzipped and in base64, which any browser unpacks by itself.
"""

import base64
import gzip

import numpy as np
from matplotlib.colors import to_hex

from .colours import colour_scale
from .space import best_view
from .symbols import LOOKS

MOST_FRAMES = 201
STEPS = 65535
COLOURS = 255
STOPS = 11
"""Colours of the figures' map that the player interpolates."""


def player(recording, every=None):
    """The player's data of a ``Recording``, ready for JSON.

    Args:
        recording: the run.
        every: frames taken, each n-th; default: at most ``MOST_FRAMES``.

    Returns:
        dict: counts, times [s], energies [J], the centre's path [m], the direction to the eye at
        the start, the map of colours, the packed arrays with what unpacks them, and lines and marks
        of joints and bodies by their looks, whose points follow the nodes in ``position``.
    """
    every = every or -(-len(recording.times) // MOST_FRAMES)
    x = recording.positions()[::every]
    centre, n = _centres(x, recording), x.shape[1]
    places = recording.symbol_places(np.arange(0, len(recording.times), every))
    x = np.concatenate([x, places], axis=1) - centre[:, None]
    low, size = x.min(axis=(0, 1)), float(np.ptp(x, axis=(0, 1)).max())
    density = recording.energy_density[::every]
    scale = colour_scale(density)
    top = float(scale.norm.vmax)
    rows = recording.history[recording.frame_rows[::every]]
    scaled = (x - low) / size * STEPS
    return {
        "frames": len(x), "nodes": x.shape[1], "symbols": _symbols(recording.symbols, n),
        "elements": recording.elements,
        "times": _rounded(recording.times[::every]), "centre": _rounded(centre.T),
        "kinetic": _rounded(rows["kinetic_energy"]), "strain": _rounded(rows["strain_energy"]),
        "eye": _rounded(best_view(x[:, recording.quads].reshape(-1, 4, 3)).eye),
        "low": _rounded(low), "size": size, "steps": STEPS, "colours": COLOURS, "top": top,
        "scale": [[stop, to_hex(scale.cmap(stop))] for stop in np.linspace(0.0, 1.0, STOPS)],
        "position": _packed(scaled.round().astype("<u2")),
        "density": _packed((np.clip(density / top, 0.0, 1.0) * COLOURS).round().astype("u1")),
        "quads": _packed(recording.quads.astype("<u2"))}


MARKS = {"dot": "circle", "ring": "circle-open", "square": "square", "end": "circle",
         "rhomb": "diamond", "foot": "cross", "cross": "x"}
"""Marks of Plotly by their looks."""


LARGEST = 6.0
"""Size of a mark that needs no more."""


def _symbols(symbols, first):
    """Lines and marks of the same look, each with the numbers of its points, which begin at
    ``first``."""
    found = {}
    for symbol in (*symbols.lines, *symbols.marks):
        found.setdefault(symbol.look, []).extend(first + point for point in symbol.points)
    rows = []
    for name, points in found.items():
        look = LOOKS[name]
        rows.append({"colour": to_hex(look.colour), "width": min(look.width, LARGEST),
                     "points": points, "mark": MARKS.get(name)})
    return rows


def packed_text(text):
    """A long text, as the Plotly library, gzipped and in base64."""
    return _packed(np.frombuffer(text.encode(), dtype="u1"))


def _centres(x, recording):
    """Centres of area of every frame (n, 3), with the elements' initial areas [m]."""
    area = recording.areas
    return np.einsum("fejc,e->fc", x[:, recording.quads], area / (4.0 * area.sum()))


def _packed(array):
    data = gzip.compress(np.ascontiguousarray(array).tobytes(), 9, mtime=0)
    return base64.b64encode(data).decode("ascii")


def _rounded(values):
    return [_rounded(row) if np.ndim(row) else float(f"{row:.6g}") for row in np.asarray(values)]
