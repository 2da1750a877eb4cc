"""Probes: what is kept of single places at every step of a run."""

import zlib
from dataclasses import dataclass

import numpy as np

from ..checks import choice, existing, integer, integers, names_columns, shown, single, text, vector
from ..errors import InputError
from ..fields import put
from ..kernels import observation
from ..kernels.calls import Call
from ..kernels.hinges import ANGLE
from ..model.constants import in_surface, recovery
from ..model.joints import Hinge, names_of
from ..model.linkages import Cylindrical, Prismatic, Revolute, Universal
from ..model.mesh import node_at
from ..results.layout import DYNAMICS, PROBES, probed
from ..results.stresses import directions, turned, turned_vector
from ..system.joints import Angle, Relative
from .energies import Energies, acts

MOST_PROBES = 100
"""Each takes 48 bytes a step, of stress 88, of a joint 112."""


def _place(name, value):
    """A number of an element, or a point."""
    return integer(name, value) if single(value) else vector(name, value, "m")


def _elements(name, value):
    """Numbers of elements."""
    numbers = integers(name, value)
    if not len(numbers):
        raise InputError(f"{name} must not be empty")
    return tuple(sorted(set(numbers)))


@dataclass(frozen=True)
class StressProbe:
    """Forces, moments and von Mises stresses of an element, see ``stresses``.

    Attributes:
        at: its number, or a place (x, y, z) [m], to which its initial centre is the nearest.
        axes: direction of x, projected on the initial element; left out, as its nodes have it.

    Raises:
        InputError: neither a number nor a place.
    """

    at: object
    axes: tuple | None = None

    def __post_init__(self):
        put(self, at=_place("at", self.at))
        if self.axes is not None:
            given = directions("axes", vector("axes", self.axes))
            put(self, axes=tuple(given.tolist()))


@dataclass(frozen=True)
class EnergyProbe:
    """Strain energy of some elements, together.

    Attributes:
        elements: their numbers, as ``mesh.groups["skin"]``; all of them without any.

    Raises:
        InputError: no numbers.
    """

    elements: object = None

    def __post_init__(self):
        if self.elements is not None:
            put(self, elements=_elements("elements", self.elements))


@dataclass(frozen=True)
class JointProbe:
    """What a joint does: of a hinge, a revolute or a cylindrical joint the ``angle`` [rad] and its
    mean ``rate`` in the step [rad/s]; of a cylindrical or prismatic one the ``slide`` of ``other``
    along the axis [m] and its mean ``speed`` [m/s]; of a universal one between bodies the ``angle``
    of the cross about ``axis`` against ``one`` and the ``second`` one of ``other`` about
    ``other_axis`` against the cross [rad] with its ``second_rate`` [rad/s]; the ``moment`` of
    spring, damper, stops, latch and motor, or of the drive, that turns it on [N m], the energy that
    is ``stored`` there [J], the ``work`` of its motor, servo or drive and what is ``lost`` in its
    dampers since t = 0 [J]; of any joint the ``force`` on the plate of its ``nodes``, of a
    spherical one on the first node, of one with ends on ``other``, or on ``one`` where that is the
    ground [N], and on that its ``couple``, all moments about its place, of moments about its axis
    too [N m].  Forces and moments are means of the step.  What a joint does not have is zero.

    Attributes:
        joint: its name.

    Raises:
        InputError: it is no name.
    """

    joint: str

    def __post_init__(self):
        put(self, joint=text("joint", self.joint))


def probes_of(name, given):
    """Nodes, places and probes by names that are fit for columns."""
    if not isinstance(given, dict) or len(given) > MOST_PROBES:
        raise InputError(f"{name} must be a dictionary of at most {MOST_PROBES} nodes, places or "
                         f"probes by their names, is {shown(given)}")
    for key in given:
        if not names_columns(key):
            raise InputError(f"{name}: a name is letters, digits and _, is {shown(key)}")
    return dict(sorted(given.items()))


