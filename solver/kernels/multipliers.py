"""Constraints between bodies, each a product of two vectors that move with them.

A vector ``u = c + sum (alpha x_i + R_i b)`` is made of places x_i and of vectors ``R_i b`` that
are constant in the frames R_i of nodes; a constraint is ``g = u . w - c = 0``.  As u and w are
linear in places and directors, ``g_1 - g_0 = u_m . dw + w_m . du`` exactly, with means u_m, w_m:
forces ``-G_m^T l`` along this gradient do no work where g stays zero, and because a dot product is
blind to rigid motions they have no resultant and no moment.

In a step of the exact scheme forces stand at its middle and impulses at both ends,

    v_0' = v_0 + M^-1 G_0^T L_0^-T n,   v_1 = v_1' - M^-1 G_1^T L_1^-T n,   L L^T = G M^-1 G^T,
    (G_1 M^-1 G_0^T L_0^-T + L_1) n = G_1 v_1' - w,

w what drives want; and with the columns ``Z = K^-1 G_m^T`` a correction is

    (D Z + C) dl = D K^-1 r + g,   d = K^-1 r - Z dl.

Gradients are stored as full rows, and only what they depend on is touched.
"""

import math

import numpy as np

from . import gauss
from .arguments import DONE
from .jit import internal, kernel
from .spins import basis
from .vectors import cross, dot

SMALL = 1e-8
"""Sine of a change of angle below which its ratio to the sine is one."""


@kernel
def carry(terms, x, x_low, dx, frames, u, d):
    """Vectors u (n, 3) at places ``x + x_low + dx`` and with ``frames``, and d (n_terms, 3), the
    ``R_i b`` of their terms.

    Args:
        terms: ``Terms``.
        x, x_low, dx: (n_nodes, 3) [m].
        frames: (n_nodes, 3, 3) rows.
        u, d: to be filled.
    """
    for k in range(u.shape[0]):
        for c in range(3):
            u[k, c] = terms.constant[k, c]
            for t in range(terms.first[k], terms.first[k + 1]):
                i = terms.node[t]
                d[t, c] = (terms.body[t, 0] * frames[i, 0, c] + terms.body[t, 1] * frames[i, 1, c]
                           + terms.body[t, 2] * frames[i, 2, c])
                u[k, c] += d[t, c] + terms.alpha[t] * ((x[i, c] + dx[i, c]) + x_low[i, c])


@internal
def _product(pairs, k, u):
    """The k-th product of vectors u."""
    return dot(u[pairs[k, 0]], u[pairs[k, 1]])


@kernel
def weigh(links, u, weights):
    """Factors ``weights`` (n_pairs,) of the changes of the products of vectors u in those of rows:
    1 of constraints, ``-s / (c^2 + s^2)`` and ``c / (c^2 + s^2)`` of an angle's cosine c and sine
    s."""
    m = links.values.shape[0]
    for k in range(m):
        weights[k] = 1.0
    for k in range(m, weights.shape[0], 2):
        c, s = _product(links.pairs, k, u), _product(links.pairs, k + 1, u)
        weights[k], weights[k + 1] = -s / (c * c + s * s), c / (c * c + s * s)


@internal
def _weigh_means(links, u_0, u_1, weights, change):
    """The same of a step between the vectors u_0 and u_1, by which the ``change`` (k,) of each
    angle is exact, see ``hinges``; the first row that turns by a right angle or more."""
    m = links.values.shape[0]
    for k in range(m):
        weights[k] = 1.0
    for k in range(m, weights.shape[0], 2):
        c_0, s_0 = _product(links.pairs, k, u_0), _product(links.pairs, k + 1, u_0)
        c_1, s_1 = _product(links.pairs, k, u_1), _product(links.pairs, k + 1, u_1)
        sine, cosine = c_0 * s_1 - s_0 * c_1, c_0 * c_1 + s_0 * s_1
        if not cosine > 0.0:
            return links.rows[k]
        angle = math.atan2(sine, cosine)
        ratio = angle / sine if abs(sine) > SMALL else 1.0 / cosine
        weights[k], weights[k + 1] = -0.5 * ratio * (s_0 + s_1), 0.5 * ratio * (c_0 + c_1)
        change[links.rows[k] - m] = angle
    return DONE


