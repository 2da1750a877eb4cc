"""What acts on the shell of a model file: functions of time, loads, supports, a rigid motion."""

from functools import cached_property
from typing import Annotated

from pydantic import BeforeValidator, Field, field_validator, model_validator

from ..model.cyclic import Cyclic
from ..model.histories import (
    CONSTANT,
    Expression,
    Harmonic,
    Steps,
    TimeFunction,
    read_time_function,
)
from ..model.loads import (
    COMPONENTS,
    Centrifugal,
    Drive,
    Gravity,
    NodalLoad,
    NodalMoment,
    Pressure,
    Support,
    line_load,
    line_moment,
    surface_load,
)
from ..model.mesh import node_at
from ..model.model import rigid_velocity
from ..model.nonconservative import Drag, FollowerForce
from .places import Placed, elements_of
from .values import (
    Beside,
    Count,
    Line,
    Name,
    NotNegative,
    Number,
    NumberOrPoint,
    Point,
    Positive,
    Provenance,
    Sourced,
    Strict,
    Unit,
    in_unit,
    only_one,
    sourced,
)

HELD = {"clamped": COMPONENTS, "pinned": ("x", "y", "z"),
        **{f"symmetry {c}": (c, f"p{c}") for c in "xyz"}}
"""Words for the components that a support holds."""


class History(Strict):
    """A function of time: points, jumps, a table, a harmonic or an expression, times ``peak``.

    Attributes:
        times: of points, linear between them and constant beyond [s].
        values: at these times.
        jumps: constant from each time to the next instead of linear, zero before the first.
        csv: path of a table with times [s] and values, from the folder of the model file.
        columns: of the table, from 0.
        frequency: of a harmonic [Hz].
        amplitude: of the harmonic.
        phase: of the harmonic [rad].
        mean: of the harmonic.
        expression: arithmetic in the time t [s], as ``sin(2 * pi * t) * exp(-t)``.
        peak: what it is multiplied by.
        unit: of the values.
        provenance: where they come from.
        source: in words.
    """

    times: list[Number] | None = None
    values: list[Number] | None = None
    jumps: bool = False
    csv: Beside | None = None
    columns: tuple[int, int] = (0, 1)
    frequency: Positive | None = None
    amplitude: Number = 1.0
    phase: Number = 0.0
    mean: Number = 0.0
    expression: Name | None = None
    peak: Annotated[Sourced[Number], BeforeValidator(sourced), Unit(None)] | None = None
    unit: str = ""
    provenance: Provenance = "given"
    source: str = ""

    @model_validator(mode="after")
    def _possible(self):
        kind = only_one(self, ("times", "csv", "frequency", "expression"))
        for name, of in (("values", "times"), ("jumps", "times"), ("columns", "csv"),
                         *((name, "frequency") for name in ("amplitude", "phase", "mean"))):
            if name in self.model_fields_set and kind != of:
                raise ValueError(f"{name} belongs to {of}, this has {kind}")
        if kind == "times" and self.values is None:
            raise ValueError("values are missing")
        self.function()
        return self

    def function(self, factor=1.0):
        """The function of time, times ``factor``."""
        factor *= self.peak.value if self.peak else 1.0
        if self.frequency is not None:
            return Harmonic(self.frequency, factor * self.amplitude, self.phase,
                            factor * self.mean)
        if self.expression is not None:
            return Expression(self.expression if factor == 1.0 else
                              f"{factor!r} * ({self.expression})")
        points = self._points
        kind = Steps if self.jumps else TimeFunction
        return kind(points.times, tuple(factor * value for value in points.values))

    @cached_property
    def _points(self):
        """The table, which is read once, or the points that are given."""
        return (read_time_function(self.csv, self.columns) if self.csv
                else TimeFunction(self.times, self.values))

    @property
    def shape(self):
        """What it is, as it is given."""
        return (self.csv or self.expression or (f"{self.frequency:g} Hz" if self.frequency else
                                                list(zip(self.times, self.values))))


KINDS = ("force", "moment", "pressure", "gravity", "centrifugal", "follower", "drag")
"""What a load can be."""


