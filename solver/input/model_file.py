"""What a model file holds: a shell, what acts on it, and how it is computed, as data."""

import re
from dataclasses import replace
from functools import cached_property
from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from ..checks import floats
from ..dynamics.probes import Probes
from ..dynamics.scheme import DISSIPATES, SCHEMES, Scheme
from ..dynamics.settings import Settings
from ..errors import InputError
from ..model.arithmetic import arithmetic
from ..model.histories import CONSTANT, TimeFunction
from ..model.joints import names_of
from ..model.mesh import MOST_ELEMENTS, node_at
from ..model.model import Model
from ..runtime.memory import ELEMENT, check_memory
from ..signatures import checked
from .acting import Driven, Held, History, Load, RigidMotion, Sector
from .attached import Damped, Foundation, MassAt, SpringBetween, SpringToGround
from .geometry import Geometry, Refinement
from .joints import BodyOf, JointOf, open_mesh
from .layers import Layers, Material, SectionOf
from .probed import Probed
from .values import (
    Count,
    Name,
    Number,
    Point,
    Positive,
    Probe,
    Sourced,
    Strict,
    Title,
    columns,
    in_unit,
    within,
)

PROPERTIES = ("thickness", "youngs", "poisson", "density")

ATTACHED = ("masses", "springs", "ground_springs", "foundations")
"""Lists of what is attached to nodes."""


class Parameters(Strict):
    """Thickness and material.

    Attributes:
        thickness: of the shell [m].
        thickness_at: instead, arithmetic in the place x, y, z of a node [m], as
            ``0.02 - 0.001 * x``; an element has the mean of its nodes.
        youngs: Young's modulus [Pa].
        poisson: Poisson's ratio [-].
        density: of the material [kg/m^3].
    """

    thickness_at: Name | None = None
    thickness: in_unit("m", Positive) | None = Field(None, validate_default=True)
    youngs: in_unit("Pa", Positive)
    poisson: in_unit("", within(-1.0, 0.5))
    density: in_unit("kg/m^3", Positive)

    @field_validator("thickness", mode="before")
    @classmethod
    def _one(cls, thickness, info):
        if thickness is None and info.data.get("thickness_at") is None:
            raise ValueError("is missing")
        if thickness is not None and info.data.get("thickness_at") is not None:
            raise ValueError("is given by thickness_at as well")
        return thickness


class Group(Strict):
    """What a group of elements has of its own, by the name of the group.

    Attributes:
        thickness: of the shell [m].
        youngs: Young's modulus [Pa].
        poisson: Poisson's ratio [-].
        density: of the material [kg/m^3].
    """

    thickness: in_unit("m", Positive) | None = None
    youngs: in_unit("Pa", Positive) | None = None
    poisson: in_unit("", within(-1.0, 0.5)) | None = None
    density: in_unit("kg/m^3", Positive) | None = None


class Paper(Strict):
    """Of a published run.

    Attributes:
        dt: time step [s].
        steps: how many.
    """

    dt: in_unit("s", Positive)
    steps: in_unit("", Count)

    @property
    def time(self):
        """Simulated time [s]."""
        return self.dt.value * self.steps.value


class Defaults(Strict):
    """What a run has that is not told otherwise.

    Attributes:
        elements: the mesh, by its number of elements; the coarsest without it.
        dt: time step [s].
        end_time: at which it ends [s].
    """

    elements: Count | None = None
    dt: Positive
    end_time: Positive

    @model_validator(mode="after")
    def _possible(self):
        Settings(self.dt, self.end_time)
        return self


class Static(Strict):
    """Equilibrium under loads that grow from zero.

    Attributes:
        kind: ``static``.
        increments: equal load factors up to 1 at which equilibrium is recorded.
        loads: names of those that act; all without it.
    """

    kind: Literal["static"]
    increments: Count = 10
    loads: list[Name] | None = None


