"""The four-node co-rotational shell element in director coordinates (paper sections 2 and 3).

The element is a function of ``y_i = x_i - x_1`` (nodes 2, 3, 4) and of the four mid-surface normals
``p_i``; rotational variables enter only through the columns ``A_i = dp_i/dn_i`` that the caller
passes.  Its 17 local variables are Eq. (6) with node 1 left out, whose local translation is zero:

- ``t[k] = (u, v, w)`` of nodes 2, 3, 4 (k = 0, 1, 2), and
- ``b = (w_2, w_3, w_4, dr_x1, dr_y1, ..., dr_x4, dr_y4)``, dr = r - r_0, for bending and shear.

Strain energy: ``W = 1/2 sum_s e_s^2 + 1/2 b^T k_b b`` with the membrane measures
``e_s = l_s . t + 1/2 w^T Q_s w`` (assumed strain, scaled by a Cholesky factor of the elasticity).

With phi the rotation of the frame, ``du_L = d(y, p) + S phi``, S_i = [y_i]x, [r_i]x, and
``phi = G1 d(y_3) + G2 d(y_4 - y_2)``: the transformation T of Eq. (45) is rotated blocks plus a
rank-3 correction, and so is the tangent of Eq. (63).  Everything is evaluated in local axes.
"""

import math

import numpy as np
from numba import njit

from .lanes import new

GAUSS = 1.0 / math.sqrt(3.0)


