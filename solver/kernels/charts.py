"""Vectorial rotational variables (paper Eqs. 24-36): the only place that knows of charts.

A node carries one or more directors (mid-surface normals) and 2 or 3 rotational variables, which
are components in the axes t_1, t_2, t_3 of its *triad*, the chart of the node:

- a smooth node, 2 variables: ``p = n t_1 + m t_2 + sqrt(1 - n^2 - m^2) t_3``, Eqs. (5), (24);
- a junction, 3 variables: ``n = e_y . t_1``, ``m = e_y . t_2``, ``k = e_z . t_1`` of a nodal frame
  (e_x, e_y, e_z) that carries all directors of the node along, ``p = e_x a_x + e_y a_y + e_z a_z``,
  Eqs. (11), (12).

Triads are renewed between two steps only.  Either they are global axes, permuted and signed, as in
the paper (the variables are then the smaller components of p, or of e_y and e_z), or they follow
the node, with t_3 along p (e_y) as it will be at the middle of the next step.

The rest of the solver sees the directors ``p``, their first derivatives ``A1 = dp/dn`` and the
number of variables of a node.  ``nodes`` below is (start (n_nodes,), n_rot (n_nodes,), first
(n_nodes + 1,), body (n_directors, 3)): first dof and number of variables of a node, its directors
``first[i] .. first[i + 1] - 1`` and their components a in the nodal frame of a junction.
"""

import math

import numpy as np
from numba import njit

CHART_LIMIT = 0.95
"""n^2 + m^2 (and k^2 / (1 - n^2)) beyond which a chart is left: far outside a sound step."""

CHART_LEFT = 1
"""Returned by ``advance_nodes`` when a director leaves its chart."""

SWITCH_RATIO = 1.001
"""Hysteresis of global axes: t_3 changes once another component exceeds that along t_3 by this
ratio half a step ahead.

Just enough to stop a node from switching to and fro.  The border and its timing matter: rotational
oscillations far faster than the step are neither resolved nor damped; they keep their size in n,
so p_dot = A1 n_dot changes with the chart.  Switching late by an angle d multiplies them by
tan(45 deg + d) with every quarter turn; switching half a step ahead of the border is late as often
as early.  Axes that follow the node do not multiply them at all.
"""

EARLIEST = 0.4
"""Size of the dependent component now that a chart chosen ahead must have: a step may turn far."""


@njit(cache=True)
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True)
def _cross(a, b, c):
    """c = a x b."""
    c[0] = a[1] * b[2] - a[2] * b[1]
    c[1] = a[2] * b[0] - a[0] * b[2]
    c[2] = a[0] * b[1] - a[1] * b[0]


@njit(cache=True)
def _along(p, triad, k):
    """p . t_k; a slice ``triad[k]`` would be counted as a reference, which takes longer."""
    return p[0] * triad[k, 0] + p[1] * triad[k, 1] + p[2] * triad[k, 2]


@njit(cache=True)
def _couple(moments, i, p, d):
    """Couple ``M_i x p_d`` as three numbers."""
    return (moments[i, 1] * p[d, 2] - moments[i, 2] * p[d, 1],
            moments[i, 2] * p[d, 0] - moments[i, 0] * p[d, 2],
            moments[i, 0] * p[d, 1] - moments[i, 1] * p[d, 0])


@njit(cache=True)
def normal(n, m, triad, p):
    """``p`` (3,) from its two variables; False (p untouched) where they leave the chart."""
    rest = 1.0 - n * n - m * m
    if not rest >= 1.0 - CHART_LIMIT:
        return False
    s = math.sqrt(rest)
    for c in range(3):
        p[c] = n * triad[0, c] + m * triad[1, c] + s * triad[2, c]
    return True


@njit(cache=True)
def first_derivatives(p, triad, A1):
    """``A1`` (3, >=2) of Eq. (27): ``dp/dn = t_1 - (n/s) t_3``, ``dp/dm = t_2 - (m/s) t_3``."""
    s = _along(p, triad, 2)
    a, b = _along(p, triad, 0) / s, _along(p, triad, 1) / s
    for c in range(3):
        A1[c, 0] = triad[0, c] - a * triad[2, c]
        A1[c, 1] = triad[1, c] - b * triad[2, c]


