"""Skyline LDL^T: symmetric matrix in one-dimensional row storage, no pivoting.

Row i holds the columns from its first non-zero one, m_i, to the diagonal; ``diagonal[i]`` is the
position of a_ii, so a_ij stands at ``diagonal[i] - i + j`` and ``m_i = i + 1 - (row length)``.
The paper's "one-dimensional storage + LDL^T decomposition" (Tables 2, 4, 6, 8).
"""

import numpy as np

from .arguments import DONE, Pivots
from .jit import internal, kernel
from .lanes import WIDTH, load, store, zeros

PANEL = WIDTH
"""Columns that are eliminated together: as many products are summed before an entry is stored."""


@kernel
def workspace(diagonal):
    """What a factorization needs besides the storage, made once for a profile.

    Returns:
        first: (n,) first column of every row.
        reach: (n,) one more than the last row that reaches this column or one before.
        G, L: (PANEL, rows that a panel touches at most, in full lanes) work arrays.
        part: (WIDTH,) work array.
    """
    n = diagonal.shape[0]
    first, reach = np.empty(n, np.int64), np.zeros(n, np.int64)
    for i in range(n):
        first[i] = i - (diagonal[i] - diagonal[i - 1] - 1) if i > 0 else 0
        reach[first[i]] = i + 1
    for j in range(1, n):
        reach[j] = max(reach[j], reach[j - 1])
    blocks = 0
    for k in range(0, n, PANEL):
        blocks = max(blocks, -(-(reach[min(k + PANEL, n) - 1] - k) // WIDTH))
    width = (blocks + 1) * WIDTH
    G, L = zeros((2, PANEL, blocks + 1)).reshape((2, PANEL, width))
    return first, reach, G, L, np.zeros(WIDTH)


@kernel
def factor(a, diagonal, first, reach, G, L, part):
    """Overwrite ``a`` with L (below the diagonal) and D (on it).

    Panel by panel of columns: ``g_ik = a_ik - sum_q g_iq L_kq``, ``d_k = g_kk``,
    ``L_ik = g_ik / d_k``, then ``a_ij -= sum_k g_ik L_jk`` for the rows that reach the panel.  The
    panel is kept transposed, so that lanes are neighbours in memory.

    Args:
        a: storage; diagonal: (n,); first, reach, G, L, part: of ``workspace``.

    Returns:
        ``Pivots``.
    """
    n = diagonal.shape[0]
    negative = 0
    for k0 in range(0, n, PANEL):
        k1 = min(k0 + PANEL, n)
        stop = reach[k1 - 1]
        _take(a, diagonal, first, k0, k1, stop, G)
        below, failed = _eliminate(G, L, k1 - k0, stop - k0)
        if failed != DONE:
            return Pivots(0, k0 + failed)
        negative += below
        _put(a, diagonal, first, k0, k1, stop, L)
        for k in range(k1 - k0):
            a[diagonal[k0 + k]] = G[k, k]
        for i in range(k1, stop):
            if first[i] < k1:
                _subtract(a, diagonal[i] - i + k1, i - k1, G, L, part)
    return Pivots(negative, DONE)


@internal
def _take(a, diagonal, first, k0, k1, stop, G):
    """Columns k0 to k1 of the storage, zeros where it has none, to the rows of G."""
    for i in range(k0, stop):
        base = diagonal[i] - i
        if first[i] <= k0 and i >= k0 + PANEL:
            for k in range(PANEL):
                G[k, i - k0] = a[base + k0 + k]
        else:
            for k in range(PANEL):
                G[k, i - k0] = 0.0
            for k in range(max(first[i], k0), min(i + 1, k1)):
                G[k - k0, i - k0] = a[base + k]


@internal
def _put(a, diagonal, first, k0, k1, stop, L):
    """Rows of L to the columns k0 to k1 of the storage, below the diagonal."""
    for i in range(k0, stop):
        base = diagonal[i] - i
        if first[i] <= k0 and i >= k0 + PANEL:
            for k in range(PANEL):
                a[base + k0 + k] = L[k, i - k0]
        else:
            for k in range(max(first[i], k0), min(i, k1)):
                a[base + k] = L[k - k0, i - k0]


@internal
def _eliminate(G, L, size, rows):
    """G and L of one panel; its ``Pivots``."""
    width = G.shape[1]
    negative = 0
    for k in range(size):
        for q in range(k):
            multiplier = L[q, k]
            for i in range(k, PANEL):
                G[k, i] -= multiplier * G[q, i]
        pivot = G[k, k]
        if pivot == 0.0 or not np.isfinite(pivot):
            return Pivots(0, k)
        if pivot < 0.0:
            negative += 1
        inverse = 1.0 / pivot
        for i in range(k, PANEL):
            L[k, i] = G[k, i] * inverse
    for i in range(PANEL, rows, WIDTH):
        for k in range(size):
            g = load(G, k * width + i)
            for q in range(k):
                g -= L[q, k] * load(G, q * width + i)
            store(G, k * width + i, g)
            store(L, k * width + i, g * (1.0 / G[k, k]))
    return Pivots(negative, DONE)


@internal
def _subtract(a, start, i, G, L, part):
    """``a_ij -= sum_k g_ik L_jk`` of a row, the i-th behind a full panel, that starts at ``start``
    in the storage: full lanes, then the entries up to the diagonal."""
    width = G.shape[1]
    for j in range(0, i - i % WIDTH, WIDTH):
        row = load(a, start + j)
        for k in range(PANEL):
            row -= G[k, PANEL + i] * load(L, k * width + PANEL + j)
        store(a, start + j, row)
    j = i - i % WIDTH
    row = G[0, PANEL + i] * load(L, PANEL + j)
    for k in range(1, PANEL):
        row += G[k, PANEL + i] * load(L, k * width + PANEL + j)
    store(part, 0, row)
    for k in range(i - j + 1):
        a[start + j + k] -= part[k]


@internal
def _sum(part):
    """Sum of the lanes in ``part``, in pairs; WIDTH is a power of two."""
    size = WIDTH
    while size > 1:
        size //= 2
        for k in range(size):
            part[k] = part[2 * k] + part[2 * k + 1]
    return part[0]


@kernel
def solve(a, diagonal, x, part):
    """Overwrite ``x`` with the solution of L D L^T x = b; ``a`` from ``factor``, ``part`` of
    ``workspace``."""
    n = diagonal.shape[0]
    previous_end = -1
    for i in range(n):
        base = diagonal[i] - i
        k = previous_end + 1 - base
        if k + WIDTH <= i:
            products = load(a, base + k) * load(x, k)
            k += WIDTH
            while k + WIDTH <= i:
                products += load(a, base + k) * load(x, k)
                k += WIDTH
            store(part, 0, products)
            x[i] -= _sum(part)
        for j in range(k, i):
            x[i] -= a[base + j] * x[j]
        previous_end = diagonal[i]
    for i in range(n):
        x[i] /= a[diagonal[i]]
    for i in range(n - 1, 0, -1):
        base = diagonal[i] - i
        value = x[i]
        k = diagonal[i - 1] + 1 - base
        while k + WIDTH <= i:
            store(x, k, load(x, k) - value * load(a, base + k))
            k += WIDTH
        for j in range(k, i):
            x[j] -= a[base + j] * value
