"""Benchmarks as data: one TOML file a case, with the provenance of every parameter.

Provenance is ``printed`` (the paper's text or tables), ``derived`` (follows from printed numbers),
``assumed`` (our reconstruction of a lost figure) or ``calibrated`` (fitted to a printed energy).
"""

import tomllib
from functools import cache
from pathlib import Path
from typing import Generic, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from ..errors import InputError
from ..loads import NodalLoad, TimeFunction
from ..mesh import block, join, node_at
from ..model import Model

FOLDER = Path(__file__).parent
Provenance = Literal["printed", "derived", "assumed", "calibrated"]
Point = tuple[float, float, float]
T = TypeVar("T")


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Sourced(_Strict, Generic[T]):
    """A value with its unit, its provenance and where it comes from."""

    value: T
    unit: str
    provenance: Provenance
    source: str


class Parameters(_Strict):
    thickness: Sourced[float]
    youngs: Sourced[float]
    poisson: Sourced[float]
    density: Sourced[float]


class Block(_Strict):
    corners: tuple[Point, Point, Point, Point]
    divisions: tuple[int, int]


class Geometry(_Strict):
    blocks: list[Block] = Field(min_length=1)
    unit: str
    provenance: Provenance
    source: str


class Mesh(_Strict):
    elements: int = Field(gt=0)
    refinement: int = Field(gt=0)
    provenance: Provenance


class History(_Strict):
    times: list[float] = Field(min_length=1)
    values: list[float] = Field(min_length=1)
    unit: str
    provenance: Provenance
    source: str


class Load(_Strict):
    name: str
    history: str
    force: Sourced[Point]
    at: Sourced[Point]


class Paper(_Strict):
    dt: Sourced[float]
    steps: Sourced[int]


class Defaults(_Strict):
    elements: int
    dt: float = Field(gt=0.0)
    end_time: float = Field(gt=0.0)


class Case(_Strict):
    """One benchmark as defined in its file."""

    name: str
    title: str
    defaults: Defaults
    paper: Paper
    parameters: Parameters
    geometry: Geometry
    meshes: list[Mesh] = Field(min_length=1)
    histories: dict[str, History]
    loads: list[Load]
    points: dict[str, Sourced[Point]]

    @model_validator(mode="after")
    def _consistent(self):
        unknown = [load.name for load in self.loads if load.history not in self.histories]
        if unknown:
            raise ValueError(f"loads {', '.join(unknown)}: history is not among "
                             f"{', '.join(self.histories)}")
        return self

    @property
    def sizes(self):
        """Element numbers of the case's meshes, ascending."""
        return tuple(sorted(mesh.elements for mesh in self.meshes))

    def model(self, elements, **options):
        """:class:`solver.Model` of the mesh with ``elements`` elements; options as of Model.

        Raises:
            InputError: no such mesh.
        """
        mesh = next((mesh for mesh in self.meshes if mesh.elements == elements), None)
        if mesh is None:
            raise InputError(f"case {self.name} has no mesh of {elements} elements, must be one "
                             f"of: {', '.join(map(str, self.sizes))}")
        nodes, quads = join([block(b.corners, [mesh.refinement * d for d in b.divisions])
                             for b in self.geometry.blocks])
        functions = {name: TimeFunction(h.times, h.values) for name, h in self.histories.items()}
        loads = [NodalLoad(node_at(nodes, load.at.value), load.force.value,
                           functions[load.history]) for load in self.loads]
        values = {name: sourced.value for name, sourced in self.parameters}
        return Model(nodes, quads, loads=loads, **values, **options)

    def provenance(self):
        """Rows (parameter, value, unit, provenance, source) of everything the case defines."""
        rows = [(name, s.value, s.unit, s.provenance, s.source) for name, s in self.parameters]
        g = self.geometry
        rows.append(("geometry", f"{len(g.blocks)} blocks", g.unit, g.provenance, g.source))
        rows += [(f"mesh {m.elements}", f"refinement {m.refinement}", "", m.provenance, "")
                 for m in self.meshes]
        rows += [(f"{name}(t)", list(zip(h.times, h.values)), h.unit, h.provenance, h.source)
                 for name, h in self.histories.items()]
        for load in self.loads:
            for what, s in (("", load.force), (" acts at", load.at)):
                rows.append((load.name + what, list(s.value), s.unit, s.provenance, s.source))
        rows += [(f"point {name}", list(s.value), s.unit, s.provenance, s.source)
                 for name, s in self.points.items()]
        rows += [(f"paper's {name}", s.value, s.unit, s.provenance, s.source)
                 for name, s in self.paper]
        return rows


def case_names():
    """Names of the cases that can be run."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))


@cache
def load_case(name):
    """The case ``name``.

    Raises:
        InputError: unknown name, or a definition file with errors (all of them, each with its
            path in the file).
    """
    if name not in case_names():
        raise InputError(f"case '{name}' is unknown, must be one of: {', '.join(case_names())}")
    return read_case(FOLDER / f"{name}.toml")


def read_case(path):
    """The case defined in the file ``path``; errors as of :func:`load_case`."""
    try:
        with open(path, "rb") as file:
            return Case.model_validate(tomllib.load(file))
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: {error}") from None
    except ValidationError as errors:
        lines = [f"{'.'.join(map(str, e['loc'])) or 'file'}: {e['msg']}" for e in errors.errors()]
        raise InputError(f"{path}: " + "; ".join(lines)) from None
