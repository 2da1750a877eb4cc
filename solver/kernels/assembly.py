"""Assembly over all elements: the system of one iteration, and the state at one instant.

Dofs are numbered node by node in an order that keeps the band narrow: 3 displacements, then the
rotational variables of the node.  The tangent goes straight into the storage of the linear solver:
the entry (row, k-th dof of a column node) of element e, vertex pair (a, b), row not before column,
stands at ``base[row] + offset[e, a, b] + stride * k``.
"""

import numpy as np
from numba import njit

from . import element, rotation
from .rotation import CHART_LEFT


@njit(cache=True)
def _gather(x, x_low, nodes, y):
    """Positions of vertices 2..4 relative to vertex 1 from compensated nodal positions."""
    i = nodes[0]
    for k in range(3):
        j = nodes[k + 1]
        for c in range(3):
            y[k, c] = (x[j, c] - x[i, c]) + (x_low[j, c] - x_low[i, c])


@njit(cache=True)
def _gather_normals(p, directors, q):
    """Normals (or their rates) of the four vertices."""
    for i in range(4):
        for c in range(3):
            q[i, c] = p[directors[i], c]


@njit(cache=True)
def _scatter(storage, numbering, nodes, e, ke, values):
    """Add the lower triangle of ``ke`` to the solver's storage, skipping fixed dofs."""
    base, offset, _, stride = storage
    (start, n_rot, _, _), fixed, any_fixed = numbering
    for a in range(4):
        row_start, row_count = start[nodes[a]], 3 + n_rot[nodes[a]]
        for b in range(4):
            col_start, col_count = start[nodes[b]], 3 + n_rot[nodes[b]]
            if col_start > row_start:
                continue
            for r in range(row_count):
                position = base[row_start + r] + offset[e, a, b]
                count = r + 1 if a == b else col_count
                if any_fixed:
                    for k in range(count):
                        if not (fixed[row_start + r] or fixed[col_start + k]):
                            values[position + stride * k] += ke[6 * a + r, 6 * b + k]
                else:
                    for k in range(count):
                        values[position + stride * k] += ke[6 * a + r, 6 * b + k]


