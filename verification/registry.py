"""All verification cases, and the report of their verdicts."""

from solver import InputError
from solver.provenance import machine, versions

from .case import KINDS
from .suites import dynamics, kernel, linear, nonlinear, patch

CASES = (*patch.CASES, *kernel.CASES, *linear.CASES, *nonlinear.CASES, *dynamics.CASES)


def find(names=(), quick=False):
    """Cases by the names of cases or suites; all without names.

    Raises:
        InputError: a name is neither a case nor a suite.
    """
    known = {case.name for case in CASES} | {case.suite for case in CASES}
    for name in names:
        if name not in known:
            raise InputError(f"'{name}' is neither a case nor a suite; corovec verify --list shows "
                             "them")
    return [case for case in CASES
            if (not names or case.name in names or case.suite in names)
            and not (quick and case.slow)]


def make_report(results, date):
    """Machine-readable verdicts of ``[(case, rows, seconds)]``."""
    return {
        "date": date, "versions": versions(), "machine": machine(), "kinds": KINDS,
        "cases": [{"name": case.name, "suite": case.suite, "claim": case.claim,
                   "source": case.source, "definition": case.definition, "seconds": seconds,
                   "rows": [row.as_dict() for row in rows]}
                  for case, rows, seconds in results]}
