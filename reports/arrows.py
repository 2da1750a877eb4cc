"""What acts on a shell, as arrows: which there are, how long they are, what each kind looks like.

An arrow along an axis, as of a moment or a spin, has two heads: it turns as a screw that goes
forward.
"""

from typing import NamedTuple

import numpy as np
from matplotlib.offsetbox import AuxTransformBox
from matplotlib.patches import FancyArrowPatch
from scipy.spatial import cKDTree

from corovec.solver.input.places import elements_of
from corovec.solver.model.constants import local_frames
from corovec.solver.model.histories import CONSTANT, FunctionOfTime
from corovec.solver.model.loads import Centrifugal, Drive, Gravity, NodalLoad, NodalMoment
from corovec.solver.model.nonconservative import Drag, FollowerForce, UserForce

from .space import ARROW, HEADS
from .style import BLACK, BLUE, GREEN, ORANGE, PURPLE, VERMILLION

LONGEST = 0.22
"""Longest arrow of each unit relative to the size of the mesh."""

PARTS = 24
"""Parts of an arrow that are hidden behind the shell or not."""

OUTWARD = 0.2
"""Weight of the distance from the middle of the mesh beside that from its nodes."""

ALONG, OVER = 9, 12
"""Most arrows of a load along a line, and of one on a surface or on any nodes."""

SIZES = {"N": "force", "N/m": "force", "N/m^2": "force", "N m": "moment", "N m/m": "moment",
         "Pa": "pressure", "m/s^2": "gravity", "m/s": "velocity", "rad/s": "spin",
         "m": "displacement", "rad": "rotation"}
"""The kind of what is in a unit."""


class Look(NamedTuple):
    """How arrows of a kind look: colour, heads, the longest of them relative to ``LONGEST``, and
    whether they begin at their point whatever is around it."""

    colour: str
    heads: int = 1
    reach: float = 1.0
    begins: bool = False


LOOKS = {"force": Look(VERMILLION), "moment": Look(PURPLE, 2), "pressure": Look(ORANGE, 1, 0.6),
         "gravity": Look(BLACK, 1, 1.0, True), "velocity": Look(BLUE, 1, 1.35, True),
         "spin": Look(BLUE, 2, 1.7, True), "displacement": Look(GREEN),
         "rotation": Look(GREEN, 2, 1.0, True)}
"""Those that begin at the mass centre differ in length, so that none hides another's head."""


class Drawn(NamedTuple):
    """Something that acts, as arrows.

    Attributes:
        name: that is written beside it, perhaps none.
        at: (n, 3) where [m].
        vectors: (n, 3) at their largest.
        unit: of these; N/m for a line load of a model file.
        function: name of the function of time.
        history: ``FunctionOfTime``.
        label: of the axis of that function.
        line: whether its points follow one another along a line.
        normals: (n, 3) of the surface that it acts on; None for one at nodes.
    """

    name: str
    at: np.ndarray
    vectors: np.ndarray
    unit: str
    function: str = ""
    history: FunctionOfTime = CONSTANT
    label: str = ""
    line: bool = False
    normals: np.ndarray = None

    @property
    def kind(self):
        """One of ``LOOKS``."""
        return SIZES[self.unit]

    @property
    def look(self):
        """``Look`` of it."""
        return LOOKS[self.kind]

    def thinned(self, longest, taken):
        """The same with few arrows, spread over it, those on a surface away from what is ``taken``
        (n, 3); ``longest`` [m] is about their length, by which those that point along their line
        are apart."""
        few = spread(self.at, OVER, () if self.normals is None else taken)
        if self.line:
            way, first = self.at[-1] - self.at[0], self.vectors[0]
            along = abs(way @ first) > 0.9 * np.linalg.norm(way) * np.linalg.norm(first)
            most = 1 + int(np.linalg.norm(way) / longest) if along else ALONG
            few = np.unique(np.linspace(0, len(self.at) - 1, min(most, ALONG)).round().astype(int))
        return self._replace(at=self.at[few], vectors=self.vectors[few],
                             normals=None if self.normals is None else self.normals[few])


def of_model(model):
    """``Drawn`` s of a model, those of one kind with one function of time together; nothing of
    forces of the user and of a medium at rest."""
    found = {}
    for load in getattr(model, "loads", ()):
        if isinstance(load, UserForce) or isinstance(load, Drag) and not any(load.velocity):
            continue
        found.setdefault((type(load), load.history), []).append(load)
    histories = list(dict.fromkeys(history for _, history in found))
    names = [f"f{k}" for k in range(1, len(histories) + 1)] if len(histories) > 1 else ["f"]
    names = dict(zip(histories, names))
    drawn = []
    for (kind, history), loads in found.items():
        parts = [_acting(model, load) for load in loads]
        at, vectors, normals = (np.concatenate(part) for part in list(zip(*parts))[:3])
        largest = 1.0 if kind is Drag else peak(history)  # the function is that of its force
        drawn.append(Drawn("", at, vectors * largest, parts[0][3], names[history], history,
                           f"{names[history]}(t) [–]", normals=normals if len(normals) else None))
    return drawn


