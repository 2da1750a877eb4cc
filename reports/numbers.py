"""Measured numbers of the README and the documentation, from result files, never typed twice.

``docs/numbers.json`` is a snapshot of a reproduction: what the Markdown shows of ``study.json`` and
``timing.json``, with the commit and the machine of each.  In the Markdown a number stands between
``<!-- number: NAME ... -->`` and ``<!-- end -->``, where NAME is one of ``TABLES``, or a case
followed by a quantity of its study's summary and a format, as in
``<!-- number: l-plate | slope, finest mesh as reference | .2f -->-1.73<!-- end -->``.
"""

import json
import re
from pathlib import Path

import click

from corovec.solver.errors import InputError

ROOT = Path(__file__).parents[1]
SNAPSHOT = "docs/numbers.json"
COMMAND = "corovec numbers FOLDER"
"""What brings the Markdown up to date: FOLDER is one of ``corovec reproduce``, with its size."""

MARKED = re.compile(r"(<!-- number: ([^>]*?) -->)(.*?)(<!-- end -->)", re.DOTALL)
CASES = ("l-plate", "ruler", "hemisphere", "plates")
METHODS = ("skyline", "dense", "auto", "lapack-lu", "banded-lu", "banded-cholesky")
NAMES = ("skyline LDLᵀ", "dense Gauss", "production", "LAPACK dense LU", "banded LU",
         "banded Cholesky")


@click.command()
@click.argument("folder", type=click.Path(file_okay=False, path_type=Path), required=False)
def numbers(folder):
    """Write the measured numbers of a reproduction FOLDER into README and documentation.

    FOLDER is that of one size, as results/reproduce/full; of what is not in it the old numbers
    stay.  Without it the Markdown is only written anew from docs/numbers.json.

    \b
    Example:
      corovec numbers results/reproduce/full
    """
    path = ROOT / SNAPSHOT
    if not path.exists():
        raise InputError(f"{path} does not exist: numbers are written in a checkout only")
    snapshot = json.loads(path.read_text(encoding="utf-8"))
    if folder is not None:
        try:
            found = collect(folder)
        except (OSError, LookupError, TypeError, AttributeError, ValueError) as error:
            raise InputError(f"{folder}: a study.json or timing.json is damaged: "
                             f"{type(error).__name__} {error}") from None
        if not any(found.values()):
            raise InputError(f"{folder} holds no study.json and no timing.json")
        snapshot = {kind: {**snapshot[kind], **found[kind]} for kind in snapshot}
    try:
        written = {page: render(page.read_text(encoding="utf-8"), snapshot) for page in pages(ROOT)}
    except (LookupError, TypeError, ValueError) as error:
        raise InputError(f"the numbers of {folder or path} are not whole: "
                         f"{type(error).__name__} {error}") from None
    written[path] = json.dumps(snapshot, indent=1, ensure_ascii=False) + "\n"
    for page, new in written.items():
        if new != page.read_text(encoding="utf-8"):
            page.write_text(new, encoding="utf-8")
            click.echo(f"{page.relative_to(ROOT)} written anew")


def pages(root):
    """Markdown files of a checkout that may show numbers."""
    return [root / "README.md", *sorted((root / "docs").rglob("*.md"))]


def collect(folder):
    """``{"convergence": {case: ...}, "timing": {table: ...}}`` of what is in a folder."""
    found = {"convergence": {}, "timing": {}}
    for case in CASES:
        path = folder / "convergence" / case / folder.name / "study.json"
        if path.exists():
            study = json.loads(path.read_text(encoding="utf-8"))
            end = max(row["until"] for row in study["drift"])
            drift = min((row for row in study["drift"] if row["until"] == end),
                        key=lambda row: row["dt"])
            found["convergence"][case] = {
                **_origin(study["origin"]),
                "mesh": [_part(row, ("elements", "printed", "energy", "order", "order_of_printed"))
                         for row in study["mesh"]],
                "drift": _part(drift, ("until", "dt", "energy_drift", "linear_momentum_drift",
                                       "angular_momentum_drift")),
                "summary": {row["quantity"]: row["ours"] for row in study["summary"]}}
    path = folder / "timing" / "table-2" / "timing.json"
    if path.exists():
        timing = json.loads(path.read_text(encoding="utf-8"))
        found["timing"]["table-2"] = {
            **_origin(timing),
            "rows": [_part(row, ("elements", "method", "unit_cpu", "basis"))
                     for row in timing["tables"]["table-2-times"]],
            "ratios": [_part(row, ("elements", "dense_skyline", "paper"))
                       for row in timing["tables"]["table-2-ratios"]]}
    return found


def render(text, snapshot):
    """The Markdown ``text`` with all marked numbers as the snapshot has them."""
    def number(match):
        name, *rest = (part.strip() for part in match[2].split("|"))
        if name in TABLES:
            shown = f"\n\n{TABLES[name](snapshot)}\n\n"
        else:
            quantity, form = rest
            shown = _short(format(snapshot["convergence"][name]["summary"][quantity], form))
        return match[1] + shown + match[4]
    return MARKED.sub(number, text)


def _energies(snapshot):
    """All cases and meshes: energies, orders, drifts."""
    lines = ["| case, elements | printed [J] | ours [J] | p printed, ours | until, dt [s] "
             "| E drift | L drift | J drift |", "|---" * 8 + "|"]
    for case in CASES:
        study = snapshot["convergence"][case]
        mesh, drift = study["mesh"], study["drift"]
        lines.append("| " + " | ".join((
            f"{case} " + ", ".join(str(row["elements"]) for row in mesh),
            ", ".join(row["printed"] for row in mesh),
            ", ".join(f"{row['energy']:.{2 if row['energy'] > 1000.0 else 3}f}" for row in mesh),
            f"{mesh[-1]['order_of_printed']:.3g}, {mesh[-1]['order']:.3g}",
            f"{drift['until']:g}, {_short(format(drift['dt'], '.2e'))}",
            _short(format(drift["energy_drift"], ".1e")),
            *(_short(format(drift[f"{name}_momentum_drift"], ".0e"))
              for name in ("linear", "angular")))) + " |")
    return "\n".join([*lines, "", _measured(snapshot["convergence"]["l-plate"])])


def _times(snapshot):
    """Table 2: CPU seconds of 100 steps, and the ratio of the paper's two solvers."""
    lines = [f"| elements | {' | '.join(NAMES)} | dense/skyline | paper's |", "|---" * 9 + "|"]
    table = snapshot["timing"]["table-2"]
    for ratio in table["ratios"]:
        of = {row["method"]: row for row in table["rows"] if row["elements"] == ratio["elements"]}
        star = "" if of["dense"]["basis"] == "steps" else "*"
        cells = [f"{of[name]['unit_cpu']:.3g}" + (star if name == "dense" else "")
                 for name in METHODS]
        lines.append(f"| {ratio['elements']} | {' | '.join(cells)} | "
                     f"{ratio['dense_skyline']:.3g}{star} | {ratio['paper']:.3g} |")
    return "\n".join([*lines, "", "(*) Composed of single calls. "
                      + _measured(table)])


TABLES = {"energies": _energies, "times": _times}


def _measured(part):
    return f"Measured at commit {part['commit'][:7]}, {part['machine']}."


def _origin(origin):
    machine = origin["machine"]
    return {"commit": origin["commit"], "machine": machine["processor"]}


def _part(row, names):
    return {name: row.get(name) for name in names}


def _short(text):
    """``2.70e-07`` as ``2.7e-7``."""
    mantissa, e, exponent = text.partition("e")
    if not e:
        return text
    mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
    return f"{mantissa}e{int(exponent)}"
