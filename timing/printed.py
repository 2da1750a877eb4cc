"""The paper's CPU times as printed, what its errata make of them, and its dense/skyline ratios."""

import re
import tomllib
from dataclasses import dataclass
from pathlib import Path

PRINTED = Path(__file__).with_name("printed.toml")
METHODS = ("skyline", "dense")


@dataclass(frozen=True)
class Cell:
    """Both CPU times of one mesh and method of a table.

    Attributes:
        table: name of the table.
        case: name of the benchmark.
        mesh: as the table names it.
        elements: of the mesh.
        method: ``skyline`` or ``dense``.
        unit: of the times, as printed.
        per_unit: CPU time per unit, as printed.
        run: CPU time of the whole run, as printed.
        unit_steps: steps of the unit as read.
        steps: of the paper's whole run.
        seconds: CPU time per unit as read [s].
        run_seconds: CPU time of the run as read [s].
        printed_seconds: CPU time per unit without the errata [s].
        estimated: whether the paper marks the run as an estimate.
        errata: what was read differently, with the arithmetic; empty if nothing.
    """

    table: str
    case: str
    mesh: str
    elements: int
    method: str
    unit: str
    per_unit: str
    run: str
    unit_steps: int
    steps: int
    seconds: float
    run_seconds: float
    printed_seconds: float
    estimated: bool
    errata: str

    @property
    def mismatch(self):
        """Time per unit, multiplied up to the whole run, beside the run's printed time, less 1."""
        return self.seconds * (self.steps / self.unit_steps) / self.run_seconds - 1.0


def cells(with_errata=True):
    """All ``Cell`` s of Tables 2, 4, 6 and 8, as printed or with the errata applied."""
    with open(PRINTED, "rb") as file:
        data = tomllib.load(file)
    errata = data["errata"] if with_errata else []
    return tuple(_cell(table, k, method, errata) for table in data["tables"]
                 for k in range(len(table["elements"])) for method in METHODS)


def doubts():
    """``{table: doubt}``: columns that other tables contradict, by which factor, and why; they are
    not corrected, for their totals agree with them."""
    with open(PRINTED, "rb") as file:
        return {doubt["table"]: doubt for doubt in tomllib.load(file)["doubts"]}


def errata():
    """The corrections: table, printed, read, arithmetic, and the cell if not the whole table."""
    with open(PRINTED, "rb") as file:
        return tomllib.load(file)["errata"]


def seconds(text):
    """``13,460 s* (3.739 h*)`` -> 13460.0."""
    return float(re.match(r"([\d,]*\.?\d+) s", text)[1].replace(",", ""))


def unit_steps(text):
    """``CPU time per 100 steps`` -> 100."""
    return int(re.search(r"per (\d+) steps", text)[1])


def _cell(table, k, method, errata):
    elements, printed, unit, run = (table["elements"][k], table[method][k], table["unit"],
                                    table[f"{method}_run"][k])
    read, read_unit, notes = printed, unit, []
    for erratum in errata:
        here = erratum["table"] == table["name"]
        if here and erratum["printed"] == unit:
            read_unit = erratum["read"]
        elif here and (erratum.get("method"), erratum.get("elements")) == (method, elements):
            read = erratum["read"]
        else:
            continue
        notes.append(f"{erratum['printed']} read as {erratum['read']}: {erratum['arithmetic']}")
    return Cell(table["name"], table["case"], table["meshes"][k], elements, method, unit, printed,
                run, unit_steps(read_unit), table["steps"], seconds(read), seconds(run),
                seconds(printed), "*" in run, "; ".join(notes))
