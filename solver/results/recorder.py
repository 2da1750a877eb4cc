"""One HDF5 file a run: histories, frames, checkpoints, and a view that ParaView opens.

The number of steps is known when a run starts, so every dataset is created at its full size and
its disk space is claimed at once; afterwards only numbers at fixed places change.  Two checkpoint
slots are written in turn, each valid only together with its checksum, and the file is closed
between writes.  So a run killed at any moment leaves a file that opens, and that resumes from the
newest valid slot.  A run that goes on longer than planned (an arc length) moves into a file of
twice the size, which takes the place of the old one once it is complete.

Dynamics and statics differ in the fields of a history row and of a frame, which the first row and
frame define.  Layout (SI units; row 0 of every history is the start):

- ``/history/NAME`` (n_steps + 1, ...): see ``HISTORY`` of ``dynamics.result`` and of
  ``statics.result``;
- ``/frames/step`` (n_frames,), ``/frames/NAME``: (n_frames * n_nodes, 3) of nodal values such as
  ``displacement``, (n_frames * n_elem,) of element values, frame after frame;
- ``/checkpoint/state`` (2, n), ``/checkpoint/stamp`` (2, 2): two packed states, each with its step
  and checksum; ``/model``: nodes and quads;
- ``/VTKHDF``: the frames again, as links, with the mesh and its time steps.
"""

import json
import uuid
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np

from ..errors import ResultFileError
from .checkpoint import make_slots, newest_slot, reserve, write_slot
from .files import claim, reason, replacing, writable_path
from .reading import FORMAT, opened, read_description, read_history
from .vtkhdf import copy_times, make_view, show_frame

METADATA = 200_000
"""Bytes that the headers of a file take at most (measured: 36 kB)."""


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
                                  f"{reason(error)}") from None
        return recorder

    @classmethod
    def resume(cls, path, model, description, state):
        """Continue a file of the same run: fills ``state``; returns (recorder, step, history)."""
        recorder = cls(Path(path).resolve(), model, description)
        with opened(recorder.path, "r") as file:
            _check_same_run(recorder.path, read_description(file, recorder.path), description)
            step, packed = newest_slot(file, recorder.path)
            state.unpack(packed)
            history = read_history(file, step)
        with opened(recorder.path, "r+") as file:
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
                                  f"{reason(error)}; the file keeps the state of its last "
                                  "checkpoint") from None

    @contextmanager
    def _new(self, state, row, frame, frame_steps):
        """An empty file with all its space reserved, in the place of ``path`` once it is filled."""
        with replacing(self.path) as partial:
            # HDF5 may crash where a write fails, so the space is claimed by the system beforehand
            claim(partial, self._bytes(state, row, frame, frame_steps))
            with h5py.File(partial, "w", locking=False) as file:
                self._layout(file, state, row, frame, frame_steps)
                yield file
            claim(partial, partial.stat().st_size)

    @staticmethod
    def _write(file, step, state, rows, frame):
        index, time, data = frame
        history = file["history"]
        for name in rows.dtype.names:
            history[name][step + 1 - len(rows):step + 1] = rows[name]
        for _, name, values in _fields(data):
            file["frames"][name][index * len(values):(index + 1) * len(values)] = values
        show_frame(file, index, time)
        write_slot(file, index % 2, step, state.pack())

    def _bytes(self, state, row, frame, frame_steps):
        """An upper bound of the file's size."""
        model, fields = self.model, _fields(frame[2])
        each = sum(values.nbytes + 8 for _, _, values in fields) + 56
        mesh = 2 * (model.nodes.nbytes + model.quads.nbytes) + 9 * len(model.quads)
        return (row.itemsize * (frame_steps[-1] + 1) + each * len(frame_steps)
                + 2 * state.pack().nbytes + mesh + METADATA)

    def _layout(self, file, state, row, frame, frame_steps):
        file.attrs["format"] = FORMAT
        file.attrs["description"] = json.dumps(self.description)
        file.attrs["run"] = self._run
        file.create_dataset("model/nodes", data=self.model.nodes)
        file.create_dataset("model/quads", data=self.model.quads)
        history = file.create_group("history", track_order=True)
        for name in row.names:
            reserve(history, name, (frame_steps[-1] + 1, *row[name].shape), row[name].base)
        file.create_dataset("frames/step", data=np.asarray(frame_steps, dtype=np.int64))
        for _, name, values in _fields(frame[2]):
            reserve(file["frames"], name, (len(frame_steps) * len(values), *values.shape[1:]))
        make_slots(file, len(state.pack()))
        make_view(file, self.model, _fields(frame[2]), len(frame_steps))


def _check_same_run(path, there, here):
    """A resumed run must have the settings, solver and model of the file."""
    stored = _flat({**there["settings"], "solver": there["solver"]})
    for key, value in _flat({**here["settings"], "solver": here["solver"]}).items():
        if stored.get(key) != value:
            raise ResultFileError(f"{path} is from other parameters: {key} is {stored.get(key)} "
                                  f"there and {value} here")
    if there["fingerprint"] != here["fingerprint"]:
        case = there["case"]
        what = f" ({case}, {there['elements']} elements)" if case else ""
        raise ResultFileError(f"{path} is from other parameters: its model is another one{what}")


def _flat(settings):
    """Nested settings as one dictionary, with names such as ``scheme.rho_inf``."""
    flat = {}
    for name, value in settings.items():
        if isinstance(value, dict):
            flat |= {f"{name}.{inner}": v for inner, v in _flat(value).items()}
        else:
            flat[name] = value
    return flat


def _fields(data):
    """(place, name, values) of every field of a frame."""
    return [(place, name, values) for place, fields in data.items()
            for name, values in fields.items()]


def _copy(file, longer):
    """All rows and frames of a full ``file`` into the first places of a ``longer`` one."""
    for group in ("history", "frames"):
        for name, values in file[group].items():
            longer[group][name][:len(values)] = values[...]
    copy_times(file, longer)
