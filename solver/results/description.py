"""What a result file says of its run, as far as others rely on it."""

import json
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError


class _Strict(BaseModel):
    model_config = ConfigDict(strict=True, allow_inf_nan=False)


class _Scheme(_Strict):
    name: str
    rho_inf: float
    transformation: str
    axes: str
    dissipation: float
    dissipates: str
    order: int


class _Newton(_Strict):
    kind: str
    tolerance: float
    min_iterations: int
    max_iterations: int


class _Settings(_Strict):
    dt: float
    end_time: float
    scheme: _Scheme
    newton: _Newton
    solver: str
    frame_every: int
    stresses: bool
    error: float


class _StaticSettings(_Strict):
    solver: str
    tolerance: float
    max_iterations: int
    fast_iterations: int
    max_divisions: int
    stresses: bool


class _LoadControl(_StaticSettings):
    method: Literal["load control"]
    factors: str


class _ArcLength(_StaticSettings):
    method: Literal["arc length"]
    length: float
    wanted_iterations: int
    switch: bool


class _Versions(_Strict):
    python: str
    corovec: str
    numpy: str
    scipy: str
    numba: str
    h5py: str


class _Machine(_Strict):
    processor: str
    system: str


class _Edges(_Strict):
    folded: int
    smooth: int
    smallest_fold: float | None
    largest_smooth: float | None


_Vector = Annotated[list[float], Field(min_length=3, max_length=3)]


class _Body(_Strict):
    mass: float
    centre: _Vector
    inertia: Annotated[list[_Vector], Field(min_length=3, max_length=3)]


class _Carried(_Strict):
    node: int | None
    vector: _Vector
    first: int = 0
    directors: list[_Vector] = []


class _Joint(_Strict):
    name: str
    kind: str
    nodes: list[int] = []
    ends: list[int | None] = []
    points: list[_Carried] = []
    axes: list[_Carried] = []


class _RigidBody(_Strict):
    name: str
    mass: float
    inertia: _Vector
    axes: Annotated[list[_Vector], Field(min_length=3, max_length=3)]
    nodes: list[int]
    at: int
    first: int


class _Description(_Strict):
    case: str | None
    fingerprint: str
    nodes: int
    elements: int
    edges: _Edges
    body: _Body
    membrane: str
    shear: str
    solver: str
    unloaded_at: Annotated[float, Field(ge=0.0, allow_inf_nan=True)]
    supported: bool
    joints: list[_Joint]
    bodies: list[_RigidBody]
    versions: _Versions
    machine: _Machine


class _StressProbe(_Strict):
    element: int
    axes: list[float] | None


class _EnergyProbe(_Strict):
    elements: int
    checksum: str


class _JointProbe(_Strict):
    joint: str


class _Dynamics(_Description):
    settings: _Settings
    probes: dict[str, int | _StressProbe | _EnergyProbe | _JointProbe]
    start: str | None
    energies: dict[str, list[str]]


class _Statics(_Description):
    settings: Annotated[_LoadControl | _ArcLength, Field(discriminator="method")]


def parsed(text, sizes):
    """The description in a JSON ``text``, as a dictionary.

    Raises:
        ValueError: it is no JSON, something is missing or of another type, or it tells of another
            mesh than that of ``sizes``.
    """
    description = json.loads(text)
    try:
        made = (_Statics if sizes.static else _Dynamics).model_validate(description)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, ("description", *first["loc"])))
        raise ValueError(f"{place}: {first['msg']}") from None
    if (description["nodes"], description["elements"]) != (sizes.nodes, sizes.elements):
        raise ValueError("description is of another mesh")
    _check_places(made, sizes)
    items = dict(sizes.items)
    of_items = ("joints", len(made.joints), items.get("joints", 0)) if sizes.static else (
        "energies", {kind: len(names) for kind, names in made.energies.items()}, items)
    for place, told, there in (
            ("supported", description["supported"], sizes.supported),
            ("settings.stresses", description["settings"]["stresses"], sizes.stresses),
            ("probes", sorted(description.get("probes", ())), sorted(dict(sizes.probes))),
            of_items):
        if told != there:
            raise ValueError(f"description.{place} is {told}, the datasets are of {there}")
    return description


def _check_places(description, sizes):
    """Raise ValueError for joints and bodies at nodes and directors that are not there."""
    carried = [one for joint in description.joints for one in (*joint.points, *joint.axes)]
    nodes = [*(i for item in (*description.joints, *description.bodies) for i in item.nodes),
             *(i for joint in description.joints for i in joint.ends if i is not None),
             *(one.node for one in carried if one.node is not None),
             *(body.at for body in description.bodies)]
    firsts = [*((one.first, len(one.directors)) for one in carried),
              *((body.first, 3) for body in description.bodies)]
    if not all(0 <= i < sizes.nodes for i in nodes) or not all(
            0 <= first <= sizes.directors - count for first, count in firsts):
        raise ValueError("description has a joint or a body where there is no node")
