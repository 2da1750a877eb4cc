"""Assembly over all elements: the system of one iteration, and the state at one instant.

Dofs are numbered node by node in an order that keeps the band narrow: 3 displacements, then the
rotational variables of the node.  The tangent goes straight into the storage of the linear solver:
the entry (row, k-th dof of a column node) of element e, vertex pair (a, b), row not before column,
stands at ``base[row] + offset[e, a, b] + stride * k``.
"""

import numpy as np
from numba import njit, uint64

from . import charts as rotation
from . import element
from .charts import CHART_LEFT
from .lanes import WIDTH, lanes, new, pair


@njit(cache=True)
def _members(elements, group):
    """First element of a group and how many elements it has; the last group may have fewer."""
    first = WIDTH * group
    return first, min(WIDTH, elements.nodes.shape[0] - first)


@njit(cache=True)
def _gather(x, x_low, nodes, y):
    """Positions of vertices 2..4 relative to vertex 1 from compensated nodal positions.

    ``nodes`` (count, 4) are those of the elements of a group, ``y`` is (3, 3, WIDTH); a lane
    without an element repeats the last one, here and below.
    """
    for v in range(WIDTH):
        el = min(v, nodes.shape[0] - 1)
        i = nodes[el, 0]
        for k in range(3):
            j = nodes[el, k + 1]
            for c in range(3):
                y[k, c, v] = (x[j, c] - x[i, c]) + (x_low[j, c] - x_low[i, c])


@njit(cache=True)
def _gather_steps(dx, nodes, dy):
    """Increments of vertices 2..4 relative to vertex 1, ``dy`` (3, 3, WIDTH)."""
    for v in range(WIDTH):
        el = min(v, nodes.shape[0] - 1)
        for k in range(3):
            for c in range(3):
                dy[k, c, v] = dx[nodes[el, k + 1], c] - dx[nodes[el, 0], c]


@njit(cache=True)
def _gather_vertices(p, vertices, q):
    """Vectors of the four vertices, ``q`` (4, 3, WIDTH)."""
    for v in range(WIDTH):
        el = min(v, vertices.shape[0] - 1)
        for i in range(4):
            for c in range(3):
                q[i, c, v] = p[vertices[el, i], c]


@njit(cache=True)
def _gather_derivatives(A1, n_rot, nodes, directors, rotations, A):
    """Columns dp/dn of the four vertices, ``A`` (4, 3, 3, WIDTH), and how many of them are used in
    any lane."""
    rotations[:] = 0
    for v in range(WIDTH):
        el = min(v, nodes.shape[0] - 1)
        for i in range(4):
            used = n_rot[nodes[el, i]]
            rotations[i] = max(rotations[i], used)
            for c in range(3):
                for k in range(used):
                    A[i, c, k, v] = A1[directors[el, i], c, k]


@njit(cache=True)
def _gather_rows(rows, first, count, q):
    """Rows of an element array, ``q`` (n, WIDTH)."""
    for v in range(WIDTH):
        el = first + min(v, count - 1)
        for k in range(q.shape[0]):
            q[k, v] = rows[el, k]


@njit(cache=True)
def _put_rows(q, first, count, rows):
    """The opposite of ``_gather_rows``."""
    for v in range(count):
        for k in range(q.shape[0]):
            rows[first + v, k] = q[k, v]


@njit(cache=True)
def _add(factor, q, vertices, total):
    """Add ``factor`` times the vectors ``q`` (4, 3, WIDTH) of the vertices, element by element."""
    for v in range(vertices.shape[0]):
        for i in range(4):
            for c in range(3):
                total[vertices[v, i], c] += factor * q[i, c, v]


