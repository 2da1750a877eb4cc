"""One HDF5 file a run: histories, frames, checkpoints, and a view that ParaView opens.

The number of steps is known when a run starts, so every dataset is created at its full size and
its disk space is claimed at once; afterwards only numbers at fixed places change.  Two checkpoint
slots are written in turn, each valid only together with its checksum, and the file is closed
between writes.  So a run killed at any moment leaves a file that opens, and that resumes from the
newest valid slot.  A run that goes on longer than planned (an arc length) moves into a file of
twice the size, which takes the place of the old one once it is complete.

Dynamics and statics differ in the fields of a history row and of a frame, which the first row and
frame define.  Layout (SI units; row 0 of every history is the start):

- ``/history/NAME`` (n_steps + 1, ...): see ``HISTORY`` of ``simulation`` and of ``statics``;
- ``/frames/step`` (n_frames,), ``/frames/NAME``: (n_frames * n_nodes, 3) of nodal values such as
  ``displacement``, (n_frames * n_elem,) of element values, frame after frame;
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

from ..errors import InputError, ResultFileError
from ..system.system import State

FORMAT = "corovec-run-2"

METADATA = 200_000
"""Bytes that the headers of a file take at most (measured: 36 kB)."""

DESCRIBED = ("case", "settings", "solver", "elements", "nodes", "versions", "machine")
COLUMNS = ("time", "kinetic_energy", "strain_energy", "external_work", "linear_momentum",
           "angular_momentum", "angular_momentum_printed", "iterations")
STATIC_COLUMNS = ("factor", "strain_energy")
FRAMES = ("displacement", "normal", "strain_energy")
"""What a result file must hold to be read."""


class Recorder:
    """Writes one run to one file; see the module.

    A frame is ``(index, time, {"PointData": {name: (n_nodes, 3)}, "CellData": {name: (n_elem,)}})``
    with the time under which ParaView shows it; times must ascend.
    """

    def __init__(self, path, model, description):
        self.path, self.model, self.description = path, model, description
        self._run = uuid.uuid4().hex

    @classmethod
    def create(cls, path, model, description, state, rows, frame, frame_steps, overwrite):
        """A new file with all its space reserved, and its first row, frame and checkpoint; the
        last of ``frame_steps`` is the last step."""
        recorder = cls(writable_path(path, overwrite), model, description)
        try:
            with recorder._new(state, rows.dtype, frame, frame_steps) as file:
                recorder._write(file, 0, state, rows, frame)
        except OSError as error:
            raise ResultFileError(f"{recorder.path} cannot be created: "
                                  f"{_reason(error)}") from None
        return recorder

    @classmethod
    def resume(cls, path, model, description, state):
        """Continue a file of the same run: fills ``state``; returns (recorder, step, history)."""
        recorder = cls(Path(path).resolve(), model, description)
        with _opened(recorder.path, "r") as file:
            _check_same_run(recorder.path, _description(file, recorder.path), description)
            step, packed = _read_checkpoint(file, recorder.path)
            _unpack(packed, state)
            history = _read_history(file, step)
        with _opened(recorder.path, "r+") as file:
            file.attrs.modify("run", recorder._run)
        return recorder, step, history

    def write(self, step, state, rows, frame):
        """Append the history ``rows`` up to ``step``, a frame, and a checkpoint."""
        if not self.path.exists():
            raise ResultFileError(f"{self.path} has vanished, its run cannot go on after step "
                                  f"{step}")
        try:
            with h5py.File(self.path, "r+", locking=False) as file:
                if file.attrs.get("run") != self._run:
                    raise ResultFileError(f"{self.path} has been taken over by another run; this "
                                          f"one stops after step {step}")
                full = step > file["frames/step"][-1]
                if not full:
                    self._write(file, step, state, rows, frame)
            if full:
                with (self._new(state, rows.dtype, frame, np.arange(2 * step)) as longer,
                      h5py.File(self.path, "r", locking=False) as file):
                    _copy(file, longer)
                    self._write(longer, step, state, rows, frame)
        except OSError as error:
            raise ResultFileError(f"{self.path} cannot be written after step {step}: "
                                  f"{_reason(error)}; the file keeps the state of its last "
                                  "checkpoint") from None

    @contextmanager
    def _new(self, state, row, frame, frame_steps):
        """An empty file with all its space reserved, in the place of ``path`` once it is filled."""
        with replacing(self.path) as partial:
            # HDF5 may crash where a write fails, so the space is claimed by the system beforehand
            _claim(partial, self._bytes(state, row, frame, frame_steps))
            with h5py.File(partial, "w", locking=False) as file:
                self._layout(file, state, row, frame, frame_steps)
                yield file
            _claim(partial, partial.stat().st_size)

    @staticmethod
    def _write(file, step, state, rows, frame):
        index, time, data = frame
        history, steps = file["history"], file["VTKHDF/Steps"]
        for name in rows.dtype.names:
            history[name][step + 1 - len(rows):step + 1] = rows[name]
        for _, name, values in _fields(data):
            file["frames"][name][index * len(values):(index + 1) * len(values)] = values
        file.flush()
        # VTK reads all values into room for NSteps: there must never be more of them
        steps.attrs.modify("NSteps", np.int64(index + 1))
        file.flush()
        steps["Values"].resize((index + 1,))
        steps["Values"][index] = time
        file.flush()
        _write_checkpoint(file["checkpoint"], index % 2, step, state)

    def _bytes(self, state, row, frame, frame_steps):
        """An upper bound of the file's size."""
        model, fields = self.model, _fields(frame[2])
        each = sum(values.nbytes + 8 for _, _, values in fields) + 56
        mesh = 2 * (model.nodes.nbytes + model.quads.nbytes) + 9 * len(model.quads)
        return (row.itemsize * (frame_steps[-1] + 1) + each * len(frame_steps)
                + 2 * _pack(state).nbytes + mesh + METADATA)

    def _layout(self, file, state, row, frame, frame_steps):
        file.attrs["format"] = FORMAT
        file.attrs["description"] = json.dumps(self.description)
        file.attrs["run"] = self._run
        file.create_dataset("model/nodes", data=self.model.nodes)
        file.create_dataset("model/quads", data=self.model.quads)
        history = file.create_group("history", track_order=True)
        for name in row.names:
            _reserve(history, name, (frame_steps[-1] + 1, *row[name].shape), row[name].base)
        file.create_dataset("frames/step", data=np.asarray(frame_steps, dtype=np.int64))
        for _, name, values in _fields(frame[2]):
            _reserve(file["frames"], name, (len(frame_steps) * len(values), *values.shape[1:]))
        _reserve(file, "checkpoint/state", (2, len(_pack(state))))
        file.create_dataset("checkpoint/stamp", data=np.array([[-1, 0], [-1, 0]]))
        self._vtk(file, _fields(frame[2]), len(frame_steps))

    def _vtk(self, file, fields, n_frames):
        """VTKHDF transient unstructured grid; its point and cell data are links to the frames."""
        n_nodes, n_elem = len(self.model.nodes), len(self.model.quads)
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = np.array([2, 0], dtype=np.int64)
        root.attrs.create("Type", b"UnstructuredGrid", dtype=h5py.string_dtype("ascii", 16))
        root["NumberOfPoints"] = np.array([n_nodes], dtype=np.int64)
        root["NumberOfCells"] = np.array([n_elem], dtype=np.int64)
        root["NumberOfConnectivityIds"] = np.array([4 * n_elem], dtype=np.int64)
        root["Points"] = file["model/nodes"]
        root["Connectivity"] = self.model.quads.ravel()
        root["Offsets"] = np.arange(n_elem + 1, dtype=np.int64) * 4
        root["Types"] = np.full(n_elem, 9, dtype=np.uint8)
        steps = root.create_group("Steps")
        steps.attrs["NSteps"] = np.int64(0)
        _reserve(steps, "Values", (1,), maxshape=(n_frames,), chunks=(n_frames,))
        zeros, frames = np.zeros(n_frames, dtype=np.int64), np.arange(n_frames, dtype=np.int64)
        steps["PartOffsets"] = zeros
        steps["NumberOfParts"] = zeros + 1
        steps["PointOffsets"] = zeros
        steps["CellOffsets"] = zeros[:, None]
        steps["ConnectivityIdOffsets"] = zeros[:, None]
        for place, name, values in fields:
            root[f"{place}/{name}"] = file[f"frames/{name}"]
            steps[f"{place}Offsets/{name}"] = frames * len(values)


