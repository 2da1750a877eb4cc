"""What all timings share: the clock, rounds, a model advanced step by step, single solver calls.

CPU seconds decide (``time.process_time``), since other programs may share the machine; wall-clock
seconds are kept beside them.  Compilation comes first and is left out; LAPACK has one thread.
"""

import os
import time
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from corovec import Newton, Scheme, warm_up
from corovec.solver.dynamics import stepping as dynamics
from corovec.solver.dynamics.newton import StepRecord
from corovec.solver.runtime.provenance import commit, machine, usable_cores, versions

from .solvers import make_system


@dataclass(frozen=True)
class Effort:
    """How much is measured.

    Attributes:
        rounds: repetitions of every measurement.
        long_rounds: repetitions of single calls above ``LONG_CALL`` seconds.
        round_seconds: CPU seconds that a round may take; it does as many steps as fit, at least
            one, at most the table's 100 or 10.
        step_seconds: longest whole step of a dense solver; beyond, single calls are timed.
        call_seconds: longest single factorization; beyond, a smaller one is scaled by n^3.
        run_seconds: longest whole run; beyond, it is extrapolated from its steps.
        growth_unknowns: largest model of the growth study.
        reference: whether the L-plate's whole run is timed, which needs a long reference run.
    """

    rounds: int
    long_rounds: int
    round_seconds: float
    step_seconds: float
    call_seconds: float
    run_seconds: float
    growth_unknowns: int
    reference: bool


CALLS_SECONDS, MAX_CALLS = 0.1, 50
"""CPU seconds that the rounds of a short single call take together, and most of them."""

LONG_CALL = 1.0

SIZES = {"quick": Effort(3, 1, 0.1, 2.0, 10.0, 0.0, 90_000, False),
         "full": Effort(5, 3, 5.0, 60.0, 300.0, 100.0, 340_000, True)}


@dataclass(frozen=True)
class Sample:
    """Rounds of one measurement: CPU and wall-clock seconds of each."""

    cpu: tuple
    wall: tuple

    @property
    def median(self):
        """Median CPU seconds."""
        return float(np.median(self.cpu))

    def __add__(self, other):
        return Sample(self.cpu + other.cpu, self.wall + other.wall)

    def scaled(self, factor):
        """The same, ``factor`` times as long."""
        return Sample(tuple(factor * t for t in self.cpu), tuple(factor * t for t in self.wall))

    def row(self, prefix):
        """Entries of a table row: median (``_cpu``), minimum, quartiles and number of rounds of the
        CPU seconds, median of the wall-clock seconds."""
        entries = {"cpu": self.median, **extent(self.cpu), "wall": float(np.median(self.wall))}
        return {f"{prefix}_{name}": entry for name, entry in entries.items()}


def extent(rounds):
    """Minimum, lower and upper quartile (interpolated) and number of some rounds."""
    least, q1, q3 = np.quantile(rounds, (0.0, 0.25, 0.75)).tolist() if rounds else (None,) * 3
    return {"min": least, "q1": q1, "q3": q3, "rounds": len(rounds)}


def sample(work, rounds, prepare=None):
    """``Sample`` of ``work()``; ``prepare()`` runs before each round, unmeasured."""
    cpu, wall = [], []
    for _ in range(rounds):
        if prepare is not None:
            prepare()
        start, clock = time.process_time(), time.perf_counter()
        work()
        cpu.append(time.process_time() - start)
        wall.append(time.perf_counter() - clock)
    return Sample(tuple(cpu), tuple(wall))