@njit(cache=True)
def second_derivatives(p, triad):
    """``(s_nn, s_nm, s_mm)`` of Eq. (29) for s = p . t_3; the other components are linear."""
    n, m, s = _along(p, triad, 0), _along(p, triad, 1), _along(p, triad, 2)
    cube = s * s * s
    return -1.0 / s - n * n / cube, -n * m / cube, -1.0 / s - m * m / cube


@njit(cache=True)
def convective(p, triad, rates):
    """The single component (along t_3) of A2, Eq. (28)."""
    nn, nm, mm = second_derivatives(p, triad)
    return (nn * rates[0] * rates[0] + 2.0 * nm * rates[0] * rates[1]
            + mm * rates[1] * rates[1])


@njit(cache=True)
def nodal_frame(n, m, k, triad, e):
    """Nodal frame of a junction, rows e_x, e_y, e_z of ``e``; False where it leaves the chart.

    ``e_y = n t_1 + m t_2 + s t_3``, e_z the unit vector normal to it with ``e_z . t_1 = k`` that
    points along t_2 where n = m = k = 0, ``e_x = e_y x e_z``.
    """
    square = 1.0 - n * n
    rest = square - m * m
    if not rest >= 1.0 - CHART_LIMIT or not k * k <= CHART_LIMIT * square:
        return False
    s = math.sqrt(rest)
    along, across = -n * k / square, math.sqrt(square - k * k) / square
    second, third = along * m + across * s, along * s - across * m
    for c in range(3):
        e[1, c] = n * triad[0, c] + m * triad[1, c] + s * triad[2, c]
        e[2, c] = k * triad[0, c] + second * triad[1, c] + third * triad[2, c]
    _cross(e[1], e[2], e[0])
    return True


@njit(cache=True)
def spins(e, triad, G, omega):
    """Spins ``omega[:, i]`` of a nodal frame for unit rates of its variables, ``G omega = 1``.

    From ``n = e_y . t_1`` and so on, ``dn = d(phi) . (e_y x t_1)``: the rows of G are
    ``e_y x t_1, e_y x t_2, e_z x t_1``.
    """
    _cross(e[1], triad[0], G[0])
    _cross(e[1], triad[1], G[1])
    _cross(e[2], triad[0], G[2])
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        for c in range(3):
            d, f = (c + 1) % 3, (c + 2) % 3
            omega[c, i] = G[j, d] * G[k, f] - G[j, f] * G[k, d]
    determinant = G[0, 0] * omega[0, 0] + G[0, 1] * omega[1, 0] + G[0, 2] * omega[2, 0]
    for i in range(3):
        for c in range(3):
            omega[c, i] /= determinant


@njit(cache=True)
def spin_derivative(e, triad, omega, a, b, result):
    """Rate of the spin ``a`` while the frame turns with the spin ``b``, both (3,).

    ``a = omega x`` with fixed x; from ``d(G omega) = 0``: ``G da = -(a . ((b x e_y) x t_1), ...)``.
    """
    turned, arm, right = np.empty(3), np.empty(3), np.empty(3)
    for row in range(3):
        _cross(b, e[1 if row < 2 else 2], turned)
        _cross(turned, triad[1 if row == 1 else 0], arm)
        right[row] = -_dot(a, arm)
    for c in range(3):
        result[c] = omega[c, 0] * right[0] + omega[c, 1] * right[1] + omega[c, 2] * right[2]


@njit(cache=True)
def _carry(e, body, p):
    """Director of a junction from the nodal frame, Eq. (11)."""
    for c in range(3):
        p[c] = e[0, c] * body[0] + e[1, c] * body[1] + e[2, c] * body[2]


@njit(cache=True)
def _swing(omega, p, A1):
    """Derivatives of a director that turns with the spins: columns ``w_k x p``."""
    for k in range(3):
        A1[0, k] = omega[1, k] * p[2] - omega[2, k] * p[1]
        A1[1, k] = omega[2, k] * p[0] - omega[0, k] * p[2]
        A1[2, k] = omega[0, k] * p[1] - omega[1, k] * p[0]


