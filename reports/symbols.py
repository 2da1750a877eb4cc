"""Symbols of joints and rigid bodies: lines and marks between points that move with nodes.

| what | symbol |
|---|---|
| hinge | the edge, a cross where its axis ends: the angle is right-handed about it |
| spherical joint, ball joint | a dot |
| revolute joint | a ring and its axis |
| universal joint | a ring and the two axes of its cross |
| cylindrical, prismatic joint | a dot, a square, and a long axis |
| rigid link | a rod with a dot at either end |
| tie | a wide line along its nodes |
| body | the cuboid of its mass and inertia, a rhomb at its centre, arms to nodes and joints |
| ground | a foot below the joint |
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.path import Path

from corovec.solver.model.mechanism import moved, plural

from .style import BLACK, BLUE, GREEN, VERMILLION

SHORT, LONG = 0.045, 0.12
"""Half the length of the axis of a joint that turns, and of one that slides, in sizes of what is
drawn."""

MOST_NAMES, FEW_NAMES = 12, 6
"""Joints and bodies that have their names beside them, at most, in a picture and in a film."""

FLAT = 0.004
"""Sides of the cuboid of a body, in sizes of what is drawn, below which its rhomb is enough."""

FOOT = Path([(0, 0), (0, -1.1), (-0.9, -1.1), (0.9, -1.1), (-0.7, -1.1), (-1.1, -1.7), (0, -1.1),
             (-0.4, -1.7), (0.7, -1.1), (0.3, -1.7)], [1, 2] * 5)
"""Marker of the ground: a stem on a hatched line."""


class Look(NamedTuple):
    """How a line or a mark looks.

    Attributes:
        colour: of it.
        width: of a line, size of a mark [points].
        marker: of matplotlib; none of a line.
        hollow: whether the mark is white inside.
        dashes: of a line.
    """

    colour: str
    width: float
    marker: object = ""
    hollow: bool = False
    dashes: object = "-"


LOOKS = {
    "hinge": Look(VERMILLION, 1.6), "axis": Look(VERMILLION, 1.0),
    "rod": Look(BLUE, 1.4), "tie": Look(GREEN, 2.4),
    "cuboid": Look(BLACK, 0.7), "arm": Look("0.4", 0.6, dashes=(0, (3, 1.5))),
    "dot": Look(VERMILLION, 4.0, "o"), "ring": Look(VERMILLION, 4.5, "o", True),
    "cross": Look(VERMILLION, 5.0, "P"), "square": Look(VERMILLION, 4.0, "s"),
    "end": Look(BLUE, 3.0, "o"), "rhomb": Look(BLACK, 4.5, "D"),
    "foot": Look("0.25", 15.0, FOOT, True)}

MARKS = {"hinge": "cross", "spherical joint": "dot", "ball joint": "dot", "revolute joint": "ring",
         "universal joint": "ring", "cylindrical joint": "dot", "prismatic joint": "square",
         "rigid link": "end"}
"""Marks of joints by their kind."""

SLIDING = ("cylindrical joint", "prismatic joint")

KEYS = {"hinge": ("hinge", "cross"), "spherical joint": ("", "dot"), "ball joint": ("", "dot"),
        "revolute joint": ("axis", "ring"), "universal joint": ("axis", "ring"),
        "cylindrical joint": ("axis", "dot"), "prismatic joint": ("axis", "square"),
        "rigid link": ("rod", "end"), "tie": ("tie", ""), "body": ("cuboid", "rhomb"),
        "ground": ("", "foot")}
"""Line and mark of each kind in a key."""


class Symbol(NamedTuple):
    """A line between two points, or a mark at one.

    Attributes:
        item: a kind of joint, ``body``, its ``cuboid`` or an ``arm`` of it, or ``ground``.
        name: of the joint or body.
        points: numbers of its points, two or one.
        look: one of ``LOOKS``.
    """

    item: str
    name: str
    points: tuple
    look: str


class Symbols:
    """Symbols of a mechanism.

    Attributes:
        lines, marks: ``Symbol`` s.
        size: largest extent of the nodes [m].
        names: ``{number of a point: text}``, few or none.
        totals: ``{kind: what a key says}``.
    """

    def __init__(self, mechanism, nodes):
        """``mechanism``: see ``model.mechanism``; ``nodes``: (n_nodes, 3) in the initial
        configuration [m]."""
        self._nodes, self.size = nodes, np.ptp(nodes, axis=0).max()
        self._points, self.lines, self.marks, self.names = [], [], [], {}
        bodies = {body["at"]: body for body in mechanism["bodies"]}
        for body in bodies.values():
            self._body(body)
        for joint in mechanism["joints"]:
            self._joint(joint, bodies)
        few = len(bodies) + len(mechanism["joints"]) <= MOST_NAMES
        self.names = self.names if few else {}
        kinds = [joint["kind"] for joint in mechanism["joints"]]
        self.totals = {kind: plural(kinds.count(kind), kind) for kind in KEYS if kind in kinds}
        if bodies:
            mass = sum(body["mass"] for body in bodies.values())
            self.totals["body"] = f"{plural(len(bodies), 'rigid body')}, {mass:.4g} kg"
        if any(mark.look == "foot" for mark in self.marks):
            self.totals["ground"] = "on the ground"

    def __bool__(self):
        return bool(self.lines or self.marks)

    @property
    def at_first(self):
        """(n_points, 3) places in the initial configuration [m]."""
        found = np.zeros((len(self._points), 3))
        for place, parts in zip(found, self._points):
            for part in parts:
                fixed = part["node"] is None or part.get("turned")
                place += np.add(part["vector"], 0.0 if fixed else self._nodes[part["node"]])
        return found

    def places(self, positions, directors):
        """(n_frames, n_points, 3) places of all points [m].

        Args:
            positions: (n_frames, n_nodes, 3) of nodes [m].
            directors: (n_frames, n_directors, 3).
        """
        found = np.zeros((len(positions), len(self._points), 3))
        for k, parts in enumerate(self._points):
            for carried in parts:
                found[:, k] += moved(carried, positions, directors)
        return found

    def _point(self, *parts):
        """The number of a point: a place, and directions from there."""
        self._points.append(parts)
        return len(self._points) - 1

    def _node(self, node):
        return self._point({"node": node, "vector": (0.0, 0.0, 0.0)})

    def _line(self, item, name, look, *points):
        self.lines += [Symbol(item, name, ends, look) for ends in pairwise(points)]

    def _mark(self, item, name, look, point):
        self.marks.append(Symbol(item, name, (point,), look))

    def _body(self, body):
        name, axes = body["name"], np.array(body["axes"])
        spread = [0.5 * (sum(body["inertia"]) - 2.0 * one) for one in body["inertia"]]
        half = np.sqrt(np.maximum(3.0 * np.array(spread) / body["mass"], 0.0))
        own = {"node": body["at"], "first": body["first"], "directors": axes}
        centre = self._node(body["at"])
        if half.max() > FLAT * self.size:
            corners = {}
            for signs in np.ndindex(2, 2, 2):
                arm = (2.0 * np.array(signs) - 1.0) * half @ axes
                corners[signs] = self._point({**own, "vector": arm})
            for a in corners:
                for b in corners:
                    if a < b and np.abs(np.subtract(a, b)).sum() == 1:
                        self._line("cuboid", name, "cuboid", corners[a], corners[b])
        for node in body["nodes"]:
            self._line("arm", name, "arm", centre, self._node(node))
        self._mark("body", name, "rhomb", centre)
        self.names[centre] = f"{name}, {body['mass']:.4g} kg"

    def _joint(self, joint, bodies):
        name, kind = joint["name"], joint["kind"]
        if "nodes" in joint:
            points = [self._node(node) for node in joint["nodes"]]
            if kind in MARKS:
                self._mark(kind, name, MARKS[kind], points[-1])
            if kind in LOOKS:
                self._line(kind, name, kind, *points)
            self.names[points[len(points) // 2]] = name
            return
        points = [self._point(point) for point in joint["points"]]
        if kind == "rigid link":
            self._line(kind, name, "rod", *points)
        for axis in joint["axes"]:
            half = (LONG if kind in SLIDING else SHORT) * self.size
            self._line(kind, name, "axis", *(self._point(joint["points"][0], {
                **axis, "vector": sign * half * np.array(axis["vector"]), "turned": True})
                for sign in (-1.0, 1.0)))
        for point, end in zip(points if len(points) > 1 else 2 * points, joint["ends"]):
            if end is None:
                self._mark("ground", name, "foot", point)
            if end in bodies:
                self._line("arm", bodies[end]["name"], "arm", self._node(end), point)
        for point in points:
            self._mark(kind, name, MARKS[kind], point)
        self.names[points[0]] = name


class Drawing:
    """Symbols on a ``Space``, which can be moved.

    Args:
        space: ``Space``.
        symbols: ``Symbols``.
        places: (n_points, 3) [m].
        hidden: function of points (n, 3), whether something lies before each, which is drawn dashed
            and hollow then; left out, nothing does.
        named: how many names stand beside at most.
        size: of marks and lines, relative to ``LOOKS``.
    """

    def __init__(self, space, symbols, places, hidden=None, named=0, size=1.0):
        self._space, self._lines, self._marks, axes = space, [], [], space.axes
        behind = hidden or (lambda points: np.zeros(len(points), dtype=bool))
        for name, covered, chosen in _alike(symbols.lines, places, behind):
            look = LOOKS[name]
            lines = LineCollection(
                [], label=f"_{name}",
                colors="0.5" if covered else look.colour, zorder=3.5, clip_on=False,
                linewidths=size * (0.7 if covered else look.width),
                linestyles=[(0, (2, 1.5)) if covered else look.dashes])
            axes.add_collection(lines, autolim=False)
            self._lines.append((lines, np.array([symbol.points for symbol in chosen])))
        for name, covered, chosen in _alike(symbols.marks, places, behind):
            look = LOOKS[name]
            marks, = axes.plot(
                [], [], label=f"_{name}",
                linestyle="", marker=look.marker, color=look.colour, zorder=5.5,
                markersize=size * look.width, clip_on=False, markeredgewidth=0.8,
                markerfacecolor=_inside(look, covered))
            self._marks.append((marks, np.array([symbol.points[0] for symbol in chosen])))
        self._names = [(k, space.text(places[k], text, (5.0, 4.0), size=6.5, color="0.15",
                                      ha="left", va="bottom"))
                       for k, text in symbols.names.items()] if len(symbols.names) <= named else []
        self.move(places)

    def move(self, places):
        """To other places (n_points, 3) [m]."""
        seen = self._space.view(places)
        for lines, points in self._lines:
            lines.set_segments(seen[points])
        for marks, points in self._marks:
            marks.set_data(*seen[points].T)
        for k, text in self._names:
            text.xy = tuple(seen[k])


def _inside(look, covered=False):
    """Colour inside of a mark."""
    if look.marker is FOOT:
        return "none"
    return "white" if look.hollow or covered else look.colour


def _alike(symbols, places, hidden):
    """``(look, whether hidden, those symbols)`` of all symbols that look alike."""
    if not symbols:
        return
    middles = np.array([places[list(symbol.points)].mean(axis=0) for symbol in symbols])
    found = {}
    for symbol, covered in zip(symbols, hidden(middles)):
        found.setdefault((symbol.look, bool(covered)), []).append(symbol)
    for (look, covered), chosen in found.items():
        yield look, covered, chosen


def key_of_symbols(axes, symbols):
    """A legend of what there is, above ``axes``."""
    if not symbols:
        return
    rows = []
    for kind in symbols.totals:
        line, mark = (LOOKS.get(name) for name in KEYS[kind])
        shown = mark or line
        rows.append(Line2D(
            [], [], linestyle=line.dashes if line else "", color=shown.colour,
            linewidth=line.width if line else 0.0, marker=mark.marker if mark else "",
            markersize=mark.width if mark else 0.0, markeredgewidth=0.8,
            markerfacecolor=_inside(shown)))
    axes.legend(rows, symbols.totals.values(), loc="lower center", bbox_to_anchor=(0.5, 1.0),
                ncols=3, handlelength=1.8, columnspacing=1.0, fontsize=6.5)


def symbols_of(model):
    """``Symbols`` of a ``Model`` or a ``Recording``; none of what has no mechanism."""
    return Symbols(getattr(model, "mechanism", {"joints": [], "bodies": []}), model.nodes)
