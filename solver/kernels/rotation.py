"""Vectorial rotational variables (paper Eqs. 24-30): the only place that knows of charts.

Every node carries rotational variables; every director (mid-surface normal) belongs to one node.
On a smooth node the variables are the two components p_n, p_m of p with the smaller absolute
values, and ``p_l = s sqrt(1 - p_n^2 - p_m^2)``.  The chart of a node is the row ``(n, m, l, s)``.
The rest of the solver sees ``p``, ``A1 = dp/dn``, ``A2`` and the number of variables of a node.
"""

import math

import numpy as np
from numba import njit

CHART_LIMIT = 0.95
"""p_n^2 + p_m^2 beyond which a chart is left: p_l^2 < 0.05, |A1| > 4, far outside a sound step."""

CHART_LEFT = 1
"""Returned by :func:`advance_nodes` when a normal leaves its chart."""

SWITCH_RATIO = 1.001
"""Hysteresis: switch once a component exceeds |p_l| by this ratio half a step ahead.

Just enough to stop a node from switching to and fro.  The border and its timing matter: rotational
oscillations far faster than the step are neither resolved nor damped; they keep their size in n,
so p_dot = A1 n_dot changes with the chart, by p_n / p_l at a switch.  Switching late by an angle d
multiplies them by tan(45 deg + d) with every quarter turn; switching half a step ahead of the
border is late as often as early.
"""


EARLIEST = 0.4
"""Size of p_l now that a chart chosen ahead must have: a step may turn far."""


@njit(cache=True)
def normal(p_n, p_m, chart, p):
    """``p`` (3,) from its two variables; False (p untouched) where they leave the chart."""
    rest = 1.0 - p_n * p_n - p_m * p_m
    if not rest >= 1.0 - CHART_LIMIT:
        return False
    p[chart[0]] = p_n
    p[chart[1]] = p_m
    p[chart[2]] = chart[3] * math.sqrt(rest)
    return True


@njit(cache=True)
def first_derivatives(p, chart, A1):
    """``A1`` (3, >=2) of Eq. (27): ``dp_l/dp_n = -p_n/p_l``, ``dp_l/dp_m = -p_m/p_l``."""
    n, m, l = chart[0], chart[1], chart[2]
    A1[n, 0], A1[n, 1] = 1.0, 0.0
    A1[m, 0], A1[m, 1] = 0.0, 1.0
    A1[l, 0], A1[l, 1] = -p[n] / p[l], -p[m] / p[l]


@njit(cache=True)
def second_derivatives(p, chart):
    """``(d2p_l/dp_n2, d2p_l/dp_n dp_m, d2p_l/dp_m2)`` of Eq. (29); p_n and p_m are linear."""
    p_n, p_m, p_l = p[chart[0]], p[chart[1]], p[chart[2]]
    cube = p_l * p_l * p_l
    return -1.0 / p_l - p_n * p_n / cube, -p_n * p_m / cube, -1.0 / p_l - p_m * p_m / cube


@njit(cache=True)
def curvature(p, chart, f_p):
    """``f_p . d2p/dn2``, the last term of the tangent by the chain rule: (nn, nm, mm)."""
    nn, nm, mm = second_derivatives(p, chart)
    f_l = f_p[chart[2]]
    return f_l * nn, f_l * nm, f_l * mm


@njit(cache=True)
def convective(p, chart, n_dot, m_dot):
    """The single non-zero component (along p_l) of A2, Eq. (28)."""
    nn, nm, mm = second_derivatives(p, chart)
    return nn * n_dot * n_dot + 2.0 * nm * n_dot * m_dot + mm * m_dot * m_dot