def read(path):
    """Contents of a result file, of dynamics or statics, up to its newest checkpoint.

    Returns:
        dict: ``description`` (dict), ``step``, ``n_steps`` (there is room for), ``history``
        (structured array of step + 1 rows), ``frame_steps`` (n,), ``displacement`` and ``normal``
        (n, n_nodes, 3), ``strain_energy`` (n, n_elem), in statics ``reaction`` (n, n_nodes, 3),
        ``nodes``, ``quads``.

    Raises:
        ResultFileError: no such file, not a corovec file, or damaged.
    """
    path, _ = _regular_file(path)
    with _opened(path, "r") as file:
        description = _description(file, path)
        step, _ = _read_checkpoint(file, path)
        planned = file["frames/step"][:]
        written = int(np.sum(planned <= step))
        frames = {}
        for name, values in file["frames"].items():
            size = len(values) // len(planned)
            frames[name] = values[:written * size].reshape(written, size, *values.shape[1:])
        contents = {
            "description": description, "step": step, "n_steps": int(planned[-1]),
            "history": _read_history(file, step), "frame_steps": frames.pop("step").ravel(),
            **frames, "nodes": file["model/nodes"][:], "quads": file["model/quads"][:]}
        _check_contents(contents)
        return contents


def output_path(output, overwrite, resume):
    """The file that a run may write to, or None; see ``writable_path``."""
    if resume and overwrite:
        raise InputError("resume and overwrite exclude each other")
    return None if output is None else writable_path(output, overwrite or resume)


