"""The element's tangent in director coordinates, Eqs. (63), (69): a rank-3 correction of rotated
blocks.

With S phi the local displacements of a rotation phi of the frame and ``phi = G d(v_13, v_24)``,

    k = k_L + P G + (P G)^T + G^T (Y + S^T k_L S) G + H,   P = k_L S - F,

where k_L is the local tangent, F turns the local forces with the frame, Y is what they add of
second order, and H is the derivative of ``G^T m``, m the moment that the local forces put on the
frame.  Everything is evaluated in local axes and rotated once at the end.  Derivation: theory page
"The frame and its derivatives".
"""

from typing import NamedTuple

import numpy as np

from .element import diagonal_forces, frame_moment
from .jit import internal, kernel
from .lanes import new


class TangentWork(NamedTuple):
    """Work arrays of ``tangent``, of lanes or of numbers.

    Attributes:
        k_m: (9, 9) stiffness of the translations of nodes 2..4.
        P_b: (11, 3) rows of P for bending and shear.
        P_x: (9, 3) rows of P for translations.
        P_p: (4, 3, 3) rows of P for the normals.
        E: (3, 3) S^T k_L S, then Y + S^T k_L S.
        C: (6, 6) G^T (Y + S^T k_L S) G + H.
        V1: (9, 3) P G for v_13.
        V2: (9, 3) P G for v_24.
        D: (4, 3, 3) columns dp/dn in local axes.
        block: (3, 3).
        k_c: (11, 11) k_b, and what coupled measures add to it.
        k_t: (9, 8) stiffness of the translations on dr, by coupled measures.
    """

    k_m: np.ndarray
    P_b: np.ndarray
    P_x: np.ndarray
    P_p: np.ndarray
    E: np.ndarray
    C: np.ndarray
    V1: np.ndarray
    V2: np.ndarray
    D: np.ndarray
    block: np.ndarray
    k_c: np.ndarray
    k_t: np.ndarray


@internal
def tangent_work():
    """``TangentWork`` of lanes."""
    return TangentWork(new((9, 9)), new((11, 3)), new((9, 3)), new((4, 3, 3)), new((3, 3)),
                       new((6, 6)), new((9, 3)), new((9, 3)), new((4, 3, 3)), new((3, 3)),
                       new((11, 11)), new((9, 8)))


@kernel
def tangent(R, diagonals, yl, r, f, g, B, e, Q, k_b, coupling, A, n_rot, work, ke):
    """Element tangent ``T^T k_T T + dT/du : f_int``, Eq. (63), but for second derivatives of p.

    The columns ``A[i, :, :n_rot[i]]`` are the directions dp_i/dn_i.  ``ke`` (24, 24) receives the
    lower triangle, for vertex i in rows 6 i + (0, 1, 2) for x_i and 6 i + 3 + c for column c of
    A_i; unused rows are left alone.
    """
    coupled = coupling.shape[0] > 0
    if coupled:
        _coupled_stiffness(B, k_b, coupling, work.k_c, work.k_t)
        k_b = work.k_c
    _local_stiffness(B, e, Q, k_b, work.k_m)
    _bending_by_rotation(k_b, yl, r, work.P_b)
    _membrane_by_rotation(work.k_m, yl, work.P_b, work.P_x)
    if coupled:
        _coupling_by_rotation(work.k_t, yl, r, work.P_b, work.P_x)
    _rotation_by_rotation(work.P_x, work.P_b, yl, r, work.E)
    _less_turned_forces(f, g, work.P_b, work.P_x, work.P_p)
    _frame_stiffness(diagonals, yl, r, f, g, work.E, work.C)
    _add_frame(diagonals, work)
    _rotate_translations(R, work.k_m, work.block, ke)
    _couple_normals(R, diagonals, k_b, A, n_rot, work.P_p, work.D, ke)
    if coupled:
        _couple_translations(R, work.k_t, n_rot, work.D, ke)
    _normals(k_b, n_rot, work.D, ke)


