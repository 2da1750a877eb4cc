"""Springs and dampers between two nodes, and springs to the ground; their forces do exactly the
work of their energies.

``N = k (l_m - L)`` with the mean length ``l_m = w l_1 + (1 - w) l_0`` of a step's ends, w the
weight of its end, along ``x_m / l_m``, x_m the difference of the nodes at the generalized midpoint:
for ``w = 1/2`` the work ``N x_m . dx / l_m = N (l_1 - l_0)`` is the change of ``k (l - L)^2 / 2``.
Of a table N is its mean from ``l_0 - L`` to ``l_1 - L``, of a damper what it has at the rate
``(l_1 - l_0) / dt``.  A spring to the ground has ``k u_m``.
"""

import math

import numpy as np

from .jit import internal, kernel
from .storage import add_cell
from .tables import energy_in, pull, taken

K, LENGTH, DAMPING, OF_SPRING, OF_DAMPER = range(5)
"""Columns of the constants of a spring between two nodes: stiffness, length at which it is slack,
damping; numbers of points of the tables of its spring and its damper, which follow."""

TABLES = OF_DAMPER + 1
"""First column of the tables."""


@internal
def _ends(pair, nodes, motion, delta, x_0, x_1):
    """Difference of the nodes of a pair at the start and at the end of a step; its lengths, and the
    change ``(x_0 + x_1) . dx / (l_0 + l_1)`` of them, in which nothing cancels."""
    start, end, twice = 0.0, 0.0, 0.0
    for c in range(3):
        dx = delta[nodes.start[pair[1]] + c] - delta[nodes.start[pair[0]] + c]
        x_0[c] = ((motion.x[pair[1], c] - motion.x[pair[0], c])
                  + (motion.x_low[pair[1], c] - motion.x_low[pair[0], c]))
        x_1[c] = x_0[c] + dx
        start += x_0[c] * x_0[c]
        end += x_1[c] * x_1[c]
        twice += dx * (x_0[c] + x_1[c])
    l_0, l_1 = math.sqrt(start), math.sqrt(end)
    return l_0, l_1, twice / (l_0 + l_1) if l_0 + l_1 > 0.0 else 0.0


@internal
def _tension(own, l_0, l_1, change, weight, rate):
    """Tension N of a spring and its damper from length l_0 to l_1, and its derivative by l_1;
    ``rate``: of a change of 1, none of an equilibrium."""
    tension = own[K] * (weight * l_1 + (1.0 - weight) * l_0 - own[LENGTH])
    tension += own[DAMPING] * rate * change
    slope = weight * own[K] + own[DAMPING] * rate
    start = (l_1 if weight == 1.0 else l_0) - own[LENGTH]
    further, more = pull(own, TABLES, start, l_1 - own[LENGTH], weight, change, rate)
    return tension + further, slope + more


@kernel
def add_axial_forces(nodes, pairs, constants, motion, delta, step, forces):
    """Add the forces of springs between pairs (n, 2) of nodes, with ``constants`` (n, 5 or more),
    to ``forces`` (n_dof,)."""
    x_0, x_1 = np.empty(3), np.empty(3)
    weight = 1.0 - step.alpha_f
    for k in range(pairs.shape[0]):
        l_0, l_1, change = _ends(pairs[k], nodes, motion, delta, x_0, x_1)
        mean = weight * l_1 + (1.0 - weight) * l_0
        if mean == 0.0:
            continue
        tension, _ = _tension(constants[k], l_0, l_1, change, weight, step.per_step)
        for c in range(3):
            f = tension / mean * (weight * x_1[c] + (1.0 - weight) * x_0[c])
            forces[nodes.start[pairs[k, 0]] + c] += f
            forces[nodes.start[pairs[k, 1]] + c] -= f


@kernel
def add_axial_stiffness(dofs, storage, pairs, constants, motion, delta, step, values, skew):
    """Add their stiffness, ``(dN/dl_1 - w N / l_m) m n_1^T + w N / l_m 1``, m = x_m / l_m, n_1 =
    x_1 / l_1, to the symmetric part of a matrix, and to the skew part if it has one."""
    x_0, x_1, k_s = np.empty(3), np.empty(3), np.empty((2, 3, 2, 3))
    weight = 1.0 - step.alpha_f
    if step.stiffness == 0.0:
        return
    for k in range(pairs.shape[0]):
        l_0, l_1, change = _ends(pairs[k], dofs.nodes, motion, delta, x_0, x_1)
        mean = weight * l_1 + (1.0 - weight) * l_0
        if mean == 0.0 or l_1 == 0.0:
            continue
        tension, slope = _tension(constants[k], l_0, l_1, change, weight, step.per_step)
        across = weight * tension / mean
        for a in range(3):
            m_a = (weight * x_1[a] + (1.0 - weight) * x_0[a]) / mean
            for b in range(3):
                entry = (slope - across) * m_a * x_1[b] / l_1 + (across if a == b else 0.0)
                k_s[0, a, 0, b] = k_s[1, a, 1, b] = entry
                k_s[0, a, 1, b] = k_s[1, a, 0, b] = -entry
        add_cell(dofs, storage, pairs[k], (3, 3), k, k_s, values, skew)


@kernel
def tensions(constants, lengths, found):
    """Tensions and their derivatives, into ``found`` (n, 2), of springs of ``lengths`` (n,) in an
    equilibrium."""
    for k in range(constants.shape[0]):
        found[k, 0], found[k, 1] = _tension(constants[k], lengths[k], lengths[k], 0.0, 1.0, 0.0)


@kernel
def stored(constants, lengths, found):
    """Energies (n,) of springs of ``lengths`` (n,), into ``found`` [J]."""
    for k in range(constants.shape[0]):
        own, longer = constants[k], lengths[k] - constants[k, LENGTH]
        found[k] = 0.5 * own[K] * longer**2 + energy_in(own, TABLES, longer)


@kernel
def lost(constants, changes, dt, found):
    """What dampers took in a step of length dt in which their lengths changed by ``changes`` (n,),
    into ``found`` [J]."""
    for k in range(constants.shape[0]):
        found[k] = taken(constants[k], TABLES, constants[k, DAMPING], changes[k], dt)


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
