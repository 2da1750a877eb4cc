"""Which scheme conserves what, up to which time step, and at what cost: the study of conservation.

Every scheme flies the same flights at the same time steps, from the smallest on, until one is too
large for it: a run that fails, or halves steps, is a result; one with more halvings than steps is
given up.  All iterate by the rule of ``Newton`` as it is by default, but for ``exact``, which goes
to rounding error.
"""

import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd

from corovec import ResultFileError, Scheme, read, total_energy
from corovec.benchmarks import load_case
from corovec.solver.checks import choice
from corovec.solver.dynamics.balance import RUN_SHARE
from corovec.solver.dynamics.result import unaccounted, unloaded_row
from corovec.verification.case import Row, at_least, small

from .study import case_run
from .tables import DRIFTS, drifts_of

PLAN = Path(__file__).with_name("conservation.toml")

SCHEMES = {"paper": Scheme(axes="global"), "quasi": Scheme(), "exact": Scheme(name="exact"),
           "dissipating": Scheme(name="exact", dissipation=0.1),
           "trapezoidal": Scheme(name="newmark"), "generalized-alpha": Scheme(rho_inf=0.8),
           "fourth-order": Scheme(name="exact", order=4)}
"""What is compared: the paper's scheme with its global axes, the same with axes that follow the
nodes, the exact one without and with (selective) dissipation, two that do not conserve, and the
exact one as five steps for one."""

SECOND_ORDER = tuple(SCHEMES)[:-1]
"""Those that are compared where a plan names none."""

HALVED = 1e-3
"""Part of the steps that may be halved at a time step that a scheme holds."""

KEPT = RUN_SHARE
"""Drift of energy and momenta from unloading to the end up to which a scheme holds a time step: the
part of its energy by which a run may be wrong before it is warned of."""

INSTANTS = 200
"""Instants at which the drift of the energy is kept for a figure."""

ROUNDING = 1e-10
"""Drift over a whole flight that rounding may make of what is conserved exactly: of up to 32 000
steps, each to some 1e-15 (seen: 8e-12)."""

TOLD_APART = 100.0 * ROUNDING
"""Least drift of a scheme that does not conserve, by which that bound tells the two apart."""

SAME_PATH = 0.5
"""Difference of the errors of two paths, relative to the larger, up to which they are the same:
what a step smaller by a third makes of an error of second order."""

MEASURED = (*DRIFTS, "energy_change", "energy_rise", "iterations_per_step", "halvings",
            "halved_share", "cpu_per_second", "path_error")
"""What is measured of a flight."""


@dataclass(frozen=True)
class Plan:
    """What is flown of a case in a size (``conservation.toml``).

    Attributes:
        elements: of the mesh.
        end_time: of the flights [s].
        steps: time steps, those that are tried [s].
        drawn: the one of the figure [s].
        frame: time between two frames, a multiple of all steps [s].
        path: time until which paths are compared [s], 0 for not at all.
        reference: small time step, with whose path [s].
        by: name of the scheme of that.
        schemes: names of ``SCHEMES``.
    """

    elements: int
    end_time: float
    steps: tuple
    drawn: float
    frame: float
    path: float = 0.0
    reference: float = 0.0
    by: str = "quasi"
    schemes: tuple = SECOND_ORDER


SIZES = ("quick", "full")


@cache
def plans(size):
    """``{case: Plan}`` of a size."""
    with open(PLAN, "rb") as file:
        return {case: Plan(**entry) for case, entry in tomllib.load(file)[size].items()}


