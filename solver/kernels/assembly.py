"""Assembly over all elements: residual and matrix of one iterate, Eqs. (58)-(70).

Elements are worked on in groups of ``WIDTH``, side by side.  Of the arrays of a group, what ends in
``_`` is seen number by number, the last axis being the lane; without it, as lanes.  A lane without
an element repeats the last one.
"""

import numpy as np
from numba import uint64

from . import element
from .arguments import AFTER, BEFORE, DONE, ELEMENTS, WHOLE
from .jit import internal, kernel
from .lanes import WIDTH, lanes, new, pair
from .nodes import advance_some, curvature, derivatives, moment_forces, moment_skew
from .tangent import tangent, tangent_work


@kernel
def members(elements, group):
    """First element of a group and how many elements it has; the last group may have fewer."""
    first = WIDTH * group
    return first, min(WIDTH, elements.nodes.shape[0] - first)


@internal
def gather_positions(x, x_low, nodes, y_):
    """Positions of vertices 2..4 relative to vertex 1 from compensated nodal positions.

    ``nodes`` (count, 4) are those of the elements of a group, ``y_`` is (3, 3, WIDTH).
    """
    for v in range(WIDTH):
        el = min(v, nodes.shape[0] - 1)
        i = nodes[el, 0]
        for k in range(3):
            j = nodes[el, k + 1]
            for c in range(3):
                y_[k, c, v] = (x[j, c] - x[i, c]) + (x_low[j, c] - x_low[i, c])


@internal
def gather_increments(dx, nodes, dy_):
    """Increments of vertices 2..4 relative to vertex 1, ``dy_`` (3, 3, WIDTH)."""
    for v in range(WIDTH):
        el = min(v, nodes.shape[0] - 1)
        for k in range(3):
            for c in range(3):
                dy_[k, c, v] = dx[nodes[el, k + 1], c] - dx[nodes[el, 0], c]


@kernel
def gather_vertices(p, vertices, q_):
    """Vectors of the four vertices, ``q_`` (4, 3, WIDTH)."""
    for v in range(WIDTH):
        el = min(v, vertices.shape[0] - 1)
        for i in range(4):
            for c in range(3):
                q_[i, c, v] = p[vertices[el, i], c]


@internal
def gather_derivatives(A1, n_rot, nodes, directors, rotations, A_):
    """Columns dp/dn of the four vertices, ``A_`` (4, 3, 3, WIDTH), and how many of them are used in
    any lane."""
    rotations[:] = 0
    for v in range(WIDTH):
        el = min(v, nodes.shape[0] - 1)
        for i in range(4):
            used = n_rot[nodes[el, i]]
            rotations[i] = max(rotations[i], used)
            for c in range(3):
                for k in range(used):
                    A_[i, c, k, v] = A1[directors[el, i], c, k]


@internal
def gather_rows(rows, first, count, q_):
    """Rows of an element array, ``q_`` (n, WIDTH)."""
    for v in range(WIDTH):
        el = first + min(v, count - 1)
        for k in range(q_.shape[0]):
            q_[k, v] = rows[el, k]


@internal
def put_rows(q_, first, count, rows):
    """The opposite of ``gather_rows``."""
    for v in range(count):
        for k in range(q_.shape[0]):
            rows[first + v, k] = q_[k, v]


@internal
def gather_strains(t, b, e, first, count, t_, b_, e_):
    """Strains of the elements of a group, see ``arguments.Start``."""
    gather_rows(t.reshape(-1, 9), first, count, t_.reshape(9, WIDTH))
    gather_rows(b, first, count, b_)
    gather_rows(e, first, count, e_)


@internal
def gather_owned(owned, nodes, own):
    """Which of the vertices a thread owns, ``own`` (WIDTH, 4), see ``arguments.Share``; whether all
    are."""
    count = 0
    for v in range(nodes.shape[0]):
        for i in range(4):
            own[v, i] = owned[nodes[v, i]]
            count += own[v, i]
    return count == 4 * nodes.shape[0]