def _acting(model, load):
    """Where a load of a model acts, its vectors there, the normals of a surface, and the unit."""
    if isinstance(load, Gravity):
        return [model.centre], [load.acceleration], [], "m/s^2"
    if isinstance(load, NodalLoad):
        return [model.nodes[load.node]], [load.force], [], "N"
    if isinstance(load, NodalMoment):
        return [model.nodes[load.node]], [load.moment], [], "N m"
    if isinstance(load, FollowerForce):
        return [model.nodes[load.node]], [_following(model, load)], [], "N"
    if isinstance(load, Centrifugal):
        return [load.about], [load.omega], [], "rad/s"
    quads = model.quads if load.elements is None else model.quads[list(load.elements)]
    at, normals = middle(model.nodes[quads])
    if isinstance(load, Drag):
        return at, np.tile(load.velocity, (len(at), 1)), [], "m/s"
    return at, load.pressure * normals, normals, "Pa"


def _following(model, load):
    """(3,) a ``FollowerForce`` at the start."""
    first = model.directors.first
    return load.vector(model.normals[first[load.node]:first[load.node + 1]])


def middle(corners):
    """(n, 3) centres of elements (n, 4, 3) and their normals there."""
    return corners.mean(axis=1), local_frames(corners)[:, 2]


def of_case(model, case):
    """``Drawn`` s of the loads of a model file, by their names, as they are given there."""
    drawn, mesh = [], case.mesh(len(model.quads))
    end = case.dynamic.end_time if case.dynamic else 1.0
    for load in case.loads:
        if load.kind == "drag" and not (load.velocity and any(load.velocity.value)):
            continue
        definition = case.histories.get(load.history)
        history = definition.function() if definition else CONSTANT
        label = definition and (definition.peak.unit if definition.peak else definition.unit)
        at, vectors, normals = _given(model, mesh, load)
        if load.kind == "drag":  # the function is that of its force
            unit, largest = "m/s", 1.0
        else:
            unit, largest = load.unit, peak(history, end)
        drawn.append(Drawn(load.name, at, vectors * largest, unit, load.history,
                           history, f"{load.history}(t) [{label or '–'}]",
                           bool(load.line or load.curve), normals))
    return drawn


def _given(model, mesh, load):
    """Where a ``Load`` of a model file acts, its vectors there, and the normals of a surface."""
    value, normals = load.value.value, None
    if load.kind == "gravity":
        at = model.centre[None]
    elif load.kind == "centrifugal":
        at = np.array([load.about.value if load.about else (0.0, 0.0, 0.0)])
    elif load.kind == "drag":
        value = load.velocity.value
        at, _ = middle(mesh.nodes[mesh.quads[elements_of(mesh, load.surface or "all")]])
    elif load.kind == "pressure" or load.surface:
        at, normals = middle(mesh.nodes[mesh.quads[elements_of(mesh, load.surface or "all")]])
        if load.kind == "pressure":
            return at, value * normals, normals
    else:
        made = load.made(mesh)
        at = mesh.nodes[[one.node for one in made]]
        if load.kind == "follower":
            return at, np.array([_following(model, one) for one in made]), None
    return at, np.tile(value, (len(at), 1)), normals


def of_motion(model, case):
    """``Drawn`` s of the rigid motion with which a model file begins."""
    for name in ("velocity", "spin"):
        given = case.motion and getattr(case.motion, name)
        if given and any(given.value):
            at = case.motion.about.value if case.motion.about else model.centre
            yield Drawn(name, np.array([at]), np.array([given.value]), given.unit)


def of_supports(model, case):
    """``Drawn`` s of what the supports of a model file prescribe."""
    end = case.dynamic.end_time if case.dynamic else 1.0
    for given, support in zip((*case.supports, *case.drives), model.supports):
        at = model.nodes[list(support.nodes)]
        if isinstance(support, Drive):
            motions = (("translation", at, support.translation, given.history, support.history),
                       ("rotation", np.array([support.about]), support.rotation,
                        given.turning or given.history, support.turning))
        else:
            along = [component in support.components for component in "xyz"] @ support.directions
            motions = (("", at, support.displacement * along, given.history, support.history),)
        for name, points, vector, function, history in motions:
            if np.any(vector):
                vectors = np.tile(peak(history, end) * np.array(vector), (len(points), 1))
                yield Drawn(name, points, vectors, "rad" if name == "rotation" else "m", function,
                            history, f"{function}(t) [–]")