@internal
def _coupled_stiffness(B, k_b, coupling, k_c, k_t):
    """With c = de/d(dr): ``k_t = B^T c``, and ``k_c`` is k_b with ``c^T c`` and with the rows of w
    in k_t, which are rows of bending as well."""
    for k in range(8):
        for i in range(9):
            k_ik = B[0, i] * coupling[0, k]
            for s in range(1, B.shape[0]):
                k_ik += B[s, i] * coupling[s, k]
            k_t[i, k] = k_ik
    for i in range(11):
        for j in range(i + 1):
            k_ij = k_b[i, j]
            if i >= 3 and j >= 3:
                for s in range(B.shape[0]):
                    k_ij += coupling[s, i - 3] * coupling[s, j - 3]
            elif i >= 3:
                k_ij += k_t[3 * j + 2, i - 3]
            k_c[i, j] = k_c[j, i] = k_ij


@internal
def _local_stiffness(B, e, Q, k_b, k_m):
    """Translations of k_L, Eq. (69): ``B^T B + sum_s e_s Q_s``, and bending and shear on w."""
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


@internal
def _bending_by_rotation(k_b, yl, r, P_b):
    """``P_b = k_b S``, but for its w-w block, which is in k_m."""
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


@internal
def _membrane_by_rotation(k_m, yl, P_b, P_x):
    """``P_x = k_m S``, and the rows of w in P_b."""
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


@internal
def _coupling_by_rotation(k_t, yl, r, P_b, P_x):
    """What the rows of u and v in k_t add to ``k_L S``, and to its rows of dr."""
    for k in range(3):
        for i in range(3 * k, 3 * k + 2):
            for j in range(4):
                k_x, k_y = k_t[i, 2 * j], k_t[i, 2 * j + 1]
                P_x[i, 0] += k_y * r[j, 2]
                P_x[i, 1] -= k_x * r[j, 2]
                P_x[i, 2] += k_x * r[j, 1] - k_y * r[j, 0]
        for j in range(8):
            k_u, k_v = k_t[3 * k, j], k_t[3 * k + 1, j]
            P_b[3 + j, 0] += k_v * yl[k, 2]
            P_b[3 + j, 1] -= k_u * yl[k, 2]
            P_b[3 + j, 2] += k_u * yl[k, 1] - k_v * yl[k, 0]


@internal
def _rotation_by_rotation(P_x, P_b, yl, r, E):
    """``E = S^T k_L S``"""
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


@internal
def _less_turned_forces(f, g, P_b, P_x, P_p):
    """``P = k_L S - F``: forces f and couples g turn with the frame; P_p from P_b."""
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


@internal
def _frame_stiffness(diagonals, yl, r, f, g, E, C):
    """Second-order part of the frame on ``(v_13, v_24)``: ``C = G^T (Y + S^T k_L S) G + H``.

    ``Y phi = sum (phi x y) x f + (phi x r) x g``; ``H`` is the derivative of ``G^T m`` with m held
    fixed in the frame.  ``C`` (6, 6) is symmetric although neither part is.
    """
    a, b, L1, L2 = diagonals
    _add_turned_moments(yl, r, f, g, E)
    m = frame_moment(yl, r, f, g)
    g1x, g1y, g1z, g2x, g2y, g2z = diagonal_forces(diagonals, m)
    h1, h2 = 0.5 / L1, 0.5 / L2
    twist1 = -(m[0] * a / (b * b) + m[1] * b / (a * a)) * h1
    twist2 = -(m[0] * a / (b * b) - m[1] * b / (a * a)) * h2
    for col in range(6):
        px, py, pz, stretch1, stretch2, beta = _diagonal_change(diagonals, col)
        qx = E[0, 0] * px + E[0, 1] * py + E[0, 2] * pz
        qy = E[1, 0] * px + E[1, 1] * py + E[1, 2] * pz
        qz = E[2, 0] * px + E[2, 1] * py + E[2, 2] * pz
        d1x, d1y, d1z, d2x, d2y, d2z = diagonal_forces(diagonals, (qx, qy, qz))
        mz_beta = m[2] * beta
        C[0, col] = d1x + py * g1z - pz * g1y - g1x * stretch1 - a * mz_beta * h1
        C[1, col] = d1y + pz * g1x - px * g1z - g1y * stretch1 - b * mz_beta * h1
        C[2, col] = d1z + px * g1y - py * g1x - g1z * stretch1 + twist1 * beta
        C[3, col] = d2x + py * g2z - pz * g2y - g2x * stretch2 - a * mz_beta * h2
        C[4, col] = d2y + pz * g2x - px * g2z - g2y * stretch2 + b * mz_beta * h2
        C[5, col] = d2z + px * g2y - py * g2x - g2z * stretch2 + twist2 * beta


