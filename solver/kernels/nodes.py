"""All nodes of a shell: their directors, moved, differentiated and carried over (Eqs. 24-37).

What is said of one node in ``charts`` (smooth nodes) and ``junctions`` is done here for every node.
The rest of the solver sees the directors p, their first derivatives A1 = dp/dn, and how many
variables a node has.
"""

import math
from typing import NamedTuple

import numpy as np

from .arguments import DONE
from .charts import (
    OBLIQUE,
    choose_triad,
    convective,
    first_derivatives,
    kept_component,
    normal,
    second_derivatives,
)
from .jit import inlined, internal, kernel
from .junctions import (
    carry,
    choose_junction_triad,
    frame_of,
    nodal_frame,
    set_junction,
    spin_derivative,
    spin_of,
    spins,
    swing,
)
from .vectors import copy_frame, cross, dot, orthonormal, rotate


class Frame(NamedTuple):
    """Work arrays of a junction.

    Attributes:
        e: (3, 3) nodal frame, rows e_x, e_y, e_z.
        G: (3, 3) rates of the variables for a spin.
        omega: (3, 3) spins for unit rates, in columns.
    """

    e: np.ndarray
    G: np.ndarray
    omega: np.ndarray


@kernel
def _frame():
    return Frame(np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)))


@internal
def _place_junction(nodes, i, x, triad, frame, p, A1):
    """Directors of the junction ``i`` and their derivatives ``omega_k x p``; False if off."""
    if not nodal_frame(x[0], x[1], x[2], triad, frame.e):
        return False
    spins(frame.e, triad, frame.G, frame.omega)
    for d in range(nodes.first[i], nodes.first[i + 1]):
        carry(frame.e, nodes.body[d], p[d])
        swing(frame.omega, p[d], A1[d])
    return True


@kernel
def place_directors(nodes, variables, chart, p, A1):
    """All directors and their derivatives, Eqs. (5), (11), (27), (33); first node off its
    chart."""
    frame = _frame()
    for i in range(variables.shape[0]):
        if nodes.n_rot[i] == 2:
            d = nodes.first[i]
            if not normal(variables[i, 0], variables[i, 1], chart[i], p[d]):
                return i
            first_derivatives(p[d], chart[i], A1[d])
        elif not _place_junction(nodes, i, variables[i], chart[i], frame, p, A1):
            return i
    return DONE


@kernel
def derivatives(nodes, chart, p, A1):
    """``A1`` of all directors, from the directors themselves."""
    frame = _frame()
    for i in range(chart.shape[0]):
        first = nodes.first[i]
        if nodes.n_rot[i] == 2:
            first_derivatives(p[first], chart[i], A1[first])
            continue
        frame_of(nodes.body, first, p, frame.e)
        spins(frame.e, chart[i], frame.G, frame.omega)
        for d in range(first, nodes.first[i + 1]):
            swing(frame.omega, p[d], A1[d])


@kernel
def director_rates(nodes, velocity, A1, p_dot):
    """``p_dot = A1 n_dot``, Eqs. (24), (30a), (31), of all directors from the dof velocities."""
    for i in range(nodes.start.shape[0]):
        rates = nodes.start[i] + 3
        for d in range(nodes.first[i], nodes.first[i + 1]):
            for c in range(3):
                rate = 0.0
                for k in range(nodes.n_rot[i]):
                    rate += A1[d, c, k] * velocity[rates + k]
                p_dot[d, c] = rate


@kernel
def start_charts(nodes, kept, p, p_dot, frames, variables, chart, velocity):
    """Charts (global axes), variables and their rates from normals and normal velocities at t = 0.

    ``frames`` (n_nodes, 3, 3): rows e_x, e_y, e_z of the nodal frames of junctions, whose spins
    follow from the rates of their first two directors; ``kept`` (n_nodes, 3): see
    ``charts.choose_triad``.
    """
    none, omega = np.zeros((3, 3)), np.empty(3)
    for i in range(nodes.start.shape[0]):
        k, d = nodes.start[i] + 3, nodes.first[i]
        if nodes.n_rot[i] == 2:
            choose_triad(p[d], p[d], none, kept[i], False, chart[i])
            for c in range(2):
                variables[i, c] = dot(p[d], chart[i, c])
                velocity[k + c] = dot(p_dot[d], chart[i, c])
        else:
            choose_junction_triad(frames[i], frames[i], none, kept[i], False, chart[i])
            spin_of(p[d], p[d + 1], p_dot[d], p_dot[d + 1], omega)
            set_junction(frames[i], omega, chart[i], variables[i], velocity[k:k + 3])