@njit(cache=True)
def _place_junction(nodes, i, x, triad, e, G, omega, p, A1):
    """Directors of the junction ``i`` and their derivatives ``omega_k x p``; False if off."""
    first, body = nodes[2], nodes[3]
    if not nodal_frame(x[0], x[1], x[2], triad, e):
        return False
    spins(e, triad, G, omega)
    for d in range(first[i], first[i + 1]):
        _carry(e, body[d], p[d])
        _swing(omega, p[d], A1[d])
    return True


@njit(cache=True)
def place_directors(nodes, variables, chart, p, A1):
    """All directors and their derivatives; index of the first node off its chart, or -1."""
    n_rot, first = nodes[1], nodes[2]
    e, G, omega = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    for i in range(variables.shape[0]):
        if n_rot[i] == 2:
            d = first[i]
            if not normal(variables[i, 0], variables[i, 1], chart[i], p[d]):
                return i
            first_derivatives(p[d], chart[i], A1[d])
        elif not _place_junction(nodes, i, variables[i], chart[i], e, G, omega, p, A1):
            return i
    return -1


@njit(cache=True)
def derivatives(nodes, chart, p, A1):
    """``A1`` of all directors, from the directors themselves."""
    n_rot, first, body = nodes[1], nodes[2], nodes[3]
    e, G, omega = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    for i in range(chart.shape[0]):
        if n_rot[i] == 2:
            first_derivatives(p[first[i]], chart[i], A1[first[i]])
            continue
        frame_of(body, first[i], p, e)
        spins(e, chart[i], G, omega)
        for d in range(first[i], first[i + 1]):
            _swing(omega, p[d], A1[d])


@njit(cache=True)
def moment_forces(nodes, i, chart, p, A1, moments, f):
    """Generalized forces of a moment M about fixed axes at node i: ``f_n = A1^T (M x p)`` on a
    smooth node, ``f_k = w_k . M`` with the spins w_k on a junction."""
    d = nodes[2][i]
    if nodes[1][i] == 2:
        x, y, z = _couple(moments, i, p, d)
        for k in range(2):
            f[k] = A1[d, 0, k] * x + A1[d, 1, k] * y + A1[d, 2, k] * z
        return
    e, G, omega = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    frame_of(nodes[3], d, p, e)
    spins(e, chart[i], G, omega)
    for k in range(3):
        f[k] = (omega[0, k] * moments[i, 0] + omega[1, k] * moments[i, 1]
                + omega[2, k] * moments[i, 2])


@njit(cache=True)
def director_rates(nodes, velocity, A1, p_dot):
    """``p_dot = A1 n_dot``, Eqs. (30a), (31), of all directors from the dof velocities."""
    start, n_rot, first, _ = nodes
    for i in range(start.shape[0]):
        for d in range(first[i], first[i + 1]):
            for c in range(3):
                rate = 0.0
                for k in range(n_rot[i]):
                    rate += A1[d, c, k] * velocity[start[i] + 3 + k]
                p_dot[d, c] = rate


@njit(cache=True)
def choose_triad(v, ahead, old, fixed_component, follow, triad):
    """Fill ``triad`` for a unit vector ``v`` that moves to ``ahead``; False if it is ``old``.

    ``follow``: t_3 along ``ahead``, t_1 as near to the old one as it can be.  Otherwise global
    axes: the one along t_3 stays unless another component exceeds it by ``SWITCH_RATIO``
    (``old = 0``: none yet, the largest).  A global axis ``fixed_component`` whose component a
    support fixes stays t_1 (-1: none).
    """
    empty = old[2, 0] == 0.0 and old[2, 1] == 0.0 and old[2, 2] == 0.0
    if follow and not empty:
        if fixed_component >= 0:
            triad[0] = 0.0
            triad[0, fixed_component] = 1.0
            share = ahead[fixed_component]
            for c in range(3):
                triad[2, c] = ahead[c] - share * triad[0, c]
        else:
            triad[2] = ahead
        size = math.sqrt(_dot(triad[2], triad[2]))
        for c in range(3):
            triad[2, c] /= size
        if fixed_component < 0:
            share = _dot(old[0], triad[2])
            for c in range(3):
                triad[0, c] = old[0, c] - share * triad[2, c]
            size = math.sqrt(_dot(triad[0], triad[0]))
            for c in range(3):
                triad[0, c] /= size
        if size > 0.1 and _dot(v, triad[2]) > EARLIEST:
            _cross(triad[2], triad[0], triad[1])
            return True
        ahead = v
    best, size = -1, -1.0
    if not empty:
        for c in range(3):
            if abs(old[2, c]) == 1.0:
                best, size = c, abs(ahead[c]) * SWITCH_RATIO
    before = best
    for c in range(3):
        if c != fixed_component and abs(ahead[c]) > size:
            best, size = c, abs(ahead[c])
    if best == before or (before >= 0 and abs(v[best]) < EARLIEST):
        triad[:] = old
        return False
    one, two = (best + 1) % 3, (best + 2) % 3
    if two == fixed_component:
        one, two = two, one
    triad[:] = 0.0
    triad[0, one] = triad[1, two] = 1.0
    triad[2, best] = 1.0 if v[best] >= 0.0 else -1.0
    return True


