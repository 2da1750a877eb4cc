"""The discrete Jacobian of the local variables: ``T_bar dq = u_L(q_1) - u_L(q_0)``, whatever the
step, and blind to every rigid motion about the midpoint.

With ``v_1 = y_3``, ``v_2 = y_4 - y_2``, l_a their lengths and z any of y_2, y_3, y_4, p_1..p_4, the
local variables are made of dot products and of one triple product:

    s_a = v_a . z / l_a          c = v_1 . v_2 / (l_1 l_2),  2a = sqrt(2 - 2c),  2b = sqrt(2 + 2c)
    e_x . z = (s_1 - s_2) / 2a   e_y . z = (s_1 + s_2) / 2b
    e_z . y_2 = e_z . y_4 = Z = (v_1 x v_2) . y_2 / D,  D = |v_1 x v_2|,  e_z . y_3 = 0

The increment of each line is linear in the increments it is made of, with coefficients of both
ends: ``d(a b) = a_m db + b_m da``, ``d(a/b) = (da - (a/b)_m db) / b_m``.  ``force`` is its
transpose, so that its forces do the work of the local ones, and conserve momenta, exactly.
Derivation: theory page "The exact scheme".
"""

import math
from typing import NamedTuple

import numpy as np

from .jit import internal, kernel
from .lanes import new
from .vectors import cross, dot


class Invariants(NamedTuple):
    """Local variables of an element at one end of a step, and what they are made of; arrays of
    lanes or of numbers.

    Attributes:
        s: (7, 2) ``v_a . z / l_a`` for y_2, y_3, y_4 [m] and p_1..p_4.
        z: (7, 2) components along e_x and e_y.
        v: (2, 3) v_1, v_2 [m].
        n: (3,) ``v_1 x v_2`` [m^2].
        q: (9,) l_1, l_2 [m], v_1 . v_2 / l_1 [m], c, 2a, 2b, D [m^2], Z [m], v_1 . v_2 [m^2].
    """

    s: np.ndarray
    z: np.ndarray
    v: np.ndarray
    n: np.ndarray
    q: np.ndarray


class ForceWork(NamedTuple):
    """Work arrays of ``force``, of lanes or of numbers.

    Attributes:
        v: (2, 3) mean v_1, v_2 [m].
        dv: (2, 3) their increments [m].
        on_v: (2, 3) forces on them [N].
        on_y: (3, 3) forces on y_2, y_3, y_4 [N].
        a: (3, 3) vectors.
        b: (3, 3) vectors.
        d: (3,) vector.
    """

    v: np.ndarray
    dv: np.ndarray
    on_v: np.ndarray
    on_y: np.ndarray
    a: np.ndarray
    b: np.ndarray
    d: np.ndarray


@internal
def invariants():
    """``Invariants`` of lanes."""
    return Invariants(new((7, 2)), new((7, 2)), new((2, 3)), new((3,)), new((9,)))


@internal
def force_work():
    """``ForceWork`` of lanes."""
    return ForceWork(new((2, 3)), new((2, 3)), new((2, 3)), new((3, 3)), new((3, 3)), new((3, 3)),
                     new((3,)))


@kernel
def measure(y, p, end):
    """Fill ``Invariants`` from relative positions ``y`` (3, 3) and normals ``p`` (4, 3)."""
    s, z, v, n, q = end
    for c in range(3):
        v[0, c], v[1, c] = y[1, c], y[2, c] - y[0, c]
    cross(v[0], v[1], n)
    l_1, l_2 = math.sqrt(dot(v[0], v[0])), math.sqrt(dot(v[1], v[1]))
    w_12 = dot(v[0], v[1])
    g = w_12 / l_1
    cosine = g / l_2
    two_a, two_b = math.sqrt(2.0 - 2.0 * cosine), math.sqrt(2.0 + 2.0 * cosine)
    D = math.sqrt(dot(n, n))
    q[0], q[1], q[2], q[3], q[4], q[5], q[6], q[8] = l_1, l_2, g, cosine, two_a, two_b, D, w_12
    q[7] = dot(n, y[0]) / D
    r_1, r_2, r_a, r_b = 1.0 / l_1, 1.0 / l_2, 1.0 / two_a, 1.0 / two_b
    for k in range(7):
        w = y[k] if k < 3 else p[k - 3]
        s_1, s_2 = dot(v[0], w) * r_1, dot(v[1], w) * r_2
        s[k, 0], s[k, 1] = s_1, s_2
        z[k, 0], z[k, 1] = (s_1 - s_2) * r_a, (s_1 + s_2) * r_b


