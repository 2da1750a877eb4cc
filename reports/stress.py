"""The stress at the end of a recording."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from corovec.solver.results.stresses import LEVELS
from corovec.solver.signatures import checked

from .colours import VON_MISES, Color, coloured
from .recording import Recording
from .scenes import Angles, instant
from .space import Space, View, best_view, bounds
from .style import WIDTH, styled
from .symbols import Drawing


@checked
@styled
def stress(recording: Recording, scale: float = 1.0, view: Angles = None, color: Color = VON_MISES):
    """The deformed shell in the last frame, coloured by a stress, of a recording with stresses.

    Args:
        recording: ``Recording``.
        scale: factor of the displacements.
        view: (elevation, azimuth) [degrees]; default: where most is seen.
        color: the largest von Mises stress over the thickness, or a component, see ``coloured``.

    Returns:
        (Figure, DataFrame): columns element, corner, x, y, z, and top, middle, bottom [Pa] of the
        von Mises stress, else that of ``color``.

    Raises:
        InputError: no stresses were recorded.
    """
    corners = recording.positions(scale)[-1:][:, recording.quads]
    colours = coloured(recording, color).at([-1])
    view = best_view(corners[0]) if view is None else View(*view)
    places = recording.symbol_places([-1], scale)
    box, colour_scale = bounds(corners, places), colours.scale
    figure = Figure(figsize=(WIDTH, 0.9 + 0.75 * WIDTH * view.aspect(box)), layout="constrained")
    space = Space(figure.add_subplot(), view, box)
    space.elements(corners, array=colours.values, norm=colour_scale.norm, cmap=colour_scale.cmap,
                   line=0.12)
    Drawing(space, recording.symbols, places[0], size=0.8)
    space.axes.set_title(instant(recording, recording.times[-1]))
    colours.bar(figure, colour_scale, space.axes, shrink=0.7, aspect=25)
    x, y, z = corners.reshape(-1, 3).T
    columns = (dict(zip(LEVELS, recording.contents["von_mises"][-1].T)) if color == VON_MISES
               else {color: colours.values[0]})
    return figure, pd.DataFrame({
        "element": np.repeat(np.arange(recording.elements), 4),
        "corner": np.tile(np.arange(4), recording.elements), "x": x, "y": y, "z": z,
        **{name: np.repeat(values, 4) for name, values in columns.items()}})
