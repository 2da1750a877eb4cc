"""One time step of a model: the discrete system, its state, and Newton's iteration (Eqs. 61-67)."""

import time
from dataclasses import dataclass

import numpy as np

from ..dynamics.newton import KeptMatrix, iterate
from ..errors import InputError, StepError
from ..kernels import assembly
from ..kernels import charts as rotation
from ..model.loads import CONSTANT, NodalLoad, NodalMoment, Pressure
from ..model.mesh import vector_areas
from .linear import make_solver
from .numbering import number_dofs

ROUNDOFF = 4.0 * np.finfo(float).eps
"""Relative rounding error of a strain; see ``System.roundoff_work``."""

MAX_HALVINGS = 10
"""A step is divided into at most 2^10 parts before the run gives up."""

NOT_TOLD = -1
"""Number of indefinite matrices where the solver does not tell."""


@dataclass
class State:
    """Everything that one instant of the motion consists of.

    Attributes:
        x: (n_nodes, 3) positions [m].
        x_low: (n_nodes, 3) their rounding errors [m].
        variables: (n_nodes, 3) rotational variables.
        chart: (n_nodes, 3, 3) their axes, see ``kernels.charts``.
        velocity: (n_dof,) U_dot.
        acceleration: (n_dof,) U_ddot.
        external_work: work of the loads since t = 0 [J].
    """

    x: np.ndarray
    x_low: np.ndarray
    variables: np.ndarray
    chart: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    external_work: float = 0.0

    ARRAYS = ("x", "x_low", "variables", "chart", "velocity", "acceleration")

    def pack(self):
        """All numbers of the state as one float64 vector."""
        arrays = [getattr(self, name).ravel() for name in self.ARRAYS]
        return np.concatenate([*arrays, [self.external_work]])

    def unpack(self, packed):
        """Take over the numbers of ``pack``."""
        at = 0
        for name in self.ARRAYS:
            array = getattr(self, name)
            array[...] = packed[at:at + array.size].reshape(array.shape)
            at += array.size
        self.external_work = float(packed[at])


@dataclass
class StepRecord:
    """What happened in one step of the time grid: sums over its parts if it was halved, but the
    final work ratio cc of the last part as ``residual``."""

    iterations: int = 0
    residual: float = 0.0
    switches: int = 0
    halvings: int = 0
    indefinite: int = 0

    def count(self, negative):
        """Count a matrix with ``negative`` negative pivots, None where the solver does not tell."""
        if negative is None:
            self.indefinite = NOT_TOLD
        elif negative:
            self.indefinite += 1


@dataclass
class Seconds:
    """Wall-clock seconds by phase."""

    assembly: float = 0.0
    factorization: float = 0.0
    solve: float = 0.0
    total: float = 0.0

    @property
    def rest(self):
        return self.total - self.assembly - self.factorization - self.solve


@dataclass(frozen=True)
class Instant:
    """Energies [J] and momenta [kg m/s, kg m^2/s] of a state, see ``assembly.observe``."""

    kinetic: float
    strain: float
    linear_momentum: np.ndarray
    angular_momentum: np.ndarray
    angular_momentum_printed: np.ndarray
    momentum_scale: float
    angular_scale: float


