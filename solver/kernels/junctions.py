"""Charts of junctions: the rotational variables of nodes where plates meet (Eqs. 11, 12, 32-36).

A junction has three variables, ``n = e_y . t_1``, ``m = e_y . t_2``, ``k = e_z . t_1`` of a nodal
frame (e_x, e_y, e_z) that carries all directors of the node along,
``p = e_x a_x + e_y a_y + e_z a_z``.  Derivatives go by its spins: a director that turns with the
spin w has the rate ``w x p``.
"""

import math

import numpy as np

from .charts import (
    CHART_LIMIT,
    EARLIEST,
    SWITCH_RATIO,
    choose_triad,
    empty,
    kept_component,
)
from .jit import internal, kernel
from .vectors import copy, cross, dot, largest


@kernel
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
    cross(e[1], e[2], e[0])
    return True


@kernel
def spins(e, triad, G, omega):
    """Spins ``omega[:, i]`` of a nodal frame for unit rates of its variables, ``G omega = 1``.

    From ``n = e_y . t_1`` and so on, ``dn = d(phi) . (e_y x t_1)``: the rows of G are
    ``e_y x t_1, e_y x t_2, e_z x t_1``.
    """
    cross(e[1], triad[0], G[0])
    cross(e[1], triad[1], G[1])
    cross(e[2], triad[0], G[2])
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        for c in range(3):
            d, f = (c + 1) % 3, (c + 2) % 3
            omega[c, i] = G[j, d] * G[k, f] - G[j, f] * G[k, d]
    determinant = G[0, 0] * omega[0, 0] + G[0, 1] * omega[1, 0] + G[0, 2] * omega[2, 0]
    for i in range(3):
        for c in range(3):
            omega[c, i] /= determinant


@internal
def spin_derivative(e, triad, omega, a, b, result):
    """Rate of the spin ``a`` while the frame turns with the spin ``b``, both (3,).

    ``a = omega x`` with fixed x; from ``d(G omega) = 0``: ``G da = -(a . ((b x e_y) x t_1), ...)``.
    """
    turned, arm, right = np.empty(3), np.empty(3), np.empty(3)
    for row in range(3):
        cross(b, e[1 if row < 2 else 2], turned)
        cross(turned, triad[1 if row == 1 else 0], arm)
        right[row] = -dot(a, arm)
    for c in range(3):
        result[c] = omega[c, 0] * right[0] + omega[c, 1] * right[1] + omega[c, 2] * right[2]


@kernel
def carry(e, body, p):
    """Director of a junction from the nodal frame, Eq. (11)."""
    for c in range(3):
        p[c] = e[0, c] * body[0] + e[1, c] * body[1] + e[2, c] * body[2]


@kernel
def swing(omega, p, A1):
    """Derivatives of a director that turns with the spins: columns ``w_k x p``."""
    for k in range(3):
        A1[0, k] = omega[1, k] * p[2] - omega[2, k] * p[1]
        A1[1, k] = omega[2, k] * p[0] - omega[0, k] * p[2]
        A1[2, k] = omega[0, k] * p[1] - omega[1, k] * p[0]


@internal
def frame_of(body, d, p, e):
    """Nodal frame of a junction from its first two directors ``p[d], p[d + 1]``."""
    a, b = np.empty((3, 3)), np.empty((3, 3))
    for first, second, target in ((body[d], body[d + 1], a), (p[d], p[d + 1], b)):
        copy(first, target[0])
        cross(first, second, target[2])
        size = math.sqrt(dot(target[2], target[2]))
        for c in range(3):
            target[2, c] /= size
        cross(target[2], target[0], target[1])
    for row in range(3):
        for c in range(3):
            e[row, c] = b[0, c] * a[0, row] + b[1, c] * a[1, row] + b[2, c] * a[2, row]


@kernel
def spin_of(a, b, a_dot, b_dot, omega):
    """Spin of a rigid pair of unit vectors: ``omega = a x a_dot + c a``, c from ``omega x b``."""
    side, rest = np.empty(3), np.empty(3)
    cross(a, a_dot, omega)
    cross(omega, b, rest)
    cross(a, b, side)
    for c in range(3):
        rest[c] = b_dot[c] - rest[c]
    share = dot(rest, side) / dot(side, side)
    for c in range(3):
        omega[c] += share * a[c]


@internal
def set_junction(e, omega, triad, x, rates):
    """Variables of a nodal frame in a triad, and their rates for the spin ``omega``."""
    turn_y, turn_z = np.empty(3), np.empty(3)
    cross(omega, e[1], turn_y)
    cross(omega, e[2], turn_z)
    x[0], x[1], x[2] = dot(e[1], triad[0]), dot(e[1], triad[1]), dot(e[2], triad[0])
    rates[0], rates[1] = dot(turn_y, triad[0]), dot(turn_y, triad[1])
    rates[2] = dot(turn_z, triad[0])


@kernel
def choose_junction_triad(e, ahead, old, kept, follow, triad):
    """As ``charts.choose_triad``, for a junction with nodal frame ``e`` that moves to
    ``ahead`` (rows e_x, e_y, e_z).

    Following axes are (e_x, e_z, e_y) ahead; a junction that turns about an axis ``kept`` only has
    no others, so that n and k are constant, e_x being that axis.  Global axes: t_3 by e_y as above,
    and t_1 of the two others the one with the smaller component of e_z (ahead, with hysteresis);
    t_2 is signed so that e_z points along it.
    """
    held = kept_component(kept) >= 0
    if held or (follow and not empty(old)):
        suits = dot(e[1], ahead[1]) > EARLIEST and dot(e[2], ahead[2]) > EARLIEST
        if not suits:
            ahead = e
        if suits or held:
            copy(ahead[0], triad[0])
            copy(ahead[2], triad[1])
            copy(ahead[1], triad[2])
            return True
    choose_triad(e[1], ahead[1], old, np.zeros(3), False, triad)
    same = True
    for c in range(3):
        same = same and triad[2, c] == old[2, c]
    one, two = largest(triad[0]), largest(triad[1])
    ratio = SWITCH_RATIO if same else 1.0
    if abs(ahead[2, one]) > ratio * abs(ahead[2, two]):
        one, two = two, one
        same = False
    if same:
        return False
    for c in range(3):
        triad[0, c] = triad[1, c] = 0.0
    triad[0, one] = triad[1, two] = 1.0
    if dot(e[2], triad[1]) * dot(e[1], triad[2]) < dot(e[2], triad[2]) * dot(e[1], triad[1]):
        triad[1, two] = -1.0
    return True
