"""Skyline LDL^T: symmetric matrix in one-dimensional row storage, no pivoting.

Row i holds the columns from its first non-zero one, m_i, to the diagonal; ``diagonal[i]`` is the
position of a_ii, so a_ij stands at ``diagonal[i] - i + j`` and ``m_i = i + 1 - (row length)``.
The paper's "one-dimensional storage + LDL^T decomposition" (Tables 2, 4, 6, 8).
"""

from numba import njit


@njit(cache=True)
def factor(a, diagonal):
    """Overwrite ``a`` with L (below the diagonal) and D (on it).

    Row by row, ``g_ij = a_ij - sum_k g_ik L_jk``, ``L_ij = g_ij / d_j``,
    ``d_i = a_ii - sum_j L_ij g_ij``.  Four rows j are worked off together: four independent sums
    keep the processor busy without any reordering of a single one.

    Returns:
        (number of negative pivots, -1), or (0, i) when pivot i is zero or not finite.
    """
    negative = 0
    previous_end = -1
    for i in range(diagonal.shape[0]):
        base_i = diagonal[i] - i
        first = previous_end + 1 - base_i
        previous_end = diagonal[i]
        j = first
        while j + 4 <= i:
            b0, b1 = diagonal[j] - j, diagonal[j + 1] - j - 1
            b2, b3 = diagonal[j + 2] - j - 2, diagonal[j + 3] - j - 3
            m0 = max(first, (diagonal[j - 1] + 1 - b0) if j > 0 else 0)
            m1 = max(first, diagonal[j] + 1 - b1)
            m2 = max(first, diagonal[j + 1] + 1 - b2)
            m3 = max(first, diagonal[j + 2] + 1 - b3)
            common = min(max(max(m0, m1), max(m2, m3)), j)
            s0, s1, s2, s3 = 0.0, 0.0, 0.0, 0.0
            for k in range(m0, common):
                s0 += a[base_i + k] * a[b0 + k]
            for k in range(m1, common):
                s1 += a[base_i + k] * a[b1 + k]
            for k in range(m2, common):
                s2 += a[base_i + k] * a[b2 + k]
            for k in range(m3, common):
                s3 += a[base_i + k] * a[b3 + k]
            for k in range(common, j):
                g = a[base_i + k]
                s0 += g * a[b0 + k]
                s1 += g * a[b1 + k]
                s2 += g * a[b2 + k]
                s3 += g * a[b3 + k]
            g0 = a[base_i + j] - s0
            g1 = a[base_i + j + 1] - s1
            if m1 <= j:
                g1 -= g0 * a[b1 + j]
            g2 = a[base_i + j + 2] - s2
            if m2 <= j:
                g2 -= g0 * a[b2 + j]
            if m2 <= j + 1:
                g2 -= g1 * a[b2 + j + 1]
            g3 = a[base_i + j + 3] - s3
            if m3 <= j:
                g3 -= g0 * a[b3 + j]
            if m3 <= j + 1:
                g3 -= g1 * a[b3 + j + 1]
            if m3 <= j + 2:
                g3 -= g2 * a[b3 + j + 2]
            a[base_i + j], a[base_i + j + 1] = g0, g1
            a[base_i + j + 2], a[base_i + j + 3] = g2, g3
            j += 4
        while j < i:
            base_j = diagonal[j] - j
            total = 0.0
            for k in range(max(first, (diagonal[j - 1] + 1 - base_j) if j > 0 else 0), j):
                total += a[base_i + k] * a[base_j + k]
            a[base_i + j] -= total
            j += 1
        pivot = a[base_i + i]
        for j in range(first, i):
            g = a[base_i + j]
            quotient = g / a[diagonal[j]]
            a[base_i + j] = quotient
            pivot -= quotient * g
        a[base_i + i] = pivot
        if pivot < 0.0:
            negative += 1
        elif not pivot > 0.0 or pivot == float("inf"):
            return 0, i
    return negative, -1


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
