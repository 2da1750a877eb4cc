"""Carrying a factorized matrix along with the nodes of a moving shell.

Seen from axes that turn with its surroundings, a node's stiffness hardly changes while the shell
tumbles.  A matrix K_0 factorized some steps ago therefore serves: ``K^-1 = T K_0^-1 T^T`` with a
block diagonal T.  Displacements of a node turn by the rotation Q of an element beside it since
then, and rates of its rotational variables by ``J = P Q A_0``, where A_0 maps old rates to those
of the normal (or to the spin of a junction) and P maps turned ones to the present variables.
"""

import numpy as np

from . import element
from .jit import inlined, internal, kernel
from .junctions import frame_of, spins


@internal
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
    d = nodes.first[i]
    if nodes.n_rot[i] == 2:
        for k in range(2):
            for c in range(3):
                variables[k, c] = chart[i, k, c]
                rates[c, k] = A1[d, c, k]
    else:
        frame_of(nodes.body, d, p, y)
        spins(y, chart[i], variables, rates)


@kernel
def keep(nodes, quads, motion, start, turning):
    """Element axes and rates A_0 of a factorization, into ``turning``."""
    x, x_low, chart, p, A1 = motion.x, motion.x_low, motion.chart, start.p, start.A1
    corner, _, frames, rates, _, _ = turning
    y, variables = np.empty((3, 3)), np.empty((3, 3))
    for i in range(corner.shape[0]):
        _bases(i, nodes, quads, corner, x, x_low, chart, p, A1, y, frames[i], rates[i], variables)


@kernel
def carry(nodes, quads, motion, start, turning):
    """Blocks Q and J of T since ``keep``; 1 at nodes that are held."""
    x, x_low, chart, p, A1 = motion.x, motion.x_low, motion.chart, start.p, start.A1
    corner, held, frames, rates, Q, J = turning
    y, frame, variables = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    n_rot, unused = nodes.n_rot, np.empty((3, 3))
    for i in range(corner.shape[0]):
        if held[i]:
            for r in range(3):
                for c in range(3):
                    Q[i, r, c] = J[i, r, c] = 1.0 if r == c else 0.0
            continue
        _bases(i, nodes, quads, corner, x, x_low, chart, p, A1, y, frame, unused, variables)
        _turn(frame, frames[i], rates[i], variables, n_rot[i], Q[i], J[i])


@inlined
def _turn(frame, frame_0, A_0, P, n_rot, Q, J):
    """``Q = R^T R_0``, ``J = P Q A_0``"""
    for r in range(3):
        for c in range(3):
            Q[r, c] = (frame[0, r] * frame_0[0, c] + frame[1, r] * frame_0[1, c]
                       + frame[2, r] * frame_0[2, c])
    for k in range(n_rot):
        a, b, c = A_0[0, k], A_0[1, k], A_0[2, k]
        x = Q[0, 0] * a + Q[0, 1] * b + Q[0, 2] * c
        y = Q[1, 0] * a + Q[1, 1] * b + Q[1, 2] * c
        z = Q[2, 0] * a + Q[2, 1] * b + Q[2, 2] * c
        for r in range(n_rot):
            J[r, k] = P[r, 0] * x + P[r, 1] * y + P[r, 2] * z


@kernel
def turn_back(nodes, turning, forces, turned):
    """``turned = T^T forces``: a residual in the axes of the factorization."""
    start, n_rot, Q, J = nodes.start, nodes.n_rot, turning.Q, turning.J
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


@kernel
def turn_on(nodes, turning, correction):
    """``correction <- T correction``: a solution in the present axes."""
    start, n_rot, Q, J = nodes.start, nodes.n_rot, turning.Q, turning.J
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


@kernel
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