@njit(cache=True)
def choose_junction_triad(e, ahead, old, follow, triad):
    """The same for a junction with nodal frame ``e`` that moves to ``ahead`` (rows e_x, e_y, e_z).

    Following axes are (e_x, e_z, e_y) ahead.  Global axes: t_3 by e_y as above, and t_1 of the two
    others the one with the smaller component of e_z (ahead, with hysteresis); t_2 is signed so that
    e_z points along it.
    """
    if follow and not (old[2, 0] == 0.0 and old[2, 1] == 0.0 and old[2, 2] == 0.0):
        if _dot(e[1], ahead[1]) > EARLIEST and _dot(e[2], ahead[2]) > EARLIEST:
            triad[0], triad[1], triad[2] = ahead[0], ahead[2], ahead[1]
            return True
        ahead = e
    choose_triad(e[1], ahead[1], old, -1, False, triad)
    same = True
    for c in range(3):
        same = same and triad[2, c] == old[2, c]
    one, two = np.argmax(np.abs(triad[0])), np.argmax(np.abs(triad[1]))
    ratio = SWITCH_RATIO if same else 1.0
    if abs(ahead[2, one]) > ratio * abs(ahead[2, two]):
        one, two = two, one
        same = False
    if same:
        return False
    triad[0], triad[1] = 0.0, 0.0
    triad[0, one] = triad[1, two] = 1.0
    if _dot(e[2], triad[1]) * _dot(e[1], triad[2]) < _dot(e[2], triad[2]) * _dot(e[1], triad[1]):
        triad[1, two] = -1.0
    return True


@njit(cache=True)
def start_charts(nodes, fixed_component, p, p_dot, variables, chart, velocity):
    """Charts (global axes), variables and their rates from normals and normal velocities at t = 0.

    The nodal frame of a junction starts along the global axes; its spin follows from the rates of
    its first two directors.
    """
    start, n_rot, first, _ = nodes
    none, e, omega = np.zeros((3, 3)), np.eye(3), np.empty(3)
    for i in range(start.shape[0]):
        k, d = start[i] + 3, first[i]
        if n_rot[i] == 2:
            choose_triad(p[d], p[d], none, fixed_component[i], False, chart[i])
            for c in range(2):
                variables[i, c] = _dot(p[d], chart[i, c])
                velocity[k + c] = _dot(p_dot[d], chart[i, c])
        else:
            choose_junction_triad(e, e, none, False, chart[i])
            _spin_of(p[d], p[d + 1], p_dot[d], p_dot[d + 1], omega)
            _set_junction(e, omega, chart[i], variables[i], velocity[k:k + 3])


@njit(cache=True)
def _spin_of(a, b, a_dot, b_dot, omega):
    """Spin of a rigid pair of unit vectors: ``omega = a x a_dot + c a``, c from ``omega x b``."""
    side, rest = np.empty(3), np.empty(3)
    _cross(a, a_dot, omega)
    _cross(omega, b, rest)
    _cross(a, b, side)
    for c in range(3):
        rest[c] = b_dot[c] - rest[c]
    share = _dot(rest, side) / _dot(side, side)
    for c in range(3):
        omega[c] += share * a[c]


@njit(cache=True)
def _set_junction(e, omega, triad, x, rates):
    """Variables of a nodal frame in a triad, and their rates for the spin ``omega``."""
    turn_y, turn_z = np.empty(3), np.empty(3)
    _cross(omega, e[1], turn_y)
    _cross(omega, e[2], turn_z)
    x[0], x[1], x[2] = _dot(e[1], triad[0]), _dot(e[1], triad[1]), _dot(e[2], triad[0])
    rates[0], rates[1] = _dot(turn_y, triad[0]), _dot(turn_y, triad[1])
    rates[2] = _dot(turn_z, triad[0])


