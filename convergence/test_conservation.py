"""The study of conservation: what is tried, what becomes of a failure, what its bound tells."""

import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

from corovec import InputError, Scheme
from corovec.convergence import conservation
from corovec.convergence.cli import conserve
from corovec.convergence.conservation import (
    KEPT,
    SCHEMES,
    SECOND_ORDER,
    ConservationStudy,
    Plan,
    conservation_tables,
    holds,
    plans,
)
from corovec.convergence.study import run_studies
from corovec.solver.results.layout import DYNAMICS
from corovec.solver.runtime import execution
from corovec.solver.runtime.execution import Workers
from corovec.verification.case import OK

HERE = Workers(lambda: ThreadPoolExecutor(1), 2)

SHORT = Plan(elements=30, end_time=1.6, steps=(0.05, 0.02), drawn=0.02, frame=0.2, path=1.2,
             reference=0.02, schemes=("quasi", "exact", "dissipating"))


@pytest.fixture
def planned(monkeypatch):
    """The plan of the L-plate, and what it becomes."""
    made = {"l-plate": SHORT}
    monkeypatch.setattr(conservation, "plans", lambda size: made)
    return made


@pytest.fixture
def command(monkeypatch, tmp_path, planned):
    """``corovec conserve l-plate`` in this process: (exit code, tables)."""
    monkeypatch.setattr(execution, "processes", lambda jobs: HERE)

    def run(*options):
        result = CliRunner().invoke(conserve, ["l-plate", "--output", str(tmp_path), *options],
                                    catch_exceptions=False)
        study = json.loads((tmp_path / "quick" / "study.json").read_text(encoding="utf-8"))
        return result, study
    return run


def test_flights_of_the_l_plate(command):
    """The exact scheme keeps everything, quasi does not; a path beside itself is the same."""
    result, study = command()
    assert "exact: largest step held 0.05 s" in result.stdout
    assert {row["verdict"] for row in study["verdicts"] if row["kind"] != "converged"} <= set(OK)
    flights = {(row["scheme"], row["dt"]): row for row in study["flights"]}
    assert flights["quasi", 0.02]["path_error"] == 0.0
    assert 0.0 < flights["exact", 0.02]["path_error"] < flights["exact", 0.05]["path_error"] < 0.1
    assert flights["dissipating", 0.02]["energy_change"] < -1e-6
    assert flights["dissipating", 0.02]["energy_rise"] < 1e-12 < flights[
        "quasi", 0.02]["energy_rise"]
    (last,) = (row for row in study["energy"] if row["time"] == 1.6 and row["scheme"] == "quasi")
    assert last["energy_drift"] == pytest.approx(flights["quasi", 0.02]["energy_drift"], rel=1e-9)
    assert {row["scheme"]: row["of_paper"] for row in study["schemes"]}["exact"] == pytest.approx(
        500.0)


def test_its_bound_fails_for_quasi(command, planned, monkeypatch):
    """Quasi in the place of the exact scheme: three promises are broken but that of L."""
    planned["l-plate"] = replace(SHORT, steps=(0.02,), schemes=("exact",), path=0.0)
    monkeypatch.setitem(SCHEMES, "exact", Scheme())
    result, study = command()
    assert result.exit_code == 1
    assert [row["name"].split(",")[0] for row in study["verdicts"] if row["verdict"] not in OK] == [
        "exact: energy", "exact: angular momentum"]


@pytest.mark.filterwarnings("ignore::corovec.solver.errors.AccuracyWarning")
def test_a_failure_is_a_result(command, planned):
    """No step so large converges: it is told how far the flight came, and the rest goes on."""
    planned["l-plate"] = replace(SHORT, end_time=6.0, steps=(0.5, 0.1), frame=1.0, drawn=0.5,
                                 path=0.0, schemes=("trapezoidal",))
    result, study = command("--json")
    lost = next(row for row in study["flights"] if not row["holds"])
    assert lost["reached"] < 6.0 and "StepError" in lost["error"]
    assert json.loads(result.stdout)["flights"] == study["flights"]


