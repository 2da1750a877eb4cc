"""A state at one instant: its local variables and measures, energies and momenta (Eqs. 46-53),
resultants of forces, stresses of an element."""

import numpy as np

from . import element
from .arguments import Observation
from .assembly import gather_positions, gather_vertices, members, put_rows
from .jit import internal, kernel
from .lanes import WIDTH, lanes, new, pair


@kernel
def observe(elements, nodal_mass, motion, velocity, start):
    """Energies and momenta of a state; fills ``start`` but for p, A1 and p_dot, which it takes.

    Args:
        elements: ``Elements``.
        nodal_mass: (n_nodes,) lumped [kg].
        motion: ``Motion``.
        velocity: (n_nodes, 3) [m/s].
        start: ``Start``.

    Returns:
        ``Observation``.  Angular momentum is about the origin.
    """
    _fill_strains(elements, motion, start)
    strain = 0.0
    for el in range(elements.nodes.shape[0]):
        strain += start.energy[el]
    kinetic, linear, angular, printed = _momenta(elements, motion, velocity, start)
    sizes = _momentum_scales(nodal_mass, motion.x, velocity)
    return Observation(kinetic, strain, linear, angular, printed, sizes[0], sizes[1])


@internal
def _fill_strains(elements, motion, start):
    """Local variables, measures and strain energy W of all elements, Eqs. (8), (10), (15)."""
    n_s = start.e.shape[1]
    (y_, y), (p_, p), (t_, t) = pair((3, 3)), pair((4, 3)), pair((3, 3))
    (b_, b), (e_, e), (W_, W), R = pair((11,)), pair((n_s,)), pair((1,)), new((3, 3))
    for group in range(elements.l.shape[0]):
        first, count = members(elements, group)
        gather_positions(motion.x, motion.x_low, elements.nodes[first:first + count], y_)
        gather_vertices(start.p, elements.directors[first:first + count], p_)
        element.frame(y, R)
        element.local_variables(R, y, p, lanes(elements.y0[group]), lanes(elements.r0[group]), t, b)
        element.membrane_strains(lanes(elements.l[group]), lanes(elements.Q[group]), t, e)
        if elements.coupling.shape[0] > 0:
            element.couple_measures(lanes(elements.coupling[group]), b, 1.0, e)
        W[0] = element.strain_energy(e, lanes(elements.k_b[group]), b)
        put_rows(t_.reshape(9, WIDTH), first, count, start.t.reshape(-1, 9))
        put_rows(b_, first, count, start.b)
        put_rows(e_, first, count, start.e)
        put_rows(W_, first, count, start.energy.reshape(-1, 1))