class Load(Strict):
    """A force, a moment, a pressure, a weight, a spin, a drag; with its place, function of time.

    Attributes:
        name: of the load.
        history: name of its function of time; constant without one.
        at: the node at a point [m].
        line: the mesh line between two points [m].
        curve: a line of the mesh, by name.
        nodes: every node of a set, by name.
        surface: the elements of a group, by name, or ``all``.
        force: dead; of a point or of each node [N], along a line [N/m], on a surface [N/m^2].
        moment: about fixed axes; of a point or of each node [N m], along a line [N m/m].
        pressure: along the normals, which it follows; everywhere without a surface [Pa].
        gravity: acceleration of everything that has mass [m/s^2].
        centrifugal: angular velocity of a frame that turns, of static steps [rad/s].
        about: a point on its axis [m]; the origin without it.
        follower: a force that turns with a node: a number along the normal of a smooth one, at a
            junction that at the start [N].
        drag: coefficient of the quadratic drag of a medium, along the normals of a surface or
            everywhere.
        density: of the medium [kg/m^3].
        velocity: of the medium [m/s]; at rest without it.
    """

    name: Name
    history: Name | None = None
    at: in_unit("m", Point) | None = None
    line: in_unit("m", Line) | None = None
    curve: Name | None = None
    nodes: Name | None = None
    surface: Name | None = None
    force: Annotated[Sourced[Point], Unit(None)] | None = None
    moment: Annotated[Sourced[Point], Unit(None)] | None = None
    pressure: Annotated[Sourced[Number], Unit(None)] | None = None
    gravity: Annotated[Sourced[Point], Unit(None)] | None = None
    centrifugal: Annotated[Sourced[Point], Unit(None)] | None = None
    about: in_unit("m", Point) | None = None
    follower: Annotated[Sourced[NumberOrPoint], Unit(None)] | None = None
    drag: Annotated[Sourced[NotNegative], Unit(None)] | None = None
    density: in_unit("kg/m^3", Positive) | None = None
    velocity: in_unit("m/s", Point) | None = None

    @field_validator(*KINDS, mode="before")
    @classmethod
    def _plain(cls, value, info):
        return value if value is None else sourced(
            value, _unit(info.field_name, _place_in(info.data)))

    @model_validator(mode="after")
    def _one_place(self):
        kind, given = self.kind, [name for name in PLACES if getattr(self, name) is not None]
        allowed = PLACES_OF[kind]
        if len(given) > 1:
            raise ValueError(f"one place is needed, {' and '.join(given)} are given")
        if given and given[0] not in allowed:
            raise ValueError(f"a {kind} has no {given[0]}" + (
                f", it acts on one of: {', '.join(allowed)}" if allowed else ""))
        for name, of in (("about", "centrifugal"), ("density", "drag"), ("velocity", "drag")):
            if getattr(self, name) and kind != of:
                raise ValueError(f"a {kind} has no {name}")
        if not given and kind in ("force", "moment", "follower"):
            raise ValueError(f"a {kind} needs one of: {', '.join(allowed)}")
        if kind == "drag" and not self.density:
            raise ValueError("a drag needs the density of the medium")
        return self

    @property
    def kind(self):
        """One of ``KINDS``."""
        return only_one(self, KINDS)

    @property
    def value(self):
        """``Sourced`` value of it."""
        return getattr(self, self.kind)

    @property
    def place(self):
        """(kind of place, what is given); None for none."""
        name = _place_in(vars(self))
        return name and (name, getattr(self, name))

    @property
    def unit(self):
        """What its value times its function of time is in."""
        return _unit(self.kind, self.place[0] if self.place else None)

    def made(self, mesh, function=CONSTANT):
        """The load on a ``Mesh``, as loads of a ``Model``.

        Raises:
            InputError: its place is not there.
        """
        value = self.value.value
        if self.gravity:
            return [Gravity(value, function)]
        if self.centrifugal:
            about = self.about.value if self.about else (0.0, 0.0, 0.0)
            return [Centrifugal(value, about, function)]
        if self.pressure or self.drag:
            everywhere = self.surface in (None, "all")
            elements = None if everywhere else mesh.groups[self.surface].tolist()
            if self.pressure:
                return [Pressure(value, elements, function)]
            medium = self.velocity.value if self.velocity else (0.0, 0.0, 0.0)
            return [Drag(value, self.density.value, elements, medium, function)]
        if self.surface:
            return surface_load(mesh.nodes, mesh.quads[elements_of(mesh, self.surface)], value,
                                function)
        if self.line or self.curve:
            way = mesh.line(*self.line.value) if self.line else mesh.chain(self.curve)
            along = line_load if self.force else line_moment
            return along(mesh.nodes, way, value, function)
        nodal = FollowerForce if self.follower else NodalLoad if self.force else NodalMoment
        nodes = mesh.node_sets[self.nodes] if self.nodes else [node_at(mesh.nodes, self.at.value)]
        return [nodal(int(node), value, function) for node in nodes]


PLACES = ("at", "line", "curve", "nodes", "surface")
PLACES_OF = {"force": PLACES, "moment": ("at", "line", "curve", "nodes"), "pressure": ("surface",),
             "gravity": (), "centrifugal": (), "follower": ("at", "nodes"), "drag": ("surface",)}