@njit(cache=True)
def _scatter(storage, numbering, nodes, first, v, ke, values):
    """Add lane ``v`` of the lower triangle ``ke`` (24 * 24, WIDTH) to the solver's storage.

    Fixed dofs are skipped.  Loops of constant length and unsigned indices, which are never counted
    from the end of an array, make this twice as fast.
    """
    base, offset, _, stride = storage
    (start, n_rot, _, _), fixed, any_fixed = numbering
    for a in range(4):
        for b in range(a + 1):
            # the rows of storage are the later dofs: the rows of this block of ke, or its columns
            swap = start[nodes[v, b]] > start[nodes[v, a]]
            i, j = (b, a) if swap else (a, b)
            row_step, col_step = (1, 24) if swap else (24, 1)
            row, row_count = start[nodes[v, i]], 3 + n_rot[nodes[v, i]]
            col, col_count = start[nodes[v, j]], 3 + n_rot[nodes[v, j]]
            for r in range(6):
                if r >= row_count:
                    continue
                position = base[row + r] + offset[first + v, i, j]
                entry = 24 * 6 * a + 6 * b + row_step * r
                used = r + 1 if a == b else col_count
                for k in range(6):
                    if k < used and not (any_fixed and (fixed[row + r] or fixed[col + k])):
                        values[uint64(position + stride * k)] += ke[uint64(entry + col_step * k),
                                                                    uint64(v)]


@njit(cache=True)
def _combine(stiffness_factor, mass_factor, mass, inertia, A, n_rot, ke):
    """``ke = stiffness_factor ke + mass_factor m`` with the mass of Eqs. (40), (41)."""
    for i in range(4):
        for j in range(i + 1):
            for r in range(3 + n_rot[i]):
                for k in range(3 + n_rot[j]):
                    ke[6 * i + r, 6 * j + k] *= stiffness_factor
            m_ij = mass_factor * mass[i, j]
            for c in range(3):
                ke[6 * i + c, 6 * j + c] += m_ij
            m_ij *= inertia
            for r in range(n_rot[i]):
                for k in range(n_rot[j]):
                    ke[6 * i + 3 + r, 6 * j + 3 + k] += m_ij * (
                        A[i, 0, r] * A[j, 0, k] + A[i, 1, r] * A[j, 1, k] + A[i, 2, r] * A[j, 2, k])