@internal
def add_vertices(factor, q_, vertices, total):
    """Add ``factor`` times the vectors ``q_`` (4, 3, WIDTH) of the vertices, element by element."""
    for v in range(vertices.shape[0]):
        for i in range(4):
            for c in range(3):
                total[vertices[v, i], c] += factor * q_[i, c, v]


@internal
def add_owned(factor, q_, vertices, own, complete, total):
    """The same to the vertices that are ``own`` (WIDTH, 4), ``complete`` if all are (7 % of the
    time of forces)."""
    if complete:
        add_vertices(factor, q_, vertices, total)
        return
    for v in range(vertices.shape[0]):
        for i in range(4):
            if own[v, i]:
                for c in range(3):
                    total[vertices[v, i], c] += factor * q_[i, c, v]


@internal
def move(y_0, dy, weight, y):
    """``y = y_0 + weight dy``"""
    for k in range(3):
        for c in range(3):
            y[k, c] = y_0[k, c] + weight * dy[k, c]


@internal
def average_strains(step, lag, t_0, b_0, e_0, t, b, e):
    """Eq. (70): (t, b, e) at the end <- (1 - alpha_f) end + alpha_f start; with damping eta [s],
    the measures b and e have ``eta (end - start) / dt`` in addition, with dissipation ``lag (end -
    start)``."""
    weight, alpha_f = 1.0 - step.alpha_f, step.alpha_f
    end, start = step.strain_end + lag, step.strain_start - lag
    for k in range(3):
        for c in range(3):
            t[k, c] = weight * t[k, c] + alpha_f * t_0[k, c]
    for k in range(11):
        b[k] = end * b[k] + start * b_0[k]
    for s in range(e.shape[0]):
        e[s] = end * e[s] + start * e_0[s]


@internal
def inertial_forces(mass, rotary, a_x, a_p, f_x, f_p):
    """``m_ij x_ddot_j``, ``(h^2/12) m_ij p_ddot_j``: M U_ddot + F_m before A1^T, Eqs. (37), (40);
    by twice ``add_inertial_forces`` forces would take 2 % longer."""
    for i in range(4):
        for c in range(3):
            f_x[i, c] = (mass[i, 0] * a_x[0, c] + mass[i, 1] * a_x[1, c]
                         + mass[i, 2] * a_x[2, c] + mass[i, 3] * a_x[3, c])
            f_p[i, c] = (rotary[i, 0] * a_p[0, c] + rotary[i, 1] * a_p[1, c]
                         + rotary[i, 2] * a_p[2, c] + rotary[i, 3] * a_p[3, c])


@internal
def add_inertial_forces(mass, a, f):
    """``f_i += m_ij a_j``"""
    for i in range(4):
        for c in range(3):
            f[i, c] += (mass[i, 0] * a[0, c] + mass[i, 1] * a[1, c] + mass[i, 2] * a[2, c]
                        + mass[i, 3] * a[3, c])


@internal
def add_eccentric_mass(mass_factor, eccentric, A, n_rot, ke):
    """``ke += mass_factor c``, between translations and normals."""
    for i in range(4):
        for j in range(i + 1):
            c_ij = mass_factor * eccentric[i, j]
            for c in range(3):
                for r in range(n_rot[i]):
                    ke[6 * i + 3 + r, 6 * j + c] += c_ij * A[i, c, r]
                if j < i:
                    for k in range(n_rot[j]):
                        ke[6 * i + c, 6 * j + 3 + k] += c_ij * A[j, c, k]


@internal
def add_mass(stiffness_factor, mass_factor, mass, n_rot, ke):
    """``ke <- stiffness_factor ke + mass_factor m`` with the mass of the translations, Eq. (40a).
    """
    for i in range(4):
        for j in range(i + 1):
            for r in range(3 + n_rot[i]):
                for k in range(3 + n_rot[j]):
                    ke[6 * i + r, 6 * j + k] *= stiffness_factor
            m_ij = mass_factor * mass[i, j]
            for c in range(3):
                ke[6 * i + c, 6 * j + c] += m_ij


