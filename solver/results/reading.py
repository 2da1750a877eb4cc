"""Reading a result file, and what it must hold."""

import json
from contextlib import contextmanager

import h5py
import numpy as np

from ..errors import ResultFileError
from ..signatures import File, checked
from .checkpoint import newest_slot
from .files import reason, regular_file

FORMAT = "corovec-run-3"

DESCRIBED = ("case", "settings", "solver", "elements", "nodes", "versions", "machine")
COLUMNS = ("time", "kinetic_energy", "strain_energy", "external_work", "linear_momentum",
           "angular_momentum", "angular_momentum_printed", "iterations")
STATIC_COLUMNS = ("factor", "strain_energy")
FRAMES = ("displacement", "normal", "strain_energy")
"""What a result file must hold to be read."""


@checked
def read(path: File):
    """Contents of a result file, of dynamics or statics, up to its newest checkpoint.

    Returns:
        dict: ``description`` (dict), ``step``, ``n_steps`` (there is room for), ``history``
        (structured array of step + 1 rows), ``frame_steps`` (n,), ``displacement`` and ``normal``
        (n, n_nodes, 3), ``strain_energy`` (n, n_elem), in statics ``reaction`` (n, n_nodes, 3),
        ``nodes``, ``quads``.

    Raises:
        InputError: no path.
        ResultFileError: no such file, not a corovec file, or damaged.
    """
    path, _ = regular_file(path)
    with opened(path, "r") as file:
        description = read_description(file, path)
        step, _ = newest_slot(file, path)
        planned = file["frames/step"][:]
        written = int(np.sum(planned <= step))
        frames = {}
        for name, values in file["frames"].items():
            size = len(values) // len(planned)
            frames[name] = values[:written * size].reshape(written, size, *values.shape[1:])
        contents = {
            "description": description, "step": step, "n_steps": int(planned[-1]),
            "history": read_history(file, step), "frame_steps": frames.pop("step").ravel(),
            **frames, "nodes": file["model/nodes"][:], "quads": file["model/quads"][:]}
        _check_contents(contents)
        return contents


@contextmanager
def opened(path, mode):
    if not path.exists():
        raise ResultFileError(f"{path} does not exist")
    try:
        with h5py.File(path, mode, locking=False) as file:
            yield file
    except PermissionError:
        raise ResultFileError(f"{path} cannot be opened: no permission") from None
    except (OSError, KeyError, RuntimeError, TypeError, ValueError, AttributeError) as error:
        raise ResultFileError(f"{path} is damaged or not a result file: {reason(error)}") from None


def read_description(file, path):
    if file.attrs.get("format") != FORMAT:
        raise ResultFileError(f"{path} was not written by this version of corovec (format "
                              f"{file.attrs.get('format')!r}, needed {FORMAT!r})")
    return json.loads(file.attrs["description"])


def read_history(file, step):
    """History rows up to ``step``."""
    group = file["history"]
    history = np.zeros(step + 1, [(name, column.dtype, column.shape[1:])
                                  for name, column in group.items()])
    for name, column in group.items():
        history[name] = column[:step + 1]
    return history


def _check_contents(contents):
    """Raise a ValueError that names what of the contents of a file is missing or impossible."""
    columns = contents["history"].dtype.names
    wanted = STATIC_COLUMNS if "factor" in columns else COLUMNS
    for place, there, names in (("description", contents["description"], DESCRIBED),
                                ("history", columns, wanted), ("frames", contents, FRAMES)):
        for name in names:
            if name not in there:
                raise ValueError(f"{place} without {name}")
    for name in (*FRAMES, "nodes"):
        if not np.isfinite(contents[name]).all():
            raise ValueError(f"{name} is not finite")
    quads, n_nodes = contents["quads"], len(contents["nodes"])
    if quads.min() < 0 or quads.max() >= n_nodes:
        raise ValueError(f"an element has node {quads.max()}, there are {n_nodes} nodes")
