"""Constraints between bodies, each a product of two vectors that move with them.

A vector ``u = c + sum (alpha x_i + R_i b)`` is made of places x_i and of vectors ``R_i b`` that
are constant in the frames R_i of nodes; a constraint is ``g = u . w - c = 0``.  As u and w are
linear in places and directors, ``g_1 - g_0 = u_m . dw + w_m . du`` exactly, with means u_m, w_m:
forces ``-G_m^T l`` along this gradient do no work where g stays zero, and because a dot product is
blind to rigid motions they have no resultant and no moment.
"""

import numpy as np

from .jit import kernel
from .spins import basis
from .vectors import cross, dot


@kernel
def carry(terms, x, x_low, dx, frames, u, d):
    """Vectors u (n, 3) at places ``x + x_low + dx`` and with ``frames``, and d (n_terms, 3), the
    ``R_i b`` of their terms.

    Args:
        terms: ``Terms``.
        x, x_low, dx: (n_nodes, 3) [m].
        frames: (n_nodes, 3, 3) rows.
        u, d: to be filled.
    """
    for k in range(u.shape[0]):
        for c in range(3):
            u[k, c] = terms.constant[k, c]
            for t in range(terms.first[k], terms.first[k + 1]):
                i = terms.node[t]
                d[t, c] = (terms.body[t, 0] * frames[i, 0, c] + terms.body[t, 1] * frames[i, 1, c]
                           + terms.body[t, 2] * frames[i, 2, c])
                u[k, c] += d[t, c] + terms.alpha[t] * ((x[i, c] + dx[i, c]) + x_low[i, c])


@kernel
def gradients(terms, pairs, local, n_rot, frames, turns, u, d, G):
    """Rows ``G`` (m, n_local) of all constraints: ``alpha w`` on places and ``b_k . q`` with
    ``q = d x w`` on the turn of a node, of each term of u, and the other way round.

    ``turns`` (n_nodes, 3): Cayley vectors th of a step; then columns are derivatives in those of
    vectors at its end, ``b_k . (q + q x th / 2) / (1 + |th|^2 / 4)``.
    """
    q, b, side = np.empty(3), np.empty(3), np.empty(3)
    G[:] = 0.0
    for row in range(pairs.shape[0]):
        for one in range(2):
            carrier, other = pairs[row, one], u[pairs[row, 1 - one]]
            for t in range(terms.first[carrier], terms.first[carrier + 1]):
                i = terms.node[t]
                at = local[i]
                th, part = turns[i], 1.0 / (1.0 + 0.25 * dot(turns[i], turns[i]))
                cross(d[t], other, q)
                cross(q, th, side)
                for c in range(3):
                    G[row, at + c] += terms.alpha[t] * other[c]
                    q[c] = part * (q[c] + 0.5 * side[c])
                for k in range(n_rot[i]):
                    basis(frames[i], n_rot[i], k, b)
                    G[row, at + 3 + k] += dot(b, q)


@kernel
def turns(nodes, local, n_rot, frames, delta, th):
    """Cayley vectors ``th`` (n_nodes, 3) of some nodes from their components in ``delta``
    (n_local,)."""
    b = np.empty(3)
    for j in range(nodes.shape[0]):
        i = nodes[j]
        th[i, 0] = th[i, 1] = th[i, 2] = 0.0
        for k in range(n_rot[i]):
            basis(frames[i], n_rot[i], k, b)
            for c in range(3):
                th[i, c] += delta[local[i] + 3 + k] * b[c]


@kernel
def spread(nodes, local, n_rot, before, after, rate, a, forces):
    """Forces (n_local,) by which an impulse a at the start of a step, which is one at its end too,
    acts: ``2 a / dt``, of turns ``(a_l + sum_k b_l0 . b_k1 a_k) / dt``; ``rate``: 1/dt."""
    b_0, b_1 = np.empty(3), np.empty(3)
    for j in range(nodes.shape[0]):
        i = nodes[j]
        at = local[i]
        for c in range(3):
            forces[at + c] = 2.0 * rate * a[at + c]
        for l in range(n_rot[i]):
            basis(before[i], n_rot[i], l, b_0)
            total = a[at + 3 + l]
            for k in range(n_rot[i]):
                basis(after[i], n_rot[i], k, b_1)
                total += dot(b_0, b_1) * a[at + 3 + k]
            forces[at + 3 + l] = rate * total
