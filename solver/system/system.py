"""The discrete system of a model: forces and matrix at an iterate, observation of a state."""

import numpy as np

from ..kernels import assembly, observation
from ..kernels.arguments import (
    DONE,
    MASS_ONLY,
    WHOLE,
    Dofs,
    Predicted,
    Residual,
    nodal_work,
)
from ..kernels.calls import Call
from ..kernels.hinges import SLACK
from ..model.mesh import vector_areas
from ..runtime import compiling  # noqa: F401 (it listens)
from . import springs
from .bodies import TurningBodies
from .constrained import constrained
from .coordinates import Charts
from .damping import Viscous
from .driven import Driven
from .failure import NotConverged
from .joints import EndPlaces, Hinges, JointForces
from .linear import UnsymmetricLU, make_solver, solve_mass
from .loads import Applied, DeadLoads, Iterate, NormalCouples, at_time, check_acting, items
from .numbering import number_dofs
from .reactions import Reactions, Resultant, Supported, along
from .rounding import EPS
from .state import blank_place
from .threads import Team, shares, whole
from .turning import Turnings

ROUNDOFF = 4.0 * EPS
"""Relative rounding error of a strain; see ``System.roundoff_work``."""


class System:
    """A model made ready for the kernels: elements, loads and coordinates with a linear solver.

    Attributes:
        model: the ``Model``.
        elements: ``arguments.Elements``.
        numbering: ``Numbering``.
        coordinates: ``Charts``.
        dofs: ``arguments.Dofs``.
        solver: linear solver, see ``system.linear``; its matrix is that of the last iterate.
        residual: ``arguments.Residual`` of the last iterate.
        all_dead: whether all loads are forces of constant direction.
        damping: ``Viscous``, or None.
        turnings: ``Turnings``, moments of joints.
        hinges: ``Hinges`` that have one.
        bodies: ``Bodies``, rigid ones.
        linked: ``Linked``, constraints of joints and bodies, None where there are none.
        driven: ``Driven``, the motion of the supports.
        supported: whether supports, springs to the ground or the neighbours of a sector hold
            anything.
        sprung: whether there are springs between nodes or to the ground.
        floating: whether nothing holds the shell: no support, no spring to the ground.
        translations: (n_nodes, 3) dofs of the displacements.
        nodal_mass: (n_nodes,) lumped masses [kg].
        lengths: (n_dof,) 1 of a displacement, the shell's size [m] of a rotational variable: their
            products are of one unit.
        nodal: ``arguments.NodalWork`` of the last iterate.
        inner_forces: (n_dof,) of springs and damping in the last iterate.
        factorizations: how many there have been, by which a kept one is known.
    """

    exact = False
    kind_of_bodies = TurningBodies

    def __init__(self, model, solver="auto", follow=True, full_tangent=False, threads=1):
        """``follow``: see ``Charts``; ``full_tangent``: with the skew part of the loads' stiffness,
        where they have one; ``threads``: as many at most assemble and, with RSLAB, solve."""
        self.model, self.elements = model, model.elements
        self._items, self._springs = items(model, self.exact), springs.items(model)
        self._turning, self.turnings = springs.TurningSprings(model), Turnings(model)
        self.hinges = Hinges(model, self.turnings)
        self.bodies, self.linked = self.kind_of_bodies(model), None
        n_rot = np.where(np.diff(model.directors.first) == 1, 2, 3)
        folding = [item for item in (self.hinges, self.bodies) if item]
        cells = [item.cells for item in (*self._items, *self._springs, *folding)]
        beside = [(group[0], other) for group in model.joined for other in group[1:]]
        cells += [np.array(beside)] if beside else []  # joined nodes are numbered side by side
        self.numbering = number_dofs((model.quads, *cells), n_rot)
        self.bodies.number(self.numbering)
        self.coordinates = self._make_coordinates(follow)
        fixed, constraints = self.coordinates.fixed, self.coordinates.constraints
        held = bool(fixed.any()) or constraints is not None and constraints.holds
        self.supported = held or model.grounded
        self.dofs = Dofs(self.coordinates.nodes, fixed, bool(fixed.any()))
        self.driven = Driven(model, self.numbering, self.coordinates)
        self._supported = Supported(model, self.numbering, fixed)
        self._joint_forces = JointForces(model, self._supported.joined)
        self._end_places = EndPlaces(model)
        self._hinges_held = bool(np.isin(self.hinges.cells, self._supported.held).any())
        self._dead = DeadLoads(model, self.numbering, self._turning.forces)
        self.all_dead = not (self._items or self._dead.any_moment)
        self.solver = self._make_solver(solver, full_tangent and not self.all_dead, threads)
        self.factorizations, self.floating = 0, not model.grounded
        self.translations = self.numbering.translations
        self.damping = Viscous(model, self.translations) if model.damping else None
        self.nodal_mass = model.nodal_mass
        self._mass = float(self.nodal_mass.sum())
        self.lengths = np.full(self.numbering.n_dof, model.size)
        self.lengths[self.translations] = 1.0
        self.residual = Residual(*np.zeros((3, self.numbering.n_dof)))
        self._inner = bool(self._springs or self.damping or self.hinges or self.bodies
                           or model.linked)
        self._turned, self.sprung = 0.0, bool(self._springs)
        self.inner_forces, self._ground_forces = np.zeros((2, self.numbering.n_dof))
        self._observe, self._resultant = Call(observation.observe), Call(observation.resultant)
        self._make_kernels(threads)
        self._unpredicted = self.predictions(used=False)
        area = np.linalg.norm(vector_areas(model.nodes[model.quads]), axis=1)
        self._stretch_energy = float(np.sum(model.youngs * model.thickness * area))

    def _make_coordinates(self, follow):
        """What the unknowns are."""
        return Charts(self.model, self.numbering, follow)

    def _make_solver(self, name, unsymmetric, threads):
        """What the matrix is assembled into and solved by."""
        constraints = self.coordinates.constraints
        if constraints:
            return constrained(self.numbering, constraints.T, unsymmetric)
        if unsymmetric:
            return UnsymmetricLU(self.numbering)
        return make_solver(name, self.numbering, threads)

    def _make_kernels(self, threads):
        """What assembles, and its work arrays."""
        self._step, self._whole = Call(assembly.step_system), whole(self.model)
        several = shares(self.model, self.numbering, threads)
        self._team = Team(several) if several else None
        self.nodal = nodal_work(len(self.model.nodes), len(self.model.normals))

    def start(self, start=None):
        """State at t = 0: the configuration and velocities of the model, or of ``start``; U_ddot is
        zero.

        Warns:
            UserWarning: no load does anything.

        Raises:
            InputError: a supported component has an initial velocity.
        """
        check_acting(self.model)
        state = self.coordinates.initial_state(self.model, start)
        state.hinges[:, SLACK] = self.turnings.slacks(at_time(0.0))
        return state

    def initial_state(self, start=None, accelerations=True):
        """The same with U_ddot from Eq. (55), for a motion, where they are wanted."""
        state = self.start(start)
        if not accelerations:
            return state
        place = self.observe(state)
        self.assemble(state, place, MASS_ONLY, np.zeros(self.numbering.n_dof), self.loads(0.0))
        if np.any(self.residual.balance):
            state.acceleration[:] = solve_mass(self.solver, self.residual.balance)
            state.acceleration[:] = self.free(state.acceleration)
        return state

    def loads(self, time, start=None, end=None):
        """``Applied`` loads at a time [s], of a step from ``start`` to ``end`` [s], that time if
        left out."""
        if end is None:
            return self.loads_by(at_time(time))
        driven = self.linked and self.linked.driven(at_time, start, end)
        return self.loads_by(at_time(time), at_time(end), driven)

    def loads_by(self, value, at_end=None, driven=None):
        """``Applied`` loads with ``value(history)`` for each function of time, of joints' springs
        ``at_end(history)``."""
        return Applied(self._dead.at(value), tuple(item.at(value) for item in self._items),
                       self.turnings.motors(value), self.turnings.slacks(at_end or value), driven)

    def work_of_supports(self, delta):
        """Work of the reactions in the increment ``delta`` that was assembled last [J]."""
        return float((self.residual.balance - self.residual.unmasked) @ delta)

    def free(self, vector):
        """A vector (n_dof,) without what supports hold of it."""
        return self.coordinates.free(vector)

    def factorize(self):
        """Factorize the matrix of the last iterate.

        Returns:
            How many pivots are negative, None if the solver does not tell.

        Raises:
            SingularMatrix: a pivot is zero or not finite.
        """
        self.factorizations += 1
        return self.solver.factor()

    def observe(self, state, place=None):
        """``Place`` of a state: what a step from it starts with, energies and momenta.

        Args:
            state: ``State``.
            place: a ``Place`` to be filled instead of a new one.

        Raises:
            NotConverged: a normal has left its chart.
        """
        if place is None:
            place = blank_place(self.elements, len(self.model.normals))
        self.coordinates.place(state, place.start)
        place.observed = self._observe(
            self.elements, self.nodal_mass, state.motion, self.coordinates.velocity(state),
            place.start)
        if self.bodies:
            place.observed = self.bodies.observed(place.observed, state, place.start)
        if self.hinges:
            self.hinges.follow(state, place.start.p)
        if self.linked:
            self.linked.follow(state, place.start)
        if self._springs or self.turnings:
            stored = self._turning.energy(place.start.p) + self.turnings.energy(state)
            stored += sum(spring.energy(state) for spring in self._springs)
            place.observed = place.observed._replace(strain=place.observed.strain + stored)
        return place

    def energies_of_springs(self, state, place, single=True):
        """Energies of springs between nodes [J], of each or of all, and of those to the ground."""
        found, ground = [], self._turning.energy(place.start.p)
        for spring in self._springs:
            if spring.grounded:
                ground += spring.energy(state)
            else:
                found = [*spring.energies(state)] if single else [spring.energy(state)]
        grounded = any(spring.grounded for spring in self._springs)
        return [*found, ground] if grounded else found

    def lost_in_springs(self, before, state, dt):
        """(n,) what the damper of each spring between nodes took in a step of length dt [s] between
        two states [J]."""
        return np.concatenate([np.zeros(0), *(spring.lost(before, state, dt)
                                              for spring in self._springs if not spring.grounded)])

    def predictions(self, used=True):
        """Room for ``arguments.Predicted`` strains."""
        n_elem, n_s = len(self.model.quads), self.elements.l.shape[1]
        return Predicted(used, np.zeros((n_elem, 11)), np.zeros((n_elem, n_s)))

    def assemble(self, state, place, step, delta, loads, *, averaged=False, tangent=True,
                 predicted=None):
        """Residual and matrix of the iterate ``delta``, see ``assembly.step_system``.

        Args:
            state: ``State`` at the start of the step.
            place: its ``Place``.
            step: ``arguments.Factors``.
            delta: (n_dof,) increment.
            loads: ``Applied``.
            averaged: whether T is the average of both ends.
            tangent: whether the matrix is wanted.
            predicted: ``arguments.Predicted`` strains of a mixed tangent.

        Raises:
            NotConverged: a normal leaves the chart of its rotational variables.
        """
        dead = loads.dead
        delta = np.ascontiguousarray(delta, dtype=float)
        if self._items or self._inner:
            iterate = self._iterate(state, place, step, delta)
            self.inner_forces[:] = self._ground_forces[:] = 0.0
            for spring in self._springs:
                spring.add_forces(self.dofs, iterate, self._ground_forces if spring.grounded
                                  else self.inner_forces)
            if self.damping:
                self.damping.add_forces(iterate, self.inner_forces if self.floating
                                        else self._ground_forces)
            if self.hinges:
                self.hinges.add_forces(self.dofs, iterate, place.start.p, self.nodal.p_end,
                                       loads.motors, loads.slacks, self.inner_forces)
            if self.bodies:
                self.bodies.add_forces(iterate, self.nodal, self.inner_forces)
            if self.linked:
                self.linked.add_forces(iterate, loads.driven, loads.slacks, loads.motors,
                                       self.nodal, self.inner_forces)
            self.inner_forces += self._ground_forces
            dead = dead._replace(forces=dead.forces + self.inner_forces)
            for item, values in zip(self._items, loads.items, strict=True):
                item.add_forces(self.dofs, iterate, values, dead.forces)
        lost = self._assemble(state, place, step, delta, dead, averaged, tangent, predicted)
        if lost != DONE:
            raise NotConverged(self.coordinates.lost(lost))
        if self.coordinates.constraints:
            self.residual.balance[:] = self.coordinates.constraints.project(self.residual.balance)
        if tangent and (self._springs or self.hinges or self.bodies or self.linked
                        or not self.all_dead):
            self._add_items(Iterate(state, step, delta, self.nodal.p_mid, self.nodal.A1), loads)

    def _assemble(self, state, place, step, delta, dead, averaged, tangent, predicted):
        """Residual and matrix of the shell and the dead loads; a node that fails."""
        arguments = (
            self.elements, self.dofs, state.motion, place.start, step, averaged, delta, dead,
            self.solver.storage, tangent, predicted or self._unpredicted, self.solver.values,
            self.residual, self.nodal)
        if self._team is None:
            return self._step(*arguments, self._whole, WHOLE)
        self.residual.applied[:] = dead.forces
        if tangent:
            self.solver.values[:] = 0.0
        lost = self._team.run(lambda share, part: self._step(*arguments, share, part))
        self.residual.balance[:] = np.where(self.dofs.fixed, 0.0, self.residual.unmasked)
        return lost

    @property
    def _placing(self):
        """Whether something needs the nodes of an iterate before it is assembled."""
        return bool(self._items or self.hinges or self.bodies or self.linked)

    def _iterate(self, state, place, step, delta):
        """``Iterate`` with the normals at the generalized midpoint."""
        if self._placing:
            self.coordinates.advance(state, place.start, step, delta, self.nodal)
        return Iterate(state, step, delta, self.nodal.p_mid, self.nodal.A1)

    def applied(self, loads):
        """(n_dof,) generalized forces of the loads in the iterate that was assembled last."""
        if self.all_dead:
            return loads.dead.forces
        return self.residual.applied - self.inner_forces

    def reactions(self, state, place, step, loads, averaged=False):
        """``Reactions`` of the iterate that was assembled last, of the same arguments; forces and
        moments are those of the generalized midpoint.  Springs to the ground, and damping of a
        shell that is held, are among them."""
        work = self.nodal
        x = state.x + (1.0 - step.alpha_f) * work.dx
        moments = loads.dead.moments
        if self._hinges_held:
            moments = moments + self.hinges.torques(work.p_mid, work.A1)
        found = self._supported.reactions(
            self.residual, self._moments_on_normals(place, averaged), work.p_mid, x, moments)
        if self.linked:
            found = self._with_joints(found, x)
        if not self._inner:
            return found
        forces = self._ground_forces[self.translations]
        moments = np.add.reduceat(np.cross(work.p_mid, loads.dead.on_normals),
                                  self.model.directors.first[:-1]) + self._turned
        return Reactions(found.forces + forces, found.moments + moments,
                         found.force + forces.sum(axis=0),
                         found.moment + (np.cross(x, forces) + moments).sum(axis=0))

    def _with_joints(self, found, x):
        """``Reactions`` with what joints hold to the ground, and by which supports at positions x
        (n_nodes, 3) hold joints."""
        at, first = self._supported.held, self.model.directors.first
        moments = np.zeros_like(x)
        moments[at] = -self.linked.torques()[at]
        smooth = at[self.numbering.n_rot[at] == 2]
        moments[smooth] -= along(moments[smooth], self.nodal.p_mid[first[smooth]])
        forces = self.linked.late()[self.translations]
        force, moment = self.linked.ground()
        return Reactions(found.forces + forces, found.moments + moments,
                         found.force + force + forces.sum(axis=0),
                         found.moment + moment + (np.cross(x, forces) + moments).sum(axis=0))

    def hurried(self, rates, held, before, after):
        """``Reactions``, as impulses [N s, N m s], of moving supports that change their rates at
        once, by ``rates`` (n_dof,): those on nodes are of lumped masses, and by which supports hold
        joints, ``held`` (n_dof,); the resultants are the changes of the momenta from one
        ``Observation`` to another."""
        own = self.nodal_mass[:, None] * rates[self.translations]
        if self.linked:
            own += held[self.translations]
        return Reactions(own, np.zeros(self.model.nodes.shape),
                         after.linear_momentum - before.linear_momentum,
                         after.angular_momentum - before.angular_momentum)

    def joints(self, state, place):
        """(n_joints, 7) force of every joint [N], on the plate of the first nodes, or as of
        ``Multipliers.on``, moment about its axis and, of one with ends, moment about its place on
        the same end [N m], of the iterate that was assembled last, of a step from ``state``."""
        found = np.zeros((len(self.model.joints), 7))
        found[:, :3] = self._joint_forces(self._supported.of_joints(self.residual))
        if self.hinges:
            n = len(self.hinges.moments)
            found[:, 3] = np.bincount(self.turnings.joints[:n], self.hinges.moments, len(found))
        if self.linked:
            x = state.x + state.x_low
            places = self._end_places(np.stack([x, x + self.nodal.dx]),
                                      np.stack([place.start.p, self.nodal.p_end]))
            found[:, 3] += self.linked.about_axes()
            owners = self.linked.owners
            for number in np.unique(owners[owners < len(found)]):
                found[number, :3], moment = self.linked.on(number)
                found[number, 4:] = moment - np.cross(places[number], found[number, :3])
        return found

    def _moments_on_normals(self, place, averaged):
        """(n, 3) ``p x f`` of the internal and inertial forces f on the normals that
        ``Supported.directors`` names, of the iterate that was assembled last [N m]."""
        work, at = self.nodal, self._supported.directors
        p, rates = work.p_mid[at], work.rate_p[at]
        if self.bodies:
            rates = rates + self.bodies.rates(work)[at]
        if not averaged:
            return np.cross(p, work.force_p[at] + rates)
        return np.cross(p, rates) + sum(
            np.cross(normals[at], of[at])
            for normals, of in zip((work.p_end, place.start.p), work.ends_p))

    def forces_of_springs(self, state, start, motion):
        """Changes (n_dof,) of the forces of springs by a small ``motion`` (n_dof,) from ``state``.
        Those of the ground are among the next ``reactions``."""
        change, self._turned = self._turning.linear(self.dofs.nodes, start, motion)
        if self.hinges:
            change += self.hinges.linear(self.dofs, state, motion)
        for spring in self._springs:
            forces = spring.linear(state, motion[self.translations])
            change[self.translations] += forces
            if spring.grounded:
                self._ground_forces[self.translations] += forces
        self.inner_forces += change
        return change

    def resultant_of_loads(self, state, step, delta, loads):
        """``Resultant`` of the loads at the generalized midpoint of an increment; but for dead
        forces alone of the iterate that was assembled last, of the same arguments."""
        total = self._resultant(self.numbering.start, state.x, delta, 1.0 - step.alpha_f,
                                self.applied(loads))
        force, moment = total[:3], total[3:]
        if not self.all_dead:
            moment += loads.dead.moments.sum(axis=0)
            for item in self._items:
                if isinstance(item, NormalCouples):  # its forces have these moments
                    p = self.nodal.p_mid[self.model.directors.first[item.nodes]]
                    moment -= along(loads.dead.moments[item.nodes], p).sum(axis=0)
        return Resultant(force, moment)

    def _add_items(self, iterate, loads):
        """Matrices of the items, and the skew part of moments."""
        solver, step, storages = self.solver, iterate.step, iter(self.solver.storages[1:])
        solver.skew[:] = 0.0
        for item, values in zip(self._items, loads.items, strict=True):
            item.add_matrix(self.dofs, iterate, values, next(storages), solver.values, solver.skew)
        for spring in self._springs:
            spring.add_matrix(self.dofs, iterate, next(storages), solver.values, solver.skew)
        if self.hinges and step.stiffness:
            self.hinges.add_matrix(self.dofs, next(storages), solver.values, solver.skew)
        if self.bodies:
            self.bodies.add_matrix(self.solver.storage, iterate, solver.values)
        if solver.skew.size:
            assembly.add_moment_skew(self.dofs, solver.storage, iterate.state.chart, step.stiffness,
                                     loads.dead.moments, self.nodal, solver.skew)

    def inside(self, state, place, step, delta):
        """Whether every normal is still in its chart at the end of the increment ``delta``."""
        return self.coordinates.inside(state, place.start, step, delta, self.nodal)

    def nodal_normals(self, place):
        """(n_nodes, 3) normals; at a junction that of its first plate."""
        return place.start.p[self.model.directors.first[:-1]]

    def displacement(self, state):
        """(n_nodes, 3) displacements since t = 0 [m]."""
        return state.x - self.model.nodes + state.x_low

    def at_node(self, state, node):
        """Displacement since t = 0 [m] and velocity [m/s] of a node, (3,) each."""
        return (state.x[node] - self.model.nodes[node] + state.x_low[node],
                state.velocity[self.translations[node]])

    def mean_velocity(self, observed):
        """Rates (n_dof,) of the translation of a free shell with its mass centre; zero of one with
        supports."""
        rates = np.zeros(self.numbering.n_dof)
        if self.floating:
            rates[self.translations] = observed.linear_momentum / self._mass
        return rates

    def inner_kinetic(self, observed):
        """Kinetic energy less that of the translation with the mass centre, of a free shell [J]."""
        if not self.floating:
            return observed.kinetic
        momentum = observed.linear_momentum
        inner = observed.kinetic - 0.5 * float(momentum @ momentum) / self._mass
        return max(inner, EPS * observed.kinetic)

    def roundoff_work(self, kinetic):
        """Work of a residual that is rounding error alone: (4 eps)^2 (sum E h A + 2 T), T the
        ``kinetic`` energy at the start of the step.

        Strains are differences of numbers of order one, so their rounding error is a few eps and
        its energy eps^2 E V; smaller works cannot be told from zero and end the iteration.
        """
        return ROUNDOFF**2 * (self._stretch_energy + 2.0 * kinetic)