@internal
def add_rotary(mass_factor, rotary, A, n_rot, ke):
    """``ke += mass_factor m`` with that of the normals, Eqs. (40b), (41)."""
    for i in range(4):
        for j in range(i + 1):
            m_ij = mass_factor * rotary[i, j]
            for r in range(n_rot[i]):
                for k in range(n_rot[j]):
                    ke[6 * i + 3 + r, 6 * j + 3 + k] += m_ij * (
                        A[i, 0, r] * A[j, 0, k] + A[i, 1, r] * A[j, 1, k] + A[i, 2, r] * A[j, 2, k])


@kernel
def scatter(storage, dofs, nodes, own, first, v, ke_, values):
    """Add lane ``v`` of the lower triangle ``ke_`` (24 * 24, WIDTH) to the solver's storage, in the
    rows of the nodes that are ``own`` (WIDTH, 4).

    Held dofs are skipped.  Loops of constant length and unsigned indices, which are never counted
    from the end of an array, make this twice as fast.
    """
    start, n_rot = dofs.nodes.start, dofs.nodes.n_rot
    for a in range(4):
        for b in range(a + 1):
            # the rows of storage are the later dofs: the rows of this block of ke, or its columns
            swap = start[nodes[v, b]] > start[nodes[v, a]]
            i, j = (b, a) if swap else (a, b)
            if not own[v, i]:
                continue
            row_step, col_step = (1, 24) if swap else (24, 1)
            row, row_count = start[nodes[v, i]], 3 + n_rot[nodes[v, i]]
            col, col_count = start[nodes[v, j]], 3 + n_rot[nodes[v, j]]
            for r in range(6):
                if r >= row_count:
                    continue
                position = storage.base[row + r] + storage.offset[first + v, i, j]
                entry = 24 * 6 * a + 6 * b + row_step * r
                used = r + 1 if a == b else col_count
                for k in range(6):
                    if k < used and not (dofs.any_fixed
                                         and (dofs.fixed[row + r] or dofs.fixed[col + k])):
                        values[uint64(position + storage.stride * k)] += ke_[
                            uint64(entry + col_step * k), uint64(v)]


@kernel
def step_system(elements, dofs, motion, start, step, averaged, delta, loads, storage,
                with_tangent, predicted, values, residual, work, share, part):
    """Residual and symmetric iteration matrix of one step, Eqs. (58)-(70).

    ``residual = F_ext - M U_ddot - F_m - F_int`` at the generalized midpoint and
    ``K = (1 - alpha_m)/(beta dt^2) M + (1 - alpha_f) K_G`` for the increment ``delta`` of the step.

    Args:
        elements: ``Elements``.
        dofs: ``Dofs``.
        motion: ``Motion`` at the start of the step.
        start: ``Start``.
        step: ``Factors``.
        averaged: whether T is the average of both ends instead of that of the midpoint.
        delta: (n_dof,) increment of the step.
        loads: ``Loads`` at the generalized midpoint.
        storage: ``Storage`` of ``values``.
        with_tangent: whether to fill ``values``.
        predicted: ``Predicted``.
        values: lower triangle of the matrix.
        residual: ``Residual``.
        work: ``NodalWork``.
        share: ``Share``.
        part: which part of it, see ``arguments.WHOLE``; whoever takes it in parts sees to what is
            of no node: zero ``values``, ``residual.applied`` and ``residual.balance``.

    Returns:
        A node whose directors leave its chart.
    """
    if part == WHOLE or part == BEFORE:
        lost = advance_some(dofs.nodes, motion, step, delta, work, share.first, share.last)
        if lost != DONE:
            return lost
        clear(dofs.nodes.first, step, loads.on_normals, share, work)
    if part == WHOLE:
        for k in range(residual.applied.shape[0]):
            residual.applied[k] = loads.forces[k]
        if with_tangent:
            values[:] = 0.0
    if part == WHOLE or part == ELEMENTS:
        add_elements(elements, dofs, motion, start, step, averaged, storage, with_tangent,
                     predicted, values, work, share)
    if part == WHOLE or part == AFTER:
        reduce(dofs, motion.chart, averaged, start.p, loads, residual, work, share)
        if with_tangent:
            force_p = work.ends_p[0] if predicted.used else work.force_p
            add_curvature(dofs, storage, motion.chart, step.stiffness, loads.moments, work,
                          force_p, values, share.first, share.last)
            hold(dofs, storage, values, share.first, share.last)
    if part == WHOLE:
        for k in range(residual.balance.shape[0]):
            residual.balance[k] = 0.0 if dofs.fixed[k] else residual.unmasked[k]
    return DONE


