"""A run of a campaign: what is computed, and the hash that names its result."""

import hashlib
import json
from dataclasses import asdict, dataclass
from functools import cache, cached_property
from importlib import metadata
from pathlib import Path

from corovec import InputError, Model, Settings, StepError, solver
from corovec.benchmarks import load_case
from corovec.solver.checks import shown
from corovec.solver.fields import check_fields
from corovec.solver.runtime.provenance import fingerprint


@dataclass(frozen=True, eq=False)
class Run:
    """A model with the settings to run it with.

    Attributes:
        model: ``Model``.
        settings: ``Settings``.
        case: name of its benchmark, if any.
        most_halvings: more of them end it with a ``StepError``; where it comes to its end, its
            result is what it is without, and so is its ``key``.

    Raises:
        InputError: no model, settings or name.
    """

    model: Model
    settings: Settings
    case: str | None = None
    most_halvings: int | None = None

    def __post_init__(self):
        check_fields(self)
        if self.most_halvings is not None and self.most_halvings < 0:
            raise InputError(f"most_halvings must not be negative, is {self.most_halvings}")

    @cached_property
    def key(self):
        """SHA-256 of all that the result depends on: model, settings, case, version of the code."""
        content = {"case": self.case, "fingerprint": fingerprint(self.model),
                   "settings": asdict(self.settings), "code": code_version()}
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()

    def watch(self, halvings):
        """What ``simulate`` calls after every step of a run that has had so many ``halvings``.

        Raises:
            StepError: more of them than ``most_halvings``.
        """
        def count(step, n_steps, row):
            nonlocal halvings
            halvings += int(row["halvings"])
            if halvings > self.most_halvings:
                raise StepError(f"given up at t = {row['time']:.6g} s, after {halvings} halvings")
        return count

    @property
    def elements(self):
        """Number of elements of its mesh."""
        return len(self.model.quads)

    @property
    def work(self):
        """Elements times steps, a measure of the time it takes."""
        return self.elements * self.settings.n_steps

    def __str__(self):
        s = self.settings
        return (f"{self.case or 'model'}, {self.elements} elements, dt {s.dt:g} s, end time "
                f"{s.end_time:g} s, {s.scheme.name}"
                + (f", rho_inf {s.scheme.rho_inf:g}" if s.scheme.name == "quasi" else ""))


def as_run(name, item):
    """``item``, called ``name`` in errors, as a ``Run``: itself, or a pair of a model, or a case's
    name, and settings.

    A name stands for the default mesh of its case.

    Raises:
        InputError: anything else.
    """
    if isinstance(item, Run):
        return item
    try:
        model, settings = item
    except (TypeError, ValueError):
        raise InputError(f"{name} must be a Run or a pair (model or case, settings), is "
                         f"{shown(item)}") from None
    case = model if isinstance(model, str) else None
    if case is not None:
        definition = load_case(case)
        model = definition.model(definition.elements)
    if not isinstance(model, Model) or not isinstance(settings, Settings):
        raise InputError(f"{name} must be a pair (model or case, settings), is a pair of "
                         f"{type(model).__name__} and {type(settings).__name__}")
    return Run(model, settings, case)


@cache
def code_version(package=solver, endings=(".py",)):
    """Version of corovec and a digest of a package's files with such endings, by default its code:
    an edit makes new results."""
    folder, digest = Path(package.__file__).parent, hashlib.sha256()
    for source in sorted(path for path in folder.rglob("*") if path.suffix in endings):
        digest.update(source.relative_to(folder).as_posix().encode() + source.read_bytes())
    return f"{metadata.version('corovec')}+{digest.hexdigest()[:16]}"