PER = {"at": "", "nodes": "", "line": "/m", "curve": "/m", "surface": "/m^2", None: ""}
"""What a force is given per, by its place."""


def _place_in(data):
    """The kind of place among the fields that are read so far."""
    return next((name for name in PLACES if data.get(name) is not None), None)


def _unit(kind, place):
    """What a load of a kind at a kind of place is in."""
    return {"force": "N" + PER[place], "moment": "N m" + PER[place], "pressure": "Pa",
            "gravity": "m/s^2", "centrifugal": "rad/s", "follower": "N", "drag": ""}[kind]


class Held(Placed):
    """A support.

    Attributes:
        fix: ``clamped``, ``pinned``, ``symmetry x`` (y, z), or a list of the components x, y, z of
            the displacement and px, py, pz of the normal.
        axes: three orthogonal vectors that these x, y, z are along, of any length; the global ones
            without it.
        displacement: prescribed to the displacement components; a motion starts where the static
            step left it, or at zero [m].
        history: name of the function of time, or of the load factor, that multiplies it.
    """

    fix: str | list[str]
    axes: tuple[Point, Point, Point] | None = None
    displacement: in_unit("m", Number) | None = None
    history: Name | None = None

    @field_validator("fix")
    @classmethod
    def _known(cls, fix):
        known = HELD if isinstance(fix, str) else COMPONENTS
        for word in [fix] if isinstance(fix, str) else fix:
            if word not in known:
                raise ValueError(f"'{word}' is unknown, must be one of: {', '.join(known)}")
        return fix

    @model_validator(mode="after")
    def _followed(self):
        if self.history and not self.displacement:
            raise ValueError("history belongs to a displacement")
        return self

    def made(self, mesh, functions):
        """``Support`` on a ``Mesh``, with functions of time by their names.

        Raises:
            InputError: its place is not there.
        """
        components = HELD[self.fix] if isinstance(self.fix, str) else self.fix
        return Support(self.numbers(mesh), components,
                       self.displacement.value if self.displacement else 0.0,
                       functions[self.history], self.axes)


class Driven(Placed):
    """A clamped support that moves as a rigid body.

    Attributes:
        translation: at the largest, times its function of time [m].
        rotation: along its axis, times its function of time [rad].
        about: a point that the rotation leaves where it is [m].
        history: name of the function of time, or of the load factor; a motion starts where it is
            zero, or where the static step left it.
        turning: name of that of the rotation; without it, ``history``.
    """

    translation: in_unit("m", Point) | None = None
    rotation: in_unit("rad", Point) | None = None
    about: in_unit("m", Point) = Field((0.0, 0.0, 0.0), validate_default=True)
    history: Name | None = None
    turning: Name | None = None

    @model_validator(mode="after")
    def _moves(self):
        if not (self.translation or self.rotation):
            raise ValueError("a translation or a rotation is needed")
        if self.turning and not self.rotation:
            raise ValueError("turning belongs to a rotation")
        return self

    def made(self, mesh, functions):
        """``Drive`` on a ``Mesh``, with functions of time by their names.

        Raises:
            InputError: its place is not there.
        """
        translation, rotation = (given.value if given else (0.0, 0.0, 0.0)
                                 for given in (self.translation, self.rotation))
        return Drive(self.numbers(mesh), translation, rotation, self.about.value,
                     functions[self.history], functions[self.turning or self.history])


class Sector(Strict):
    """The shell is one of equal sectors about an axis, whose edges move alike but for a turn.

    Attributes:
        sectors: how many there are.
        axis: a vector along it.
        about: a point on it [m]; the origin without one.
    """

    sectors: Count
    axis: Point = (0.0, 0.0, 1.0)
    about: in_unit("m", Point) | None = None

    @model_validator(mode="after")
    def _possible(self):
        self.made()
        return self

    def made(self):
        """``Cyclic``."""
        about = self.about.value if self.about else (0.0, 0.0, 0.0)
        return Cyclic(self.sectors, self.axis, about)


class RigidMotion(Strict):
    """How the shell moves at the start.

    Attributes:
        velocity: of the point ``about`` [m/s].
        spin: [rad/s].
        about: a point [m]; without one the mass centre, of a sector a point on the axis.
    """

    velocity: in_unit("m/s", Point) | None = None
    spin: in_unit("rad/s", Point) | None = None
    about: in_unit("m", Point) | None = None

    def rates(self, model):
        """``velocity`` and ``normal_velocity`` of a ``Model``."""
        v, omega = (given.value if given else (0.0, 0.0, 0.0)
                    for given in (self.velocity, self.spin))
        centre = model.cyclic.about if model.cyclic else model.centre
        return rigid_velocity(model, v, omega, self.about.value if self.about else centre)
