"""Joints between bodies, nodes and the ground that take multipliers: constraints as data.

An end of a joint is the number of a node, the name of a ``RigidBody`` or ``"ground"``.  Places and
axes are those of the initial configuration; each end takes them along as its body moves.
"""

from dataclasses import dataclass, field

import numpy as np

from ..checks import TINY, distinct, existing, integer, number, shown, text, vector
from ..errors import InputError
from ..fields import put
from .bodies import GROUND
from .histories import CONSTANT, FunctionOfTime
from .joints import Turning, name_of
from .loads import history_of

NONE = np.zeros((0, 2), dtype=np.int64)


def _end(name, value):
    """A node, a body or the ground."""
    return text(name, value) if isinstance(value, str) else integer(name, value)


def _axis(name, value):
    """A direction, as a unit vector."""
    axis = np.array(vector(name, value))
    length = np.linalg.norm(axis)
    if length < TINY:
        raise InputError(f"{name} must not be zero")
    return tuple((axis / length).tolist())


@dataclass(frozen=True)
class _Between:
    """A joint of two ends.

    Attributes:
        one, other: its ends.
        at: (x, y, z) of the joint [m]; left out, the place of an end that is a node.
        name: by which results and messages know it; left out, ``joint`` and its number.
    """

    one: object
    other: object
    at: tuple = None
    name: str = field(default="", kw_only=True)

    kind = "joint"
    tied = NONE
    nodes = ()

    def __post_init__(self):
        put(self, name=name_of(f"{self.kind}: name", self.name))
        for side in ("one", "other"):
            put(self, **{side: _end(f"{self._what}: {side}", getattr(self, side))})
        if self.one == self.other:
            raise InputError(f"{self._what}: both ends are {shown(self.one)}")
        if self.at is not None:
            put(self, at=vector(f"{self._what}: at", self.at, "m"))

    @property
    def _what(self):
        return f"{self.kind} {self.name}".rstrip()

    @property
    def ends(self):
        """Both ends."""
        return self.one, self.other

    def place(self, nodes):
        """(3,) place of the joint."""
        at = self.at
        for end in self.ends:
            if at is None and not isinstance(end, str):
                at = nodes[end]
        return np.array(at)


@dataclass(frozen=True)
class Ball(_Between):
    """A point that both ends share, about which they turn freely."""

    kind = "ball joint"


@dataclass(frozen=True)
class _Axial(_Between):
    axis: tuple = None

    def __post_init__(self):
        super().__post_init__()
        if self.axis is None:
            raise InputError(f"{self._what}: axis is missing")
        put(self, axis=_axis(f"{self._what}: axis", self.axis))


@dataclass(frozen=True)
class Revolute(_Axial, Turning):
    """A point and an ``axis`` that both ends share: one turns about it.

    At a smooth node of a shell the axis must be its normal; as a shell does not know turns about
    that, such a joint has no angle.  Between bodies, and of a body on the ground, the angle is that
    by which ``other`` has turned against ``one``, right-handed about the axis [rad].  Its moment is
    that of ``corovec.solver.model.joints.Turning``, by its attributes; or it is driven.

    Attributes:
        angle: that the joint is driven by [rad]; None where it is free.
        driving: ``FunctionOfTime`` that multiplies it, in a motion where the shell is at t = 0;
            of a static load factor, which a constant one rises with.
    """

    angle: float = None
    driving: FunctionOfTime = CONSTANT

    kind = "revolute joint"

    def __post_init__(self):
        super().__post_init__()
        self._check_turning(self._what)
        put(self, driving=history_of(self.driving, f"{self._what}: driving"))
        if self.angle is not None:
            put(self, angle=number(f"{self._what}: angle", self.angle, "rad"))
            if self.acts:
                raise InputError(f"{self._what}: a joint that is driven by its angle has no "
                                 "spring, damper, stop, latch or motor")
        elif self.driving != CONSTANT:
            raise InputError(f"{self._what}: driving needs an angle, which it multiplies")

    @property
    def places(self):
        """Number of places at which it has an angle that takes part."""
        return int(self.acts or self.angle is not None)


