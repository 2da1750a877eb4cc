"""Angles of hinges, and moments whose work in a step is exactly moment times change of angle.

The plates a and b have the normals p_a, p_b at a hinge along e.  With ``c = p_a . p_b``,
``tau = e . (p_a x p_b)`` and ``s = tau / |e|`` the angle is ``phi = atan2(s, c)``.  Over a step

    phi_1 - phi_0 = k (c_m ds - s_m dc),   k = (phi_1 - phi_0) / (c_0 s_1 - s_0 c_1),

because ``c_m ds - s_m dc = c_0 s_1 - s_0 c_1``; ``ds = (d tau - s_m d|e|) / |e|_m`` and d tau, dc,
d|e| are linear in the increments and blind to rigid motions, as in ``discrete``.  The transpose of
this line takes a moment to forces on the nodes and normals, which do its work and have no resultant
and no moment.
"""

import math

import numpy as np

from .arguments import DONE
from .discrete import triple_remainder
from .jit import internal, kernel
from .storage import add_cell
from .tables import energy_in, pull, table_mean, taken
from .vectors import cross, dot

SMALL_TANGENT = 1e-3
"""Tangent of a change of angle below which its ratio to the sine is a series."""

K, REST, DAMPING, LEAST, MOST, STOP, LOCK, LOCK_K, LOCK_DAMPING, OF_SPRING, OF_DAMPER = range(11)
"""Columns of the constants of a hinge: of its spring, damper, stops and latch; numbers of points of
the tables of its spring and its damper, which follow: their places, values there and integrals from
zero."""

TABLES = OF_DAMPER + 1
"""First column of the tables."""

ANGLE, LOCKED, SLACK = range(3)
"""Columns of the state of a hinge: its angle [rad], whether its latch holds, and the angle at which
its spring is slack [rad]."""


@internal
def _edge(pair, motion, nodes, delta, weight, e):
    """Vector along the edge, ``weight`` of an increment on."""
    for c in range(3):
        e[c] = ((motion.x[pair[1], c] - motion.x[pair[0], c])
                + (motion.x_low[pair[1], c] - motion.x_low[pair[0], c])
                + weight * (delta[nodes.start[pair[1]] + c] - delta[nodes.start[pair[0]] + c]))


@internal
def _measures(e, p_a, p_b, n):
    """c, s and |e|."""
    cross(p_a, p_b, n)
    length = math.sqrt(dot(e, e))
    return dot(p_a, p_b), dot(e, n) / length, length


@kernel
def angles(edges, directors, motion, p, found):
    """Angles phi (n,) of hinges at a state, to be filled [rad]."""
    e, n = np.empty(3), np.empty(3)
    for k in range(edges.shape[0]):
        i, j = edges[k]
        for c in range(3):
            e[c] = ((motion.x[j, c] - motion.x[i, c]) + (motion.x_low[j, c] - motion.x_low[i, c]))
        c, s, _ = _measures(e, p[directors[k, 0]], p[directors[k, 1]], n)
        found[k] = math.atan2(s, c)


@internal
def _beyond(angle, limit, side):
    """How far an angle is beyond a limit; ``side``: 1 of an upper one, -1 of a lower one."""
    return max(side * (angle - limit), 0.0)


@internal
def _slope(stiffness, limit, side, before, after):
    """``(V_1 - V_0) / (angle_1 - angle_0)`` of a one-sided spring."""
    a, b = _beyond(after, limit, side), _beyond(before, limit, side)
    if a > 0.0 and b > 0.0:
        return 0.5 * stiffness * side * (a + b)
    if a > 0.0 or b > 0.0:
        return 0.5 * stiffness * (a * a - b * b) / (after - before)
    return 0.0


@internal
def _slope_change(stiffness, limit, side, before, after, weight):
    """Derivative of ``_slope`` by the angle at the end; ``weight``: of that end in springs."""
    a, b = _beyond(after, limit, side), _beyond(before, limit, side)
    if a > 0.0 and b > 0.0:
        return weight * stiffness
    if a > 0.0 or b > 0.0:
        change = after - before
        return stiffness * (side * a - 0.5 * (a * a - b * b) / change) / change
    return 0.0


@internal
def _side(own):
    """Of which kind of limit the latch is."""
    return 1.0 if own[LOCK] > 0.0 else -1.0


