"""Loads of a model at one time: dead ones as vectors, followers as items of the system.

An item adds its forces and its matrix at an iterate, on cells of nodes of its own.
"""

import math
from collections import defaultdict
from typing import NamedTuple

import numpy as np

from ..errors import InputError, warn
from ..kernels import centrifugal, couples, pressure
from ..kernels.arguments import Factors, Loads
from ..model.histories import CONSTANT
from ..model.joints import Hinge, names_of
from ..model.loads import Centrifugal, Gravity, NodalLoad, NodalMoment, Pressure
from ..model.mesh import boundary
from ..model.nonconservative import FollowerForce
from ..names import listed
from .nonconservative import DragForces, FollowerForces, UserForces
from .state import State


class Iterate(NamedTuple):
    """Where forces are taken.

    Attributes:
        state: at the start of the step.
        step: its coefficients.
        delta: (n_dof,) increment.
        p: (n_directors, 3) normals at the generalized midpoint, for items that take them.
        A1: (n_directors, 3, 3) their derivatives.
    """

    state: State
    step: Factors
    delta: np.ndarray
    p: np.ndarray | None = None
    A1: np.ndarray | None = None

    @property
    def rates(self):
        """(n_dof,) U_dot there [m/s, 1/s]."""
        state, step = self.state, self.step
        return (step.rate_delta * self.delta - step.rate_velocity * state.velocity
                - step.rate_acceleration * state.acceleration)


class DeadLoads:
    """Nodal forces, weight, and moments about fixed axes, by their functions of time; forces of
    turning springs ``on_normals``."""

    def __init__(self, model, numbering, on_normals):
        self._on_normals = on_normals
        self._shapes = numbering.n_dof, (len(model.nodes), 3)
        self._forces = defaultdict(lambda: np.zeros(self._shapes[0]))
        self._moments = _moments(model)
        for load in model.loads:
            if isinstance(load, NodalLoad):
                first = numbering.start[load.node]
                self._forces[load.history][first:first + 3] += load.force
            elif isinstance(load, Gravity):
                self._forces[load.history][numbering.translations] += np.outer(
                    model.nodal_mass, load.acceleration)

    def at(self, value):
        """``arguments.Loads`` with ``value(history)`` for each function of time."""
        return Loads(_total(self._forces, value, self._shapes[0]),
                     _total(self._moments, value, self._shapes[1]), self._on_normals)

    @property
    def any_moment(self):
        """Whether there is a moment, whose generalized forces follow the shell."""
        return bool(self._moments)


class FollowerPressure:
    """Pressures along the current normals of elements.

    Attributes:
        cells: (n, 4) nodes of the elements that bear one.
        exact: whether their work in a step is that of the enclosed volume, of a closed surface in
            the exact scheme.
    """

    def __init__(self, model, exact=False):
        patterns = {}
        for load in model.loads:
            if isinstance(load, Pressure):
                elements = slice(None) if load.elements is None else list(load.elements)
                pattern = patterns.setdefault(load.history, np.zeros(len(model.quads)))
                pattern[elements] += load.pressure
        loaded = np.zeros(len(model.quads), dtype=bool)
        for pattern in patterns.values():
            loaded |= pattern != 0.0
        self.cells = np.ascontiguousarray(model.quads[loaded])
        self.exact = exact and loaded.any() and not len(boundary(self.cells))
        self._patterns = {history: pattern[loaded] for history, pattern in patterns.items()}

    def at(self, value):
        """Pressures (n,) [Pa] with ``value(history)`` for each function of time."""
        return _total(self._patterns, value, len(self.cells))

    def add_forces(self, dofs, iterate, pressures, forces):
        """Add the forces at an iterate to ``forces`` (n_dof,) [N]."""
        pressure.add_pressure_forces(
            dofs.nodes, self.cells, pressures, iterate.state.motion, iterate.delta,
            1.0 - iterate.step.alpha_f, forces)
        if self.exact:
            pressure.add_volume_remainder(
                dofs.nodes, self.cells, pressures, self.cells[0, 0], iterate.state.motion,
                iterate.delta, forces)

    def add_matrix(self, dofs, iterate, pressures, storage, values, skew):
        """Add their stiffness to the symmetric part and, if there is one, to the skew part."""
        pressure.add_pressure_stiffness(
            dofs, storage, self.cells, pressures, iterate.state.motion, iterate.delta,
            iterate.step, values, skew)


class NormalCouples:
    """Moments about the normals of smooth nodes, shared alike by the elements around them, on an
    edge of a sector by those on the other as well; those at clamped nodes go to the support.

    Attributes:
        cells: (n, 4) nodes of these elements, the one with the moment first.
        nodes: (m,) those with a moment.
    """

    def __init__(self, model):
        patterns = _moments(model)
        if model.pairs:
            patterns = {history: model.pairs.summed(pattern)
                        for history, pattern in patterns.items()}
        loaded = np.zeros(len(model.nodes), dtype=bool)
        for pattern in patterns.values():
            loaded |= np.any(pattern != 0.0, axis=1)
        loaded &= (np.diff(model.directors.first) == 1) & ~model.fixed.all(axis=1)
        elements, corners = np.nonzero(loaded[model.quads])
        around = corners[:, None] + np.arange(4)
        self.cells = np.ascontiguousarray(model.quads[elements[:, None], around % 4])
        nodes = self.cells[:, 0]
        self.nodes = np.unique(nodes)
        counts = np.bincount(nodes, minlength=len(model.nodes))
        if model.pairs:
            _, one, other, _ = model.pairs
            counts[one] = counts[other] = counts[one] + counts[other]
        shares = 1.0 / counts[nodes, None]
        self._directors = model.directors.first[nodes]
        self._patterns = {history: shares * pattern[nodes]
                          for history, pattern in patterns.items()}

    def at(self, value):
        """Moments (n, 3) [N m] with ``value(history)`` for each function of time."""
        return _total(self._patterns, value, self.cells[:, :3].shape)

    def add_forces(self, dofs, iterate, moments, forces):
        """Add the forces at an iterate to ``forces`` (n_dof,) [N]."""
        couples.add_couples(dofs.nodes, self.cells, self._directors, moments, iterate.state.motion,
                            iterate.delta, 1.0 - iterate.step.alpha_f, iterate.p, iterate.A1,
                            forces)

    def add_matrix(self, dofs, iterate, moments, storage, values, skew):
        """Add their stiffness to the symmetric part and, if there is one, to the skew part."""
        couples.add_couples_stiffness(dofs, storage, self.cells, self._directors, moments,
                                      iterate.state.motion, iterate.delta, iterate.step, iterate.p,
                                      iterate.A1, values, skew)