@kernel
def local_variables(end, y0, r0, t, b):
    """Local variables of Eqs. (8), (10), as ``element.local_variables``: ``t`` (3, 3), ``b``
    (11,)."""
    z, Z = end.z, end.q[7]
    for k in range(3):
        t[k, 0], t[k, 1] = z[k, 0] - y0[k, 0], z[k, 1] - y0[k, 1]
        if k == 1:
            t[k, 2] = -y0[k, 2]
        else:
            t[k, 2] = Z - y0[k, 2]
        b[k] = t[k, 2]
    for i in range(4):
        b[3 + 2 * i], b[4 + 2 * i] = z[3 + i, 0] - r0[i, 0], z[3 + i, 1] - r0[i, 1]


@kernel
def force(start, end, y, dy, p, f, g, work, f_x, f_p):
    """``T_bar^T f_L``: forces f (3, 3) on the local displacements and g (4, 2) on dr, as forces on
    nodes ``f_x`` (4, 3) and normals ``f_p`` (4, 3).

    Args:
        start, end: ``Invariants`` of both ends of the step.
        y: (3, 3) mean relative positions [m]; dy: their increments [m].
        p: (4, 3) mean normals.
        f, g: local forces.
        work: ``ForceWork``.
        f_x, f_p: to be filled; the forces on the nodes sum to zero.
    """
    v, dv, on_v, on_y, _, _, _ = work
    q_0, q_1 = start.q, end.q
    for c in range(3):
        v[0, c], v[1, c] = y[1, c], y[2, c] - y[0, c]
        dv[0, c], dv[1, c] = dy[1, c], dy[2, c] - dy[0, c]
    l_1, l_2, gm = 0.5 * (q_0[0] + q_1[0]), 0.5 * (q_0[1] + q_1[1]), 0.5 * (q_0[2] + q_1[2])
    cosine = 0.5 * (q_0[3] + q_1[3])
    r_1, r_2 = 1.0 / l_1, 1.0 / l_2
    r_a, r_b = 2.0 / (q_0[4] + q_1[4]), 2.0 / (q_0[5] + q_1[5])
    on_1, on_2, on_a, on_b = 0.0 * r_1, 0.0 * r_1, 0.0 * r_1, 0.0 * r_1
    for c in range(3):
        on_v[0, c] = on_v[1, c] = on_1
    for k in range(7):
        w = y[k] if k < 3 else p[k - 3]
        f_z, f_e = (f[k, 0], f[k, 1]) if k < 3 else (g[k - 3, 0], g[k - 3, 1])
        f_z, f_e = f_z * r_a, f_e * r_b
        on_a -= 0.5 * (start.z[k, 0] + end.z[k, 0]) * f_z
        on_b -= 0.5 * (start.z[k, 1] + end.z[k, 1]) * f_e
        f_1, f_2 = (f_e + f_z) * r_1, (f_e - f_z) * r_2
        on_1 -= 0.5 * (start.s[k, 0] + end.s[k, 0]) * f_1
        on_2 -= 0.5 * (start.s[k, 1] + end.s[k, 1]) * f_2
        for c in range(3):
            entry = f_1 * v[0, c] + f_2 * v[1, c]
            if k < 3:
                on_y[k, c] = entry
            else:
                f_p[k - 3, c] = entry
            on_v[0, c] += f_1 * w[c]
            on_v[1, c] += f_2 * w[c]
    on_c = on_b * r_b - on_a * r_a
    on_2 -= cosine * (on_c * r_2)
    on_g = on_c * r_2 * r_1
    on_1 -= gm * on_g
    on_1, on_2 = on_1 * r_1, on_2 * r_2
    for c in range(3):
        on_v[0, c] += on_g * v[1, c] + on_1 * v[0, c]
        on_v[1, c] += on_g * v[0, c] + on_2 * v[1, c]
    _height_force(q_0, q_1, y, dy, f[0, 2] + f[2, 2], work)
    for c in range(3):
        f_2, f_3, f_4 = on_y[0, c] - on_v[1, c], on_y[1, c] + on_v[0, c], on_y[2, c] + on_v[1, c]
        f_x[0, c] = -(f_2 + f_3 + f_4)
        f_x[1, c] = f_2
        f_x[2, c] = f_3
        f_x[3, c] = f_4