@kernel
def gradients(links, weights, frames, turns, u, d, G):
    """Rows ``G`` (k, n_local) of the first k constraints and angles, sums of the products'
    ``weights`` times ``alpha w`` on places and ``b_k . q`` with ``q = d x w`` on the turn of a
    node, of each term of u, and the other way round.

    ``turns`` (n_nodes, 3): Cayley vectors th of a step; then columns are derivatives in those of
    vectors at its end, ``b_k . (q + q x th / 2) / (1 + |th|^2 / 4)``.
    """
    terms, pairs, n_rot, spans = links.terms, links.pairs, links.n_rot, links.spans
    q, b, side = np.empty(3), np.empty(3), np.empty(3)
    for row in range(G.shape[0]):
        for span in range(spans.first[row], spans.first[row + 1]):
            for k in range(spans.begin[span], spans.end[span]):
                G[row, k] = 0.0
    for k in range(pairs.shape[0]):
        row, weight = links.rows[k], weights[k]
        if row >= G.shape[0]:
            continue
        for one in range(2):
            carrier, other = pairs[k, one], u[pairs[k, 1 - one]]
            for t in range(terms.first[carrier], terms.first[carrier + 1]):
                i = terms.node[t]
                at, th = links.local[i], turns[i]
                part = weight / (1.0 + 0.25 * dot(th, th))
                cross(d[t], other, q)
                cross(q, th, side)
                for c in range(3):
                    G[row, at + c] += weight * terms.alpha[t] * other[c]
                    q[c] = part * (q[c] + 0.5 * side[c])
                for r in range(n_rot[i]):
                    basis(frames[i], n_rot[i], r, b)
                    G[row, at + 3 + r] += dot(b, q)


@internal
def _turns(links, frames, delta, th):
    """Cayley vectors ``th`` (n_nodes, 3) of the nodes from their components in ``delta`` (n_dof,).
    """
    b = np.empty(3)
    for i in links.nodes:
        at = links.local[i] + 3
        th[i, 0] = th[i, 1] = th[i, 2] = 0.0
        for k in range(links.n_rot[i]):
            basis(frames[i], links.n_rot[i], k, b)
            for c in range(3):
                th[i, c] += delta[links.dofs[at + k]] * b[c]


@internal
def _spread(links, before, after, rate, a, forces):
    """Forces (n_local,) by which an impulse a at the start of a step, which is one at its end too,
    acts: ``2 a / dt``, of turns ``(a_l + sum_k b_l0 . b_k1 a_k) / dt``; ``rate``: 1/dt."""
    b_0, b_1 = np.empty(3), np.empty(3)
    for i in links.nodes:
        at, n = links.local[i], links.n_rot[i]
        for c in range(3):
            forces[at + c] = 2.0 * rate * a[at + c]
        for l in range(n):
            basis(before[i], n, l, b_0)
            total = a[at + 3 + l]
            for k in range(n):
                basis(after[i], n, k, b_1)
                total += dot(b_0, b_1) * a[at + 3 + k]
            forces[at + 3 + l] = rate * total


@internal
def _add(factor, row, total):
    """Add ``factor`` times a row to another one."""
    for k in range(len(total)):
        total[k] += factor * row[k]


@internal
def _times(spans, G, row, x):
    """A row of G times x (n_local,)."""
    total = 0.0
    for span in range(spans.first[row], spans.first[row + 1]):
        for k in range(spans.begin[span], spans.end[span]):
            total += G[row, k] * x[k]
    return total


@internal
def _sum_rows(spans, factors, G, x):
    """``x = G^T factors`` (n_local,)"""
    for k in range(x.shape[0]):
        x[k] = 0.0
    for row in range(G.shape[0]):
        for span in range(spans.first[row], spans.first[row + 1]):
            for k in range(spans.begin[span], spans.end[span]):
                x[k] += factors[row] * G[row, k]


@internal
def _root(spans, G, mobile, moved, root):
    """L of ``L L^T = G M^-1 G^T``, and ``G M^-1``; ``mobile``: M^-1 (n_local, n_local)."""
    moved[:] = 0.0
    for i in range(root.shape[0]):
        for span in range(spans.first[i], spans.first[i + 1]):
            for k in range(spans.begin[span], spans.end[span]):
                _add(G[i, k], mobile[k], moved[i])
        for j in range(i + 1):
            total = _times(spans, G, j, moved[i])
            for k in range(j):
                total -= root[i, k] * root[j, k]
            root[i, j] = math.sqrt(total) if i == j else total / root[j, j]