@njit(cache=True)
def step_system(elements, numbering, motion, start_state, step, averaged, delta, loads,
                storage, with_tangent, mixed, values, residual, scratch):
    """Residual and symmetric iteration matrix of one step, Eqs. (58)-(70).

    ``residual = F_ext - M U_ddot - F_m - F_int`` at the generalized midpoint and
    ``K = (1 - alpha_m)/(beta dt^2) M + (1 - alpha_f) K_G`` for the increment ``delta`` of the step.
    With alpha_f = 0, unit stiffness factor and zero inertia factors it is static equilibrium at
    the end; with a zero stiffness factor the matrix is the mass matrix alone.

    Args:
        elements: ``Elements``.
        numbering: (nodes, fixed (n_dof,), any fixed), nodes as in ``kernels.charts``.
        motion: (x, x_low, variables, chart, velocity, acceleration) at the start of the step.
        start_state: (p, t, b, e): normals, local variables and measures at the start.
        step: (alpha_f, factor of K_G, factors of delta, U_dot, U_ddot in Eq. 57b, then in Eq. 57a).
        averaged: T as the weighted mean of the two ends instead of at the midpoint.
        delta: (n_dof,) increment of the step.
        loads: (dead (n_dof,), moments (n_nodes, 3), pressure (n_elem,), any pressure) at the
            generalized midpoint.
        storage: (base, offset, diagonal, stride) of the linear solver.
        with_tangent: whether ``values`` is assembled too.
        mixed: (whether, e (n_elem, n_s), b (n_elem, 11)): the tangent takes its stresses from these
            instead of from the strains; see ``predict_strains``.
        values: storage of the matrix.
        residual: (3, n_dof) result: the residual with zeros at fixed dofs, the same without (minus
            the reaction there), and the applied load.
        scratch: arrays of ``scratch``.

    Returns:
        0, or CHART_LEFT when a normal leaves the chart of its rotational variables.
    """
    (start, n_rot, _, _), fixed, any_fixed = numbering
    x, x_low, _, chart, _, _ = motion
    dead, moments, pressures, any_pressure = loads
    use_mixed, e_mixed, b_mixed = mixed
    p_start, t_start, b_start, e_start = start_state
    alpha_f, k_factor, c_delta = step[0], step[1], step[2]
    weight = 1.0 - alpha_f
    dx, p_end, p_mid, A1, inertial_x, inertial_p, force_x, force_p, rate_p, ends_p = scratch
    if rotation.advance_nodes(numbering[0], motion, step, delta, scratch) != 0:
        return CHART_LEFT
    force_x[:] = 0.0
    force_p[:] = 0.0
    rate_p[:] = 0.0
    ends_p[:] = 0.0
    residual[2] = dead
    if with_tangent:
        values[:] = 0.0

    n_s = elements.l.shape[1]
    # of the elements of a group side by side; what ends in _ is read or written lane by lane
    (x_, y_0), (dx_, dy), (y_, y), (p_, p) = pair((3, 3)), pair((3, 3)), pair((3, 3)), pair((4, 3))
    (t_, t_0), (b_, b_0), (e_, e_0) = pair((3, 3)), pair((11,)), pair((n_s,))
    (force_x_, f_x), (force_p_, f_p) = pair((4, 3)), pair((4, 3))
    (a_x_, a_x), (a_p_, a_p), (A_, A) = pair((4, 3)), pair((4, 3)), pair((4, 3, 3))
    (mass_, mass), (inertia_, inertia), (ke_, ke) = pair((4, 4)), pair((1,)), pair((24, 24))
    R, t, b, e = new((3, 3)), new((3, 3)), new((11,)), new((n_s,))
    B, f, g, yl, r = new((n_s, 9)), new((3, 3)), new((4, 2)), new((3, 3)), new((4, 3))
    rotations, pushed = np.empty(4, np.int64), np.empty((4, 3))
    work = element.workspace()

    for group in range(elements.l.shape[0]):
        first, count = _members(elements, group)
        nodes = elements.nodes[first:first + count]
        directors = elements.directors[first:first + count]
        y0, r0, l_s = lanes(elements.y0[group]), lanes(elements.r0[group]), lanes(elements.l[group])
        Q, k_b = lanes(elements.Q[group]), lanes(elements.k_b[group])
        _gather(x, x_low, nodes, x_)
        _gather_steps(dx, nodes, dx_)
        _gather_rows(t_start.reshape(-1, 9), first, count, t_.reshape(9, WIDTH))
        _gather_rows(b_start, first, count, b_)
        _gather_rows(e_start, first, count, e_)
        _gather_rows(elements.mass.reshape(-1, 16), first, count, mass_.reshape(16, WIDTH))
        _gather_rows(elements.inertia.reshape(-1, 1), first, count, inertia_)

        # strains at the end of the step, averaged with those at its start (Eq. 70)
        for k in range(3):
            for c in range(3):
                y[k, c] = y_0[k, c] + dy[k, c]
        _gather_vertices(p_end, directors, p_)
        lengths_end = element.frame(y, R)
        element.local_variables(R, y, p, y0, r0, t, b)
        element.membrane_strains(l_s, Q, t, e)
        for k in range(3):
            for c in range(3):
                t[k, c] = weight * t[k, c] + alpha_f * t_0[k, c]
        for k in range(11):
            b[k] = weight * b[k] + alpha_f * b_0[k]
        for s in range(n_s):
            e[s] = weight * e[s] + alpha_f * e_0[s]
        element.local_forces(l_s, Q, k_b, t, b, e, B, f, g)

        if averaged:
            element.rotated_positions(R, y, p, yl, r)
            element.global_forces(R, *lengths_end, yl, r, f, g, f_x, f_p)
            _add(weight, force_x_, nodes, force_x)
            _add(weight, force_p_, directors, ends_p[0])
            _gather_vertices(p_start, directors, p_)
            lengths_start = element.frame(y_0, R)
            element.rotated_positions(R, y_0, p, yl, r)
            element.global_forces(R, *lengths_start, yl, r, f, g, f_x, f_p)
            _add(alpha_f, force_x_, nodes, force_x)
            _add(alpha_f, force_p_, directors, ends_p[1])

        # T at the generalized midpoint
        for k in range(3):
            for c in range(3):
                y[k, c] = y_0[k, c] + weight * dy[k, c]
        _gather_vertices(p_mid, directors, p_)
        a_13, b_13, L13, L24 = element.frame(y, R)
        element.rotated_positions(R, y, p, yl, r)
        element.global_forces(R, a_13, b_13, L13, L24, yl, r, f, g, f_x, f_p)
        if not averaged:
            _add(1.0, force_x_, nodes, force_x)
        _add(1.0, force_p_, directors, force_p)
        _gather_vertices(inertial_x, nodes, a_x_)
        _gather_vertices(inertial_p, directors, a_p_)
        for i in range(4):
            for c in range(3):
                f_x[i, c] = (mass[i, 0] * a_x[0, c] + mass[i, 1] * a_x[1, c]
                             + mass[i, 2] * a_x[2, c] + mass[i, 3] * a_x[3, c])
                f_p[i, c] = inertia[0] * (mass[i, 0] * a_p[0, c] + mass[i, 1] * a_p[1, c]
                                          + mass[i, 2] * a_p[2, c] + mass[i, 3] * a_p[3, c])
        _add(1.0, force_x_, nodes, force_x)
        _add(1.0, force_p_, directors, rate_p)
        if any_pressure:
            for v in range(count):
                element.pressure_forces(y_[:, :, v], pressures[first + v], pushed)
                for i in range(4):
                    for c in range(3):
                        residual[2, start[nodes[v, i]] + c] += pushed[i, c]
        if with_tangent:
            _gather_derivatives(A1, n_rot, nodes, directors, rotations, A_)
            if use_mixed:
                _gather_rows(b_mixed, first, count, b_)
                _gather_rows(e_mixed, first, count, e_)
                b[:], e[:] = b_0, e_0
                element.local_forces(l_s, Q, k_b, t, b, e, B, f, g)
                for i in range(4):
                    for c in range(3):
                        f_p[i, c] = R[0, c] * g[i, 0] + R[1, c] * g[i, 1]
                _add(1.0, force_p_, directors, ends_p[0])
            element.tangent(R, a_13, b_13, L13, L24, yl, r, f, g, B, e, Q, k_b, A, rotations,
                            work, ke)
            if any_pressure:
                for v in range(count):
                    element.add_pressure_stiffness(y_[:, :, v], pressures[first + v],
                                                   ke_[:, :, v])
            _combine(k_factor, c_delta, mass, inertia[0], A, rotations, ke)
            for v in range(count):
                _scatter(storage, numbering, nodes, first, v, ke_.reshape(576, WIDTH), values)

    _reduce(numbering, chart, averaged, p_start, moments, residual, scratch)
    if with_tangent:
        force = ends_p[0] if use_mixed else force_p
        _finish_tangent(storage, numbering, chart, k_factor, moments, p_mid, A1, force, values)
    return 0


