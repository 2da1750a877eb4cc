"""Follower pressure on elements: forces along their current normals, and their stiffness.

``f_i = p int N_i (x,xi x x,eta) dxi deta`` on the bilinear surface through the nodes.  Its
derivative is not symmetric: the skew part is a boundary term, which vanishes in the assembled
matrix where the loaded surface is closed or its rim is held.

In a step the forces at its middle do the work of p dV but for a term of third order in the
increments, ``p V(dx)/4``, which ``add_volume_remainder`` gives back without a resultant.
"""

import math
from typing import NamedTuple

import numpy as np

from .discrete import add_rest, turn, turn_transposed
from .element import corners
from .jit import internal, kernel
from .storage import add_cell
from .vectors import cross

GAUSS = 1.0 / math.sqrt(3.0)


class Point(NamedTuple):
    """The bilinear surface at a natural point.

    Attributes:
        N: (4,) shape functions.
        d_xi: (4,) their derivatives.
        d_eta: (4,) their derivatives.
        t_1: (3,) tangent x,xi [m].
        t_2: (3,) tangent x,eta [m].
    """

    N: np.ndarray
    d_xi: np.ndarray
    d_eta: np.ndarray
    t_1: np.ndarray
    t_2: np.ndarray


@internal
def _point():
    return Point(np.empty(4), np.empty(4), np.empty(4), np.empty(3), np.empty(3))


@internal
def _evaluate(y, xi, eta, point):
    """``N_i = (1 + xi_i xi)(1 + eta_i eta)/4`` and tangents; y (3, 3) relative to node 1."""
    signs = ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))
    point.t_1[:] = 0.0
    point.t_2[:] = 0.0
    for i in range(4):
        s, t = signs[i]
        point.N[i] = 0.25 * (1.0 + s * xi) * (1.0 + t * eta)
        point.d_xi[i] = 0.25 * s * (1.0 + t * eta)
        point.d_eta[i] = 0.25 * t * (1.0 + s * xi)
        if i > 0:
            for c in range(3):
                point.t_1[c] += point.d_xi[i] * y[i - 1, c]
                point.t_2[c] += point.d_eta[i] * y[i - 1, c]


@internal
def pressure_forces(y, pressure, f):
    """``f_i = p int N_i (x,xi x x,eta) dxi deta`` (4, 3)."""
    point = _point()
    f[:] = 0.0
    for xi in (-GAUSS, GAUSS):
        for eta in (-GAUSS, GAUSS):
            _evaluate(y, xi, eta, point)
            for c in range(3):
                d, e = (c + 1) % 3, (c + 2) % 3
                normal = point.t_1[d] * point.t_2[e] - point.t_1[e] * point.t_2[d]
                for i in range(4):
                    f[i, c] += pressure * point.N[i] * normal


@internal
def pressure_stiffness(y, pressure, k):
    """``k_ij = -df_i/dx_j = -p int N_i [a_j]x``, a_j = N_j,eta t_1 - N_j,xi t_2; k (4, 3, 4, 3)."""
    point = _point()
    k[:] = 0.0
    for xi in (-GAUSS, GAUSS):
        for eta in (-GAUSS, GAUSS):
            _evaluate(y, xi, eta, point)
            for i in range(4):
                for j in range(4):
                    for c in range(3):
                        d, e = (c + 1) % 3, (c + 2) % 3
                        a_c = pressure * point.N[i] * (point.d_eta[j] * point.t_1[c]
                                                       - point.d_xi[j] * point.t_2[c])
                        k[i, d, j, e] += a_c
                        k[i, e, j, d] -= a_c


@internal
def relative_positions(quad, nodes, motion, delta, weight, y):
    """Nodes 2..4 relative to node 1 of an element, ``weight`` of the increment on."""
    corners(quad, motion, y)
    first = nodes.start[quad[0]]
    for k in range(3):
        at = nodes.start[quad[k + 1]]
        for c in range(3):
            y[k, c] += weight * (delta[at + c] - delta[first + c])


