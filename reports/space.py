"""Drawing in space: a parallel projection on plain axes, so that all directions have one scale.

Elements are painted from the farthest to the nearest.
"""

from itertools import pairwise, product
from typing import Annotated

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from corovec.solver.checks import number, numbers, shown
from corovec.solver.errors import InputError
from corovec.solver.model.mesh import vector_areas
from corovec.solver.names import mathtext

from .style import VERMILLION

ELEVATIONS, AZIMUTHS = (20.0, 30.0, 40.0), (-60.0, -40.0, -75.0, -120.0)

ARROW = {"arrowstyle": "-|>", "linewidth": 1.0, "shrinkA": 0.0, "shrinkB": 0.0,
         "mutation_scale": 8.0}
"""Looks of the arrows of loads."""

HEADS = (0.0, 5.0)
"""How far the heads of an arrow are from its tip [points of print]."""

THINNEST = 0.08
"""Shortest side of the box relative to its longest: a flat mesh needs room for its ticks."""

MOST_VECTORS = 20_000
"""Elements beyond which they become an image inside a vector figure."""

WAYS = 16
"""Directions in which a name may lie from its point."""

GAPS = (4.0, 9.0, 15.0, 22.0)
"""Distances of a name from its point that are tried [points of print]."""

CLEAR = 2.0
"""White around a name [points of print]."""

COILS = 5
"""Of a spring."""

DEPTH = 1e-3
"""What lies less than this part of the scene's size behind an element is not hidden by it."""


class View:
    """A parallel projection, seen from an elevation and an azimuth [degrees].

    Attributes:
        eye: (3,) unit vector from the scene to the eye.
        screen: (2, 3) unit vectors to the right and upwards.
    """

    def __init__(self, elevation, azimuth):
        e, a = np.radians([number("view", angle, "degrees") for angle in (elevation, azimuth)])
        self.eye = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        right = np.array([-np.sin(a), np.cos(a), 0.0])
        self.screen = np.array([right, np.cross(self.eye, right)])

    def __call__(self, points):
        """(..., 2) places on the screen of points (..., 3) [m]."""
        return np.asarray(points) @ self.screen.T

    def aspect(self, box):
        """Height over width of a box on the screen."""
        width, height = np.abs(self.screen) @ np.ptp(box, axis=0)
        return height / width


def _angles(name, view):
    """An elevation and an azimuth [degrees]."""
    items = numbers(name, view)
    if len(items) != 2:
        raise InputError(f"{name} must be (elevation, azimuth), is {shown(view)}")
    return items


Angles = Annotated[tuple, _angles]


def best_view(corners):
    """The ``View`` in which elements (n, 4, 3) fill most of a picture, rather wide than high.
    """
    areas = vector_areas(corners)
    size = np.ptp(bounds(corners), axis=0)

    def filled(view):
        width, height = np.abs(view.screen) @ size
        return np.abs(areas @ view.eye).sum() / (width * height) * min(1.0, width / height)

    return max((View(*angles) for angles in product(ELEVATIONS, AZIMUTHS)), key=filled)


def bounds(*points):
    """(2, 3) corners of the box around points (..., 3), never quite flat."""
    points = np.concatenate([np.reshape(part, (-1, 3)) for part in points])
    low, high = points.min(axis=0), points.max(axis=0)
    half = np.maximum(0.51 * (high - low), 0.5 * THINNEST * (high - low).max())
    return 0.5 * (low + high) + np.array([-half, half])


def hidden(view, points, corners):
    """(n,) whether elements (n_elem, 4, 3) lie between points (n, 3) and the eye."""
    triangles = np.reshape(corners, (-1, 4, 3))[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)
    seen, depth = view(triangles), triangles @ view.eye
    sides = (seen[:, 1:] - seen[:, :1]).transpose(0, 2, 1)
    facing = np.abs(np.linalg.det(sides)) > 1e-12 * np.ptp(seen, axis=(0, 1)).max() ** 2
    seen, depth, inverse = seen[facing], depth[facing], np.linalg.inv(sides[facing])
    margin = DEPTH * np.ptp(triangles, axis=(0, 1)).max()

    (left, low), (right, high) = seen.min(axis=1).T, seen.max(axis=1).T

    def covered(point):
        x, y = view(point)
        near = np.flatnonzero((left <= x) & (x <= right) & (low <= y) & (y <= high))
        part = np.einsum("tij,tj->ti", inverse[near], (x, y) - seen[near, 0])
        within = (part > 0.0).all(axis=1) & (part.sum(axis=1) < 1.0)
        over = depth[near, 0] + np.sum(part * (depth[near, 1:] - depth[near, :1]), axis=1)
        return bool(np.any(over[within] > point @ view.eye + margin))

    return np.array([covered(point) for point in np.reshape(points, (-1, 3))], dtype=bool)


