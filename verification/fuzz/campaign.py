"""Tries of a target: in this process, or many in a worker process that may hang or die."""

import contextlib
import multiprocessing
import random
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from corovec import AccuracyWarning, ResultFileWarning, StabilityWarning

TRY_SECONDS = 60.0
"""A try that takes longer hangs."""

PREPARATION_SECONDS = 600.0
"""Time to compile the kernels and to make what tries start from."""

ENDLESS = 10**9


class Fault(AssertionError):
    """What must not be, in one line."""


class Target(NamedTuple):
    """What is tried.

    Attributes:
        name: of the target.
        claim: what must hold.
        prepare: function of an empty folder; what all tries start from.
        attempt: function of a ``random.Random``, of what was prepared and of an empty folder, the
            current one; the kind of the outcome, or whatever it raises is a failure.
    """

    name: str
    claim: str
    prepare: Callable
    attempt: Callable


def once(target, prepared, seed, number):
    """The outcome of one try.

    Raises:
        Fault: the target says so, or something warned that does not speak to users.
        Exception: any other.
    """
    chance = random.Random(f"{seed} {target.name} {number}")
    with (tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder),
          warnings.catch_warnings(record=True) as told):
        warnings.simplefilter("always")
        outcome = target.attempt(chance, prepared, Path(folder))
    for warning in told:
        if not issubclass(warning.category, AccuracyWarning | ResultFileWarning | StabilityWarning):
            raise Fault(f"{warning.category.__name__}: {warning.message} "
                        f"({Path(warning.filename).name}:{warning.lineno})")
    return outcome


def campaign(target, seed, seconds, tries=ENDLESS):
    """Tries of a target until the time is over, in a worker process; a new one where it is lost.

    Returns:
        dict: ``name``, ``claim``, ``tries``, ``seconds``, ``outcomes`` (how many of each kind),
        ``failures`` (each its ``try`` and ``what``).
    """
    start, outcomes, failures, done = time.monotonic(), Counter(), [], 0
    while done < tries and time.monotonic() < start + seconds:
        for number, outcome, what in _worker(target, seed, range(done, tries), start + seconds):
            outcomes[outcome] += 1
            if what:
                failures.append({"try": number, "what": what})
            done = number + 1
    return {"name": target.name, "claim": target.claim, "tries": sum(outcomes.values()),
            "seconds": round(time.monotonic() - start, 1), "outcomes": dict(outcomes),
            "failures": failures}


def _worker(target, seed, numbers, end):
    """Yield ``(number, outcome, what)`` of the tries of a worker process, the last of which may be
    the one that it was lost with."""
    context = multiprocessing.get_context("spawn")
    receive, send = context.Pipe(duplex=False)
    with tempfile.TemporaryDirectory() as folder:
        process = context.Process(target=_tries, args=(target, seed, numbers, end, folder, send))
        process.start()
        send.close()
        lost = "cannot be prepared", PREPARATION_SECONDS
        number = numbers.start
        try:
            while receive.poll(lost[1]):
                if (told := receive.recv()) is not None:
                    yield told
                    number = told[0] + 1
                lost = "ends the process", TRY_SECONDS
            yield number, "failed", f"hangs: not over after {lost[1]:g} s"
        except EOFError:
            process.join()
            if process.exitcode:
                yield number, "failed", f"{lost[0]}: exit code {process.exitcode}"
        finally:
            process.kill()
            process.join()


def _tries(target, seed, numbers, end, folder, pipe):
    tempfile.tempdir = folder
    prepared = target.prepare(Path(tempfile.mkdtemp()))
    pipe.send(None)
    for number in numbers:
        if time.monotonic() > end:
            break
        try:
            pipe.send((number, once(target, prepared, seed, number), None))
        except Exception as error:
            pipe.send((number, "failed", described(error)))


def described(error):
    """An error in one line, with its place in the source."""
    text = " ".join(str(error).split())[:300]
    if isinstance(error, Fault):
        return text
    last = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {text} ({Path(last.filename).name}:{last.lineno})"
