"""Whether something fits into memory, asked before it is made, and how much was taken."""

import os
import sys

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


def peak_memory():
    """Most memory that this process has had at a time since it began [MB], None if unknown."""
    try:
        with open("/proc/self/status") as status:
            return next(int(line.split()[1]) for line in status if "VmHWM" in line) * 1024 / 1e6
    except (OSError, StopIteration):
        pass
    try:
        import resource
    except ImportError:
        return None
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak * (1 if sys.platform == "darwin" else 1024) / 1e6


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
