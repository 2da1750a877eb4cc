"""Joints of a model file: where the mesh is opened, and what holds the sides together."""

from typing import Literal

from pydantic import Field, model_validator

from ..errors import InputError
from ..model.bodies import RigidBody
from ..model.cutting import apart, cut
from ..model.joints import Hinge, Spherical
from ..model.linkages import (
    Ball,
    Cylindrical,
    Prismatic,
    Revolute,
    RigidLink,
    Tie,
    Universal,
)
from ..model.mesh import node_at
from .places import Placed
from .values import (
    Line,
    Name,
    NotNegative,
    Number,
    Numbers,
    Point,
    Positive,
    Strict,
    in_unit,
    only_one,
)

NONE = Field(0.0, validate_default=True)
End = Name | Point
Three = tuple[Positive, Positive, Positive]

MOMENT = ("stiffness", "rest", "turning", "spring_angles", "spring_moments", "damping",
          "damper_rates", "damper_moments", "stops", "stop_stiffness", "lock",
          "lock_stiffness", "lock_damping", "torque", "history")
"""Fields of what turns a joint."""

LINKED = {"ball": Ball, "revolute": Revolute, "cylindrical": Cylindrical, "prismatic": Prismatic,
          "universal": Universal, "link": RigidLink, "tie": Tie}
"""Joints with multipliers, by their kind."""

NEEDED = {"revolute": ("axis",), "cylindrical": ("axis",), "prismatic": ("axis",),
          "universal": ("axis", "other_axis"), "tie": ("nodes", "curve")}
"""What they need besides their ends, which all but a tie have."""

POSSIBLE = {"revolute": ("at", "angle", "driving", *MOMENT), "link": ("at", "to"), "tie": ()}
"""What they can have besides; others a place, ``at``."""


class BodyOf(Placed):
    """A rigid body, and the nodes that it carries, if it carries any.

    Attributes:
        name: by which joints know it.
        mass: of the body [kg].
        inertia: its three principal moments about its centre [kg m^2].
        centre: of mass [m].
        axes: three principal axes; along x, y and z without them [-].
    """

    name: Name
    mass: in_unit("kg", Positive)
    inertia: in_unit("kg m^2", Three)
    centre: in_unit("m", Point)
    axes: in_unit("", tuple[Point, Point, Point]) | None = None

    @model_validator(mode="after")
    def _one_place(self):
        if any((self.at, self.line, self.nodes, self.where)):
            only_one(self, ("at", "line", "nodes", "where"))
        return self

    def made(self, mesh):
        """``RigidBody`` on a ``Mesh``.

        Raises:
            InputError: its place is not there, or as of ``RigidBody``.
        """
        carries = any((self.at, self.line, self.nodes, self.where))
        return RigidBody(self.name, self.mass.value, self.inertia.value, self.centre.value,
                         self.numbers(mesh) if carries else (), self.axes and self.axes.value)


