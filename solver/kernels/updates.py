"""Moving a state: the end of a step, and the correction of an equilibrium."""


from . import element
from .assembly import gather_positions, gather_strains, gather_vertices, members, put_rows
from .jit import internal, kernel
from .lanes import lanes, new, pair


@kernel
def move_nodes(start, delta, x, x_low):
    """Add displacements to compensated positions: two-sum, the rounding error kept in x_low."""
    for i in range(start.shape[0]):
        for c in range(3):
            old, add = x[i, c], delta[start[i] + c] + x_low[i, c]
            new = old + add
            part = new - old
            x[i, c] = new
            x_low[i, c] = (old - (new - part)) + (add - part)


@kernel
def accept(nodes, end, delta, motion):
    """Move the state to the end of a converged step: Newmark's update, compensated positions.

    ``end`` are the ``EndFactors``.
    """
    start, n_rot = nodes.start, nodes.n_rot
    move_nodes(start, delta, motion.x, motion.x_low)
    for i in range(start.shape[0]):
        for k in range(n_rot[i]):
            motion.variables[i, k] += delta[start[i] + 3 + k]
    for k in range(delta.shape[0]):
        v, a = motion.velocity[k], motion.acceleration[k]
        motion.velocity[k] = (end.rate_delta * delta[k] + end.rate_velocity * v
                              + end.rate_acceleration * a)
        motion.acceleration[k] = (end.second_delta * delta[k] + end.second_velocity * v
                                  + end.second_acceleration * a)


@kernel
def predict_strains(elements, nodes, motion, start, correction, predicted):
    """Strain measures after a correction by linear extrapolation, ``e + B T du``, ``b + T du``.

    A tangent whose stresses are these instead of those of the moved configuration is that of a
    mixed (stress and displacement) Newton iteration: spurious membrane forces of a large rotation
    do not enter it, so it takes larger steps (Magisano, Leonetti, Garcea 2017).  The equilibrium it
    converges to is the same.
    """
    n_s = start.e.shape[1]
    (y_, y), (p_, p), (dy_, dy) = pair((3, 3)), pair((4, 3)), pair((3, 3))
    (dp_, dp), (t_, t), (b_, b), (e_, e) = pair((4, 3)), pair((3, 3)), pair((11,)), pair((n_s,))
    R, yl, r, dt = new((3, 3)), new((3, 3)), new((4, 3)), new((3, 3))
    for group in range(elements.l.shape[0]):
        first, count = members(elements, group)
        quads = elements.nodes[first:first + count]
        directors = elements.directors[first:first + count]
        gather_positions(motion.x, motion.x_low, quads, y_)
        gather_vertices(start.p, directors, p_)
        gather_strains(start.t, start.b, start.e, first, count, t_, b_, e_)
        _gather_correction(nodes, start.A1, quads, directors, correction, dy_, dp_)
        diagonals = element.frame(y, R)
        element.rotated_positions(R, y, p, yl, r)
        if elements.coupling.shape[0] > 0:
            element.couple_measures(lanes(elements.coupling[group]), b, -1.0, e)
        _change_variables(R, yl, r, diagonals, dy, dp, dt, b)
        if elements.coupling.shape[0] > 0:
            element.couple_measures(lanes(elements.coupling[group]), b, 1.0, e)
        _change_measures(lanes(elements.l[group]), lanes(elements.Q[group]), t, dt, e)
        put_rows(b_, first, count, predicted.b)
        put_rows(e_, first, count, predicted.e)


@internal
def _gather_correction(nodes, A1, quads, directors, correction, dy_, dp_):
    """Changes of the relative positions and, ``A1 dn``, of the normals of a group."""
    start, n_rot = nodes.start, nodes.n_rot
    for v in range(quads.shape[0]):
        for k in range(3):
            for c in range(3):
                dy_[k, c, v] = (correction[start[quads[v, k + 1]] + c]
                                - correction[start[quads[v, 0]] + c])
        for i in range(4):
            rates = start[quads[v, i]] + 3
            for c in range(3):
                dp_[i, c, v] = 0.0
                for k in range(n_rot[quads[v, i]]):
                    dp_[i, c, v] += A1[directors[v, i], c, k] * correction[rates + k]


@internal
def _change_variables(R, yl, r, diagonals, d, dp, dt, b):
    """``T du``, Eq. (45): ``dt = R dy + yl x phi``, and the same for the normals; added to b."""
    dy = dt
    for k in range(3):
        d_x, d_y, d_z = d[k, 0], d[k, 1], d[k, 2]
        for c in range(3):
            dy[k, c] = R[c, 0] * d_x + R[c, 1] * d_y + R[c, 2] * d_z
    phi = element.frame_rotation(diagonals, dy)
    for k in range(3):
        dy_x, dy_y, dy_z = dy[k, 0], dy[k, 1], dy[k, 2]
        dt[k, 0] = dy_x + yl[k, 1] * phi[2] - yl[k, 2] * phi[1]
        dt[k, 1] = dy_y + yl[k, 2] * phi[0] - yl[k, 0] * phi[2]
        dt[k, 2] = dy_z + yl[k, 0] * phi[1] - yl[k, 1] * phi[0]
        b[k] += dt[k, 2]
    for i in range(4):
        b[3 + 2 * i] += (R[0, 0] * dp[i, 0] + R[0, 1] * dp[i, 1] + R[0, 2] * dp[i, 2]
                         + (r[i, 1] * phi[2] - r[i, 2] * phi[1]))
        b[4 + 2 * i] += (R[1, 0] * dp[i, 0] + R[1, 1] * dp[i, 1] + R[1, 2] * dp[i, 2]
                         + (r[i, 2] * phi[0] - r[i, 0] * phi[2]))


@internal
def _change_measures(l, Q, t, dt, e):
    """``e_s += B_s dt``, Eq. (16)"""
    for s in range(e.shape[0]):
        for k in range(3):
            slope = l[s, k, 2]
            for j in range(3):
                slope += Q[s, k, j] * t[j, 2]
            e[s] += l[s, k, 0] * dt[k, 0] + l[s, k, 1] * dt[k, 1] + slope * dt[k, 2]
