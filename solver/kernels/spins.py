"""Nodes that turn by Cayley vectors: the coordinates of the exact scheme.

Every node has a frame, rows t_1, t_2, t_3 of its chart, and its directors are constant in it,
``p_d = sum body_dk t_k``.  In a step it turns by ``C = Cay(th)``,

    C a = a + (th x a + th x (th x a) / 2) / (1 + |th|^2 / 4),

so that ``C a - a = th x a_m`` for every vector a of the node, a_m its mean: lengths and angles are
kept.  The unknowns are the components of th along b_k: t_2 and -t_1 of a smooth node, whose t_3 is
its normal (so that dp = t_1, t_2), and t_1, t_2, t_3 of a junction.  Its spin w has the same
components, ``w_1 = 2 th/dt - C w_0``; as C leaves th alone and turns the frame, those of w_1 are 2
th_k/dt less those of w_0, as of a velocity.
"""

import numpy as np

from .arguments import DONE
from .jit import inlined, internal, kernel
from .updates import move_nodes
from .vectors import adjugate, cross, dot, orthonormal

LARGEST_TURN = 3.0
"""Cayley vector of a step beyond which it is not sound."""


@internal
def basis(frame, n_rot, k, b):
    """``b_k`` (3,), see the module."""
    for c in range(3):
        if n_rot == 3:
            b[c] = frame[k, c]
        elif k == 0:
            b[c] = frame[1, c]
        else:
            b[c] = -frame[0, c]


@internal
def turned(th, a, C_a):
    """``C a``, see the module."""
    x = th[1] * a[2] - th[2] * a[1]
    y = th[2] * a[0] - th[0] * a[2]
    z = th[0] * a[1] - th[1] * a[0]
    part = 1.0 / (1.0 + 0.25 * dot(th, th))
    C_a[0] = a[0] + part * (x + 0.5 * (th[1] * z - th[2] * y))
    C_a[1] = a[1] + part * (y + 0.5 * (th[2] * x - th[0] * z))
    C_a[2] = a[2] + part * (z + 0.5 * (th[0] * y - th[1] * x))


@inlined
def vector(frames, i, n_rot, components, first, v):
    """``v = sum components[first + k] b_k`` of node i."""
    one, two = components[first], components[first + 1]
    for c in range(3):
        if n_rot == 2:
            v[c] = one * frames[i, 1, c] - two * frames[i, 0, c]
        else:
            v[c] = (one * frames[i, 0, c] + two * frames[i, 1, c]
                    + components[first + 2] * frames[i, 2, c])


@inlined
def turn_frame(frames, i, th, ends, j):
    """``ends[j] = C frames[i]``, row by row; slices of them would take longer."""
    part = 1.0 / (1.0 + 0.25 * dot(th, th))
    for row in range(3):
        a, b, c = frames[i, row, 0], frames[i, row, 1], frames[i, row, 2]
        x, y, z = th[1] * c - th[2] * b, th[2] * a - th[0] * c, th[0] * b - th[1] * a
        ends[j, row, 0] = a + part * (x + 0.5 * (th[1] * z - th[2] * y))
        ends[j, row, 1] = b + part * (y + 0.5 * (th[2] * x - th[0] * z))
        ends[j, row, 2] = c + part * (z + 0.5 * (th[0] * y - th[1] * x))


@inlined
def swing(frames, i, n_rot, p, A1, d):
    """Derivatives ``b_k x p`` of a director of node i, into ``A1[d]``."""
    for k in range(n_rot):
        row, sign = (k, 1.0) if n_rot == 3 else ((1, 1.0) if k == 0 else (0, -1.0))
        a, b, c = frames[i, row, 0], frames[i, row, 1], frames[i, row, 2]
        A1[d, 0, k] = sign * (b * p[2] - c * p[1])
        A1[d, 1, k] = sign * (c * p[0] - a * p[2])
        A1[d, 2, k] = sign * (a * p[1] - b * p[0])


@inlined
def director(frames, i, body, d, p):
    """``p = sum body_dk t_k`` of node i."""
    for c in range(3):
        p[c] = (body[d, 0] * frames[i, 0, c] + body[d, 1] * frames[i, 1, c]
                + body[d, 2] * frames[i, 2, c])


@kernel
def place(nodes, frames, p, A1):
    """Directors of all nodes, and their derivatives ``b_k x p``."""
    own = np.empty(3)
    for i in range(frames.shape[0]):
        for d in range(nodes.first[i], nodes.first[i + 1]):
            director(frames, i, nodes.body, d, own)
            swing(frames, i, nodes.n_rot[i], own, A1, d)
            for c in range(3):
                p[d, c] = own[c]