@kernel
def add_pressure_forces(nodes, quads, pressures, motion, delta, weight, forces):
    """Add the forces of pressures (n,) [Pa] on quads (n, 4) to ``forces`` (n_dof,)."""
    y, f = np.empty((3, 3)), np.empty((4, 3))
    for k in range(quads.shape[0]):
        relative_positions(quads[k], nodes, motion, delta, weight, y)
        pressure_forces(y, pressures[k], f)
        for i in range(4):
            for c in range(3):
                forces[nodes.start[quads[k, i]] + c] += f[i, c]


@kernel
def add_pressure_stiffness(dofs, storage, quads, pressures, motion, delta, step, values, skew):
    """Add their stiffness to the symmetric part of a matrix, and to the skew part if it has one
    (``skew`` is not empty)."""
    y, k_p = np.empty((3, 3)), np.empty((4, 3, 4, 3))
    for k in range(quads.shape[0]):
        relative_positions(quads[k], dofs.nodes, motion, delta, 1.0 - step.alpha_f, y)
        pressure_stiffness(y, step.stiffness * pressures[k], k_p)
        add_cell(dofs, storage, quads[k], (3, 3, 3, 3), k, k_p, values, skew)


TRIPLES = ((0, 1, 2), (0, 2, 3), (0, 1, 3), (1, 2, 3))
"""Corners of the tetrahedra of a bilinear surface with a point, ``V = sum [a, b, c] / 12``."""


@kernel
def add_volume_remainder(nodes, quads, pressures, origin, motion, delta, forces):
    """Add ``p [da, db, dc] / 48`` of all tetrahedra with the node ``origin`` as forces, see
    ``discrete.triple_remainder``: the work of the pressure forces in a step is then p dV exactly,
    of a closed surface, and their resultant and moment stay what they are.

    Args:
        nodes: ``Nodes``.
        quads: (n, 4) nodes; pressures: (n,) [Pa].
        origin: a node.
        motion: ``Motion`` at the start of the step.
        delta: (n_dof,) increment.
        forces: (n_dof,) [N].
    """
    a, da, f, A = np.empty((4, 3)), np.empty((4, 3)), np.empty((4, 3)), np.empty((4, 3))
    v, dv, n, th = np.empty((2, 3)), np.empty((2, 3)), np.empty(3), np.empty(3)
    m, part, on_v = np.empty(3), np.empty(3), np.empty((2, 3))
    at = nodes.start[origin]
    for q in range(quads.shape[0]):
        for i in range(4):
            node = quads[q, i]
            for c in range(3):
                da[i, c] = delta[nodes.start[node] + c] - delta[at + c]
                a[i, c] = ((motion.x[node, c] - motion.x[origin, c])
                           + (motion.x_low[node, c] - motion.x_low[origin, c]) + 0.5 * da[i, c])
                f[i, c] = 0.0
        for k in range(2):
            for c in range(3):
                v[k, c], dv[k, c] = a[2 + k, c] - a[k, c], da[2 + k, c] - da[k, c]
                on_v[k, c] = 0.0
        turn(v, dv, n, th)
        m[:] = 0.0
        for i in range(4):
            cross(th, a[i], A[i])
        for i, j, k in TRIPLES:
            cross(da[j], da[k], part)
            add_rest(pressures[q] / 48.0, part, a[i], f[i], m)
            cross(da[k], A[i], part)
            add_rest(pressures[q] / 48.0, part, a[j], f[j], m)
            cross(A[i], A[j], part)
            add_rest(pressures[q] / 48.0, part, a[k], f[k], m)
        turn_transposed(v, n, m, on_v[0], on_v[1])
        for k in range(2):
            for c in range(3):
                f[k, c] -= on_v[k, c]
                f[2 + k, c] += on_v[k, c]
        for i in range(4):
            for c in range(3):
                forces[nodes.start[quads[q, i]] + c] += f[i, c]
                forces[at + c] -= f[i, c]
