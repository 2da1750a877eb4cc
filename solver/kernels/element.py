"""The four-node co-rotational shell element in director coordinates (paper sections 2 and 3).

The element is a function of ``y_i = x_i - x_1`` (nodes 2, 3, 4) and of the four mid-surface normals
``p_i``; rotational variables enter only through the columns ``A_i = dp_i/dn_i`` that the caller
passes.  Its 17 local variables are Eq. (6) with node 1 left out, whose local translation is zero:

- ``t[k] = (u, v, w)`` of nodes 2, 3, 4 (k = 0, 1, 2), and
- ``b = (w_2, w_3, w_4, dr_x1, dr_y1, ..., dr_x4, dr_y4)``, dr = r - r_0, for bending and shear.

Strain energy: ``W = 1/2 sum_s e_s^2 + 1/2 b^T k_b b`` with the membrane measures
``e_s = l_s . t + 1/2 w^T Q_s w`` (assumed strain, scaled by a Cholesky factor of the elasticity).
Sections that couple stretch and bending add ``c_s . dr`` to the measures.

With phi the rotation of the frame, ``du_L = d(y, p) + S phi``, S_i = [y_i]x, [r_i]x, and
``phi = G1 d(y_3) + G2 d(y_4 - y_2)``: the transformation T of Eq. (45) is rotated blocks plus a
rank-3 correction, and so is the tangent of Eq. (63).  Everything is evaluated in local axes.
"""

import math
from typing import NamedTuple

from .jit import internal, kernel


class Diagonals(NamedTuple):
    """The diagonals of an element in its local axes, numbers or lanes.

    They have the directions (a, b, 0) and (-a, b, 0).

    Attributes:
        a: cosine of half the angle between them.
        b: sine of it.
        L13: length of that from node 1 to node 3 [m].
        L24: length of that from node 2 to node 4 [m].
    """

    a: float
    b: float
    L13: float
    L24: float


@internal
def corners(quad, motion, y):
    """Nodes 2, 3, 4 of a ``quad`` relative to node 1, ``y`` (3, 3), from compensated positions."""
    first = quad[0]
    for k in range(3):
        node = quad[k + 1]
        for c in range(3):
            y[k, c] = ((motion.x[node, c] - motion.x[first, c])
                       + (motion.x_low[node, c] - motion.x_low[first, c]))


@kernel
def frame(y, R):
    """Local frame, Eqs. (3), (4): rows of ``R`` are e_x, e_y, e_z.

    ``y`` (3, 3) holds nodes 2, 3, 4 relative to node 1.  Returns the ``Diagonals``.
    """
    c1x, c1y, c1z = y[1, 0], y[1, 1], y[1, 2]
    c2x, c2y, c2z = y[2, 0] - y[0, 0], y[2, 1] - y[0, 1], y[2, 2] - y[0, 2]
    length1 = math.sqrt(c1x * c1x + c1y * c1y + c1z * c1z)
    length2 = math.sqrt(c2x * c2x + c2y * c2y + c2z * c2z)
    c1x, c1y, c1z = c1x / length1, c1y / length1, c1z / length1
    c2x, c2y, c2z = c2x / length2, c2y / length2, c2z / length2
    exx, exy, exz = c1x - c2x, c1y - c2y, c1z - c2z
    eyx, eyy, eyz = c1x + c2x, c1y + c2y, c1z + c2z
    two_a = math.sqrt(exx * exx + exy * exy + exz * exz)
    two_b = math.sqrt(eyx * eyx + eyy * eyy + eyz * eyz)
    exx, exy, exz = exx / two_a, exy / two_a, exz / two_a
    eyx, eyy, eyz = eyx / two_b, eyy / two_b, eyz / two_b
    R[0, 0], R[0, 1], R[0, 2] = exx, exy, exz
    R[1, 0], R[1, 1], R[1, 2] = eyx, eyy, eyz
    R[2, 0] = exy * eyz - exz * eyy
    R[2, 1] = exz * eyx - exx * eyz
    R[2, 2] = exx * eyy - exy * eyx
    return Diagonals(0.5 * two_a, 0.5 * two_b, length1, length2)