@njit(cache=True)
def _reduce(numbering, chart, averaged, p_start, moments, residual, scratch):
    """Chain rule to rotational variables, ``f_n = A1^T f_p``.  Fixed dofs carry no residual."""
    nodes, fixed, _ = numbering
    start, n_rot, directors, _ = nodes
    _, p_end, p_mid, A1, _, _, force_x, force_p, rate_p, ends_p = scratch
    balance, unmasked, applied = residual[0], residual[1], residual[2]
    couple = np.empty(3)
    for i in range(start.shape[0]):
        first = start[i]
        for c in range(3):
            unmasked[first + c] = applied[first + c] - force_x[i, c]
        rotation.moment_forces(nodes, i, chart, p_mid, A1, moments, couple)
        for k in range(n_rot[i]):
            load = 0.0
            for d in range(directors[i], directors[i + 1]):
                for c in range(3):
                    load += A1[d, c, k] * rate_p[d, c]
                    if not averaged:
                        load += A1[d, c, k] * force_p[d, c]
            applied[first + 3 + k] += couple[k]
            unmasked[first + 3 + k] = applied[first + 3 + k] - load
    if averaged:
        A_end = np.empty_like(A1)
        for end in range(2):
            rotation.derivatives(nodes, chart, p_end if end == 0 else p_start, A_end)
            for i in range(start.shape[0]):
                for d in range(directors[i], directors[i + 1]):
                    for k in range(n_rot[i]):
                        for c in range(3):
                            unmasked[start[i] + 3 + k] -= A_end[d, c, k] * ends_p[end, d, c]
    for k in range(fixed.shape[0]):
        balance[k] = 0.0 if fixed[k] else unmasked[k]


