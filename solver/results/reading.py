"""Reading a result file: what it holds is checked first, and what is read against its checksums."""

from contextlib import contextmanager
from typing import NamedTuple

import h5py
import numpy as np

from ..errors import ResultFileError, ResultFileWarning, warn
from ..signatures import File, checked
from .checkpoint import valid_slots
from .checksums import intact, of_fixed
from .description import parsed
from .files import reason, regular_file
from .layout import TIMES, Sizes, checked_sizes, columns
from .vtkhdf import frames_shown

NUMBER = 10

FORMAT = f"corovec-run-{NUMBER}"

OLDER = tuple(f"corovec-run-{k}" for k in range(1, NUMBER))


@checked
def read(path: File):
    """Contents of a result file, of dynamics or statics, up to its newest checkpoint.

    Everything is checked against the checksums with which it was written.  Where the newest
    checkpoint or its frame is damaged, the one before counts, with a ``ResultFileWarning``.

    Returns:
        dict: ``description`` (dict; ``joints`` and ``bodies`` in it tell of these), ``step``,
        ``n_steps`` (there is room for), ``history``
        (structured array of step + 1 rows, a probe's columns being NAME_u and NAME_v),
        ``frame_steps`` (n,), ``displacement`` and ``normal`` (n, n_nodes, 3), ``director``
        (n, n_directors, 3), ``strain_energy`` (n, n_elem), of a shell with supports ``reaction``
        and ``reaction_moment`` (n, n_nodes, 3), where they were asked for the stresses
        ``membrane_force``, ``moment``, ``von_mises`` (n, n_elem, 3), ``shear_force`` (n, n_elem, 2)
        and ``nodal_von_mises`` (n, n_nodes, 3), ``memory``, most that its process has had at a time
        [MB] (None: not told), and ``nodes``, ``quads``.

    Raises:
        InputError: no path.
        ResultFileError: no such file, not a corovec file, damaged, or one that reaches for other
            files.
    """
    path, _ = regular_file(path)
    with opened(path, "r") as file:
        stored = load(file, path, whole=True)
        sizes, n = stored.sizes, len(stored.frame_steps)
        fields = {name: stored.fields[name][:n * shape[0]].reshape(n, *shape)
                  for name, (_, shape) in sizes.fields.items()}
        return {"description": stored.description, "step": stored.step, "n_steps": sizes.steps,
                "history": stored.history, "frame_steps": stored.frame_steps,
                "director": fields["normal"], **fields, "memory": _memory(file),
                "nodes": file["model/nodes"][:], "quads": file["model/quads"][:]}


class Stored(NamedTuple):
    """What a file holds up to its newest good checkpoint.

    Attributes:
        sizes: ``Sizes``.
        description: of the run.
        step: of the checkpoint; packed: its state.
        history: rows up to there.
        plan: steps of all frames that there is room for.
        frame_steps: those of the frames that are written.
        fields: arrays, or datasets, of the frames by name.
    """

    sizes: Sizes
    description: dict
    step: int
    packed: np.ndarray
    history: np.ndarray
    plan: np.ndarray
    frame_steps: np.ndarray
    fields: dict


def load(file, path, whole=False):
    """What an open file holds, checked; ``whole``: all frames at once in memory.

    Raises:
        ResultFileError: of another format, or no checkpoint is intact.
        ValueError: what is missing, changed or impossible.
    """
    _check_format(file, path)
    sizes = checked_sizes(file)
    text = _description(file)
    if file.attrs.get("checksum") != of_fixed(file, text, sizes):
        raise ValueError("its description or mesh has changed")
    description, plan = parsed(text, sizes), _plan(file, sizes)
    slots = list(valid_slots(file))
    if not slots:
        raise ResultFileError(f"{path} is damaged: neither of its two checkpoints is intact")
    last = slots[0][0]
    n, history = _frames(plan, last), _history(file, sizes, last)
    fields = {name: file[f"frames/{name}"] for name in sizes.fields}
    if whole:
        fields = {name: values[:n * sizes.fields[name][1][0]] for name, values in fields.items()}
    good = intact(list(zip(file[TIMES][:n], file["frames/checksum"][:n])), plan, history,
                  [(fields[name], shape[0]) for name, (_, shape) in sizes.fields.items()])
    step, packed, n = _newest_good(slots, plan, good)
    if frames_shown(file) > n:
        warn(f"{path}: what follows step {step} is damaged or incomplete; that step is the newest "
             "good checkpoint", ResultFileWarning)
    _check_values(file, sizes, history[:step + 1])
    return Stored(sizes, description, step, packed, history[:step + 1], plan, plan[:n], fields)


