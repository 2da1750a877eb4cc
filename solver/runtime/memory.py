"""Whether something fits into memory, asked before it is made."""

import os

from ..errors import InputError

ELEMENT = 8_000
"""Bytes that a model takes an element, without its matrix (measured: 8 to 9 kB)."""


def check_memory(what, size):
    """Refuse ``what`` if its ``size`` in bytes is more than the memory that is free.

    Raises:
        InputError: it is.
    """
    free = available_memory()
    if free is not None and size > free:
        raise InputError(f"{what} would take {size / 1e9:.3g} GB of memory, {free / 1e9:.3g} GB "
                         "are free")


def available_memory():
    """Bytes that programs can have without swapping, or all of the machine; None if unknown."""
    try:
        with open("/proc/meminfo") as info:
            return next(1024 * int(line.split()[1]) for line in info if "MemAvailable" in line)
    except (OSError, StopIteration):
        pass
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return None
