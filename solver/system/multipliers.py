"""Constraints with multipliers, solved for together with the increment of a step.

With ``g(q_1) = 0`` and forces ``-G_m^T l`` along midpoint gradients a step conserves energy and
momenta, but nothing keeps the rates ``G v`` at zero: they alternate and grow (measured on a rigid
link: 0.2 m/s of 4 within 10 s).  Therefore the rates at both ends of a step get an impulse each,

    v_0' = v_0 + M^-1 G_0^T L_0^-T n,   v_1 = v_1' - M^-1 G_1^T L_1^-T n,   L L^T = G M^-1 G^T,

with the same n at both ends, chosen so that ``G_1 v_1 = 0``.  As ``G_0 v_0 = 0`` the first adds
``n . n / 2`` to the energy and the second takes it away, exactly; both have no resultant and no
moment.  The scheme stays symmetric in time and of second order.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

from ..checks import TINY
from ..errors import InputError
from ..kernels import hinges, multipliers
from ..kernels.arguments import Terms
from ..kernels.calls import Call
from ..kernels.hinges import moments
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
from .damping import consistent_mass
from .driven import INSTANT
from .failure import NotConverged
from .turning import nearest

DEPENDENT = 1e-9
"""Smallest eigenvalue of the constraints' scaled matrix ``G M^-1 G^T`` below which they depend on
each other."""

ALONG = 1e-6
"""Sine of the angle between directions that are one, and distance, in sizes of the shell, of places
that are."""

CLOSED = 1e-7
"""Part of the size of its vectors by which a constraint may be off before the last correction,
which squares it."""

SETTLED = 1e-13
"""Part of the energy that the last correction of a drive's moment may change its work by."""

RATES = 1e-9
"""Part of the rates of single nodes by which initial velocities may violate a constraint."""

SMALL = 1e-8
"""Sine of a change of angle below which its ratio to the sine is one."""

LEAST = 1e-12
"""Stiffness of a moment, in those of inertia, below which it is a given one."""


class _Rows:
    """Constraints of the joints and bodies of a model, as vectors and pairs of them."""

    def __init__(self, model, n_rot, frames):
        self._model, self._n_rot, self._frames = model, n_rot, frames
        first = len(model.nodes) - len(model.bodies)
        self._node_of = {body.name: first + k for k, body in enumerate(model.bodies)}
        self.vectors, self.pairs, self.owners, self.angles = [], [], [], []
        for k, (name, joint) in enumerate(zip(names_of(model.joints), model.joints)):
            if isinstance(joint, LINKED):
                self._name, self._owner = name, k
                _ROWS[type(joint)](self, joint)
        for k, body in enumerate(model.bodies):
            self._name, self._owner = f"body {body.name}", len(model.joints) + k
            for i in body.nodes:
                self._carry(body, i)

    def node(self, end):
        """Number of the node of an end."""
        return self._node_of[end] if isinstance(end, str) else end

    def _point(self, end, place):
        """The point of an end at a place."""
        if end == GROUND:
            return place, []
        i = self.node(end)
        arm = place - self._model.nodes[i]
        if self._n_rot[i] == 2:  # its node, see ``check_linked``
            arm = np.zeros(3)
        return np.zeros(3), [(i, 1.0, self._frames[i] @ arm)]

    def _vector(self, end, direction):
        """A direction that an end takes along; of a smooth node its normal."""
        if end == GROUND:
            return np.array(direction), []
        i = self.node(end)
        if self._n_rot[i] == 2:
            p = self._model.normals[self._model.directors.first[i]]
            if np.linalg.norm(np.cross(p, direction)) > ALONG:
                raise InputError(f"{self._name}: node {i} of a shell has a normal only, along "
                                 f"{np.round(p, 6).tolist()}, the axis must be along it")
        return np.zeros(3), [(i, 0.0, self._frames[i] @ direction)]

    def _across(self, end, axis):
        """Two directions at right angles to an axis that an end takes along; of a smooth node,
        whose axis is its normal, those of its frame."""
        if end != GROUND and self._n_rot[self.node(end)] == 2:
            self._vector(end, axis)
            i = self.node(end)
            return [(np.zeros(3), [(i, 0.0, e)]) for e in np.eye(3)[:2]]
        side = _side(axis)
        return [self._vector(end, side), self._vector(end, np.cross(axis, side))]

    def _axes(self, *ends):
        """Three directions of an end, of a body or a junction if one is."""
        turning = [end for end in ends if end != GROUND]
        i = self.node(max(turning, key=lambda end: self._n_rot[self.node(end)]))
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
        if joint.places:
            for end in joint.ends:
                if end != GROUND and self._n_rot[self.node(end)] == 2:
                    raise InputError(f"{self._name}: node {self.node(end)} of a shell does not "
                                     "know turns about its normal, a moment or an angle needs "
                                     "bodies")
            across = self._across(joint.one, joint.axis)
            arm = self._vector(joint.other, _side(joint.axis))
            self.angles.append((self._owner, arm, *across))

    def _universal(self, joint):
        self._meet(joint)
        self._add(self._vector(joint.one, joint.axis),
                  self._vector(joint.other, joint.other_axis))

    def _cylindrical(self, joint):
        self._meet(joint, self._across(joint.one, joint.axis))
        self._align(joint)

    def _prismatic(self, joint):
        self._cylindrical(joint)
        side = _side(joint.axis)
        self._add(self._vector(joint.one, side),
                  self._vector(joint.other, np.cross(joint.axis, side)))

    def _link(self, joint):
        nodes, places = self._model.nodes, (joint.at, joint.to)
        points = []
        for end, place in zip(joint.ends, places):
            if place is None and end == GROUND:
                raise InputError(f"{self._name}: its point of the ground is missing (at is that of "
                                 "one, to that of the other)")
            own = None if end == GROUND else nodes[self.node(end)]
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

    def measures(self):
        """Pairs of vectors whose products are the cosine and the sine of each angle."""
        pairs = []
        for _, arm, *across in self.angles:
            for side in across:
                pairs.append((len(self.vectors), len(self.vectors) + 1))
                self.vectors.extend([side, arm])
        return pairs

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


