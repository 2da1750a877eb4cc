"""Newton's iteration of one time step (Eqs. 61-67), with a new matrix in every iteration as in the
paper, or with one factorization for many of them."""

import math
import time
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..kernels.arguments import Factors
from ..system.failure import NotConverged
from ..system.linear import NOT_TOLD
from ..system.loads import Applied
from ..system.reactions import NOTHING, Reactions, Resultant
from ..system.state import Place, State

MAX_DAMPINGS = 4
"""How often a correction is halved when it would leave the chart of a normal."""

REST = 4.0
"""Times the kinetic energy about the mass centre: the work that undoes a start at rest, where the
velocities are those of a rigid motion.  A start with the rates that takes more to undo is left for
one at rest."""

KEPT_TOLERANCE = 1e-12
"""A kept matrix goes on until the work ratio to be expected after the last correction is this times
the tolerance, but not below ``LEAST_RATIO``: as far as Newton's iteration, whose last correction
squares the ratio, gets by the paper's rule.  (Measured on a stiff plate that flips over: with 1e-8
energy drifts by 1e-4 in 2000 steps, and the second order in dt is lost.)"""

LEAST_RATIO = 1e-18
"""Work ratio at which residuals are 1e-9 of the first: no rule asks for more."""


@dataclass
class Seconds:
    """Wall-clock seconds by phase.

    Attributes:
        assembly: of residuals and matrices.
        factorization: of matrices.
        solve: of corrections.
        total: of all steps.
    """

    assembly: float = 0.0
    factorization: float = 0.0
    solve: float = 0.0
    total: float = 0.0

    @property
    def rest(self):
        """What is none of the phases [s]."""
        return self.total - self.assembly - self.factorization - self.solve


@dataclass
class StepRecord:
    """What happened in one step of the time grid: sums over its parts if it was halved.

    Attributes:
        iterations: corrections.
        work_ratio: the final cc, Eq. (67), of the last part.
        switches: changes to other global axes.
        halvings: how often it was halved.
        indefinite: matrices with negative pivots; ``NOT_TOLD`` where the solver does not tell.
        impulses: ``Reactions`` times the length of the step; None of a shell without supports.
        loads: ``Resultant`` of the loads times the length of the step.
        joints: (n_joints, 7) impulses of ``System.joints``, where they are asked for.
        turned: (n_joints, 2) work of motors, servos and drives, and what dampers took [J].
        sprung: (n,) what the dampers of springs between nodes took [J].
        parts: of an adaptive step.
        rejected: parts that were taken back.
        local_error: the largest of a part [sizes of the shell].
    """

    iterations: int = 0
    work_ratio: float = 0.0
    switches: int = 0
    halvings: int = 0
    indefinite: int = 0
    impulses: Reactions | None = None
    loads: Resultant = NOTHING
    joints: np.ndarray | float = 0.0
    turned: np.ndarray | float = 0.0
    sprung: np.ndarray | float = 0.0
    parts: int = 1
    rejected: int = 0
    local_error: float = 0.0

    def add(self, part):
        """Add the record of a part that was accepted."""
        self._add_effort(part)
        self.parts += 1
        self.work_ratio = part.work_ratio
        self.switches += part.switches
        self.loads = self.loads.plus(part.loads, 1.0)
        self.joints = self.joints + part.joints
        self.turned = self.turned + part.turned
        self.sprung = self.sprung + part.sprung
        if part.impulses:
            self.impulses = part.impulses.plus(self.impulses, 1.0) if self.impulses else (
                part.impulses)

    def reject(self, part):
        """Count what a part took that was taken back."""
        self._add_effort(part)
        self.rejected += 1

    def _add_effort(self, part):
        self.iterations += part.iterations
        self.halvings += part.halvings
        if NOT_TOLD in (self.indefinite, part.indefinite):
            self.indefinite = NOT_TOLD
        else:
            self.indefinite += part.indefinite

    def count(self, negative):
        """Count a matrix with ``negative`` negative pivots, None where the solver does not tell."""
        if negative is None:
            self.indefinite = NOT_TOLD
        elif negative:
            self.indefinite += 1


class RatesMislead(NotConverged):
    """The increment is sought from a start at rest instead."""


class Problem(NamedTuple):
    """The equations of one step.

    Attributes:
        state: ``State`` at its start.
        place: ``Place`` of that.
        step: ``arguments.Factors``.
        dt: its length [s].
        loads: ``Applied`` at the generalized midpoint.
        averaged: whether T is the average of both ends.
        driven: (n_dof,) increment of what supports move, None where they do not.
    """

    state: State
    place: Place
    step: Factors
    dt: float
    loads: Applied
    averaged: bool
    driven: np.ndarray | None


