"""Measured numbers of the README and the documentation, from result files, never typed twice.

``docs/numbers.json`` is a snapshot: what the Markdown shows of ``study.json``, ``timing.json`` and
``peers.json``, with commit and machine of each, and under ``commands`` the lines that come from
commands without such a file.  In the Markdown a number stands between ``<!-- number: NAME ... -->``
and ``<!-- end -->``, where NAME is one of ``TABLES``, one of the commands, or

- a case, a quantity of its study's summary and a format, as in
  ``<!-- number: l-plate | R squared | .4f -->0.9995<!-- end -->``,
- a case or timing, a table of it, ``column=value`` of a row (more with ;), a column and a format.
"""

import json
import re
from pathlib import Path

from corovec.solver.errors import InputError
from corovec.timing.shapes import SHAPES

from . import number_tables
from .number_tables import CASES, DRIFTS

ROOT = Path(__file__).parents[1]
SNAPSHOT = "docs/numbers.json"
COMMAND = "corovec numbers FOLDER"
"""What brings the Markdown up to date: FOLDER is one of ``corovec reproduce``, with its size."""

MARKED = re.compile(r"(<!-- number: ([^>]*?) -->)(.*?)(<!-- end -->)", re.DOTALL)
TABLES = {name: getattr(number_tables, name) for name in (
    "energies", "dissipation", "motion", "schemes", "paths", "times", "ratios", "iterations",
    "exponents", "shapes", "targets", "peers", "peer_ratios")}
RUNS = {"conservation": ("case",), "peers": ("elements", "dt")}
"""Parts of the snapshot whose rows are of several runs, and what is measured anew together."""

TIMINGS = ("table-2", "table-4", "table-6", "table-8", "iterations", "growth", "targets")

COLUMNS = {
    "mesh": ("elements", "printed", "energy", "order", "order_of_printed"),
    "drift": ("until", "dt", *DRIFTS),
    "dissipation": ("dt", "rho_inf", "time", "energy_change"),
    "schemes": ("case", "scheme", "largest_step", "of_paper", "larger_untried", *DRIFTS,
                "iterations_per_step", "cpu_per_second"),
    "flights": ("case", "scheme", "dt", "path_error"),
    "motion": ("dt", "point", "component", "until", "min", "max", "period", "autocorrelation"),
    "symmetry": ("dt", "until", "asymmetry"),
    "growth": ("dt", "power"),
    "times": ("elements", "method", "unit_cpu", "basis"),
    "ratios": ("case", "elements", "dense_skyline", "dense_basis", "sparsity", "paper"),
    "iterations": ("dt", "matrix", "iterations", "iterations_converged"),
    "exponents": ("case", "method", "solvers", "assembly", "factorization", "solve", "step",
                  "memory_bytes"),
    "shapes": ("case", "unknowns", "solver", "first_step", "step", "iterations_per_step", "solve",
               "assembly", "factorization", "peak_memory"),
    "targets": ("name", "unit", "target", "goal", "value", "met"),
    "rows": ("program", "version", "elements", "dt", "end_time", "cpu_ms_per_step", "survived",
             "reached", "energy_drift"),
    "speedups": ("elements", "dt", "fastest", "factor")}
"""Columns that the snapshot keeps of a table; those of a timing by the end of their name."""


def update(folder=None):
    """Write numbers into README and documentation, see ``corovec numbers``; the pages that changed.

    Raises:
        InputError: there is no checkout, or the results are damaged or not whole.
    """
    path = ROOT / SNAPSHOT
    if not path.exists():
        raise InputError(f"{path} does not exist: numbers are written in a checkout only")
    snapshot = json.loads(path.read_text(encoding="utf-8"))
    if folder is not None:
        try:
            found = collect(folder)
        except (OSError, LookupError, TypeError, AttributeError, ValueError) as error:
            raise InputError(f"{folder}: a study.json, timing.json or peers.json is damaged: "
                             f"{type(error).__name__} {error}") from None
        if not any(found.values()):
            raise InputError(f"{folder} holds no study.json, timing.json or peers.json")
        for kind, parts in found.items():
            runs = snapshot[kind].get("runs", []), parts.get("runs", [])
            snapshot[kind].update(parts)
            if kind in RUNS:
                snapshot[kind] = {"runs": _joined(*runs, RUNS[kind])}
    try:
        written = {page: render(page.read_text(encoding="utf-8"), snapshot) for page in pages(ROOT)}
    except (LookupError, TypeError, ValueError) as error:
        raise InputError(f"the numbers of {folder or path} are not whole: "
                         f"{type(error).__name__} {error}") from None
    written[path] = json.dumps(snapshot, indent=1, ensure_ascii=False) + "\n"
    changed = [page for page, new in written.items() if new != page.read_text(encoding="utf-8")]
    for page in changed:
        page.write_text(written[page], encoding="utf-8")
    return [page.relative_to(ROOT) for page in changed]


def pages(root):
    """Markdown files of a checkout that may show numbers."""
    return [root / "README.md", *sorted((root / "docs").rglob("*.md"))]