class Probes:
    """Probes on a model.

    Attributes:
        row: type of a history row with their columns.
        joints: whether there are any of joints.
        description: what a result file says of them.
        energies: ``Energies`` of single items, which are kept without being asked for.
    """

    def __init__(self, model, given):
        """``given``: nodes, places and probes by their names."""
        self._probes = {name: _made(model, f"probes: {name}", probe)
                        for name, probe in given.items()}
        self.energies = Energies(model)
        kinds = {name: probe.kind for name, probe in self._probes.items()}
        taken = dict.fromkeys(DYNAMICS.names, "the run")
        for name, kind in kinds.items():
            for column in (f"{name}{end}" for end in PROBES[kind]):
                if column in taken:
                    raise InputError(f"probes: {name}: its column {column} is one of "
                                     f"{taken[column]}: take another name")
                taken[column] = f"the probe {name}"
        self.row = probed(kinds, self.energies.counts)
        self.description = {name: probe.told for name, probe in self._probes.items()}
        self.joints = any(probe.kind == "joint" for probe in self._probes.values())
        self._columns = []

    def attach(self, history):
        """Write to the rows of ``history`` from now on."""
        size, self._columns, self._history = history.dtype.itemsize, [], history
        for name, probe in self._probes.items():
            columns = PROBES[probe.kind]
            first = history.dtype.fields[f"{name}{next(iter(columns))}"][1]
            count = sum(int(np.prod(shape)) for _, shape in columns.values())
            self._columns.append((probe, np.ndarray((len(history), count), "f8", history, first,
                                                    (size, 8))))

    def write(self, step, system, state, place, record, dt):
        """The columns of a step, of the ``state`` at its end and its ``place``; ``record``: its
        ``StepRecord``; dt: its length [s]."""
        both = slice(max(step - 1, 0), step + 1)
        if self.energies.names:
            self.energies.write(self._history[both], system, state, place, record)
        for probe, columns in self._columns:
            if probe.kind == "joint":
                probe.write(columns[both], system, state, place, record, dt)
            else:
                probe.write(columns[step], system, state, place)


def _made(model, name, probe):
    if isinstance(probe, StressProbe):
        return _Stress(model, name, probe)
    if isinstance(probe, EnergyProbe):
        return _Energy(model, name, probe)
    if isinstance(probe, JointProbe):
        return _Joint(model, name, probe)
    return _Node(model, name, probe)


class _Node:
    """Displacement and velocity of a node."""

    kind = "node"

    def __init__(self, model, name, place):
        if single(place):
            self.told = existing(f"{name}: node", (integer(name, place),), len(model.nodes))[0]
            return
        try:
            self.told = node_at(model.nodes, vector(name, place, "m"))
        except InputError as error:
            message = str(error)
            raise InputError(message if name in message else f"{name}: {message}") from None

    def write(self, row, system, state, place):
        row[:3], row[3:] = system.at_node(state, self.told)


