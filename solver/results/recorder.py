"""One HDF5 file a run: histories, frames, checkpoints, and a view that ParaView opens.

The number of steps is known when a run starts, so every dataset is created at its full size and
its disk space is claimed at once; afterwards only numbers at fixed places change.  Two checkpoint
slots are written in turn, each valid only together with its checksum, and the file is closed
between writes.  So a run killed at any moment leaves a file that opens, and that resumes from the
newest valid slot.  A run that goes on longer than planned (an arc length) moves into a file of
twice the size, which takes the place of the old one once it is complete.

Dynamics and statics differ in the fields of a history row and of a frame.  Layout (SI units; row 0
of every history is the start):

- ``/history/NAME`` (n_steps + 1, ...): see ``DYNAMICS`` and ``STATICS`` of ``layout``;
  ``/probes/NAME/WHAT`` (n_steps + 1, ...): of single places, see ``PROBES``;
  ``/energies/KIND/WHAT`` (n_steps + 1, n): of joints, bodies and springs, see ``ITEMS``;
  ``/items/KIND/WHAT`` (n_steps + 1, n, ...): of joints in statics, see ``OF_JOINTS``;
- ``/frames/step`` (n_frames,), ``/frames/NAME``: (n_frames * n_nodes, 3) of nodal values such as
  ``displacement``, (n_frames * n_elem, ...) of element values, frame after frame, all of them in
  ``Sizes.fields``;
  ``/frames/checksum`` (n_frames,): see ``checksums``;
- the attribute ``memory``: most that the process has had at a time when it last wrote [MB];
- ``/checkpoint/state`` (2, n), ``/checkpoint/stamp`` (2, 2): two packed states, each with its step
  and checksum; ``/model``: nodes and quads;
- ``/VTKHDF``: the frames again, as links, with the mesh and its time steps.

HDF5's file format 1.8 is the newest that a killed process cannot leave locked, and the first that
keeps checksums of its own structures.
"""

import json
import math
import time
import uuid
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np

from ..errors import ResultFileError
from ..runtime.memory import peak_memory
from .checkpoint import EMPTY, slot_of, write_slot
from .checksums import of_fixed, of_frame
from .files import claim, draft, reason, writable_path
from .layout import TIMES, Sizes, columns, fixed, growing, is_static, items_of, probe_kinds
from .reading import FORMAT, load, opened
from .vtkhdf import copy_times, make_view, show_frames

WAIT = 0.5
"""Seconds for which frames are kept in memory, to be written together (measured: a file's numbers
take 5 ms to write, however few they are)."""

METADATA = 200_000
"""Bytes that the headers of a file take at most (measured: 36 kB)."""


