"""Carrying a factorized matrix along with the nodes of a moving shell.

Seen from axes that turn with its surroundings, a node's stiffness hardly changes while the shell
tumbles.  A matrix K_0 factorized some steps ago therefore serves: ``K^-1 = T K_0^-1 T^T`` with a
block diagonal T.  Displacements of a node turn by the rotation Q of an element beside it since
then, and rates of its rotational variables by ``J = P Q A_0``, where A_0 maps old rates to those
of the normal (or to the spin of a junction) and P maps turned ones to the present variables.

The matrix of the exact scheme has its forces in the axes of the middle of a step and its
corrections in those of the end, ``K^-1 = T_1 K_0^-1 T_m^T``: that turns symmetric factors into the
unsymmetric matrix, but for inertia.
"""

import numpy as np

from . import element
from .jit import inlined, internal, kernel
from .junctions import frame_of, spins
from .vectors import copy_frame


@internal
def _bases(i, nodes, chart, p, A1, e, rates, variables):
    """Maps from rates of the variables of node i to those of the normal or to the spin (columns of
    ``rates``), and back (rows of ``variables``)."""
    d = nodes.first[i]
    if nodes.n_rot[i] == 2:
        for k in range(2):
            for c in range(3):
                variables[k, c] = chart[i, k, c]
                rates[c, k] = A1[d, c, k]
    else:
        frame_of(nodes.body, d, p, e)
        spins(e, chart[i], variables, rates)


@internal
def _unit(a):
    """Fill ``a`` with 1."""
    for r in range(3):
        for c in range(3):
            a[r, c] = 1.0 if r == c else 0.0


@kernel
def keep(nodes, quads, motion, start, turning):
    """Element axes and rates A_0 of a factorization, into ``turning``."""
    y, variables = np.empty((3, 3)), np.empty((3, 3))
    for i in range(turning.corner.shape[0]):
        element.corners(quads[turning.corner[i]], motion, y)
        element.frame(y, turning.frames[i])
        _bases(i, nodes, motion.chart, start.p, start.A1, y, turning.rates[i], variables)


@kernel
def carry(nodes, quads, motion, start, turning):
    """Blocks Q and J of T since ``keep``; 1 at nodes that are held."""
    y, frame, variables = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    unused = np.empty((3, 3))
    for i in range(turning.corner.shape[0]):
        if turning.held[i]:
            _unit(turning.Q[i])
            _unit(turning.J[i])
            continue
        element.corners(quads[turning.corner[i]], motion, y)
        element.frame(y, frame)
        _bases(i, nodes, motion.chart, start.p, start.A1, y, unused, variables)
        _turn(frame, turning.frames[i], turning.rates[i], variables, nodes.n_rot[i], turning.Q[i],
              turning.J[i])
    for i in range(turning.corner.shape[0]):
        if turning.twin[i] != i:
            copy_frame(turning.Q[turning.twin[i]], turning.Q[i])


@internal
def _step_axes(quad, motion, dx, part, y, frame):
    """Axes (rows) of an element where a part of a step's displacements dx is done."""
    element.corners(quad, motion, y)
    for k in range(3):
        for c in range(3):
            y[k, c] += part * (dx[quad[k + 1], c] - dx[quad[0], c])
    element.frame(y, frame)


@internal
def _spin_bases(i, nodes, chart, work, rates, of_forces, of_corrections):
    """As ``_bases`` in a step of the exact scheme: ``rates`` from variables at its middle, and
    back, of residuals ``r_k = (b_k x p_m) . f`` (of a junction ``b_k . m``) and of corrections at
    its end."""
    d = nodes.first[i]
    size = (work.p_mid[d, 0]**2 + work.p_mid[d, 1]**2 + work.p_mid[d, 2]**2)
    for k in range(nodes.n_rot[i]):
        for c in range(3):
            t, end = chart[i, k, c], work.frames[i, k, c]
            mean = 0.5 * (t + end)
            if nodes.n_rot[i] == 2:
                rates[c, k] = work.A1[d, c, k]
                of_forces[k, c], of_corrections[k, c] = mean / size, end
            else:
                rates[c, k] = of_forces[k, c] = t
                of_corrections[k, c] = mean


@kernel
def keep_step(nodes, quads, motion, work, turning):
    """``keep`` at the middle of the step that ``work``, a ``SpinWork``, is of."""
    y, unused = np.empty((3, 3)), np.empty((3, 3))
    for i in range(turning.corner.shape[0]):
        _step_axes(quads[turning.corner[i]], motion, work.dx, 0.5, y, turning.frames[i])
        _spin_bases(i, nodes, motion.chart, work, turning.rates[i], y, unused)


@kernel
def carry_step(nodes, quads, motion, work, turning):
    """Blocks of T_m and T_1 since ``keep_step``; 1 at nodes that are held."""
    y, frame, unused = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    of_forces, of_corrections = np.empty((3, 3)), np.empty((3, 3))
    corner, held, twin, frames, rates, Q, J, Q_forces, J_forces = turning
    for i in range(corner.shape[0]):
        if held[i]:
            _unit(Q[i])
            _unit(J[i])
            _unit(Q_forces[i])
            _unit(J_forces[i])
            continue
        n_rot = nodes.n_rot[i]
        _spin_bases(i, nodes, motion.chart, work, unused, of_forces, of_corrections)
        _step_axes(quads[corner[i]], motion, work.dx, 0.5, y, frame)
        _turn(frame, frames[i], rates[i], of_forces, n_rot, Q_forces[i], J_forces[i])
        _step_axes(quads[corner[i]], motion, work.dx, 1.0, y, frame)
        _turn(frame, frames[i], rates[i], of_corrections, n_rot, Q[i], J[i])
    for i in range(corner.shape[0]):
        if twin[i] != i:
            copy_frame(Q[twin[i]], Q[i])
            copy_frame(Q_forces[twin[i]], Q_forces[i])


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
    start, n_rot, Q, J = nodes.start, nodes.n_rot, turning.Q_forces, turning.J_forces
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