class _Stress:
    """Forces, moments and von Mises stresses of an element.

    All are linear in its measures (e, b) but for a norm at the end: the von Mises stress is that of
    ``(s_xx - s_yy/2, sqrt(3)/2 s_yy, sqrt(3) s_xy, sqrt(3) s_xz, sqrt(3) s_yz)``.
    """

    kind = "stress"

    def __init__(self, model, name, probe):
        self._element = k = _nearest(model, name, probe.at)
        self.told = {"element": k, "axes": probe.axes and list(probe.axes)}
        corners, h = model.nodes[model.quads[[k]]], model.thickness[k]
        N, M, S, C = (None if operator is None else operator[0] for operator in recovery(
            corners, model.law.of([k]), membrane=model.membrane, shear=model.shear))
        n = np.concatenate([N, np.zeros((3, 11))], axis=1)
        m, q = (np.concatenate([np.zeros((len(of), N.shape[1])), of], axis=1) for of in (M, S))
        if C is not None:
            m[:, :N.shape[1]] = C
        if probe.axes is not None:
            seen, steep = in_surface(corners, np.array([probe.axes]))
            if steep[0]:
                raise InputError(f"{name}: axes {probe.axes} are no direction in the surface of "
                                 f"element {k}: they stand on it or are zero")
            along = seen[0]
            n, m, q = turned(n.T, along).T, turned(m.T, along).T, turned_vector(q.T, along).T
        shear = np.zeros_like(q), 1.5 * q / h, np.zeros_like(q)
        levels = [_measure(n / h + z * 6.0 * m / h**2, s)
                  for z, s in zip((1.0, 0.0, -1.0), shear)]
        self._operator = np.concatenate([n, m, q, *levels])
        self._measure = Call(observation.stress_at)

    def write(self, row, system, state, place):
        self._measure(self._operator, place.start, self._element, row)


def _measure(s, shear):
    """Five numbers whose norm is the von Mises stress, of stresses (3, n) and (2, n)."""
    root = np.sqrt(3.0)
    return np.stack([s[0] - 0.5 * s[1], 0.5 * root * s[1], root * s[2], *(root * shear)])


def _nearest(model, name, at):
    """Number of an element by itself, or by a place."""
    if isinstance(at, int):
        return existing(f"{name}: element", (at,), len(model.quads))[0]
    centres = model.nodes[model.quads].mean(axis=1)
    return int(np.argmin(np.linalg.norm(centres - at, axis=1)))


class _Energy:
    """Strain energy of some elements."""

    kind = "energy"

    def __init__(self, model, name, probe):
        n = len(model.quads)
        elements = existing(f"{name}: element", probe.elements or range(n), n)
        self._elements = np.array(elements)
        self.told = {"elements": len(elements),
                     "checksum": f"{zlib.crc32(self._elements.tobytes()):08x}"}

    def write(self, row, system, state, place):
        row[0] = place.start.energy[self._elements].sum()


class _Joint:
    """Angle, forces and energies of a joint."""

    kind = "joint"

    def __init__(self, model, name, probe):
        names = names_of(model.joints)
        if not names:
            raise InputError(f"{name}: the model has no joints")
        self._number = names.index(choice(f"{name}: joint", probe.joint, tuple(names)))
        joint = model.joints[self._number]
        self._angle = Angle(model, joint) if isinstance(joint, Hinge) else None
        acting = [k for k, other in enumerate(model.joints) if acts(other)]
        self._relative = None
        if isinstance(joint, (Revolute, Cylindrical, Prismatic, Universal)):
            self._relative = Relative(model, joint)
        self._place = acting.index(self._number) if self._number in acting else None
        self.told = {"joint": probe.joint}

    def write(self, rows, system, state, place, record, dt):
        """The last of ``rows``; before it stands that of the step before, if there is one."""
        row = rows[-1]
        if self._angle:
            last = rows[0, 0] if len(rows) == 2 else 0.0
            row[0] = self._angle(state, place.start.p, last)
        elif self._place is not None:
            row[0] = state.hinges[system.turnings.joints == self._number, ANGLE][0]
        if self._relative:
            last = rows[0, [0, 14]] if len(rows) == 2 else np.zeros(2)
            angle, row[14], row[9] = self._relative(state, place.start.p, *last)
            row[0] = row[0] if self._place is not None else angle
        if len(rows) == 2:
            row[[1, 10, 15]] = (row[[0, 9, 14]] - rows[0, [0, 9, 14]]) / dt
            forces = record.joints[self._number] / dt
            row[2], row[3:6], row[11:14] = forces[3], forces[:3], forces[4:]
            row[7:9] = rows[0, 7:9]
            if self._place is not None:
                row[7:9] += record.turned[self._number]
        if self._place is not None:
            row[6] = system.turnings.energies(state)[self._place]
