"""What a model file holds: parameters, geometry, meshes, histories and loads as data.

A value is given plainly, ``thickness = 0.1`` in the unit that the code understands, or with where
it comes from: ``thickness = { value = 0.1, unit = "m", provenance = "printed", source = "..." }``.
"""

from functools import partial
from typing import Annotated, Generic, Literal, TypeVar

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    field_validator,
    model_validator,
)

from ..checks import count, number, positive, text
from ..dynamics.settings import Settings
from ..errors import InputError
from ..model.generators import block, corners_of, sphere_segment
from ..model.loads import NodalLoad, TimeFunction, line_load
from ..model.mesh import MOST_ELEMENTS, line_nodes, node_at
from ..model.meshes import join
from ..model.model import Model
from ..runtime.memory import ELEMENT, check_memory
from ..signatures import checked

Provenance = Literal["printed", "derived", "assumed", "selected", "calibrated", "given"]
"""``selected``: chosen among candidates by a printed result; it proves as little as what was
``calibrated`` to one."""


def _within(low, high):
    """The type of a number between two others."""

    def check(value):
        if not low < number("", value) < high:
            raise InputError(f"must lie in ({low:g}, {high:g}), is {value}")
        return value

    return Annotated[float, BeforeValidator(check)]


# what a check says of a value without a name, its place in the file stands before
Number = Annotated[float, BeforeValidator(partial(number, ""))]
Positive = Annotated[float, BeforeValidator(partial(positive, ""))]
Count = Annotated[int, BeforeValidator(partial(count, ""))]
Name = Annotated[str, BeforeValidator(partial(text, ""))]
Title = Annotated[str, BeforeValidator(lambda given: given if given == "" else text("", given))]
Polar = _within(0.0, 180.0)
Point = tuple[Number, Number, Number]
Divisions = tuple[Count, Count]
T = TypeVar("T")


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Sourced(_Strict, Generic[T]):
    """A value with its unit, its provenance and where it comes from."""

    value: T
    unit: str
    provenance: Provenance
    source: str


def _sourced(value, unit=""):
    """A plain value as the table of a ``Sourced`` one."""
    if isinstance(value, dict | Sourced):
        return value
    return {"value": value, "unit": unit, "provenance": "given", "source": ""}


def _in(unit, kind):
    """The type of a ``Sourced`` value in a unit, the only one that the code understands."""

    def check(sourced):
        if sourced.unit != unit:
            raise ValueError(f"in '{sourced.unit}', must be in '{unit}'")
        return sourced

    return Annotated[Sourced[kind], BeforeValidator(lambda value: _sourced(value, unit)),
                     AfterValidator(check)]


class Parameters(_Strict):
    thickness: _in("m", Positive)
    youngs: _in("Pa", Positive)
    poisson: _in("", _within(-1.0, 0.5))
    density: _in("kg/m^3", Positive)


class Block(_Strict):
    corners: tuple[Point, Point, Point, Point]
    divisions: Divisions

    @field_validator("corners")
    @classmethod
    def _round(cls, corners):
        corners_of("", corners)
        return corners


class Sphere(_Strict):
    """Segment of a sphere between two parallels, see ``sphere_segment``."""

    radius: _in("m", Positive)
    polar_angles: _in("deg", tuple[Polar, Polar])
    divisions: _in("", Divisions)

    @field_validator("polar_angles")
    @classmethod
    def _from_above(cls, angles):
        if not angles.value[0] < angles.value[1]:
            raise ValueError(f"the upper parallel comes first: {angles.value} must increase")
        return angles


class Geometry(_Strict):
    """Flat blocks joined at coincident nodes, or a sphere segment."""

    blocks: list[Block] = []
    sphere: Sphere | None = None
    unit: str | None = None
    provenance: Provenance = "given"
    source: str = ""

    @model_validator(mode="after")
    def _one_kind(self):
        if bool(self.blocks) == bool(self.sphere):
            raise ValueError("either blocks or sphere is needed")
        if self.blocks and self.unit not in ("m", None):
            raise ValueError(f"blocks in '{self.unit}', must be in 'm'")
        return self

    @property
    def elements(self):
        """Number of elements at refinement 1."""
        return sum(n * m for n, m in self.divisions)

    @property
    def divisions(self):
        """Divisions of every block at refinement 1."""
        return ([self.sphere.divisions.value] if self.sphere
                else [block.divisions for block in self.blocks])

    def mesh(self, refinement):
        """Nodes, quads, exact normals (None for flat blocks)."""
        fine = [(refinement * n, refinement * m) for n, m in self.divisions]
        if self.sphere:
            mesh = sphere_segment(self.sphere.radius.value, self.sphere.polar_angles.value, *fine)
            normals = np.empty_like(mesh.nodes)
            normals[mesh.quads] = mesh.normals
            return mesh.nodes, mesh.quads, normals
        mesh = join([block(b.corners, d) for b, d in zip(self.blocks, fine)])
        return mesh.nodes, mesh.quads, None

    def rows(self):
        kind = "sphere segment" if self.sphere else f"{len(self.blocks)} blocks"
        unit = ("m" if self.blocks else "") if self.unit is None else self.unit
        return [("geometry", kind, unit, self.provenance, self.source),
                *((name, *_columns(sourced)) for name, sourced in self.sphere or ())]