@internal
def clear(first, step, on_normals, share, work):
    """Forces of nodes and normals before those of elements are added; ``first``: of ``Nodes``."""
    for i in range(share.first, share.last):
        for c in range(3):
            work.force_x[i, c] = 0.0
    for d in range(first[share.first], first[share.last]):
        for c in range(3):
            work.rate_p[d, c] = 0.0
            work.force_p[d, c] = -on_normals[d, c]
            work.ends_p[0, d, c] = -(1.0 - step.alpha_f) * on_normals[d, c]
            work.ends_p[1, d, c] = -step.alpha_f * on_normals[d, c]


@internal
def add_elements(elements, dofs, motion, start, step, averaged, storage, with_tangent, predicted,
                 values, work, share):
    """Internal and inertial forces of elements, and their matrices, see ``Share``."""
    n_s = elements.l.shape[1]
    dx, p_end, p_mid, A1, inertial_x, inertial_p, force_x, force_p, rate_p, ends_p = work
    x, x_low, n_rot = motion.x, motion.x_low, dofs.nodes.n_rot
    t_start, b_start, e_start = start.t, start.b, start.e
    alpha_f, weight = step.alpha_f, 1.0 - step.alpha_f
    (y_0_, y_0), (dy_, dy), y, (p_, p) = pair((3, 3)), pair((3, 3)), new((3, 3)), pair((4, 3))
    (t_, t_0), (b_, b_0), (e_, e_0) = pair((3, 3)), pair((11,)), pair((n_s,))
    (f_x_, f_x), (f_p_, f_p) = pair((4, 3)), pair((4, 3))
    (a_x_, a_x), (a_p_, a_p), (A_, A) = pair((4, 3)), pair((4, 3)), pair((4, 3, 3))
    ke_, ke = pair((24, 24))
    t, b, e, R = new((3, 3)), new((11,)), new((n_s,)), new((3, 3))
    B, f, g, yl, r = new((n_s, 9)), new((3, 3)), new((4, 2)), new((3, 3)), new((4, 3))
    rotations, matrices = np.empty(4, np.int64), tangent_work()
    coupling, coupled = new((0, 8)), elements.coupling.shape[0] > 0
    (eccentric_, eccentric), off_centre = pair((4, 4)), elements.eccentric.shape[0] > 0
    own, complete = np.ones((WIDTH, 4), np.bool_), True

    for group in share.groups:
        first, count = members(elements, group)
        nodes = elements.nodes[first:first + count]
        directors = elements.directors[first:first + count]
        if share.owned.shape[0]:
            complete = gather_owned(share.owned, nodes, own)
        y0, r0, l = lanes(elements.y0[group]), lanes(elements.r0[group]), lanes(elements.l[group])
        Q, k_b = lanes(elements.Q[group]), lanes(elements.k_b[group])
        if coupled:
            coupling = lanes(elements.coupling[group])
        gather_positions(x, x_low, nodes, y_0_)
        gather_increments(dx, nodes, dy_)
        gather_strains(t_start, b_start, e_start, first, count, t_, b_, e_)
        inertia = lanes(elements.inertia[group])
        mass, rotary = inertia[0], inertia[1]

        # 1. strains at the end of the step, Eqs. (8), (10), averaged with those at its start,
        #    Eq. (70), and local forces, Eq. (68)
        move(y_0, dy, 1.0, y)
        gather_vertices(p_end, directors, p_)
        diagonals = element.frame(y, R)
        element.local_variables(R, y, p, y0, r0, t, b)
        element.membrane_strains(l, Q, t, e)
        element.couple_measures(coupling, b, 1.0, e)
        average_strains(step, 0.0, t_0, b_0, e_0, t, b, e)
        element.local_forces(l, Q, k_b, t, b, e, B, f, g)
        element.couple_forces(coupling, e, g)

        # 2. T^T f_int, Eq. (45b), with T the average of both ends
        if averaged:
            element.rotated_positions(R, y, p, yl, r)
            element.global_forces(R, diagonals, yl, r, f, g, f_x, f_p)
            add_owned(weight, f_x_, nodes, own, complete, force_x)
            add_owned(weight, f_p_, directors, own, complete, ends_p[0])
            gather_vertices(start.p, directors, p_)
            diagonals = element.frame(y_0, R)
            element.rotated_positions(R, y_0, p, yl, r)
            element.global_forces(R, diagonals, yl, r, f, g, f_x, f_p)
            add_owned(alpha_f, f_x_, nodes, own, complete, force_x)
            add_owned(alpha_f, f_p_, directors, own, complete, ends_p[1])

        # 3. or with T at the generalized midpoint
        move(y_0, dy, weight, y)
        gather_vertices(p_mid, directors, p_)
        diagonals = element.frame(y, R)
        element.rotated_positions(R, y, p, yl, r)
        element.global_forces(R, diagonals, yl, r, f, g, f_x, f_p)
        if not averaged:
            add_owned(1.0, f_x_, nodes, own, complete, force_x)
        add_owned(1.0, f_p_, directors, own, complete, force_p)

        # 4. M U_ddot + F_m before A_1^T, Eqs. (37), (43)
        gather_vertices(inertial_x, nodes, a_x_)
        gather_vertices(inertial_p, directors, a_p_)
        inertial_forces(mass, rotary, a_x, a_p, f_x, f_p)
        if off_centre:
            gather_rows(elements.eccentric.reshape(-1, 16), first, count,
                        eccentric_.reshape(16, WIDTH))
            # the same of mass that is eccentric: c_ij p_ddot_j on x, c_ij x_ddot_j on p
            add_inertial_forces(eccentric, a_p, f_x)
            add_inertial_forces(eccentric, a_x, f_p)
        add_owned(1.0, f_x_, nodes, own, complete, force_x)
        add_owned(1.0, f_p_, directors, own, complete, rate_p)

        # 5. k_T, Eq. (63), and mass, Eq. (40)
        if with_tangent:
            gather_derivatives(A1, n_rot, nodes, directors, rotations, A_)
            if predicted.used:
                gather_rows(predicted.b, first, count, b_)
                gather_rows(predicted.e, first, count, e_)
                for k in range(11):
                    b[k] = b_0[k]
                for s in range(n_s):
                    e[s] = e_0[s]
                element.local_forces(l, Q, k_b, t, b, e, B, f, g)
                element.couple_forces(coupling, e, g)
                _couples(R, g, f_p)
                add_owned(1.0, f_p_, directors, own, complete, ends_p[0])
            tangent(R, diagonals, yl, r, f, g, B, e, Q, k_b, coupling, A, rotations,
                    matrices, ke)
            add_mass(step.stiffness * step.strain_end / weight, step.mass, mass, rotations, ke)
            add_rotary(step.mass, rotary, A, rotations, ke)
            if off_centre:
                add_eccentric_mass(step.mass, eccentric, A, rotations, ke)
            for v in range(count):
                scatter(storage, dofs, nodes, own, first, v, ke_.reshape(576, WIDTH), values)