class Dynamic(Strict):
    """Motion from rest, from the initial velocities, or from the equilibrium of the step before.

    Attributes:
        kind: ``dynamic``.
        dt: time step [s].
        end_time: at which it ends [s].
        loads: names of those that act; all without it.
        scheme: ``quasi``, ``exact`` or ``newmark``.
        dissipation: of ``exact``, 0 to 1.
        dissipates: of ``exact``, ``selective`` or ``constant``: where that is.
        rho_inf: of ``quasi``, the spectral radius at infinity, 0 to 1.
        order: in time, 2 or 4.
        error: of a step, in sizes of the shell, beyond which it is divided; 0 for steps of dt.
    """

    kind: Literal["dynamic"]
    dt: Positive
    end_time: Positive
    loads: list[Name] | None = None
    scheme: Literal[SCHEMES] = "quasi"
    dissipation: Number = 0.0
    dissipates: Literal[DISSIPATES] = "selective"
    rho_inf: Number = 1.0
    order: Count = 2
    error: Number = 0.0

    @model_validator(mode="after")
    def _possible(self):
        self.settings()
        return self

    def settings(self, **others):
        """``Settings`` of the step."""
        scheme = Scheme(self.scheme, self.rho_inf, dissipation=self.dissipation,
                        dissipates=self.dissipates, order=self.order)
        return Settings(self.dt, self.end_time, scheme, error=self.error, **others)


class Output(Strict):
    """What is recorded.

    Attributes:
        frame_every: steps between two frames; 0 for about 200 frames.
        stresses: whether frames have stresses.
    """

    frame_every: Annotated[int, Field(ge=0)] = 0
    stresses: bool = True


class Calibration(Strict):
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


