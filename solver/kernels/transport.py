"""Carrying a factorized matrix along with the nodes of a moving shell.

Seen from axes that turn with its surroundings, a node's stiffness hardly changes while the shell
tumbles.  A matrix K_0 factorized some steps ago therefore serves: ``K^-1 = T K_0^-1 T^T`` with a
block diagonal T.  Displacements of a node turn by the rotation Q of an element beside it since
then, and rates of its rotational variables by ``J = P Q A_0``, where A_0 maps old rates to those
of the normal (or to the spin of a junction) and P maps turned ones to the present variables.
"""

import numpy as np
from numba import njit

from . import charts as rotation
from . import element


@njit(cache=True)
def _bases(i, nodes, quads, corner, x, x_low, chart, p, A1, y, frame, rates, variables):
    """Axes of an element beside node i (rows), and the maps from rates of its variables to those
    of the normal or to the spin (columns of ``rates``), and back (rows of ``variables``)."""
    quad = quads[corner[i]]
    first = quad[0]
    for k in range(3):
        node = quad[k + 1]
        for c in range(3):
            y[k, c] = (x[node, c] - x[first, c]) + (x_low[node, c] - x_low[first, c])
    element.frame(y, frame)
    d = nodes[2][i]
    if nodes[1][i] == 2:
        for k in range(2):
            for c in range(3):
                variables[k, c] = chart[i, k, c]
                rates[c, k] = A1[d, c, k]
    else:
        rotation.frame_of(nodes[3], d, p, y)
        rotation.spins(y, chart[i], variables, rates)


@njit(cache=True)
def keep(nodes, quads, corner, x, x_low, chart, p, A1, frames, rates):
    """Element axes ``frames`` (n_nodes, 3, 3) and rates A_0 (n_nodes, 3, 3) of a factorization."""
    y, variables = np.empty((3, 3)), np.empty((3, 3))
    for i in range(corner.shape[0]):
        _bases(i, nodes, quads, corner, x, x_low, chart, p, A1, y, frames[i], rates[i], variables)


@njit(cache=True)
def carry(nodes, quads, corner, x, x_low, chart, p, A1, held, frames, rates, Q, J):
    """Blocks ``Q`` and ``J`` (n_nodes, 3, 3) of T since ``keep``; 1 at nodes that are held."""
    n_rot = nodes[1]
    y, frame, variables = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    unused, turned = np.empty((3, 3)), np.empty(3)
    for i in range(corner.shape[0]):
        if held[i]:
            for r in range(3):
                for c in range(3):
                    Q[i, r, c] = J[i, r, c] = 1.0 if r == c else 0.0
            continue
        _bases(i, nodes, quads, corner, x, x_low, chart, p, A1, y, frame, unused, variables)
        for r in range(3):
            for c in range(3):
                Q[i, r, c] = (frame[0, r] * frames[i, 0, c] + frame[1, r] * frames[i, 1, c]
                              + frame[2, r] * frames[i, 2, c])
        for k in range(n_rot[i]):
            for c in range(3):
                turned[c] = (Q[i, c, 0] * rates[i, 0, k] + Q[i, c, 1] * rates[i, 1, k]
                             + Q[i, c, 2] * rates[i, 2, k])
            for r in range(n_rot[i]):
                J[i, r, k] = (variables[r, 0] * turned[0] + variables[r, 1] * turned[1]
                              + variables[r, 2] * turned[2])


@njit(cache=True)
def turn_back(start, n_rot, Q, J, forces, turned):
    """``turned = T^T forces``: a residual in the axes of the factorization."""
    for i in range(start.shape[0]):
        k = start[i]
        for c in range(3):
            turned[k + c] = (Q[i, 0, c] * forces[k] + Q[i, 1, c] * forces[k + 1]
                             + Q[i, 2, c] * forces[k + 2])
        k += 3
        for c in range(n_rot[i]):
            value = 0.0
            for r in range(n_rot[i]):
                value += J[i, r, c] * forces[k + r]
            turned[k + c] = value


@njit(cache=True)
def turn_on(start, n_rot, Q, J, correction):
    """``correction <- T correction``: a solution in the present axes."""
    for i in range(start.shape[0]):
        k = start[i]
        a, b, c = correction[k], correction[k + 1], correction[k + 2]
        for r in range(3):
            correction[k + r] = Q[i, r, 0] * a + Q[i, r, 1] * b + Q[i, r, 2] * c
        k += 3
        a, b = correction[k], correction[k + 1]
        if n_rot[i] == 2:
            for r in range(2):
                correction[k + r] = J[i, r, 0] * a + J[i, r, 1] * b
        else:
            c = correction[k + 2]
            for r in range(3):
                correction[k + r] = J[i, r, 0] * a + J[i, r, 1] * b + J[i, r, 2] * c


@njit(cache=True)
def balance(start, mass, c_delta, residual, correction):
    """Translate ``correction`` as a whole so that its inertia forces equal the residual's sum.

    The stiffness of a free shell bears no translation, so this is exact: the iteration conserves
    linear momentum whatever the matrix, as the exact one does.  ``mass`` (n_nodes,): lumped.
    """
    total = 0.0
    for i in range(start.shape[0]):
        total += mass[i]
    for c in range(3):
        missing = 0.0
        for i in range(start.shape[0]):
            missing += residual[start[i] + c] - c_delta * mass[i] * correction[start[i] + c]
        missing /= c_delta * total
        for i in range(start.shape[0]):
            correction[start[i] + c] += missing