class Stepper:
    """A model that advances step by step from rest, as ``simulate`` does.

    The production default (``auto``) keeps factorizations; all others are compared as in the paper,
    with a new matrix in each iteration.

    Attributes:
        system: ``System``.
        state: ``State`` reached.
        place: ``Place`` of it.
        done: steps so far.
        record: iterations and so on, in sum.
    """

    def __init__(self, model, dt, method="auto"):
        self.dt, self._scheme = dt, Scheme()
        newton = Newton("modified" if method == "auto" else "full")
        self.system = make_system(model, method)
        self._stepper = dynamics.Stepper(self.system, self._scheme, newton)
        self.state = self.system.initial_state()
        self.place = self.system.observe(self.state)
        self.record, self.done = StepRecord(), 0

    def steps(self, count=1):
        """Advance by ``count`` steps."""
        for _ in range(count):
            self._stepper.advance(self.state, self.place, self.done * self.dt, self.dt,
                                  self.record)
            self.done += 1

    def use(self, method):
        """Assemble for another linear solver from now on; the state cannot advance any more."""
        self.system = make_system(self.system.model, method)

    def forget(self):
        """Drop the factorization that is kept."""
        self._stepper.forget()

    @property
    def iterations(self):
        """Iterations a step, so far."""
        return self.record.iterations / self.done

    def assemble(self, tangent=True):
        """The matrix and residual of the first iterate of the next step."""
        time_ = (self.done + 1.0 - self._scheme.alpha_f) * self.dt
        self.system.assemble(self.state, self.place, self._scheme.midpoint(self.dt),
                             self.dt * self.state.velocity, self.system.loads(time_),
                             tangent=tangent)


@dataclass(frozen=True)
class Calls:
    """``Sample`` s of single calls: assembly, factorization, solution of one load."""

    assembly: Sample
    factor: Sample
    solve: Sample

    @property
    def iteration(self):
        """CPU seconds of one Newton iteration."""
        return self.assembly.median + self.factor.median + self.solve.median

    def step(self, iterations, rest):
        """``Sample`` of a step that is composed of them: ``iterations (assembly + factor +
        solve) + rest``, where ``rest`` [s] and ``iterations`` come from other steps."""
        def compose(clock):
            rounds = zip(*(getattr(call, clock) for call in (self.assembly, self.factor,
                                                             self.solve)))
            return tuple(iterations * sum(seconds) + rest for seconds in rounds)
        return Sample(compose("cpu"), compose("wall"))

    def row(self):
        """Entries of a table row."""
        return {name: entry for phase, call in vars(self).items()
                for name, entry in call.row(phase).items()}


def time_calls(stepper, effort):
    """``Calls`` at the stepper's state: rounds of each, of short ones as many as fit into
    ``CALLS_SECONDS``.  Filling the upper triangle of an unsymmetric solver counts as assembly."""
    system = stepper.system
    solver = system.solver
    stepper.assemble()
    matrix, rhs = solver.values.copy(), system.residual.balance.copy()
    stepper.forget()
    unsymmetric = hasattr(solver, "complete")

    def assemble():
        stepper.assemble()
        if unsymmetric:
            solver.complete()

    def restore():
        solver.values[:] = matrix
        if unsymmetric:
            solver.complete()

    def several(work, prepare=None):
        once = sample(work, 1, prepare)
        least = effort.long_rounds if once.median > LONG_CALL else effort.rounds
        most = int(np.clip(CALLS_SECONDS / max(once.median, 1e-9), least, MAX_CALLS))
        return once + sample(work, most - 1, prepare)

    return Calls(several(assemble),
                 several(solver.eliminate if unsymmetric else solver.factor, restore),
                 several(lambda: solver.solve(rhs)))


def single_thread():
    """Context in which LAPACK has one thread, the kernels compiled."""
    warm_up()
    return threadpool_limits(1)


def surroundings():
    """Versions, commit, machine, cores and load, to be kept with every result."""
    return {"versions": versions(), "commit": commit(), "machine": machine(),
            "cores": usable_cores(), "load": load()}


def load():
    """Mean number of programs running, over 1, 5 and 15 minutes; None where unknown."""
    return list(os.getloadavg()) if hasattr(os, "getloadavg") else None
