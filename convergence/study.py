"""Which runs the convergence study of a case needs, and what follows from their histories.

Four questions, all about the energy after the loads are gone: does it converge with the mesh, does
the time step matter beside that, how long is it conserved, and what does rho_inf < 1 take from it.
"""

import tomllib
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

import numpy as np

from corovec import InputError, Newton, Scheme, Settings, total_energy
from corovec.benchmarks import load_case
from corovec.solver.checks import choice
from corovec.solver.dynamics.result import unloaded_row

from .rates import mesh_errors, step_limit
from .run import Run

PRINTED = Path(__file__).with_name("printed.toml")

FREE_FLIGHT = 1.2
"""Runs of the mesh and the temporal study end at this multiple of the unloading time."""

JUSTIFIED = 1.0 / 20.0
"""A time step is justified if halving it changes every energy by less than this part of its mesh
error: the change to the next finer mesh."""

DRIFT_TARGET = 1e-6
"""Energy drift whose time step is looked for."""

COARSEST = 50
"""Steps until unloading of the largest time step tried; the others are its halves."""

RHO_INF = (1.0, 0.9, 0.5)

CHECKPOINTS = 20
"""Checkpoints (and frames) of a run: an interruption costs at most this part of it."""

FRAMES = 10
"""Frames until unloading of a run whose motion is looked at."""

FLIGHT = Newton(tolerance=1e-10)
"""Newton's iteration in the drift study: what the default (1e-6) leaves over in every step adds
up (seen: angular momentum of the three plates, dt = 0.01 s, 6e-8 with 1e-6, 9e-10 with this)."""


@dataclass(frozen=True)
class Size:
    """How much is computed.

    Attributes:
        meshes: how many meshes at most, the coarsest, None for all.
        elements: meshes beyond the second have at most so many elements.
        steps: most steps until unloading in the temporal study.
        drift_steps: most steps until unloading in the drift study.
        mesh_work: elements times steps of a run of the mesh study.
        work: elements times steps of any other run.
        drift_levels: how many time steps the drift study compares.
        flight: end of the drift study as a multiple of the unloading time; None: the paper's.
        damped: part of that free flight which runs with rho_inf < 1 go along.
        paper_step: whether the mesh study takes the paper's time step.
    """

    meshes: int | None
    elements: float
    steps: int
    drift_steps: int
    mesh_work: float
    work: float
    drift_levels: int
    flight: float | None
    damped: float = 1.0
    paper_step: bool = False


SIZES = {
    "quick": Size(3, 5000, 400, 800, 5e5, 1.5e6, 3, 4.0, damped=0.5),
    "full": Size(None, np.inf, 1600, 6400, 2e6, 1e7, 4, None),
    "paper": Size(None, np.inf, 1600, 6400, np.inf, np.inf, 4, None, paper_step=True),
}