def _side(axis):
    """A direction at right angles to an axis."""
    side = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    return side / np.linalg.norm(side)


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


class Rates(NamedTuple):
    """What drives do in a step.

    Attributes:
        angle: (k,) angles at its end [rad].
        before: (k,) their rates at its start [rad/s].
        after: (k,) at its end [rad/s].
    """

    angle: np.ndarray
    before: np.ndarray
    after: np.ndarray


class Multipliers:
    """The constraints of a model in the exact scheme, and the moments of its revolute joints.

    Rows are constraints, products of vectors; then driven angles; then the moments, as constraints
    that give way: ``-l = M(angle)``.

    Attributes:
        dofs: (n_local,) unknowns on which constraints depend.
        forces: (m,) multipliers l of the last iterate.
        owners: (m,) number of the joint, or of the body after all joints, of each row.
        off: (m,) by how much each is missed in the last iterate.
    """

    def __init__(self, system):
        model, numbering, coordinates = system.model, system.numbering, system.coordinates
        self._rows_of = rows = _Rows(model, numbering.n_rot, coordinates.initial_frames)
        self._model, self._free = model, coordinates.free
        self._turnings = system.turnings
        driven = [angle for angle in rows.angles if model.joints[angle[0]].angle is not None]
        soft = [angle for angle in rows.angles if model.joints[angle[0]].angle is None]
        rows.angles = driven + soft
        self._driven = [model.joints[angle[0]] for angle in driven]
        self.owners = np.array([*rows.owners, *(angle[0] for angle in rows.angles)], dtype=np.int64)
        self._m, m = len(rows.pairs), len(self.owners)
        self._hard = self._m + len(driven)
        place_of = {joint: k for k, joint in enumerate(system.turnings.joints.tolist())}
        self._places = np.array([place_of[angle[0]] for angle in rows.angles], dtype=np.int64)
        self._pairs = np.array(rows.pairs + rows.measures(), dtype=np.int64).reshape(-1, 2)
        self._terms = rows.terms()
        self._nodes = np.unique(self._terms.node)
        self._n_rot, start = numbering.n_rot, numbering.start
        sizes = 3 + self._n_rot[self._nodes]
        self._local = np.full(len(model.nodes), -1)
        self._local[self._nodes] = np.cumsum(sizes) - sizes
        self.dofs = np.concatenate([np.zeros(0, dtype=np.int64), *(
            start[i] + np.arange(3 + self._n_rot[i]) for i in self._nodes)])
        n_terms = len(self._terms.node)
        self._u, self._d = np.zeros((2, len(rows.vectors), 3)), np.zeros((2, n_terms, 3))
        self._turns, self._no_turns = np.zeros((2, len(model.nodes), 3))
        self._raw = np.zeros((len(self._pairs), len(self.dofs)))
        self._place, self._gradients = Call(multipliers.carry), Call(multipliers.gradients)
        self._turn, self._spread = Call(multipliers.turns), Call(multipliers.spread)
        self._moments = Call(moments)
        self.forces, self.off, self._give = np.zeros((3, m))
        self._n = np.zeros(self._hard)
        self._drive, self._moved = (0.0, 0.0), np.zeros(self._hard - self._m)
        if m:
            self._inverse = _inverse_mass(system, self.dofs)
            self._inverse_here = self._inverse[self.dofs]
            self._set_values(coordinates)

    def __bool__(self):
        return len(self.owners) > 0

    @property
    def drives(self):
        """Numbers of the joints that are driven."""
        return self.owners[self._m:self._hard]

    def _set_values(self, coordinates):
        """Products of the initial configuration; constraints must be independent there."""
        X, rest = self._model.nodes, np.zeros_like(self._model.nodes)
        u = self._u[0]
        self._place(self._terms, X, rest, rest, coordinates.initial_frames, u, self._d[0])
        one, other = self._pairs[:self._m].T
        self._values = np.sum(u[one] * u[other], axis=1)
        lengths = np.linalg.norm(u, axis=1)
        moving = np.zeros(len(u), dtype=bool)
        owner = np.repeat(np.arange(len(u)), np.diff(self._terms.first))
        moving[owner[self._terms.alpha != 0.0]] = True
        scale = np.where(moving, np.maximum(lengths, self._model.size), 1.0)
        self._scale = np.concatenate([scale[one] * scale[other],
                                      np.ones(len(self.owners) - self._m)])
        self._initial = self._angles(u)
        G = self._rows(coordinates.initial_frames, u, self._d[0], *self._weights(u))
        self._check(self._mobility(G[:self._hard]))

    def _products(self, u):
        """Cosines and sines of the angles."""
        one, other = self._pairs[self._m:].T
        return np.sum(u[one] * u[other], axis=1).reshape(-1, 2).T

    def _angles(self, u):
        """(k,) angles, in (-pi, pi]."""
        c, s = self._products(u)
        return np.arctan2(s, c)

    def _weights(self, u):
        """Factors of dc and ds in the change of each angle, ``(c ds - s dc) / (c^2 + s^2)``."""
        c, s = self._products(u)
        return -s / (c**2 + s**2), c / (c**2 + s**2)

    def _mean_weights(self):
        """The same in a step, where that is exact, and the change: see ``kernels.hinges``."""
        (c_0, s_0), (c_1, s_1) = self._products(self._u[0]), self._products(self._u[1])
        sine, cosine = c_0 * s_1 - s_0 * c_1, c_0 * c_1 + s_0 * s_1
        if np.any(cosine <= 0.0):
            raise NotConverged("a joint turns too far")
        change = np.arctan2(sine, cosine)
        ratio = np.divide(change, sine, where=np.abs(sine) > SMALL, out=1.0 / cosine)
        return -0.5 * ratio * (s_0 + s_1), 0.5 * ratio * (c_0 + c_1), change

    def _rows(self, frames, u, d, on_c, on_s, turns=None):
        """Gradients (m, n_local) of all rows; ``on_c``, ``on_s``: of angles in their cosines and
        sines."""
        self._gradients(self._terms, self._pairs, self._local, self._n_rot, frames,
                        self._no_turns if turns is None else turns, u, d, self._raw)
        c, s = self._raw[self._m::2], self._raw[self._m + 1::2]
        return np.concatenate([self._raw[:self._m], on_c[:, None] * c + on_s[:, None] * s])

    def _mobility(self, G):
        """``G M^-1 G^T``"""
        return G @ self._inverse_here @ G.T

    def _check(self, S):
        names, diagonal = self._names(), np.diag(S)
        if np.any(diagonal <= 0.0):
            raise InputError(f"{names[self.owners[np.argmin(diagonal)]]}: supports hold what it "
                             "joins already")
        scale = 1.0 / np.sqrt(diagonal)
        sizes, modes = np.linalg.eigh(scale[:, None] * S * scale)
        if len(sizes) and sizes[0] < DEPENDENT:
            count = int(np.sum(sizes < DEPENDENT))
            shares = np.abs(modes[:, :count]).max(axis=1)
            involved = sorted({names[k] for k in self.owners[:self._hard][shares > 0.1]})
            raise InputError(f"{', '.join(involved)}: {count} of their constraints follow from the "
                             "others: leave out a joint, or take one that holds less")

    def _names(self):
        """Of joints, then of bodies."""
        return [*names_of(self._model.joints), *(f"body {b.name}" for b in self._model.bodies)]

    def driven(self, begin, end, dt):
        """``Rates`` of drives in a step of length dt [s]; ``begin(part)`` and ``end(part)`` give
        ``value(history)`` a ``part`` of dt after its start and its end."""
        def angles(value):
            return np.array([joint.angle * value(joint.driving) for joint in self._driven])

        def rates(at):
            return (angles(at(INSTANT)) - angles(at(-INSTANT))) / (2.0 * INSTANT * dt)

        return Rates(angles(end(0.0)), rates(begin), rates(end))

    def follow(self, state):
        """Angles of a ``state``."""
        if len(self._places):
            self._place(self._terms, state.x, state.x_low, np.zeros_like(state.x), state.chart,
                        self._u[1], self._d[1])
            at = self._places, hinges.ANGLE
            state.hinges[at] = nearest(self._angles(self._u[1]) - self._initial, state.hinges[at])

    def begin(self, state):
        """Start a step from a ``state``: no forces yet."""
        self.forces[:] = 0.0
        u, d = self._u[0], self._d[0]
        self._place(self._terms, state.x, state.x_low, np.zeros_like(state.x), state.chart, u, d)
        self._G_0 = self._rows(state.chart, u, d, *self._weights(u))[:self._hard]
        self._rates_0 = self._G_0[self._m:] @ state.velocity[self.dofs]
        self._root = _root(self._mobility(self._G_0))
        self._impulse = solve_triangular(self._root, self._G_0, lower=True).T

    def check_rates(self, state, driven):
        """Raise ``InputError`` for initial velocities that constraints do not allow; ``driven``:
        ``Rates`` of a step that begins there."""
        self.begin(state)
        rates = self._G_0 @ state.velocity[self.dofs]
        sizes = np.abs(self._G_0) @ np.abs(state.velocity[self.dofs])
        rates[self._m:] -= driven.before
        sizes[self._m:] += np.abs(driven.before) + np.abs(driven.after)
        missed = np.abs(rates) - RATES * sizes
        # what a central difference over ``INSTANT`` misses of a rate that begins with t^2
        missed[self._m:] -= INSTANT**2 * np.abs(driven.after - driven.before)
        k = int(np.argmax(missed))
        if missed[k] > 0.0:
            raise InputError(f"{self._names()[self.owners[k]]}: the initial velocities of what it "
                             "joins do not fit together, or to its drive (rigid_velocity gives "
                             "those of a rigid motion)")

    def add_forces(self, iterate, driven, slacks, motors, work, forces):
        """Add the forces of the constraints, and of the impulses, at an iterate to ``forces``
        (n_dof,).

        Args:
            iterate: ``Iterate``.
            driven: ``Rates``.
            slacks: (n,) angles at which springs are slack at the end [rad].
            motors: (n,) moments of motors [N m].
            work: ``SpinWork`` of it.
            forces: added to.

        Raises:
            NotConverged: a joint turns by a right angle or more in the step.
        """
        state, step, delta = iterate[:3]
        u, d = self._u, self._d
        self._turn(self._nodes, self._local, self._n_rot, state.chart, delta[self.dofs],
                   self._turns)
        self._place(self._terms, state.x, state.x_low, work.dx, work.frames, u[1], d[1])
        *mean, change = self._mean_weights()
        self._G_m = self._rows(state.chart, 0.5 * (u[0] + u[1]), 0.5 * (d[0] + d[1]), *mean)
        self._D = self._rows(state.chart, u[1], d[1], *self._weights(u[1]), self._turns)
        self._miss(state, change, step, driven, slacks, motors)
        rates = 2.0 * step.rate_delta * delta[self.dofs] - state.velocity[self.dofs]
        self._n[:] = self._rates_end(work.frames, rates, driven)
        at = self._nodes
        self._at = (step.rate_delta, state.x[at] + state.x_low[at], work.dx[at].copy(),
                    state.chart[at], work.frames[at])
        spread = np.zeros(len(self.dofs))
        self._spread(self._nodes, self._local, self._n_rot, state.chart, work.frames,
                     step.rate_delta, self._impulse @ self._n, spread)
        forces[self.dofs] += spread - self._G_m.T @ self.forces

    def on(self, number):
        """Force [N] and moment about the origin [N m], (3,) each, of the joint ``number`` on its
        end ``other``, or on ``one`` where the other is the ground.  Means of the step of the
        iterate whose forces were added last: of the multipliers at its middle, and of the impulses
        at both ends."""
        rate, x, dx, before, after = self._at
        rows = 1.0 * (self.owners == number)
        hard = rows[:self._hard]
        first, last = (solve_triangular(root.T, self._n, lower=False)
                       for root in (self._root, self._root_1))
        acting = ((-self._G_m.T @ (rows * self.forces), 0.5),
                  (rate * (self._G_0.T @ (hard * first)), 0.0),
                  (-rate * (self._G_1.T @ (hard * last)), 1.0))
        force, moment = np.zeros((2, 3))
        for i in self._end_of(number):
            j = np.searchsorted(self._nodes, i)
            at, n = self._local[i], self._n_rot[i]
            for f, part in acting:
                axes = before[j] + part * (after[j] - before[j])
                if n == 2:
                    axes = np.stack([axes[1], -axes[0]]) / (axes[2] @ axes[2])
                elif part == 0.5:
                    axes = before[j]
                force += f[at:at + 3]
                moment += np.cross(x[j] + part * dx[j], f[at:at + 3]) + f[at + 3:at + 3 + n] @ axes
        return force, moment

    def about_axes(self):
        """(n_joints,) moments that turn joints on, of drives too [N m]."""
        return np.bincount(self.owners[self._m:], -self.forces[self._m:], len(self._model.joints))

    def ground(self):
        """The same of all joints to the ground, together."""
        grounded = [k for k, joint in enumerate(self._model.joints) if GROUND in joint.ends]
        parts = [self.on(k) for k in grounded] or [np.zeros((2, 3))]
        return tuple(np.sum(parts, axis=0))

    def _end_of(self, number):
        """Nodes of the end on which a joint's force is told."""
        joint = self._model.joints[number]
        if isinstance(joint, Tie):
            return joint.nodes
        end = joint.one if joint.other == GROUND else joint.other
        return [self._rows_of.node(end)]

    def _miss(self, state, change, step, driven, slacks, motors):
        """By how much rows are missed."""
        one, other = self._pairs[:self._m].T
        self.off[:self._m] = np.sum(self._u[1][one] * self._u[1][other], axis=1) - self._values
        n, places = len(self._driven), self._places
        angle = state.hinges[places, hinges.ANGLE] + change
        self.off[self._m:self._hard] = angle[:n] - driven.angle
        self._moved = driven.angle - state.hinges[places[:n], hinges.ANGLE]
        places, found = places[n:], np.empty((len(places) - n, 2))
        if len(places):
            self._moments(self._turnings.constants[places], state.hinges[places], slacks[places],
                          angle[n:], 1.0 - step.alpha_f, step.rate_delta, found)
            stiffness = np.maximum(found[:, 1], LEAST * self._stiff(step))
            self._give[self._hard:] = 1.0 / stiffness
            self.off[self._hard:] = -(found[:, 0] + motors[places]
                                      + self.forces[self._hard:]) / stiffness

    def _stiff(self, step):
        """(k,) what inertia has for a stiffness against the moments [N m/rad]."""
        return step.delta / np.maximum(np.diag(self._mobility(self._D[self._hard:])), TINY)

    def _rates_end(self, frames, rates, driven):
        """n by which ``G_1 v_1`` is what drives want, of rates (n_local,) without impulses."""
        self._G_1 = self._rows(frames, self._u[1], self._d[1], *self._weights(self._u[1]))
        self._G_1 = self._G_1[:self._hard]
        self._root_1 = _root(self._mobility(self._G_1))
        missed = self._G_1 @ rates
        missed[self._m:] -= driven.after
        return np.linalg.solve(self._G_1 @ self._inverse_here @ self._impulse + self._root_1,
                               missed)

    def closed(self, energy):
        """Whether the constraints hold, but for what the next correction mends, and the work of
        drives is settled, for an ``energy`` of the motion [J], or gets no better.

        What is left of the residual does no work where constraints stay, but on what a drive moves.
        """
        change, last = self._drive
        work = np.abs(self.forces[self._m:self._hard] @ self._moved)
        return bool(np.all(np.abs(self.off) <= CLOSED * self._scale) and (
            change <= SETTLED * (energy + work) or change > 0.5 * last))

    def pass_on(self, parts):
        """Add to sizes of forces (n_dof,), whose rounding error the residual has, what joints carry
        of them to other ends, as to bodies, which have no stiffness of their own."""
        G = np.abs(self._G_m)
        largest = (G * parts[self.dofs]).max(axis=1, initial=0.0)
        parts[self.dofs] += (largest / np.maximum(np.sum(G * G, axis=1), TINY)) @ G

    def columns(self):
        """(m, n_dof) rows of ``G_m``, what supports leave free."""
        rows = np.zeros((len(self.owners), len(self._inverse)))
        rows[:, self.dofs] = self._G_m
        return [self._free(row) for row in rows]

    def split(self, moved, columns):
        """Changes of the multipliers for a correction ``moved`` (n_local,) without them, of which
        each takes off ``columns`` (n_local, m)."""
        matrix = self._D @ columns
        matrix[np.diag_indices(len(matrix))] += self._give
        change = np.linalg.solve(matrix, self._D @ moved + self.off)
        self.forces += change
        drives = slice(self._m, self._hard)
        self._drive = np.abs(change[drives]) @ np.abs(self._moved), self._drive[0]
        return change

    def settle(self, state, delta, driven):
        """Rates of a ``state`` at the end of a converged step that keep the constraints; the works
        of the ``drives`` in it [J]."""
        work = -self.forces[self._m:self._hard] * (self._G_m[self._m:self._hard]
                                                   @ delta[self.dofs])
        self._place(self._terms, state.x, state.x_low, np.zeros_like(state.x), state.chart,
                    self._u[1], self._d[1])
        n = self._rates_end(state.chart, state.velocity[self.dofs], driven)
        before, after = (solve_triangular(root.T, n, lower=False)
                         for root in (self._root, self._root_1))
        state.velocity[:] -= self._inverse @ (self._G_0.T @ before + self._G_1.T @ after)
        return work + self._rates_0 * before[self._m:] - driven.after * after[self._m:]