@internal
def _add_turned_moments(yl, r, f, g, E):
    """``E += Y = sum y f^T + r g^T - (y . f + r . g) 1``"""
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


@internal
def _diagonal_change(diagonals, col):
    """What a unit change of component ``col`` of (v_13, v_24) does to the frame.

    Returns:
        Rotation G (three numbers), relative stretch of either diagonal, and change of the angle
        whose cosine and sine are a and b.
    """
    a, b, L1, L2 = diagonals
    h1, h2 = 0.5 / L1, 0.5 / L2
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
    return px, py, pz, stretch1, stretch2, beta


@internal
def _add_frame(diagonals, work):
    """``k_m += P G + (P G)^T + C``, with v_13 = y_3 and v_24 = y_4 - y_2."""
    a, b, L1, L2 = diagonals
    h1, h2 = 0.5 / L1, 0.5 / L2
    k_m, P_x, C, V1, V2 = work.k_m, work.P_x, work.C, work.V1, work.V2
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


@internal
def _rotate_translations(R, k_m, block, ke):
    """``R^T k R`` of nodes 2..4; node 1 from translation invariance."""
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


@internal
def _couple_normals(R, diagonals, k_b, A, n_rot, P_p, D, ke):
    """Rows of the normals and columns of the translations: k_b and P_p G with ``D_j = R A_j``."""
    for j in range(4):
        for n in range(n_rot[j]):
            for c in range(3):
                D[j, c, n] = R[c, 0] * A[j, 0, n] + R[c, 1] * A[j, 1, n] + R[c, 2] * A[j, 2, n]
            d_x, d_y, d_z = D[j, 0, n], D[j, 1, n], D[j, 2, n]
            q_x = P_p[j, 0, 0] * d_x + P_p[j, 1, 0] * d_y + P_p[j, 2, 0] * d_z
            q_y = P_p[j, 0, 1] * d_x + P_p[j, 1, 1] * d_y + P_p[j, 2, 1] * d_z
            q_z = P_p[j, 0, 2] * d_x + P_p[j, 1, 2] * d_y + P_p[j, 2, 2] * d_z
            v1x, v1y, v1z, v2x, v2y, v2z = diagonal_forces(diagonals, (q_x, q_y, q_z))
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


@internal
def _couple_translations(R, k_t, n_rot, D, ke):
    """What the rows of u and v in k_t add to rows of the normals; D as ``_couple_normals`` left it.
    """
    for j in range(4):
        for n in range(n_rot[j]):
            d_x, d_y = D[j, 0, n], D[j, 1, n]
            col = 6 * j + 3 + n
            for k in range(3):
                k_u = k_t[3 * k, 2 * j] * d_x + k_t[3 * k, 2 * j + 1] * d_y
                k_v = k_t[3 * k + 1, 2 * j] * d_x + k_t[3 * k + 1, 2 * j + 1] * d_y
                for c in range(3):
                    row, entry = 6 * k + 6 + c, R[0, c] * k_u + R[1, c] * k_v
                    ke[col, c] -= entry
                    ke[max(col, row), min(col, row)] += entry


@internal
def _normals(k_b, n_rot, D, ke):
    """``D_i^T k_b D_j`` of the normals."""
    for i in range(4):
        for j in range(i + 1):
            k_xx, k_xy = k_b[3 + 2 * i, 3 + 2 * j], k_b[3 + 2 * i, 4 + 2 * j]
            k_yx, k_yy = k_b[4 + 2 * i, 3 + 2 * j], k_b[4 + 2 * i, 4 + 2 * j]
            for n in range(n_rot[j]):
                k_x = k_xx * D[j, 0, n] + k_xy * D[j, 1, n]
                k_y = k_yx * D[j, 0, n] + k_yy * D[j, 1, n]
                for m in range(n_rot[i]):
                    ke[6 * i + 3 + m, 6 * j + 3 + n] = D[i, 0, m] * k_x + D[i, 1, m] * k_y
