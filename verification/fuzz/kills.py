"""Runs that are killed at any moment and resumed: the bits of one that never stopped."""

import os
import signal
import time
import warnings

import h5py
import numpy as np

from corovec import Settings, StaticSettings, arc_length, line_load, load_control, simulate
from corovec.verification.models import cross_code_plate
from corovec.verification.shells import roof, strip

from .campaign import Target


def dynamic(path):
    simulate(cross_code_plate(1), Settings(dt=2e-3, end_time=0.2, frame_every=2), output=path,
             resume=True)


def controlled(path):
    model, _ = strip(10.0, 4, lambda X, tip: line_load(X, tip, (0.0, 0.0, 40.0)))
    load_control(model, np.linspace(0.1, 1.0, 10), StaticSettings(max_iterations=4), output=path,
                 resume=True)


def followed(path):
    """Outgrows the room of its file."""
    arc_length(roof(2, 12.7), 0.25, lambda factor, u: u[0, 2] < -26.0, output=path, resume=True)


def datasets(path):
    """Every dataset of a file; of the checkpoints, whose places depend on when frames were
    written, the newest."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.update({name: item[...]})
                        if isinstance(item, h5py.Dataset) else None)
        newest = int(np.argmax(found["checkpoint/stamp"][:, 0]))
        found |= {f"checkpoint/{name}": found[f"checkpoint/{name}"][newest]
                  for name in ("state", "stamp")}
        found["NSteps"] = file["VTKHDF/Steps"].attrs["NSteps"]
    return found


def assert_same_bits(first, second):
    a, b = datasets(first), datasets(second)
    assert a.keys() == b.keys()
    for name in a:
        assert np.asarray(a[name]).tobytes() == np.asarray(b[name]).tobytes(), name


def prepare(folder):
    """``[(run, file of an uninterrupted one, its seconds)]``."""
    def whole(run):
        path = folder / f"{run.__name__}.h5"
        run(folder / "first.h5")  # which loads the kernels
        (folder / "first.h5").unlink()
        clock = time.perf_counter()
        run(path)
        return run, path, time.perf_counter() - clock

    return [whole(run) for run in (dynamic, controlled, followed)]


def started(run, path):
    """A copy of this process that does the run; its number."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # threads of BLAS, which has no task
        child = os.fork()
    if not child:
        status = 1
        try:
            run(path)
            status = 0
        finally:
            os._exit(status)
    return child


def attempt(chance, runs, folder):
    run, whole, seconds = chance.choice(runs)
    path, kills = folder / "run.h5", 0
    for _ in range(chance.randrange(1, 5)):
        child = started(run, path)
        time.sleep(chance.random() * seconds)
        os.kill(child, signal.SIGKILL)
        kills += os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) != 0
    run(path)
    assert_same_bits(whole, path)
    return f"{run.__name__}, {kills} kills"


TARGET = Target("kills", "a run that is killed and resumed ends with the same bits", prepare,
                attempt)
