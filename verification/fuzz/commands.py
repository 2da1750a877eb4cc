"""Random options and values on the command line: one line of error, no traceback."""

import contextlib
import io
import sys
from unittest import mock

import click

from corovec import Settings, simulate, warm_up
from corovec.benchmarks import FOLDER
from corovec.solver.cli import cli, main
from corovec.verification.models import cross_code_plate

from .campaign import Fault, Target

SHORT = ("--dt", "0.01", "--end-time", "0.02")

CHANGED = (
    ("run", "l-plate", "--elements", "30", *SHORT),
    ("run", "shell.toml", *SHORT, "--output", "new.h5"),
    ("run", "l-plate", *SHORT, "--output", "run.h5", "--overwrite", "--json"),
    ("info", "run.h5"), ("info", "run.h5", "--json"), ("list",), ("list", "--json"),
    ("claims", "l-plate", "run.h5"), ("nonsense",))
"""Commands that end soon whatever is changed in them."""

REFUSED = (
    ("verify", "nonsense"), ("converge", "nonsense"), ("calibrate", "nonsense", "--elements", "30"),
    ("time", "nonsense"), ("reproduce", "nonsense"), ("animate", "none.h5", "--output", "film.gif"),
    ("plot", "none.h5"), ("numbers", "none"))
"""Commands that take long, but not with these arguments, which further options do not change."""

TEXTS = ("", " ", "-1", "0", "1", "3", "30", "nan", "inf", "-inf", "1e400", "1e-400", "0x10",
         "1_0", "\u0663", "1,5", "None", "true", "x" * 5000, "a\nb", "\x1b[31m", "\udcff", "{}",
         "%s", "--", "-", "none/none", "/", ".", "/dev/null", "run.h5", "shell.toml", "l-plate",
         "quasi", "newmark", "full", "modified", "skyline", "dense", "average", "global", "strain",
         "0.5", "0.01", "1e-30", "1e29", "9" * 20)



GOOD = ("1", "3", "0.5", "0.01", "0.02", "quasi", "full", "modified", "skyline", "dense", "average",
        "global", "strain")
"""Values that one option or another takes."""


def prepare(folder):
    """The bytes of a result file and of a model file."""
    warm_up()
    simulate(cross_code_plate(1), Settings(dt=0.01, end_time=0.02), output=folder / "run.h5")
    return {"run.h5": (folder / "run.h5").read_bytes(),
            "shell.toml": (FOLDER / "l-plate.toml").read_bytes()}


def option(chance, command):
    """An option of a command, with any value."""
    found = cli.get_command(click.Context(cli), command)
    parameters = found.get_params(click.Context(found)) if found else []
    names = [name for parameter in parameters for name in parameter.opts if name.startswith("--")]
    name = chance.choice([*names, "--nonsense"])
    return chance.choice((name, f"{name}={chance.choice(chance.choice((TEXTS, GOOD)))}"))


def arguments(chance):
    """A command line."""
    if chance.random() < 0.3:
        line = list(chance.choice(REFUSED))
        return [*line, *(option(chance, line[0]) for _ in range(chance.randrange(1, 3)))]
    line = list(chance.choice(CHANGED))
    for _ in range(chance.choice((1, 1, 1, 2, 3))):
        at = chance.randrange(len(line))
        line[at:at + chance.randrange(2)] = [
            option(chance, line[0]) if at and chance.random() < 0.8 else chance.choice(TEXTS)]
    return line


def called(line):
    """Exit status, and what a command writes to standard error, in this process."""
    out, err = (io.TextIOWrapper(io.BytesIO(), "utf-8", errors, write_through=True)
                for errors in ("strict", "backslashreplace"))
    with (mock.patch.object(sys, "argv", ["corovec", *line]), contextlib.redirect_stdout(out),
          contextlib.redirect_stderr(err)):
        try:
            main()
            status = 0
        except SystemExit as end:
            status = end.code or 0
    return status, err.buffer.getvalue().decode()


def attempt(chance, files, folder):
    for name, data in files.items():
        (folder / name).write_bytes(data)
    line = arguments(chance)
    if not line or line[0] in ("", "--") or line[0] not in NAMES:
        line = ["nonsense", *line]
    try:
        status, said = called(line)
    except Exception as error:
        error.args = (f"{_shown(line)}: {error}",)
        raise
    errors = [text for text in said.splitlines() if not text.startswith("corovec: warning: ")]
    good = not errors if status == 0 else (
        len(errors) == 1 and errors[0].startswith("corovec: error: "))
    if status not in (0, 1, 2) or not good:
        raise Fault(f"{_shown(line)}: status {status}, {said!r}")
    return f"status {status}"


NAMES = {line[0] for line in (*CHANGED, *REFUSED)}


def _shown(line):
    return " ".join(repr(text[:40]) for text in line)


TARGET = Target("commands", "any command line ends with status 0, 1 or 2 and one line of error",
                prepare, attempt)