class JointOf(Strict):
    """A hinge of plates about a straight line of element edges, a spherical joint of plates at a
    point, or a joint between bodies, nodes and the ground.

    Attributes:
        kind: ``hinge`` or ``spherical``; of bodies, nodes and the ground ``ball``, ``revolute``,
            ``cylindrical``, ``prismatic``, ``universal``, ``link`` or ``tie``.
        name: by which probes and messages know it; without one ``joint`` and its number.
        line: of a hinge, from its start to its end; the mesh is opened there, unless it has an edge
            of its own on either side; whichever way it runs, the angle grows as the plates turn
            away from the side that their normals point to [m].
        at: of a spherical joint, the place where plates touch; of others their place, of a link
            that of its one end [m].
        one: of a joint of bodies, its one end: the name of a body, ``ground``, or the point of a
            node [m].
        other: its other end, likewise.
        axis: of revolute, cylindrical, prismatic and universal joints [-].
        other_axis: of a universal joint, that of its other end [-].
        to: of a link, the place of its other end [m].
        angle: by which a revolute joint is driven [rad].
        driving: name of the function of time that multiplies it.
        nodes: of a tie, a set of nodes or a line of the mesh, by name.
        curve: of a tie, the line of the mesh that they lie on, by name.
        stiffness: of a torsion spring [N m/rad].
        rest: angle at which it is slack [rad].
        turning: name of the function of time that multiplies ``rest``: the spring is a servo then.
        spring_angles: of the table of a spring, counted from ``rest``, rising [rad].
        spring_moments: there [N m].
        damping: of a damper [N m s/rad].
        damper_rates: of the table of a damper, rising [rad/s].
        damper_moments: there [N m].
        stops: the smallest and the largest angle [rad].
        stop_stiffness: of springs beyond these [N m/rad].
        lock: angle at which a latch holds [rad].
        lock_stiffness: of the latch [N m/rad].
        lock_damping: of the latch [N m s/rad].
        torque: of a motor [N m].
        history: name of the function of time of the motor; constant without one.
    """

    kind: Literal["hinge", "spherical", *LINKED]
    name: Name | None = None
    line: in_unit("m", Line) | None = None
    at: in_unit("m", Point) | None = None
    one: End | None = None
    other: End | None = None
    axis: in_unit("", Point) | None = None
    other_axis: in_unit("", Point) | None = None
    to: in_unit("m", Point) | None = None
    angle: in_unit("rad", Number) | None = None
    driving: Name | None = None
    nodes: Name | None = None
    curve: Name | None = None
    stiffness: in_unit("N m/rad", NotNegative) = NONE
    rest: in_unit("rad", Number) = NONE
    turning: Name | None = None
    spring_angles: in_unit("rad", Numbers) | None = None
    spring_moments: in_unit("N m", Numbers) | None = None
    damping: in_unit("N m s/rad", NotNegative) = NONE
    damper_rates: in_unit("rad/s", Numbers) | None = None
    damper_moments: in_unit("N m", Numbers) | None = None
    stops: in_unit("rad", tuple[Number, Number]) | None = None
    stop_stiffness: in_unit("N m/rad", Positive) | None = None
    lock: in_unit("rad", Number) | None = None
    lock_stiffness: in_unit("N m/rad", Positive) | None = None
    lock_damping: in_unit("N m s/rad", NotNegative) = NONE
    torque: in_unit("N m", Number) = NONE
    history: Name | None = None

    @model_validator(mode="after")
    def _one_place(self):
        given = self.model_fields_set - {"kind", "name"}
        if self.kind in LINKED:
            ends = () if self.kind == "tie" else ("one", "other")
            needed = (*ends, *NEEDED.get(self.kind, ()))
            missing = [name for name in needed if getattr(self, name) is None]
            if missing:
                raise ValueError(f"{', '.join(missing)}: missing, a {self.kind} joint needs "
                                 f"{', '.join(needed)}")
            _no_more(self.kind, given - {*needed, *POSSIBLE.get(self.kind, ("at",))})
            return self
        place = only_one(self, ("line", "at"))
        if (self.kind == "hinge") != (place == "line"):
            raise ValueError("a hinge has a line, a spherical joint an at")
        own = sorted(given.intersection(MOMENT))
        if self.kind == "spherical" and own:
            raise ValueError(f"{', '.join(own)}: a spherical joint has no moment")
        _no_more(self.kind, given - {place, *MOMENT})
        return self

    def opened(self, mesh):
        """The ``Mesh`` that is open there, and the nodes of a joint of plates by their fields."""
        if self.kind in LINKED:
            return mesh, {}
        if self.line:
            mesh, nodes, others = cut(mesh, *self.line.value)
            return mesh, {"nodes": nodes, "others": others}
        mesh, nodes = apart(mesh, self.at.value)
        return mesh, {"nodes": nodes}

    def ends(self, mesh):
        """Ends of a joint of bodies and nodes on a ``Mesh`` that is open, by their fields.

        Raises:
            InputError: they are not there.
        """
        if self.kind == "tie":
            return {"nodes": mesh.node_sets[self.nodes], "line": mesh.chain(self.curve)}
        if self.kind not in LINKED:
            return {}
        return {side: end if isinstance(end, str) else node_at(mesh.nodes, end)
                for side, end in (("one", self.one), ("other", self.other))}

    def made(self, places, functions):
        """The joint at ``places``, see ``opened`` and ``ends``, with functions of time by their
        names."""
        own = {} if self.name is None else {"name": self.name}
        names = {"hinge": MOMENT, "spherical": (), "tie": ()}.get(self.kind, (
            *NEEDED.get(self.kind, ()), *POSSIBLE.get(self.kind, ("at",))))
        for key in names:
            given = getattr(self, key)
            if key in ("turning", "history", "driving"):
                own[key] = functions[given]
            elif given is not None:
                own[key] = given.value
        return {"hinge": Hinge, "spherical": Spherical, **LINKED}[self.kind](**places, **own)


def _no_more(kind, names):
    """Raise for fields that a kind does not have."""
    if names:
        raise ValueError(f"{', '.join(sorted(names))}: a {kind} joint has no such thing")


def open_mesh(mesh, joints):
    """A ``Mesh`` opened for all ``JointOf`` s, and the nodes of each.

    Raises:
        InputError: no such place, with the number of the joint.
    """
    places = []
    for k, joint in enumerate(joints):
        try:
            mesh, place = joint.opened(mesh)
        except InputError as error:
            raise InputError(f"joints[{k}]: {error}") from None
        places.append(place)
    for k, joint in enumerate(joints):
        try:
            places[k].update(joint.ends(mesh))
        except InputError as error:
            raise InputError(f"joints[{k}]: {error}") from None
    return mesh, places
