"""Springs between two nodes and to the ground; their forces do exactly the work of their energy.

``N = k (l_m - L)`` with the mean length ``l_m = w l_1 + (1 - w) l_0`` of a step's ends, w the
weight of its end, along ``x_m / l_m``, x_m the difference of the nodes at the generalized midpoint:
for ``w = 1/2`` the work ``N x_m . dx / l_m = N (l_1 - l_0)`` is the change of ``k (l - L)^2 / 2``.
A spring to the ground has ``k u_m``.
"""

import math

import numpy as np

from .jit import internal, kernel
from .storage import add_cell


@internal
def _ends(pair, nodes, motion, delta, x_0, x_1):
    """Difference of the nodes of a pair at the start and at the end of a step; its lengths."""
    start, end = 0.0, 0.0
    for c in range(3):
        x_0[c] = ((motion.x[pair[1], c] - motion.x[pair[0], c])
                  + (motion.x_low[pair[1], c] - motion.x_low[pair[0], c]))
        x_1[c] = x_0[c] + (delta[nodes.start[pair[1]] + c] - delta[nodes.start[pair[0]] + c])
        start += x_0[c] * x_0[c]
        end += x_1[c] * x_1[c]
    return math.sqrt(start), math.sqrt(end)


@kernel
def add_axial_forces(nodes, pairs, stiffness, lengths, motion, delta, weight, forces):
    """Add the forces of springs between pairs (n, 2) of nodes, stiffness k (n,) [N/m], slack at
    ``lengths`` (n,) [m], to ``forces`` (n_dof,)."""
    x_0, x_1 = np.empty(3), np.empty(3)
    for k in range(pairs.shape[0]):
        l_0, l_1 = _ends(pairs[k], nodes, motion, delta, x_0, x_1)
        mean = weight * l_1 + (1.0 - weight) * l_0
        if mean == 0.0:
            continue
        pull = stiffness[k] * (mean - lengths[k]) / mean
        for c in range(3):
            f = pull * (weight * x_1[c] + (1.0 - weight) * x_0[c])
            forces[nodes.start[pairs[k, 0]] + c] += f
            forces[nodes.start[pairs[k, 1]] + c] -= f


@kernel
def add_axial_stiffness(dofs, storage, pairs, stiffness, lengths, motion, delta, step, values,
                        skew):
    """Add their stiffness, ``w ((k - N / l_m) m n_1^T + N / l_m 1)``, m = x_m / l_m, n_1 = x_1 /
    l_1, to the symmetric part of a matrix, and to the skew part if it has one."""
    x_0, x_1, k_s = np.empty(3), np.empty(3), np.empty((2, 3, 2, 3))
    weight = 1.0 - step.alpha_f
    for k in range(pairs.shape[0]):
        l_0, l_1 = _ends(pairs[k], dofs.nodes, motion, delta, x_0, x_1)
        mean = weight * l_1 + (1.0 - weight) * l_0
        if mean == 0.0 or l_1 == 0.0:
            continue
        pull = stiffness[k] * (mean - lengths[k]) / mean
        for a in range(3):
            m_a = (weight * x_1[a] + (1.0 - weight) * x_0[a]) / mean
            for b in range(3):
                entry = step.stiffness * (stiffness[k] - pull) * m_a * x_1[b] / l_1
                entry += step.stiffness * pull if a == b else 0.0
                k_s[0, a, 0, b] = k_s[1, a, 1, b] = entry
                k_s[0, a, 1, b] = k_s[1, a, 0, b] = -entry
        add_cell(dofs, storage, pairs[k], (3, 3), k, k_s, values, skew)


@kernel
def add_ground_forces(nodes, cells, stiffness, X, motion, delta, weight, forces):
    """Add ``-k u_m`` of springs between nodes ``cells`` (n, 1) and their initial places X (n, 3)
    [m], stiffness (n, 3) [N/m]."""
    for k in range(cells.shape[0]):
        i = cells[k, 0]
        for c in range(3):
            at = nodes.start[i] + c
            u = (motion.x[i, c] - X[k, c]) + motion.x_low[i, c] + weight * delta[at]
            forces[at] -= stiffness[k, c] * u


@kernel
def add_ground_stiffness(dofs, storage, cells, stiffness, factor, values, skew):
    """Add ``factor k``."""
    k_s = np.zeros((1, 3, 1, 3))
    for k in range(cells.shape[0]):
        for c in range(3):
            k_s[0, c, 0, c] = factor * stiffness[k, c]
        add_cell(dofs, storage, cells[k], (3,), k, k_s, values, skew)
