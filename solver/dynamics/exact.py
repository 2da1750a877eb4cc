"""Newton's iteration of a step of the exact scheme, to rounding error.

What a step conserves is conserved as far as its equations are solved, so the iteration goes on
until the work of a correction is that of rounded strains (``System.roundoff_work``).  It starts
without the velocities of the nodes: a conserving scheme never removes their fast part, and dt
times it leads far from what comes.
"""

from itertools import count

import numpy as np

from ..system.failure import NotConverged
from .krylov import minimal_residual
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

OWN = 3
"""Matrices of a step after which the derivative gives the corrections; the first iterations of a
step that begins with it that have a matrix of their own."""

SETTLED = 0.03
"""Part of the work that a correction may leave without a new matrix for the next one, where they
come from the derivative (measured: more, and hemispheres that crumple take twice the time)."""

NEAR, FEW_PRODUCTS, MOST_PRODUCTS = 0.01, 2, 20
"""Part of a correction that may be missing; products with the derivative for it up to which the
symmetric matrix alone serves the next step, and at most."""

SHIFT = 1e-7
"""Part of the shell's size by which nodes move for a product with the derivative (a difference)."""

LONGER, STEADY = 2, 0.5
"""Times ``max_iterations`` after which an iteration goes on only as long as each correction leaves
no more than that part of the work: at large turns a matrix without the derivative of the inertia
converges slowly, however short the step."""


class ExactIteration(Iteration):
    """Newton's iteration on an ``ExactSystem``.

    As long as a symmetric matrix, kept and turned, serves it gives the corrections.  Where it has
    to be made again and again in a step, they are those of the derivative, found by GMRES with that
    matrix before it; the next step goes on so unless few products were enough each time.  With
    multipliers the matrix alone gives them.
    """

    always_made = True

    def __init__(self, system, kept):
        super().__init__(system, kept)
        self._slow = False

    def forget(self):
        """Drop what is kept between steps."""
        super().forget()
        self._slow = False

    @staticmethod
    def _work(residual, correction):
        """Works of all unknowns, none negative: with matrices that are not definite their sum may
        vanish in the middle of an iteration (measured: one step in 6000 lost 8e-9 of its energy).
        """
        return float(np.abs(residual) @ np.abs(correction))

    def increment(self, problem, rule, record):
        """The increment (n_dof,) of a step: from a rigid motion, and where that fails with a new
        matrix each time and the derivative, from a rigid motion, from the increment of the last
        step; arguments and errors of ``solve``."""
        try:
            return self.solve(problem, rule, record)
        except NotConverged:
            self._slow = True
        try:
            return self.solve(problem, rule.full, record)
        except NotConverged:
            return self.solve(problem, rule.full, record, again=True)

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
            system.linked.begin(state, problem.place.start)
        new = not (rule.keep and kept.serves(problem.step))
        differs = not system.linked  # multipliers change with every solution
        stale, made, fresh, slow = not new and kept.stale, -1, 0, self._slow and differs
        first = last = 0.0
        slower, ended = 1.0, False
        own = products = most = 0
        for k in count():
            delta = self._assemble(problem, delta, correction, new)
            if new:
                self._factorize(problem, rule.keep, record)
                made, own = k, own + 1
            fresh = fresh + 1 if new or slow else 0
            if new or k <= TURNING:
                kept.carry(state, problem.place)
            correction, work = self._correct()
            record.iterations += 1
            if slow:
                correction, work, products = self._improved(problem, delta, correction, record)
                most = max(most, products)
            turn = system.coordinates.size_of_turn(correction)
            if turn > LARGEST_CORRECTION:
                correction = correction * (LARGEST_CORRECTION / turn)
            delta = delta + correction
            first = first or work
            record.work_ratio = work / first if first > 0.0 else 0.0
            left = work / last if last > 0.0 else 1.0
            # how fast it converges, the slower of two ratios tells: rigid parts vanish at once
            ended = (ended and k > 1) or work * min(max(left, slower), 1.0) <= floor or (
                fresh > 1 and left > STALLED and system.at_rounding(state, problem.step))
            if k and ended and (not system.linked or (
                    system.linked.closed() and system.linked.settled(observed.kinetic))):
                kept.stale = k - max(made, 0) > kept.patience
                if slow:
                    self._slow = most > FEW_PRODUCTS
                    self._assemble(problem, delta, correction, False)
                return delta
            if left > 1.0 and made < 0 and k > 2 and not slow:
                raise NotConverged("the matrix of an earlier step does not serve any more")
            if k + 1 >= LONGER * rule.max_iterations and left > STEADY:
                raise NotConverged(f"{k + 1} iterations left a work of {work:.2g} J instead of "
                                   f"{floor:.2g} J")
            if slow:
                new = (not rule.keep or k + 1 < OWN or left > SETTLED
                       or products > kept.patience)
            else:
                new = (not rule.keep or (stale and k == 0)
                       or (k > 1 and kept.too_slow(k, work, floor, left)))
                slow = new and own >= OWN and differs
            last, slower = work, left

    def _improved(self, problem, delta, correction, record):
        """A correction by the derivative itself, from that by the matrix, its work and how many
        products it took, each a difference of two residuals."""
        system, kept = self.system, self.kept
        balance, size = system.residual.balance.copy(), SHIFT * system.model.size

        def product(direction):
            shift = size / np.abs(system.lengths * direction).max()
            self._assemble(problem, delta + shift * direction, 0.0 * direction, False)
            return kept.solve((balance - system.residual.balance) / shift)

        correction, products = minimal_residual(product, correction, system.lengths, NEAR,
                                                MOST_PRODUCTS)
        record.iterations += products
        system.residual.balance[:] = balance
        return correction, self._work(balance, correction), products