@njit(cache=True)
def _finish_tangent(storage, numbering, chart, k_factor, moments, p_mid, A1, force_p, values):
    """Second derivative of the normals, ``f_p . d2p/dn2``, and unit rows for fixed dofs.

    A moment M adds the symmetric part of its load stiffness; the skew part, on a smooth node
    proportional to M . p, is left out: the matrix stays symmetric, and exact where M is tangential
    to the shell.
    """
    _, _, diagonal, stride = storage
    nodes, fixed, any_fixed = numbering
    start, n_rot = nodes[0], nodes[1]
    H = np.empty((3, 3))
    for i in range(start.shape[0]):
        rotation.curvature(nodes, i, p_mid, A1, chart, force_p, moments, H)
        for k in range(n_rot[i]):
            row = start[i] + 3 + k
            for l in range(k + 1):
                if l == k or not (fixed[row] or fixed[row - k + l]):
                    values[diagonal[row] - stride * (k - l)] += k_factor * H[k, l]
    if any_fixed:
        for k in range(fixed.shape[0]):
            if fixed[k]:
                values[diagonal[k]] = 1.0


@njit(cache=True)
def predict_strains(elements, numbering, x, x_low, p, A1, state, correction, e_next, b_next):
    """Strain measures after a correction by linear extrapolation, ``e + B T du``, ``b + T du``.

    A tangent whose stresses are these instead of those of the moved configuration is that of a
    mixed (stress and displacement) Newton iteration: spurious membrane forces of a large rotation
    do not enter it, so it takes larger steps (Magisano, Leonetti, Garcea 2017).  The equilibrium it
    converges to is the same.
    """
    start, n_rot = numbering[0], numbering[1]
    _, t_now, b_now, e_now = state
    n_s = e_now.shape[1]
    (y_, y), (q_, q), (d_, d) = pair((3, 3)), pair((4, 3)), pair((3, 3))
    (dp_, dp), (t_, t), (b_, b), (e_, e) = pair((4, 3)), pair((3, 3)), pair((11,)), pair((n_s,))
    R, yl, r = new((3, 3)), new((3, 3)), new((4, 3))
    dy, dt = new((3, 3)), new((3, 3))
    for group in range(elements.l.shape[0]):
        first, count = _members(elements, group)
        nodes = elements.nodes[first:first + count]
        directors = elements.directors[first:first + count]
        _gather(x, x_low, nodes, y_)
        _gather_vertices(p, directors, q_)
        _gather_rows(t_now.reshape(-1, 9), first, count, t_.reshape(9, WIDTH))
        _gather_rows(b_now, first, count, b_)
        _gather_rows(e_now, first, count, e_)
        for v in range(count):
            for k in range(3):
                for c in range(3):
                    d_[k, c, v] = (correction[start[nodes[v, k + 1]] + c]
                                   - correction[start[nodes[v, 0]] + c])
            for i in range(4):
                rates = start[nodes[v, i]] + 3
                for c in range(3):
                    dp_[i, c, v] = 0.0
                    for k in range(n_rot[nodes[v, i]]):
                        dp_[i, c, v] += A1[directors[v, i], c, k] * correction[rates + k]
        a_13, b_13, L13, L24 = element.frame(y, R)
        element.rotated_positions(R, y, q, yl, r)
        for k in range(3):
            for c in range(3):
                dy[k, c] = R[c, 0] * d[k, 0] + R[c, 1] * d[k, 1] + R[c, 2] * d[k, 2]
        phi = element.frame_rotation(a_13, b_13, L13, L24, dy)
        for k in range(3):
            dt[k, 0] = dy[k, 0] + yl[k, 1] * phi[2] - yl[k, 2] * phi[1]
            dt[k, 1] = dy[k, 1] + yl[k, 2] * phi[0] - yl[k, 0] * phi[2]
            dt[k, 2] = dy[k, 2] + yl[k, 0] * phi[1] - yl[k, 1] * phi[0]
            b[k] += dt[k, 2]
        for i in range(4):
            b[3 + 2 * i] += (R[0, 0] * dp[i, 0] + R[0, 1] * dp[i, 1] + R[0, 2] * dp[i, 2]
                             + (r[i, 1] * phi[2] - r[i, 2] * phi[1]))
            b[4 + 2 * i] += (R[1, 0] * dp[i, 0] + R[1, 1] * dp[i, 1] + R[1, 2] * dp[i, 2]
                             + (r[i, 2] * phi[0] - r[i, 0] * phi[2]))
        l_s, Q = lanes(elements.l[group]), lanes(elements.Q[group])
        for s in range(n_s):
            for k in range(3):
                slope = l_s[s, k, 2]
                for j in range(3):
                    slope += Q[s, k, j] * t[j, 2]
                e[s] += l_s[s, k, 0] * dt[k, 0] + l_s[s, k, 1] * dt[k, 1] + slope * dt[k, 2]
        _put_rows(b_, first, count, b_next)
        _put_rows(e_, first, count, e_next)


