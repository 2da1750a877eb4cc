"""Steps of a motion: each solved by Newton's iteration, halved where that fails."""

import numpy as np

from ..errors import StepError
from ..kernels.hinges import SLACK
from ..system.damping import Dissipation, strains
from ..system.failure import NotConverged
from ..system.loads import Iterate, at_time
from ..system.reactions import no_reactions
from . import balance
from .exact import ExactIteration
from .kept_matrix import KeptMatrix, TurnedMatrix
from .newton import Iteration, Problem

MAX_HALVINGS = 10
"""A step is divided into at most 2^10 parts before the run gives up."""


class Stepper:
    """Moves states of a system by steps.

    Attributes:
        system: ``System``.
        iteration: ``Iteration``, with the seconds by phase.
    """

    def __init__(self, system, scheme, rule, joints=False):
        """``scheme``: ``Scheme``; ``rule``: ``Newton``; ``joints``: whether what joints do is asked
        for."""
        self._joints = joints
        self.system, self._scheme, self._rule = system, scheme, rule
        self.iteration = (ExactIteration(system, TurnedMatrix(system)) if scheme.exact
                          else Iteration(system, KeptMatrix(system)))
        self._dissipation = Dissipation(system.model, scheme) if scheme.dissipation else None
        self._factors = {}
        self._before = system.coordinates.blank_state(system.model)

    def forget(self):
        """Drop what is kept between steps, so that the next one depends on its state alone."""
        self.iteration.forget()

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
            StepError: the step did not converge although halved ``MAX_HALVINGS`` times, or energy
                and work have drifted apart.
        """
        scheme = self._scheme
        loads = self.system.loads(time + (1.0 - scheme.alpha_f) * dt, time, time + dt)
        if dt not in self._factors:
            midpoint = scheme.midpoint(dt)
            if self.system.damping:
                midpoint = self.system.damping.damped(midpoint, dt)
            self._factors[dt] = midpoint, scheme.end(dt)
        problem = Problem(state, place, self._factors[dt][0], dt, loads,
                          scheme.transformation == "average",
                          self.system.driven.increment(state, at_time(time + dt)))
        try:
            self._accept(problem, time, self.iteration.increment(problem, self._rule, record),
                         record)
        except NotConverged as failure:
            if depth == MAX_HALVINGS:
                raise StepError(f"no convergence at t = {time:.9g} s though the step was divided "
                                f"into {2**depth}, dt = {dt:.3g} s: {failure}") from None
            record.halvings += 1
            half = 0.5 * dt
            self.advance(state, place, time, half, record, depth + 1)
            self.advance(state, place, time + half, half, record, depth + 1)

    def start(self, state):
        """What a run that begins, or goes on, at ``state`` needs of the scheme."""
        if self._dissipation:
            self._dissipation.begin(state)

    def _accept(self, problem, time, delta, record):
        """End of a converged step: new state, work of the loads, new axes.

        Raises:
            NotConverged: energy came from nothing; the state is as it was.
        """
        system, state, place, dt = self.system, problem.state, problem.place, problem.dt
        reactions, driven, braked, hurried = None, 0.0, 0.0, None
        if system.supported or self._joints:
            self._assemble(problem, delta)
        if system.supported:
            reactions = system.reactions(state, place, problem.step, problem.loads,
                                         problem.averaged)
            driven = system.work_of_supports(delta)
            late = system.linked and system.linked.late()
        joints, done = self._joints and dt * system.joints(state, place), 0.0
        applied = system.resultant_of_loads(state, problem.step, delta, problem.loads)
        work = self._work(problem, time, delta)
        if system.damping:
            braked = system.damping.braked(Iterate(state, problem.step, delta))
        before, lost, sprung = place.observed, 0.0, 0.0
        damped = system.damping or self._dissipation
        measures = damped and strains(place.start)
        self._before.take(state)
        try:
            system.coordinates.accept(state, self._factors[dt][1], delta)
            drives = None
            if system.linked:
                drives = system.linked.settle(state, delta, problem.loads.driven)
                work += float(drives.sum())
                if system.driven.moving:
                    driven += dt * float(late @ state.velocity)
            switches = system.coordinates.renew(state, dt)
            if system.turnings:
                state.hinges[:, SLACK] = problem.loads.slacks
            system.observe(state, place)
            if system.driven.moving:
                found, rates = place.observed, state.velocity.copy()
                system.driven.set_rates(state, at_time, time + dt, dt)
                rates, held = state.velocity - rates, 0.0
                if system.linked:
                    held = system.linked.keep_rates(state, problem.loads.driven.after)
                system.observe(state, place)
                driven += place.observed.energy - found.energy
                hurried = system.hurried(rates, held, found, place.observed)
            if system.damping:
                lost = braked + system.damping.lost(problem.step, measures, place.start)
            if system.turnings:
                turned = system.turnings.turned(self._before, state, problem.loads.motors, dt)
                work, lost = work + float(turned.work.sum()), lost + float(turned.lost.sum())
                done = np.transpose([system.turnings.by_joint(values) for values in turned])
                if drives is not None:
                    done[system.linked.drives, 0] += drives
                system.turnings.latch(state)
            if self._dissipation:
                lost += self._dissipation.lost(state, measures, place.start)
            if system.sprung:
                sprung = system.lost_in_springs(self._before, state, dt)
                lost += float(sprung.sum())
            state.external_work += work
            state.support_work += driven
            state.dissipated += lost
            balance.settle(self._scheme, state, time + dt, before.energy, place.observed.energy,
                           work + driven - lost, system.roundoff_work(before.kinetic))
        except NotConverged:
            state.take(self._before)
            system.observe(state, place)
            raise
        record.switches += switches
        record.joints, record.turned = record.joints + joints, record.turned + done
        record.sprung = record.sprung + sprung
        record.loads = record.loads.plus(applied, dt)
        if reactions:
            impulses = record.impulses or no_reactions(len(state.x))
            record.impulses = impulses.plus(reactions, dt)
            if hurried:
                record.impulses = record.impulses.plus(hurried, 1.0)

    def _assemble(self, problem, delta):
        """The residual of a converged step, at its generalized midpoint."""
        self.system.assemble(problem.state, problem.place, problem.step, delta, problem.loads,
                             averaged=problem.averaged, tangent=False)

    def _work(self, problem, time, delta):
        """Work of the loads in a step [J], with their values at its middle."""
        system = self.system
        loads = problem.loads
        if self._scheme.alpha_f != 0.5:
            loads = system.loads(time + 0.5 * problem.dt, time, time + problem.dt)
            if not system.all_dead:
                system.assemble(problem.state, problem.place, problem.step, delta, loads,
                                averaged=problem.averaged, tangent=False)
        return float(system.applied(loads) @ delta)