class ConservationStudy:
    """The flights of one case in one size; a time step is tried if the next smaller one holds, so
    that ``runs`` is asked again with the outcomes so far until it names nothing new.

    Raises:
        InputError: unknown case or size, or a case that is not planned.
    """

    def __init__(self, case, size="quick"):
        self.size_name = choice("size", size, SIZES)
        self.case = choice("case", case, tuple(plans(size)))
        self.definition, self.plan = load_case(case), plans(size)[case]

    def run(self, scheme, dt):
        """``Run`` of a scheme of ``SCHEMES``."""
        return self._run(dt, self.plan.end_time, SCHEMES[scheme])

    @property
    def reference(self):
        """``Run`` with whose path the others are compared; None without."""
        plan = self.plan
        return self._run(plan.reference, plan.path, SCHEMES[plan.by]) if plan.path else None

    def tried(self, scheme, outcomes):
        """Time steps of a scheme, rising, until the first that it does not hold, or from the second
        on is not among ``outcomes`` yet."""
        tried = []
        for dt in sorted(self.plan.steps):
            tried.append(dt)
            outcome = outcomes.get(self.run(scheme, dt).key)
            if not holds(outcome) if outcome else len(tried) > 1:
                break
        return tried

    def runs(self, outcomes):
        """Runs that are needed and not among ``outcomes`` (``{key: Outcome}``)."""
        needed = [self.run(scheme, dt) for scheme in self.plan.schemes
                  for dt in self.tried(scheme, outcomes)]
        needed += [self.reference] if self.reference else []
        return [run for run in needed if run.key not in outcomes]

    def _run(self, dt, end_time, scheme):
        plan = self.plan
        return case_run(self.case, plan.elements, "stress", dt, end_time,
                        round(end_time / plan.frame), round(end_time / dt), scheme=scheme)


@cache
def holds(outcome):
    """Whether a run came to its end with at most ``HALVED`` of its steps halved and drifts of at
    most ``KEPT``."""
    if outcome.status == "failed":
        return False
    history = outcome.history
    drifts = drifts_of(history, outcome.run.model).values()
    return halved_share(history) <= HALVED and max(drifts) <= KEPT


def halved_share(history):
    """Part of the steps of a history that were halved."""
    return float(np.mean(history["halvings"][1:] > 0))


@cache
def reached(outcome):
    """Contents of the file of a run, of one that failed as far as its last frame; None if
    there is none."""
    try:
        contents = read(outcome.path)
    except ResultFileError:
        return None
    return contents if contents["step"] else None


def conservation_tables(studies, outcomes):
    """``{name: DataFrame}`` of everything that ``studies`` found: ``flights``, a row a run;
    ``energy``, the drift against time at one time step; ``schemes``, the largest step that each
    holds; ``verdicts``."""
    flights = pd.DataFrame([row for study in studies for row in _flights(study, outcomes)])
    tables = {
        "flights": flights,
        "energy": pd.DataFrame([row for study in studies for row in _curves(study, outcomes)],
                               columns=["case", "scheme", "dt", "time", "energy_drift"]),
        "schemes": pd.DataFrame([row for study in studies for row in _largest(study, flights)])}
    tables["verdicts"] = pd.DataFrame([{"case": study.case, **row.as_dict()} for study in studies
                                       for row in verdicts(study, tables)])
    return tables


def _flights(study, outcomes):
    """Every flight: how far it came, what it kept, how its steps went, what a second of it took,
    and its path beside that of the reference."""
    for scheme in study.plan.schemes:
        for dt in study.tried(scheme, outcomes):
            outcome = outcomes[study.run(scheme, dt).key]
            contents, settings = reached(outcome), outcome.run.settings
            row = {"case": study.case, "elements": outcome.run.elements, "scheme": scheme,
                   "dt": dt, "end_time": settings.end_time, "reached": 0.0,
                   "holds": holds(outcome), "error": outcome.error,
                   **dict.fromkeys(MEASURED, np.nan)}
            if contents:
                history, model = contents["history"], outcome.run.model
                flown = settings.end_time - outcome.begun_at * dt
                row |= {"reached": float(history["time"][-1]), **drifts_of(history, model),
                        **_energy(history, model.unloaded_at),
                        "iterations_per_step": float(history["iterations"][1:].mean()),
                        "halvings": int(history["halvings"].sum()),
                        "halved_share": halved_share(history),
                        "cpu_per_second": outcome.cpu / flown,
                        "path_error": _path_error(study, outcomes, contents)}
            yield row


def _energy(history, unloaded_at):
    """Change of the energy from unloading to the end, and its largest rise above what it was at any
    time before, both relative to that at unloading; NaN before."""
    first = unloaded_row(history, unloaded_at)
    if first is None:
        return {"energy_change": np.nan, "energy_rise": np.nan}
    energy = total_energy(history)[first:]
    rise = energy - np.minimum.accumulate(energy)
    return {"energy_change": energy[-1] / energy[0] - 1.0, "energy_rise": rise.max() / energy[0]}


