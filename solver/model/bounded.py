"""numpy for a library that reads files: no array that a damaged count in a file asks for."""

from contextlib import ExitStack, contextmanager
from unittest.mock import patch

import numpy as np

LEAST = 20_000_000
"""Entries that an array may have whatever the size of the file: numbers of nodes may have gaps."""


class Bounded:
    """numpy, whose functions that make arrays refuse those which a file of ``size`` bytes cannot
    fill."""

    def __init__(self, size):
        self._most, self._size = max(size, LEAST), size

    def __getattr__(self, name):
        return getattr(np, name)

    def empty(self, shape, *arguments, **options):
        """``np.empty``."""
        return np.empty(self._checked(shape), *arguments, **options)

    def full(self, shape, *arguments, **options):
        """``np.full``."""
        return np.full(self._checked(shape), *arguments, **options)

    def ones(self, shape, *arguments, **options):
        """``np.ones``."""
        return np.ones(self._checked(shape), *arguments, **options)

    def zeros(self, shape, *arguments, **options):
        """``np.zeros``."""
        return np.zeros(self._checked(shape), *arguments, **options)

    def arange(self, *limits, **options):
        """``np.arange``."""
        self._checked(max(map(abs, map(int, limits))))
        return np.arange(*limits, **options)

    def fromfile(self, file, dtype=float, count=-1, sep=""):
        """``np.fromfile``; of four sizes, which stand at the head of a section, two are counts."""
        if count > self._size:
            raise ValueError(f"{count} numbers in {self._size} bytes")
        found = np.fromfile(file, dtype, int(count), sep)
        if count == 4 and found.dtype.kind == "u":
            self._checked(max(map(int, found[:2]), default=0))
        return found

    def _checked(self, shape):
        entries = int(np.prod(shape, dtype=object))
        if not 0 <= entries <= self._most:
            raise ValueError(f"an array of {entries} entries in a file of {self._size} bytes")
        return shape


@contextmanager
def bounded(modules, size):
    """While it lasts, numpy of ``modules`` is that of a file of ``size`` bytes."""
    with ExitStack() as stack:
        for module in modules:
            stack.enter_context(patch.object(module, "np", Bounded(size)))
        yield