@kernel
def advance(nodes, inertia, motion, start, step, delta, work):
    """Nodal quantities of an iterate, into ``work``: directors at the end, and their means,
    derivatives ``b_k x p_m``, frames at the end, accelerations, rates of the momenta of the spins.

    Args:
        nodes: ``Nodes``.
        inertia: (n_directors,) of the normals [kg m^2].
        motion: ``Motion`` at the start of the step; its charts are the frames.
        start: ``Start``.
        step: ``Factors``.
        delta: (n_dof,) increment.
        work: ``SpinWork``.

    Returns:
        The first node that turns by more than ``LARGEST_TURN``.
    """
    first_dof, n_rot, first, body = nodes
    frames, velocity = motion.chart, motion.velocity
    p_start, p_end, p_mid, A1, rate = start.p, work.p_end, work.p_mid, work.A1, work.spin_rate
    ends = work.frames
    th, w_0, w_1, p_0, p_1 = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for i in range(first_dof.shape[0]):
        at = first_dof[i]
        for c in range(3):
            work.dx[i, c] = delta[at + c]
            work.inertial_x[i, c] = step.delta * delta[at + c] - step.velocity * velocity[at + c]
            rate[i, c] = 0.0
        vector(frames, i, n_rot[i], delta, at + 3, th)
        vector(frames, i, n_rot[i], velocity, at + 3, w_0)
        if not dot(th, th) <= LARGEST_TURN**2:
            return i
        turned(th, w_0, w_1)
        turn_frame(frames, i, th, ends, i)
        for c in range(3):
            w_1[c] = step.velocity * th[c] - w_1[c]
        for d in range(first[i], first[i + 1]):
            director(ends, i, body, d, p_1)
            for c in range(3):
                p_0[c] = p_start[d, c]
                p_end[d, c] = p_1[c]
            along_0, along_1, factor = dot(p_0, w_0), dot(p_1, w_1), step.rate_delta * inertia[d]
            for c in range(3):
                rate[i, c] += factor * ((w_1[c] - along_1 * p_1[c]) - (w_0[c] - along_0 * p_0[c]))
                p_0[c] = p_mid[d, c] = 0.5 * (p_0[c] + p_1[c])
            swing(frames, i, n_rot[i], p_0, A1, d)
    return DONE


@internal
def moment_across(nodes, i, p, moments, m):
    """A moment at node i less what lies along the normal of a smooth node, (3,)."""
    d, share = nodes.first[i], 0.0
    if nodes.n_rot[i] == 2:
        share = dot(moments[i], p[d]) / dot(p[d], p[d])
    for c in range(3):
        m[c] = moments[i, c] - share * p[d, c]


@internal
def nodal_matrix(nodes, i, inertia, frame, work, step, k_n):
    """What node i adds to the matrix of a step, ``k_n`` (n_rot, n_rot): of the symmetric part of
    the derivative of ``b_k . (p x f)``, ``(b_k . f)(b_l . p) - (b_k . b_l)(p . f)``, and of ``b_k .
    J b_l`` with ``J = sum I_d (1 - p p^T)``, over its directors."""
    n, b_k, b_l, p, forces = nodes.n_rot[i], np.empty(3), np.empty(3), work.p_mid, work.force_p
    for k in range(n):
        basis(frame, n, k, b_k)
        for l in range(k + 1):
            basis(frame, n, l, b_l)
            bent, heavy = 0.0, 0.0
            for d in range(nodes.first[i], nodes.first[i + 1]):
                p_k, p_l = dot(b_k, p[d]), dot(b_l, p[d])
                bent += 0.5 * (dot(b_k, forces[d]) * p_l + dot(b_l, forces[d]) * p_k)
                heavy -= inertia[d] * p_k * p_l
                if k == l:
                    bent -= dot(p[d], forces[d])
                    heavy += inertia[d]
            k_n[k, l] = k_n[l, k] = step.stiffness * bent + step.delta * heavy


