"""One HDF5 file a run: histories, frames, checkpoints, and a view that ParaView opens.

The number of steps is known when a run starts, so every dataset is created at its full size and
its disk space is claimed at once; afterwards only numbers at fixed places change.  Two checkpoint
slots are written in turn, each valid only together with its checksum, and the file is closed
between writes.  So a run killed at any moment leaves a file that opens, and that resumes from the
newest valid slot.

Layout (SI units; row 0 of every history is t = 0):

- ``/history/NAME`` (n_steps + 1, ...): see ``HISTORY``;
- ``/frames/step`` (n_frames,), ``/frames/displacement`` and ``/frames/normal``
  (n_frames * n_nodes, 3), ``/frames/strain_energy`` (n_frames * n_elem,): frame after frame;
- ``/checkpoint/state`` (2, n), ``/checkpoint/stamp`` (2, 2): two packed states, each with its step
  and checksum; ``/model``: nodes and quads;
- ``/VTKHDF``: the frames again, as links, with the mesh and its time steps.
"""

import json
import os
import stat
import tempfile
import uuid
import zlib
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np

from .errors import ResultFileError
from .system import State

FORMAT = "corovec-run-2"

METADATA = 200_000
"""Bytes that the headers of a file take at most (measured: 36 kB)."""

HISTORY = np.dtype([
    ("time", "f8"), ("kinetic_energy", "f8"), ("strain_energy", "f8"), ("external_work", "f8"),
    ("linear_momentum", "f8", 3), ("angular_momentum", "f8", 3),
    ("angular_momentum_printed", "f8", 3), ("momentum_scale", "f8"), ("angular_scale", "f8"),
    ("iterations", "i4"), ("residual", "f8"), ("switches", "i4"), ("halvings", "i4"),
    ("indefinite", "i4")])
"""One row a step; ``angular_momentum_printed`` is Eq. (50) as printed (one sum over nodes)."""