def _path_error(study, outcomes, contents):
    """Largest distance of a node from where it is in the reference, at the frames until ``path``,
    relative to the largest displacement there; NaN without a reference or before that time."""
    end = study.plan.path
    if not end or contents["history"]["time"][-1] < end * (1.0 - 1e-9):
        return np.nan
    times, exact = outcomes[study.reference.key].frames
    own = np.searchsorted(contents["history"]["time"][contents["frame_steps"]], times - 1e-9)
    apart = np.linalg.norm(contents["displacement"][own] - exact, axis=2)
    return float(apart.max() / np.linalg.norm(exact, axis=2).max())


def _curves(study, outcomes):
    """Largest drift of the energy so far against time, at the time step that is drawn."""
    dt = study.plan.drawn
    for scheme in study.plan.schemes:
        if dt in study.tried(scheme, outcomes):
            outcome = outcomes[study.run(scheme, dt).key]
            contents = reached(outcome)
            first = contents and unloaded_row(contents["history"], outcome.run.model.unloaded_at)
            if first is not None:
                history = contents["history"][first:]
                left = unaccounted(history)
                drift = np.maximum.accumulate(np.abs(left - left[0])) / total_energy(history)[0]
                rows = np.unique(np.linspace(1, len(history) - 1, INSTANTS).round().astype(int))
                for time, value in zip(history["time"][rows], drift[rows]):
                    yield {"case": study.case, "scheme": scheme, "dt": dt, "time": time,
                           "energy_drift": value}


def _largest(study, flights):
    """The largest time step that each scheme holds, and the flight at it."""
    own = flights[flights["case"] == study.case]
    for scheme in study.plan.schemes:
        held = own[(own["scheme"] == scheme) & own["holds"]]
        best = held.loc[held["dt"].idxmax()].to_dict() if len(held) else {}
        yield {"case": study.case, "scheme": scheme, "largest_step": best.get("dt", np.nan),
               "of_paper": best.get("dt", np.nan) / study.definition.paper.dt.value,
               "larger_untried": bool(best) and best["dt"] == max(study.plan.steps),
               **{name: best.get(name, np.nan) for name in (
                   "energy_drift", "linear_momentum_drift", "angular_momentum_drift",
                   "iterations_per_step", "cpu_per_second")}}


def verdicts(study, tables):
    """``Row`` s of a study: what is promised, and what the schemes without the promise give."""
    flights = tables["flights"]
    flights = flights[flights["case"] == study.case]
    of = {name: flights[flights["scheme"] == name] for name in SCHEMES}
    where = f"{study.plan.end_time:g} s, all steps"
    kept = {f"{name} momentum": f"{name}_momentum_drift" for name in ("linear", "angular")}
    for scheme, names in (("exact", {"energy": "energy_drift", **kept}),
                          ("fourth-order", {"energy": "energy_drift", **kept}),
                          ("dissipating", {"energy and what is dissipated": "energy_drift",
                                           "energy, rise": "energy_rise", **kept})):
        for name, column in names.items() if len(of[scheme]) else ():
            yield small(f"{scheme}: {name}, {where}", of[scheme][column].max(skipna=False),
                        ROUNDING, "rounding of every step, at any step")
    for scheme in ("paper", "quasi", "trapezoidal", "generalized-alpha"):
        if len(of[scheme]):
            yield at_least(f"{scheme}: energy, {where}", of[scheme]["energy_drift"].min(),
                           TOLD_APART, "the bound of the exact scheme tells them apart")
    yield from _comparison(study, tables, of)


def _comparison(study, tables, of):
    """The steps that exact and quasi hold, and their paths at the same steps."""
    largest = tables["schemes"].query("case == @study.case").set_index("scheme")["largest_step"]
    if {"quasi", "exact"} <= set(largest.index):
        yield Row("largest step held [s], exact beside quasi", largest["exact"],
                  np.nan_to_num(largest["quasi"]), "baseline", 0.0, "no shorter one", above=True)
    paths = of["exact"].merge(of["quasi"], on="dt", suffixes=("", "_quasi"))
    for row in paths.dropna(subset=["path_error", "path_error_quasi"]).itertuples():
        yield Row(f"error of the path, exact beside quasi, dt = {row.dt:g} s", row.path_error,
                  row.path_error_quasi, "converged", SAME_PATH, "exactness buys no accuracy of "
                  "the path, and costs none", scale=max(row.path_error, row.path_error_quasi))
