"""Constraints in a step, solved for together with its increment, and impulses at both its ends,
see ``multipliers``.

With the columns ``Z = K^-1 G_m^T`` and the derivative D of g at the end of the step,

    (D Z + C) dl = D K^-1 r + g,   d = K^-1 r - Z dl,

C the compliance of moments, zero of constraints.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular

from ..checks import TINY
from ..errors import InputError
from ..kernels import hinges, multipliers
from ..kernels.arguments import DONE, link_work
from ..kernels.calls import Call
from .driven import INSTANT, slope
from .failure import NotConverged
from .linked import Linked

SETTLED = 1e-13
"""Part of the energy that the last correction of a drive's moment may change its work by."""

FLAT = 1e-8
"""The same where a correction is no smaller than the one before: below it that is rounding
(measured: up to 6e-10), above it where the next is no smaller either, as of slow drives."""

FIRST = 1e-3
"""Length of a step [s] of which the rates of drives at its start are asked for."""

JUMP = 1e-9
"""Angle [rad] by which a drive may begin off its joint."""

ROUNDED_TURN = 1e-13
"""Angle [rad] that rounding may leave of one that a drive begins with: that of ``1 - cos(6 t)`` at
1e-7 s has three digits."""

RATES = 1e-9
"""Part of the rates of single nodes by which initial velocities may violate a constraint."""

ROUNDED = 1e-13
"""The same of the fastest nodes, what rounding leaves in a constraint along which none moves."""

LEAST = 1e-12
"""Stiffness of a moment, in those of inertia, below which it is a given one."""


class Rates(NamedTuple):
    """What drives do in a step.

    Attributes:
        start: (k,) angles at its start [rad].
        angle: (k,) at its end [rad].
        before: (k,) their rates at its start [rad/s].
        after: (k,) at its end [rad/s].
    """

    start: np.ndarray
    angle: np.ndarray
    before: np.ndarray
    after: np.ndarray


