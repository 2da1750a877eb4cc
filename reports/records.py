"""A small record of what the results of a commit say: ``records/COMMIT.json`` in their folder.

An entry is one study or timing, called as its command: energies, drifts and rates with their
verdicts, times in units of the dense LU that was timed with them.  A record is made of the results
that are there, entry by entry, so that one of an interrupted night is finished by the next run.
"""

import json
from typing import Literal

from pydantic import BaseModel, ConfigDict, ValidationError

from corovec import ResultFileError
from corovec.solver.results.files import reason, replacing, writable_folder
from corovec.timing.tables import TABLES

FOLDER = "records"
RESULTS = ("study.json", "timing.json")
TIMELESS = ("", "D")
"""Units of targets that are ratios already."""


class Kept(BaseModel):
    """What all parts of a record have in common: nothing else, and no other types."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class Rounds(Kept):
    """How the rounds of a timing lie, in units of its reference."""

    least: float
    q1: float
    median: float
    q3: float
    rounds: int

    def __str__(self):
        return f"{self.median:.3g} ({self.q1:.3g} to {self.q3:.3g}, {self.rounds} rounds)"


class Entry(Kept):
    """What one result says.

    Attributes:
        date: when it was written.
        machine: processor and system.
        versions: of the libraries.
        numbers: by their names, None where a run failed.
        verdicts: of those numbers that have one.
        timings: by what was timed.
    """

    date: str
    machine: dict[str, str]
    versions: dict[str, str]
    numbers: dict[str, float | None] = {}
    verdicts: dict[str, str] = {}
    timings: dict[str, Rounds] = {}


class Record(Kept):
    """The entries of a commit, by the commands that wrote them."""

    format: Literal["corovec-record-1"] = "corovec-record-1"
    commit: str
    entries: dict[str, Entry]


def below(folder):
    """Contents of all results below a folder, for ``records_of``.

    Raises:
        ResultFileError: one is damaged.
    """
    for path in sorted(path for name in RESULTS for path in folder.rglob(name)):
        try:
            yield path, json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise ResultFileError(f"{path} is damaged: {error}") from None


def records_of(results):
    """The ``Record`` s of pairs of a path and contents of ``study.json`` and ``timing.json``: each
    result is of the commit that it names.

    Raises:
        ResultFileError: one is none of these.
    """
    entries = {}
    for path, contents in results:
        try:
            commit, found = (_study if "origin" in contents else _timing)(contents)
            entries.setdefault(commit, {}).update(found)
        except (LookupError, TypeError, AttributeError, ValueError) as error:
            raise ResultFileError(f"{path} is damaged: {type(error).__name__} "
                                  f"{reason(error)}") from None
    return [Record(commit=commit, entries=found) for commit, found in entries.items()]


def load(folder):
    """(records in ``folder``/records, a sentence on each that is damaged)."""
    records, damaged = [], []
    for path in sorted((folder / FOLDER).glob("*.json")):
        try:
            records.append(Record.model_validate_json(path.read_bytes()))
        except (OSError, ValidationError) as error:
            damaged.append(f"record {path.name} is damaged and skipped: {reason(error)}")
    return records, damaged


def keep(folder, records):
    """Write records into ``folder``/records; what a commit has there already stays beside it."""
    own = writable_folder(folder / FOLDER)
    there = {record.commit: record.entries for record in load(folder)[0]}
    for record in records:
        whole = Record(commit=record.commit,
                       entries={**there.get(record.commit, {}), **record.entries})
        with replacing(own / f"{record.commit.replace(' ', '-')}.json") as partial:
            partial.write_text(whole.model_dump_json(indent=1) + "\n", encoding="utf-8")


def _study(study):
    """(commit, entry) of a convergence study."""
    origin, run, rows = study["origin"], study["runs"][0], study["verdicts"]
    name = f"converge {run['case']} --size {origin['size']}"
    if run["membrane"] != "stress":
        name += f" --membrane {run['membrane']}"
    numbers = {f"{row['elements']} elements: energy after unloading [J]": row["energy"]
               for row in study["mesh"]}
    return origin["commit"], {name: Entry(
        **_origin(origin), numbers={**numbers, **{row["name"]: row["value"] for row in rows}},
        verdicts={row["name"]: row["verdict"] for row in rows})}


def _timing(timing):
    """(commit, entries) of a timing, a study each; what counts iterations has no entry."""
    return timing["commit"], {
        f"time {name} --size {timing['size']}": Entry(
            **_origin(timing), timings=dict(_ratios(name, timing["tables"], reference["LU_cpu"])))
        for name, reference in timing["references"].items() if name != "iterations"}


def _ratios(name, tables, reference):
    """What was timed, and its ``Rounds``."""
    if name in TABLES:
        for row in tables[f"{name}-times"]:
            if "unit_cpu" in row:
                yield f"{row['case']} {row['elements']} {row['method']}", _rounds(
                    row, reference, "unit_", "cpu")
    elif name == "growth":
        for row in tables["growth-phases"]:
            yield f"{row['case']} {row['elements']} {row['method']}: {row['phase']}", _rounds(
                row, reference, "call_", "cpu")
    else:
        for row in tables["targets"]:
            if row["rounds"]:
                yield row["name"], _rounds(row, 1.0 if row["unit"] in TIMELESS else reference)


def _rounds(row, reference, prefix="", median="value"):
    return Rounds(rounds=row[f"{prefix}rounds"], **{
        kept: row[prefix + name] / reference
        for kept, name in (("least", "min"), ("q1", "q1"), ("median", median), ("q3", "q3"))})


def _origin(origin):
    return {name: origin[name] for name in ("date", "machine", "versions")}