class System:
    """A model made ready for the kernels, with the linear solver and the scratch arrays."""

    def __init__(self, model, solver="auto", follow=True):
        self.model = model
        self.follow = follow
        self.elements = model.elements
        directors = model.directors
        n_rot = np.where(np.diff(directors.first) == 1, 2, 3)
        self.numbering = number_dofs(model.quads, n_rot)
        self.solver = make_solver(solver, self.numbering)
        self.seconds = Seconds()
        n_nodes, n_elem, n_dof = len(model.nodes), len(model.quads), self.numbering.n_dof
        self.fixed_component, fixed = _supports(model, self.numbering)
        self.fixed = fixed
        self.translations = self.numbering.start[:, None] + np.arange(3)
        # the nodal frame of a junction starts along the global axes, Eq. (12)
        self.nodes = (self.numbering.start, self.numbering.n_rot, directors.first,
                       model.normals.copy())
        self._numbering = (self.nodes, fixed, bool(fixed.any()))
        self.nodal_mass = np.zeros(n_nodes)
        np.add.at(self.nodal_mass, model.quads, self.elements.mass.sum(axis=2))
        self._loads = _load_patterns(model, self.numbering)
        self._any_pressure = any(isinstance(load, Pressure) for load in model.loads)
        self.all_dead = all(isinstance(load, NodalLoad) for load in model.loads)
        self.p = model.normals.copy()
        self.p_dot = np.zeros_like(self.p)
        self.A1 = np.zeros((len(self.p), 3, 3))
        n_s = self.elements.l.shape[1]
        self._start = (np.zeros_like(self.p), np.zeros((n_elem, 3, 3)), np.zeros((n_elem, 11)),
                       np.zeros((n_elem, n_s)))
        self.mixed = False
        self.predicted = (np.zeros((n_elem, n_s)), np.zeros((n_elem, 11)))
        self.element_energy = np.zeros(n_elem)
        self.residual = np.zeros((3, n_dof))
        self._scratch = scratch(n_nodes, len(self.p))
        self.kept = KeptMatrix(self)
        area = np.linalg.norm(vector_areas(model.nodes[model.quads]), axis=1)
        self._stretch_energy = float(np.sum(model.youngs * model.thickness * area))

    def initial_state(self):
        """State at t = 0: the initial configuration and velocities, Ü from Eq. (55)."""
        state = self.placed_state()
        # M Ü = F_ext - F_m - F_int: unit mass factor, no stiffness, velocities as they are
        mass_only = (0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0, 0.0)
        self.assemble(state, mass_only, False, np.zeros(self.numbering.n_dof), self.loads_at(0.0))
        if np.any(self.residual[0]):
            self.solver.factor()
            state.acceleration[:] = self.solver.solve(self.residual[0])
            state.acceleration[self.fixed] = 0.0
        return state

    def placed_state(self):
        """State at t = 0, but for Ü, which is zero."""
        model, state = self.model, self.blank_state()
        state.velocity[self.translations] = model.velocity
        rotation.start_charts(self.nodes, self.fixed_component, model.normals,
                              model.normal_velocity, state.variables, state.chart, state.velocity)
        fixed = self.fixed
        if np.any(state.velocity[fixed]):
            k = int(np.flatnonzero(fixed & (state.velocity != 0.0))[0])
            raise InputError(f"node {self.numbering.node_of_dof[k]}: initial velocity of a "
                             "supported component must be zero")
        self.observe(state)
        return state

    def blank_state(self):
        """Nodes at their initial places, axes along the global ones, everything else zero."""
        nodes, n_dof = self.model.nodes, self.numbering.n_dof
        return State(nodes.copy(), np.zeros_like(nodes), np.zeros_like(nodes),
                     np.tile(np.eye(3), (len(nodes), 1, 1)), np.zeros(n_dof), np.zeros(n_dof))

    def static_loads(self, factor):
        """Loads at a load factor: a constant load is multiplied by it, any other taken at it."""
        return self._sum_loads(lambda h: factor if h == CONSTANT else h(factor))

    def loads_at(self, time_):
        """Loads at time t: dead forces (n_dof,) [N], moments (n_nodes, 3) [N m], pressures
        (n_elem,) [Pa], and whether there are any pressures."""
        return self._sum_loads(lambda history: history(time_))

    def _sum_loads(self, value):
        totals = (np.zeros(self.numbering.n_dof), np.zeros((len(self.model.nodes), 3)),
                  np.zeros(len(self.model.quads)))
        for (history, kind), pattern in self._loads.items():
            factor = value(history)
            if factor != 0.0:
                totals[kind][...] += factor * pattern
        return *totals, self._any_pressure

    def observe(self, state):
        """Energies and momenta of ``state``; makes it the start of the next step."""
        self._place(state)
        rotation.director_rates(self.nodes, state.velocity, self.A1, self.p_dot)
        velocity = state.velocity[self.translations]
        values = assembly.observe(self.elements, self.nodal_mass, state.x, state.x_low, self.p,
                                  velocity, self.p_dot, self._start, self.element_energy)
        self._kinetic = values[0]
        return Instant(values[0], values[1], values[2:5], values[5:8], values[8:11], values[11],
                       values[12])

    @property
    def nodal_normals(self):
        """(n_nodes, 3) current normals; at a junction that of its first plate."""
        return self.p[self.model.directors.first[:-1]]

    def predict_strains(self, state, correction):
        """Strain measures for a mixed tangent after ``correction``; see the kernel."""
        assembly.predict_strains(self.elements, self.nodes, state.x, state.x_low, self.p,
                                 self.A1, self._start, correction, *self.predicted)

    def turn(self, state, correction):
        """Turn the normals of ``state`` along great circles, see ``rotation.turn_normals``."""
        rotation.turn_normals(self.nodes, self.fixed_component, correction, state.variables,
                              state.chart, self.p, self.A1)

    def largest_turn(self, correction):
        """Largest angle [rad] by which a correction turns a normal."""
        return rotation.largest_turn(self.nodes, correction, self.A1)

    def _place(self, state):
        lost = rotation.place_directors(self.nodes, state.variables, state.chart, self.p, self.A1)
        if lost >= 0:
            raise StepError(f"the normal of node {lost} has left its chart")

    def advance(self, state, scheme, rule, start, dt, record, depth=0):
        """Move ``state`` from ``start`` to ``start + dt``; halves the step where Newton fails.

        Returns the ``Instant`` at the end and adds to ``record``.

        Raises:
            StepError: the step did not converge although halved ``MAX_HALVINGS`` times.
        """
        loads = self.loads_at(start + (1.0 - scheme.alpha_f) * dt)
        delta, failure = iterate(self, state, scheme, rule, dt, loads, record)
        if delta is None and rule.keep:
            delta, failure = iterate(self, state, scheme, rule.full, dt, loads, record)
        if delta is not None:
            return self._accept(state, scheme, start, dt, delta, loads, record)
        if depth == MAX_HALVINGS:
            raise StepError(f"no convergence at t = {start:.9g} s with dt = {dt:.3g} s: {failure}")
        record.halvings += 1
        half = 0.5 * dt
        self.advance(state, scheme, rule, start, half, record, depth + 1)
        return self.advance(state, scheme, rule, start + half, half, record, depth + 1)

    @property
    def roundoff_work(self):
        """Work of a residual that is rounding error alone: (4 eps)^2 (sum E h A + 2 T), T the
        kinetic energy at the start of the step.

        Strains are differences of numbers of order one, so their rounding error is a few eps and
        its energy eps^2 E V; smaller works cannot be told from zero and end the iteration.
        """
        return ROUNDOFF**2 * (self._stretch_energy + 2.0 * self._kinetic)

    def inside(self, state, step, delta):
        """Whether every normal is still in its chart after the last correction."""
        return rotation.advance_nodes(self.nodes, _motion(state), step, delta,
                                      self._scratch) == 0

    def _accept(self, state, scheme, start, dt, delta, loads, record):
        """End of a converged step: new state, energies, switches."""
        assembly.accept(self._numbering, scheme.end(dt), delta, state.x, state.x_low,
                        state.variables, state.velocity, state.acceleration)
        applied = loads[0] if scheme.alpha_f == 0.5 else self.loads_at(start + 0.5 * dt)[0]
        if not self.all_dead:
            applied = applied + self.residual[2] - loads[0]
        state.external_work += float(applied @ delta)
        record.switches += self.switch(state, dt)
        return self.observe(state)

    def switch(self, state, dt):
        """Renew the axes of the rotational variables for the next step; how many switched."""
        return rotation.switch_charts(
            self.nodes, self.fixed_component, self.follow, dt, state.variables, state.chart,
            state.velocity, state.acceleration)

    def assemble(self, state, step, averaged, delta, loads, tangent=True):
        """Residual and matrix of one iterate, see ``assembly.step_system``; its status."""
        clock = time.perf_counter()
        status = assembly.step_system(
            self.elements, self._numbering, _motion(state), self._start, step, averaged, delta,
            loads, self.solver.storage, tangent, (self.mixed, *self.predicted), self.solver.values,
            self.residual, self._scratch)
        self.seconds.assembly += time.perf_counter() - clock
        return status

    def factorize(self):
        """Factorize the assembled matrix; how many pivots are negative, if the solver tells."""
        clock = time.perf_counter()
        negative = self.solver.factor()
        self.seconds.factorization += time.perf_counter() - clock
        return negative


