"""Tables 2, 4, 6, 8: the paper's two solvers, the production default and two LAPACK solvers."""

import numpy as np

from corovec.benchmarks import case_names, load_case

from .measure import Calls, Stepper, sample, time_calls
from .printed import cells
from .solvers import METHODS

TABLES = {cell.table.lower().replace(" ", "-"): cell.table for cell in cells()}
"""The paper's tables, by their names on the command line."""

TABLE_OF = {cell.case: cell.table.lower().replace(" ", "-") for cell in cells()}
"""The table of each benchmark that has one."""

DENSE = ("lapack-lu", "dense")
"""Methods whose cost grows with the cube of the unknowns; the others go first."""

SEED, BASE = ("l-plate", 120), ("l-plate", 480)
"""Models whose dense factorizations tell about how long larger ones take, and from which those are
scaled that would take too long."""

SCALED_AT_MOST = 2.5
"""Largest ratio of unknowns over which a dense factorization is scaled."""

HELD = ("rest", "calls")
"""Entries of a row that only other rows need."""

ORDER = ("skyline", "auto", "banded-cholesky", "banded-lu", *DENSE)

BASES = {"steps": "whole steps timed",
         "single calls": "a step composed of single assembly, factorization and solution",
         "scaled": "as single calls, the factorization scaled by n^3 from a smaller matrix"}


def available(case, elements):
    """Whether the solver has this mesh of this case."""
    return case in case_names() and elements in load_case(case).sizes


class Bench:
    """Timings of all methods; remembers the largest dense factorization of each."""

    def __init__(self, effort):
        self.effort = effort
        self._largest = {}

    def rows(self, name, progress=lambda text: None):
        """Rows of one of ``TABLES``: a dictionary a mesh and method, seconds of CPU time."""
        rows = []
        printed = [cell for cell in cells() if cell.table == TABLES[name]]
        for elements in dict.fromkeys(cell.elements for cell in printed):
            of_mesh = {cell.method: cell for cell in printed if cell.elements == elements}
            rows += self._mesh(of_mesh, progress)
        return rows

    def _mesh(self, printed, progress):
        cell = printed["skyline"]
        if not available(cell.case, cell.elements):
            return [{**_identity(cell), "method": method, "basis": "not available",
                     **_paper(printed.get(method))} for method in METHODS]
        definition = load_case(cell.case)
        model, dt = definition.model(cell.elements), definition.paper.dt.value
        measured = {}
        for method in ORDER:
            progress(f"{cell.table}, {cell.elements} elements, {method}")
            measured[method] = self._method(model, dt, method, cell, measured.get("skyline"))
        return [{**_identity(cell), "method": method,
                 **{key: value for key, value in measured[method].items() if key not in HELD},
                 **_paper(printed.get(method))} for method in METHODS]

    def _method(self, model, dt, method, cell, skyline):
        """One row.  Iterations and what a step costs beside them are the skyline's."""
        if method in DENSE and self._expected(method, skyline["unknowns"]) * skyline[
                "iterations_per_step"] > self.effort.step_seconds:
            return self._from_calls(model, dt, method, cell, skyline)
        stepper = Stepper(model, dt, method)
        once = sample(stepper.steps, 1).median
        count = int(np.clip(self.effort.round_seconds / once, 1, cell.unit_steps))
        step = sample(lambda: stepper.steps(count), self.effort.rounds).scaled(1.0 / count)
        calls = time_calls(stepper, self.effort)
        self._remember(method, stepper.system.numbering.n_dof, calls)
        rest = max(0.0, step.median - stepper.iterations * calls.iteration)
        run, done = step.median * cell.steps, stepper.done
        extrapolated = run > self.effort.run_seconds
        if not extrapolated:
            remaining = sample(lambda: stepper.steps(cell.steps - done), 1).median
            run = remaining * cell.steps / (cell.steps - done)
        return {"unknowns": stepper.system.numbering.n_dof, "basis": "steps",
                "steps_per_round": count, "iterations_per_step": stepper.iterations,
                "halvings": stepper.record.halvings, "solver": stepper.system.solver.name,
                "storage_bytes": stepper.system.solver.values.nbytes, "step_cpu": step.median,
                **calls.row(), "rest": rest, "calls": calls,
                **step.scaled(cell.unit_steps).row("unit"), "run_cpu": run,
                "run_extrapolated": extrapolated}

    def _from_calls(self, model, dt, method, cell, skyline):
        """A row from single calls, the factorization scaled if even one would take too long."""
        n, iterations, scaled_from = skyline["unknowns"], skyline["iterations_per_step"], None
        if self._expected(method, n) > self.effort.call_seconds:
            if n > SCALED_AT_MOST * self._largest[method][0]:
                self._time_model(method, BASE)
            m, of_m = self._largest[method]
            scaled_from, storage, basis = m, 8 * n * n, "scaled"
            calls = Calls(skyline["calls"].assembly, of_m.factor.scaled((n / m)**3),
                          of_m.solve.scaled((n / m)**2))
        else:
            stepper = Stepper(model, dt, method)
            storage, basis = stepper.system.solver.values.nbytes, "single calls"
            calls = time_calls(stepper, self.effort)
            self._remember(method, n, calls)
        step = calls.step(iterations, skyline["rest"])
        return {"unknowns": n, "basis": basis, "scaled_from_unknowns": scaled_from,
                "steps_per_round": 0, "iterations_per_step": iterations, "halvings": 0,
                "solver": method, "storage_bytes": storage, "step_cpu": step.median,
                **calls.row(), **step.scaled(cell.unit_steps).row("unit"),
                "run_cpu": step.median * cell.steps, "run_extrapolated": True}

    def _expected(self, method, n):
        """CPU seconds of a dense factorization of ``n`` unknowns, by n^3."""
        if method not in self._largest:
            self._time_model(method, SEED)
        m, calls = self._largest[method]
        return calls.factor.median * (n / m)**3

    def _time_model(self, method, model):
        case, elements = model
        definition = load_case(case)
        stepper = Stepper(definition.model(elements), definition.paper.dt.value, method)
        self._remember(method, stepper.system.numbering.n_dof,
                       time_calls(stepper, self.effort))

    def _remember(self, method, n, calls):
        if n > self._largest.get(method, (0,))[0]:
            self._largest[method] = n, calls


