"""Every quick verification case, asserted; and the command that runs them all."""

import json
from dataclasses import replace
from functools import partial

import pytest

from corovec.verification.case import OK, Case, Row, small
from corovec.verification.helpers import corovec
from corovec.verification.mutants import deviating_rows
from corovec.verification.registry import CASES, make_report, run_case
from corovec.verification.suites import mutants

LONG = {"discrete-jacobian", "element-derivatives", "exact-conservation", "hemisphere-shear",
        "hinge-work", "joint-conservation", "linked-conservation", "order-in-time", "spin",
        "spin-global"}
"""Quick cases that take 3 to 20 seconds."""


@pytest.mark.parametrize("case", [pytest.param(case, id=case.name, marks=[
    pytest.mark.slow] * (case.name in LONG)) for case in CASES if not case.slow])
def test_case(case):
    """No row deviates without an explanation."""
    rows = list(case.run())
    assert rows
    wrong = [f"{row.name}: {row.value:g} against {row.reference:g}, {row.verdict}"
             for row in rows if row.verdict not in OK]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("mutant", (*mutants.ELEMENT, *mutants.SCHEME, *mutants.EXACT,
                                    *mutants.JOINTS, *mutants.MODES), ids=lambda m: m.name)
def test_mutants_fit_the_source(mutant):
    """The text that a mutant replaces is there, and its killers exist."""
    compile(mutant.source(), mutant.file, "exec")
    assert mutant.killers and set(mutant.killers) <= {case.name for case in CASES}


def test_a_mutant_is_caught():
    """One of them here; `corovec verify mutants` runs them all."""
    mutant = next(m for m in mutants.ELEMENT if m.killers == ("thick-beam",))
    assert deviating_rows(mutant, "thick-beam") == 1


def yielded(n):
    """Rows of a case that yields them."""
    for k in range(n):
        yield small(f"row {k}", 0.0, 1e-9, "rounding")


def test_a_case_may_yield_its_rows():
    """All are there however often they are read, and an error on the way ends the case."""
    case = Case("yields", "own", "nothing", "own", "nothing", partial(yielded, 3))
    outcome = run_case(case)
    assert outcome.deviations == 0 and len(outcome.rows) == 3
    rows = make_report([outcome], "2000-01-01", True)["cases"][0]["rows"]
    assert [row["name"] for row in rows] == ["row 0", "row 1", "row 2"]
    assert "TypeError" in run_case(replace(case, run=partial(yielded, None))).error


def test_names_are_unique():
    names = [case.name for case in CASES]
    assert len(set(names)) == len(names)
    assert not set(names) & {case.suite for case in CASES if case.suite not in ("patch",)}


@pytest.mark.parametrize("value, options, verdict", [
    (1.0, {}, "match"), (1.0 + 1e-9, {}, "deviates (open)"),
    (1.01, {"tolerance": 0.02}, "within tolerance"),
    (1.03, {"tolerance": 0.02}, "deviates (open)"),
    (1.03, {"tolerance": 0.02, "explanation": "known"}, "deviates (open)"),
    (1.03, {"tolerance": 0.02, "explanation": "known", "covers": 0.04}, "deviates (explained)"),
    (1.05, {"tolerance": 0.02, "explanation": "known", "covers": 0.04}, "deviates (open)"),
    (1.5, {"tolerance": 0.02, "target": 2.0}, "better"),
    (2.0, {"above": True}, "bound met"), (0.5, {"above": True}, "deviates (open)"),
    (1.0, {"tolerance": 1e-6}, "match"), (1.0 + 1e-8, {"tolerance": 1e-6}, "within tolerance"),
    (1.004, {"tolerance": 0.005, "digits": True}, "match"),
    (1.004, {"tolerance": 0.005, "uncertainty": 0.002}, "deviates (open)"),
    (1.004, {"tolerance": 0.005, "uncertainty": 0.002, "explanation": "dt", "covers": 0.007},
     "deviates (explained)"),
    (1.0009, {"rests_on": "selected"}, "selected"), (1.0, {"rests_on": "calibrated"}, "calibrated"),
    (1.0011, {"rests_on": "selected"}, "deviates (open)"), (1.0, {"rests_on": "assumed"}, "match"),
    (1.0009, {"rests_on": "selected", "uncertainty": 2e-4}, "deviates (open)"),
    (1.0009, {"rests_on": "selected", "scale": 1.0}, "deviates (open)"),
    (float("nan"), {"tolerance": 9.0}, "deviates (open)"),
])
def test_verdicts(value, options, verdict):
    """Each verdict, and that a wrong value gets a bad one."""
    row = Row("x", value, 1.0, "analytic", **{"tolerance": 1e-12, "reason": "test", **options})
    assert row.verdict == verdict


@pytest.mark.slow
def test_command(tmp_path):
    path = tmp_path / "verdicts.json"
    done = corovec("verify", "patch-finite", "--output", str(path))
    assert done.returncode == 0 and "deviate without explanation" in done.stdout
    report = json.loads(path.read_text())
    assert report["cases"][0]["rows"][0]["verdict"] == "within tolerance"
    assert "end-shear" in corovec("verify", "--list").stdout
    wrong = corovec("verify", "patchwork")
    assert wrong.returncode == 2 and "neither a case nor a suite" in wrong.stderr