class Mesh(_Strict):
    elements: Count
    refinement: Count
    provenance: Provenance = "given"


class History(_Strict):
    """Piecewise linear function of time: ``peak`` (1 if there is none) times ``values``."""

    times: list[Number]
    values: list[Number]
    peak: Annotated[Sourced[Number], BeforeValidator(_sourced)] | None = None
    unit: str = ""
    provenance: Provenance = "given"
    source: str = ""

    @model_validator(mode="after")
    def _possible(self):
        self.function()
        return self

    def function(self, factor=1.0):
        """``TimeFunction`` of the history times ``factor``."""
        factor *= self.peak.value if self.peak else 1.0
        return TimeFunction(self.times, [factor * value for value in self.values])


class Load(_Strict):
    """A force at a point, or a force per length along the mesh line between two points."""

    name: Name
    history: str
    at: _in("m", Point) | None = None
    line: _in("m", tuple[Point, Point]) | None = None
    force: Sourced[Point]

    @field_validator("force", mode="before")
    @classmethod
    def _plain(cls, force, info):
        return _sourced(force, "N/m" if info.data.get("line") else "N")

    @model_validator(mode="after")
    def _one_place(self):
        if bool(self.at) == bool(self.line):
            raise ValueError("either at or line is needed")
        return self

    def nodal(self, nodes, quads, function):
        """The load as ``NodalLoad`` s."""
        if self.at:
            return [NodalLoad(node_at(nodes, self.at.value), self.force.value, function)]
        return line_load(nodes, line_nodes(nodes, quads, *self.line.value), self.force.value,
                         function)


class Paper(_Strict):
    dt: _in("s", Positive)
    steps: _in("", Count)

    @property
    def time(self):
        """Simulated time [s]."""
        return self.dt.value * self.steps.value


class Defaults(_Strict):
    elements: Count
    dt: Positive
    end_time: Positive

    @model_validator(mode="after")
    def _possible(self):
        Settings(self.dt, self.end_time)
        return self


class Calibration(_Strict):
    """How ``corovec calibrate`` fitted the peak of a history to a printed energy.

    Attributes:
        elements: the mesh, by its number of elements.
        printed: its energy after unloading [J] as printed.
        table: where it is printed.
        dt: time step [s].
        residual: of our energy, relative to the printed one.
        dt_change: relative change of our energy at half the step.
    """

    elements: Count
    printed: str
    table: str
    dt: Positive
    residual: Number
    dt_change: Number

    @property
    def source(self):
        return (f"energy {self.printed} J of {self.elements} elements ({self.table}), which is no "
                f"check any more; dt {self.dt:g} s, residual {self.residual:.0e}, at half the step "
                f"{self.dt_change:+.0e}")