def zigzag(start, end, height):
    """(n, 2) corners of a spring between two places on the screen, ``height`` to either side."""
    start, end = np.asarray(start), np.asarray(end)
    along = end - start
    across = np.array([-along[1], along[0]]) * height / (np.linalg.norm(along) or 1.0)
    part = np.array([0.0, 0.15, *np.linspace(0.15, 0.85, 2 * COILS + 2)[1:-1], 0.85, 1.0])
    side = np.array([0.0, 0.0, *(1.0, -1.0) * COILS, 0.0, 0.0])
    return start + part[:, None] * along + side[:, None] * across


class Space:
    """Matplotlib ``axes`` that show what lies in ``box`` (2, 3) [m] by a ``View``.

    With ``ruled`` the box has a grid on its far faces, and numbers along three of its edges.
    """

    def __init__(self, axes, view, box, ruled=True):
        self.axes, self.view, self.box = axes, view, box
        edges = view(list(product(*box.T)))
        axes.set(xlim=(edges[:, 0].min(), edges[:, 0].max()),
                 ylim=(edges[:, 1].min(), edges[:, 1].max()), aspect="equal")
        axes.axis("off")
        if ruled:
            self._rule()

    def elements(self, frames, edge="0.3", line=0.3, **style):
        """Elements (n_frames, n_elem, 4, 3), later frames over earlier ones.

        ``style``: of a ``PolyCollection``; ``array`` (n_frames, n_elem) and ``norm`` colour them.
        """
        polygons = PolyCollection([], edgecolor=edge, linewidth=line, joinstyle="round",
                                  clip_on=False, zorder=2, **style)
        polygons.set_rasterized(frames.shape[0] * frames.shape[1] > MOST_VECTORS)
        self.axes.add_collection(polygons, autolim=False)
        self.move(polygons, frames, style.get("array"))
        return polygons

    def move(self, polygons, frames, values=None):
        """Give ``polygons`` other places and values."""
        order = np.argsort(frames.mean(axis=2) @ self.view.eye, axis=1)
        frames = np.take_along_axis(frames, order[:, :, None, None], axis=1)
        polygons.set_verts(self.view(frames).reshape(-1, 4, 2))
        if values is not None:
            polygons.set_array(np.take_along_axis(values, order, axis=1).ravel())

    def arrow(self, tail, tip, covered=(False,), color=VERMILLION, heads=1, **style):
        """An arrow between two points (3,) [m]; those of its equal parts that are ``covered`` are
        dashed, and its heads are hollow if the last one is.  ``style``: other than ``ARROW``."""
        covered = np.asarray(covered)
        ends = self.view((tail, tip))
        head = "white" if covered[-1] else color
        for shrink in HEADS[:heads]:
            self.axes.annotate("", ends[1], ends[0], annotation_clip=False, zorder=5, arrowprops={
                **ARROW, "edgecolor": color, "facecolor": head, "shrinkB": shrink, **style,
                **({"linestyle": (0, (1.5, 1.2)), "linewidth": 0.7} if covered.any() else {})})
        if covered.any():
            along = np.linspace(0.0, 1.0, len(covered) + 1)[:, None] * (ends[1] - ends[0]) + ends[0]
            self.axes.add_collection(LineCollection(
                np.stack([along[:-1], along[1:]], axis=1)[~covered], colors=color,
                linewidths=ARROW["linewidth"], clip_on=False, zorder=5), autolim=False)

    def text(self, point, text, offset=(0.0, 0.0), **style):
        """``text`` at a point, moved by ``offset`` [points of print]."""
        style = {"ha": "center", "va": "center", "zorder": 6, **style}
        return self.axes.annotate(
            mathtext(text), self.view(point), offset, textcoords="offset points",
            annotation_clip=False,
            path_effects=[withStroke(linewidth=1.8, foreground="white")], **style)

    def names(self, named, around):
        """Write names beside their points where they cover least of other texts and lines.

        Args:
            named: (point (3,) [m], text, way (2,) on the screen that is tried first, style of
                ``text``) each.
            around: ``[(points (..., 3) [m], weight)]`` that had better not be covered.
        """
        self.axes.figure.draw_without_rendering()
        place = self.axes.transData.transform
        part = np.linspace(0.0, 1.0, 60)[:, None]
        lines = [start + part * (end - start) for line in self.axes.lines
                 for start, end in pairwise(line.get_xydata())]
        seen = [*((self.view(points).reshape(-1, 2), weight) for points, weight in around),
                *((points, 1.0) for points in lines)]
        crowd = place(np.concatenate([points for points, _ in seen]))
        weights = np.concatenate([np.full(len(points), weight) for points, weight in seen])
        taken = [text.get_window_extent().get_points() for text in self.axes.texts
                 if text.get_text()]
        for point, name, way, style in named:
            text = self.text(point, name, **style)
            at, size = place(self.view(point)), text.get_window_extent().size
            turned = np.arctan2(way[1], way[0]) + 2.0 * np.pi / WAYS * np.arange(WAYS)
            ways = np.column_stack([np.cos(turned), np.sin(turned)])
            offsets = np.concatenate([ways * (0.5 * size + gap) for gap in GAPS])
            dislike = np.add.outer(GAPS, 2.0 * (1.0 - ways @ ways[0])).ravel()
            low = at + offsets - 0.5 * size - CLEAR
            high = at + offsets + 0.5 * size + CLEAR
            within = (np.all(crowd > low[:, None], axis=2) & np.all(crowd < high[:, None], axis=2))
            others = np.array(taken).reshape(-1, 2, 2)
            common = np.minimum(high[:, None], others[:, 1]) - np.maximum(low[:, None],
                                                                          others[:, 0])
            cost = dislike + within @ weights + 10.0 * np.prod(
                np.maximum(common, 0.0), axis=2).sum(axis=1)
            best = np.argmin(cost.round(6))
            text.xyann = tuple(offsets[best])
            taken.append(np.array([low[best], high[best]]))

    def dot(self, point, color, covered=False, size=4.0, marker="o"):
        """Mark a point (3,) [m], hollow if it is ``covered``."""
        self.axes.plot(*self.view(point), marker=marker, color=color, markersize=size, zorder=6,
                       linestyle="", clip_on=False, markerfacecolor="white" if covered else color)

    def zigzag(self, tail, tip, covered, color):
        """A spring between two points (3,) [m], dotted if it is ``covered``."""
        height = 0.012 * np.ptp(self.axes.get_xlim())
        self.axes.plot(*zigzag(*self.view((tail, tip)), height).T, color=color, linewidth=0.9,
                       linestyle=(0, (1, 1)) if covered else "-", zorder=4, clip_on=False)

    def scale_bar(self):
        """A line of a round length below the picture on the left, with its length."""
        (left, right), bottom = self.axes.get_xlim(), self.axes.get_ylim()[0]
        length = MaxNLocator(5, steps=(1, 2, 5, 10)).tick_values(0.0, right - left)[1]
        self.axes.plot((left, left + length), (bottom, bottom), color="0.2", linewidth=1.2,
                       solid_capstyle="butt", clip_on=False)
        self.axes.annotate(f"{length:g} m", (left + 0.5 * length, bottom), (0.0, -3.0), size=7.0,
                           textcoords="offset points", ha="center", va="top")

    def _rule(self):
        """The grid on the far faces, and the numbers on the edges where they do not hide it."""
        far = (self.view.eye > 0.0).astype(int) * -1 + 1
        ticks = [self._ticks(along) for along in range(3)]
        lines = []
        for face, along in ((f, a) for f in range(3) for a in range(3) if a != f):
            across = 3 - face - along
            for tick in (*ticks[across], *self.box[:, across]):
                ends = np.empty((2, 3))
                ends[:, face] = self.box[far[face], face]
                ends[:, across] = tick
                ends[:, along] = self.box[:, along]
                lines.append(self.view(ends))
        self.axes.add_collection(LineCollection(lines, colors="0.88", linewidths=0.4, zorder=1,
                                                clip_on=False), autolim=False)
        centre = self.view(self.box.mean(axis=0))
        for along in range(3):
            ends = self._edge(along, far)
            start, end = self.view(ends)
            normal = np.array([start[1] - end[1], end[0] - start[0]])
            length = np.linalg.norm(normal)
            if length < 0.02 * np.ptp(self.axes.get_xlim()):
                continue
            normal *= np.sign(normal @ (0.5 * (start + end) - centre)) / length
            self.axes.plot(*np.transpose([start, end]), color="0.2", linewidth=0.6, zorder=1,
                           clip_on=False)
            places = np.repeat(ends[:1], len(ticks[along]), axis=0)
            places[:, along] = ticks[along]
            for place, tick in zip(places, ticks[along]):
                label = f"{tick + 0.0:g}".replace("-", "−")
                self.text(place, label, 9.0 * normal * (1.4, 1.0), size=7.0)
            self.text(ends.mean(axis=0), f"{'XYZ'[along]} [m]", 22.0 * normal * (1.5, 1.0))

    def _ticks(self, along):
        """Round numbers along an edge, as many as there is room for."""
        low, high = self.box[:, along]
        seen = np.linalg.norm(self.view.screen[:, along]) * (high - low)
        bins = max(1, round(7.0 * seen / np.ptp(self.axes.get_xlim())))
        values = MaxNLocator(bins, steps=(1, 2, 5, 10), min_n_ticks=1).tick_values(low, high)
        return values[(values >= low) & (values <= high)]

    def _edge(self, along, far):
        """Ends (2, 3) of the edge for numbers: on the outline, below or to the left."""
        edges = []
        for flipped in range(3):
            if flipped != along:
                sides = np.where(np.arange(3) == flipped, 1 - far, far)
                ends = self.box[sides, np.arange(3)] * np.ones((2, 1))
                ends[:, along] = self.box[:, along]
                edges.append(ends)
        lowest = 0 if along == 2 else 1
        return min(edges, key=lambda ends: self.view(ends).mean(axis=0)[lowest])