@njit(cache=True)
def _momentum_scales(nodal_mass, x, v):
    """``sum m |v|`` and ``sum m |x - x_c| |v|`` with lumped nodal masses, x_c the mass centre."""
    centre = np.zeros(3)
    total = 0.0
    for i in range(x.shape[0]):
        total += nodal_mass[i]
        for c in range(3):
            centre[c] += nodal_mass[i] * x[i, c]
    centre /= total
    linear, angular = 0.0, 0.0
    for i in range(x.shape[0]):
        speed, arm = 0.0, 0.0
        for c in range(3):
            speed += v[i, c] * v[i, c]
            arm += (x[i, c] - centre[c]) ** 2
        linear += nodal_mass[i] * np.sqrt(speed)
        angular += nodal_mass[i] * np.sqrt(speed * arm)
    return linear, angular


@njit(cache=True)
def observe(elements, nodal_mass, x, x_low, p, v, p_dot, start_state, element_energy):
    """Local variables and measures of a state, its energies and momenta.

    Fills ``start_state = (p, t, b, e)`` for the next step and ``element_energy`` (n_elem,), the
    strain energy of each element [J].  Angular momentum is about the origin.

    Returns:
        (13,): kinetic energy, strain energy, linear momentum (Eq. 49), angular momentum with the
        consistent mass, angular momentum with one sum over nodes as printed in Eq. (50), and the
        scales sum m |v| and sum m |x - x_c| |v| against which drifts are measured.
    """
    p_start, t_start, b_start, e_start = start_state
    result = np.zeros(13)
    n_s = e_start.shape[1]
    (y_, y), (p_, normals), (t_, t) = pair((3, 3)), pair((4, 3)), pair((3, 3))
    (b_, b), (e_, e), (W_, W), R = pair((11,)), pair((n_s,)), pair((1,)), new((3, 3))
    vx, vp, q = np.empty((4, 3)), np.empty((4, 3)), np.empty((4, 3))
    X = np.empty((4, 3))
    kinetic, strain = 0.0, 0.0
    for i in range(p.shape[0]):
        for c in range(3):
            p_start[i, c] = p[i, c]
    for group in range(elements.l.shape[0]):
        first, count = _members(elements, group)
        _gather(x, x_low, elements.nodes[first:first + count], y_)
        _gather_vertices(p, elements.directors[first:first + count], p_)
        element.frame(y, R)
        element.local_variables(R, y, normals, lanes(elements.y0[group]), lanes(elements.r0[group]),
                                t, b)
        element.membrane_strains(lanes(elements.l[group]), lanes(elements.Q[group]), t, e)
        W[0] = element.strain_energy(e, lanes(elements.k_b[group]), b)
        _put_rows(t_.reshape(9, WIDTH), first, count, t_start.reshape(-1, 9))
        _put_rows(b_, first, count, b_start)
        _put_rows(e_, first, count, e_start)
        _put_rows(W_, first, count, element_energy.reshape(-1, 1))
    for el in range(elements.nodes.shape[0]):
        strain += element_energy[el]
        for i in range(4):
            node, director = elements.nodes[el, i], elements.directors[el, i]
            for c in range(3):
                vx[i, c], vp[i, c] = v[node, c], p_dot[director, c]
                X[i, c], q[i, c] = x[node, c] + x_low[node, c], p[director, c]
        mass, inertia = elements.mass[el], elements.inertia[el]
        for i in range(4):
            px, py, pz, wx, wy, wz, lumped = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for j in range(4):
                m_ij = mass[i, j]
                lumped += m_ij
                px += m_ij * vx[j, 0]
                py += m_ij * vx[j, 1]
                pz += m_ij * vx[j, 2]
                wx += m_ij * vp[j, 0]
                wy += m_ij * vp[j, 1]
                wz += m_ij * vp[j, 2]
            kinetic += 0.5 * (vx[i, 0] * px + vx[i, 1] * py + vx[i, 2] * pz)
            kinetic += 0.5 * inertia * (vp[i, 0] * wx + vp[i, 1] * wy + vp[i, 2] * wz)
            result[2] += px
            result[3] += py
            result[4] += pz
            wx, wy, wz = inertia * wx, inertia * wy, inertia * wz
            result[5] += X[i, 1] * pz - X[i, 2] * py + q[i, 1] * wz - q[i, 2] * wy
            result[6] += X[i, 2] * px - X[i, 0] * pz + q[i, 2] * wx - q[i, 0] * wz
            result[7] += X[i, 0] * py - X[i, 1] * px + q[i, 0] * wy - q[i, 1] * wx
            for c in range(3):
                d, f = (c + 1) % 3, (c + 2) % 3
                result[8 + c] += lumped * (X[i, d] * vx[i, f] - X[i, f] * vx[i, d]
                                           + inertia * (q[i, d] * vp[i, f] - q[i, f] * vp[i, d]))
    result[0] = kinetic
    result[1] = strain
    result[11], result[12] = _momentum_scales(nodal_mass, x, v)
    return result