class ModelFile(_Strict):
    """A model as its file defines it.

    Attributes:
        name: of the model.
        title: what it is, in words; by default its name.
        paper: time step and number of steps of the paper; None if it is of no paper.
        parameters: thickness and material.
        geometry: blocks, or a segment of a sphere.
        meshes: refinements of the geometry.
        defaults: mesh, time step and end time of a run that is not told otherwise.
        histories: functions of time, by name.
        loads: forces at points and along lines.
        points: places of interest, by name.
        calibration: how the peak was found, if it is calibrated.
    """

    name: Name
    title: Title = ""
    paper: Paper | None = None
    parameters: Parameters
    geometry: Geometry
    meshes: list[Mesh] = Field(min_length=1)
    defaults: Defaults
    histories: dict[Name, History]
    loads: list[Load]
    points: dict[Name, _in("m", Point)] = {}
    calibration: Calibration | None = None

    @model_validator(mode="after")
    def _consistent(self):
        problems = [*self._of_meshes(), *self._of_loads()] or [*self._of_places()]
        if problems:
            raise ValueError("; ".join(problems))
        try:
            self.model(self.sizes[0])
        except InputError as error:
            raise ValueError(f"geometry: {error}") from None
        return self

    def _of_meshes(self):
        """What is wrong with the numbers of elements."""
        for k, mesh in enumerate(self.meshes):
            elements = self.geometry.elements * mesh.refinement**2
            if mesh.elements != elements:
                yield (f"meshes[{k}]: refinement {mesh.refinement} has {elements} elements, not "
                       f"{mesh.elements}")
            elif elements > MOST_ELEMENTS:
                yield f"meshes[{k}]: {elements} elements, at most {MOST_ELEMENTS} are possible"
        yield from _repeated("meshes", "elements", [mesh.elements for mesh in self.meshes])
        if self.defaults.elements not in self.sizes:
            yield f"defaults.elements: no mesh of {self.defaults.elements} elements"

    def _of_loads(self):
        """What is wrong with the names and units of loads, histories and peaks."""
        yield from _repeated("loads", "name", [load.name for load in self.loads])
        for k, load in enumerate(self.loads):
            history = self.histories.get(load.history)
            if history is None:
                yield (f"loads[{k}].history: '{load.history}' is not among "
                       f"{', '.join(self.histories)}")
                continue
            wanted = "N" if load.at else "N/m"
            units = [load.force.unit, history.unit, history.peak.unit if history.peak else ""]
            if sorted(units) != ["", "", wanted]:
                yield (f"loads[{k}]: force in '{units[0]}', history in '{units[1]}', peak in "
                       f"'{units[2]}': one must be in '{wanted}', the others without unit")
        kinds = [history.peak.provenance for history in self.histories.values() if history.peak]
        if self.calibration and "calibrated" not in kinds:
            yield "calibration: no history has a peak that is calibrated"

    def _of_places(self):
        """What is wrong with the places of loads and points on a mesh that is right."""
        nodes, quads, _ = self.mesh(self.sizes[0])
        for k, load in enumerate(self.loads):
            try:
                load.nodal(nodes, quads, self.histories[load.history].function())
            except InputError as error:
                yield f"loads[{k}].{'at' if load.at else 'line'}: {error}"
        for name, point in self.points.items():
            try:
                node_at(nodes, point.value)
            except InputError as error:
                yield f"points.{name}: {error}"

    @property
    def heading(self):
        """The title, or the name where there is none."""
        return self.title or self.name

    @property
    def sizes(self):
        """Element numbers of the model's meshes, ascending."""
        return tuple(sorted(mesh.elements for mesh in self.meshes))

    @property
    def free_peak(self):
        """Name of the history with a peak of its own, the one number to calibrate; or None."""
        return next((name for name, h in self.histories.items() if h.peak), None)

    def mesh(self, elements):
        """Nodes, quads and exact normals (or None) of the mesh with ``elements`` elements.

        Raises:
            InputError: no such mesh, or not enough memory for it.
        """
        mesh = next((mesh for mesh in self.meshes if mesh.elements == elements), None)
        if mesh is None:
            raise InputError(f"model {self.name} has no mesh of {elements} elements, must be one "
                             f"of: {', '.join(map(str, self.sizes))}")
        check_memory(f"a mesh of {elements} elements", elements * ELEMENT)
        return self.geometry.mesh(mesh.refinement)

    def loads_on(self, nodes, quads, factor=1.0):
        """The loads, times ``factor``, as ``NodalLoad`` s of a mesh."""
        functions = {name: h.function(factor) for name, h in self.histories.items()}
        return [one for load in self.loads
                for one in load.nodal(nodes, quads, functions[load.history])]

    def load_number(self, elements, k):
        """The number in the file of the load to which ``Model.loads[k]`` belongs."""
        nodes, quads, _ = self.mesh(elements)
        counts = [len(load.nodal(nodes, quads, TimeFunction((0.0,), (1.0,))))
                  for load in self.loads]
        return int(np.searchsorted(np.cumsum(counts), k, side="right"))

    @checked
    def model(self, elements: int, load_factor: float = 1.0, **options):
        """``Model`` of the mesh with ``elements`` elements; options as of Model.

        Raises:
            InputError: no such mesh, or as of ``Model``.
        """
        nodes, quads, normals = self.mesh(elements)
        values = {name: sourced.value for name, sourced in self.parameters}
        return Model(nodes, quads, loads=self.loads_on(nodes, quads, load_factor),
                     normals=normals, **values, **options)

    def provenance(self):
        """Rows (parameter, value, unit, provenance, source) of everything the file defines."""
        rows = [(name, *_columns(s)) for name, s in self.parameters]
        rows += self.geometry.rows()
        rows += [(f"mesh {m.elements}", f"refinement {m.refinement}", "", m.provenance, "")
                 for m in self.meshes]
        for name, h in self.histories.items():
            shape = list(zip(h.times, h.values))
            rows.append((f"{name}(t)", shape, h.unit, h.provenance, h.source))
            if h.peak:
                rows.append((f"peak of {name}(t)", *_columns(h.peak)))
        for load in self.loads:
            rows.append((load.name, *_columns(load.force)))
            rows.append((load.name + (" acts at" if load.at else " acts along"),
                         *_columns(load.at or load.line)))
        rows += [(f"point {name}", *_columns(s)) for name, s in self.points.items()]
        rows += [(f"paper's {name}", *_columns(s)) for name, s in self.paper or ()]
        return rows


def keys():
    """Names of everything that a model file can hold."""
    return {name for kind in _Strict.__subclasses__() for name in kind.model_fields}


def _repeated(place, name, values):
    """What is wrong with ``values`` that are there again."""
    for k, value in enumerate(values):
        if value in values[:k]:
            yield f"{place}[{k}].{name}: {value} is that of {place}[{values.index(value)}] as well"


def _columns(sourced):
    value = list(sourced.value) if isinstance(sourced.value, tuple) else sourced.value
    return value, sourced.unit, sourced.provenance, sourced.source
