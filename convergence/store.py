"""Result files of a campaign: one a run, named by its hash, stamped when it is finished.

The stamp holds what the solver's own file does not: how long it took, and from which step on.
"""

import time
from dataclasses import asdict

import h5py
import numpy as np

from corovec import ResultFileError, read, simulate
from corovec.solver.runtime.provenance import fingerprint

STAMP = np.dtype([("seconds", "f8"), ("cpu", "f8"), ("begun_at", "i8")])


def record(run, path):
    """Run (or finish) ``run`` into the file ``path`` and stamp it."""
    begun_at, halvings = 0, 0
    if path.exists():
        contents = read(path)
        begun_at, halvings = contents["step"], int(contents["history"]["halvings"].sum())
    clock = time.process_time()
    watched = {} if run.most_halvings is None else {"progress": run.watch(halvings)}
    result = simulate(run.model, run.settings, output=path, resume=True, case=run.case, **watched)
    stamp = np.array((result.seconds.total, time.process_time() - clock, begun_at), dtype=STAMP)
    with h5py.File(path, "r+", locking=False) as file:
        file.attrs["campaign"] = stamp


def inspect(path, run):
    """Contents of the finished result of ``run``, with its ``stamp``; None if it is not finished.

    Raises:
        ResultFileError: the file is damaged or belongs to another run.
    """
    if not path.exists():
        return None
    contents = read(path)
    description = contents["description"]
    if (description["fingerprint"], description["settings"]) != (fingerprint(run.model),
                                                                 asdict(run.settings)):
        raise ResultFileError(f"{path} holds another run")
    with h5py.File(path, "r", locking=False) as file:
        stamp = file.attrs.get("campaign")
    if stamp is None:
        return None
    if getattr(stamp, "dtype", None) != STAMP:
        raise ResultFileError(f"{path} is damaged: the stamp of its campaign has changed")
    if contents["step"] < contents["n_steps"]:
        raise ResultFileError(f"{path} is damaged: its last checkpoint is gone")
    contents["stamp"] = dict(zip(STAMP.names, stamp.item()))
    return contents


def set_aside(path):
    """Rename a damaged file so that its place is free; returns the new name."""
    k = 0
    while (aside := path.with_suffix(f".damaged-{k}")).exists():
        k += 1
    return path.rename(aside)
