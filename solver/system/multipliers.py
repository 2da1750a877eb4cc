"""Constraints with multipliers, solved for together with the increment of a step.

With ``g(q_1) = 0`` and forces ``-G_m^T l`` along midpoint gradients a step conserves energy and
momenta, but nothing keeps the rates ``G v`` at zero: they alternate and grow (measured on a rigid
link: 0.2 m/s of 4 within 10 s).  Therefore the rates at both ends of a step get an impulse each,

    v_0' = v_0 + M^-1 G_0^T L_0^-T n,   v_1 = v_1' - M^-1 G_1^T L_1^-T n,   L L^T = G M^-1 G^T,

with the same n at both ends, chosen so that ``G_1 v_1 = 0``.  As ``G_0 v_0 = 0`` the first adds
``n . n / 2`` to the energy and the second takes it away, exactly; both have no resultant and no
moment.  The scheme stays symmetric in time and of second order.
"""

import numpy as np
from scipy.linalg import solve_triangular
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

from ..errors import InputError
from ..kernels import multipliers
from ..kernels.arguments import Terms
from ..kernels.calls import Call
from ..model.bodies import GROUND
from ..model.joints import names_of
from ..model.linkages import (
    LINKED,
    Ball,
    Cylindrical,
    Prismatic,
    Revolute,
    RigidLink,
    Tie,
    Universal,
)

DEPENDENT = 1e-9
"""Smallest eigenvalue of the constraints' scaled matrix ``G M^-1 G^T`` below which they depend on
each other."""

ALONG = 1e-6
"""Sine of the angle between directions that are one, and distance, in sizes of the shell, of places
that are."""

CLOSED = 2e-14
"""Part of the size of its vectors by which a constraint may be off."""