class StepLinks(Linked):
    """As ``Linked``, in a step; moments are constraints that give way: ``-l = M(angle)``."""

    def __init__(self, system, frames):
        super().__init__(system, frames)
        self._work = work = link_work(self._links, self._hard, self._n_dof)
        self._u, self._d, self.forces, self.off = work.u, work.d, work.forces, work.off
        self._G_0, self._G_1, self._G_m, self._D = work.G_0, work.G_1, work.G_m, work.D
        self._root_0, self._root_1 = work.root_0, work.root_1
        self._leave, self._missed = Call(multipliers.leave), Call(multipliers.rates_missed)
        self._balance, self._backward = Call(multipliers.rates_end), Call(multipliers.backward)
        self._split = Call(multipliers.split)
        self._of_drives = slice(self._m, self._hard)
        self._moves = np.isin(self.dofs, system.translations)

    @property
    def drives(self):
        """Numbers of the joints that are driven."""
        return self.owners[self._of_drives]

    def driven(self, at, start, end):
        """``Rates`` of drives in a step from ``start`` to ``end`` [s]; ``at(time)`` gives
        ``value(history)``."""
        def angles(time):
            value = at(time)
            return np.array([joint.angle * value(joint.driving) for joint in self._driven])

        h = INSTANT * abs(end - start)
        return Rates(angles(start), angles(end), *(slope(angles, time, h)
                                                   for time in (start, end)))

    def check_rates(self, state, start, driven):
        """Raise ``InputError`` for initial velocities that constraints do not allow, and for drives
        that begin elsewhere; ``start``: ``Start`` of the state; ``driven``: ``Rates`` of a step
        that begins there."""
        self.begin(state, start)
        jumps = driven.start - state.hinges[self._places[:len(self._driven)], hinges.ANGLE]
        if np.any(far := np.abs(jumps) > JUMP):
            k = int(np.argmax(far))
            raise InputError(f"{self._names()[self.drives[k]]}: angle times driving begins "
                             f"{jumps[k]:g} rad off the angle that the joint has at the start")
        speeds = np.abs(state.velocity[self.dofs])
        rates, sizes = self._G_0 @ state.velocity[self.dofs], np.abs(self._G_0) @ speeds
        fastest = np.where(self._moves, speeds[self._moves].max(initial=0.0),
                           speeds[~self._moves].max(initial=0.0))
        turning = rates[self._m:].copy()
        rates[self._m:] -= driven.before
        sizes[self._m:] += np.abs(driven.before) + np.abs(driven.after)
        missed = np.abs(rates) - RATES * sizes - ROUNDED * (np.abs(self._G_0) @ fastest)
        # what a difference over ``INSTANT`` misses of a rate that begins with t^2, and by rounding
        missed[self._m:] -= INSTANT**2 * np.abs(driven.after - driven.before)
        missed[self._m:] -= ROUNDED_TURN / (INSTANT * FIRST)
        k = int(np.argmax(missed))
        if missed[k] > 0.0:
            name, drive = self._names()[self.owners[k]], k - self._m
            if drive >= 0:
                raise InputError(f"{name}: its drive begins at {driven.before[drive]:g} rad/s, the "
                                 f"initial velocities turn it at {turning[drive]:g} rad/s: let it "
                                 "begin from rest, or give what it joins that spin "
                                 "(rigid_velocity)")
            raise InputError(f"{name}: the initial velocities of what it joins do not fit together "
                             "(rigid_velocity gives those of a rigid motion)")

    def _miss_angles(self, state, step, driven, slacks, motors):
        """By how much the angles of drives, and moments, are missed."""
        if not len(self._places):
            return
        n, places, work = len(self._driven), self._places, self._work
        before = state.hinges[places, hinges.ANGLE]
        angle = before + work.change
        self.off[self._of_drives] = angle[:n] - driven.angle
        work.way[:] = driven.angle - before[:n]
        places, found = places[n:], np.empty((len(places) - n, 2))
        if len(places):
            self._moments(self._turnings.constants[places], state.hinges[places], slacks[places],
                          angle[n:], 1.0 - step.alpha_f, step.per_step, found)
            stiffness = np.maximum(found[:, 1], LEAST * self._stiff(step))
            work.give[self._hard:] = 1.0 / stiffness
            self.off[self._hard:] = -(found[:, 0] + motors[places]
                                      + self.forces[self._hard:]) / stiffness

    def _rates_end(self, rates, driven):
        """Take n by which ``G_1 v_1`` is what drives want, of ``rates`` (n_local,) without
        impulses."""
        self._check_pivot(
            self._balance(self._links, self._mobile, rates, driven.after, self._work))

    def _check_pivot(self, lost):
        if lost != DONE:
            raise NotConverged("joints hold the same twice")

    def _impulses(self):
        """(hard,) multipliers of the rates at both ends, ``L^-T n``."""
        before, after = self._work.n.copy(), self._work.n.copy()
        self._backward(self._root_0, before)
        self._backward(self._root_1, after)
        return before, after

    def _works(self, delta, driven, before, after):
        """Works of the ``drives`` in a step [J], of its impulses ``before`` and ``after``, too."""
        drives = self._of_drives
        return (-self.forces[drives] * (self._G_m[drives] @ delta[self.dofs])
                + self._rates_0 * before[self._m:] - driven.after * after[self._m:])

    def _stiff(self, step):
        """(k,) what inertia has for a stiffness against the moments [N m/rad]."""
        return step.delta / np.maximum(np.diag(self._mobility(self._D[self._hard:])), TINY)

    def _mobility(self, G):
        """``G M^-1 G^T``"""
        return G @ self._mobile @ G.T

    def take_columns(self, solve_rows):
        """Take the columns ``K^-1 G_m^T``; ``solve_rows`` overwrites residuals (m, n_dof) with
        corrections."""
        columns, here = self._work.columns, self._work.here
        columns[:] = 0.0
        columns[:, self.dofs] = self._G_m
        for column in columns:
            column[:] = self._free(column)
        solve_rows(columns)
        here[:] = columns[:, self.dofs]

    def split(self, turning, carried, correction):
        """Change the multipliers for a ``correction`` (n_dof,) without them, and that by what they
        take off; ``turning``: of the matrix, if it is ``carried``.

        Raises:
            NotConverged: joints hold the same twice.
        """
        self._check_pivot(self._split(self._links, turning, carried, correction, self._work))

    def keep_rates(self, state, wanted):
        """Take rates of a ``state`` by which its constraints are kept where supports have taken
        theirs, those of drives ``wanted`` (k,) [rad/s]; impulses (n_dof,) by which supports hold
        those that it takes."""
        self._end_at(state)
        self._missed(self._links, self._mobile, state.velocity[self.dofs], wanted, self._work)
        impulse = solve_triangular(self._root_1, self._work.n, lower=True)
        self._backward(self._root_1, impulse)
        impulse = self._G_1.T @ impulse
        state.velocity[:] -= self._pushed(impulse)
        return self._held_back @ impulse

    def settle(self, state, delta, driven):
        """Rates of a ``state`` at the end of a converged step that keep the constraints; the works
        of the ``drives`` in it [J]."""
        self._end_at(state)
        self._rates_end(state.velocity[self.dofs], driven)
        before, after = self._impulses()
        state.velocity[:] -= self._pushed(self._G_1.T @ after, self._G_0.T @ before)
        return self._works(delta, driven, before, after)

    def on(self, number):
        """Force [N] and moment about the origin [N m], (3,) each, of the joint ``number`` on its
        end ``other``, or on ``one`` where the other is the ground.  Means of the step of the
        iterate whose forces were added last: of the multipliers at its middle, and of the impulses
        at both ends."""
        force, moment = np.zeros((2, 3))
        for f, when in self._acting(self.owners == number):
            for i in self._end_of(number):
                own = f[self._local[i] + np.arange(3)]
                force += own
                moment += np.cross(self._place_of(i, when), own) + self._torque(i, f, when)
        return force, moment

    def torques(self):
        """(n_nodes, 3) of all joints on nodes, means of the step [N m]."""
        found = np.zeros((len(self._local), 3))
        for f, when in self._acting(np.ones(len(self.owners), dtype=bool)):
            for i in self._nodes:
                found[i] += self._torque(i, f, when)
        return found

    def _forces_of(self, rows):
        """Forces (n_local,) of some rows, means of the step: of multipliers, and of the impulses at
        its start and its end."""
        rate, hard = self._rate, rows[:self._hard]
        first, last = self._impulses()
        return (-self._G_m.T @ (rows * self.forces), rate * (self._G_0.T @ (hard * first)),
                -rate * (self._G_1.T @ (hard * last)))

    def late(self):
        """(n_dof,) forces by which supports hold the impulses beside those in the residual, which
        has twice that of the start of the step."""
        first, last = self._impulses()
        return self._rate * (self._held_back @ (self._G_0.T @ first + self._G_1.T @ last))

    def settled(self, energy):
        """Whether the work of drives is, for an ``energy`` of the motion [J], or gets no better.

        What is left of the residual does no work where constraints stay, but on what a drive moves.
        """
        change, last, before = self._work.drive
        whole = energy + np.abs(self.forces[self._of_drives] @ self._work.way)
        flat = change > 0.5 * last and (change <= FLAT * whole or last > 0.5 * before)
        return change <= SETTLED * whole or flat

    def pass_on(self, parts):
        """Add to sizes of forces (n_dof,), whose rounding error the residual has, what joints carry
        of them to other ends, as to bodies, which have no stiffness of their own."""
        G = np.abs(self._G_m)
        largest = (G * parts[self.dofs]).max(axis=1, initial=0.0)
        parts[self.dofs] += (largest / np.maximum(np.sum(G * G, axis=1), TINY)) @ G
