"""Result files of a campaign: one a run, named by its hash, stamped when it is finished.

The stamp holds what the solver's own file does not: seconds, and a digest of the histories by which
later damage is noticed.
"""

import hashlib
import json
from dataclasses import asdict

import h5py

from corovec import ResultFileError, read, simulate
from corovec.solver.runtime.provenance import fingerprint

STAMP = "campaign"


def record(run, path):
    """Run (or finish) ``run`` into the file ``path`` and stamp it."""
    begun_at = read(path)["step"] if path.exists() else 0
    result = simulate(run.model, run.settings, output=path, resume=True, case=run.case)
    stamp = {"key": run.key, "seconds": result.seconds.total, "begun_at": begun_at,
             "digest": _digest(result.history)}
    with h5py.File(path, "r+", locking=False) as file:
        file.attrs[STAMP] = json.dumps(stamp)


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
        text = file.attrs.get(STAMP)
    if text is None:
        return None
    contents["stamp"] = json.loads(text)
    if contents["stamp"]["digest"] != _digest(contents["history"]):
        raise ResultFileError(f"{path} is damaged: its histories have changed")
    return contents


def set_aside(path):
    """Rename a damaged file so that its place is free; returns the new name."""
    k = 0
    while (aside := path.with_suffix(f".damaged-{k}")).exists():
        k += 1
    return path.rename(aside)


def _digest(history):
    return hashlib.sha256(history.tobytes()).hexdigest()