@njit(cache=True)
def frame(y, R):
    """Local frame, Eqs. (3), (4): rows of ``R`` are e_x, e_y, e_z.

    ``y`` (3, 3) holds nodes 2, 3, 4 relative to node 1.  Returns ``(a, b, L13, L24)``: in local
    axes the diagonals have the directions (a, b, 0) and (-a, b, 0) and these lengths.
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
    return 0.5 * two_a, 0.5 * two_b, length1, length2


@njit(cache=True)
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


@njit(cache=True)
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


@njit(cache=True)
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


@njit(cache=True)
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


@njit(cache=True)
def rotated_positions(R, y, p, yl, r):
    """Positions (3, 3) and normals (4, 3) in the axes of ``R``."""
    for c in range(3):
        for k in range(3):
            yl[k, c] = R[c, 0] * y[k, 0] + R[c, 1] * y[k, 1] + R[c, 2] * y[k, 2]
        for i in range(4):
            r[i, c] = R[c, 0] * p[i, 0] + R[c, 1] * p[i, 1] + R[c, 2] * p[i, 2]


@njit(cache=True)
def frame_rotation(a, b, L1, L2, dy):
    """Rotation ``phi = G d(v_13, v_24)`` of the frame (local axes) for changes ``dy`` (3, 3)."""
    h1, h2 = 0.5 / L1, 0.5 / L2
    d_x, d_y, d_z = dy[2, 0] - dy[0, 0], dy[2, 1] - dy[0, 1], dy[2, 2] - dy[0, 2]
    return ((dy[1, 2] * h1 + d_z * h2) / b, (d_z * h2 - dy[1, 2] * h1) / a,
            (a * dy[1, 1] - b * dy[1, 0]) * h1 - (b * d_x + a * d_y) * h2)


@njit(cache=True)
def _frame_moment(yl, r, f, g):
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


@njit(cache=True)
def _diagonal_forces(a, b, L1, L2, m):
    """``G^T m``: the moment ``m`` of the frame as forces on v_13 and v_24 (local axes, 6)."""
    h1, h2 = 0.5 / L1, 0.5 / L2
    return (-b * m[2] * h1, a * m[2] * h1, (m[0] / b - m[1] / a) * h1,
            -b * m[2] * h2, -a * m[2] * h2, (m[0] / b + m[1] / a) * h2)


@njit(cache=True)
def global_forces(R, a, b, L1, L2, yl, r, f, g, f_x, f_p):
    """``T^T f_int`` (Eq. 45b) in director coordinates: ``f_x`` (4, 3), ``f_p`` (4, 3).

    Node 1 receives minus the sum of the others, so every element is in equilibrium of forces
    to the last bit.
    """
    m = _frame_moment(yl, r, f, g)
    g1x, g1y, g1z, g2x, g2y, g2z = _diagonal_forces(a, b, L1, L2, m)
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


@njit(cache=True)
def _frame_stiffness(a, b, L1, L2, yl, r, f, g, E, C):
    """Second-order part of the frame on ``(v_13, v_24)``: ``C = G^T (Y + S^T k S) G + H``.

    ``Y phi = sum (phi x y) x f + (phi x r) x g``; ``H`` is the derivative of ``G^T m`` with m held
    fixed in the frame.  ``E`` (3, 3) holds S^T k S on entry and is overwritten.  ``C`` (6, 6) is
    symmetric although neither part is.
    """
    trace = 0.0
    for k in range(3):
        trace += yl[k, 0] * f[k, 0] + yl[k, 1] * f[k, 1] + yl[k, 2] * f[k, 2]
        for c in range(3):
            for d in range(3):
                E[c, d] += yl[k, c] * f[k, d]
    for i in range(4):
        trace += r[i, 0] * g[i, 0] + r[i, 1] * g[i, 1]
        for c in range(3):
            for d in range(2):
                E[c, d] += r[i, c] * g[i, d]
    for c in range(3):
        E[c, c] -= trace
    m = _frame_moment(yl, r, f, g)
    g1x, g1y, g1z, g2x, g2y, g2z = _diagonal_forces(a, b, L1, L2, m)
    h1, h2 = 0.5 / L1, 0.5 / L2
    twist1 = -(m[0] * a / (b * b) + m[1] * b / (a * a)) * h1
    twist2 = -(m[0] * a / (b * b) - m[1] * b / (a * a)) * h2
    for col in range(6):
        px, py, pz, stretch1, stretch2, beta = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        if col == 0:
            pz, stretch1, beta = -b * h1, a / L1, -b * h1
        elif col == 1:
            pz, stretch1, beta = a * h1, b / L1, a * h1
        elif col == 2:
            px, py = h1 / b, -h1 / a
        elif col == 3:
            pz, stretch2, beta = -b * h2, -a / L2, b * h2
        elif col == 4:
            pz, stretch2, beta = -a * h2, b / L2, a * h2
        else:
            px, py = h2 / b, h2 / a
        qx = E[0, 0] * px + E[0, 1] * py + E[0, 2] * pz
        qy = E[1, 0] * px + E[1, 1] * py + E[1, 2] * pz
        qz = E[2, 0] * px + E[2, 1] * py + E[2, 2] * pz
        d1x, d1y, d1z, d2x, d2y, d2z = _diagonal_forces(a, b, L1, L2, (qx, qy, qz))
        mz_beta = m[2] * beta
        C[0, col] = d1x + py * g1z - pz * g1y - g1x * stretch1 - a * mz_beta * h1
        C[1, col] = d1y + pz * g1x - px * g1z - g1y * stretch1 - b * mz_beta * h1
        C[2, col] = d1z + px * g1y - py * g1x - g1z * stretch1 + twist1 * beta
        C[3, col] = d2x + py * g2z - pz * g2y - g2x * stretch2 - a * mz_beta * h2
        C[4, col] = d2y + pz * g2x - px * g2z - g2y * stretch2 + b * mz_beta * h2
        C[5, col] = d2z + px * g2y - py * g2x - g2z * stretch2 + twist2 * beta


@njit(cache=True)
def tangent(R, a, b, L1, L2, yl, r, f, g, B, e, Q, k_b, A, n_rot, work, ke):
    """Element tangent ``T^T k_T T + dT/du : f_int``, Eq. (63), but for second derivatives of p.

    The columns ``A[i, :, :n_rot[i]]`` are the directions dp_i/dn_i.  ``ke`` (24, 24) receives the
    lower triangle, for vertex i in rows 6 i + (0, 1, 2) for x_i and 6 i + 3 + c for column c of
    A_i; unused rows are left alone.  ``work`` are arrays of the shapes ``WORK``.
    """
    k_m, P_x, P_p, P_b, E, C, V1, V2, D, block = work
    h1, h2 = 0.5 / L1, 0.5 / L2

    # local membrane stiffness: B^T D B + sum_s N_s Q_s, then bending and shear on w
    for i in range(9):
        for j in range(i + 1):
            k_ij = 0.0
            for s in range(B.shape[0]):
                k_ij += B[s, i] * B[s, j]
            k_m[i, j] = k_m[j, i] = k_ij
    for k in range(3):
        for j in range(3):
            w_w = k_b[k, j]
            for s in range(B.shape[0]):
                w_w += e[s] * Q[s, k, j]
            k_m[3 * k + 2, 3 * j + 2] += w_w

    # P = k S - F: bending part first (its w-w block is already in k_m)
    for i in range(11):
        P_b[i, 0] = P_b[i, 1] = P_b[i, 2] = 0.0
        for j in range(4):
            k_x, k_y = k_b[i, 3 + 2 * j], k_b[i, 4 + 2 * j]
            P_b[i, 0] += k_y * r[j, 2]
            P_b[i, 1] -= k_x * r[j, 2]
            P_b[i, 2] += k_x * r[j, 1] - k_y * r[j, 0]
        if i >= 3:
            for k in range(3):
                P_b[i, 0] -= k_b[i, k] * yl[k, 1]
                P_b[i, 1] += k_b[i, k] * yl[k, 0]
    for i in range(9):
        P_x[i, 0] = P_x[i, 1] = P_x[i, 2] = 0.0
        for k in range(3):
            k_u, k_v, k_w = k_m[i, 3 * k], k_m[i, 3 * k + 1], k_m[i, 3 * k + 2]
            P_x[i, 0] += k_v * yl[k, 2] - k_w * yl[k, 1]
            P_x[i, 1] += k_w * yl[k, 0] - k_u * yl[k, 2]
            P_x[i, 2] += k_u * yl[k, 1] - k_v * yl[k, 0]
    for k in range(3):
        for c in range(3):
            P_x[3 * k + 2, c] += P_b[k, c]

    # E = S^T k S
    for c in range(3):
        E[0, c] = E[1, c] = E[2, c] = 0.0
        for k in range(3):
            E[0, c] += yl[k, 2] * P_x[3 * k + 1, c] - yl[k, 1] * P_x[3 * k + 2, c]
            E[1, c] += yl[k, 0] * P_x[3 * k + 2, c] - yl[k, 2] * P_x[3 * k, c]
            E[2, c] += yl[k, 1] * P_x[3 * k, c] - yl[k, 0] * P_x[3 * k + 1, c]
        for j in range(4):
            E[0, c] += r[j, 2] * P_b[4 + 2 * j, c]
            E[1, c] -= r[j, 2] * P_b[3 + 2 * j, c]
            E[2, c] += r[j, 1] * P_b[3 + 2 * j, c] - r[j, 0] * P_b[4 + 2 * j, c]
    for k in range(3):
        P_x[3 * k, 1] += f[k, 2]
        P_x[3 * k, 2] -= f[k, 1]
        P_x[3 * k + 1, 0] -= f[k, 2]
        P_x[3 * k + 1, 2] += f[k, 0]
        P_x[3 * k + 2, 0] += f[k, 1]
        P_x[3 * k + 2, 1] -= f[k, 0]
    for j in range(4):
        for c in range(3):
            P_p[j, 0, c] = P_b[3 + 2 * j, c]
            P_p[j, 1, c] = P_b[4 + 2 * j, c]
        P_p[j, 0, 2] -= g[j, 1]
        P_p[j, 1, 2] += g[j, 0]
        P_p[j, 2, 0] = g[j, 1]
        P_p[j, 2, 1] = -g[j, 0]
        P_p[j, 2, 2] = 0.0
    _frame_stiffness(a, b, L1, L2, yl, r, f, g, E, C)

    # translations: k + P G + (P G)^T + C, rotated; node 1 from translation invariance
    for i in range(9):
        p_x, p_y, p_z = P_x[i, 0], P_x[i, 1], P_x[i, 2]
        V1[i, 0], V1[i, 1], V1[i, 2] = -b * p_z * h1, a * p_z * h1, (p_x / b - p_y / a) * h1
        V2[i, 0], V2[i, 1], V2[i, 2] = -b * p_z * h2, -a * p_z * h2, (p_x / b + p_y / a) * h2
    for i in range(9):
        for c in range(3):
            k_m[i, c] -= V2[i, c]
            k_m[i, 3 + c] += V1[i, c]
            k_m[i, 6 + c] += V2[i, c]
    for i in range(9):
        for c in range(3):
            k_m[c, i] -= V2[i, c]
            k_m[3 + c, i] += V1[i, c]
            k_m[6 + c, i] += V2[i, c]
    for c in range(3):
        for d in range(3):
            k_m[c, d] += C[3 + c, 3 + d]
            k_m[c, 3 + d] -= C[3 + c, d]
            k_m[3 + c, d] -= C[c, 3 + d]
            k_m[c, 6 + d] -= C[3 + c, 3 + d]
            k_m[6 + c, d] -= C[3 + c, 3 + d]
            k_m[3 + c, 3 + d] += C[c, d]
            k_m[3 + c, 6 + d] += C[c, 3 + d]
            k_m[6 + c, 3 + d] += C[3 + c, d]
            k_m[6 + c, 6 + d] += C[3 + c, 3 + d]
    for c in range(3):
        for d in range(3):
            ke[c, d] = 0.0
            for k in range(3):
                ke[6 * k + 6 + c, d] = 0.0
    for k in range(3):
        for j in range(k + 1):
            for c in range(3):
                for d in range(3):
                    block[c, d] = (k_m[3 * k + c, 3 * j] * R[0, d]
                                   + k_m[3 * k + c, 3 * j + 1] * R[1, d]
                                   + k_m[3 * k + c, 3 * j + 2] * R[2, d])
            for c in range(3):
                for d in range(3):
                    entry = (R[0, c] * block[0, d] + R[1, c] * block[1, d]
                             + R[2, c] * block[2, d])
                    ke[6 * k + 6 + c, 6 * j + 6 + d] = entry
                    ke[6 * k + 6 + c, d] -= entry
                    if j < k:
                        ke[6 * j + 6 + d, c] -= entry
    for k in range(3):
        for c in range(3):
            for d in range(3):
                ke[c, d] -= ke[6 * k + 6 + c, d]

    # normals: D_j = R A_j; coupling with translations through k_b and the frame
    for j in range(4):
        for n in range(n_rot[j]):
            for c in range(3):
                D[j, c, n] = R[c, 0] * A[j, 0, n] + R[c, 1] * A[j, 1, n] + R[c, 2] * A[j, 2, n]
            d_x, d_y, d_z = D[j, 0, n], D[j, 1, n], D[j, 2, n]
            q_x = P_p[j, 0, 0] * d_x + P_p[j, 1, 0] * d_y + P_p[j, 2, 0] * d_z
            q_y = P_p[j, 0, 1] * d_x + P_p[j, 1, 1] * d_y + P_p[j, 2, 1] * d_z
            q_z = P_p[j, 0, 2] * d_x + P_p[j, 1, 2] * d_y + P_p[j, 2, 2] * d_z
            v1x, v1y, v1z, v2x, v2y, v2z = _diagonal_forces(a, b, L1, L2, (q_x, q_y, q_z))
            k_2 = k_b[0, 3 + 2 * j] * d_x + k_b[0, 4 + 2 * j] * d_y
            k_3 = k_b[1, 3 + 2 * j] * d_x + k_b[1, 4 + 2 * j] * d_y
            k_4 = k_b[2, 3 + 2 * j] * d_x + k_b[2, 4 + 2 * j] * d_y
            col = 6 * j + 3 + n
            for c in range(3):
                frame_24 = R[0, c] * v2x + R[1, c] * v2y + R[2, c] * v2z
                entry_2 = R[2, c] * k_2 - frame_24
                entry_3 = R[2, c] * k_3 + R[0, c] * v1x + R[1, c] * v1y + R[2, c] * v1z
                entry_4 = R[2, c] * k_4 + frame_24
                ke[col, c] = -(entry_2 + entry_3 + entry_4)
                ke[max(col, 6 + c), min(col, 6 + c)] = entry_2
                ke[max(col, 12 + c), min(col, 12 + c)] = entry_3
                ke[max(col, 18 + c), min(col, 18 + c)] = entry_4
    for i in range(4):
        for j in range(i + 1):
            k_xx, k_xy = k_b[3 + 2 * i, 3 + 2 * j], k_b[3 + 2 * i, 4 + 2 * j]
            k_yx, k_yy = k_b[4 + 2 * i, 3 + 2 * j], k_b[4 + 2 * i, 4 + 2 * j]
            for n in range(n_rot[j]):
                k_x = k_xx * D[j, 0, n] + k_xy * D[j, 1, n]
                k_y = k_yx * D[j, 0, n] + k_yy * D[j, 1, n]
                for m in range(n_rot[i]):
                    ke[6 * i + 3 + m, 6 * j + 3 + n] = D[i, 0, m] * k_x + D[i, 1, m] * k_y


@njit(cache=True)
def _pressure_point(y, xi, eta, weights, d_xi, d_eta):
    """Shape functions and tangent vectors of the bilinear surface at a natural point."""
    signs = ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))
    t_1, t_2 = np.zeros(3), np.zeros(3)
    for i in range(4):
        s, t = signs[i]
        weights[i] = 0.25 * (1.0 + s * xi) * (1.0 + t * eta)
        d_xi[i] = 0.25 * s * (1.0 + t * eta)
        d_eta[i] = 0.25 * t * (1.0 + s * xi)
        if i > 0:
            for c in range(3):
                t_1[c] += d_xi[i] * y[i - 1, c]
                t_2[c] += d_eta[i] * y[i - 1, c]
    return t_1, t_2


@njit(cache=True)
def pressure_forces(y, pressure, f):
    """Follower pressure along the normal: ``f_i = p int N_i (x,xi x x,eta) dxi deta`` (4, 3)."""
    N, d_xi, d_eta = np.empty(4), np.empty(4), np.empty(4)
    f[:] = 0.0
    for xi in (-GAUSS, GAUSS):
        for eta in (-GAUSS, GAUSS):
            t_1, t_2 = _pressure_point(y, xi, eta, N, d_xi, d_eta)
            for c in range(3):
                d, e = (c + 1) % 3, (c + 2) % 3
                normal = t_1[d] * t_2[e] - t_1[e] * t_2[d]
                for i in range(4):
                    f[i, c] += pressure * N[i] * normal


@njit(cache=True)
def add_pressure_stiffness(y, pressure, ke):
    """Subtract the symmetric part of ``d f_i / d x_j`` of a follower pressure from ``ke``.

    The skew part is a boundary term: it vanishes in the assembled matrix where the loaded surface
    is closed or its rim is held.
    """
    N, d_xi, d_eta = np.empty(4), np.empty(4), np.empty(4)
    for xi in (-GAUSS, GAUSS):
        for eta in (-GAUSS, GAUSS):
            t_1, t_2 = _pressure_point(y, xi, eta, N, d_xi, d_eta)
            for i in range(4):
                for j in range(4):
                    # d(t_1 x t_2) = spin(a) dx_j with a = N_j,eta t_1 - N_j,xi t_2
                    for c in range(3):
                        d, e = (c + 1) % 3, (c + 2) % 3
                        a_c = 0.5 * pressure * N[i] * (d_eta[j] * t_1[c] - d_xi[j] * t_2[c])
                        # row d, column e of spin(a) is -a_c; row e, column d is +a_c
                        ke[6 * i + d, 6 * j + e] += a_c
                        ke[6 * i + e, 6 * j + d] -= a_c
                        ke[6 * j + e, 6 * i + d] += a_c
                        ke[6 * j + d, 6 * i + e] -= a_c


WORK = ((9, 9), (9, 3), (4, 3, 3), (11, 3), (3, 3), (6, 6), (9, 3), (9, 3), (4, 3, 3), (3, 3))
"""Shapes of the scratch arrays ``work`` of ``tangent``."""


@njit(cache=True, no_cpython_wrapper=True)
def workspace():
    """Scratch lanes of ``tangent``, made once for all elements."""
    return (new(WORK[0]), new(WORK[1]), new(WORK[2]), new(WORK[3]), new(WORK[4]), new(WORK[5]),
            new(WORK[6]), new(WORK[7]), new(WORK[8]), new(WORK[9]))