@internal
def _momenta(elements, motion, velocity, start):
    """Kinetic energy, Eq. (22), linear momentum, Eq. (49), and angular momentum: with the
    consistent mass, ``sum_ij m_ij x_i x v_j + I_ij p_i x p_dot_j``, and with one sum over
    nodes, Eq. (50) as printed."""
    kinetic = 0.0
    linear, angular, printed = np.zeros(3), np.zeros(3), np.zeros(3)
    v, w, X, q = np.empty((4, 3)), np.empty((4, 3)), np.empty((4, 3)), np.empty((4, 3))
    off_centre = elements.eccentric.shape[0] > 0
    for el in range(elements.nodes.shape[0]):
        for i in range(4):
            node, director = elements.nodes[el, i], elements.directors[el, i]
            for c in range(3):
                v[i, c], w[i, c] = velocity[node, c], start.p_dot[director, c]
                X[i, c] = motion.x[node, c] + motion.x_low[node, c]
                q[i, c] = start.p[director, c]
        mass, rotary = elements.mass[el], elements.rotary[el]
        for i in range(4):
            px, py, pz, wx, wy, wz, lumped, turned = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for j in range(4):
                m_ij, I_ij = mass[i, j], rotary[i, j]
                lumped += m_ij
                turned += I_ij
                px += m_ij * v[j, 0]
                py += m_ij * v[j, 1]
                pz += m_ij * v[j, 2]
                wx += I_ij * w[j, 0]
                wy += I_ij * w[j, 1]
                wz += I_ij * w[j, 2]
            if off_centre:
                for j in range(4):
                    c_ij = elements.eccentric[el, i, j]
                    px += c_ij * w[j, 0]
                    py += c_ij * w[j, 1]
                    pz += c_ij * w[j, 2]
                    wx += c_ij * v[j, 0]
                    wy += c_ij * v[j, 1]
                    wz += c_ij * v[j, 2]
            kinetic += 0.5 * (v[i, 0] * px + v[i, 1] * py + v[i, 2] * pz)
            kinetic += 0.5 * (w[i, 0] * wx + w[i, 1] * wy + w[i, 2] * wz)
            linear[0] += px
            linear[1] += py
            linear[2] += pz
            angular[0] += X[i, 1] * pz - X[i, 2] * py + q[i, 1] * wz - q[i, 2] * wy
            angular[1] += X[i, 2] * px - X[i, 0] * pz + q[i, 2] * wx - q[i, 0] * wz
            angular[2] += X[i, 0] * py - X[i, 1] * px + q[i, 0] * wy - q[i, 1] * wx
            for c in range(3):
                d, f = (c + 1) % 3, (c + 2) % 3
                printed[c] += (lumped * (X[i, d] * v[i, f] - X[i, f] * v[i, d])
                               + turned * (q[i, d] * w[i, f] - q[i, f] * w[i, d]))
    return kinetic, linear, angular, printed


@internal
def _momentum_scales(nodal_mass, x, v):
    """``sum m |v|`` and ``sum m |x - x_c| |v|`` with lumped nodal masses, x_c the mass centre."""
    centre = np.zeros(3)
    total = 0.0
    for i in range(x.shape[0]):
        total += nodal_mass[i]
        for c in range(3):
            centre[c] += nodal_mass[i] * x[i, c]
    for c in range(3):
        centre[c] /= total
    linear, angular = 0.0, 0.0
    for i in range(x.shape[0]):
        speed, arm = 0.0, 0.0
        for c in range(3):
            speed += v[i, c] * v[i, c]
            arm += (x[i, c] - centre[c]) ** 2
        linear += nodal_mass[i] * np.sqrt(speed)
        angular += nodal_mass[i] * np.sqrt(speed * arm)
    return linear, angular


@kernel
def resultant(start, x, delta, part, forces):
    """Force and moment about the origin (6,) of the nodal forces at ``x + part delta``.

    Args:
        start: (n_nodes,) first dof of each node.
        x: (n_nodes, 3) [m].
        delta: (n_dof,) increment.
        part: of it.
        forces: (n_dof,) generalized [N]; those on rotational variables are left out.
    """
    total, at, f = np.zeros(6), np.empty(3), np.empty(3)
    for i in range(len(start)):
        for c in range(3):
            at[c] = x[i, c] + part * delta[start[i] + c]
            f[c] = forces[start[i] + c]
            total[c] += f[c]
        total[3] += at[1] * f[2] - at[2] * f[1]
        total[4] += at[2] * f[0] - at[0] * f[2]
        total[5] += at[0] * f[1] - at[1] * f[0]
    return total


@kernel
def stress_at(operator, start, element, row):
    """Forces, moments and von Mises stresses of an element.

    Args:
        operator: (23, n_s + 11) of its measures (e, b): n, m, q, and at top, middle and bottom five
            numbers each whose norm is the von Mises stress.
        start: ``Start``.
        element: its number.
        row: (11,) to be filled: n, m, q, von Mises stresses.
    """
    e, b = start.e[element], start.b[element]
    for k in range(operator.shape[0]):
        value = 0.0
        for j in range(len(e)):
            value += operator[k, j] * e[j]
        for j in range(len(b)):
            value += operator[k, len(e) + j] * b[j]
        if k < 8:
            row[k] = value
        else:
            level = 8 + (k - 8) // 5
            row[level] = value**2 + (row[level] if (k - 8) % 5 else 0.0)
    for level in range(8, 11):
        row[level] = np.sqrt(row[level])