class Recorder:
    """Writes one run to one file; see the module.

    A frame is ``(index, time, {name: values})``, see ``snapshot``, with the time under which
    ParaView shows it; times must ascend.
    """

    def __init__(self, path, model, description):
        self.path, self.model = path, model
        self._text = np.bytes_(json.dumps(description))
        self._run = np.bytes_(uuid.uuid4().hex)
        self._kept, self._state, self._written = [], None, time.monotonic()
        self._pending, self._latest = [], None
        self._slot = 0

    @classmethod
    def create(cls, path, model, description, state, rows, frame, frame_steps, overwrite):
        """A new file with all its space reserved, and its first row, frame and checkpoint; the
        last of ``frame_steps`` is the last step."""
        recorder = cls(writable_path(path, overwrite), model, description)
        try:
            with recorder._new(len(state.pack()), rows.dtype, frame[2], frame_steps) as file:
                recorder._write(file, 0, state.pack(), [(rows, frame)])
        except OSError as error:
            raise ResultFileError(f"{recorder.path} cannot be created: "
                                  f"{reason(error)}") from None
        return recorder

    @classmethod
    def resume(cls, path, model, description, state, frame_steps=None):
        """Continue a file of the same run: fills ``state``; returns (recorder, step, history).

        ``frame_steps``: those of the run, where they are known.
        """
        recorder = cls(Path(path).resolve(), model, description)
        with opened(recorder.path, "r") as file:
            stored = load(file, recorder.path)
            _check_same_run(recorder.path, stored.description, description)
            if (len(stored.packed) != len(state.pack())
                    or frame_steps is not None and not np.array_equal(stored.plan, frame_steps)):
                raise ValueError("its frames or states are not those of its settings")
            state.unpack(stored.packed)
            recorder._slot = 1 - slot_of(file, stored.step)
        with opened(recorder.path, "r+") as file:
            file.attrs.modify("run", recorder._run)
        return recorder, stored.step, stored.history

    def keep(self, step, state, rows, frame, checkpoint=True):
        """Append the history ``rows`` up to ``step`` and a frame, which wait in memory for the next
        ``checkpoint``; with that within ``WAIT`` of the last time they still wait, for ``flush`` at
        the latest."""
        index, at, fields = frame
        fields = {name: np.array(values) for name, values in fields.items()}
        unused = self._latest[1] if self._pending else None  # no checkpoint: it is not written
        self._pending.append((rows, (index, at, fields)))
        self._latest = step, state.pack(out=unused)
        if checkpoint:
            self._close()
            if time.monotonic() - self._written > WAIT:
                self.flush()

    def _close(self):
        """The latest frame becomes one from which a run can go on."""
        self._kept += self._pending
        self._pending, self._state = [], self._latest

    def flush(self, everything=False):
        """Write what waits in memory up to the last checkpoint, or ``everything``, of a run that
        has failed and will not go on."""
        if everything and self._pending:
            self._close()
        kept, self._kept = self._kept, []
        if kept:
            self._append(*self._state, kept)
        self._written = time.monotonic()

    def _append(self, step, packed, kept):
        (rows, (_, _, fields)) = kept[-1]
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
                    self._write(file, step, packed, kept)
            if full:
                with (self._new(len(packed), rows.dtype, fields, np.arange(2 * step)) as longer,
                      h5py.File(self.path, "r", locking=False) as file):
                    _copy(file, longer, rows.dtype)
                    self._write(longer, step, packed, kept)
        except OSError as error:
            raise ResultFileError(f"{self.path} cannot be written after step {step}: "
                                  f"{reason(error)}; the file keeps the state of its last "
                                  "checkpoint") from None

    @contextmanager
    def _new(self, numbers, row, fields, frame_steps):
        """An empty file with all its space reserved, in the place of ``path`` once it is filled."""
        model = self.model
        sizes = Sizes(is_static(row), len(model.nodes), len(model.quads), len(model.normals),
                      int(frame_steps[-1]), len(frame_steps), numbers,
                      "reaction" in fields, "von_mises" in fields, tuple(probe_kinds(row).items()),
                      items_of(row))
        with draft(self.path) as partial:
            # HDF5 may crash where a write fails, so the space is claimed by the system beforehand
            claim(partial, _bytes(sizes) + len(self._text))
            with h5py.File(partial, "w", locking=False, libver=("v108", "v108")) as file:
                self._layout(file, sizes, frame_steps)
                yield file
            claim(partial, partial.stat().st_size)

    def _write(self, file, step, packed, kept):
        """Rows and frames one after the other, and the checkpoint of the last."""
        rows = np.concatenate([rows for rows, _ in kept])
        last, _, fields = kept[-1][1]
        frames, first = file["frames"], last + 1 - len(kept)
        for name, place in columns(rows.dtype).items():
            file[place][step + 1 - len(rows):step + 1] = rows[name]
        for name, values in fields.items():
            frames[name][first * len(values):(last + 1) * len(values)] = np.concatenate(
                [fields[name] for _, (_, _, fields) in kept])
        frames["checksum"][first:last + 1] = [
            of_frame(index, at, rows, fields.values()) for rows, (index, at, fields) in kept]
        show_frames(file, first, [at for _, (_, at, _) in kept])
        file.attrs.modify("memory", peak_memory() or np.nan)
        write_slot(file, self._slot, step, packed)
        self._slot = 1 - self._slot

    def _layout(self, file, sizes, frame_steps):
        """All datasets, those that do not change with their values."""
        for place, (dtype, shape) in {**fixed(sizes), **growing(sizes)}.items():
            _reserve(file, place, shape, dtype)
        _reserve(file, TIMES, (1,), "f8", maxshape=(sizes.frames,), chunks=(sizes.frames,))
        file["model/nodes"][...], file["model/quads"][...] = self.model.nodes, self.model.quads
        file["frames/step"][...], file["checkpoint/stamp"][...] = frame_steps, EMPTY
        make_view(file, self.model, sizes)
        file.attrs.update(memory=np.nan, format=np.bytes_(FORMAT), description=self._text,
                          run=self._run, checksum=of_fixed(file, self._text, sizes))


def _reserve(file, name, shape, dtype, **layout):
    """A dataset with its place in the file, not yet written; contiguous, if not told otherwise."""
    places = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    places.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    places.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    file.create_dataset(name, shape, dtype, dcpl=places, **layout)


def _bytes(sizes):
    """An upper bound of a file's size."""
    numbers = {**fixed(sizes), **growing(sizes), TIMES: ("f8", (sizes.frames,))}
    return METADATA + sum(np.dtype(dtype).itemsize * math.prod(shape)
                          for dtype, shape in numbers.values())


def _check_same_run(path, there, here):
    """A resumed run must have the settings, solver and model of the file."""
    stored = _flat({**there["settings"], "solver": there["solver"]})
    for key, value in _flat({**here["settings"], "solver": here["solver"]}).items():
        if stored.get(key) != value:
            raise ResultFileError(f"{path} is from other parameters: {key} is {stored.get(key)} "
                                  f"there and {value} here")
    if there.get("start") != here.get("start"):
        raise ResultFileError(f"{path} is from other parameters: it starts from another "
                              "configuration")
    if there.get("probes") != here.get("probes"):
        raise ResultFileError(f"{path} is from other parameters: probes are {there.get('probes')} "
                              f"there and {here.get('probes')} here")
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


def _copy(file, longer, row):
    """All rows, of type ``row``, and frames of a full ``file`` (of statics) into the first places
    of a ``longer``."""
    for place in (*columns(row).values(), *(f"frames/{name}" for name in file["frames"])):
        longer[place][:len(file[place])] = file[place][...]
    copy_times(file, longer)
