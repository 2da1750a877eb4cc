"""The studies by name, and their tables as text and files."""

import json

import pandas as pd

from corovec.solver.results.files import replacing

from .growth import exponents, growth
from .iterations import long_run, step_iterations
from .measure import load
from .tables import BASES, TABLES, Bench, ratios
from .targets import dense_lu, targets
from .verdicts import verdicts

WRITTEN = {**{name: (f"{name}-times", f"{name}-ratios", f"{name}-verdicts") for name in TABLES},
           "iterations": ("iterations", "iterations-run"),
           "growth": ("growth", "growth-phases", "growth-exponents"), "targets": ("D", "targets")}
"""Tables that each study gives."""

NAMES = tuple(WRITTEN)

REFERENCE = 1000
"""Unknowns of the dense LU whose time stands for the machine as it was during a study."""


def _rounds(prefix, unit):
    """Columns of ``Sample.row``, with their unit: minimum, quartiles around the median, number."""
    return {f"{prefix}_min": unit, f"{prefix}_q1": unit, f"{prefix}_cpu": unit,
            f"{prefix}_q3": unit, f"{prefix}_rounds": ""}


SHOWN = {
    "times": {"elements": "", "method": "", "basis": "", "unit_steps": "", **_rounds("unit", "s"),
              "run_steps": "", "run_cpu": "s", "run_extrapolated": "", "printed": "",
              "printed_run": ""},
    "ratios": {"elements": "", "unknowns": "", "dense_skyline": "", "dense_basis": "", "paper": "",
               "paper_as_printed": "", "dense_auto": "", "lapack_skyline": "", "lapack_basis": "",
               "sparsity": "", "symmetry": "", "profile": ""},
    "verdicts": {"name": "", "value": "", "reference": "", "verdict": ""},
    "growth": {"case": "", "elements": "", "unknowns": "", "method": "", "solver": "",
               "first_step": "s", "step": "s", "iterations_per_step": "", "matrix_bytes": "B",
               "memory_bytes": "B", "peak_memory": "MB"},
    "phases": {"case": "", "elements": "", "method": "", "phase": "", **_rounds("call", "s")},
    "D": {"unknowns": "", **_rounds("D", "s")},
    "iterations": {"dt": "s", "matrix": "", "gap": "", "iterations": "", "iterations_converged": "",
                   "error": "", "paper_error": "", "converged_error": ""},
    "run": {"dt": "s", "time": "s", "paper_iterations": "", "tight_iterations": "",
            "paper_energy_drift": "", "tight_energy_drift": "", "difference": "m",
            "travelled": "m"},
    "targets": {"name": "", "min": "", "q1": "", "value": "", "q3": "", "rounds": "", "unit": "",
                "target": "", "goal": "", "met": "", "detail": ""}}
"""Columns shown, by the end of a table's name; the files have them all."""


def collect(name, effort, bench, folder=None, progress=lambda text: None):
    """``{table: rows}`` of one of ``NAMES``; see the functions for the rows.

    ``bench``: a ``Bench``, shared; ``folder``: see ``timing.targets``.
    """
    if name in TABLES:
        rows = bench.rows(name, progress)
        compared = ratios(rows)
        return {f"{name}-times": rows, f"{name}-ratios": compared,
                f"{name}-verdicts": [row.as_dict() for row in verdicts(compared)]}
    if name == "iterations":
        progress("iterations")
        return {"iterations": step_iterations(), "iterations-run": long_run()}
    if name == "growth":
        rows, phases = growth(effort, progress)
        return {"growth": rows, "growth-phases": phases, "growth-exponents": exponents(rows)}
    rows, D = targets(effort, folder, progress)
    return {"D": [D], "targets": [target.row() for target in rows]}


def run(names, report, effort, folder=None, progress=lambda text: None):
    """Collect the studies into ``report["tables"]``, one after the other; yields their tables.

    A dense LU of ``REFERENCE`` unknowns is timed before and after each study, for its times to be
    compared with other runs.  With a folder, ``timing.json`` and a CSV a table are written after
    each.
    """
    bench = Bench(effort)
    report["tables"], report["references"] = {}, {}
    for name in names:
        reference = dense_lu(effort.rounds, REFERENCE)
        tables = collect(name, effort, bench, folder, progress)
        reference += dense_lu(effort.rounds, REFERENCE)
        report["references"][name] = {"unknowns": REFERENCE, **reference.row("LU")}
        report["tables"].update(tables)
        report["load_at_end"] = load()
        if folder is not None:
            write(folder, report)
        yield tables


def write(folder, report):
    """``timing.json`` and the CSV files, each replaced as a whole; those of tables that are not
    in the report, of an earlier one, are removed."""
    with replacing(folder / "timing.json") as partial:
        partial.write_text(json.dumps(report, indent=1), encoding="utf-8")
    for name, rows in report["tables"].items():
        with replacing(folder / f"{name}.csv") as partial:
            frame = pd.DataFrame(rows).assign(commit=report["commit"], date=report["date"],
                                              size=report["size"])
            frame.to_csv(partial, index=False)
    for name in set().union(*WRITTEN.values()) - set(report["tables"]):
        (folder / f"{name}.csv").unlink(missing_ok=True)


def text(name, rows):
    """A table for reading: chosen columns, missing ones as ``-``, errata and bases below."""
    columns = SHOWN.get(name.rsplit("-", 1)[-1]) or dict.fromkeys(rows[0], "")
    frame = pd.DataFrame([{key: row.get(key) for key in columns} for row in rows])
    shown = frame.map(_text).rename(columns={key: f"{key} [{unit}]" if unit else key
                                             for key, unit in columns.items()})
    notes = sorted({row["errata"] for row in rows if row.get("errata")})
    bases = [basis for basis in BASES if any(row.get("basis") == basis for row in rows)]
    notes += [f"{basis}: {BASES[basis]}" for basis in bases if basis != "steps"]
    return "\n".join([name, shown.to_string(index=False), *(f"  {note}" for note in notes), ""])


def _text(value):
    if value is None or value != value:
        return "-"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