def collect(folder):
    """``{"convergence": {case: ...}, "timing": {name: ...}, "conservation": ..., "peers": ...}`` of
    what is there."""
    studies = {case: folder / "convergence" / case / folder.name / "study.json" for case in CASES}
    timings = {name: folder / "timing" / name / "timing.json" for name in TIMINGS}
    peers = _read(folder / "peers.json")
    conserved = _read(folder / "conservation" / folder.name / "study.json")
    return {"convergence": {case: _study(_read(path)) for case, path in studies.items()
                            if path.exists()},
            "timing": {name: _timing(_read(path)) for name, path in timings.items()
                       if path.exists()},
            "conservation": {} if conserved is None else {"runs": [{
                **_origin(conserved["origin"]), "schemes": _rows(conserved, "schemes"),
                "flights": _rows(conserved, "flights")}]},
            "peers": {} if peers is None else {"runs": [{
                **_origin(peers), "rows": _rows(peers, "rows"),
                "speedups": _rows(peers, "speedups")}]}}


def _joined(old, new, keys):
    """Runs of which each has rows of its own ``keys``: ``old`` ones, but for what is ``new``."""
    again = {tuple(row[key] for key in keys) for run in new for rows in _tables(run).values()
             for row in rows}
    kept = [{**run, **{name: [row for row in rows if tuple(row[key] for key in keys) not in again]
                       for name, rows in _tables(run).items()}} for run in old]
    return [run for run in kept if any(_tables(run).values())] + new


def _tables(run):
    return {name: rows for name, rows in run.items() if isinstance(rows, list)}


def render(text, snapshot):
    """The Markdown ``text`` with all marked numbers as the snapshot has them."""
    def number(match):
        name, *rest = (part.strip() for part in match[2].split("|"))
        if not rest:
            shown = (TABLES[name](snapshot) if name in TABLES
                     else number_tables.command(snapshot["commands"][name]))
            return f"{match[1]}\n\n{shown}\n\n{match[4]}"
        return match[1] + _value(snapshot, name, *rest) + match[4]
    return MARKED.sub(number, text)


def _value(snapshot, name, table, *rest):
    """The text of one number, – without such a row: see the module for what a marker holds."""
    part = {**snapshot["convergence"], **snapshot["timing"]}[name]
    if len(rest) == 1:
        return number_tables.number(part["summary"][table], rest[0])
    selector, column, form = rest
    wanted = dict(item.strip().split("=", 1) for item in selector.split(";"))
    rows = [row for row in part[table]
            if all(str(row[key]) == value for key, value in wanted.items())]
    return number_tables.number(rows[0][column] if rows else None, form)


def _study(study):
    """What is kept of a study: its meshes and summary, and at the smallest time step the whole
    flight: drifts, motion, asymmetry (the largest of all planes), its growth (the fastest)."""
    kept = {name: _rows(study, name) for name in ("mesh", "drift", "dissipation", "motion",
                                                  "symmetry", "growth")}
    end, dt = max(row["until"] for row in kept["drift"]), min(row["dt"] for row in kept["drift"])
    for name in ("drift", "motion", "symmetry", "growth"):
        kept[name] = [row for row in kept[name] if row["dt"] == dt]
    (drift,) = (row for row in kept["drift"] if row["until"] == end)
    last = {row["rho_inf"]: row for row in kept["dissipation"] if row["rho_inf"] < 1.0}
    untils = sorted({row["until"] for row in kept["symmetry"]})
    symmetry = [max((row for row in kept["symmetry"] if row["until"] == until),
                    key=lambda row: row["asymmetry"]) for until in (*untils[:1], *untils[-1:])]
    moving = {"motion": kept["motion"], "symmetry": symmetry,
              "growth": [max(kept["growth"], key=lambda row: row["power"])]} if untils else {}
    return {**_origin(study["origin"]), "mesh": kept["mesh"], "drift": drift,
            "dissipation": list(last.values()), **moving,
            "summary": {row["quantity"]: row["ours"] for row in study["summary"]}}


def _timing(timing):
    """What is kept of a timing: its tables that ``COLUMNS`` knows, by the end of their name, and of
    the growth study the models that are no benchmarks."""
    found = timing["tables"]
    tables = {name.rsplit("-", 1)[-1]: _rows(found, name) for name in found
              if name.rsplit("-", 1)[-1] in COLUMNS and name != "growth"}
    if "growth" in found:
        shapes = [row for row in found["growth"] if row["case"] in SHAPES and "step" in row]
        tables["shapes"] = _rows({"shapes": shapes}, "shapes")
    return {**_origin(timing), **tables}


def _rows(tables, name):
    """Rows of a table with the columns of ``COLUMNS`` only; no table, no rows."""
    return [{column: row.get(column) for column in COLUMNS[name.rsplit("-", 1)[-1]]}
            for row in tables.get(name, ())]


def _read(path):
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None


def _origin(origin):
    return {"commit": origin["commit"], "machine": origin["machine"]["processor"]}