class CaseStudy:
    """The study of one case in one size.

    Its runs depend on results (the time step of the mesh study is halved until it is justified), so
    ``runs`` is asked again with the outcomes so far until it names nothing new.

    Raises:
        InputError: unknown case, size or membrane field, or a case whose loads never end.
    """

    def __init__(self, case, size="quick", membrane="stress"):
        self.definition = load_case(case)
        self.case = case
        self.size_name, self.size = choice("size", size, tuple(SIZES)), SIZES[size]
        self.membrane = membrane
        self.elements = [n for k, n in enumerate(self.definition.sizes[:self.size.meshes])
                         if k < 2 or n <= self.size.elements]
        self.unloaded_at = case_model(case, self.elements[0], membrane).unloaded_at
        if not np.isfinite(self.unloaded_at):
            raise InputError(f"case {case} is never unloaded: there is no energy after load "
                             "removal to study")

    @property
    def supported(self):
        """Whether the case has supports, so that its momenta are not conserved."""
        return bool(case_model(self.case, self.elements[0], self.membrane).supports)

    @property
    def paper_dt(self):
        """Time step of the paper [s]."""
        return self.definition.paper.dt.value

    @property
    def paper_time(self):
        """Simulated time of the paper [s]."""
        return self.definition.paper.time

    @cached_property
    def mesh_steps(self):
        """Time steps that the mesh study may take, falling: the first is only for comparison."""
        if self.size.paper_step:
            return [2.0 * self.paper_dt, self.paper_dt]
        largest = self.elements[-1] * FREE_FLIGHT
        return self._halves(self.size.mesh_work / largest)

    @cached_property
    def temporal_steps(self):
        """Time steps of the temporal study, falling, without the paper's if it is none of them."""
        affordable = self.size.work / (FREE_FLIGHT * self.elements[0])
        return self._halves(min(self.size.steps, affordable))

    @cached_property
    def drift_time(self):
        """End of the drift study [s]."""
        if self.size.flight is None:
            return self.paper_time
        return min(self.size.flight * self.unloaded_at, self.paper_time)

    @property
    def damped_time(self):
        """End of the runs with rho_inf < 1 [s]."""
        return self.unloaded_at + self.size.damped * (self.drift_time - self.unloaded_at)

    @cached_property
    def drift_steps(self):
        """Time steps of the drift study, falling; not the largest, which in long flights is so
        large (seen: the hemisphere) that the waves which appear need 20 iterations or halved steps.
        """
        affordable = self.size.work / (self.elements[0] * self.drift_time / self.unloaded_at)
        if self.size.paper_step:
            affordable = self.unloaded_at / self.paper_dt
        most = max(4 * COARSEST, min(self.size.drift_steps, affordable))
        steps = self._halves(most)[1:][-self.size.drift_levels:]
        return sorted({*steps, self.paper_dt}, reverse=True) if self.size.paper_step else steps

    def mesh_run(self, elements, dt):
        """``Run`` of the mesh study."""
        return self._run(elements, dt, FREE_FLIGHT * self.unloaded_at)

    def temporal_run(self, dt):
        """``Run`` of the study of the time step."""
        return self.mesh_run(self.elements[0], dt)

    def drift_run(self, dt, rho_inf=1.0):
        """``Run`` of a long flight."""
        end, frames = self.drift_time if rho_inf == 1.0 else self.damped_time, None
        if self.motion and rho_inf == 1.0:
            frames = round(FRAMES * self.drift_time / self.unloaded_at)
        return self._run(self.elements[0], dt, end, frames,
                         scheme=Scheme(rho_inf=rho_inf), newton=FLIGHT)

    @property
    def motion(self):
        """What the paper claims of the displacements (``printed.toml``); None if nothing."""
        return (printed_results(self.case) or {}).get("motion")

    @property
    def paper_run(self):
        """The paper's time step in the temporal study; None if it is too long for the size."""
        run = self.temporal_run(self.paper_dt)
        return run if run.work <= self.size.work else None

    def runs(self, outcomes):
        """Runs that are needed and not among ``outcomes`` (``{key: Outcome}``)."""
        levels = range(self.level(outcomes) + 1)
        needed = [self.mesh_run(n, self.mesh_steps[k]) for k in levels for n in self.elements]
        needed += [self.temporal_run(dt) for dt in self.temporal_steps]
        needed += [self.paper_run] if self.paper_run else []
        needed += [self.drift_run(dt) for dt in self.drift_steps]
        needed += [self.drift_run(self.drift_steps[0], rho) for rho in RHO_INF]
        return [run for run in needed if run.key not in outcomes]

    def level(self, outcomes):
        """Index of the time step of the mesh study: the first justified one, or the smallest
        allowed; a failed run asks for no smaller one."""
        for k in range(1, len(self.mesh_steps)):
            known = all(self.mesh_run(n, self.mesh_steps[j]).key in outcomes
                        for j in (k - 1, k) for n in self.elements)
            if not known or not np.any(self.step_changes(outcomes, k) >= JUSTIFIED):
                return k
        return len(self.mesh_steps) - 1

    def energies(self, outcomes, k):
        """Energy after unloading of every mesh at the k-th time step [J]; NaN for a failed run."""
        return np.array([unloaded_energy(outcomes[self.mesh_run(n, self.mesh_steps[k]).key])
                         for n in self.elements])

    def limit(self, outcomes, elements):
        """``Limit`` of the energy of a mesh as the time step goes to zero, and the smallest step:
        of the runs of the mesh study, or on the coarsest mesh of the study of the time step if that
        went farther; runs with halved steps have no single one and are left out."""
        steps = self.mesh_steps[:self.level(outcomes) + 1]
        if elements == self.elements[0] and self.temporal_steps[-1] < steps[-1]:
            steps = self.temporal_steps
        ended = [(dt, outcomes[self.mesh_run(elements, dt).key]) for dt in steps]
        whole = [(dt, unloaded_energy(outcome)) for dt, outcome in ended if not halved(outcome)]
        return step_limit([energy for _, energy in whole]), whole[-1][0] if whole else np.nan

    def step_changes(self, outcomes, k):
        """What halving the k-th time step would change at most, relative to the mesh errors (n,).

        Half of what halving to it has changed: the order in time is at least one.
        """
        fine, coarse = self.energies(outcomes, k), self.energies(outcomes, k - 1)
        with np.errstate(divide="ignore", invalid="ignore"):
            return 0.5 * np.abs(fine - coarse) / mesh_errors(fine)

    def _halves(self, most):
        """Time steps with 50, 100, and 200, 400... steps until unloading, as long as these are at
        most ``most``; one that is the paper's but for rounding is the paper's."""
        count = 1 + int(np.log2(max(most, 2 * COARSEST) / COARSEST))
        steps = [self.unloaded_at / (COARSEST * 2**k) for k in range(count)]
        return [self.paper_dt if np.isclose(dt, self.paper_dt, rtol=1e-9) else dt for dt in steps]

    def _run(self, elements, dt, end, frames=None, **settings):
        return case_run(self.case, elements, self.membrane, dt, round(end / dt) * dt,
                        frames or CHECKPOINTS, **settings)


@cache
def case_model(case, elements, membrane):
    """``Model`` of a mesh of a case."""
    return load_case(case).model(elements, membrane=membrane)


@cache
def case_run(case, elements, membrane, dt, end_time, frames, most_halvings=None, **settings):
    """``Run`` of a mesh of a case, with so many frames."""
    every = max(1, round(end_time / dt) // frames)
    settings = Settings(dt=dt, end_time=end_time, frame_every=every, **settings)
    return Run(case_model(case, elements, membrane), settings, case, most_halvings)


def run_studies(studies, campaign):
    """Outcomes of all runs that ``studies`` need, ``{key: Outcome}``."""
    outcomes = {}
    while needed := [run for study in studies for run in study.runs(outcomes)]:
        outcomes |= campaign.run(needed)
    return outcomes


@cache
def unloaded_energy(outcome):
    """Energy at the first step after the loads are gone [J]; NaN for a run that failed."""
    history = outcome.history
    if history is None:
        return np.nan
    return float(total_energy(history)[unloaded_row(history, outcome.run.model.unloaded_at)])


def halved(outcome):
    """Whether a run had to halve a step."""
    return outcome.history is not None and bool(outcome.history["halvings"].any())


def printed_results(case):
    """What the paper prints of ``case``, as strings (``printed.toml``); None if nothing."""
    with open(PRINTED, "rb") as file:
        return tomllib.load(file).get(case)