class CentrifugalForces:
    """Centrifugal forces of frames that turn about points.

    Attributes:
        cells: (n, 4) nodes of the elements, all of them.
    """

    def __init__(self, model):
        self._loads = [load for load in model.loads if isinstance(load, Centrifugal)]
        self.cells = model.quads[:len(model.quads) if self._loads else 0]
        self._elements = model.elements
        self._work = centrifugal.blank_work(len(model.nodes), len(model.normals))

    def at(self, value):
        """``(Q, about)`` of each frame, ``Q = |omega|^2 1 - omega omega^T`` [1/s^2], times
        ``value(history)``."""
        return [(value(load.history) * (np.dot(load.omega, load.omega) * np.eye(3)
                                        - np.outer(load.omega, load.omega)),
                 np.array(load.about)) for load in self._loads]

    def add_forces(self, dofs, iterate, frames, forces):
        """Add the forces at an iterate to ``forces`` (n_dof,) [N]."""
        for Q, about in frames:
            centrifugal.add_centrifugal_forces(
                self._elements, dofs, Q, about, iterate.state.motion, iterate.delta,
                1.0 - iterate.step.alpha_f, self._work, forces)

    def add_matrix(self, dofs, iterate, frames, storage, values, skew):
        """Add their stiffness, which is symmetric."""
        for Q, about in frames:
            centrifugal.add_centrifugal_stiffness(
                self._elements, dofs, storage, Q, about, iterate.state.motion, iterate.delta,
                iterate.step, self._work, values, skew)


class Applied(NamedTuple):
    """All loads at one time.

    Attributes:
        dead: ``arguments.Loads``.
        items: what each item has at that time.
        motors: (n,) moments of motors at each place of a joint [N m].
        slacks: (n,) angles at which springs of joints are slack at the end of the step [rad].
        driven: ``step_links.Rates`` of drives, None where there are no multipliers.
    """

    dead: Loads
    items: tuple
    motors: np.ndarray
    slacks: np.ndarray
    driven: object = None


def items(model, exact=False):
    """Items of the loads of a model, those that act on any cell; ``exact``: of the exact scheme."""
    found = (FollowerPressure(model, exact), NormalCouples(model), CentrifugalForces(model),
             FollowerForces(model), DragForces(model), UserForces(model))
    return [item for item in found if len(item.cells)]


def check_acting(model):
    """Warn of loads none of which does anything, all going into supports; where others act, some of
    a line or a surface may.  Warn of hinges that cannot turn."""
    fixed, n = model.fixed, len(model.loads)
    for name, joint in zip(names_of(model.joints), model.joints):
        if isinstance(joint, Hinge) and fixed[np.ravel(joint.tied), 3:].all():
            warn(f"{name}: supports hold the normals on both of its sides, it cannot turn",
                 UserWarning)
    if n and all(_held(load, fixed) for load in model.loads):
        warn(f"no load does anything: the supports take all of load{'s' * (n > 1)} "
             f"{listed(range(n))}, whose nodes are held in these directions", UserWarning)


def _held(load, fixed):
    """Whether a load acts on components only that supports fix, (n_nodes, 6)."""
    if isinstance(load, NodalLoad):
        return any(load.force) and not np.any(np.array(load.force)[~fixed[load.node, :3]])
    if isinstance(load, FollowerForce):
        return np.any(load.force) and fixed[load.node, :3].all()
    return isinstance(load, NodalMoment) and any(load.moment) and fixed[load.node].all()


def at_time(time):
    """Value of a function of time, for ``at``; an ``InputError`` where it is not finite."""
    return lambda history: _finite(history(time), f"t = {time:g} s")


def at_factor(factor):
    """The same for a static load factor: a constant load is multiplied by it, any other taken at
    it."""
    return lambda history: factor if history == CONSTANT else _finite(
        history(factor), f"load factor {factor:g}")


def _finite(value, at):
    if not math.isfinite(value):
        raise InputError(f"a function of time of a load or a support is {value} at {at}")
    return value


def unloaded(history):
    """The same where nothing acts: zero."""
    return 0.0


def _moments(model):
    """``{history: (n_nodes, 3)}``, the nodal moments of a model [N m]."""
    patterns = defaultdict(lambda: np.zeros((len(model.nodes), 3)))
    for load in model.loads:
        if isinstance(load, NodalMoment):
            patterns[load.history][load.node] += load.moment
    return patterns


def _total(patterns, value, shape):
    total = np.zeros(shape)
    for history, pattern in patterns.items():
        factor = value(history)
        if factor != 0.0:
            total += factor * pattern
    return total