class Middle(NamedTuple):
    """Rotational variables of a node in one iterate, (3,) each.

    Attributes:
        x_end: at the end of the step.
        x_mid: at the generalized midpoint.
        x_dot: rates there, Eq. (57a).
        x_ddot: second rates there, Eq. (57b).
    """

    x_end: np.ndarray
    x_mid: np.ndarray
    x_dot: np.ndarray
    x_ddot: np.ndarray


@inlined
def second_rate(step, delta, velocity, acceleration, k):
    """Eq. (57b): U_ddot at the generalized midpoint, of dof k."""
    return (step.delta * delta[k] - step.velocity * velocity[k]
            - step.acceleration * acceleration[k])


@inlined
def rate_at_midpoint(step, delta, velocity, acceleration, k):
    """Eq. (57a): U_dot at the generalized midpoint, of dof k."""
    return (step.rate_delta * delta[k] - step.rate_velocity * velocity[k]
            - step.rate_acceleration * acceleration[k])


@internal
def advance_junction(nodes, i, triad, middle, work, frame):
    """Directors of a junction at the end and the midpoint, ``p_ddot = w_dot x p + w x (w x p)``:
    A1 n_ddot + A2, Eqs. (32), (34)."""
    if not _place_junction(nodes, i, middle.x_end, triad, frame, work.p_end, work.A1):
        return False
    if not _place_junction(nodes, i, middle.x_mid, triad, frame, work.p_mid, work.A1):
        return False
    spin, rate, turned, twice = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    spin_and_rate(frame, triad, middle.x_dot, middle.x_ddot, spin, rate)
    for d in range(nodes.first[i], nodes.first[i + 1]):
        cross(spin, work.p_mid[d], turned)
        cross(spin, turned, twice)
        cross(rate, work.p_mid[d], turned)
        for c in range(3):
            work.inertial_p[d, c] = turned[c] + twice[c]
    return True


@internal
def spin_and_rate(frame, triad, x_dot, x_ddot, spin, rate):
    """``w = omega x_dot`` and ``w_dot = omega x_ddot + dw/dx x_dot`` of a nodal frame."""
    for c in range(3):
        spin[c] = dot(frame.omega[c], x_dot)
    spin_derivative(frame.e, triad, frame.omega, spin, spin, rate)
    for c in range(3):
        rate[c] += dot(frame.omega[c], x_ddot)


@kernel
def advance_nodes(nodes, motion, step, delta, work):
    """Nodal quantities of an iterate: increments, directors at its end and at the midpoint, A1, and
    the accelerations ``(d2x, A1 n_ddot + A2)`` that enter M U_ddot + F_m (Eqs. 37, 40, 58).

    Returns:
        The first node whose directors are off its chart.
    """
    return advance_some(nodes, motion, step, delta, work, 0, nodes.start.shape[0])