class Recorder:
    """Writes one run to one file; see the module."""

    def __init__(self, path, shape):
        self.path = path
        self.n_nodes, self.n_elem, self.n_frames = shape
        self._run = uuid.uuid4().hex

    @classmethod
    def create(cls, path, model, description, state, rows, frame, frame_steps, n_steps,
               overwrite):
        """A new file with all its space reserved, and its first row, frame and checkpoint."""
        path = writable_path(path, overwrite)
        recorder = cls(path, (len(model.nodes), len(model.quads), len(frame_steps)))
        with replacing(path) as partial:
            # HDF5 may crash where a write fails, so the space is claimed by the system beforehand
            _claim(partial, recorder._bytes(model, state, n_steps))
            with h5py.File(partial, "w", locking=False) as file:
                recorder._layout(file, model, description, state, frame_steps, n_steps)
                recorder._write(file, 0, state, rows, 0, frame)
            _claim(partial, partial.stat().st_size)
        return recorder

    @classmethod
    def resume(cls, path, description):
        """Continue a file of the same run; returns (recorder, step, state, history so far)."""
        path = Path(path).resolve()
        with _opened(path, "r") as file:
            _check_same_run(path, _description(file, path), description)
            step, state = _read_checkpoint(file, path)
            history = _read_history(file, step)
            shape = (len(file["model/nodes"]), len(file["model/quads"]), len(file["frames/step"]))
        recorder = cls(path, shape)
        with _opened(path, "r+") as file:
            file.attrs.modify("run", recorder._run)
        return recorder, step, state, history

    def write(self, step, state, rows, first_row, frame):
        """Append history ``rows`` from ``first_row``, the frame ``(index, displacement, normals,
        element energies)``, and a checkpoint after ``step`` steps."""
        if not self.path.exists():
            raise ResultFileError(f"{self.path} has vanished, its run cannot go on after step "
                                  f"{step}")
        try:
            with h5py.File(self.path, "r+", locking=False) as file:
                if file.attrs.get("run") != self._run:
                    raise ResultFileError(f"{self.path} has been taken over by another run; this "
                                          f"one stops after step {step}")
                self._write(file, step, state, rows, first_row, frame)
        except OSError as error:
            raise ResultFileError(f"{self.path} cannot be written after step {step}: "
                                  f"{_reason(error)}; the file keeps the state of its last "
                                  "checkpoint") from None

    def _write(self, file, step, state, rows, first_row, frame):
        index, displacement, normals, energy = frame
        history, frames = file["history"], file["frames"]
        for name in HISTORY.names:
            history[name][first_row:first_row + len(rows)] = rows[name]
        nodes = slice(index * self.n_nodes, (index + 1) * self.n_nodes)
        frames["displacement"][nodes] = displacement
        frames["normal"][nodes] = normals
        frames["strain_energy"][index * self.n_elem:(index + 1) * self.n_elem] = energy
        steps = file["VTKHDF/Steps"]
        steps["Values"][index] = rows["time"][-1]
        file.flush()
        _write_checkpoint(file["checkpoint"], index % 2, step, state)
        file.flush()
        steps.attrs.modify("NSteps", np.int64(index + 1))

    def _bytes(self, model, state, n_steps):
        """An upper bound of the file's size."""
        checkpoint = _pack(state).nbytes
        frame = 48 * self.n_nodes + 8 * self.n_elem + 100
        mesh = 2 * (model.nodes.nbytes + model.quads.nbytes) + 9 * self.n_elem
        return (HISTORY.itemsize * (n_steps + 1) + frame * self.n_frames + 2 * checkpoint + mesh
                + METADATA)

    def _layout(self, file, model, description, state, frame_steps, n_steps):
        file.attrs["format"] = FORMAT
        file.attrs["description"] = json.dumps(description)
        file.attrs["run"] = self._run
        file.create_dataset("model/nodes", data=model.nodes)
        file.create_dataset("model/quads", data=model.quads)
        for name in HISTORY.names:
            field = HISTORY[name]
            _reserve(file, f"history/{name}", (n_steps + 1, *field.shape), field.base)
        file.create_dataset("frames/step", data=np.asarray(frame_steps, dtype=np.int64))
        _reserve(file, "frames/displacement", (self.n_frames * self.n_nodes, 3))
        _reserve(file, "frames/normal", (self.n_frames * self.n_nodes, 3))
        _reserve(file, "frames/strain_energy", (self.n_frames * self.n_elem,))
        _reserve(file, "checkpoint/state", (2, len(_pack(state))))
        file.create_dataset("checkpoint/stamp", data=np.array([[-1, 0], [-1, 0]]))
        self._vtk(file, model)

    def _vtk(self, file, model):
        """VTKHDF transient unstructured grid; its point and cell data are links to the frames."""
        n_nodes, n_elem, n_frames = self.n_nodes, self.n_elem, self.n_frames
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = np.array([2, 0], dtype=np.int64)
        root.attrs.create("Type", b"UnstructuredGrid", dtype=h5py.string_dtype("ascii", 16))
        root["NumberOfPoints"] = np.array([n_nodes], dtype=np.int64)
        root["NumberOfCells"] = np.array([n_elem], dtype=np.int64)
        root["NumberOfConnectivityIds"] = np.array([4 * n_elem], dtype=np.int64)
        root["Points"] = file["model/nodes"]
        root["Connectivity"] = model.quads.ravel()
        root["Offsets"] = np.arange(n_elem + 1, dtype=np.int64) * 4
        root["Types"] = np.full(n_elem, 9, dtype=np.uint8)
        root["PointData/displacement"] = file["frames/displacement"]
        root["PointData/normal"] = file["frames/normal"]
        root["CellData/strain_energy"] = file["frames/strain_energy"]
        steps = root.create_group("Steps")
        steps.attrs["NSteps"] = np.int64(0)
        _reserve(steps, "Values", (n_frames,))
        zeros, frames = np.zeros(n_frames, dtype=np.int64), np.arange(n_frames, dtype=np.int64)
        steps["PartOffsets"] = zeros
        steps["NumberOfParts"] = zeros + 1
        steps["PointOffsets"] = zeros
        steps["CellOffsets"] = zeros[:, None]
        steps["ConnectivityIdOffsets"] = zeros[:, None]
        steps["PointDataOffsets/displacement"] = frames * n_nodes
        steps["PointDataOffsets/normal"] = frames * n_nodes
        steps["CellDataOffsets/strain_energy"] = frames * n_elem


