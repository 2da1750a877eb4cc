"""All verification cases, and the report of their verdicts."""

import time
from typing import NamedTuple

from corovec import InputError
from corovec.solver.runtime.provenance import machine, versions

from .case import KINDS, OK, Case
from .suites import (
    benchmarks,
    dynamics,
    exact,
    joints,
    junctions,
    kernel,
    linear,
    mutants,
    nonlinear,
    patch,
    rotations,
    sections,
    shear,
    stresses,
    vibration,
)

SUITES = (patch, kernel, linear, shear, stresses, sections, nonlinear, rotations, dynamics,
          exact, joints, junctions, vibration, benchmarks, mutants)
CASES = tuple(case for suite in SUITES for case in suite.CASES)


def find(names=(), quick=False):
    """Cases by the names of cases or suites; all without names.

    Raises:
        InputError: a name is neither a case nor a suite, or no case is left.
    """
    known = {case.name for case in CASES} | {case.suite for case in CASES}
    for name in names:
        if name not in known:
            raise InputError(f"'{name}' is neither a case nor a suite; corovec verify --list shows "
                             "them")
    cases = [case for case in CASES
             if (not names or case.name in names or case.suite in names)
             and not (quick and case.slow)]
    if not cases:
        raise InputError(f"{', '.join(names)}: slow cases only, without quick ones")
    return cases


class Outcome(NamedTuple):
    """What became of a case: its rows and seconds, or the error that ended it."""

    case: Case
    rows: list
    seconds: float = 0.0
    error: str | None = None

    @property
    def deviations(self):
        """Number of rows that deviate without an explanation."""
        return sum(row.verdict not in OK for row in self.rows)


def run_case(case):
    """``Outcome`` of a case, whatever it raises."""
    clock = time.perf_counter()
    try:
        rows, error = list(case.run()), None
    except Exception as raised:
        rows, error = [], describe(raised)
    return Outcome(case, rows, time.perf_counter() - clock, error)


def describe(error):
    """An exception in one line."""
    return f"{type(error).__name__}: {error}"


def make_report(outcomes, date, complete):
    """Machine-readable verdicts of some cases, and whether these are all that were asked for."""
    return {
        "date": date, "complete": complete, "versions": versions(), "machine": machine(),
        "kinds": KINDS,
        "cases": [{"name": case.name, "suite": case.suite, "claim": case.claim,
                   "source": case.source, "definition": case.definition, "seconds": seconds,
                   "error": error, "rows": [row.as_dict() for row in rows]}
                  for case, rows, seconds, error in outcomes]}