def ratios(rows):
    """Ratios of a table's rows, mesh by mesh.

    ``dense / skyline`` of whole steps, ours and the paper's (as read, and as printed), and of what
    depends on the solver alone (factorization and solution) its factors: sparsity, LAPACK's dense
    LU against its unsymmetric banded LU; symmetry, that against its banded Cholesky; profile, that
    against the skyline, which skips what is empty within the band.  ``operations``: the n^3 / 3
    products of dense elimination over the skyline's, at least (entries)^2 / 2n.  ``dense_basis``,
    ``lapack_basis``: the key of ``BASES`` that the numerators rest on.
    """
    result = []
    for elements in dict.fromkeys(row["elements"] for row in rows):
        of = {row["method"]: row for row in rows if row["elements"] == elements}
        if of["skyline"]["basis"] == "not available":
            ours = {}
        else:
            cost = {name: row["factor_cpu"] + row["solve_cpu"] for name, row in of.items()}
            ours = {"dense_skyline": of["dense"]["step_cpu"] / of["skyline"]["step_cpu"],
                    "lapack_skyline": of["lapack-lu"]["step_cpu"] / of["skyline"]["step_cpu"],
                    "dense_auto": of["dense"]["step_cpu"] / of["auto"]["step_cpu"],
                    "operations": _operations(of["skyline"]),
                    "sparsity": cost["lapack-lu"] / cost["banded-lu"],
                    "symmetry": cost["banded-lu"] / cost["banded-cholesky"],
                    "profile": cost["banded-cholesky"] / cost["skyline"],
                    "dense_basis": of["dense"]["basis"], "lapack_basis": of["lapack-lu"]["basis"]}
        sky, dense = of["skyline"], of["dense"]
        result.append({"table": sky["table"], "case": sky["case"], "elements": elements,
                       "unknowns": sky.get("unknowns"), **ours,
                       "paper": dense["paper_seconds"] / sky["paper_seconds"],
                       "paper_as_printed": dense["printed_seconds"] / sky["printed_seconds"]})
    return result


def _operations(skyline):
    """Products of dense elimination over those of a skyline row's factorization, at most."""
    n, entries = skyline["unknowns"], skyline["storage_bytes"] / 8
    return 2.0 * n**4 / (3.0 * entries**2)


def _identity(cell):
    return {"table": cell.table, "case": cell.case, "mesh": cell.mesh, "elements": cell.elements,
            "unit_steps": cell.unit_steps, "run_steps": cell.steps}


def _paper(cell):
    """What the paper prints beside a row; None for methods that it does not have."""
    if cell is None:
        return dict.fromkeys(("printed", "printed_run", "printed_seconds", "paper_seconds",
                              "paper_run_seconds", "paper_estimated", "errata"))
    return {"printed": cell.per_unit, "printed_run": cell.run,
            "printed_seconds": cell.printed_seconds, "paper_seconds": cell.seconds,
            "paper_run_seconds": cell.run_seconds, "paper_estimated": cell.estimated,
            "errata": cell.errata}
