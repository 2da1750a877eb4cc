"""Checkpoints: two slots that are written in turn, each valid only together with its checksum."""

import numpy as np

from .checksums import crc

EMPTY = -1, 0
"""Step and checksum of a slot that is not valid."""


def write_slot(file, slot, step, packed):
    """Put the vector ``packed`` of a step into a slot, which is not valid meanwhile."""
    group = file["checkpoint"]
    group["stamp"][slot] = EMPTY
    group["state"][slot] = packed
    group["stamp"][slot] = step, crc(np.int64(step), packed)


def slot_of(file, step):
    """The slot that holds a step."""
    return int(np.argmax(file["checkpoint/stamp"][:, 0] == step))


def valid_slots(file):
    """(step, packed vector) of the slots whose checksum holds, the newest first."""
    group = file["checkpoint"]
    stamps = group["stamp"][...]
    for slot in np.argsort(-stamps[:, 0], kind="stable"):
        step, checksum = (int(value) for value in stamps[slot])
        packed = group["state"][slot]
        if step >= 0 and checksum == crc(np.int64(step), packed):
            yield step, packed