class _Rows:
    """Constraints of the joints and bodies of a model, as vectors and pairs of them."""

    def __init__(self, model, n_rot, frames):
        self._model, self._n_rot, self._frames = model, n_rot, frames
        first = len(model.nodes) - len(model.bodies)
        self._node_of = {body.name: first + k for k, body in enumerate(model.bodies)}
        self.vectors, self.pairs, self.owners = [], [], []
        for k, (name, joint) in enumerate(zip(names_of(model.joints), model.joints)):
            if isinstance(joint, LINKED):
                self._name, self._owner = name, k
                _ROWS[type(joint)](self, joint)
        for k, body in enumerate(model.bodies):
            self._name, self._owner = f"body {body.name}", len(model.joints) + k
            for i in body.nodes:
                self._carry(body, i)

    def _node(self, end):
        return self._node_of[end] if isinstance(end, str) else end

    def _point(self, end, place):
        """The point of an end at a place."""
        if end == GROUND:
            return place, []
        i = self._node(end)
        arm = place - self._model.nodes[i]
        if self._n_rot[i] == 2:  # its node, see ``check_linked``
            arm = np.zeros(3)
        return np.zeros(3), [(i, 1.0, self._frames[i] @ arm)]

    def _vector(self, end, direction):
        """A direction that an end takes along; of a smooth node its normal."""
        if end == GROUND:
            return np.array(direction), []
        i = self._node(end)
        if self._n_rot[i] == 2:
            p = self._model.normals[self._model.directors.first[i]]
            if np.linalg.norm(np.cross(p, direction)) > ALONG:
                raise InputError(f"{self._name}: node {i} of a shell has a normal only, along "
                                 f"{np.round(p, 6).tolist()}, the axis must be along it")
        return np.zeros(3), [(i, 0.0, self._frames[i] @ direction)]

    def _across(self, end, axis):
        """Two directions at right angles to an axis that an end takes along; of a smooth node,
        whose axis is its normal, those of its frame."""
        if end != GROUND and self._n_rot[self._node(end)] == 2:
            self._vector(end, axis)
            i = self._node(end)
            return [(np.zeros(3), [(i, 0.0, e)]) for e in np.eye(3)[:2]]
        side = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
        side /= np.linalg.norm(side)
        return [self._vector(end, side), self._vector(end, np.cross(axis, side))]

    def _axes(self, *ends):
        """Three directions of an end, of a body or a junction if one is."""
        turning = [end for end in ends if end != GROUND]
        i = self._node(max(turning, key=lambda end: self._n_rot[self._node(end)]))
        return [(np.zeros(3), [(i, 0.0, e)]) for e in np.eye(3)]

    def _add(self, u, w):
        self.pairs.append((len(self.vectors), len(self.vectors) + 1))
        self.vectors.extend([u, w])
        self.owners.append(self._owner)

    def _meet(self, joint, axes=None):
        """The points of both ends coincide, along some directions."""
        place = joint.place(self._model.nodes)
        apart = _difference(*(self._point(end, place) for end in joint.ends))
        for axis in axes or self._axes(*joint.ends):
            self._add(axis, apart)

    def _align(self, joint):
        """The axes of both ends are one."""
        for side in self._across(joint.one, joint.axis):
            self._add(side, self._vector(joint.other, joint.axis))

    def _ball(self, joint):
        self._meet(joint)

    def _revolute(self, joint):
        self._meet(joint)
        self._align(joint)

    def _universal(self, joint):
        self._meet(joint)
        self._add(self._vector(joint.one, joint.axis),
                  self._vector(joint.other, joint.other_axis))

    def _cylindrical(self, joint):
        self._meet(joint, self._across(joint.one, joint.axis))
        self._align(joint)

    def _prismatic(self, joint):
        self._cylindrical(joint)
        side = np.cross(joint.axis, np.eye(3)[np.argmin(np.abs(joint.axis))])
        self._add(self._vector(joint.one, side / np.linalg.norm(side)),
                  self._vector(joint.other, np.cross(joint.axis, side) / np.linalg.norm(side)))

    def _link(self, joint):
        nodes, places = self._model.nodes, (joint.at, joint.to)
        points = []
        for end, place in zip(joint.ends, places):
            if place is None and end == GROUND:
                raise InputError(f"{self._name}: its point of the ground is missing (at is that of "
                                 "one, to that of the other)")
            own = None if end == GROUND else nodes[self._node(end)]
            points.append(own if place is None or not isinstance(end, str) else np.array(place))
        rod = _difference(*(self._point(end, at) for end, at in zip(joint.ends, points)))
        if np.linalg.norm(points[1] - points[0]) < ALONG * self._model.size:
            raise InputError(f"{self._name}: both points are at {points[0].tolist()}")
        self._add(rod, rod)

    def _tie(self, joint):
        x, first, p = self._model.nodes, self._model.directors.first, self._model.normals
        line = np.array(joint.line)
        for i in joint.nodes:
            k, part, gap = _on_line(x[i], x[line])
            if gap > ALONG * self._model.size:
                raise InputError(f"{self._name}: node {i} lies {gap:.3g} m beside the line")
            ends, shares = line[k:k + 2], (1.0 - part, part)
            for j in (i, *ends):
                if self._n_rot[j] != 2:
                    raise InputError(f"{self._name}: several plates meet at node {j}")
            apart = np.zeros(3), [(i, 1.0, np.zeros(3)),
                                  *((j, -share, np.zeros(3)) for j, share in zip(ends, shares))]
            normal = np.zeros(3), [(j, 0.0, share * (self._frames[j] @ p[first[j]]))
                                   for j, share in zip(ends, shares)]
            mean = sum(share * p[first[j]] for j, share in zip(ends, shares))
            if np.linalg.norm(np.cross(p[first[i]], mean)) > ALONG:
                raise InputError(f"{self._name}: the normal of node {i} is not that of the line")
            axes = self._axes(i)
            for axis in axes:
                self._add(axis, apart)
            for axis in axes[:2]:
                self._add(axis, normal)

    def _carry(self, body, i):
        """Node i moves and turns with a body."""
        x, first = self._model.nodes[i], self._model.directors.first[i]
        apart = _difference(self._point(body.name, x), self._point(i, x))
        axes = self._axes(body.name)
        for axis in axes:
            self._add(axis, apart)
        if self._n_rot[i] == 2:
            normal = self._vector(body.name, self._model.normals[first])
            for side in self._axes(i)[:2]:
                self._add(side, normal)
        else:
            own = [self._vector(i, direction) for direction in body.directions]
            for r, c in ((0, 1), (0, 2), (1, 2)):
                self._add(own[r], axes[c])

    def terms(self):
        """``Terms`` of all vectors."""
        parts = [terms for _, terms in self.vectors]
        return Terms(np.cumsum([0, *map(len, parts)]),
                     np.array([constant for constant, _ in self.vectors]).reshape(-1, 3),
                     np.array([i for part in parts for i, _, _ in part], dtype=np.int64),
                     np.array([alpha for part in parts for _, alpha, _ in part], dtype=float),
                     np.array([b for part in parts for *_, b in part], dtype=float).reshape(-1, 3))


