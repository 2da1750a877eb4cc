"""Entries of a matrix in the storage of a linear solver.

A matrix is a symmetric part and, where it needs one, a skew part; of either the lower triangle is
stored, at the same places (see ``arguments.Storage``).
"""


from .jit import internal


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
