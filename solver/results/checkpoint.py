"""Checkpoints: two slots that are written in turn, each valid only together with its checksum."""

import zlib

import h5py
import numpy as np

from ..errors import ResultFileError


def make_slots(file, size):
    """Two empty slots in a new file, for vectors of ``size`` numbers."""
    reserve(file, "checkpoint/state", (2, size))
    file.create_dataset("checkpoint/stamp", data=np.array([[-1, 0], [-1, 0]]))


def write_slot(file, slot, step, packed):
    """Put the vector ``packed`` of a step into a slot, which is not valid meanwhile."""
    group = file["checkpoint"]
    group["stamp"][slot] = -1, 0
    group["state"][slot] = packed
    group["stamp"][slot] = step, _checksum(packed, step)


def newest_slot(file, path):
    """(step, packed vector) of the newest slot whose checksum holds.

    Raises:
        ResultFileError: none is intact.
    """
    group = file["checkpoint"]
    stamps = group["stamp"][...]
    for slot in np.argsort(-stamps[:, 0], kind="stable"):
        step, crc = (int(value) for value in stamps[slot])
        packed = group["state"][slot]
        if step >= 0 and crc == _checksum(packed, step):
            return step, packed
    raise ResultFileError(f"{path} is damaged: neither of its two checkpoints is intact")


def reserve(group, name, shape, dtype="f8", **layout):
    """A dataset with its place in the file, not yet written; contiguous, if not told otherwise."""
    places = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    places.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    places.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    group.create_dataset(name, shape, dtype, dcpl=places, **layout)


def _checksum(packed, step):
    """CRC-32 of a vector and of the step number it belongs to."""
    return zlib.crc32(np.ascontiguousarray(packed).tobytes(), zlib.crc32(np.int64(step).tobytes()))