_ROWS = {Ball: _Rows._ball, Revolute: _Rows._revolute, Universal: _Rows._universal,
         Cylindrical: _Rows._cylindrical, Prismatic: _Rows._prismatic, RigidLink: _Rows._link,
         Tie: _Rows._tie}


def _difference(one, other):
    """The vector from one point to the other."""
    return other[0] - one[0], other[1] + [(i, -alpha, -b) for i, alpha, b in one[1]]


def _on_line(place, line):
    """Number of the segment of a polyline (n, 3) that a place is nearest to, the part of it before
    that, and the distance."""
    along, arms = np.diff(line, axis=0), place - line[:-1]
    part = np.clip(np.sum(arms * along, axis=1) / np.sum(along**2, axis=1), 0.0, 1.0)
    gaps = np.linalg.norm(arms - part[:, None] * along, axis=1)
    k = int(np.argmin(gaps))
    return k, float(part[k]), float(gaps[k])


class Multipliers:
    """The constraints of a model in the exact scheme.

    Attributes:
        dofs: (n_local,) unknowns on which constraints depend.
        forces: (m,) multipliers of the last iterate.
        owners: (m,) number of the joint, or of the body after all joints, of each constraint.
    """

    def __init__(self, system):
        model, numbering, coordinates = system.model, system.numbering, system.coordinates
        rows = _Rows(model, numbering.n_rot, coordinates.initial_frames)
        self.owners, self._model = np.array(rows.owners, dtype=np.int64), model
        self._pairs = np.array(rows.pairs, dtype=np.int64).reshape(-1, 2)
        self._terms, m = rows.terms(), len(rows.pairs)
        self._nodes = np.unique(self._terms.node)
        n_rot, start = numbering.n_rot, numbering.start
        sizes = 3 + n_rot[self._nodes]
        self._local = np.full(len(model.nodes), -1)
        self._local[self._nodes] = np.cumsum(sizes) - sizes
        self.dofs = np.concatenate([np.zeros(0, dtype=np.int64), *(
            start[i] + np.arange(3 + n_rot[i]) for i in self._nodes)])
        self._n_rot, self._free = n_rot, coordinates.free
        self._turning = np.ones(len(self.dofs), dtype=bool)
        self._turning[(self._local[self._nodes][:, None] + np.arange(3)).ravel()] = False
        n_vectors, n_terms = 2 * m, len(self._terms.node)
        self._u, self._d = np.zeros((2, n_vectors, 3)), np.zeros((2, n_terms, 3))
        self._turns, self._no_turns = np.zeros((2, len(model.nodes), 3))
        self._G = np.zeros((4, m, len(self.dofs)))
        self._place, self._gradients = Call(multipliers.carry), Call(multipliers.gradients)
        self.forces, self._n = np.zeros(m), np.zeros(m)
        if m:
            self._inverse = _inverse_mass(system, self.dofs)
            self._inverse_here = self._inverse[self.dofs]
            self._set_values(coordinates)

    def __bool__(self):
        return len(self.owners) > 0

    def _set_values(self, coordinates):
        """Products of the initial configuration; constraints must be independent there."""
        X, rest = self._model.nodes, np.zeros_like(self._model.nodes)
        frames = coordinates.initial_frames
        u = self._u[0]
        self._place(self._terms, X, rest, rest, frames, u, self._d[0])
        one, other = self._pairs.T
        self._values = np.sum(u[one] * u[other], axis=1)
        lengths = np.linalg.norm(u, axis=1)
        moving = np.zeros(len(u), dtype=bool)
        moving[np.repeat(np.arange(len(u)), np.diff(self._terms.first))] = self._terms.alpha != 0.0
        scale = np.where(moving, np.maximum(lengths, self._model.size), 1.0)
        self._scale = scale[one] * scale[other]
        self._gradients(self._terms, self._pairs, self._local, self._n_rot, frames,
                        self._no_turns, u, self._d[0], self._G[0])
        self._check(self._mobility(self._G[0]))

    def _mobility(self, G):
        """``G M^-1 G^T`` (m, m)."""
        return G @ self._inverse_here @ G.T

    def _check(self, S):
        names = [*names_of(self._model.joints), *(f"body {b.name}" for b in self._model.bodies)]
        diagonal = np.diag(S)
        if np.any(diagonal <= 0.0):
            name = names[self.owners[np.argmin(diagonal)]]
            raise InputError(f"{name}: supports hold what it joins already")
        scale = 1.0 / np.sqrt(diagonal)
        sizes, modes = np.linalg.eigh(scale[:, None] * S * scale)
        if sizes[0] < DEPENDENT:
            count = int(np.sum(sizes < DEPENDENT))
            shares = np.abs(modes[:, :count]).max(axis=1)
            involved = sorted({names[k] for k in self.owners[shares > 0.1]})
            raise InputError(f"{', '.join(involved)}: {count} of their constraints follow from the "
                             "others: leave out a joint, or take one that holds less")

    def begin(self, state):
        """Start a step from a ``state``: no forces yet."""
        self.forces[:] = self._n[:] = 0.0
        self._place(self._terms, state.x, state.x_low, np.zeros_like(state.x), state.chart,
                    self._u[0], self._d[0])
        self._gradients(self._terms, self._pairs, self._local, self._n_rot, state.chart,
                        self._no_turns, self._u[0], self._d[0], self._G[0])
        self._root = _root(self._mobility(self._G[0]))
        self._impulse = solve_triangular(self._root, self._G[0], lower=True).T

    def check_rates(self, state):
        """Raise ``InputError`` for initial velocities that constraints do not allow."""
        self.begin(state)
        rates = self._G[0] @ state.velocity[self.dofs]
        sizes = np.abs(self._G[0]) @ np.abs(state.velocity[self.dofs])
        k = int(np.argmax(np.abs(rates) - 1e-9 * sizes))
        if abs(rates[k]) > 1e-9 * sizes[k]:
            names = [*names_of(self._model.joints),
                     *(f"body {body.name}" for body in self._model.bodies)]
            raise InputError(f"{names[self.owners[k]]}: the initial velocities of what it joins do "
                             "not fit together (rigid_velocity gives those of a rigid motion)")

    def add_forces(self, iterate, work, forces):
        """Add the forces of the constraints, and of the impulses, at an iterate to ``forces``
        (n_dof,); ``work``: ``SpinWork``."""
        state, step, delta = iterate[:3]
        u, d = self._u, self._d
        self._turn(state.chart, delta)
        self._place(self._terms, state.x, state.x_low, work.dx, work.frames, u[1], d[1])
        means = self._G[1:], 0.5 * (u[0] + u[1]), 0.5 * (d[0] + d[1])
        for G, frames, turns, at, arms in (
                (self._G[1], state.chart, self._no_turns, *means[1:]),
                (self._G[2], state.chart, self._turns, u[1], d[1])):
            self._gradients(self._terms, self._pairs, self._local, self._n_rot, frames, turns, at,
                            arms, G)
        one, other = self._pairs.T
        self.off = np.sum(u[1][one] * u[1][other], axis=1) - self._values
        rates = 2.0 * step.rate_delta * delta[self.dofs] - state.velocity[self.dofs]
        self._n[:], _ = self._rates_end(work.frames, rates)
        forces[self.dofs] += self._impulses(state.chart, work.frames, step.rate_delta)
        forces[self.dofs] -= self._G[1].T @ self.forces

    def _turn(self, frames, delta):
        """Cayley vectors of the nodes, from their components."""
        th = delta[self.dofs]
        for i in self._nodes:
            at = self._local[i] + 3
            if self._n_rot[i] == 2:
                self._turns[i] = th[at] * frames[i, 1] - th[at + 1] * frames[i, 0]
            else:
                self._turns[i] = th[at:at + 3] @ frames[i]

    def _rates_end(self, frames, rates):
        """n by which ``G_1 v_1 = 0``, and L_1^-1 G_1, of rates (n_local,) without impulses."""
        G = self._G[3]
        self._gradients(self._terms, self._pairs, self._local, self._n_rot, frames,
                        self._no_turns, self._u[1], self._d[1], G)
        root = _root(self._mobility(G))
        return (np.linalg.solve(G @ self._inverse_here @ self._impulse + root, G @ rates),
                solve_triangular(root, G, lower=True))

    def _impulses(self, before, after, rate):
        """(n_local,) forces of the impulse at the start, which also is one at the end: ``2 a/dt``,
        ``(a_l + sum_k b_l0 . b_k1 a_k)/dt`` on turns."""
        a = self._impulse @ self._n
        found = 2.0 * rate * a
        for i in self._nodes:
            at = slice(self._local[i] + 3, self._local[i] + 3 + self._n_rot[i])
            b_0, b_1 = (_basis(frames[i], self._n_rot[i]) for frames in (before, after))
            found[at] = rate * (a[at] + b_0 @ (b_1.T @ a[at]))
        return found

    def closed(self):
        """Whether the constraints hold, but for what the next correction mends."""
        return bool(np.all(np.abs(self.off) <= np.sqrt(CLOSED) * self._scale))

    def columns(self):
        """(m, n_dof) rows of ``G_m``, what supports leave free."""
        rows = np.zeros((len(self.owners), len(self._inverse)))
        rows[:, self.dofs] = self._G[1]
        return [self._free(row) for row in rows]

    def split(self, moved, columns):
        """Changes of the multipliers for a correction ``moved`` (n_local,) without them, of which
        each takes off ``columns`` (n_local, m)."""
        D = self._G[2]
        change = np.linalg.solve(D @ columns, D @ moved + self.off)
        self.forces += change
        return change

    def settle(self, state):
        """Rates of a ``state`` at the end of a converged step that keep the constraints."""
        self._place(self._terms, state.x, state.x_low, np.zeros_like(state.x), state.chart,
                    self._u[1], self._d[1])
        n, end = self._rates_end(state.chart, state.velocity[self.dofs])
        state.velocity[:] -= self._inverse @ (self._impulse @ n + end.T @ n)


