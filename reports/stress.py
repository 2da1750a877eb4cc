"""The stress at the end of a recording."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from corovec.solver.results.stresses import LEVELS
from corovec.solver.signatures import checked

from .recording import Recording
from .scenes import Angles, instant
from .space import Space, View, best_view, bounds, density_bar, density_scale
from .style import WIDTH, styled


@checked
@styled
def von_mises(recording: Recording, scale: float = 1.0, view: Angles = None):
    """The deformed shell in the last frame, coloured by the largest von Mises stress over its
    thickness, of a recording with stresses.

    Args:
        recording: ``Recording``.
        scale: factor of the displacements.
        view: (elevation, azimuth) [degrees]; default: where most is seen.

    Returns:
        (Figure, DataFrame): columns element, corner, x, y, z, top, middle, bottom [Pa].
    """
    corners = recording.positions(scale)[-1:][:, recording.quads]
    stress = recording.contents["von_mises"][-1]
    largest = stress.max(axis=1)[None]
    view = best_view(corners[0]) if view is None else View(*view)
    box, colours = bounds(corners), density_scale(largest)
    figure = Figure(figsize=(WIDTH, 0.9 + 0.75 * WIDTH * view.aspect(box)), layout="constrained")
    space = Space(figure.add_subplot(), view, box)
    space.elements(corners, array=largest, norm=colours.norm, cmap=colours.cmap, line=0.12)
    space.axes.set_title(instant(recording, recording.times[-1]))
    density_bar(figure, colours, largest, space.axes, label="von Mises stress [Pa]", shrink=0.7,
                aspect=25)
    x, y, z = corners.reshape(-1, 3).T
    return figure, pd.DataFrame({
        "element": np.repeat(np.arange(len(stress)), 4),
        "corner": np.tile(np.arange(4), len(stress)), "x": x, "y": y, "z": z,
        **{level: np.repeat(values, 4) for level, values in zip(LEVELS, stress.T)}})