@kernel
def energy(constants, states):
    """Energy of springs, stops and latches [J], of hinges with ``constants`` (n, 11 or more) and
    ``states`` (n, 3)."""
    total = 0.0
    for k in range(constants.shape[0]):
        own, angle = constants[k], states[k, ANGLE]
        pressed = _beyond(angle, own[LOCK], _side(own))
        if states[k, LOCKED] > 0.0:
            pressed = angle - own[LOCK]
        total += 0.5 * (own[K] * (angle - states[k, SLACK])**2 + own[LOCK_K] * pressed**2
                        + own[STOP] * (_beyond(angle, own[LEAST], -1.0)**2
                                       + _beyond(angle, own[MOST], 1.0)**2))
        total += energy_in(own, TABLES, angle - states[k, SLACK])
    return total


@internal
def _moment(own, state, before, after, slack, weight, rate):
    """Moment of springs, dampers, stops and latch that turns a hinge on, from the angle ``before``
    to ``after``, and about how much less it is by a radian more."""
    damping, change = own[DAMPING], after - before
    if weight == 1.0:
        before = after
    angle = before + weight * (after - before)
    moment = -own[K] * (angle - (state[SLACK] + weight * (slack - state[SLACK])))
    moment -= _slope(own[STOP], own[LEAST], -1.0, before, after)
    moment -= _slope(own[STOP], own[MOST], 1.0, before, after)
    start = after - slack if weight == 1.0 else before - state[SLACK]
    back, less = pull(own, TABLES, start, after - slack, weight, change, rate)
    moment -= back
    stiffness = weight * own[K] + less
    stiffness += _slope_change(own[STOP], own[LEAST], -1.0, before, after, weight)
    stiffness += _slope_change(own[STOP], own[MOST], 1.0, before, after, weight)
    if state[LOCKED] > 0.0:
        moment -= own[LOCK_K] * (angle - own[LOCK])
        damping += own[LOCK_DAMPING]
        stiffness += weight * own[LOCK_K]
    else:
        moment -= _slope(own[LOCK_K], own[LOCK], _side(own), before, after)
        stiffness += _slope_change(own[LOCK_K], own[LOCK], _side(own), before, after, weight)
    return moment - damping * rate * change, stiffness + damping * rate


@internal
def _on_ends(moment, before, after, e, de, p, dp, n, a, b, on_v, on_y):
    """Forces of a moment on the edge and p_a, ``on_v`` (2, 3), and on p_b, ``on_y``, see the
    module; ``before`` and ``after``: c, s and |e|.  e, de: mean of the edge and its increment; p,
    dp (2, 3): those of the normals."""
    sine = before[0] * after[1] - before[1] * after[0]
    cosine = before[0] * after[0] + before[1] * after[1]
    if abs(sine) < SMALL_TANGENT * cosine:
        tangent = sine / cosine
        ratio = (1.0 - tangent**2 / 3.0 + tangent**4 / 5.0) / cosine
    else:
        ratio = math.atan2(sine, cosine) / sine
    length = 0.5 * (before[2] + after[2])
    on_c = -0.5 * ratio * moment * (before[1] + after[1])
    on_tau = 0.5 * ratio * moment * (before[0] + after[0]) / length
    on_length = -0.5 * (before[1] + after[1]) * on_tau / length
    v, dv = np.empty((2, 3)), np.empty((2, 3))
    cross(p[0], p[1], n)
    cross(p[1], e, a[0])
    cross(e, p[0], a[1])
    for c in range(3):
        v[0, c], v[1, c], dv[0, c], dv[1, c] = e[c], p[0, c], de[c], dp[0, c]
        on_v[0, c] = on_tau * n[c] + on_length * e[c]
        on_v[1, c] = on_tau * a[0, c] + on_c * p[1, c]
        on_y[c] = on_tau * a[1, c] + on_c * p[0, c]
    triple_remainder(v, dv, p[1], dp[1], 0.25 * on_tau, a, b, n, on_v, on_y)