@kernel
def _height_force(q_0, q_1, y, dy, f_Z, work):
    """What a force on Z puts on v_1, v_2 and y_2: ``dZ = (d tau - Z_m dD) / D_m``, tau the triple
    product of v_1, v_2 and y_2."""
    v, dv, on_v, on_y, _, _, d = work
    on_tau = f_Z / (0.5 * (q_0[6] + q_1[6]))
    on_D = -0.5 * (q_0[7] + q_1[7]) * on_tau / (0.5 * (q_0[6] + q_1[6]))
    w_11 = 0.5 * (q_0[0] * q_0[0] + q_1[0] * q_1[0])
    w_22 = 0.5 * (q_0[1] * q_0[1] + q_1[1] * q_1[1])
    w_12 = 0.5 * (q_0[8] + q_1[8])
    for c in range(3):
        on_v[0, c] += on_D * (w_22 * v[0, c] - w_12 * v[1, c])
        on_v[1, c] += on_D * (w_11 * v[1, c] - w_12 * v[0, c])
    for one, two, on in ((v[1], y[0], on_v[0]), (y[0], v[0], on_v[1]), (v[0], v[1], on_y[0])):
        cross(one, two, d)
        for c in range(3):
            on[c] += on_tau * d[c]
    triple_remainder(v, dv, y[0], dy[0], 0.25 * on_tau, work.a, work.b, d, on_v, on_y[0])


@kernel
def triple_remainder(v, dv, y, dy, on, a, b, n, on_v, on_y):
    """``on [dv_1, dv_2, dy]``, the part of the increment of a triple product that is cubic, as
    forces linear in the increments and blind to rigid motions.

    With the rotation th of ``turn`` and the rests ``r_i = d_i - th x i_m``:
    ``[dv_1, dv_2, dy] = (dv_2 x dy) . r_1 + (dy x a_1) . r_2 + (a_1 x a_2) . r_y``,
    ``a_i = th x v_i``, because th x v_1, th x v_2 and th x y lie in one plane.
    """
    th, m, part = b[0], b[1], b[2]
    a_1, a_2 = a[0], a[1]
    turn(v, dv, n, th)
    cross(th, v[0], a_1)
    cross(th, v[1], a_2)
    for c in range(3):
        m[c] = 0.0 * on
    cross(dv[1], dy, part)
    add_rest(on, part, v[0], on_v[0], m)
    cross(dy, a_1, part)
    add_rest(on, part, v[1], on_v[1], m)
    cross(a_1, a_2, part)
    add_rest(on, part, y, on_y, m)
    turn_transposed(v, n, m, on_v[0], on_v[1])


@kernel
def add_rest(on, coefficient, at, force, m):
    """Force ``on`` times a coefficient of a rest ``d - th x at``, and the moment that it takes off
    th."""
    x, y, z = on * coefficient[0], on * coefficient[1], on * coefficient[2]
    force[0] += x
    force[1] += y
    force[2] += z
    m[0] -= at[1] * z - at[2] * y
    m[1] -= at[2] * x - at[0] * z
    m[2] -= at[0] * y - at[1] * x


@kernel
def turn(v, dv, n, th):
    """An estimate ``th = G dv`` of the rotation of two vectors v (2, 3) by their increments, exact
    for a rigid one; ``n = v_1 x v_2``."""
    cross(v[0], v[1], n)
    nn = dot(n, n)
    along_1, along_2 = dot(n, dv[0]) / nn, dot(n, dv[1]) / nn
    about = 0.5 * (_across(n, v[0], dv[0]) + _across(n, v[1], dv[1])) / nn
    for c in range(3):
        th[c] = v[0, c] * along_2 - v[1, c] * along_1 + n[c] * about


@kernel
def _across(n, v, d):
    """``(n x v) . d / |v|^2``"""
    return ((n[1] * v[2] - n[2] * v[1]) * d[0] + (n[2] * v[0] - n[0] * v[2]) * d[1]
            + (n[0] * v[1] - n[1] * v[0]) * d[2]) / dot(v, v)


@kernel
def turn_transposed(v, n, m, on_1, on_2):
    """``G^T m`` of ``turn``, added to the forces on v_1 and v_2."""
    nn = dot(n, n)
    along_1, along_2 = dot(v[1], m) / nn, dot(v[0], m) / nn
    about = 0.5 * dot(n, m) / nn
    about_1, about_2 = about / dot(v[0], v[0]), about / dot(v[1], v[1])
    for c in range(3):
        d, e = (c + 1) % 3, (c + 2) % 3
        on_1[c] += about_1 * (n[d] * v[0, e] - n[e] * v[0, d]) - along_1 * n[c]
        on_2[c] += about_2 * (n[d] * v[1, e] - n[e] * v[1, d]) + along_2 * n[c]