@internal
def _couples(R, g, f_p):
    """Forces on the normals, ``R^T g``."""
    for i in range(4):
        for c in range(3):
            f_p[i, c] = R[0, c] * g[i, 0] + R[1, c] * g[i, 1]


@kernel
def reduce(dofs, chart, averaged, p_start, loads, residual, work, share):
    """Chain rule to rotational variables, ``f_n = A1^T f_p``, of the nodes of a ``Share``."""
    start, n_rot, first, _ = dofs.nodes
    _, _, p_mid, A1, _, _, force_x, force_p, rate_p, _ = work
    unmasked, applied, moments = residual.unmasked, residual.applied, loads.moments
    couple = np.empty(3)
    for i in range(share.first, share.last):
        for c in range(3):
            unmasked[start[i] + c] = applied[start[i] + c] - force_x[i, c]
        moment_forces(dofs.nodes, i, chart, p_mid, A1, moments, couple)
        for k in range(n_rot[i]):
            load = 0.0
            for d in range(first[i], first[i + 1]):
                for c in range(3):
                    load += A1[d, c, k] * rate_p[d, c]
                    if not averaged:
                        load += A1[d, c, k] * force_p[d, c]
            applied[start[i] + 3 + k] += couple[k]
            unmasked[start[i] + 3 + k] = applied[start[i] + 3 + k] - load
    if averaged:
        reduce_ends(dofs.nodes, chart, p_start, unmasked, work, share)