@njit(cache=True)
def advance_nodes(nodes, motion, step, delta, scratch):
    """Nodal quantities of an iterate: increments, directors at its end and at the midpoint, A1, and
    the accelerations ``(d2x, A1 n_ddot + A2)`` that enter M U_ddot + F_m (Eqs. 37, 40, 58)."""
    start, n_rot, first, _ = nodes
    _, _, variables, chart, velocity, acceleration = motion
    alpha_f, _, c_delta, c_velocity, c_acceleration, v_delta, v_velocity, v_acceleration = step
    dx, p_end, p_mid, A1, inertial_x, inertial_p = scratch[:6]
    weight = 1.0 - alpha_f
    x, x_dot, x_ddot = np.empty(3), np.empty(3), np.empty(3)
    e, G, omega = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    spin, rate, turned, twice = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for i in range(start.shape[0]):
        for c in range(3):
            k = start[i] + c
            dx[i, c] = delta[k]
            inertial_x[i, c] = (c_delta * delta[k] - c_velocity * velocity[k]
                                - c_acceleration * acceleration[k])
        for c in range(n_rot[i]):
            k = start[i] + 3 + c
            x[c] = variables[i, c] + delta[k]
            x_dot[c] = (v_delta * delta[k] - v_velocity * velocity[k]
                        - v_acceleration * acceleration[k])
            x_ddot[c] = (c_delta * delta[k] - c_velocity * velocity[k]
                         - c_acceleration * acceleration[k])
        d = first[i]
        if n_rot[i] == 2:
            if not normal(x[0], x[1], chart[i], p_end[d]):
                return CHART_LEFT
            k = start[i] + 3
            if not normal(variables[i, 0] + weight * delta[k],
                          variables[i, 1] + weight * delta[k + 1], chart[i], p_mid[d]):
                return CHART_LEFT
            first_derivatives(p_mid[d], chart[i], A1[d])
            bent = convective(p_mid[d], chart[i], x_dot)
            for c in range(3):
                inertial_p[d, c] = (A1[d, c, 0] * x_ddot[0] + A1[d, c, 1] * x_ddot[1]
                                    + bent * chart[i, 2, c])
            continue
        if not _place_junction(nodes, i, x, chart[i], e, G, omega, p_end, A1):
            return CHART_LEFT
        for c in range(3):
            x[c] = variables[i, c] + weight * delta[start[i] + 3 + c]
        if not _place_junction(nodes, i, x, chart[i], e, G, omega, p_mid, A1):
            return CHART_LEFT
        for c in range(3):
            spin[c] = _dot(omega[c], x_dot)
        spin_derivative(e, chart[i], omega, spin, spin, rate)
        for c in range(3):
            rate[c] += _dot(omega[c], x_ddot)
        for d in range(first[i], first[i + 1]):
            _cross(spin, p_mid[d], turned)
            _cross(spin, turned, twice)
            _cross(rate, p_mid[d], turned)
            for c in range(3):
                inertial_p[d, c] = turned[c] + twice[c]
    return 0


