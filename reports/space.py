"""Drawing in space: axes of one scale, elements as polygons, arrows, and where to look from."""

from itertools import product

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.patches import FancyArrowPatch
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d import proj3d
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from .style import COLOURS

ELEVATIONS, AZIMUTHS = (20.0, 30.0, 40.0), (-60.0, -40.0, -75.0, -120.0)

THINNEST = 0.15
"""Shortest side of the box relative to its longest: a flat mesh needs room for its ticks."""

MOST_VECTORS = 4000
"""Polygons beyond which they become an image inside a vector figure."""


class Arrow(FancyArrowPatch):
    """An arrow between two points in space, with a filled head."""

    def __init__(self, tail, tip, color):
        super().__init__((0.0, 0.0), (0.0, 0.0), arrowstyle="-|>", mutation_scale=8.0,
                         shrinkA=0.0, shrinkB=0.0, linewidth=1.0, color=color, zorder=5)
        self._ends = np.transpose([tail, tip])

    def do_3d_projection(self, renderer=None):
        x, y, z = proj3d.proj_transform(*self._ends, self.axes.M)
        self.set_positions((x[0], y[0]), (x[1], y[1]))
        return min(z)


def best_view(corners):
    """(elevation, azimuth) [degrees] from which most area of the elements (n, 4, 3) is seen."""
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    views = list(product(ELEVATIONS, AZIMUTHS))
    return max(views, key=lambda view: np.abs(normal @ direction(view)).sum())


def direction(view):
    """Unit vector from the scene to the eye."""
    elevation, azimuth = np.radians(view)
    return np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth),
                     np.sin(elevation)])


def bounds(points, *more):
    """(2, 3) least and largest coordinates."""
    points = np.concatenate([np.reshape(part, (-1, 3)) for part in (points, *more)])
    return np.array([points.min(axis=0), points.max(axis=0)])


def space(figure, place, box, view):
    """Axes in ``place`` (of a grid) that hold ``box`` (2, 3), with one scale in all directions."""
    axes = figure.add_subplot(place, projection="3d", computed_zorder=False)
    middle, half = box.mean(axis=0), 0.5 * np.ptp(box, axis=0)
    half = np.maximum(1.03 * half, THINNEST * half.max())
    for name, m, h in zip("xyz", middle, half):
        getattr(axes, f"set_{name}lim")(m - h, m + h)
        axis = getattr(axes, f"{name}axis")
        axis.set_major_locator(MaxNLocator(nbins=1 + int(np.ceil(5.0 * h / half.max())),
                                           steps=(1, 2, 5, 10)))
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
        axis.set_tick_params(pad=0.0)
        axis.labelpad = 0.0
        axis.line.set_linewidth(0.6)
    axes.set(xlabel="X [m]", ylabel="Y [m]", zlabel="Z [m]", proj_type="ortho")
    axes.set_box_aspect(half, zoom=1.2)
    axes.view_init(*view)
    return axes


def elements(axes, corners, edge="0.25", line=0.3, **style):
    """Elements (n, 4, 3) as polygons; ``facecolor``, or values with a norm in ``style``."""
    polygons = Poly3DCollection(corners, edgecolor=edge, linewidth=line, zorder=2,
                                rasterized=len(corners) > MOST_VECTORS, **style)
    axes.add_collection3d(polygons, autolim=False)
    return polygons


def density_scale(density):
    """Colours of strain energy densities [J/m^2], from zero to the largest but for peaks.

    The top is where 99.5 % of the values lie below; whatever is beyond has its colour.
    """
    top = float(np.quantile(density, 0.995)) or float(density.max()) or 1.0
    return ScalarMappable(Normalize(0.0, top), COLOURS)


def density_bar(figure, scale, density, axes, **place):
    """The colour bar of :func:`density_scale`."""
    beyond = "max" if density.max() > scale.norm.vmax else "neither"
    bar = figure.colorbar(scale, ax=axes, extend=beyond, label="strain energy density [J/m²]",
                          **place)
    bar.outline.set_linewidth(0.5)
    return bar
