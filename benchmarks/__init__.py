"""Benchmarks as data: one TOML file a case, with the provenance of every parameter.

Provenance is ``printed`` (the paper's text or tables), ``derived`` (follows from printed numbers),
``assumed`` (our reconstruction of a lost figure) or ``calibrated`` (fitted to a printed energy).
``calibrated.json`` holds the calibrated peaks, as ``corovec calibrate`` wrote them.
"""

import json
import tomllib
from functools import cache
from pathlib import Path
from typing import Annotated, Generic, Literal, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    Strict,
    TypeAdapter,
    ValidationError,
    field_validator,
    model_validator,
)

from corovec.solver.errors import InputError
from corovec.solver.model.loads import NodalLoad, TimeFunction, line_load
from corovec.solver.model.mesh import block, join, line_nodes, node_at, sphere_segment
from corovec.solver.model.model import Model

FOLDER = Path(__file__).parent
CALIBRATED = FOLDER / "calibrated.json"
Provenance = Literal["printed", "derived", "assumed", "calibrated"]
Number = Annotated[float, Strict()]
Positive = Annotated[float, Strict(), Field(gt=0.0)]
Count = Annotated[int, Strict(), Field(gt=0)]
Polar = Annotated[float, Strict(), Field(gt=0.0, lt=180.0)]
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


def _in(unit, kind):
    """The type of a ``Sourced`` value in a unit, the only one that the code understands."""

    def check(sourced):
        if sourced.unit != unit:
            raise ValueError(f"in '{sourced.unit}', must be in '{unit}'")
        return sourced

    return Annotated[Sourced[kind], AfterValidator(check)]


class Parameters(_Strict):
    thickness: _in("m", Positive)
    youngs: _in("Pa", Positive)
    poisson: _in("", Annotated[float, Strict(), Field(gt=-1.0, lt=0.5)])
    density: _in("kg/m^3", Positive)


class Block(_Strict):
    corners: tuple[Point, Point, Point, Point]
    divisions: Divisions


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
    unit: str
    provenance: Provenance
    source: str

    @model_validator(mode="after")
    def _one_kind(self):
        if bool(self.blocks) == bool(self.sphere):
            raise ValueError("either blocks or sphere is needed")
        if self.blocks and self.unit != "m":
            raise ValueError(f"blocks in '{self.unit}', must be in 'm'")
        return self

    @property
    def divisions(self):
        """Divisions of every block at refinement 1."""
        return ([self.sphere.divisions.value] if self.sphere
                else [block.divisions for block in self.blocks])

    def mesh(self, refinement):
        """Nodes, quads, exact normals (None for flat blocks)."""
        fine = [(refinement * n, refinement * m) for n, m in self.divisions]
        if self.sphere:
            return sphere_segment(self.sphere.radius.value, self.sphere.polar_angles.value, *fine)
        return *join([block(b.corners, d) for b, d in zip(self.blocks, fine)]), None

    def rows(self):
        kind = "sphere segment" if self.sphere else f"{len(self.blocks)} blocks"
        return [("geometry", kind, self.unit, self.provenance, self.source),
                *((name, *_columns(sourced)) for name, sourced in self.sphere or ())]


class Mesh(_Strict):
    elements: Count
    refinement: Count
    provenance: Provenance


class History(_Strict):
    """Piecewise linear function of time: ``peak`` (1 if there is none) times ``values``."""

    times: list[Number]
    values: list[Number]
    peak: Sourced[Number] | None = None
    unit: str
    provenance: Provenance
    source: str

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

    name: str
    history: str
    force: Sourced[Point]
    at: _in("m", Point) | None = None
    line: _in("m", tuple[Point, Point]) | None = None

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


class Calibration(_Strict):
    """A peak fitted to a printed energy: what ``corovec calibrate`` found, and how.

    Attributes:
        peak: of the case's history that has one [its unit].
        printed: energy after unloading [J] as printed, in ``table``, of the mesh of ``elements``.
        dt: time step [s].
        residual: of our energy, relative to the printed one.
        dt_change: relative change of our energy at half the step.
    """

    peak: Number
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


