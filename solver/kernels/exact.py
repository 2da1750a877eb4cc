"""Assembly of the exact scheme over all elements: residual and matrix of one iterate.

Positions and normals are those of both ends of the step, local forces those of the mean strains,
Eqs. (68), (70), and what takes them to the nodes is the discrete Jacobian (``discrete``).  The
matrix is the symmetric tangent at the mean configuration, Eq. (63), with the inertia of the step.
"""

import numpy as np

from . import discrete, element
from .arguments import DONE
from .assembly import (
    add_inertial_forces,
    add_mass,
    add_vertices,
    average_strains,
    gather_derivatives,
    gather_increments,
    gather_positions,
    gather_rows,
    gather_vertices,
    hold,
    members,
    move,
    scatter,
)
from .jit import internal, kernel
from .lanes import WIDTH, lanes, new, pair
from .spins import advance, basis, moment_across, nodal_matrix
from .tangent import tangent, tangent_work
from .vectors import dot


@kernel
def step_exact(elements, dofs, inertia, motion, start, step, lags, delta, loads, storage,
               with_tangent, values, residual, work, placed):
    """Residual and symmetric matrix of an iterate of the exact scheme.

    ``R_x = F - M (v_1 - v_0)/dt - f_x``,
    ``R_k = b_k . (m - (pi_1 - pi_0)/dt - sum p_m x f_p)``, ``(f_x, f_p) = T_bar^T f_L``.

    Args:
        elements: ``Elements``.
        dofs: ``Dofs``.
        inertia: (n_directors,) of the normals [kg m^2].
        motion: ``Motion`` at the start of the step.
        start: ``Start``.
        step: ``Factors``.
        lags: (n_elem, 1) what dissipation adds to the weight of the strains at the end.
        delta: (n_dof,) increment of the step.
        loads: ``Loads`` at the middle of the step.
        storage: ``Storage`` of ``values``.
        with_tangent: whether to fill ``values``.
        values: lower triangle of the matrix.
        residual: ``Residual``.
        work: ``SpinWork``.
        placed: whether it has the nodes of this iterate already.

    Returns:
        A node that turns too far.
    """
    if not placed:
        lost = advance(dofs.nodes, inertia, motion, start, step, delta, work)
        if lost != DONE:
            return lost
    work.force_x[:] = 0.0
    for d in range(work.force_p.shape[0]):
        for c in range(3):
            work.force_p[d, c] = -loads.on_normals[d, c]
    if with_tangent:
        values[:] = 0.0
    _add_elements(elements, dofs, motion, start, step, lags, storage, with_tangent, values, work)
    _reduce(dofs, motion.chart, loads, residual, work)
    if with_tangent:
        _add_nodes(dofs, inertia, storage, motion.chart, step, work, values)
        hold(dofs, storage, values, 0, dofs.nodes.start.shape[0])
    return DONE