def _basis(frame, n_rot):
    """(n_rot, 3) rows b_k, see ``kernels.spins``."""
    return frame if n_rot == 3 else np.stack([frame[1], -frame[0]])


def _root(S):
    """Lower triangular L with ``L L^T = S``, scaled first."""
    scale = np.sqrt(np.diag(S))
    return scale[:, None] * np.linalg.cholesky(S / np.outer(scale, scale))


def _inverse_mass(system, dofs):
    """(n_dof, n_local) columns of the inverse mass at some unknowns, of what supports leave free;
    turns have the lumped inertia of the exact scheme."""
    model, numbering, coordinates = system.model, system.numbering, system.coordinates
    start, n_rot, first = numbering.start, numbering.n_rot, model.directors.first
    quads, masses = model.quads, model.elements.mass
    rows, columns, values = [], [], []
    for c in range(3):
        rows.append(start[np.repeat(quads, 4, axis=1).ravel()] + c)
        columns.append(start[np.tile(quads, (1, 4)).ravel()] + c)
        values.append(masses.ravel())
        for node, mass in model.body_masses:
            rows.append([start[node] + c])
            columns.append([start[node] + c])
            values.append([mass])
    body, inertia = coordinates.nodes.body, coordinates.inertia
    for i in range(len(model.nodes)):
        at, n = np.arange(first[i], first[i + 1]), n_rot[i]
        J = sum(inertia[d] * (np.eye(3) - np.outer(body[d], body[d])) for d in at)
        J = np.array([[J[1, 1], -J[1, 0]], [-J[0, 1], J[0, 0]]]) if n == 2 else J
        rows.append(start[i] + 3 + np.repeat(np.arange(n), n))
        columns.append(start[i] + 3 + np.tile(np.arange(n), n))
        values.append(J.ravel())
    M = coo_array((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
                  shape=(numbering.n_dof,) * 2).tocsc()
    if coordinates.constraints:
        T = coordinates.constraints.T
    else:
        free = np.flatnonzero(~coordinates.fixed)
        T = coo_array((np.ones(len(free)), (free, np.arange(len(free)))),
                      shape=(numbering.n_dof, len(free))).tocsr()
    reduced = splu((T.T @ M @ T).tocsc())
    return T @ reduced.solve(T.T[:, dofs].toarray())