@kernel
def add_hinge_forces(nodes, edges, directors, owners, constants, states, moments, slacks, motion,
                     delta, step, p_0, p_1, A1, forces, on_rotations):
    """Add the forces of hinges at an iterate to ``forces`` (n_dof,).

    Args:
        nodes: ``Nodes``.
        edges: (n, 2) nodes at both ends of the edge around each place of a hinge.
        directors: (n, 2) normals of the plates there; owners: (n, 2) their nodes.
        constants: (n, 11 or more) see ``K`` and the others.
        states: (n, 3) at the start of the step.
        moments: (n,) of motors [N m].
        slacks: (n,) angles at which springs are slack at the end [rad].
        motion: ``Motion`` at the start of the step.
        delta: (n_dof,) increment.
        step: ``Factors``.
        p_0, p_1: (n_directors, 3) normals at both ends.
        A1: (n_directors, 3, 3) their derivatives at the generalized midpoint.
        forces: (n_dof,) added to.
        on_rotations: (n, 6) to be filled: what an angle changes by per unit of the rotational
            variables of both nodes, two of either, the stiffness, and the moment.

    Returns:
        The first node whose plates fold by a right angle or more in the step.
    """
    e_0, e, de, n = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    p, dp, a, b = np.empty((2, 3)), np.empty((2, 3)), np.empty((3, 3)), np.empty((3, 3))
    on_v, on_y = np.empty((2, 3)), np.empty(3)
    weight = 1.0 - step.alpha_f
    for k in range(edges.shape[0]):
        _edge(edges[k], motion, nodes, delta, 0.0, e_0)
        _edge(edges[k], motion, nodes, delta, 1.0, e)
        before = _measures(e_0, p_0[directors[k, 0]], p_0[directors[k, 1]], n)
        after = _measures(e, p_1[directors[k, 0]], p_1[directors[k, 1]], n)
        cosine = before[0] * after[0] + before[1] * after[1]
        if not cosine > 0.0:
            return owners[k, 0]
        change = math.atan2(before[0] * after[1] - before[1] * after[0], cosine)
        angle = states[k, ANGLE]
        held = weight == 1.0
        if held:
            before = after
        moment, stiffness = _moment(constants[k], states[k], angle, angle + change, slacks[k],
                                    weight, step.per_step)
        for c in range(3):
            de[c] = 0.0 if held else e[c] - e_0[c]
            e[c] -= 0.5 * de[c]
            for side in range(2):
                d = directors[k, side]
                dp[side, c] = 0.0 if held else p_1[d, c] - p_0[d, c]
                p[side, c] = p_1[d, c] - 0.5 * dp[side, c]
        _on_ends(1.0, before, after, e, de, p, dp, n, a, b, on_v, on_y)
        moment += moments[k]
        for c in range(3):
            forces[nodes.start[edges[k, 0]] + c] -= moment * on_v[0, c]
            forces[nodes.start[edges[k, 1]] + c] += moment * on_v[0, c]
        for side in range(2):
            d, at = directors[k, side], nodes.start[owners[k, side]] + 3
            on = on_v[1] if side == 0 else on_y
            for r in range(2):
                found = A1[d, 0, r] * on[0] + A1[d, 1, r] * on[1] + A1[d, 2, r] * on[2]
                on_rotations[k, 2 * side + r] = found
                forces[at + r] += moment * found
        on_rotations[k, 4], on_rotations[k, 5] = stiffness, moment
    return DONE


@kernel
def add_hinge_stiffness(dofs, storage, owners, on_rotations, values, skew):
    """Add ``stiffness g g^T``, g the gradient of the angle in the rotational variables."""
    k_h = np.zeros((2, 5, 2, 5))
    for k in range(owners.shape[0]):
        g, stiffness = on_rotations[k], on_rotations[k, 4]
        for i in range(2):
            for r in range(2):
                for j in range(2):
                    for c in range(2):
                        k_h[i, 3 + r, j, 3 + c] = stiffness * g[2 * i + r] * g[2 * j + c]
        add_cell(dofs, storage, owners[k], (5, 5), k, k_h, values, skew)


@kernel
def moments(constants, states, slacks, after, weight, rate, found):
    """Moments that turn joints on in a step to the angles ``after`` (n,), and their stiffness, into
    ``found`` (n, 2); see ``add_hinge_forces``."""
    for k in range(constants.shape[0]):
        found[k, 0], found[k, 1] = _moment(constants[k], states[k], states[k, ANGLE], after[k],
                                           slacks[k], weight, rate)


@kernel
def done(constants, before, after, dt, found):
    """Moments of springs in a step of length dt between the states ``before`` and ``after`` (n, 3),
    and what dampers took, into ``found`` (n, 2) [N m], [J]."""
    for k in range(constants.shape[0]):
        own, change = constants[k], after[k, ANGLE] - before[k, ANGLE]
        start, end = before[k, ANGLE] - before[k, SLACK], after[k, ANGLE] - after[k, SLACK]
        damping = own[DAMPING] + (own[LOCK_DAMPING] if before[k, LOCKED] > 0.0 else 0.0)
        found[k, 0] = 0.5 * own[K] * (start + end)
        n = int(own[OF_SPRING])
        if n > 0:
            found[k, 0] += table_mean(own, TABLES, n, start, end, 0.5)[0]
        found[k, 1] = taken(own, TABLES, damping, change, dt)
