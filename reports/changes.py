"""What moved between the results of a commit and the last record before them, in words."""

from collections import Counter
from dataclasses import dataclass, field
from typing import NamedTuple

from corovec.convergence.verdicts import ROUNDING

from .tables import VERDICTS, Table

ENERGY, DERIVED = 1e-9, 1e-3
"""Changes, relative, that are rounding: of an energy, and of what comes from differences of nearly
equal energies (drifts, errors, orders) or from long flights, which multiply rounding."""

TIMING = 0.1
"""Least change of a median, relative, that is told where the quartiles of two timings lie apart."""

FALLEN = tuple(name for name in VERDICTS if name.startswith(("failed", "deviates")))
"""Verdicts to which another falls."""

KINDS = {"fell": ("verdict fell", "verdicts fell"),
         "verdict": ("other verdict changed", "other verdicts changed"),
         "number": ("number moved", "numbers moved"), "timing": ("timing moved", "timings moved"),
         "new": ("row is new", "rows are new"), "gone": ("row is gone", "rows are gone")}
"""Kinds of changes, the worst first, of one and of several."""


class Change(NamedTuple):
    """What moved.

    Attributes:
        kind: one of ``KINDS``.
        result: the command that wrote it.
        name: of the number.
        before: the number as recorded, with its verdict where that changed.
        now: the same.
        since: commit of the record.
        commit: of the results.
    """

    kind: str
    result: str
    name: str
    before: str
    now: str
    since: str
    commit: str

    def __str__(self):
        return (f"{self.result}: {self.name}: {self.before} ({self.since}) -> {self.now} "
                f"({self.commit})")


@dataclass
class Comparison:
    """Results beside the last records before them.

    Attributes:
        changes: what moved, the worst first.
        compared: how many numbers and timings were compared.
        commits: pairs of the commits that were.
        notes: what could not be compared, what else differs, damaged records.
    """

    changes: list = field(default_factory=list)
    compared: int = 0
    commits: dict = field(default_factory=dict)
    notes: list = field(default_factory=list)

    @property
    def fell(self):
        """Whether a verdict fell."""
        return any(change.kind == "fell" for change in self.changes)

    def line(self):
        """All of it in one line."""
        if not self.commits:
            return "; ".join(["no earlier record", *self.notes])
        since = ", ".join(f"{before} -> {now}" for before, now in self.commits)
        kinds = Counter(change.kind for change in self.changes)
        moved = [f"{kinds[kind]} {words[kinds[kind] > 1]}" for kind, words in KINDS.items()
                 if kind in kinds] or ["nothing moved beyond rounding"]
        first = [f"first {self.changes[0]}"] if self.changes else []
        return f"{since}, {self.compared} compared: " + "; ".join(
            [", ".join(moved), *first, *self.notes])


def compare(records, earlier, notes=()):
    """``Comparison`` of ``Record`` s of results with the last of some earlier ones that has the
    same result of another commit.

    Timings of another machine are not compared.
    """
    found = Comparison(notes=list(notes))
    for record in records:
        for result, entry in record.entries.items():
            if last := _last(earlier, record.commit, result, entry.date):
                _compare_entry(found, result, (last.commit, last.entries[result]),
                               (record.commit, entry))
    found.changes.sort(key=lambda change: list(KINDS).index(change.kind))
    found.notes = list(dict.fromkeys(found.notes))
    return found


def table(comparison):
    """All changes as a table of the page."""
    return Table("", ("what", "result", "before", "now", "since", "commit", "moved"),
                 [[change.name, change.result, change.before, change.now, change.since,
                   change.commit, change.kind] for change in comparison.changes])


def _last(records, commit, result, date):
    """The newest record of another commit that has a result, none newer than ``date``."""
    older = [record for record in records if record.commit != commit
             and result in record.entries and record.entries[result].date <= date]
    return max(older, key=lambda record: record.entries[result].date, default=None)


def _compare_entry(found, result, before, now):
    (since, old), (commit, new) = before, now
    since, commit = _short(since), _short(commit)
    found.commits[since, commit] = None
    found.notes += [f"{name} {old.versions.get(name, 'none')} -> {version}"
                    for name, version in new.versions.items() if old.versions.get(name) != version]
    moved = _numbers(old, new)
    found.compared += len(new.numbers)
    if old.machine == new.machine:
        moved += _timings(old.timings, new.timings)
        found.compared += len(new.timings)
    elif new.timings:
        found.notes.append("timings of another machine are not compared")
    found.changes += [Change(kind, result, *words, since, commit) for kind, *words in moved]


def _numbers(old, new):
    """(kind, name, before, now) of the numbers of two entries that moved."""
    moved = []
    for name in dict.fromkeys((*old.numbers, *new.numbers)):
        if name not in new.numbers:
            moved.append(("gone", name, _shown(old.numbers[name]), "–"))
        elif name not in old.numbers:
            moved.append(("new", name, "–", _shown(new.numbers[name])))
        else:
            verdicts = old.verdicts.get(name), new.verdicts.get(name)
            values = old.numbers[name], new.numbers[name]
            if verdicts[0] != verdicts[1]:
                moved.append(("fell" if _fell(*verdicts) else "verdict", name, *(
                    f"{value}, {verdict or 'no verdict'}"
                    for value, verdict in zip(_apart(*values), verdicts))))
            elif _differ(*values, ENERGY if name.endswith("[J]") else DERIVED):
                moved.append(("number", name, *_apart(*values)))
    return moved


def _timings(old, new):
    """The same of timings whose quartiles lie apart."""
    return [("timing", name, str(old[name]), str(now)) for name, now in new.items()
            if name in old and (now.q1 > old[name].q3 or now.q3 < old[name].q1)
            and abs(now.median - old[name].median) > TIMING * old[name].median]


def _fell(before, now):
    """Whether a verdict is worse than before, and no agreement any more."""
    order = list(VERDICTS)
    return now in FALLEN and before in order and order.index(now) < order.index(before)


def _differ(before, now, rounding):
    """Whether two numbers differ by more than rounding; None stands for a run that failed."""
    if before is None or now is None:
        return before is not now
    return abs(now - before) > max(ROUNDING, rounding * max(abs(before), abs(now)))


def _apart(before, now):
    """Both numbers with so many digits, four at least, that they differ if they do."""
    texts = [tuple(_shown(value, digits) for value in (before, now)) for digits in range(4, 18)]
    return next((pair for pair in texts if pair[0] != pair[1]), texts[0])


def _shown(value, digits=4):
    return "none" if value is None else f"{value:.{digits}g}"


def _short(commit):
    """A commit of ten digits, marked if its sources were edited."""
    digits, *edited = commit.split("-", 1)
    return "-".join([digits[:10], *edited]) if len(digits) == 40 else commit
