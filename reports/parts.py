"""The parts of a reproduction: one ``corovec`` command each, its result, and how it ended."""

import hashlib
import json
import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import NoneType
from typing import NamedTuple

from corovec import (
    InputError,
    ResultFileError,
    benchmarks,
    convergence,
    solver,
    timing,
    verification,
)
from corovec.convergence.run import code_version
from corovec.solver.results.files import replacing
from corovec.timing.report import NAMES as TIMINGS
from corovec.verification.registry import CASES

from . import drawings
from .recording import Recording

PLAN = Path(__file__).with_name("plan.toml")

SIZES = {"quick": "coarse meshes and a part of the paper's simulated times: minutes",
         "full": "all meshes over the paper's simulated times: hours"}
"""Sizes, and what they are."""

SOURCES = (".py", ".toml", ".json")
"""Files of a package on which results depend: code, and the data that it reads."""

LONGEST = ("verify-mutants", "converge-hemisphere", "converge-plates", "run-plates-432",
           "conserve", "verify-rotations", "verify-nonlinear")
"""Parts that are begun before the others, the longest first, so that none is waited for at last."""

LEFT_OUT = {"quick": ("verify-mutants", "time-growth")}
"""Parts that a size does not run: they alone would take as long as all the others."""


@dataclass(frozen=True)
class Part:
    """One command and its result.

    Attributes:
        name: names its stamp and its log.
        kind: ``verify``, ``converge``, ``conserve``, ``claims``, ``time`` or ``run``.
        command: arguments of ``corovec``.
        result: the file that it writes.
        packages: on whose sources, beside the solver's and the benchmarks', the result depends.
        left_out: whether this size leaves it out.
        inputs: parts whose results are arguments too, as far as they are finished.
    """

    name: str
    kind: str
    command: tuple
    result: Path
    packages: tuple
    left_out: bool = False
    inputs: tuple = ()

    @property
    def alone(self):
        """Timings share the machine with nothing else; iterations are counted, not timed."""
        return self.kind == "time" and self.name != "time-iterations"

    @property
    def judged(self):
        """Exit status 1 of these says that a number deviates, and the result is whole."""
        return self.kind in ("verify", "converge", "conserve", "claims")

    @property
    def code(self):
        """Versions of the sources that the result depends on."""
        return [code_version(package, SOURCES) for package in
                (solver, benchmarks, *self.packages)]

    def read(self):
        """Contents of the result: a ``Recording`` of a run, else an object of JSON.

        Raises:
            ResultFileError: it is missing, damaged or incomplete.
        """
        if self.kind == "run":
            result = Recording.open(self.result)
            complete = result.contents["step"] == result.contents["n_steps"]
        else:
            try:
                result = json.loads(self.result.read_text(encoding="utf-8"))
            except (OSError, ValueError) as error:
                raise ResultFileError(f"{self.result} is missing or damaged: {error}") from None
            complete = result.get("complete", True)
        if not complete:
            raise ResultFileError(f"{self.result} is not complete")
        return result

    def whole(self):
        """Whether the result can be read; that of a run, which may be large, only exists."""
        try:
            return self.result.exists() if self.kind == "run" else bool(self.read())
        except ResultFileError:
            return False

    def shown(self):
        """The command as one types it, without where its files go."""
        words = [*self.command, *(part.result.name for part in self.inputs)]
        for option in ("--output", "--jobs", "--frame-every"):
            if option in words:
                k = words.index(option)
                del words[k:k + 2]
        return "corovec " + " ".join(word for word in words if word != "--overwrite")


def parts(size, folder):
    """All ``Part`` s of a size, the timings first; results go into ``folder``.

    Raises:
        InputError: unknown size.
    """
    if size not in SIZES:
        raise InputError(f"size '{size}' is unknown, must be one of: {', '.join(SIZES)}")
    runs = list(_runs(size, folder))
    return [*_timings(size, folder), *runs, *_claims(folder, runs), *_studies(size, folder),
            *_suites(size, folder)]


@cache
def plan(size):
    """``{case: runs}`` behind the figures (``plan.toml``)."""
    with open(PLAN, "rb") as file:
        return tomllib.load(file)[size]


def select(everything, names):
    """The parts called ``names``, or of such a kind; all without names.

    Raises:
        InputError: a name that no part has.
    """
    known = {part.name for part in everything} | {part.kind for part in everything}
    for name in names:
        if name not in known:
            raise InputError(f"part '{name}' is unknown, must be one of: "
                             f"{', '.join(part.name for part in everything)}")
    return [part for part in everything
            if part.name in names or part.kind in names or not names and not part.left_out]