@njit(cache=True)
def choose_chart(p, ahead, old, fixed_component, chart):
    """Fill ``chart`` for ``p``, which moves to ``ahead``; False if it is the chart ``old`` already.

    The dependent component stays unless another exceeds it by ``SWITCH_RATIO`` (``old[3] = 0``: no
    chart yet, the largest).  A component that a support fixes (``fixed_component``, -1 for none)
    stays the first variable.
    """
    best = -1
    size = -1.0
    if old[3] != 0:
        best = old[2]
        size = abs(ahead[best]) * SWITCH_RATIO
    for c in range(3):
        if c != fixed_component and abs(ahead[c]) > size:
            best, size = c, abs(ahead[c])
    first, second = (best + 1) % 3, (best + 2) % 3
    if second == fixed_component:
        first, second = second, first
    chart[0], chart[1], chart[2] = first, second, best
    chart[3] = 1 if p[best] >= 0.0 else -1
    return old[3] == 0 or best != old[2]


@njit(cache=True)
def place_directors(variables, chart, p):
    """Normals of all nodes from their variables; index of the first node off its chart, or -1."""
    for i in range(variables.shape[0]):
        if not normal(variables[i, 0], variables[i, 1], chart[i], p[i]):
            return i
    return -1


@njit(cache=True)
def director_rates(start, velocity, chart, p, p_dot):
    """``p_dot = A1 n_dot`` (Eq. 30a) of all nodes from the dof velocities."""
    for i in range(p.shape[0]):
        n, m, l = chart[i, 0], chart[i, 1], chart[i, 2]
        p_dot[i, n] = velocity[start[i] + 3]
        p_dot[i, m] = velocity[start[i] + 4]
        p_dot[i, l] = -(p[i, n] * p_dot[i, n] + p[i, m] * p_dot[i, m]) / p[i, l]


@njit(cache=True)
def start_charts(start, fixed_component, p, p_dot, variables, chart, velocity):
    """Charts, variables and their rates (in ``velocity``) from normals and normal velocities."""
    for i in range(p.shape[0]):
        choose_chart(p[i], p[i], np.zeros(4, np.int64), fixed_component[i], chart[i])
        n, m = chart[i, 0], chart[i, 1]
        variables[i, 0], variables[i, 1] = p[i, n], p[i, m]
        velocity[start[i] + 3], velocity[start[i] + 4] = p_dot[i, n], p_dot[i, m]


@njit(cache=True)
def advance_nodes(numbering, motion, step, delta, scratch):
    """Nodal quantities of an iterate: increments, normals at its end and at the midpoint, A1, and
    the accelerations ``(d2x, A1 n_ddot + A2)`` that enter M U_ddot + F_m (Eqs. 37, 40, 58)."""
    start = numbering[0]
    _, _, variables, chart, velocity, acceleration = motion
    alpha_f, _, c_delta, c_velocity, c_acceleration, v_delta, v_velocity, v_acceleration = step
    dx, p_end, p_mid, A1, inertial_x, inertial_p, _, _, _, _ = scratch
    weight = 1.0 - alpha_f
    for i in range(start.shape[0]):
        first = start[i]
        for c in range(3):
            k = first + c
            dx[i, c] = delta[k]
            inertial_x[i, c] = (c_delta * delta[k] - c_velocity * velocity[k]
                                - c_acceleration * acceleration[k])
        k = first + 3
        dn, dm = delta[k], delta[k + 1]
        n, m = variables[i, 0], variables[i, 1]
        if not normal(n + dn, m + dm, chart[i], p_end[i]):
            return CHART_LEFT
        if not normal(n + weight * dn, m + weight * dm, chart[i], p_mid[i]):
            return CHART_LEFT
        first_derivatives(p_mid[i], chart[i], A1[i])
        n_dot = v_delta * dn - v_velocity * velocity[k] - v_acceleration * acceleration[k]
        m_dot = v_delta * dm - v_velocity * velocity[k + 1] - v_acceleration * acceleration[k + 1]
        n_ddot = c_delta * dn - c_velocity * velocity[k] - c_acceleration * acceleration[k]
        m_ddot = (c_delta * dm - c_velocity * velocity[k + 1]
                  - c_acceleration * acceleration[k + 1])
        for c in range(3):
            inertial_p[i, c] = A1[i, c, 0] * n_ddot + A1[i, c, 1] * m_ddot
        inertial_p[i, chart[i, 2]] += convective(p_mid[i], chart[i], n_dot, m_dot)
    return 0