@internal
def reduce_ends(nodes, chart, p_start, unmasked, work, share):
    """``f_n -= A1^T f_p`` at the end and at the start of the step, where T is their average."""
    start, n_rot, first = nodes.start, nodes.n_rot, nodes.first
    A_end = np.empty_like(work.A1)
    for end in range(2):
        derivatives(nodes, chart, work.p_end if end == 0 else p_start, A_end)
        for i in range(share.first, share.last):
            for d in range(first[i], first[i + 1]):
                for k in range(n_rot[i]):
                    for c in range(3):
                        unmasked[start[i] + 3 + k] -= A_end[d, c, k] * work.ends_p[end, d, c]


@internal
def add_curvature(dofs, storage, chart, factor, moments, work, force_p, values, first, last):
    """Second derivative of the normals, ``f_p . d2p/dn2``, with the symmetric part of the load
    stiffness of moments, of the nodes from ``first`` to that before ``last``."""
    start, n_rot = dofs.nodes.start, dofs.nodes.n_rot
    fixed, diagonal, stride = dofs.fixed, storage.diagonal, storage.stride
    p_mid, A1, H = work.p_mid, work.A1, np.empty((3, 3))
    for i in range(first, last):
        curvature(dofs.nodes, i, p_mid, A1, chart, force_p, moments, H)
        for k in range(n_rot[i]):
            row = start[i] + 3 + k
            for l in range(k + 1):
                if l == k or not (fixed[row] or fixed[row - k + l]):
                    values[diagonal[row] - stride * (k - l)] += factor * H[k, l]


@kernel
def add_moment_skew(dofs, storage, chart, factor, moments, work, skew):
    """Skew part of the load stiffness of moments, proportional to M . p on a smooth node."""
    start, n_rot = dofs.nodes.start, dofs.nodes.n_rot
    H = np.empty((3, 3))
    for i in range(start.shape[0]):
        if moments[i, 0] == 0.0 and moments[i, 1] == 0.0 and moments[i, 2] == 0.0:
            continue
        moment_skew(dofs.nodes, i, chart, work.p_mid, work.A1, moments, H)
        for k in range(n_rot[i]):
            row = start[i] + 3 + k
            for l in range(k):
                if not (dofs.fixed[row] or dofs.fixed[row - k + l]):
                    skew[storage.diagonal[row] - storage.stride * (k - l)] += factor * H[k, l]


@internal
def hold(dofs, storage, values, first, last):
    """Unit rows for held dofs of the nodes from ``first`` to that before ``last``."""
    if dofs.any_fixed:
        start, n_rot = dofs.nodes.start, dofs.nodes.n_rot
        for i in range(first, last):
            for k in range(start[i], start[i] + 3 + n_rot[i]):
                if dofs.fixed[k]:
                    values[storage.diagonal[k]] = 1.0