@contextmanager
def opened(path, mode):
    """The file at ``path``; whatever turns out to be wrong with it is one ``ResultFileError``."""
    if not path.exists():
        raise ResultFileError(f"{path} does not exist")
    try:
        with h5py.File(path, mode, locking=False) as file:
            yield file
    except PermissionError:
        raise ResultFileError(f"{path} cannot be opened: no permission") from None
    except (OSError, LookupError, RuntimeError, TypeError, ValueError, ArithmeticError,
            AttributeError, MemoryError) as error:
        raise ResultFileError(f"{path} is damaged or not a result file: {reason(error)}") from None


def _check_format(file, path):
    given = file.attrs.get("format")
    given = given.decode(errors="replace") if isinstance(given, bytes) else given
    if isinstance(given, str) and given in OLDER:
        raise ResultFileError(f"{path} is of an older version of corovec (format {given}, this one "
                              f"reads {FORMAT}): repeat its run, or read it with that version")
    if not isinstance(given, str) or given != FORMAT:
        raise ResultFileError(f"{path} was not written by this version of corovec (format "
                              f"{given!r}, needed {FORMAT!r})")


def _description(file):
    """The text of the description."""
    place = file.attrs.get_id("description")
    if place.shape != () or place.dtype.kind != "S":
        raise ValueError("description is not a text")
    return bytes(file.attrs["description"])


def _memory(file):
    """Most memory that the run has had [MB], None where the file does not tell."""
    value = file.attrs.get("memory")
    if not isinstance(value, float) or not 0.0 < value < np.inf:
        return None
    return float(value)


def _plan(file, sizes):
    """Steps of all frames that there is room for."""
    plan = file["frames/step"][:]
    if plan[0] != 0 or plan[-1] != sizes.steps or np.any(np.diff(plan) <= 0):
        raise ValueError("frames/step does not ascend from the start to the last step")
    return plan


def _frames(plan, step):
    """How many frames there are up to a checkpoint, which is at one of them."""
    n = int(np.searchsorted(plan, step, side="right"))
    if plan[n - 1] != step:
        raise ValueError(f"its checkpoint is at step {step}, which has no frame")
    return n


def _newest_good(slots, plan, good):
    """(step, packed vector, frames up to there) of the newest slot all of whose frames, the first
    ``good`` ones, are as they were written; the start alone is no run to fall back to."""
    newest = slots[0][0]
    for step, packed in slots:
        n = _frames(plan, step)
        if n <= good and (step > 0 or newest == 0):
            return step, packed, n
    raise ValueError(f"frame {good}, or the history up to it, has changed: run it again; "
                     "those before are whole, h5py reads them")


def _history(file, sizes, step):
    """History rows up to ``step``."""
    history = np.zeros(step + 1, sizes.row)
    for name, place in columns(sizes.row).items():
        history[name] = file[place][:step + 1]
    return history


def _check_values(file, sizes, history):
    """Refuse numbers that are not finite, and nodes that are not there."""
    nodes, quads = file["model/nodes"][:], file["model/quads"][:]
    for name, values in (("nodes", nodes), *((name, history[name]) for name in sizes.row.names)):
        if not np.isfinite(values).all():
            raise ValueError(f"{name} is not finite")
    if quads.min() < 0 or quads.max() >= len(nodes):
        raise ValueError(f"an element has node {quads.max()}, there are {len(nodes)} nodes")