@dataclass(frozen=True)
class Cylindrical(_Axial):
    """A line through ``at`` along ``axis`` that both ends share: one slides along it and turns."""

    kind = "cylindrical joint"


@dataclass(frozen=True)
class Prismatic(_Axial):
    """As ``Cylindrical``, without the turn."""

    kind = "prismatic joint"


@dataclass(frozen=True)
class Universal(_Axial):
    """A point that both ends share, and an ``axis`` of one that stays at right angles to the
    ``other_axis`` of the other: a cross."""

    other_axis: tuple = None
    kind = "universal joint"

    def __post_init__(self):
        super().__post_init__()
        if self.other_axis is None:
            raise InputError(f"{self._what}: other_axis is missing")
        put(self, other_axis=_axis(f"{self._what}: other_axis", self.other_axis))
        if abs(np.dot(self.axis, self.other_axis)) > 1e-9:
            raise InputError(f"{self._what}: axis and other_axis must be at right angles")


@dataclass(frozen=True)
class RigidLink(_Between):
    """A massless rod: the distance between two points stays as it is.

    ``at`` is the point of one, ``to`` that of the other [m]; a node is its own point.
    """

    to: tuple = None
    kind = "rigid link"

    def __post_init__(self):
        super().__post_init__()
        if self.to is not None:
            put(self, to=vector(f"{self._what}: to", self.to, "m"))


@dataclass(frozen=True)
class Tie:
    """A weld of edges whose nodes do not meet: ``nodes`` lie on the polyline of ``line`` and move
    and turn with it.

    ``x = sum N_i x_i`` and ``p x sum N_i p_i = 0`` with the linear shape functions N_i of the edge
    that a node is on; the normals of both must agree.
    """

    nodes: tuple
    line: tuple
    name: str = ""

    tied = NONE
    ends = ()

    def __post_init__(self):
        put(self, name=name_of("tie: name", self.name))
        put(self, nodes=distinct("tie: nodes", self.nodes), line=distinct("tie: line", self.line))
        if len(self.line) < 2:
            raise InputError(f"tie {self.name}: line must have two nodes or more")
        if set(self.nodes) & set(self.line):
            raise InputError(f"tie {self.name}: node {min(set(self.nodes) & set(self.line))} is on "
                             "both sides")


LINKED = (Ball, Revolute, Cylindrical, Prismatic, Universal, RigidLink, Tie)


def check_linked(name, joint, nodes, bodies, joined):
    """Check the ends of a joint.

    Args:
        name: of the joint.
        joint: one of ``LINKED``.
        nodes: (n_nodes, 3) [m].
        bodies: names.
        joined: lists of nodes that move together.

    Raises:
        InputError: nodes and bodies that do not exist, a place that is missing or is not that of a
            node.
    """
    if isinstance(joint, Tie):
        existing(f"{name}: node", (*joint.nodes, *joint.line), len(nodes) - len(bodies))
        return
    grounds = [end for end in joint.ends if end == GROUND]
    if len(grounds) == 2:
        raise InputError(f"{name}: both ends are the ground")
    for end in joint.ends:
        if isinstance(end, str):
            if end != GROUND and end not in bodies:
                known = ", ".join((*bodies, GROUND))
                raise InputError(f"{name}: {shown(end)} is no body, must be one of: {known}")
        else:
            existing(f"{name}: node", (end,), len(nodes))
    if all(isinstance(end, str) for end in joint.ends) and joint.at is None:
        raise InputError(f"{name}: at is missing, the place of the joint")
    for group in joined:
        if len(set(group).intersection(end for end in joint.ends if not isinstance(end, str))) > 1:
            raise InputError(f"{name}: its nodes are joined already")
    size = np.ptp(nodes, axis=0).max()
    link = isinstance(joint, RigidLink)
    for end, place in zip(joint.ends, (joint.at, joint.to) if link else 2 * [joint.place(nodes)]):
        if isinstance(end, str) or place is None:
            continue
        if np.linalg.norm(nodes[end] - place) > 1e-6 * size:
            raise InputError(f"{name}: node {end} is at {nodes[end].tolist()}, the joint at "
                             f"{np.array(place).tolist()}")