@internal
def _add_elements(elements, dofs, motion, start, step, lags, storage, with_tangent, values, work):
    """Internal and inertial forces of all elements, and their matrices."""
    n_s = elements.l.shape[1]
    x, x_low, n_rot = motion.x, motion.x_low, dofs.nodes.n_rot
    (y_0_, y_0), (dy_, dy), y = pair((3, 3)), pair((3, 3)), new((3, 3))
    (p_0_, p_0), (p_1_, p_1), (p_, p) = pair((4, 3)), pair((4, 3)), pair((4, 3))
    t_0, b_0, e_0 = new((3, 3)), new((11,)), new((n_s,))
    t, b, e, R = new((3, 3)), new((11,)), new((n_s,)), new((3, 3))
    (f_x_, f_x), (f_p_, f_p), (a_x_, a_x) = pair((4, 3)), pair((4, 3)), pair((4, 3))
    (A_, A), (ke_, ke), (lag_, lag) = pair((4, 3, 3)), pair((24, 24)), pair((1,))
    B, f, g, yl, r = new((n_s, 9)), new((3, 3)), new((4, 2)), new((3, 3)), new((4, 3))
    before, after, jacobian = discrete.invariants(), discrete.invariants(), discrete.force_work()
    rotations, matrices = np.empty(4, np.int64), tangent_work()
    coupling, coupled = new((0, 8)), elements.coupling.shape[0] > 0
    own = np.ones((WIDTH, 4), np.bool_)

    for group in range(elements.l.shape[0]):
        first, count = members(elements, group)
        nodes = elements.nodes[first:first + count]
        directors = elements.directors[first:first + count]
        y0, r0, l = lanes(elements.y0[group]), lanes(elements.r0[group]), lanes(elements.l[group])
        Q, k_b = lanes(elements.Q[group]), lanes(elements.k_b[group])
        mass = lanes(elements.inertia[group])[0]
        if coupled:
            coupling = lanes(elements.coupling[group])
        gather_positions(x, x_low, nodes, y_0_)
        gather_increments(work.dx, nodes, dy_)
        gather_vertices(start.p, directors, p_0_)
        gather_vertices(work.p_end, directors, p_1_)
        gather_vertices(work.p_mid, directors, p_)
        gather_rows(lags, first, count, lag_)

        # 1. strains at both ends, Eqs. (8), (10), their mean, Eq. (70), local forces, Eq. (68)
        discrete.measure(y_0, p_0, before)
        discrete.local_variables(before, y0, r0, t_0, b_0)
        element.membrane_strains(l, Q, t_0, e_0)
        element.couple_measures(coupling, b_0, 1.0, e_0)
        move(y_0, dy, 1.0, y)
        discrete.measure(y, p_1, after)
        discrete.local_variables(after, y0, r0, t, b)
        element.membrane_strains(l, Q, t, e)
        element.couple_measures(coupling, b, 1.0, e)
        average_strains(step, lag[0], t_0, b_0, e_0, t, b, e)
        element.local_forces(l, Q, k_b, t, b, e, B, f, g)
        element.couple_forces(coupling, e, g)

        # 2. T_bar^T f_L, and M (v_1 - v_0)/dt
        move(y_0, dy, 0.5, y)
        discrete.force(before, after, y, dy, p, f, g, jacobian, f_x, f_p)
        gather_vertices(work.inertial_x, nodes, a_x_)
        add_inertial_forces(mass, a_x, f_x)
        add_vertices(1.0, f_x_, nodes, work.force_x)
        add_vertices(1.0, f_p_, directors, work.force_p)

        # 3. k_T at the mean configuration, Eq. (63), and mass, Eq. (40)
        if with_tangent:
            gather_derivatives(work.A1, n_rot, nodes, directors, rotations, A_)
            diagonals = element.frame(y, R)
            element.rotated_positions(R, y, p, yl, r)
            tangent(R, diagonals, yl, r, f, g, B, e, Q, k_b, coupling, A, rotations, matrices, ke)
            add_mass(2.0 * step.stiffness * (step.strain_end + lag[0]), step.mass, mass, rotations,
                     ke)
            for v in range(count):
                scatter(storage, dofs, nodes, own, first, v, ke_.reshape(576, WIDTH), values)


@internal
def _reduce(dofs, frames, loads, residual, work):
    """Residual of all unknowns; held ones carry none."""
    start, n_rot, first, _ = dofs.nodes
    balance, unmasked, applied = residual
    b, moment = np.empty(3), np.empty(3)
    for k in range(dofs.fixed.shape[0]):
        applied[k] = loads.forces[k]
    for i in range(start.shape[0]):
        for c in range(3):
            unmasked[start[i] + c] = applied[start[i] + c] - work.force_x[i, c]
        moment_across(dofs.nodes, i, work.p_mid, loads.moments, moment)
        for k in range(n_rot[i]):
            basis(frames[i], n_rot[i], k, b)
            inner = dot(b, work.spin_rate[i])
            for d in range(first[i], first[i + 1]):
                for c in range(3):
                    inner += work.A1[d, c, k] * work.force_p[d, c]
            at = start[i] + 3 + k
            applied[at] += dot(b, moment)
            unmasked[at] = applied[at] - inner
    for k in range(dofs.fixed.shape[0]):
        balance[k] = 0.0 if dofs.fixed[k] else unmasked[k]


@internal
def _add_nodes(dofs, inertia, storage, frames, step, work, values):
    """Second derivative of the normals and their inertia."""
    start, n_rot = dofs.nodes.start, dofs.nodes.n_rot
    fixed, diagonal, stride = dofs.fixed, storage.diagonal, storage.stride
    k_n = np.empty((3, 3))
    for i in range(start.shape[0]):
        nodal_matrix(dofs.nodes, i, inertia, frames[i], work, step, k_n)
        for k in range(n_rot[i]):
            row = start[i] + 3 + k
            for l in range(k + 1):
                if l == k or not (fixed[row] or fixed[row - k + l]):
                    values[diagonal[row] - stride * (k - l)] += k_n[k, l]
