"""Moments about the normals of smooth nodes, as couples of forces on the elements around them.

A smooth node has no rotation about its normal.  The part t = (M . p) p of a moment M therefore acts
on the corners of an element beside the node, as forces that turn it like a rigid body about their
mean: ``f_j = w x r_j`` with ``I w = t``, ``I = sum |r|^2 1 - r r^T``.  Their sum is zero and their
moment ``sum r_j x f_j = I w = t``, exactly, whatever the shape of the element; their work is that
of t in its mean rotation.
"""

import math
from typing import NamedTuple

import numpy as np

from .jit import internal, kernel
from .pressure import relative_positions
from .storage import add_cell
from .vectors import adjugate, cross, dot


class Couple(NamedTuple):
    """A couple on the corners of an element.

    Attributes:
        r: (4, 3) corners from their mean [m].
        inverse: (3, 3) of ``sum |r|^2 1 - r r^T`` [1/m^2].
        w: (3,) its product with the moment t [N/m].
        t: (3,) moment along the normal [N m].
        p: (3,) normal of the node, of unit length.
        A1: (3, 2) its derivatives.
    """

    r: np.ndarray
    inverse: np.ndarray
    w: np.ndarray
    t: np.ndarray
    p: np.ndarray
    A1: np.ndarray


@internal
def _couple():
    return Couple(np.empty((4, 3)), np.empty((3, 3)), np.empty(3), np.empty(3), np.empty(3),
                  np.empty((3, 2)))


@internal
def _place(d, quad, moment, nodes, motion, delta, weight, p, A1, y, couple):
    """The couple of a moment about the normal ``p[d]`` on a quad, ``weight`` of the increment on.
    """
    size = math.sqrt(dot(p[d], p[d]))
    for c in range(3):
        couple.p[c] = p[d, c] / size
        couple.A1[c, 0], couple.A1[c, 1] = A1[d, c, 0], A1[d, c, 1]
    relative_positions(quad, nodes, motion, delta, weight, y)
    along_p = dot(moment, couple.p)
    for c in range(3):
        mean = 0.25 * (y[0, c] + y[1, c] + y[2, c])
        couple.r[0, c] = -mean
        for i in range(3):
            couple.r[i + 1, c] = y[i, c] - mean
        couple.t[c] = along_p * couple.p[c]
    _invert(couple.r, y, couple.inverse)
    _apply(couple.inverse, couple.t, couple.w)


@internal
def _invert(r, inertia, inverse):
    """Inverse of ``sum |r|^2 1 - r r^T``."""
    for a in range(3):
        for b in range(3):
            inertia[a, b] = 0.0
            for i in range(4):
                inertia[a, b] -= r[i, a] * r[i, b]
                if a == b:
                    inertia[a, b] += dot(r[i], r[i])
    determinant = adjugate(inertia, inverse)
    for a in range(3):
        for b in range(3):
            inverse[a, b] /= determinant


@internal
def _apply(matrix, vector, result):
    """``result = matrix vector``"""
    for c in range(3):
        result[c] = dot(matrix[c], vector)


@internal
def _stiffness(moment, couple, k, change, w_change, force):
    """``k[i, :, j, c] = -df_i`` for the c-th dof of corner j; the normal is that of corner 0.

    ``df_i = dw x r_i + w x dr_i``, and from ``I w = t``: ``I dw = dt - 2 r_jc w + (r_j . w) e_c +
    w_c r_j`` for the corner's translation c, ``dt = (M . dp) p + (M . p) dp``.
    """
    r, w, p = couple.r, couple.w, couple.p
    k[:] = 0.0
    for j in range(4):
        for c in range(3 if j > 0 else 5):
            for a in range(3):
                if c < 3:
                    change[a] = w[c] * r[j, a] - 2.0 * r[j, c] * w[a]
                    change[a] += dot(r[j], w) if a == c else 0.0
                else:
                    turned = (moment[0] * couple.A1[0, c - 3] + moment[1] * couple.A1[1, c - 3]
                              + moment[2] * couple.A1[2, c - 3])
                    change[a] = turned * p[a] + dot(moment, p) * couple.A1[a, c - 3]
            _apply(couple.inverse, change, w_change)
            for i in range(4):
                cross(w_change, r[i], force)
                for a in range(3):
                    k[i, a, j, c] -= force[a]
                if c < 3:
                    moved = (1.0 if i == j else 0.0) - 0.25
                    d, e = (c + 1) % 3, (c + 2) % 3  # w x e_c
                    k[i, d, j, c] -= moved * w[e]
                    k[i, e, j, c] += moved * w[d]


@kernel
def add_couples(nodes, quads, directors, moments, motion, delta, weight, p, A1, forces):
    """Add the forces of moments (n, 3) [N m] about the normals ``p[directors]`` of the first nodes
    of quads (n, 4) to ``forces`` (n_dof,)."""
    y, force, couple = np.empty((3, 3)), np.empty(3), _couple()
    for k in range(quads.shape[0]):
        _place(directors[k], quads[k], moments[k], nodes, motion, delta, weight, p, A1, y, couple)
        for i in range(4):
            cross(couple.w, couple.r[i], force)
            for c in range(3):
                forces[nodes.start[quads[k, i]] + c] += force[c]


@kernel
def add_couples_stiffness(dofs, storage, quads, directors, moments, motion, delta, step, p, A1,
                          values, skew):
    """Add their stiffness to the symmetric part of a matrix, and to the skew part if it has one."""
    y, couple, k_c = np.empty((3, 3)), _couple(), np.empty((4, 5, 4, 5))
    change, w_change, force, moment = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for k in range(quads.shape[0]):
        for c in range(3):
            moment[c] = step.stiffness * moments[k, c]
        _place(directors[k], quads[k], moment, dofs.nodes, motion, delta, 1.0 - step.alpha_f, p,
               A1, y, couple)
        _stiffness(moment, couple, k_c, change, w_change, force)
        add_cell(dofs, storage, quads[k], (5, 3, 3, 3), k, k_c, values, skew)