@kernel
def local_variables(R, y, p, y0, r0, t, b):
    """Local variables of Eqs. (8), (10): ``t`` (3, 3) and ``b`` (11), see the module."""
    for k in range(3):
        for c in range(3):
            t[k, c] = R[c, 0] * y[k, 0] + R[c, 1] * y[k, 1] + R[c, 2] * y[k, 2] - y0[k, c]
        b[k] = t[k, 2]
    for i in range(4):
        for c in range(2):
            rotated = R[c, 0] * p[i, 0] + R[c, 1] * p[i, 1] + R[c, 2] * p[i, 2]
            b[3 + 2 * i + c] = rotated - r0[i, c]


@kernel
def membrane_strains(l, Q, t, e):
    """Assumed membrane measures ``e_s = l_s . t + 1/2 w^T Q_s w``."""
    w0, w1, w2 = t[0, 2], t[1, 2], t[2, 2]
    for s in range(l.shape[0]):
        e_s = 0.0
        for k in range(3):
            e_s += l[s, k, 0] * t[k, 0] + l[s, k, 1] * t[k, 1] + l[s, k, 2] * t[k, 2]
        e_s += 0.5 * (w0 * (Q[s, 0, 0] * w0 + Q[s, 0, 1] * w1 + Q[s, 0, 2] * w2)
                      + w1 * (Q[s, 1, 0] * w0 + Q[s, 1, 1] * w1 + Q[s, 1, 2] * w2)
                      + w2 * (Q[s, 2, 0] * w0 + Q[s, 2, 1] * w1 + Q[s, 2, 2] * w2))
        e[s] = e_s


@kernel
def couple_measures(coupling, b, factor, e):
    """``e_s += factor c_s . dr``, of sections that couple stretch and bending."""
    for s in range(coupling.shape[0]):
        e_s = coupling[s, 0] * b[3]
        for k in range(1, 8):
            e_s += coupling[s, k] * b[3 + k]
        e[s] += factor * e_s