class ModelFile(Strict):
    """A model as its file defines it.

    Attributes:
        name: of the model.
        title: what it is, in words.
        paper: of a published run.
        parameters: thickness and material; not needed where sections have all elements.
        materials: of layers, by name.
        laminates: layers of these, by name.
        sections: where laminates lie.
        groups: what groups of elements have of their own, by their names.
        geometry: the mesh.
        meshes: refinements of the geometry; the geometry as it is without any.
        defaults: of a run in time; not needed with steps.
        histories: functions of time, by name.
        loads: what acts.
        supports: what is held.
        drives: supports that move.
        masses: rigid masses at nodes.
        springs: between two nodes.
        ground_springs: between nodes and the ground.
        foundations: elastic ones under elements.
        bodies: rigid ones.
        joints: hinges and spherical joints of plates, and joints of bodies, nodes and the ground.
        damping: of the shell.
        cyclic: the shell is one sector of many.
        motion: how the shell moves at the start.
        steps: one static, one dynamic, or a dynamic one that starts from the equilibrium of a
            static one; a dynamic one by the defaults without any.
        points: nodes by their places [m], whose motion is recorded at every step.
        probes: stresses and energies that are recorded at every step, by name.
        output: what is recorded.
        calibration: how the peak was found, if it is calibrated.
    """

    name: Name
    title: Title = ""
    paper: Paper | None = None
    parameters: Parameters | None = None
    materials: dict[Name, Material] = {}
    laminates: dict[Name, Layers] = {}
    sections: list[SectionOf] = []
    groups: dict[Name, Group] = {}
    geometry: Geometry
    meshes: list[Refinement] = []
    defaults: Defaults | None = None
    histories: dict[Name, History] = {}
    loads: list[Load] = []
    supports: list[Held] = []
    drives: list[Driven] = []
    masses: list[MassAt] = []
    springs: list[SpringBetween] = []
    ground_springs: list[SpringToGround] = []
    foundations: list[Foundation] = []
    bodies: list[BodyOf] = []
    joints: list[JointOf] = []
    damping: Damped | None = None
    cyclic: Sector | None = None
    motion: RigidMotion | None = None
    steps: list[Annotated[Static | Dynamic, Field(discriminator="kind")]] = []
    points: dict[Probe, in_unit("m", Point)] = {}
    probes: dict[Probe, Probed] = {}
    output: Output = Output()
    calibration: Calibration | None = None

    @field_validator("meshes")
    @classmethod
    def _some(cls, meshes):
        if not meshes:
            raise ValueError("must not be empty, leave it out")
        return meshes

    @model_validator(mode="after")
    def _consistent(self):
        try:
            problems = [*self._of_material(), *self._of_meshes(), *self._of_loads(),
                        *self._of_supports(),
                        *self._of_steps()]
        except InputError as error:  # the file of the mesh
            raise ValueError(f"geometry.file: {error}") from None
        problems = problems or [*self._of_joints()] or [*self._of_places()]
        if problems:
            raise ValueError("; ".join(problems))
        try:
            model = self.model(self.sizes[0])
            if self.probes:
                Probes(model, self.probes_on(self.mesh(self.sizes[0])))
        except InputError as error:
            raise ValueError(self._in_file(str(error))) from None
        return self

    def _in_file(self, message):
        """An error of the model with the place of what it is of in the file."""
        supports = [place for place, _ in self._listed("supports", "drives")]
        if probe := re.match("probes: ", message):
            return f"probes.{message[probe.end():]}"
        if attached := re.match(r"attached\[(\d+)\]: ", message):
            mesh = self.mesh(self.sizes[0])
            places = [place for place, item in self._listed(*ATTACHED) for _ in item.made(mesh)]
            return f"{places[int(attached[1])]}: {message[attached.end():]}"
        if both := re.search(r"supports (\d+) and (\d+)", message):
            # beyond the list: what joints imply
            one, other = ((supports + ["one of a joined node"])[min(int(number), len(supports))]
                          for number in both.groups())
            return message.replace(both[0], f"{one} and {other}")
        for k, body in enumerate(self.bodies):
            if message.startswith(f"body {body.name}: "):
                return f"bodies[{k}]: {message.removeprefix(f'body {body.name}: ')}"
        for k, name in enumerate(names_of(self.joints)):
            if message.startswith(f"{name}: "):
                return f"joints[{k}]: {message.removeprefix(f'{name}: ')}"
        return message if message.startswith("joints: ") else f"geometry: {message}"

    def _listed(self, *names):
        """``(place in the file, item)`` of lists of tables."""
        return [(f"{name}[{k}]", item) for name in names
                for k, item in enumerate(getattr(self, name))]

    def _of_material(self):
        """What is wrong with parameters, and with the names of laminates and materials."""
        if self.parameters is None and (self.groups or not self.sections):
            yield "parameters: is missing"
        for name, laminate in self.laminates.items():
            unknown = [(k, ply.material) for k, ply in enumerate(laminate.plies)
                       if ply.material not in self.materials]
            for k, material in unknown:
                yield _unknown(f"laminates.{name}.plies[{k}].material", material, self.materials)
            if not unknown:
                yield from _wrong(f"laminates.{name}",
                                  lambda laminate=laminate: laminate.made(self.materials))
        for k, section in enumerate(self.sections):
            if section.laminate not in self.laminates:
                yield _unknown(f"sections[{k}].laminate", section.laminate, self.laminates)

    def _of_meshes(self):
        """What is wrong with the numbers of elements."""
        for k, mesh in enumerate(self.meshes):
            elements = self.geometry.elements * mesh.refinement**2
            if self.geometry.file and mesh.refinement != 1:
                yield f"meshes[{k}]: a mesh of a file has the refinement 1 only"
            elif mesh.elements != elements:
                yield (f"meshes[{k}]: refinement {mesh.refinement} has {elements} elements, not "
                       f"{mesh.elements}")
        for elements in self.sizes:
            if elements > MOST_ELEMENTS:
                yield f"geometry: {elements} elements, at most {MOST_ELEMENTS} are possible"
        yield from _repeated("meshes", "elements", [mesh.elements for mesh in self.meshes])
        if self.defaults and self.defaults.elements not in (None, *self.sizes):
            yield f"defaults.elements: no mesh of {self.defaults.elements} elements"

    def _of_loads(self):
        """What is wrong with the names and units of loads, histories and peaks."""
        yield from _repeated("loads", "name", [load.name for load in self.loads])
        for k, load in enumerate(self.loads):
            if load.history and load.history not in self.histories:
                yield _unknown(f"loads[{k}].history", load.history, self.histories)
                continue
            history = self.histories[load.history] if load.history else None
            units = [load.value.unit, history.unit if history else "",
                     history.peak.unit if history and history.peak else ""]
            if sorted(units) != sorted(["", "", load.unit]):
                yield (f"loads[{k}]: {load.kind} in '{units[0]}', history in '{units[1]}', peak in "
                       f"'{units[2]}': one must be in '{load.unit}', the others without unit")
        kinds = [history.peak.provenance for history in self.histories.values() if history.peak]
        if self.calibration and "calibrated" not in kinds:
            yield "calibration: no history has a peak that is calibrated"

    def _of_supports(self):
        """What is wrong with the functions of time of supports and joints."""
        for place, support in self._listed("supports", "drives", "joints"):
            for key in ("history", "turning", "driving"):
                name = getattr(support, key, None)
                if name and name not in self.histories:
                    yield _unknown(f"{place}.{key}", name, self.histories)
                elif name:
                    history = self.histories[name]
                    unit = history.unit or history.peak and history.peak.unit
                    if unit:
                        yield f"{place}.{key}: '{name}' is in '{unit}', must be without unit"

    def _of_steps(self):
        """What is wrong with the steps."""
        kinds = [step.kind for step in self.steps]
        if kinds not in ([], ["static"], ["dynamic"], ["static", "dynamic"]):
            yield ("steps: one static, one dynamic, or a static and a dynamic one are possible, "
                   f"not {', '.join(kinds)}")
        if not kinds and self.defaults is None:
            yield "defaults: is missing, with dt and end_time, or [[steps]]"
        names = [load.name for load in self.loads]
        for k, step in enumerate(self.steps):
            for name in step.loads or ():
                if name not in names:
                    yield _unknown(f"steps[{k}].loads", name, names)
        motion = self.dynamic if self.steps or self.defaults else None
        for k, load in enumerate(self.loads):
            moves = motion and (motion.loads is None or load.name in motion.loads)
            if moves and load.kind == "centrifugal":
                yield (f"loads[{k}]: centrifugal forces are those of a frame that turns: of a "
                       "static step, not of a motion")
        if self.motion and "static" in kinds:
            yield "motion: the motion starts from the equilibrium of the static step, at rest"
        for name in self.probes.keys() & self.points.keys():
            yield f"probes.{name}: a point has the same name"

    def _of_joints(self):
        """What is wrong with joints, and where they are."""
        names = names_of(self.joints)
        yield from _repeated("joints", "name", names)
        yield from _repeated("bodies", "name", [body.name for body in self.bodies])
        try:
            _, places = self._opened(self.sizes[0])
        except InputError as error:
            yield str(error)
            return
        functions = self._functions()
        for k, (joint, at) in enumerate(zip(self.joints, places)):
            yield from _wrong(f"joints[{k}]",
                              lambda joint=joint, at=at: joint.made(at, functions))

    def _of_places(self):
        """What is wrong with the places of groups, loads, supports, points and all else on a mesh
        that is right."""
        mesh, functions = self.mesh(self.sizes[0]), self._functions()
        for name in self.groups:
            yield from _wrong(f"groups.{name}", lambda name=name: mesh.groups[name])
        for k, load in enumerate(self.loads):
            place = f".{load.place[0]}" if load.place else ""
            yield from _wrong(f"loads[{k}]{place}", lambda load=load: load.made(mesh))
        for k, section in enumerate(self.sections):
            if section.group is not None:
                yield from _wrong(f"sections[{k}].group",
                                  lambda section=section: mesh.groups[section.group])
        for place, support in self._listed("supports", "drives"):
            yield from _wrong(place, lambda support=support: support.made(mesh, functions))
        for place, item in self._listed(*ATTACHED, "bodies"):
            yield from _wrong(place, lambda item=item: item.made(mesh))
        nodes = [*mesh.nodes, *(body.centre.value for body in self.bodies)]
        for name, probe in self.probes.items():
            yield from _wrong(f"probes.{name}", lambda probe=probe: probe.made(mesh))
        for name, point in self.points.items():
            yield from _wrong(f"points.{name}",
                              lambda point=point: node_at(nodes, point.value))
        if self.parameters and self.parameters.thickness_at:
            yield from _wrong("parameters.thickness_at", lambda: self._thickness(mesh))

    @property
    def heading(self):
        """The title, or the name where there is none."""
        return self.title or self.name

    @cached_property
    def sizes(self):
        """Element numbers of the model's meshes, ascending."""
        return tuple(sorted(mesh.elements for mesh in self.meshes)) or (self.geometry.elements,)

    @property
    def static(self):
        """The static step, or None."""
        return next((step for step in self.steps if step.kind == "static"), None)

    @property
    def dynamic(self):
        """The dynamic step, which is that of the defaults without any steps, or None."""
        if not self.steps:
            return Dynamic(kind="dynamic", dt=self.defaults.dt, end_time=self.defaults.end_time)
        return next((step for step in self.steps if step.kind == "dynamic"), None)

    @property
    def elements(self):
        """Number of elements of a run that is not told otherwise."""
        return self.defaults and self.defaults.elements or self.sizes[0]

    @property
    def free_peak(self):
        """Name of the history with a peak of its own, the one number to calibrate; or None."""
        return next((name for name, h in self.histories.items() if h.peak), None)

    def mesh(self, elements):
        """``Mesh`` with ``elements`` elements, open at the joints.

        Raises:
            InputError: no such mesh, or not enough memory for it.
        """
        return self._opened(elements)[0]

    def _opened(self, elements):
        """The mesh, and the nodes of all joints."""
        refinements = {mesh.elements: mesh.refinement for mesh in self.meshes} or {self.sizes[0]: 1}
        if elements not in refinements:
            raise InputError(f"model {self.name} has no mesh of {elements} elements, must be one "
                             f"of: {', '.join(map(str, self.sizes))}")
        check_memory(f"a mesh of {elements} elements", elements * ELEMENT)
        return open_mesh(self.geometry.mesh(refinements[elements]), self.joints)

    def loads_on(self, mesh, factor=1.0, names=None, rising=False):
        """The loads called ``names`` (None: all), times ``factor``, as loads of a ``Model``;
        ``rising``: each with the load factor to its value at t = 0."""
        functions = self._functions(factor, rising)
        return [one for load in self.loads if names is None or load.name in names
                for one in load.made(mesh, functions[load.history])]

    def supports_on(self, mesh, rising=False):
        """Supports, those that move last; ``rising`` as of ``loads_on``."""
        functions = self._functions(rising=rising)
        return [item.made(mesh, functions) for _, item in self._listed("supports", "drives")]

    def joints_on(self, elements, rising=False):
        """Joints on the mesh with ``elements`` elements; ``rising`` as of ``loads_on``."""
        return self._joints(self._opened(elements)[1], rising)

    def _joints(self, places, rising):
        functions = self._functions(rising=rising)
        return [joint.made(at, functions) for joint, at in zip(self.joints, places)]

    def attached_on(self, mesh):
        """All that is attached to nodes."""
        return [one for _, item in self._listed(*ATTACHED) for one in item.made(mesh)]

    def probes_on(self, mesh):
        """``{name: place or probe}`` of all points and probes."""
        return {**{name: point.value for name, point in self.points.items()},
                **{name: probe.made(mesh) for name, probe in self.probes.items()}}

    def _functions(self, factor=1.0, rising=False):
        """``{name: function of time}``; that of no name is constant."""
        functions = {name: history.function(factor) for name, history in self.histories.items()}
        if rising:
            functions = {name: TimeFunction((0.0, 1.0), (0.0, of(0.0)))
                         for name, of in functions.items()}
        constant = CONSTANT if factor == 1.0 or rising else TimeFunction((0.0,), (factor,))
        return {None: constant, **functions}

    def load_number(self, elements, k, names=None):
        """The number in the file of the load to which ``Model.loads[k]`` belongs."""
        mesh = self.mesh(elements)
        numbers = [number for number, load in enumerate(self.loads)
                   if names is None or load.name in names for _ in load.made(mesh)]
        return numbers[k]

    @checked
    def model(self, elements: int, load_factor: float = 1.0, loads: list[str] = None,
              rising: bool = False, **options):
        """``Model`` of the mesh with ``elements`` elements; options as of Model.

        Args:
            elements: of the mesh.
            load_factor: of all loads.
            loads: names of those that act, None for all.
            rising: each with the load factor to its value at t = 0, where a motion starts.

        Raises:
            InputError: no such mesh, or as of ``Model``.
        """
        mesh, places = self._opened(elements)
        values = {name: self._values(mesh, name) for name in PROPERTIES}
        shell = Model.of(mesh, loads=self.loads_on(mesh, load_factor, loads, rising),
                         supports=self.supports_on(mesh, rising), attached=self.attached_on(mesh),
                         damping=self.damping and self.damping.made(),
                         cyclic=self.cyclic and self.cyclic.made(),
                         joints=self._joints(places, rising),
                         bodies=[body.made(mesh) for body in self.bodies],
                         sections=self._sections(mesh), **values, **options)
        if self.motion is None:
            return shell
        velocity, normal_velocity = self.motion.rates(shell)
        return replace(shell, velocity=velocity, normal_velocity=normal_velocity)

    def _sections(self, mesh):
        """``Section`` s on a mesh."""
        laminates = {name: layers.made(self.materials) for name, layers in self.laminates.items()}
        return [section.made(mesh, laminates[section.laminate]) for section in self.sections]

    def _values(self, mesh, name):
        """A property, or (n_elem,) of them where they differ; None where sections have all."""
        if self.parameters is None:
            return None
        own = {group: getattr(given, name).value for group, given in self.groups.items()
               if getattr(given, name) is not None}
        if name == "thickness" and self.parameters.thickness_at:
            values = self._thickness(mesh)
            for group, value in own.items():
                values[mesh.groups[group]] = value
            return values
        value = getattr(self.parameters, name).value
        return mesh.per_element(own, default=value) if own else value

    def _thickness(self, mesh):
        """(n_elem,) by ``thickness_at`` [m]."""
        x, y, z = mesh.nodes.T
        at = floats("", arithmetic(self.parameters.thickness_at, x=x, y=y, z=z), (len(x),))
        if at.min() <= 0.0:
            raise InputError(f"is {at.min():g} m at node {at.argmin()}, must be positive")
        return mesh.per_element(at)

    def provenance(self):
        """Rows (parameter, value, unit, provenance, source) of everything the file defines."""
        rows = [(name, *columns(given)) for name, given in self.parameters or ()
                if given is not None and name != "thickness_at"]
        rows += self.geometry.rows()
        rows += [(f"mesh {m.elements}", f"refinement {m.refinement}", "", m.provenance, "")
                 for m in self.meshes]
        for name, h in self.histories.items():
            rows.append((f"{name}(t)", h.shape, h.unit, h.provenance, h.source))
            if h.peak:
                rows.append((f"peak of {name}(t)", *columns(h.peak)))
        for load in self.loads:
            rows.append((load.name, *columns(load.value)))
            if load.at or load.line:
                rows.append((load.name + (" acts at" if load.at else " acts along"),
                             *columns(load.at or load.line)))
            rows += [(f"{load.name} {name}", *columns(given)) for name in ("density", "velocity")
                     if (given := getattr(load, name))]
        rows += [(f"{place} {name}", *columns(given)) for place, item in (
            *self._listed(*ATTACHED, "bodies", "joints", "drives"), ("damping", self.damping or ()),
            *((f"probe {name}", probe) for name, probe in self.probes.items()))
            for name, given in item if isinstance(given, Sourced)]
        rows += [(f"point {name}", *columns(s)) for name, s in self.points.items()]
        rows += [(f"paper's {name}", *columns(s)) for name, s in self.paper or ()]
        return rows


def keys(kind=Strict):
    """Names of everything that a model file can hold."""
    return set().union(*({*one.model_fields, *keys(one)} for one in kind.__subclasses__()))


def _repeated(place, name, values):
    """What is wrong with ``values`` that are there again."""
    for k, value in enumerate(values):
        if value in values[:k]:
            yield f"{place}[{k}].{name}: {value} is that of {place}[{values.index(value)}] as well"


def _unknown(place, name, known):
    known = ", ".join(map(str, known))
    return f"{place}: '{name}' is " + (f"not among {known}" if known else "unknown, there is none")


def _wrong(place, make):
    """What is wrong with something that is made on a mesh."""
    try:
        make()
    except InputError as error:
        yield f"{place}: {error}"