@njit(cache=True)
def curvature(nodes, i, p, A1, chart, forces, moments, H):
    """``H = sum f_p . d2p/dn2`` over the directors of node i (n_rot x n_rot), the last term of the
    tangent by the chain rule, less that of a moment M about fixed axes.

    On a smooth node ``f_p`` is less ``M x p``.  On a junction, with the spins w_k,
    ``f . p,kl = w_k,l . (p x f - M) + f . (w_k x (w_l x p))``, symmetric part of the M term.
    """
    _, n_rot, first, _ = nodes
    d, triad = first[i], chart[i]
    if n_rot[i] == 2:
        x, y, z = _couple(moments, i, p, d)
        along = ((forces[d, 0] - x) * triad[2, 0] + (forces[d, 1] - y) * triad[2, 1]
                 + (forces[d, 2] - z) * triad[2, 2])
        nn, nm, mm = second_derivatives(p[d], triad)
        H[0, 0], H[0, 1], H[1, 0], H[1, 1] = along * nn, along * nm, along * nm, along * mm
        return
    e, G, omega = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    total, part, rate, arm = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    frame_of(nodes[3], first[i], p, e)
    spins(e, triad, G, omega)
    for c in range(3):
        total[c] = -moments[i, c]
    for d in range(first[i], first[i + 1]):
        _cross(p[d], forces[d], part)
        for c in range(3):
            total[c] += part[c]
    for k in range(3):
        for l in range(k + 1):
            value = 0.0
            for one, two in ((k, l), (l, k)):
                spin_derivative(e, triad, omega, omega[:, one], omega[:, two], rate)
                value += 0.5 * _dot(rate, total)
            for d in range(first[i], first[i + 1]):
                for c in range(3):
                    # f . (w_k x (w_l x p)) and its transpose
                    arm[c] = A1[d, c, l]
                _cross(omega[:, k], arm, part)
                value += 0.5 * _dot(forces[d], part)
                for c in range(3):
                    arm[c] = A1[d, c, k]
                _cross(omega[:, l], arm, part)
                value += 0.5 * _dot(forces[d], part)
            H[k, l] = H[l, k] = value


@njit(cache=True)
def frame_of(body, d, p, e):
    """Nodal frame of a junction from its first two directors ``p[d], p[d + 1]``."""
    a, b = np.empty((3, 3)), np.empty((3, 3))
    for first, second, target in ((body[d], body[d + 1], a), (p[d], p[d + 1], b)):
        target[0] = first
        _cross(first, second, target[2])
        size = math.sqrt(_dot(target[2], target[2]))
        for c in range(3):
            target[2, c] /= size
        _cross(target[2], target[0], target[1])
    for row in range(3):
        for c in range(3):
            e[row, c] = b[0, c] * a[0, row] + b[1, c] * a[1, row] + b[2, c] * a[2, row]


@njit(cache=True)
def switch_charts(nodes, fixed_component, follow, dt, variables, chart, velocity, acceleration):
    """Renew the charts of all nodes, for their directors half a step ``dt`` ahead.

    p, p_dot = A1 n_dot and p_ddot = A1 n_ddot + A2 (Eq. 30) are carried over.  The velocity tells
    what is ahead: of an oscillation that alternates with the steps nothing is left there.

    Returns:
        How many nodes changed to other global axes.
    """
    start, n_rot = nodes[0], nodes[1]
    rate, second, ahead, p = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    new, A1, e, e_ahead = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    G, omega = np.empty((3, 3)), np.empty((3, 3))
    spin, change = np.empty(3), np.empty(3)
    switched = 0
    for i in range(start.shape[0]):
        k = start[i] + 3
        x_dot, x_ddot = velocity[k:k + n_rot[i]], acceleration[k:k + n_rot[i]]
        if n_rot[i] == 2:
            normal(variables[i, 0], variables[i, 1], chart[i], p)
            first_derivatives(p, chart[i], A1)
            for c in range(3):
                rate[c] = A1[c, 0] * x_dot[0] + A1[c, 1] * x_dot[1]
                ahead[c] = p[c] + 0.5 * dt * rate[c]
            size = math.sqrt(_dot(ahead, ahead))
            for c in range(3):
                ahead[c] /= size
            if not choose_triad(p, ahead, chart[i], fixed_component[i], follow, new):
                continue
            bent = convective(p, chart[i], x_dot)
            for c in range(3):
                second[c] = A1[c, 0] * x_ddot[0] + A1[c, 1] * x_ddot[1] + bent * chart[i, 2, c]
            for c in range(2):
                variables[i, c] = _dot(p, new[c])
                x_dot[c], x_ddot[c] = _dot(rate, new[c]), _dot(second, new[c])
        else:
            nodal_frame(variables[i, 0], variables[i, 1], variables[i, 2], chart[i], e)
            spins(e, chart[i], G, omega)
            for c in range(3):
                spin[c] = _dot(omega[c], x_dot)
            for row in range(1, 3):
                _cross(spin, e[row], change)
                for c in range(3):
                    e_ahead[row, c] = e[row, c] + 0.5 * dt * change[c]
            _orthonormal(e_ahead)
            if not choose_junction_triad(e, e_ahead, chart[i], follow, new):
                continue
            spin_derivative(e, chart[i], omega, spin, spin, change)
            for c in range(3):
                change[c] += _dot(omega[c], x_ddot)
            _set_junction(e, spin, new, variables[i], x_dot)
            spins(e, new, G, omega)
            spin_derivative(e, new, omega, spin, spin, rate)
            for c in range(3):
                change[c] -= rate[c]
            for c in range(3):
                x_ddot[c] = _dot(G[c], change)
        chart[i] = new
        switched += 0 if follow else 1
    return switched