def test_a_scheme_breaks_the_bound(command, planned):
    """The trapezoidal rule comes to its end unhalved, and does not hold the step."""
    planned["l-plate"] = replace(SHORT, end_time=4.0, steps=(0.05, 0.02), path=0.0,
                                 schemes=("trapezoidal",))
    fine, coarse = command("--json")[1]["flights"]
    assert fine["holds"] and fine["energy_drift"] < KEPT and coarse["halvings"] == 0
    assert not coarse["holds"] and coarse["reached"] == 4.0 and coarse["energy_drift"] > KEPT


@dataclass(eq=False)
class Formula:
    """An outcome with halved steps from a time step on, a failure from another, and energy that
    drifts by just more than the bound from a third."""

    run: object
    halved_from: float = np.inf
    failing_from: float = np.inf
    drifting_from: float = np.inf
    error, path = "", "nowhere.h5"

    @property
    def status(self):
        return "failed" if self.run.settings.dt >= self.failing_from else "finished"

    @property
    def history(self):
        dt, rows = self.run.settings.dt, np.zeros(100, dtype=DYNAMICS)
        rows["halvings"][1:] = dt >= self.halved_from
        rows["time"], rows["kinetic_energy"] = np.linspace(0.0, 2.0, 100), 1.0
        rows["kinetic_energy"][-1] += 1.01 * KEPT if dt >= self.drifting_from else 0.99 * KEPT
        return rows


@pytest.mark.parametrize("limits, tried", [
    ({}, [0.01, 0.02, 0.05, 0.1]), ({"halved_from": 0.05}, [0.01, 0.02, 0.05]),
    ({"failing_from": 0.02}, [0.01, 0.02]), ({"drifting_from": 0.02}, [0.01, 0.02]),
    ({"halved_from": 0.01}, [0.01])])
def test_steps_are_tried_until_one_does_not_hold(planned, limits, tried):
    planned["l-plate"] = replace(SHORT, steps=(0.1, 0.05, 0.02, 0.01), path=0.0)
    study = ConservationStudy("l-plate")
    campaign = SimpleNamespace(run=lambda runs: {run.key: Formula(run, **limits) for run in runs})
    outcomes = run_studies([study], campaign)
    assert study.tried("exact", outcomes) == tried
    assert holds(outcomes[study.run("exact", tried[0]).key]) == (len(tried) > 1)


@pytest.mark.parametrize("size", conservation.SIZES)
def test_plans_are_whole(size):
    """Frames and kinks of the loads are multiples of all steps, kinks but at a hundred times the
    paper's step; paths can be compared."""
    for case, plan in plans(size).items():
        study = ConservationStudy(case, size)
        steps = [*plan.steps, *([plan.reference] if plan.path else [])]
        unloaded = study.run("exact", plan.drawn).model.unloaded_at
        assert plan.drawn in plan.steps and unloaded < plan.end_time
        hundred = 100.0 * study.definition.paper.dt.value
        kinked = [dt for dt in steps if abs(dt / hundred - 1.0) > 1e-6]
        for interval, dts in ((plan.frame, steps), (0.5 * unloaded, kinked), (plan.path, steps),
                              (plan.end_time, steps)):
            assert all(abs(interval / dt - round(interval / dt)) < 1e-6 for dt in dts)
        if size == "full":
            assert plan.end_time == study.definition.paper.time
            assert set(SECOND_ORDER) <= set(plan.schemes)


def test_unknown_names_are_told():
    with pytest.raises(InputError, match="case"):
        ConservationStudy("nothing")
    with pytest.raises(InputError, match="size"):
        ConservationStudy("l-plate", "paper")


def test_tables_without_a_curve(planned):
    """A case of which nothing came, of which no file is there."""
    study = ConservationStudy("l-plate")
    missing = Formula(study.run("exact", 0.02), failing_from=0.0)
    outcomes = {study.run(name, dt).key: missing for name in SCHEMES for dt in SHORT.steps}
    tables = conservation_tables([study], outcomes)
    assert tables["energy"].empty and not tables["flights"]["holds"].any()
    assert set(tables["verdicts"]["verdict"]) == {"deviates (open)"}