@njit(cache=True)
def move_nodes(start, delta, x, x_low):
    """Add displacements to compensated positions: two-sum, the rounding error kept in x_low."""
    for i in range(start.shape[0]):
        for c in range(3):
            old, add = x[i, c], delta[start[i] + c] + x_low[i, c]
            new = old + add
            part = new - old
            x[i, c] = new
            x_low[i, c] = (old - (new - part)) + (add - part)


@njit(cache=True)
def accept(numbering, rates, delta, x, x_low, variables, velocity, acceleration):
    """Move the state to the end of a converged step (Newmark update, compensated positions).

    ``rates`` holds the factors of (delta, U_dot, U_ddot) in U_dot and in U_ddot at t_{n+1}.
    """
    start, n_rot = numbering[0][0], numbering[0][1]
    move_nodes(start, delta, x, x_low)
    v_delta, v_velocity, v_acceleration, a_delta, a_velocity, a_acceleration = rates
    for i in range(start.shape[0]):
        for k in range(n_rot[i]):
            variables[i, k] += delta[start[i] + 3 + k]
    for k in range(delta.shape[0]):
        v, a = velocity[k], acceleration[k]
        velocity[k] = v_delta * delta[k] + v_velocity * v + v_acceleration * a
        acceleration[k] = a_delta * delta[k] + a_velocity * v + a_acceleration * a