@kernel
def couple_forces(coupling, e, g):
    """``g_j += sum_s c_sj e_s``, what the measures do to dr."""
    for s in range(coupling.shape[0]):
        for k in range(8):
            g[k // 2, k % 2] += coupling[s, k] * e[s]


@kernel
def strain_energy(e, k_b, b):
    """Strain energy W of one element (the internal part of Eq. 15)."""
    energy = 0.0
    for s in range(e.shape[0]):
        energy += e[s] * e[s]
    for i in range(11):
        row = 0.0
        for j in range(11):
            row += k_b[i, j] * b[j]
        energy += b[i] * row
    return 0.5 * energy


@kernel
def local_forces(l, Q, k_b, t, b, e, B, f, g):
    """Local internal force, Eqs. (16), (68): ``f`` (3, 3) on nodes 2..4, ``g`` (4, 2) on dr.

    ``t``, ``b``, ``e`` are the values at the generalized midpoint, Eq. (70).  ``B`` (n_s, 9)
    receives ``de_s/dt``; as e_s is quadratic, B at the averaged t is the average of the two B.
    """
    for k in range(3):
        for c in range(3):
            f[k, c] = 0.0
    for s in range(l.shape[0]):
        for k in range(3):
            B[s, 3 * k] = l[s, k, 0]
            B[s, 3 * k + 1] = l[s, k, 1]
            B[s, 3 * k + 2] = (l[s, k, 2] + Q[s, k, 0] * t[0, 2]
                               + Q[s, k, 1] * t[1, 2] + Q[s, k, 2] * t[2, 2])
            f[k, 0] += B[s, 3 * k] * e[s]
            f[k, 1] += B[s, 3 * k + 1] * e[s]
            f[k, 2] += B[s, 3 * k + 2] * e[s]
    for i in range(11):
        row = 0.0
        for j in range(11):
            row += k_b[i, j] * b[j]
        if i < 3:
            f[i, 2] += row
        else:
            g[(i - 3) // 2, (i - 3) % 2] = row


@kernel
def rotated_positions(R, y, p, yl, r):
    """Positions (3, 3) and normals (4, 3) in the axes of ``R``."""
    for c in range(3):
        for k in range(3):
            yl[k, c] = R[c, 0] * y[k, 0] + R[c, 1] * y[k, 1] + R[c, 2] * y[k, 2]
        for i in range(4):
            r[i, c] = R[c, 0] * p[i, 0] + R[c, 1] * p[i, 1] + R[c, 2] * p[i, 2]


@kernel
def frame_rotation(diagonals, dy):
    """Rotation ``phi = G d(v_13, v_24)`` of the frame (local axes) for changes ``dy`` (3, 3)."""
    a, b, L13, L24 = diagonals
    h1, h2 = 0.5 / L13, 0.5 / L24
    d_x, d_y, d_z = dy[2, 0] - dy[0, 0], dy[2, 1] - dy[0, 1], dy[2, 2] - dy[0, 2]
    return ((dy[1, 2] * h1 + d_z * h2) / b, (d_z * h2 - dy[1, 2] * h1) / a,
            (a * dy[1, 1] - b * dy[1, 0]) * h1 - (b * d_x + a * d_y) * h2)


@kernel
def frame_moment(yl, r, f, g):
    """Moment conjugate to the rotation of the frame, ``m = -sum y x f + r x g`` (local axes)."""
    mx, my, mz = 0.0, 0.0, 0.0
    for k in range(3):
        mx -= yl[k, 1] * f[k, 2] - yl[k, 2] * f[k, 1]
        my -= yl[k, 2] * f[k, 0] - yl[k, 0] * f[k, 2]
        mz -= yl[k, 0] * f[k, 1] - yl[k, 1] * f[k, 0]
    for i in range(4):
        mx += r[i, 2] * g[i, 1]
        my -= r[i, 2] * g[i, 0]
        mz -= r[i, 0] * g[i, 1] - r[i, 1] * g[i, 0]
    return mx, my, mz


@kernel
def diagonal_forces(diagonals, m):
    """``G^T m``: the moment ``m`` of the frame as forces on v_13 and v_24 (local axes, 6)."""
    a, b, L13, L24 = diagonals
    h1, h2 = 0.5 / L13, 0.5 / L24
    return (-b * m[2] * h1, a * m[2] * h1, (m[0] / b - m[1] / a) * h1,
            -b * m[2] * h2, -a * m[2] * h2, (m[0] / b + m[1] / a) * h2)


@kernel
def global_forces(R, diagonals, yl, r, f, g, f_x, f_p):
    """``T^T f_int`` (Eq. 45b) in director coordinates: ``f_x`` (4, 3), ``f_p`` (4, 3).

    Node 1 receives minus the sum of the others, so every element is in equilibrium of forces
    to the last bit.
    """
    m = frame_moment(yl, r, f, g)
    g1x, g1y, g1z, g2x, g2y, g2z = diagonal_forces(diagonals, m)
    for c in range(3):
        f_2 = R[0, c] * (f[0, 0] - g2x) + R[1, c] * (f[0, 1] - g2y) + R[2, c] * (f[0, 2] - g2z)
        f_3 = R[0, c] * (f[1, 0] + g1x) + R[1, c] * (f[1, 1] + g1y) + R[2, c] * (f[1, 2] + g1z)
        f_4 = R[0, c] * (f[2, 0] + g2x) + R[1, c] * (f[2, 1] + g2y) + R[2, c] * (f[2, 2] + g2z)
        f_x[0, c] = -(f_2 + f_3 + f_4)
        f_x[1, c] = f_2
        f_x[2, c] = f_3
        f_x[3, c] = f_4
        for i in range(4):
            f_p[i, c] = R[0, c] * g[i, 0] + R[1, c] * g[i, 1]