def read(path):
    """Contents of a result file up to its newest checkpoint.

    Returns:
        dict: ``description`` (dict), ``step``, ``n_steps``, ``history`` (structured array of
        ``HISTORY``), ``frame_steps`` (n,), ``displacement`` and ``normal`` (n, n_nodes, 3),
        ``strain_energy`` (n, n_elem), ``nodes``, ``quads``.

    Raises:
        ResultFileError: no such file, not a corovec file, or damaged.
    """
    path, _ = _regular_file(path)
    with _opened(path, "r") as file:
        description = _description(file, path)
        step, _ = _read_checkpoint(file, path)
        frames = file["frames"]
        frame_steps = frames["step"][:]
        written = int(np.sum(frame_steps <= step))
        n_nodes, n_elem = len(file["model/nodes"]), len(file["model/quads"])
        return {
            "description": description, "step": step, "n_steps": len(file["history/time"]) - 1,
            "history": _read_history(file, step), "frame_steps": frame_steps[:written],
            "displacement": frames["displacement"][:written * n_nodes].reshape(-1, n_nodes, 3),
            "normal": frames["normal"][:written * n_nodes].reshape(-1, n_nodes, 3),
            "strain_energy": frames["strain_energy"][:written * n_elem].reshape(-1, n_elem),
            "nodes": file["model/nodes"][:], "quads": file["model/quads"][:]}


def writable_path(path, overwrite=False):
    """``path`` with links resolved.

    Raises:
        ResultFileError: it is no path, exists and is not to be overwritten, is not a file, or has
            no folder to be in.
    """
    path, exists = _regular_file(path)
    if exists and not overwrite:
        raise ResultFileError(f"{path} exists: use --overwrite to replace it or --resume to "
                              "continue it")
    if not path.parent.is_dir():
        raise ResultFileError(f"{path} cannot be created: no folder {path.parent}")
    return path


@contextmanager
def replacing(path):
    """A temporary file beside ``path`` that takes its place at the end, unless something fails.

    Raises:
        ResultFileError: it cannot be written.
    """
    partial = None
    try:
        handle, name = tempfile.mkstemp(".part", path.name[:100] + ".", path.parent)
        os.close(handle)
        partial = Path(name)
        yield partial
        partial.chmod(0o666 & ~_umask())
        os.replace(partial, path)
    except OSError as error:
        raise ResultFileError(f"{path} cannot be created: {_reason(error)}") from None
    finally:
        if partial is not None:
            partial.unlink(missing_ok=True)


def _regular_file(given):
    """``given`` as a path with links resolved, and whether it exists."""
    try:
        if not os.fspath(given):
            raise ValueError("empty")
        path = Path(given).resolve()
        try:
            regular = stat.S_ISREG(path.stat().st_mode)
        except (FileNotFoundError, NotADirectoryError):
            return path, False
    except (TypeError, ValueError, OSError, RuntimeError) as error:
        raise ResultFileError(f"{str(given)!r} is not a path of a file: "
                              f"{_reason(error)}") from None
    if not regular:
        raise ResultFileError(f"{path} is not a regular file")
    return path, True


@contextmanager
def _opened(path, mode):
    if not path.exists():
        raise ResultFileError(f"{path} does not exist")
    try:
        with h5py.File(path, mode, locking=False) as file:
            yield file
    except (OSError, KeyError, RuntimeError, TypeError, ValueError, AttributeError) as error:
        raise ResultFileError(f"{path} is damaged or not a result file: {_reason(error)}") from None