class Case(_Strict):
    """One benchmark as defined in its file."""

    name: str
    title: str
    paper: Paper
    parameters: Parameters
    geometry: Geometry
    meshes: list[Mesh] = Field(min_length=1)
    defaults: Defaults
    histories: dict[str, History]
    loads: list[Load]
    points: dict[str, _in("m", Point)] = {}

    @field_validator("meshes")
    @classmethod
    def _numbers_of_elements(cls, meshes, info):
        if "geometry" in info.data:
            coarse = sum(n * m for n, m in info.data["geometry"].divisions)
            for mesh in meshes:
                if mesh.elements != coarse * mesh.refinement**2:
                    raise ValueError(f"refinement {mesh.refinement} has "
                                     f"{coarse * mesh.refinement**2} elements, not {mesh.elements}")
        return meshes

    @field_validator("defaults")
    @classmethod
    def _known_mesh(cls, defaults, info):
        sizes = [mesh.elements for mesh in info.data.get("meshes", ())]
        if sizes and defaults.elements not in sizes:
            raise ValueError(f"no mesh of {defaults.elements} elements")
        return defaults

    @field_validator("loads")
    @classmethod
    def _known_histories(cls, loads, info):
        known = info.data.get("histories")
        unknown = [load for load in loads if known is not None and load.history not in known]
        if unknown:
            raise ValueError("; ".join(f"{load.name}: history '{load.history}' is not among "
                                       f"{', '.join(known)}" for load in unknown))
        for load in loads if known is not None else ():
            history, wanted = known[load.history], "N" if load.at else "N/m"
            units = [load.force.unit, history.unit, history.peak.unit if history.peak else ""]
            if sorted(units) != ["", "", wanted]:
                raise ValueError(f"{load.name}: force in '{units[0]}', history in '{units[1]}', "
                                 f"peak in '{units[2]}': one must be in '{wanted}', the others "
                                 "without unit")
        return loads

    @model_validator(mode="after")
    def _on_the_mesh(self):
        nodes, quads, _ = self.mesh(self.sizes[0])
        where = "loads"
        try:
            self.loads_on(nodes, quads)
            for name, point in self.points.items():
                where = f"point {name}"
                node_at(nodes, point.value)
        except InputError as error:
            raise ValueError(f"{where}: {error}") from None
        return self

    @property
    def sizes(self):
        """Element numbers of the case's meshes, ascending."""
        return tuple(sorted(mesh.elements for mesh in self.meshes))

    @property
    def free_peak(self):
        """Name of the history with a peak of its own, the one number to calibrate; or None."""
        return next((name for name, h in self.histories.items() if h.peak), None)

    def calibrated(self, calibration):
        """The case with the peak of a ``Calibration``.

        Raises:
            InputError: it has no history with a peak.
        """
        if self.free_peak is None:
            raise InputError(f"case {self.name} has no peak to calibrate")
        history = self.histories[self.free_peak]
        peak = Sourced[Number](value=calibration.peak, unit=history.peak.unit,
                              provenance="calibrated", source=calibration.source)
        changed = history.model_copy(update={"peak": peak})
        return self.model_copy(update={"histories": {**self.histories, self.free_peak: changed}})

    def mesh(self, elements):
        """Nodes, quads and exact normals (or None) of the mesh with ``elements`` elements.

        Raises:
            InputError: no such mesh.
        """
        mesh = next((mesh for mesh in self.meshes if mesh.elements == elements), None)
        if mesh is None:
            raise InputError(f"case {self.name} has no mesh of {elements} elements, must be one "
                             f"of: {', '.join(map(str, self.sizes))}")
        return self.geometry.mesh(mesh.refinement)

    def loads_on(self, nodes, quads, factor=1.0):
        """The loads, times ``factor``, as ``NodalLoad`` s of a mesh.

        Raises:
            InputError: a load point or line that the mesh does not have.
        """
        functions = {name: h.function(factor) for name, h in self.histories.items()}
        loads = []
        for load in self.loads:
            try:
                loads += load.nodal(nodes, quads, functions[load.history])
            except InputError as error:
                raise InputError(f"case {self.name}, load {load.name}: {error}") from None
        return loads

    def model(self, elements, load_factor=1.0, **options):
        """``Model`` of the mesh with ``elements`` elements; options as of Model.

        Raises:
            InputError: no such mesh, or as of ``loads_on``.
        """
        nodes, quads, normals = self.mesh(elements)
        values = {name: sourced.value for name, sourced in self.parameters}
        return Model(nodes, quads, loads=self.loads_on(nodes, quads, load_factor),
                     normals=normals, **values, **options)

    def provenance(self):
        """Rows (parameter, value, unit, provenance, source) of everything the case defines."""
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
        rows += [(f"paper's {name}", *_columns(s)) for name, s in self.paper]
        return rows


def _columns(sourced):
    value = list(sourced.value) if isinstance(sourced.value, tuple) else sourced.value
    return value, sourced.unit, sourced.provenance, sourced.source


def case_names():
    """Names of the cases that can be run."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))


@cache
def load_case(name):
    """The case ``name``, with its calibrated peak if there is one.

    Raises:
        InputError: unknown name, or a definition file with errors (all of them, each with its
            path in the file).
    """
    if name not in case_names():
        raise InputError(f"case '{name}' is unknown, must be one of: {', '.join(case_names())}")
    case, calibrations = read_case(FOLDER / f"{name}.toml"), read_calibrations()
    return case.calibrated(calibrations[name]) if name in calibrations else case


def read_case(path):
    """The case defined in the file ``path``; errors as of ``load_case``."""
    try:
        with open(path, "rb") as file:
            return _valid(path, Case.model_validate, tomllib.load(file))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: {error}") from None
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}") from None


def read_calibrations(path=CALIBRATED):
    """``{case: Calibration}`` of the file; errors as of ``load_case``."""
    text = path.read_text(encoding="utf-8") if path.exists() else "{}"
    return _valid(path, TypeAdapter(dict[str, Calibration]).validate_json, text)


def write_calibration(name, calibration, path=CALIBRATED):
    """Put the calibration of the case ``name`` into the file, beside those of other cases."""
    kept = {**read_calibrations(path), name: calibration}
    text = json.dumps({case: kept[case].model_dump() for case in sorted(kept)}, indent=2)
    path.write_text(text + "\n", encoding="utf-8")
    load_case.cache_clear()


def _valid(path, validate, data):
    try:
        return validate(data)
    except ValidationError as errors:
        lines = [f"{'.'.join(map(str, e['loc'])) or 'file'}: {e['msg']}" for e in errors.errors()]
        raise InputError(f"{path}: " + "; ".join(lines)) from None
