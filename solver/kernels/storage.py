"""Entries of a matrix in the storage of a linear solver.

A matrix is a symmetric part and, where it needs one, a skew part; of either the lower triangle is
stored, at the same places (see ``arguments.Storage``).
"""

import numpy as np

from .jit import internal, kernel


@kernel
def mirror(pointer, columns, first, rows, source):
    """The full matrix of a lower triangle by columns: the ``rows`` of the entries and their
    ``source``, the places of their values in the triangle.

    Args:
        pointer, columns: of the triangle by rows (CSR), ascending, the diagonal last.
        first: (n,) place of the first entry of every column; afterwards that behind the last.
        rows, source: to be filled.
    """
    for row in range(len(first)):
        for k in range(pointer[row], pointer[row + 1]):
            column = columns[k]
            if column < row:  # what stands above the diagonal comes first in its column
                rows[first[row]], source[first[row]] = column, k
                first[row] += 1
        for k in range(pointer[row], pointer[row + 1]):
            column = columns[k]
            rows[first[column]], source[first[column]] = row, k
            first[column] += 1


@internal
def add_cell(dofs, storage, nodes, sizes, cell, k, values, skew):
    """Add the matrix ``k`` between the first ``sizes`` dofs of n nodes, ``k[i, r, j, c]``; ``cell``
    is their row in the offsets.  Held dofs are skipped; an empty ``skew`` takes no part."""
    start = dofs.nodes.start
    for i in range(len(nodes)):
        for j in range(len(nodes)):
            row, column = start[nodes[i]], start[nodes[j]]
            if column > row:
                continue
            for r in range(sizes[i]):
                for c in range(r + 1 if i == j else sizes[j]):
                    if dofs.fixed[row + r] or dofs.fixed[column + c]:
                        continue
                    place = storage.base[row + r] + storage.offset[cell, i, j] + storage.stride * c
                    values[place] += 0.5 * (k[i, r, j, c] + k[j, c, i, r])
                    if skew.size:
                        skew[place] += 0.5 * (k[i, r, j, c] - k[j, c, i, r])


@kernel
def times(pointer, columns, factors, x, y):
    """Product y (n_rows,) of a sparse matrix by rows, entries ``pointer[i] .. pointer[i + 1] - 1``
    of row i, with x."""
    for i in range(y.shape[0]):
        total = 0.0
        for k in range(pointer[i], pointer[i + 1]):
            total += factors[k] * x[columns[k]]
        y[i] = total


@kernel
def add_up(places, factors, sources, values, sums):
    """``sums[places] = sum factors values[sources]``"""
    sums[:] = 0.0
    for k in range(places.shape[0]):
        sums[places[k]] += factors[k] * values[sources[k]]


@kernel
def pull(rows, columns, places, part, moved):
    """``moved`` (n,): ``places`` of unknowns moved by a ``part`` of the mean of what their
    neighbours are away, each weighted by the 16th power of its distance over the largest one, and
    one more of none.

    Returns:
        The largest distance.
    """
    width, weights = 0.0, np.ones(len(places))
    for k in range(len(rows)):
        width = max(width, abs(places[rows[k]] - places[columns[k]]))
    moved[:] = 0.0
    for k in range(len(rows)):
        i, j = rows[k], columns[k]
        away = places[i] - places[j]
        weight = (away / width)**2
        for _ in range(3):
            weight *= weight
        weights[i] += weight
        weights[j] += weight
        moved[i] -= weight * away
        moved[j] += weight * away
    for i in range(len(places)):
        moved[i] = places[i] + part * moved[i] / weights[i]
    return width
