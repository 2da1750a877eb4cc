"""Checksums of what a result file holds: one of all that is written once, one with every frame.

CRC-32 finds every change of up to four bytes in a row for certain, and others but for one in 4e9.
HDF5's own Fletcher-32 is for chunks alone, which a kill may tear, and takes 0x0000 for 0xffff.
"""

import zlib

import numpy as np

from .layout import fixed


def crc(*parts):
    """CRC-32 of bytes and arrays, one after the other."""
    value = 0
    for part in parts:
        value = zlib.crc32(part if isinstance(part, bytes) else np.ascontiguousarray(part), value)
    return value


def of_fixed(file, text, sizes):
    """Of the description and the datasets that do not change."""
    return crc(text, *(file[place][...] for place in fixed(sizes)))


def of_frame(index, time, rows, fields):
    """Of a frame: its number and time, the history ``rows`` since the frame before, its fields."""
    return crc(np.int64(index), np.float64(time), rows, *fields)


def intact(frames, plan, history, fields):
    """How many frames, from the first on, are as they were written.

    Args:
        frames: (time, checksum) of each.
        plan: their steps.
        history: rows up to the last of them.
        fields: arrays or datasets of (values, rows a frame).

    Raises:
        ValueError: a frame is not finite.
    """
    start = 0
    for k, ((time, checksum), step) in enumerate(zip(frames, plan)):
        parts = [values[k * size:(k + 1) * size] for values, size in fields]
        if checksum != of_frame(k, time, history[start:step + 1], parts):
            return k
        if not all(np.isfinite(part).all() for part in parts):
            raise ValueError(f"frame {k} is not finite")
        start = step + 1
    return len(frames)