def writable_path(path, overwrite=False):
    """``path`` with links resolved.

    Raises:
        ResultFileError: it is no path, exists and is not to be overwritten, is not a file, or has
            no folder to be in.
    """
    path, exists = _regular_file(path)
    if exists and not overwrite:
        raise ResultFileError(f"{path} exists: use --overwrite to replace it (or, for a run, "
                              "--resume to continue it)")
    if not path.parent.is_dir():
        raise ResultFileError(f"{path} cannot be created: no folder {path.parent}")
    return path


def writable_folder(path):
    """The folder ``path``, made if needed, with links resolved.

    Raises:
        ResultFileError: it is not a folder, or cannot be made or written to.
    """
    if not str(path):
        raise ResultFileError("the name of the folder is empty")
    path = Path(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            return path.resolve()
    except FileExistsError:
        raise ResultFileError(f"{path} is not a folder") from None
    except OSError as error:
        raise ResultFileError(f"folder {path} cannot be written: {error.strerror}") from None


@contextmanager
def replacing(path):
    """A temporary file beside ``path`` that takes its place at the end, unless something fails."""
    partial = None
    try:
        handle, name = tempfile.mkstemp(".part", path.name[:100] + ".", path.parent)
        os.close(handle)
        partial = Path(name)
        yield partial
        partial.chmod(0o666 & ~_umask())
        os.replace(partial, path)
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
    except PermissionError:
        raise ResultFileError(f"{path} cannot be opened: no permission") from None
    except (OSError, KeyError, RuntimeError, TypeError, ValueError, AttributeError) as error:
        raise ResultFileError(f"{path} is damaged or not a result file: {_reason(error)}") from None


def _description(file, path):
    if file.attrs.get("format") != FORMAT:
        raise ResultFileError(f"{path} was not written by this version of corovec (format "
                              f"{file.attrs.get('format')!r}, needed {FORMAT!r})")
    return json.loads(file.attrs["description"])


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


def _fields(data):
    """(place, name, values) of every field of a frame."""
    return [(place, name, values) for place, fields in data.items()
            for name, values in fields.items()]


def _copy(file, longer):
    """All rows and frames of a full ``file`` into the first places of a ``longer`` one."""
    for group in ("history", "frames"):
        for name, values in file[group].items():
            longer[group][name][:len(values)] = values[...]
    values, times = file["VTKHDF/Steps/Values"][...], longer["VTKHDF/Steps/Values"]
    times.resize(values.shape)
    times[...] = values


def _reserve(group, name, shape, dtype="f8", **layout):
    """A dataset with its place in the file, not yet written; contiguous, if not told otherwise."""
    places = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    places.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    places.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    group.create_dataset(name, shape, dtype, dcpl=places, **layout)


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


def _unpack(packed, state):
    """Fill ``state`` from ``_pack``."""
    at = 0
    for name in State.ARRAYS:
        array = getattr(state, name)
        array[...] = packed[at:at + array.size].reshape(array.shape)
        at += array.size
    state.external_work = float(packed[at])


def _checksum(packed, step):
    """CRC-32 of a packed state and of the step number it belongs to."""
    return zlib.crc32(np.ascontiguousarray(packed).tobytes(), zlib.crc32(np.int64(step).tobytes()))


def _write_checkpoint(group, slot, step, state):
    packed = _pack(state)
    group["stamp"][slot] = -1, 0
    group["state"][slot] = packed
    group["stamp"][slot] = step, _checksum(packed, step)


def _read_checkpoint(file, path):
    """(step, packed state) of the newest slot whose checksum holds."""
    group = file["checkpoint"]
    stamps = group["stamp"][...]
    for slot in np.argsort(-stamps[:, 0], kind="stable"):
        step, crc = (int(value) for value in stamps[slot])
        packed = group["state"][slot]
        if step >= 0 and crc == _checksum(packed, step):
            return step, packed
    raise ResultFileError(f"{path} is damaged: neither of its two checkpoints is intact")


def _read_history(file, step):
    """History rows up to ``step``."""
    group = file["history"]
    history = np.zeros(step + 1, [(name, column.dtype, column.shape[1:])
                                  for name, column in group.items()])
    for name, column in group.items():
        history[name] = column[:step + 1]
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
