"""Joints of a model file: where the mesh is opened, and what holds the sides together."""

from typing import Literal

from pydantic import Field, model_validator

from ..errors import InputError
from ..model.cutting import apart, cut
from ..model.joints import Hinge, Spherical
from .values import Line, Name, NotNegative, Number, Point, Positive, Strict, in_unit, only_one

NONE = Field(0.0, validate_default=True)


class JointOf(Strict):
    """A hinge about a straight line of element edges, or a spherical joint at a point.

    Attributes:
        kind: ``hinge`` or ``spherical``.
        name: by which probes and messages know it; without one ``joint`` and its number.
        line: of a hinge, from its start to its end; the mesh is opened there, unless it has an edge
            of its own on either side [m].
        at: of a spherical joint, the place where plates touch [m].
        stiffness: of a torsion spring [N m/rad].
        rest: angle at which it is slack [rad].
        turning: name of the function of time that multiplies ``rest``: the spring is a servo then.
        damping: of a damper [N m s/rad].
        stops: the smallest and the largest angle [rad].
        stop_stiffness: of springs beyond these [N m/rad].
        lock: angle at which a latch holds [rad].
        lock_stiffness: of the latch [N m/rad].
        lock_damping: of the latch [N m s/rad].
        torque: of a motor [N m].
        history: name of the function of time of the motor; constant without one.
    """

    kind: Literal["hinge", "spherical"]
    name: Name | None = None
    line: in_unit("m", Line) | None = None
    at: in_unit("m", Point) | None = None
    stiffness: in_unit("N m/rad", NotNegative) = NONE
    rest: in_unit("rad", Number) = NONE
    turning: Name | None = None
    damping: in_unit("N m s/rad", NotNegative) = NONE
    stops: in_unit("rad", tuple[Number, Number]) | None = None
    stop_stiffness: in_unit("N m/rad", Positive) | None = None
    lock: in_unit("rad", Number) | None = None
    lock_stiffness: in_unit("N m/rad", Positive) | None = None
    lock_damping: in_unit("N m s/rad", NotNegative) = NONE
    torque: in_unit("N m", Number) = NONE
    history: Name | None = None

    @model_validator(mode="after")
    def _one_place(self):
        place = only_one(self, ("line", "at"))
        if (self.kind == "hinge") != (place == "line"):
            raise ValueError("a hinge has a line, a spherical joint an at")
        own = self.model_fields_set - {"kind", "name", "line", "at"}
        if self.kind == "spherical" and own:
            raise ValueError(f"{', '.join(sorted(own))}: a spherical joint has no moment")
        return self

    def opened(self, mesh):
        """The ``Mesh`` that is open there, and the nodes of the joint by their fields."""
        if self.line:
            mesh, nodes, others = cut(mesh, *self.line.value)
            return mesh, {"nodes": nodes, "others": others}
        mesh, nodes = apart(mesh, self.at.value)
        return mesh, {"nodes": nodes}

    def made(self, places, functions):
        """``Hinge`` or ``Spherical`` joint at ``places``, see ``opened``, with functions of time by
        their names."""
        name = self.name or ""
        if self.at:
            return Spherical(**places, name=name)
        values = {key: getattr(self, key).value for key in (
            "stiffness", "rest", "damping", "stops", "stop_stiffness", "lock", "lock_stiffness",
            "lock_damping", "torque") if getattr(self, key) is not None}
        return Hinge(**places, **values, turning=functions[self.turning],
                     history=functions[self.history], name=name)


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
    return mesh, places