@njit(cache=True)
def _orthonormal(e):
    """Make rows e_y, e_z of a frame orthonormal again and complete it."""
    size = math.sqrt(_dot(e[1], e[1]))
    for c in range(3):
        e[1, c] /= size
    share = _dot(e[1], e[2])
    for c in range(3):
        e[2, c] -= share * e[1, c]
    size = math.sqrt(_dot(e[2], e[2]))
    for c in range(3):
        e[2, c] /= size
    _cross(e[1], e[2], e[0])


@njit(cache=True)
def _rotate(angle, axis, v):
    """Rotate ``v`` by ``angle`` about the unit vector ``axis`` (Rodrigues)."""
    side = np.empty(3)
    _cross(axis, v, side)
    cosine, sine, share = math.cos(angle), math.sin(angle), _dot(axis, v)
    for c in range(3):
        v[c] = cosine * v[c] + sine * side[c] + (1.0 - cosine) * share * axis[c]


@njit(cache=True)
def turn_normals(nodes, fixed_component, correction, variables, chart, p, A1):
    """Turn every director as the correction of the variables says, along a great circle.

    For statics, where the directors are the whole state: large rotations stay rotations, no chart
    is left, and the variables are chosen afresh.  A supported component keeps its value.
    """
    start, n_rot, first, body = nodes
    turn, new, none = np.empty(3), np.empty((3, 3)), np.zeros(3)
    e, G, omega = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    rates = np.empty(3)
    for i in range(start.shape[0]):
        k, d = start[i] + 3, first[i]
        if n_rot[i] == 3:
            nodal_frame(variables[i, 0], variables[i, 1], variables[i, 2], chart[i], e)
            spins(e, chart[i], G, omega)
            for c in range(3):
                turn[c] = _dot(omega[c], correction[k:k + 3])
            angle = math.sqrt(_dot(turn, turn))
            if angle > 0.0:
                for c in range(3):
                    turn[c] /= angle
                _rotate(angle, turn, e[1])
                _rotate(angle, turn, e[2])
                _orthonormal(e)
            choose_junction_triad(e, e, chart[i], False, new)
            chart[i] = new
            _set_junction(e, none, new, variables[i], rates)
            for d in range(first[i], first[i + 1]):
                _carry(e, body[d], p[d])
            continue
        for c in range(3):
            turn[c] = A1[d, c, 0] * correction[k] + A1[d, c, 1] * correction[k + 1]
        angle = math.sqrt(_dot(turn, turn))
        kept = fixed_component[i]
        held = p[d, kept] if kept >= 0 else 0.0
        if angle > 0.0:
            cosine, sine = math.cos(angle), math.sin(angle) / angle
            for c in range(3):
                p[d, c] = cosine * p[d, c] + sine * turn[c]
        square = 0.0
        for c in range(3):
            if c != kept:
                square += p[d, c] * p[d, c]
        scale = math.sqrt((1.0 - held * held) / square)
        for c in range(3):
            p[d, c] = held if c == kept else scale * p[d, c]
        choose_triad(p[d], p[d], chart[i], kept, False, new)
        chart[i] = new
        variables[i, 0], variables[i, 1] = _dot(p[d], new[0]), _dot(p[d], new[1])


@njit(cache=True)
def largest_turn(nodes, correction, A1):
    """Largest angle [rad] by which a correction turns a director."""
    start, n_rot, first, _ = nodes
    largest = 0.0
    for i in range(start.shape[0]):
        for d in range(first[i], first[i + 1]):
            square = 0.0
            for c in range(3):
                turn = 0.0
                for k in range(n_rot[i]):
                    turn += A1[d, c, k] * correction[start[i] + 3 + k]
                square += turn * turn
            largest = max(largest, square)
    return math.sqrt(largest)
