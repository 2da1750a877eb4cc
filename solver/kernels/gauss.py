"""Gaussian elimination on full storage with partial pivoting: the paper's baseline.

What an unsymmetric co-rotational tangent would need ("full-matrix storage + Gaussian elimination",
Tables 2, 4, 6, 8).  It exploits neither symmetry nor sparsity, on purpose.
"""

import numpy as np

from .arguments import DONE
from .jit import kernel

SQUARE = 32
"""Rows of the squares in which a matrix is mirrored."""


@kernel
def factor(a, rows):
    """Overwrite ``a`` (n, n) with its LU factors; ``rows`` (n,) records the row exchanges.

    Returns the index of the first pivot that is zero or not finite, or ``DONE``.
    """
    n = a.shape[0]
    for k in range(n):
        pivot_row, largest = k, abs(a[k, k])
        for i in range(k + 1, n):
            if abs(a[i, k]) > largest:
                pivot_row, largest = i, abs(a[i, k])
        if not 0.0 < largest < np.inf:
            return k
        rows[k] = pivot_row
        if pivot_row != k:
            for j in range(n):
                a[k, j], a[pivot_row, j] = a[pivot_row, j], a[k, j]
        pivot = a[k, k]
        upper = a[k, k + 1:]
        for i in range(k + 1, n):
            multiplier = a[i, k] / pivot
            a[i, k] = multiplier
            lower = a[i, k + 1:]
            for j in range(len(lower)):
                lower[j] -= multiplier * upper[j]
    return DONE


@kernel
def mirror(a):
    """Copy the lower triangle of ``a`` (n, n) to the upper one, square by square for the cache."""
    n = a.shape[0]
    for i0 in range(0, n, SQUARE):
        i1 = min(i0 + SQUARE, n)
        for j0 in range(0, i1, SQUARE):
            for i in range(i0, i1):
                for j in range(j0, min(j0 + SQUARE, i)):
                    a[j, i] = a[i, j]


@kernel
def solve(a, rows, x):
    """Overwrite ``x`` with the solution; ``a``, ``rows`` from ``factor``."""
    n = a.shape[0]
    for k in range(n):
        x[k], x[rows[k]] = x[rows[k]], x[k]
    for i in range(n):
        total = 0.0
        for k in range(i):
            total += a[i, k] * x[k]
        x[i] -= total
    for i in range(n - 1, -1, -1):
        total = 0.0
        for k in range(i + 1, n):
            total += a[i, k] * x[k]
        x[i] = (x[i] - total) / a[i, i]
