"""Newton's iteration of a step of the exact scheme, to rounding error.

What a step conserves is conserved as far as its equations are solved, so the iteration goes on
until the work of a correction is that of rounded strains (``System.roundoff_work``).  It starts
without the velocities of the nodes: a conserving scheme never removes their fast part, and dt
times it leads far from what comes.
"""

from itertools import count

import numpy as np

from ..system.failure import NotConverged
from .newton import Iteration

LARGEST_CORRECTION = 0.5
"""Turn of a node [rad] by one correction, which is shortened to it."""

STALLED = 0.3
"""Ratio of the works of two corrections, both with matrices of their own, from which the iteration
is at its floor, where the residual is rounding error.  (A kept matrix may stall far above it: 15 of
1000 random shells lost up to 2e-4 of their energy.)"""

TURNING = 1
"""Number of the last correction for which a kept matrix is turned anew (measured: later ones gain
nothing)."""

FLOOR = 1.0 / 64.0
"""Part of the work of rounded strains at which the iteration ends (measured: a larger one leaves a
drift ten times that of rounding, a smaller one is not reached); stiffness damping multiplies that
work by twice its weight of the strains at the end."""

GIVEN_UP = 3
"""Steps one after another in which kept matrices failed, from which they are not tried any more,
until the next checkpoint."""

LONGER, STEADY = 2, 0.5
"""Times ``max_iterations`` after which an iteration goes on only as long as each correction leaves
no more than that part of the work: at large turns a matrix without the derivative of the inertia
converges slowly, however short the step."""


class ExactIteration(Iteration):
    """Newton's iteration on an ``ExactSystem``."""

    always_made = True

    def __init__(self, system, kept):
        super().__init__(system, kept)
        self._failed = 0

    def forget(self):
        """Drop what is kept between steps."""
        super().forget()
        self._failed = 0

    @staticmethod
    def _work(residual, correction):
        """Works of all unknowns, none negative: with matrices that are not definite their sum may
        vanish in the middle of an iteration (measured: one step in 6000 lost 8e-9 of its energy).
        """
        return float(np.abs(residual) @ np.abs(correction))

    def increment(self, problem, rule, record):
        """The increment (n_dof,) of a step: from a rigid motion, and where that fails with a new
        matrix each time, from the increment of the last step, from a rigid motion; arguments and
        errors of ``solve``."""
        if rule.keep and self._failed < GIVEN_UP:
            try:
                found = self.solve(problem, rule, record)
                self._failed = 0
                return found
            except NotConverged:
                self._failed += 1
        try:
            return self.solve(problem, rule.full, record, again=True)
        except NotConverged:
            return self.solve(problem, rule.full, record)

    def solve(self, problem, rule, record, *, again=False):
        """The increment of a step.

        Args:
            problem: ``Problem``.
            rule: ``Newton``; its tolerance takes no part.
            record: ``StepRecord``, added to.
            again: whether it starts from the increment of the last step, not from a rigid motion.

        Returns:
            (n_dof,) increment.

        Raises:
            NotConverged: the reason why there is no increment.
        """
        system, kept = self.system, self.kept
        observed, state = problem.place.observed, problem.state
        floor = FLOOR * system.roundoff_work(observed.kinetic) * 2.0 * problem.step.strain_end
        delta = correction = system.coordinates.predict(
            system.nodal_mass, state, problem.place, problem.dt, system.floating,
            again and bool(state.acceleration.any()))
        if problem.driven is not None:
            delta = system.free(delta) + problem.driven
        if system.linked:
            system.linked.begin(state)
        new = not (rule.keep and kept.serves(problem.step))
        stale, made, fresh = not new and kept.stale, -1, 0
        first = last = 0.0
        slower = 1.0
        for k in count():
            delta = self._assemble(problem, delta, correction, new)
            if new:
                self._factorize(problem, rule.keep, record)
                made = k
            fresh = fresh + 1 if new else 0
            if new or k <= TURNING:
                kept.carry(state, problem.place)
            correction, work = self._correct()
            record.iterations += 1
            turn = system.coordinates.size_of_turn(correction)
            if turn > LARGEST_CORRECTION:
                correction = correction * (LARGEST_CORRECTION / turn)
            delta = delta + correction
            first = first or work
            record.work_ratio = work / first if first > 0.0 else 0.0
            left = work / last if last > 0.0 else 1.0
            # how fast it converges, the slower of two ratios tells: rigid parts vanish at once
            ended = work * min(max(left, slower), 1.0) <= floor or (
                fresh > 1 and left > STALLED and system.at_rounding(state, problem.step))
            if k and ended and (not system.linked or system.linked.closed()):
                kept.stale = k - max(made, 0) > kept.patience
                return delta
            if left > 1.0 and made < 0 and k > 2:
                raise NotConverged("the matrix of an earlier step does not serve any more")
            if k + 1 >= LONGER * rule.max_iterations and left > STEADY:
                raise NotConverged(f"{k + 1} iterations left a work of {work:.2g} J instead of "
                                   f"{floor:.2g} J")
            new = (not rule.keep or (stale and k == 0)
                   or (k > 1 and kept.too_slow(k, work, floor, left)))
            last, slower = work, left