class Stamps:
    """How parts ended, one JSON file a part in ``folder``."""

    def __init__(self, folder):
        self.folder = folder

    def read(self, part):
        """The stamp of a part; None if it never began, or if that is no stamp."""
        try:
            stamp = json.loads(self._path(part).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        whole = isinstance(stamp, dict) and {"command", "code", "status", "seconds"} <= set(stamp)
        return stamp if whole and isinstance(stamp["seconds"], (int, float, NoneType)) else None

    def write(self, part, status, seconds=None, message=""):
        """Note what became of a part."""
        stamp = {"part": part.name, "command": self._command(part), "code": part.code,
                 "inputs": self._inputs(part), "status": status, "seconds": seconds,
                 "message": message,
                 "sha256": _digest(part.result) if status == "finished" else None}
        with replacing(self._path(part)) as partial:
            partial.write_text(json.dumps(stamp, indent=1), encoding="utf-8")

    def log(self, part):
        """The file of what a part printed."""
        return self.folder / f"{part.name}.log"

    def current(self, part):
        """The stamp of a part if it is of this command, these sources and inputs, else None."""
        stamp = self.read(part)
        same = stamp and (stamp["command"], stamp["code"], stamp.get("inputs", {})) == (
            self._command(part), part.code, self._inputs(part))
        return stamp if same else None

    def input_files(self, part):
        """The results of the inputs of a part that are finished."""
        return [each.result for each in part.inputs if each.name in self._inputs(part)]

    def finished(self, part):
        """Whether the part need not be run again."""
        stamp = self.current(part)
        return bool(stamp) and stamp["status"] == "finished" and self.intact(part, stamp)

    @staticmethod
    def intact(part, stamp):
        """Whether the result of a finished part is there as it was when it finished."""
        return _digest(part.result) == stamp.get("sha256") is not None

    def _command(self, part):
        """The command with its files named from the folder of all results, which may be moved."""
        return [word.removeprefix(str(self.folder.parent)) for word in part.command]

    def _inputs(self, part):
        """``{name: SHA-256}`` of the results of the inputs that are finished, as they were then."""
        stamps = {each.name: self.current(each) for each in part.inputs}
        return {name: stamp["sha256"] for name, stamp in stamps.items()
                if stamp and stamp["status"] == "finished"}

    def _path(self, part):
        return self.folder / f"{part.name}.json"


def _digest(path):
    """SHA-256 of a file; None if it cannot be read."""
    try:
        with open(path, "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return None


def status(part, stamps):
    """How a part stands, in words."""
    stamp = stamps.read(part)
    if stamp is None:
        return "left out" if part.left_out else "not run"
    if not stamps.current(part):
        return f"{stamp['status']}, earlier sources{' or runs' * bool(part.inputs)}"
    damaged = stamp["status"] == "finished" and not stamps.intact(part, stamp)
    return "finished, damaged" if damaged else stamp["status"]


class Lack(NamedTuple):
    """Why a result is not shown: a verdict of the page, and the reason in words."""

    verdict: str
    why: str


class Results:
    """What the parts of a size wrote, as far as they are finished.

    What a part wrote that failed since, was interrupted or had earlier sources is not shown.
    """

    def __init__(self, size, folder):
        self.parts = {part.name: part for part in parts(size, folder)}
        self.stamps = Stamps(folder / "parts")

    def read(self, name):
        """(contents, []) of a part, or (None, [``Lack``])."""
        part = self.parts[name]
        stamp = self.stamps.current(part) or {}
        ended = stamp.get("status")
        if ended == "finished":
            try:
                if not self.stamps.intact(part, stamp):
                    raise ResultFileError(f"{part.result} is missing or damaged: it is not what "
                                          "its part wrote")
                return part.read(), []
            except ResultFileError as error:
                return None, [Lack("failed", str(error))]
        verdict = ended if ended == "failed" else "left out" if part.left_out else "not run"
        return None, [Lack(verdict, f"{name}: {stamp.get('message') or status(part, self.stamps)}")]


def _timings(size, folder):
    for name in TIMINGS:
        own = folder / "timing" / name
        yield Part(f"time-{name}", "time",
                   ("time", name, "--size", size, "--output", str(own), "--overwrite"),
                   own / "timing.json", (timing, verification),
                   f"time-{name}" in LEFT_OUT.get(size, ()))


def _runs(size, folder):
    for case, runs in plan(size).items():
        for run in sorted(runs, key=lambda run: -run["elements"]):
            path = run_file(folder, case, run["elements"])
            options = [word for name in ("elements", "dt", "end_time", "frame_every")
                       for word in (f"--{name.replace('_', '-')}", f"{run[name]:g}")]
            yield Part(f"run-{case}-{run['elements']}", "run",
                       ("run", case, *options, "--output", str(path)), path, ())


def _claims(folder, runs):
    for case in drawings.benchmarks():
        path = folder / "claims" / f"{case}.json"
        yield Part(f"claims-{case}", "claims",
                   ("claims", case, "--output", str(path), "--overwrite"), path,
                   (convergence, verification),
                   inputs=tuple(part for part in reversed(runs) if part.command[1] == case))


def _studies(size, folder):
    for case in drawings.benchmarks():
        yield Part(f"converge-{case}", "converge",
                   ("converge", case, "--size", size, "--jobs", "1", "--output",
                    str(folder / "convergence")), study_file(folder, case, size),
                   (convergence, verification))
    yield Part("conserve", "conserve",
               ("conserve", "--size", size, "--jobs", "1", "--output",
                str(folder / "conservation")), conservation_file(folder, size),
               (convergence, verification))


def _suites(size, folder):
    for suite in suite_names():
        path = suite_file(folder, suite)
        yield Part(f"verify-{suite}", "verify",
                   ("verify", suite, "--jobs", "1", "--output", str(path),
                    "--overwrite"), path, (verification,),
                   f"verify-{suite}" in LEFT_OUT.get(size, ()))


def suite_names():
    """Names of the verification suites."""
    return tuple(dict.fromkeys(case.suite for case in CASES))


def run_file(folder, case, elements):
    """Result file of a run behind the figures."""
    return folder / "runs" / f"{case}-{elements}.h5"


def study_file(folder, case, size):
    """Tables of a convergence study, as ``corovec converge`` writes them."""
    return folder / "convergence" / case / size / "study.json"


def conservation_file(folder, size):
    """Tables of the study of conservation, as ``corovec conserve`` writes them."""
    return folder / "conservation" / size / "study.json"


def suite_file(folder, suite):
    """Verdicts of a verification suite."""
    return folder / "verification" / f"{suite}.json"