@internal
def advance_some(nodes, motion, step, delta, work, first_node, last_node):
    """The same of the nodes from ``first_node`` to that before ``last_node``."""
    start, n_rot, first, _ = nodes
    _, _, variables, chart, velocity, acceleration = motion
    dx, p_end, p_mid, A1, inertial_x, inertial_p, _, _, _, _ = work
    x_end, x_mid, x_dot, x_ddot = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    frame, weight = _frame(), 1.0 - step.alpha_f
    for i in range(first_node, last_node):
        for c in range(3):
            k = start[i] + c
            dx[i, c] = delta[k]
            inertial_x[i, c] = second_rate(step, delta, velocity, acceleration, k)
        for c in range(n_rot[i]):
            k = start[i] + 3 + c
            x_end[c] = variables[i, c] + delta[k]
            x_mid[c] = variables[i, c] + weight * delta[k]
            x_dot[c] = rate_at_midpoint(step, delta, velocity, acceleration, k)
            x_ddot[c] = second_rate(step, delta, velocity, acceleration, k)
        if n_rot[i] == 2:
            d = first[i]
            inside = (normal(x_end[0], x_end[1], chart[i], p_end[d])
                      and normal(x_mid[0], x_mid[1], chart[i], p_mid[d]))
            if inside:
                first_derivatives(p_mid[d], chart[i], A1[d])
                bent = convective(p_mid[d], chart[i], x_dot)
                for c in range(3):
                    inertial_p[d, c] = (A1[d, c, 0] * x_ddot[0] + A1[d, c, 1] * x_ddot[1]
                                        + bent * chart[i, 2, c])
        else:
            inside = advance_junction(nodes, i, chart[i], Middle(x_end, x_mid, x_dot, x_ddot),
                                      work, frame)
        if not inside:
            return i
    return DONE


@internal
def _couple(moments, i, p, d):
    """Couple ``M_i x p_d`` as three numbers."""
    return (moments[i, 1] * p[d, 2] - moments[i, 2] * p[d, 1],
            moments[i, 2] * p[d, 0] - moments[i, 0] * p[d, 2],
            moments[i, 0] * p[d, 1] - moments[i, 1] * p[d, 0])


@internal
def moment_forces(nodes, i, chart, p, A1, moments, f):
    """Generalized forces of a moment M about fixed axes at node i: ``f_n = A1^T (M x p)`` on a
    smooth node, ``f_k = w_k . M`` with the spins w_k on a junction."""
    d = nodes.first[i]
    if nodes.n_rot[i] == 2:
        x, y, z = _couple(moments, i, p, d)
        for k in range(2):
            f[k] = A1[d, 0, k] * x + A1[d, 1, k] * y + A1[d, 2, k] * z
        return
    e, G, omega = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    frame_of(nodes.body, d, p, e)
    spins(e, chart[i], G, omega)
    for k in range(3):
        f[k] = (omega[0, k] * moments[i, 0] + omega[1, k] * moments[i, 1]
                + omega[2, k] * moments[i, 2])


@internal
def moment_skew(nodes, i, chart, p, A1, moments, H):
    """Skew part of the load stiffness of a moment M: half of ``-df_k/dn_l + df_l/dn_k``.

    On a smooth node ``f_k = M . (p x A1_k)``, so it is ``M . (A1_k x A1_l)``; on a junction
    ``(w_l,k - w_k,l) . M / 2``.
    """
    d = nodes.first[i]
    H[:] = 0.0
    if nodes.n_rot[i] == 2:
        a, b, normal_part = A1[d, :, 0].copy(), A1[d, :, 1].copy(), np.empty(3)
        cross(a, b, normal_part)
        H[0, 1] = dot(moments[i], normal_part)
        H[1, 0] = -H[0, 1]
        return
    frame, rate = _frame(), np.empty(3)
    frame_of(nodes.body, d, p, frame.e)
    spins(frame.e, chart[i], frame.G, frame.omega)
    for k in range(3):
        for l in range(3):
            spin_derivative(frame.e, chart[i], frame.omega, frame.omega[:, k].copy(),
                            frame.omega[:, l].copy(), rate)
            part = 0.5 * dot(rate, moments[i])
            H[k, l] -= part
            H[l, k] += part


@kernel
def curvature(nodes, i, p, A1, chart, forces, moments, H):
    """``H = sum f_p . d2p/dn2`` over the directors of node i (n_rot x n_rot), the last term of the
    tangent by the chain rule, less that of a moment M about fixed axes."""
    if nodes.n_rot[i] == 2:
        _curvature_smooth(nodes, i, p, chart[i], forces, moments, H)
    else:
        _curvature_junction(nodes, i, p, A1, chart[i], forces, moments, H)