def _root(S):
    """Lower triangular L with ``L L^T = S``, scaled first."""
    scale = np.sqrt(np.diag(S))
    return scale[:, None] * np.linalg.cholesky(S / np.outer(scale, scale))


def _inverse_mass(system, dofs):
    """(n_dof, n_local) columns of the inverse mass at some unknowns, of what supports leave free;
    turns have the lumped inertia of the exact scheme."""
    model, numbering, coordinates = system.model, system.numbering, system.coordinates
    start, n_rot, first = numbering.start, numbering.n_rot, model.directors.first
    bodies, body_masses = np.array(model.body_masses).reshape(-1, 2).T
    bodies, mass = bodies.astype(np.int64), consistent_mass(model).tocoo()
    i, j, own = (np.concatenate(parts) for parts in (
        (mass.coords[0], bodies), (mass.coords[1], bodies), (mass.data, body_masses)))
    rows = [start[i] + c for c in range(3)]
    columns = [start[j] + c for c in range(3)]
    values = [own] * 3
    b = coordinates.nodes.body
    J = np.add.reduceat(coordinates.inertia[:, None, None] * (
        np.eye(3) - b[:, :, None] * b[:, None, :]), first[:-1])
    for n, axes in ((2, np.array([[0, 1, 0], [-1, 0, 0]])), (3, np.eye(3))):  # see ``spins.basis``
        at = np.flatnonzero(n_rot == n)
        dofs_of = start[at][:, None] + 3 + np.arange(n)
        rows.append(np.repeat(dofs_of, n, axis=1).ravel())
        columns.append(np.tile(dofs_of, (1, n)).ravel())
        values.append((axes @ J[at] @ axes.T).ravel())
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
