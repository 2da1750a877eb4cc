"""Constraints of joints and bodies as rows: vectors that move with nodes, and pairs of them.

See ``kernels.multipliers`` for what a vector and a constraint are.
"""

import numpy as np

from ..errors import InputError
from ..kernels.arguments import Terms
from ..model.bodies import GROUND, own_nodes
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

ALONG = 1e-6
"""Sine of the angle between directions that are one, and distance, in sizes of the shell, of places
that are."""


class Rows:
    """Constraints of the joints and bodies of a model, as vectors and pairs of them."""

    def __init__(self, model, n_rot, frames):
        self._model, self._n_rot, self._frames = model, n_rot, frames
        self._node_of = own_nodes(model)
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


_ROWS = {Ball: Rows._ball, Revolute: Rows._revolute, Universal: Rows._universal,
         Cylindrical: Rows._cylindrical, Prismatic: Rows._prismatic, RigidLink: Rows._link,
         Tie: Rows._tie}


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
