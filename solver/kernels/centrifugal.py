"""Centrifugal forces in a frame that turns at w about a point c, and their stiffness.

``f_x = M Q (x - c)`` and ``f_n = A1^T (h^2/12) M Q p`` with ``Q = |w|^2 1 - w w^T``, the consistent
mass M of Eq. (40): the derivative of ``T_2 = 1/2 (w x (x - c))^T M (w x (x - c)) + ...``, so the
stiffness ``-df/du`` is symmetric; it softens the shell.
"""

from typing import NamedTuple

import numpy as np

from .assembly import add_curvature
from .jit import internal, kernel
from .nodes import place_directors
from .storage import add_cell


class CentrifugalWork(NamedTuple):
    """Work arrays, at the generalized midpoint.

    Attributes:
        p_mid: (n_directors, 3) normals.
        A1: (n_directors, 3, 3) their derivatives.
        force_p: (n_directors, 3) forces on the normals [N m].
        moments: (n_nodes, 3) zeros.
    """

    p_mid: np.ndarray
    A1: np.ndarray
    force_p: np.ndarray
    moments: np.ndarray


def blank_work(n_nodes, n_directors):
    """``CentrifugalWork`` of zeros."""
    return CentrifugalWork(np.zeros((n_directors, 3)), np.zeros((n_directors, 3, 3)),
                           np.zeros((n_directors, 3)), np.zeros((n_nodes, 3)))


@internal
def _turn(Q, v, of_v):
    """``Q v``"""
    for c in range(3):
        of_v[c] = Q[c, 0] * v[0] + Q[c, 1] * v[1] + Q[c, 2] * v[2]


@internal
def _place(elements, nodes, Q, motion, delta, weight, work):
    """Normals and the forces on them, ``weight`` of the increment on."""
    variables, q = motion.variables.copy(), np.empty(3)
    for i in range(variables.shape[0]):
        for k in range(nodes.n_rot[i]):
            variables[i, k] += weight * delta[nodes.start[i] + 3 + k]
    place_directors(nodes, variables, motion.chart, work.p_mid, work.A1)
    work.force_p[:] = 0.0
    for el in range(elements.nodes.shape[0]):
        for j in range(4):
            _turn(Q, work.p_mid[elements.directors[el, j]], q)
            for i in range(4):
                m = elements.rotary[el, i, j]
                for c in range(3):
                    work.force_p[elements.directors[el, i], c] += m * q[c]


@kernel
def add_centrifugal_forces(elements, dofs, Q, centre, motion, delta, weight, work, forces):
    """Add the forces, see the module, to ``forces`` (n_dof,)."""
    start, n_rot, first, _ = dofs.nodes
    arm, q = np.empty(3), np.empty(3)
    _place(elements, dofs.nodes, Q, motion, delta, weight, work)
    for el in range(elements.nodes.shape[0]):
        for j in range(4):
            node = elements.nodes[el, j]
            for c in range(3):
                arm[c] = (motion.x[node, c] - centre[c] + motion.x_low[node, c]
                          + weight * delta[start[node] + c])
            _turn(Q, arm, q)
            for i in range(4):
                for c in range(3):
                    forces[start[elements.nodes[el, i]] + c] += elements.mass[el, i, j] * q[c]
    for i in range(start.shape[0]):
        for d in range(first[i], first[i + 1]):
            for k in range(n_rot[i]):
                for c in range(3):
                    forces[start[i] + 3 + k] += work.A1[d, c, k] * work.force_p[d, c]


@kernel
def add_centrifugal_stiffness(elements, dofs, storage, Q, centre, motion, delta, step, work,
                              values, skew):
    """Add the stiffness ``-df/du``: ``-M Q``, ``-A1^T (h^2/12) M Q A1`` and
    ``-f_p . d2p/dn2``."""
    n_rot = dofs.nodes.n_rot
    k, column = np.empty((4, 6, 4, 6)), np.empty(3)
    _place(elements, dofs.nodes, Q, motion, delta, 1.0 - step.alpha_f, work)
    for el in range(elements.nodes.shape[0]):
        nodes, directors = elements.nodes[el], elements.directors[el]
        k[:] = 0.0
        for j in range(4):
            for s in range(n_rot[nodes[j]]):
                _turn(Q, work.A1[directors[j], :, s], column)
                for i in range(4):
                    m = step.stiffness * elements.rotary[el, i, j]
                    for r in range(n_rot[nodes[i]]):
                        for c in range(3):
                            k[i, 3 + r, j, 3 + s] -= m * work.A1[directors[i], c, r] * column[c]
            for i in range(4):
                for c in range(3):
                    for d in range(3):
                        k[i, c, j, d] = -step.stiffness * elements.mass[el, i, j] * Q[c, d]
        add_cell(dofs, storage, nodes, 3 + n_rot[nodes], el, k, values, skew)
    add_curvature(dofs, storage, motion.chart, -step.stiffness, work.moments, work, work.force_p,
                  values, 0, len(dofs.nodes.start))