@njit(cache=True)
def switch_charts(start, fixed_component, variables, chart, velocity, acceleration, p, p_old):
    """Change the variables of every node whose dependent component is no longer clearly largest.

    ``p_old`` are the normals a step before; charts are chosen for the normals half a step ahead.
    p, p_dot = A1 n_dot and p_ddot = A1 n_ddot + A2 (Eq. 30) are carried over; returns how many
    nodes switched.
    """
    rate, second, ahead = np.empty(3), np.empty(3), np.empty(3)
    new = np.empty(4, np.int64)
    switched = 0
    for i in range(start.shape[0]):
        for c in range(3):
            ahead[c] = p[i, c] + 0.5 * (p[i, c] - p_old[i, c])
        if not choose_chart(p[i], ahead, chart[i], fixed_component[i], new):
            continue
        if abs(p[i, new[2]]) < EARLIEST:
            continue
        switched += 1
        k = start[i] + 3
        n, m, l = chart[i, 0], chart[i, 1], chart[i, 2]
        rate[n], rate[m] = velocity[k], velocity[k + 1]
        rate[l] = -(p[i, n] * rate[n] + p[i, m] * rate[m]) / p[i, l]
        second[n], second[m] = acceleration[k], acceleration[k + 1]
        second[l] = (-(p[i, n] * second[n] + p[i, m] * second[m]) / p[i, l]
                     + convective(p[i], chart[i], rate[n], rate[m]))
        chart[i] = new
        n, m = new[0], new[1]
        variables[i, 0], variables[i, 1] = p[i, n], p[i, m]
        velocity[k], velocity[k + 1] = rate[n], rate[m]
        acceleration[k], acceleration[k + 1] = second[n], second[m]
    return switched


@njit(cache=True)
def turn_normals(start, fixed_component, correction, variables, chart, p):
    """Turn every normal by the tangent vector ``A1 dn`` of a correction, along a great circle.

    For statics, where p is the whole state: large rotations stay rotations, no chart is left, and
    the variables are chosen afresh.  A supported component keeps its value.
    """
    A1, turn, new = np.zeros((3, 3)), np.empty(3), np.empty(4, np.int64)
    for i in range(p.shape[0]):
        first_derivatives(p[i], chart[i], A1)
        angle = 0.0
        for c in range(3):
            turn[c] = A1[c, 0] * correction[start[i] + 3] + A1[c, 1] * correction[start[i] + 4]
            angle += turn[c] * turn[c]
        angle = math.sqrt(angle)
        kept = fixed_component[i]
        held = p[i, kept] if kept >= 0 else 0.0
        if angle > 0.0:
            cosine, sine = math.cos(angle), math.sin(angle) / angle
            for c in range(3):
                p[i, c] = cosine * p[i, c] + sine * turn[c]
        square = 0.0
        for c in range(3):
            if c != kept:
                square += p[i, c] * p[i, c]
        scale = math.sqrt((1.0 - held * held) / square)
        for c in range(3):
            p[i, c] = held if c == kept else scale * p[i, c]
        choose_chart(p[i], p[i], chart[i], fixed_component[i], new)
        chart[i] = new
        variables[i, 0], variables[i, 1] = p[i, new[0]], p[i, new[1]]


@njit(cache=True)
def largest_turn(start, correction, chart, p):
    """Largest angle [rad] by which a correction turns a normal."""
    A1, largest = np.zeros((3, 3)), 0.0
    for i in range(p.shape[0]):
        first_derivatives(p[i], chart[i], A1)
        square = 0.0
        for c in range(3):
            turn = A1[c, 0] * correction[start[i] + 3] + A1[c, 1] * correction[start[i] + 4]
            square += turn * turn
        largest = max(largest, square)
    return math.sqrt(largest)