@kernel
def accept(nodes, end, delta, motion):
    """Move a state to the end of a converged step, whose mean rates are left in its accelerations.

    ``end`` are the ``EndFactors``.  Frames are made orthonormal to the last bit.
    """
    move_nodes(nodes.start, delta, motion.x, motion.x_low)
    th, new, frame = np.empty(3), np.empty((1, 3, 3)), np.empty((3, 3))
    for i in range(nodes.start.shape[0]):
        vector(motion.chart, i, nodes.n_rot[i], delta, nodes.start[i] + 3, th)
        turn_frame(motion.chart, i, th, new, 0)
        for row in range(3):
            for c in range(3):
                frame[(row + 2) % 3, c] = new[0, row, c]  # t_3 comes second: it keeps its direction
        orthonormal(frame)
        for row in range(3):
            for c in range(3):
                motion.chart[i, row, c] = frame[(row + 2) % 3, c]
    for k in range(delta.shape[0]):
        motion.velocity[k] = end.rate_delta * delta[k] + end.rate_velocity * motion.velocity[k]
        motion.acceleration[k] = 0.5 * end.rate_delta * delta[k]


@internal
def _rigid(mass, motion, momentum, angular, centre, v, w):
    """Mass centre of a free shell, velocity and spin of the rigid motion with its momenta (about
    the origin), with lumped masses; False of one without inertia about an axis."""
    inertia, inverse, arm = np.zeros((3, 3)), np.empty((3, 3)), np.empty(3)
    total = 0.0
    centre[:] = 0.0
    for i in range(mass.shape[0]):
        total += mass[i]
        for c in range(3):
            centre[c] += mass[i] * motion.x[i, c]
    for c in range(3):
        centre[c] /= total
        v[c] = momentum[c] / total
    for i in range(mass.shape[0]):
        for c in range(3):
            arm[c] = motion.x[i, c] - centre[c]
        square = dot(arm, arm)
        for r in range(3):
            inertia[r, r] += mass[i] * square
            for c in range(3):
                inertia[r, c] -= mass[i] * arm[r] * arm[c]
    cross(centre, momentum, arm)
    for a in range(3):
        arm[a] = angular[a] - arm[a]
    determinant = adjugate(inertia, inverse)
    for a in range(3):
        w[a] = dot(inverse[a], arm) / determinant
    return determinant > 0.0


@kernel
def predict(nodes, mass, motion, start, dt, free, again, momentum, angular, delta):
    """Where Newton's iteration of a step starts: its increment, into ``delta``.

    Of a ``free`` shell a rigid motion with its momenta, or, ``again``, the increment of the last
    step once more, turned along; of one that is held none, or that increment.

    Args:
        nodes: ``Nodes``.
        mass: (n_nodes,) lumped [kg].
        motion: ``Motion``; in its accelerations the mean rates of the last step.
        start: ``Start``.
        dt: length of the step [s].
        free: whether nothing holds the shell.
        again: see above.
        momentum: (3,) [kg m/s]; angular: (3,) about the origin [kg m^2/s].
        delta: (n_dof,) to be filled.
    """
    centre, v, w, th, arm = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3), np.empty(3)
    part, goal, b = np.empty(3), np.empty(3), np.empty(3)
    rates = motion.acceleration
    if free and not _rigid(mass, motion, momentum, angular, centre, v, w):
        w[:] = 0.0
    for c in range(3):
        w[c] *= dt
    size = np.sqrt(dot(w, w))
    if size > 0.5 * LARGEST_TURN:
        for c in range(3):
            w[c] *= 0.5 * LARGEST_TURN / size
    for i in range(nodes.start.shape[0]):
        at, d = nodes.start[i], nodes.first[i]
        if again:
            for c in range(3):
                arm[c] = rates[at + c] - v[c]
            turned(w, arm, part)
            for c in range(3):
                delta[at + c] = dt * (v[c] + part[c])
            for k in range(nodes.n_rot[i]):
                delta[at + 3 + k] = dt * rates[at + 3 + k]
            continue
        for c in range(3):
            arm[c] = motion.x[i, c] - centre[c]
            th[c] = w[c]
        turned(w, arm, part)
        for c in range(3):
            delta[at + c] = dt * v[c] + (part[c] - arm[c])
        if nodes.n_rot[i] == 2:
            turned(w, start.p[d], goal)
            cross(start.p[d], goal, th)
            for c in range(3):
                th[c] *= 2.0 / (1.0 + dot(start.p[d], goal))
        for k in range(nodes.n_rot[i]):
            basis(motion.chart[i], nodes.n_rot[i], k, b)
            delta[at + 3 + k] = dot(b, th)


@kernel
def largest_turn(nodes, delta):
    """Largest turn of a node [rad], of a small increment (n_dof,)."""
    largest = 0.0
    for i in range(nodes.start.shape[0]):
        size = 0.0
        for k in range(nodes.n_rot[i]):
            size += delta[nodes.start[i] + 3 + k]**2
        largest = max(largest, size)
    return np.sqrt(largest)