@njit(cache=True)
def _combine(stiffness_factor, mass_factor, mass, inertia, A, n_rot, ke):
    """``ke = stiffness_factor ke + mass_factor m`` with the mass of Eqs. (40), (41)."""
    for i in range(24):
        for j in range(24):
            ke[i, j] *= stiffness_factor
    if mass_factor == 0.0:
        return
    for i in range(4):
        for j in range(4):
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
        elements: :class:`solver.element.Elements`.
        numbering: (nodes, fixed (n_dof,), any fixed), nodes as in :mod:`solver.kernels.rotation`.
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
            instead of from the strains; see :func:`predict_strains`.
        values: storage of the matrix.
        residual: (3, n_dof) result: the residual with zeros at fixed dofs, the same without (minus
            the reaction there), and the applied load.
        scratch: arrays of :func:`solver.system.scratch`.

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
    R = np.empty((3, 3))
    y_0, y, p = np.empty((3, 3)), np.empty((3, 3)), np.empty((4, 3))
    t, b, e = np.empty((3, 3)), np.empty(11), np.empty(n_s)
    B, f, g = np.empty((n_s, 9)), np.empty((3, 3)), np.empty((4, 2))
    yl, r = np.empty((3, 3)), np.empty((4, 3))
    f_x, f_p = np.empty((4, 3)), np.empty((4, 3))
    A, rotations = np.zeros((4, 3, 3)), np.empty(4, np.int64)
    ke, pushed = np.zeros((24, 24)), np.empty((4, 3))
    work = element.workspace()

    for el in range(elements.nodes.shape[0]):
        nodes, directors = elements.nodes[el], elements.directors[el]
        l_s, Q, k_b = elements.l[el], elements.Q[el], elements.k_b[el]
        _gather(x, x_low, nodes, y_0)

        # strains at the end of the step, averaged with those at its start (Eq. 70)
        for k in range(3):
            for c in range(3):
                y[k, c] = y_0[k, c] + (dx[nodes[k + 1], c] - dx[nodes[0], c])
        _gather_normals(p_end, directors, p)
        lengths_end = element.frame(y, R)
        element.local_variables(R, y, p, elements.y0[el], elements.r0[el], t, b)
        element.membrane_strains(l_s, Q, t, e)
        for k in range(3):
            for c in range(3):
                t[k, c] = weight * t[k, c] + alpha_f * t_start[el, k, c]
        for k in range(11):
            b[k] = weight * b[k] + alpha_f * b_start[el, k]
        for s in range(n_s):
            e[s] = weight * e[s] + alpha_f * e_start[el, s]
        element.local_forces(l_s, Q, k_b, t, b, e, B, f, g)

        if averaged:
            element.rotated_positions(R, y, p, yl, r)
            element.global_forces(R, *lengths_end, yl, r, f, g, f_x, f_p)
            for i in range(4):
                for c in range(3):
                    force_x[nodes[i], c] += weight * f_x[i, c]
                    ends_p[0, directors[i], c] += weight * f_p[i, c]
            _gather_normals(p_start, directors, p)
            lengths_start = element.frame(y_0, R)
            element.rotated_positions(R, y_0, p, yl, r)
            element.global_forces(R, *lengths_start, yl, r, f, g, f_x, f_p)
            for i in range(4):
                for c in range(3):
                    force_x[nodes[i], c] += alpha_f * f_x[i, c]
                    ends_p[1, directors[i], c] += alpha_f * f_p[i, c]

        # T at the generalized midpoint
        for k in range(3):
            for c in range(3):
                y[k, c] = y_0[k, c] + weight * (dx[nodes[k + 1], c] - dx[nodes[0], c])
        _gather_normals(p_mid, directors, p)
        a_13, b_13, L13, L24 = element.frame(y, R)
        element.rotated_positions(R, y, p, yl, r)
        element.global_forces(R, a_13, b_13, L13, L24, yl, r, f, g, f_x, f_p)
        pressed = any_pressure and pressures[el] != 0.0
        if pressed:
            element.pressure_forces(y, pressures[el], pushed)
            for i in range(4):
                for c in range(3):
                    residual[2, start[nodes[i]] + c] += pushed[i, c]
        for i in range(4):
            for c in range(3):
                force_p[directors[i], c] += f_p[i, c]
                if not averaged:
                    force_x[nodes[i], c] += f_x[i, c]
        mass, inertia = elements.mass[el], elements.inertia[el]
        for i in range(4):
            for j in range(4):
                m_ij = mass[i, j]
                for c in range(3):
                    force_x[nodes[i], c] += m_ij * inertial_x[nodes[j], c]
                    rate_p[directors[i], c] += m_ij * inertia * inertial_p[directors[j], c]
        if with_tangent:
            for i in range(4):
                rotations[i] = n_rot[nodes[i]]
                for c in range(3):
                    for k in range(rotations[i]):
                        A[i, c, k] = A1[directors[i], c, k]
            if use_mixed:
                e[:] = e_mixed[el]
                b[:] = b_mixed[el]
                element.local_forces(l_s, Q, k_b, t, b, e, B, f, g)
                for i in range(4):
                    for c in range(3):
                        ends_p[0, directors[i], c] += R[0, c] * g[i, 0] + R[1, c] * g[i, 1]
            element.tangent(R, a_13, b_13, L13, L24, yl, r, f, g, B, e, Q, k_b, A, rotations,
                            work, ke)
            if pressed:
                element.add_pressure_stiffness(y, pressures[el], ke)
            _combine(k_factor, c_delta, mass, inertia, A, rotations, ke)
            _scatter(storage, numbering, nodes, el, ke, values)

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
        rotation.moment_forces(nodes, i, chart[i], p_mid, A1, moments[i], couple)
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
        rotation.curvature(nodes, i, p_mid, A1, chart[i], force_p, moments[i], H)
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
    R, y, q = np.empty((3, 3)), np.empty((3, 3)), np.empty((4, 3))
    yl, r = np.empty((3, 3)), np.empty((4, 3))
    dy, dp, dt = np.empty((3, 3)), np.empty(3), np.empty((3, 3))
    for el in range(elements.nodes.shape[0]):
        nodes, directors = elements.nodes[el], elements.directors[el]
        _gather(x, x_low, nodes, y)
        _gather_normals(p, directors, q)
        a, b, L1, L2 = element.frame(y, R)
        element.rotated_positions(R, y, q, yl, r)
        for k in range(3):
            for c in range(3):
                dy[k, c] = 0.0
                for d in range(3):
                    dy[k, c] += R[c, d] * (correction[start[nodes[k + 1]] + d]
                                           - correction[start[nodes[0]] + d])
        phi = element.frame_rotation(a, b, L1, L2, dy)
        for k in range(3):
            dt[k, 0] = dy[k, 0] + yl[k, 1] * phi[2] - yl[k, 2] * phi[1]
            dt[k, 1] = dy[k, 1] + yl[k, 2] * phi[0] - yl[k, 0] * phi[2]
            dt[k, 2] = dy[k, 2] + yl[k, 0] * phi[1] - yl[k, 1] * phi[0]
            b_next[el, k] = b_now[el, k] + dt[k, 2]
        for i in range(4):
            first = start[nodes[i]] + 3
            for c in range(3):
                dp[c] = 0.0
                for k in range(n_rot[nodes[i]]):
                    dp[c] += A1[directors[i], c, k] * correction[first + k]
            for c in range(2):
                turned = R[c, 0] * dp[0] + R[c, 1] * dp[1] + R[c, 2] * dp[2]
                if c == 0:
                    turned += r[i, 1] * phi[2] - r[i, 2] * phi[1]
                else:
                    turned += r[i, 2] * phi[0] - r[i, 0] * phi[2]
                b_next[el, 3 + 2 * i + c] = b_now[el, 3 + 2 * i + c] + turned
        for s in range(e_now.shape[1]):
            change = 0.0
            for k in range(3):
                slope = elements.l[el, s, k, 2]
                for j in range(3):
                    slope += elements.Q[el, s, k, j] * t_now[el, j, 2]
                change += (elements.l[el, s, k, 0] * dt[k, 0] + elements.l[el, s, k, 1] * dt[k, 1]
                           + slope * dt[k, 2])
            e_next[el, s] = e_now[el, s] + change


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
    R = np.empty((3, 3))
    y, q = np.empty((3, 3)), np.empty((4, 3))
    vx, vp = np.empty((4, 3)), np.empty((4, 3))
    X = np.empty((4, 3))
    kinetic, strain = 0.0, 0.0
    for i in range(p.shape[0]):
        for c in range(3):
            p_start[i, c] = p[i, c]
    for el in range(elements.nodes.shape[0]):
        nodes, directors = elements.nodes[el], elements.directors[el]
        _gather(x, x_low, nodes, y)
        _gather_normals(p, directors, q)
        _gather_normals(p_dot, directors, vp)
        for i in range(4):
            for c in range(3):
                vx[i, c] = v[nodes[i], c]
                X[i, c] = x[nodes[i], c] + x_low[nodes[i], c]
        element.frame(y, R)
        element.local_variables(R, y, q, elements.y0[el], elements.r0[el], t_start[el],
                                b_start[el])
        element.membrane_strains(elements.l[el], elements.Q[el], t_start[el], e_start[el])
        element_energy[el] = element.strain_energy(e_start[el], elements.k_b[el], b_start[el])
        strain += element_energy[el]
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