@inlined
def _curvature_smooth(nodes, i, p, triad, forces, moments, H):
    """``(f_p - M x p) . d2p/dn2``: only the component along t_3 is curved, Eq. (29)."""
    d = nodes.first[i]
    x, y, z = _couple(moments, i, p, d)
    along_3 = ((forces[d, 0] - x) * triad[2, 0] + (forces[d, 1] - y) * triad[2, 1]
               + (forces[d, 2] - z) * triad[2, 2])
    nn, nm, mm = second_derivatives(p[d], triad)
    H[0, 0], H[0, 1], H[1, 0], H[1, 1] = along_3 * nn, along_3 * nm, along_3 * nm, along_3 * mm


@internal
def _curvature_junction(nodes, i, p, A1, triad, forces, moments, H):
    """With the spins w_k, ``f . p,kl = w_k,l . (p x f - M) + f . (w_k x (w_l x p))``, symmetric
    part of the M term."""
    frame = _frame()
    total, part, rate, arm = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    frame_of(nodes.body, nodes.first[i], p, frame.e)
    spins(frame.e, triad, frame.G, frame.omega)
    omega = frame.omega
    for c in range(3):
        total[c] = -moments[i, c]
    for d in range(nodes.first[i], nodes.first[i + 1]):
        cross(p[d], forces[d], part)
        for c in range(3):
            total[c] += part[c]
    for k in range(3):
        for l in range(k + 1):
            value = 0.0
            for one, two in ((k, l), (l, k)):
                spin_derivative(frame.e, triad, omega, omega[:, one], omega[:, two], rate)
                value += 0.5 * dot(rate, total)
            for d in range(nodes.first[i], nodes.first[i + 1]):
                for one, two in ((k, l), (l, k)):
                    for c in range(3):
                        arm[c] = A1[d, c, two]
                    cross(omega[:, one], arm, part)
                    value += 0.5 * dot(forces[d], part)
            H[k, l] = H[l, k] = value


@kernel
def switch_charts(nodes, kept, follow, dt, motion):
    """Renew the charts of all nodes, for their directors half a step ``dt`` ahead.

    p, p_dot = A1 n_dot and p_ddot = A1 n_ddot + A2 (Eq. 30) are carried over.  The velocity tells
    what is ahead: of an oscillation that alternates with the steps nothing is left there.

    Returns:
        How many nodes changed to other global axes.
    """
    start, n_rot, _, _ = nodes
    _, _, variables, chart, velocity, acceleration = motion
    new = np.empty((3, 3))
    A1, p, rate, second = np.empty((3, 3)), np.empty(3), np.empty(3), np.empty(3)
    ahead, frame, e_ahead = np.empty(3), _frame(), np.empty((3, 3))
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
            size = math.sqrt(dot(ahead, ahead))
            for c in range(3):
                ahead[c] /= size
            changed = choose_triad(p, ahead, chart[i], kept[i], follow, new)
            if changed:
                bent = convective(p, chart[i], x_dot)
                for c in range(3):
                    second[c] = (A1[c, 0] * x_ddot[0] + A1[c, 1] * x_ddot[1]
                                 + bent * chart[i, 2, c])
                for c in range(2):
                    variables[i, c] = dot(p, new[c])
                    x_dot[c], x_ddot[c] = dot(rate, new[c]), dot(second, new[c])
        else:
            changed = _switch_junction(chart[i], kept[i], follow, dt, variables[i], x_dot, x_ddot,
                                       new, frame, e_ahead, p, rate, second)
        if changed:
            copy_frame(new, chart[i])
            if not follow and kept_component(kept[i]) < (OBLIQUE if n_rot[i] == 2 else 0):
                switched += 1
    return switched