@internal
def _forward(root, rows, solved):
    """``L^-1`` times rows."""
    solved[:] = rows
    for i in range(root.shape[0]):
        for j in range(i):
            _add(-root[i, j], solved[j], solved[i])
        for k in range(rows.shape[1]):
            solved[i, k] /= root[i, i]


@kernel
def backward(root, x):
    """Overwrite x with ``L^-T x``."""
    for i in range(root.shape[0] - 1, -1, -1):
        x[i] /= root[i, i]
        for j in range(i):
            x[j] -= root[i, j] * x[i]


@kernel
def leave(links, mobile, work):
    """Root, impulses and what they move for the gradients G_0 at the start of a step, whose forces
    are zero."""
    work.forces[:] = 0.0
    _root(links.spans, work.G_0, mobile, work.moved, work.root_0)
    _forward(work.root_0, work.G_0, work.impulse)
    _forward(work.root_0, work.moved, work.kick)


@kernel
def begin(links, mobile, motion, work):
    """Start a step of the exact scheme from a state.

    Args:
        links: ``Links``.
        mobile: (n_local, n_local) inverse mass.
        motion: ``Motion`` of the state.
        work: ``LinkWork``, filled.
    """
    u, d = work.u[0], work.d[0]
    carry(links.terms, motion.x, motion.x_low, work.rest, motion.chart, u, d)
    weigh(links, u, work.weights)
    gradients(links, work.weights, motion.chart, work.rest, u, d, work.G_0)
    leave(links, mobile, work)


@kernel
def end(links, motion, work):
    """Gradients G_1 at a state where a step ends."""
    u, d = work.u[1], work.d[1]
    carry(links.terms, motion.x, motion.x_low, work.rest, motion.chart, u, d)
    weigh(links, u, work.weights)
    gradients(links, work.weights, motion.chart, work.rest, u, d, work.G_1)


@internal
def _measure(links, motion, nodal, delta, rate, work):
    """Vectors, gradients, changes of angles, what is missed of constraints, and rates without
    impulses at the end of an iterate; arguments and result of ``constrain``."""
    u_0, u_1, u, d_0, d_1, d = (work.u[0], work.u[1], work.u[2], work.d[0], work.d[1], work.d[2])
    weights, rest = work.weights, work.rest
    _turns(links, motion.chart, delta, work.turns)
    carry(links.terms, motion.x, motion.x_low, nodal.dx, nodal.frames, u_1, d_1)
    lost = _weigh_means(links, u_0, u_1, weights, work.change)
    if lost != DONE:
        return lost
    _mean(u_0, u_1, u)
    _mean(d_0, d_1, d)
    gradients(links, weights, motion.chart, rest, u, d, work.G_m)
    weigh(links, u_1, weights)
    gradients(links, weights, motion.chart, work.turns, u_1, d_1, work.D)
    gradients(links, weights, nodal.frames, rest, u_1, d_1, work.G_1)
    for k in range(links.values.shape[0]):
        work.off[k] = _product(links.pairs, k, u_1) - links.values[k]
    for k in range(links.dofs.shape[0]):
        at = links.dofs[k]
        work.rates[k] = 2.0 * rate * delta[at] - motion.velocity[at]
    return DONE


@internal
def _mean(before, after, mean):
    """``(a_0 + a_1)/2`` of vectors (n, 3)."""
    for k in range(mean.shape[0]):
        for c in range(3):
            mean[k, c] = 0.5 * (before[k, c] + after[k, c])


@kernel
def rates_missed(links, mobile, rates, wanted, work):
    """The root at the end of a step, and by how much ``G_1 v`` misses what drives want, into n.

    Args:
        links: ``Links``.
        mobile: (n_local, n_local) inverse mass.
        rates: (n_local,) v.
        wanted: (k,) of the last rows.
        work: ``LinkWork``.
    """
    _root(links.spans, work.G_1, mobile, work.moved, work.root_1)
    driven = work.n.shape[0] - wanted.shape[0]
    for i in range(work.n.shape[0]):
        work.n[i] = _times(links.spans, work.G_1, i, rates)
        if i >= driven:
            work.n[i] -= wanted[i - driven]