def peak(history, end=1.0):
    """The value of largest size of a time function until ``end`` [s], if it has no end of its own.
    """
    values = history.curve(end)[1]
    return float(max(values[np.isfinite(values)], key=abs, default=0.0))


def thinned(drawn, longest):
    """The same ``Drawn`` s with few arrows each, those on surfaces away from one another."""
    few = []
    for one in drawn:
        few.append(one.thinned(longest, on_surfaces(few)))
    return few


def on_surfaces(drawn):
    """(n, 3) where arrows stand on a surface."""
    return np.concatenate([np.zeros((0, 3)), *(one.at for one in drawn if one.normals is not None)])


def spread(points, most, taken=()):
    """Ascending numbers of at most ``most`` of ``points`` (n, m), each the farthest from those
    before and from the points that are ``taken``; without these the first is beside the middle."""
    if len(points) <= most:
        return np.arange(len(points))
    far = np.full(len(points), np.inf)
    if len(taken):
        far = cKDTree(taken).query(points)[0]
    first = np.linalg.norm(points - np.mean(points, axis=0), axis=1).round(12)
    chosen = [int(np.argmax(far) if len(taken) else np.argmin(first))]
    while len(chosen) < most:
        far = np.minimum(far, np.linalg.norm(points - points[chosen[-1]], axis=1))
        chosen.append(int(np.argmax(far)))
    return np.unique(chosen)


def scales(model, drawn):
    """``{unit: length of an arrow [m] per size}``, the longest of each unit by its ``Look``."""
    largest = {}
    for one in drawn:
        size = np.linalg.norm(one.vectors, axis=1).max(initial=0.0)
        largest[one.unit] = max(size, largest.get(one.unit, 0.0))
    return {unit: LOOKS[SIZES[unit]].reach * LONGEST * model.size / size
            for unit, size in largest.items() if size > 0.0}


def ends(model, one, scales, eye):
    """(n, 2, 3) tails and tips of the arrows of a ``Drawn``: those on a surface stand on that side
    of it which the ``eye`` sees, others touch their points from that side where they are farther
    from the mesh and its middle."""
    arrows, at = scales.get(one.unit, 0.0) * one.vectors, one.at
    if one.look.begins:
        from_point = np.ones(len(at), dtype=bool)
    elif one.normals is not None:
        from_point = np.einsum("ij,ij->i", arrows, one.normals) * (one.normals @ eye) >= 0.0
    else:
        mesh = cKDTree(model.nodes)
        before, after = (np.mean(mesh.query(free)[0] + OUTWARD * np.linalg.norm(
            free - mesh.data.mean(axis=0), axis=1)) for free in (at - arrows, at + arrows))
        from_point = np.full(len(at), before <= after * (1.0 + 1e-9))
    tails = np.where(from_point[:, None], at, at - arrows)
    return np.stack([tails, tails + arrows], axis=1)


def middles(arrows):
    """(n, PARTS, 3) middles of the equal parts of arrows (n, 2, 3)."""
    part = (np.arange(PARTS)[:, None] + 0.5) / PARTS
    return arrows[:, :1] + part * (arrows[:, 1:] - arrows[:, :1])


def names(space, drawn, arrows):
    """What ``Space.names`` takes of ``Drawn`` s: a name lies beyond that end of the middle arrow
    which is not at its point."""
    for one, each in zip(drawn, arrows):
        if one.name and len(each):
            arrow, at = each[len(each) // 2], one.at[len(each) // 2]
            free = arrow[np.argmax(np.linalg.norm(arrow - at, axis=1))]
            yield free, one.name, space.view(free - at), {"color": one.look.colour}


def sample(space, unit, length):
    """An arrow ``length`` [m] long on the screen of ``space``, as those of a unit."""
    look, box = LOOKS[SIZES[unit]], AuxTransformBox(space.axes.transData)
    for shrink in HEADS[:look.heads]:
        box.add_artist(FancyArrowPatch((0.0, 0.0), (length, 0.0), color=look.colour,
                                       **{**ARROW, "shrinkB": shrink}))
    return box


def rounded(size):
    """The largest of 1, 2, 5, 10, ... that is not above ``size``."""
    power = 10.0 ** np.floor(np.log10(size))
    return max(step for step in (1.0, 2.0, 5.0) if step * power <= size * (1.0 + 1e-9)) * power