@internal
def _switch_junction(triad, kept, follow, dt, x, x_dot, x_ddot, new, frame, e_ahead, spin, rate,
                     change):
    """Variables of a junction in new axes, its spin and the rate of that kept."""
    nodal_frame(x[0], x[1], x[2], triad, frame.e)
    spins(frame.e, triad, frame.G, frame.omega)
    for c in range(3):
        spin[c] = dot(frame.omega[c], x_dot)
    for row in range(1, 3):
        cross(spin, frame.e[row], change)
        for c in range(3):
            e_ahead[row, c] = frame.e[row, c] + 0.5 * dt * change[c]
    orthonormal(e_ahead)
    if not choose_junction_triad(frame.e, e_ahead, triad, kept, follow, new):
        return False
    spin_and_rate(frame, triad, x_dot, x_ddot, spin, change)
    set_junction(frame.e, spin, new, x, x_dot)
    spins(frame.e, new, frame.G, frame.omega)
    spin_derivative(frame.e, new, frame.omega, spin, spin, rate)
    for c in range(3):
        change[c] -= rate[c]
    for c in range(3):
        x_ddot[c] = dot(frame.G[c], change)
    return True


@kernel
def turn_normals(nodes, kept, correction, variables, chart, p, A1):
    """Turn every director as the correction of the variables says, along a great circle.

    For statics, where the directors are the whole state: large rotations stay rotations, no chart
    is left, and the variables are chosen afresh.  A supported component keeps its value.
    """
    for i in range(nodes.start.shape[0]):
        k = nodes.start[i] + 3
        if nodes.n_rot[i] == 3:
            _turn_junction(nodes, i, kept[i], correction[k:k + 3], variables[i], chart[i], p)
        else:
            d = nodes.first[i]
            _turn_smooth(kept[i], correction[k:k + 2], variables[i], chart[i], p[d],
                         A1[d])


@internal
def _turn_junction(nodes, i, kept, correction, x, triad, p):
    """The nodal frame by the rotation vector ``omega dn``, its directors with it."""
    frame = _frame()
    turn, new, none, rates = np.empty(3), np.empty((3, 3)), np.zeros(3), np.empty(3)
    nodal_frame(x[0], x[1], x[2], triad, frame.e)
    spins(frame.e, triad, frame.G, frame.omega)
    for c in range(3):
        turn[c] = dot(frame.omega[c], correction)
    angle = math.sqrt(dot(turn, turn))
    if angle > 0.0:
        for c in range(3):
            turn[c] /= angle
        rotate(angle, turn, frame.e[1])
        rotate(angle, turn, frame.e[2])
        orthonormal(frame.e)
    choose_junction_triad(frame.e, frame.e, triad, kept, False, new)
    copy_frame(new, triad)
    set_junction(frame.e, none, new, x, rates)
    for d in range(nodes.first[i], nodes.first[i + 1]):
        carry(frame.e, nodes.body[d], p[d])


@internal
def _turn_smooth(kept, correction, x, triad, p, A1):
    """``p <- cos(a) p + sin(a)/a A1 dn`` with a = |A1 dn|; the component along an axis ``kept``
    stays, the others are scaled to a unit vector."""
    turn, new = np.empty(3), np.empty((3, 3))
    for c in range(3):
        turn[c] = A1[c, 0] * correction[0] + A1[c, 1] * correction[1]
    angle = math.sqrt(dot(turn, turn))
    held = dot(p, kept)
    if angle > 0.0:
        cosine, sine = math.cos(angle), math.sin(angle) / angle
        for c in range(3):
            p[c] = cosine * p[c] + sine * turn[c]
    changed = dot(p, kept)
    for c in range(3):
        p[c] -= changed * kept[c]
    scale = math.sqrt((1.0 - held * held) / dot(p, p))
    for c in range(3):
        p[c] = held * kept[c] + scale * p[c]
    choose_triad(p, p, triad, kept, False, new)
    copy_frame(new, triad)
    x[0], x[1] = dot(p, new[0]), dot(p, new[1])


@kernel
def largest_turn(nodes, correction, A1):
    """Largest angle [rad] by which a correction turns a director."""
    largest = 0.0
    for i in range(nodes.start.shape[0]):
        for d in range(nodes.first[i], nodes.first[i + 1]):
            square = 0.0
            for c in range(3):
                turn = 0.0
                for k in range(nodes.n_rot[i]):
                    turn += A1[d, c, k] * correction[nodes.start[i] + 3 + k]
                square += turn * turn
            largest = max(largest, square)
    return math.sqrt(largest)
