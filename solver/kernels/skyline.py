"""Skyline LDL^T: symmetric matrix in one-dimensional row storage, no pivoting.

Row i holds the columns from its first non-zero one, m_i, to the diagonal; ``diagonal[i]`` is the
position of a_ii, so a_ij stands at ``diagonal[i] - i + j`` and ``m_i = i + 1 - (row length)``.
The paper's "one-dimensional storage + LDL^T decomposition" (Tables 2, 4, 6, 8).
"""

import numpy as np
from numba import njit

PANEL = 8
"""Columns that are eliminated together: as many products are summed before an entry is stored."""


@njit(cache=True)
def workspace(diagonal):
    """What a factorization needs besides the storage, made once for a profile.

    Returns:
        first: (n,) first column of every row.
        reach: (n,) one more than the last row that reaches this column or one before.
        G, L: (PANEL, rows that a panel touches at most) work arrays.
    """
    n = diagonal.shape[0]
    first, reach = np.empty(n, np.int64), np.zeros(n, np.int64)
    for i in range(n):
        first[i] = i - (diagonal[i] - diagonal[i - 1] - 1) if i > 0 else 0
        reach[first[i]] = i + 1
    for j in range(1, n):
        reach[j] = max(reach[j], reach[j - 1])
    width = 0
    for k in range(0, n, PANEL):
        width = max(width, reach[min(k + PANEL, n) - 1] - k)
    return first, reach, np.zeros((PANEL, width)), np.zeros((PANEL, width))


@njit(cache=True)
def factor(a, diagonal, first, reach, G, L):
    """Overwrite ``a`` with L (below the diagonal) and D (on it).

    Panel by panel of columns: ``g_ik = a_ik - sum_q g_iq L_kq``, ``d_k = g_kk``,
    ``L_ik = g_ik / d_k``, then ``a_ij -= sum_k g_ik L_jk`` for the rows that reach the panel.  The
    panel is kept transposed, so that every innermost loop runs along contiguous memory.

    Args:
        a: storage; diagonal: (n,); first, reach, G, L: of :func:`workspace`.

    Returns:
        (number of negative pivots, -1), or (0, i) when pivot i is zero or not finite.
    """
    n = diagonal.shape[0]
    negative = 0
    for k0 in range(0, n, PANEL):
        k1 = min(k0 + PANEL, n)
        stop = reach[k1 - 1]
        m = stop - k0
        for k in range(k1 - k0):
            for i in range(m):
                G[k, i] = 0.0
        for i in range(k0, stop):
            base = diagonal[i] - i
            for k in range(max(first[i], k0), min(i + 1, k1)):
                G[k - k0, i - k0] = a[base + k]
        for k in range(k1 - k0):
            for q in range(k):
                multiplier = L[q, k]
                for i in range(k, m):
                    G[k, i] -= multiplier * G[q, i]
            pivot = G[k, k]
            if pivot < 0.0:
                negative += 1
            elif not pivot > 0.0 or pivot == np.inf:
                return 0, k0 + k
            for i in range(k, m):
                L[k, i] = G[k, i] / pivot
        for i in range(k0, stop):
            base = diagonal[i] - i
            for k in range(max(first[i], k0), min(i, k1)):
                a[base + k] = L[k - k0, i - k0]
        for k in range(k1 - k0):
            a[diagonal[k0 + k]] = G[k, k]
        for i in range(k1, stop):
            if first[i] < k1:
                start = diagonal[i] - i + k1
                _subtract(a[start:start + i - k1 + 1], G, L, i - k0)
    return negative, -1


@njit(cache=True)
def _subtract(row, G, L, i):
    """``row_j -= sum_k G_ki L_kj`` for the columns j behind a full panel."""
    g0, g1, g2, g3 = G[0, i], G[1, i], G[2, i], G[3, i]
    g4, g5, g6, g7 = G[4, i], G[5, i], G[6, i], G[7, i]
    l0, l1, l2, l3 = L[0, PANEL:], L[1, PANEL:], L[2, PANEL:], L[3, PANEL:]
    l4, l5, l6, l7 = L[4, PANEL:], L[5, PANEL:], L[6, PANEL:], L[7, PANEL:]
    for j in range(row.shape[0]):
        row[j] -= (((g0 * l0[j] + g1 * l1[j]) + (g2 * l2[j] + g3 * l3[j]))
                   + ((g4 * l4[j] + g5 * l5[j]) + (g6 * l6[j] + g7 * l7[j])))


@njit(cache=True)
def solve(a, diagonal, x):
    """Overwrite ``x`` with the solution of L D L^T x = b; ``a`` from :func:`factor`."""
    n = diagonal.shape[0]
    previous_end = -1
    for i in range(n):
        base = diagonal[i] - i
        total = 0.0
        for k in range(previous_end + 1 - base, i):
            total += a[base + k] * x[k]
        x[i] -= total
        previous_end = diagonal[i]
    for i in range(n):
        x[i] /= a[diagonal[i]]
    for i in range(n - 1, 0, -1):
        base = diagonal[i] - i
        value = x[i]
        for k in range(diagonal[i - 1] + 1 - base, i):
            x[k] -= a[base + k] * value