class Iteration:
    """Newton's iteration on a system.

    Attributes:
        seconds: ``Seconds``, added to.
        kept: ``KeptMatrix``.
        always_made: whether it is told of every matrix, also of one that is not to be kept.
    """

    always_made = False

    def __init__(self, system, kept):
        self.system, self.kept = system, kept
        self.seconds = Seconds()

    def forget(self):
        """Drop what is kept between steps."""
        self.kept.forget()

    def increment(self, problem, rule, record):
        """The increment (n_dof,) of a step: from the rates, from a start at rest, with a new matrix
        each time; arguments and errors of ``solve``."""
        try:
            return self.solve(problem, rule, record)
        except RatesMislead:
            try:
                return self.solve(problem, rule, record, at_rest=True)
            except NotConverged:
                pass
        except NotConverged:
            pass
        return self.solve(problem, rule.full, record, at_rest=True)

    def solve(self, problem, rule, record, *, at_rest=False):
        """The increment of a step.

        It starts from dt U_dot or, ``at_rest``, from no more than dt times the mean velocity of a
        free shell.  Membrane vibrations far faster than the step are never damped; their rates say
        nothing of what comes, but undoing dt times them may take many times the energy of the
        motion, and then it is by that work that Eq. (67) would measure when to end.

        Args:
            problem: ``Problem``.
            rule: ``Newton``.
            record: ``StepRecord``, added to.
            at_rest: see above.

        Returns:
            (n_dof,) increment.

        Raises:
            RatesMislead: the first correction does more work than one from a start at rest.
            NotConverged: the reason why there is no increment.
        """
        system, kept = self.system, self.kept
        new = not (rule.keep and kept.serves(problem.step))
        if not new:
            kept.carry(problem.state, problem.place)
        if system.linked:
            system.linked.begin(problem.state, problem.place.start)
        observed = problem.place.observed
        floor = system.roundoff_work(observed.kinetic)
        velocity = system.mean_velocity(observed) if at_rest else problem.state.velocity
        delta = problem.dt * velocity
        correction = delta.copy()
        if problem.driven is not None:
            correction = system.free(delta)
            delta = correction + problem.driven
        first = last = 0.0
        made = -1
        for k in range(0 if at_rest else 1, rule.max_iterations + 1):
            delta = self._assemble(problem, delta, correction, new)
            if new:
                self._factorize(problem, rule.keep, record)
                made = k
            correction, work = self._correct()
            record.iterations += 1
            if (k == 1 and not at_rest and work > REST * system.inner_kinetic(observed) + floor
                    and np.any(delta)):
                raise RatesMislead(f"the rates take {work:.3g} J to undo")
            if first == 0.0:
                first = work
            elif k == 1:  # the start at rest was a prediction
                first = min(first, max(work, rule.tolerance * first))
            record.work_ratio = work / first if first > 0.0 else 0.0
            left = work / last if last > 0.0 else 1.0
            if left > 1.0 and made < 0:
                raise NotConverged("the matrix of an earlier step does not serve any more")
            delta = delta + correction
            wanted = _wanted(rule) * first
            ended = work <= floor or ends(rule, work, first, left, wanted, new)
            if k >= rule.least and ended and (not system.linked or (
                    system.linked.closed() and system.linked.settled(observed.kinetic))):
                if k - made > kept.patience:
                    kept.forget()
                if system.inside(problem.state, problem.place, problem.step, delta):
                    return delta
                raise NotConverged("a normal left its chart")
            new = not rule.keep or (k > 1 and kept.too_slow(k, work, wanted, left))
            last = work
        raise NotConverged(f"{rule.max_iterations} iterations reached cc = "
                           f"{record.work_ratio:.2g} instead of {rule.tolerance:.2g}")

    def _assemble(self, problem, delta, correction, tangent):
        """Residual, and matrix if wanted, at ``delta``; returns it, damped where a normal would
        leave its chart."""
        clock = time.perf_counter()
        try:
            for damping in range(MAX_DAMPINGS + 1):
                try:
                    self.system.assemble(
                        problem.state, problem.place, problem.step, delta, problem.loads,
                        averaged=problem.averaged, tangent=tangent)
                    return delta
                except NotConverged:
                    if damping == MAX_DAMPINGS:
                        raise
                correction = 0.5 * correction
                delta = delta - correction
        finally:
            self.seconds.assembly += time.perf_counter() - clock

    def _factorize(self, problem, keep, record):
        """Factorize the assembled matrix, and keep it for other steps if wanted."""
        clock = time.perf_counter()
        self.kept.forget()
        try:
            record.count(self.system.factorize())
        finally:
            self.seconds.factorization += time.perf_counter() - clock
        if keep or self.always_made:
            self.kept.made(problem.step, problem.state, problem.place)

    @staticmethod
    def _work(residual, correction):
        """By which an iteration is measured, Eq. (67) [J]."""
        return abs(float(residual @ correction))

    def _correct(self):
        """The correction for the residual, and its work, Eq. (67)."""
        clock = time.perf_counter()
        balance = self.system.residual.balance
        correction = self.kept.solve(balance)
        self.seconds.solve += time.perf_counter() - clock
        work = self._work(balance, correction)
        if not math.isfinite(work):
            raise NotConverged("the residual is not finite")
        return correction, work


def ends(rule, work, first, left, wanted, new):
    """Eq. (67): whether a correction is the last, with the work that it does, the first did, and
    the ratio to the one before; ``new``: whether it has its own matrix."""
    if not rule.keep or new:
        return work <= rule.tolerance * first
    return work * min(left, 1.0) <= wanted


def _wanted(rule):
    """Work ratio at which an iteration with a kept matrix ends."""
    return max(KEPT_TOLERANCE * rule.tolerance, LEAST_RATIO)
