"""Forces that turn with nodes, and their stiffness.

``f = sum f_k t_k`` with constant components along ``t_1 = p_1/|p_1|``, ``t_3 ~ p_1 x p_2``,
``t_2 = t_3 x t_1`` of the directors of a junction; at a smooth node along t_1 alone.  A small turn
w changes it by ``df = w x f``.
"""

import math

import numpy as np

from .jit import internal, kernel
from .junctions import spin_of
from .storage import add_cell
from .vectors import cross, dot


@internal
def _place(p, d, components, junction, t, force):
    """Rows t_1, t_2, t_3 at a node whose first director is ``p[d]``, and the force."""
    size = math.sqrt(dot(p[d], p[d]))
    for c in range(3):
        t[0, c] = p[d, c] / size
        force[c] = components[0] * t[0, c]
    if junction:
        cross(t[0], p[d + 1], t[2])
        side = math.sqrt(dot(t[2], t[2]))
        for c in range(3):
            t[2, c] /= side
        cross(t[2], t[0], t[1])
        for c in range(3):
            force[c] += components[1] * t[1, c] + components[2] * t[2, c]
    return size


@kernel
def add_follower_forces(nodes, cells, components, p, forces):
    """Add forces with ``components`` (n, 3) [N] at nodes ``cells`` (n, 1) to ``forces`` (n_dof,);
    p (n_directors, 3) are normals at the generalized midpoint."""
    t, force = np.empty((3, 3)), np.empty(3)
    for k in range(cells.shape[0]):
        i = cells[k, 0]
        _place(p, nodes.first[i], components[k], nodes.n_rot[i] == 3, t, force)
        for c in range(3):
            forces[nodes.start[i] + c] += force[c]


@kernel
def add_follower_stiffness(dofs, storage, cells, components, step, p, A1, values, skew):
    """Add ``-df/du`` to the symmetric part of a matrix, and to the skew part if it has one; A1
    (n_directors, 3, 3) are the derivatives of p."""
    nodes = dofs.nodes
    t, force, k_f = np.empty((3, 3)), np.empty(3), np.empty((1, 6, 1, 6))
    a_dot, b, b_dot = np.empty(3), np.empty(3), np.empty(3)
    w, df = np.empty(3), np.empty(3)
    for k in range(cells.shape[0]):
        i = cells[k, 0]
        d, n_rot = nodes.first[i], nodes.n_rot[i]
        size = _place(p, d, components[k], n_rot == 3, t, force)
        k_f[:] = 0.0
        for r in range(n_rot):
            for c in range(3):
                a_dot[c] = A1[d, c, r] / size
            if n_rot == 3:
                other = math.sqrt(dot(p[d + 1], p[d + 1]))
                for c in range(3):
                    b[c], b_dot[c] = p[d + 1, c] / other, A1[d + 1, c, r] / other
                spin_of(t[0], b, a_dot, b_dot, w)
            else:
                cross(t[0], a_dot, w)
            cross(w, force, df)
            for c in range(3):
                k_f[0, c, 0, 3 + r] = -step.stiffness * df[c]
        add_cell(dofs, storage, cells[k], 3 + nodes.n_rot[cells[k]], k, k_f, values, skew)