def _motion(state):
    """The arrays of a state, as the kernels take them."""
    return (state.x, state.x_low, state.variables, state.chart, state.velocity, state.acceleration)


def scratch(n_nodes, n_directors):
    """Nodal work arrays of ``assembly.step_system``: dx, p_end, p_mid, A1, inertial accelerations
    of x and p, force on x, internal and inertial force on p, and the forces at both ends."""
    dx, a_x, force_x = (np.zeros((n_nodes, 3)) for _ in range(3))
    p_end, p_mid, a_p, force_p, rate_p = (np.zeros((n_directors, 3)) for _ in range(5))
    return (dx, p_end, p_mid, np.zeros((n_directors, 3, 3)), a_x, a_p, force_x, force_p, rate_p,
            np.zeros((2, n_directors, 3)))


def _supports(model, numbering):
    """Component of the normal that must stay a variable (n_nodes,), -1 for none, and fixed dofs.

    Two fixed components of a unit normal fix it altogether; a single one is kept as the first
    rotational variable of its node.
    """
    mask = model.fixed
    fixed = np.zeros(numbering.n_dof, dtype=bool)
    fixed_component = np.full(len(model.nodes), -1, dtype=np.int64)
    for i in np.flatnonzero(mask.any(axis=1)):
        first = numbering.start[i]
        fixed[first:first + 3] = mask[i, :3]
        components = np.flatnonzero(mask[i, 3:])
        if len(components) == 1:
            fixed_component[i] = components[0]
        fixed[first + 3:first + 3 + min(len(components), numbering.n_rot[i])] = True
    return fixed_component, fixed


def _load_patterns(model, numbering):
    """``{(history, kind): pattern}``: dead forces (kind 0), moments (1) and pressures (2)."""
    shapes = (numbering.n_dof, (len(model.nodes), 3), len(model.quads))
    patterns = {}

    def pattern(history, kind):
        return patterns.setdefault((history, kind), np.zeros(shapes[kind]))

    for load in model.loads:
        if isinstance(load, Pressure):
            elements = slice(None) if load.elements is None else list(load.elements)
            pattern(load.history, 2)[elements] += load.pressure
        elif isinstance(load, NodalMoment):
            pattern(load.history, 1)[load.node] += load.moment
        else:
            first = numbering.start[load.node]
            pattern(load.history, 0)[first:first + 3] += load.force
    return patterns