def _description(file, path):
    if file.attrs.get("format") != FORMAT:
        raise ResultFileError(f"{path} was not written by this version of corovec (format "
                              f"{file.attrs.get('format')!r}, needed {FORMAT!r})")
    return json.loads(file.attrs["description"])


def _check_same_run(path, there, here):
    """A resumed run must have the settings, solver and model of the file."""
    for key, value in {**here["settings"], "solver": here["solver"]}.items():
        stored = there["solver"] if key == "solver" else there["settings"].get(key)
        if stored != value:
            raise ResultFileError(f"{path} is from other parameters: {key} is {stored} there and "
                                  f"{value} here")
    if there["fingerprint"] != here["fingerprint"]:
        case = there["case"]
        what = f" ({case}, {there['elements']} elements)" if case else ""
        raise ResultFileError(f"{path} is from other parameters: its model is another one{what}")


def _reserve(group, name, shape, dtype="f8"):
    """A contiguous dataset with its place in the file, not yet written."""
    places = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    places.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    places.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    group.create_dataset(name, shape, dtype, dcpl=places)


def _claim(path, size):
    """Make the system set ``size`` bytes of disk aside for ``path``; OSError where it cannot."""
    with open(path, "ab") as file:
        if hasattr(os, "posix_fallocate"):
            os.posix_fallocate(file.fileno(), 0, size)
        else:
            block = bytes(1 << 20)
            while (rest := size - file.tell()) > 0:
                file.write(block[:rest])


def _pack(state):
    """All numbers of a state as one float64 vector."""
    arrays = [np.asarray(getattr(state, name), dtype=float).ravel() for name in State.ARRAYS]
    return np.concatenate([*arrays, [state.external_work]])


def _unpack(packed, n_nodes):
    """The state of :func:`_pack`."""
    n_dof = (len(packed) - 1 - 18 * n_nodes) // 2
    shapes = ((n_nodes, 3), (n_nodes, 3), (n_nodes, 3), (n_nodes, 3, 3), (n_dof,), (n_dof,))
    arrays, at = [], 0
    for shape in shapes:
        size = int(np.prod(shape))
        arrays.append(packed[at:at + size].reshape(shape).copy())
        at += size
    return State(*arrays, external_work=float(packed[at]))


def _checksum(packed, step):
    """CRC-32 of a packed state and of the step number it belongs to."""
    return zlib.crc32(np.ascontiguousarray(packed).tobytes(), zlib.crc32(np.int64(step).tobytes()))


def _write_checkpoint(group, slot, step, state):
    packed = _pack(state)
    group["stamp"][slot] = -1, 0
    group["state"][slot] = packed
    group["stamp"][slot] = step, _checksum(packed, step)


def _read_checkpoint(file, path):
    """(step, state) of the newest slot whose checksum holds."""
    group = file["checkpoint"]
    stamps, n_nodes = group["stamp"][...], len(file["model/nodes"])
    for slot in np.argsort(-stamps[:, 0], kind="stable"):
        step, crc = (int(value) for value in stamps[slot])
        packed = group["state"][slot]
        if step >= 0 and crc == _checksum(packed, step):
            return step, _unpack(packed, n_nodes)
    raise ResultFileError(f"{path} is damaged: neither of its two checkpoints is intact")


def _read_history(file, step):
    """History rows up to ``step``."""
    group = file["history"]
    history = np.zeros(step + 1, dtype=HISTORY)
    for name in HISTORY.names:
        history[name] = group[name][:step + 1]
    return history


def _umask():
    current = os.umask(0)
    os.umask(current)
    return current


def _reason(error):
    """First line of an error, without HDF5's nested explanations."""
    number = getattr(error, "errno", None)
    if number:
        return os.strerror(number)
    return str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