@kernel
def rates_end(links, mobile, rates, wanted, work):
    """n by which ``G_1 v_1`` is what drives want; arguments of ``rates_missed``, ``rates`` without
    impulses.

    Returns:
        A row that others hold already.
    """
    rates_missed(links, mobile, rates, wanted, work)
    for i in range(work.n.shape[0]):
        for j in range(work.n.shape[0]):
            crossed = _times(links.spans, work.G_1, i, work.kick[j])
            work.ends[i, j] = crossed + work.root_1[i, j]
    return _solve(work.ends, work.exchanges, work.n)


@internal
def _solve(matrix, exchanges, x):
    """Overwrite x with the solution; the first pivot that is zero or not finite."""
    failed = gauss.factor(matrix, exchanges)
    if failed == DONE:
        gauss.solve(matrix, exchanges, x)
    return failed


@kernel
def constrain(links, mobile, motion, nodal, delta, rate, wanted, work, forces):
    """Add the forces of constraints and impulses of an iterate of the exact scheme to ``forces``
    (n_dof,).

    Args:
        links: ``Links``.
        mobile: (n_local, n_local) inverse mass.
        motion: ``Motion`` at the start of the step.
        nodal: ``SpinWork`` of the iterate.
        delta: (n_dof,) increment.
        rate: 1/dt.
        wanted: (k,) rates of drives at the end.
        work: ``LinkWork``.
        forces: added to.

    Returns:
        The first row whose angle changes by a right angle or more, or that others hold already.
    """
    lost = _measure(links, motion, nodal, delta, rate, work)
    if lost == DONE:
        lost = rates_end(links, mobile, work.rates, wanted, work)
    if lost != DONE:
        return lost
    push, spread = work.pushes[0], work.pushes[1]
    push[:] = 0.0
    for i in range(work.n.shape[0]):
        _add(work.n[i], work.impulse[i], push)
    _spread(links, motion.chart, nodal.frames, rate, push, spread)
    _sum_rows(links.spans, work.forces, work.G_m, work.acting)
    for k in range(links.dofs.shape[0]):
        forces[links.dofs[k]] += spread[k] - work.acting[k]
    return DONE


@internal
def _turn_rows(spans, turning, carried, D, turned):
    """``D T``: rows in the axes of a kept matrix, see ``transport``, if it is ``carried``."""
    Q, J = turning.Q, turning.J
    for row in range(D.shape[0]):
        for span in range(spans.first[row], spans.first[row + 1]):
            i, at = spans.node[span], spans.begin[span]
            n = spans.end[span] - at - 3
            for c in range(3 + n):
                turned[row, at + c] = 0.0 if carried else D[row, at + c]
            if not carried:
                continue
            for r in range(3):
                for c in range(3):
                    turned[row, at + c] += D[row, at + r] * Q[i, r, c]
            for r in range(n):
                for c in range(n):
                    turned[row, at + 3 + c] += D[row, at + 3 + r] * J[i, r, c]


@kernel
def split(links, turning, carried, correction, work):
    """Changes of the multipliers for a ``correction`` (n_dof,) without them, which gets them; see
    the module.

    Args:
        links: ``Links``.
        turning: ``Turning`` of the matrix that gave the correction and the columns.
        carried: whether that has been carried along.
        correction: changed.
        work: ``LinkWork``.

    Returns:
        A row that others hold already.
    """
    changes, moved, spans, m = work.changes, work.rates, links.spans, work.changes.shape[0]
    for k in range(moved.shape[0]):
        moved[k] = correction[links.dofs[k]]
    _turn_rows(spans, turning, carried, work.D, work.turned)
    for i in range(m):
        changes[i] = work.off[i] + _times(spans, work.turned, i, moved)
        for j in range(m):
            work.matrix[i, j] = _times(spans, work.turned, i, work.here[j])
        work.matrix[i, i] += work.give[i]
    failed = _solve(work.matrix, work.exchanges, changes)
    if failed != DONE:
        return failed
    for i in range(m):
        work.forces[i] += changes[i]
        _add(-changes[i], work.columns[i], correction)
    work.drive[2], work.drive[1], work.drive[0] = work.drive[1], work.drive[0], 0.0
    for i in range(work.way.shape[0]):
        work.drive[0] += abs(changes[links.values.shape[0] + i]) * abs(work.way[i])
    return DONE
