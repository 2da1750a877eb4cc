"""Steps of a motion: each solved by Newton's iteration, halved where that fails."""

from ..errors import StepError
from ..system.failure import NotConverged
from .kept_matrix import KeptMatrix
from .newton import Iteration, Problem

MAX_HALVINGS = 10
"""A step is divided into at most 2^10 parts before the run gives up."""


class Stepper:
    """Moves states of a system by steps.

    Attributes:
        system: ``System``.
        iteration: ``Iteration``, with the seconds by phase.
    """

    def __init__(self, system, scheme, rule):
        """``scheme``: ``Scheme``; ``rule``: ``Newton``."""
        self.system, self._scheme, self._rule = system, scheme, rule
        self.iteration = Iteration(system, KeptMatrix(system))
        self._factors = {}

    def forget(self):
        """Drop what is kept between steps, so that the next one depends on its state alone."""
        self.iteration.kept.forget()

    def advance(self, state, place, time, dt, record, depth=0):
        """Move ``state`` and its ``place`` from ``time`` to ``time + dt`` [s].

        Args:
            state: ``State``.
            place: ``Place`` of it.
            time: start of the step [s].
            dt: its length [s].
            record: ``StepRecord``, added to.
            depth: how often the step has been halved.

        Raises:
            StepError: the step did not converge although halved ``MAX_HALVINGS`` times.
        """
        scheme = self._scheme
        loads = self.system.loads(time + (1.0 - scheme.alpha_f) * dt)
        if dt not in self._factors:
            self._factors[dt] = scheme.midpoint(dt), scheme.end(dt)
        problem = Problem(state, place, self._factors[dt][0], dt, loads,
                          scheme.transformation == "average")
        try:
            delta = self._solve(problem, record)
        except NotConverged as failure:
            if depth == MAX_HALVINGS:
                raise StepError(f"no convergence at t = {time:.9g} s with dt = {dt:.3g} s: "
                                f"{failure}") from None
            record.halvings += 1
            half = 0.5 * dt
            self.advance(state, place, time, half, record, depth + 1)
            self.advance(state, place, time + half, half, record, depth + 1)
            return
        self._accept(problem, time, delta, record)

    def _solve(self, problem, record):
        """The increment, with a new matrix in every iteration where a kept one does not serve."""
        if self._rule.keep:
            try:
                return self.iteration.solve(problem, self._rule, record)
            except NotConverged:
                pass
        return self.iteration.solve(problem, self._rule.full, record)

    def _accept(self, problem, time, delta, record):
        """End of a converged step: new state, work of the loads, new axes."""
        system, state, dt = self.system, problem.state, problem.dt
        applied = problem.loads.dead.forces
        if self._scheme.alpha_f != 0.5:
            applied = system.loads(time + 0.5 * dt).dead.forces
        if not system.all_dead:
            applied = applied + system.residual.applied - problem.loads.dead.forces
        system.coordinates.accept(state, self._factors[dt][1], delta)
        state.external_work += float(applied @ delta)
        record.switches += system.coordinates.renew(state, dt)
        system.observe(state, problem.place)
