"""Constraints of joints and bodies at a state, in the rotational variables of nodes.

A vector ``u = c + sum (alpha x_i + d)`` changes by ``J dq = sum (alpha dx_i + th_i x d)`` with the
spins ``th = W dn`` of nodes, and a product of two by ``dg = w . J_u dq + u . J_w dq``.
"""

import numpy as np

from .linked import Linked
from .spins import frames_along
from .state import blank_place

ON, BEYOND = np.array([1, 2, 0]), np.array([2, 0, 1])
"""The axes that follow each."""


class ChartRows(Linked):
    """As ``Linked``, with gradients in the unknowns of ``Charts``."""

    def __init__(self, system):
        coordinates, numbering, model = system.coordinates, system.numbering, system.model
        self._coordinates = coordinates
        self._first, self._normals = model.directors.first, model.normals
        smooth = numbering.n_rot == 2
        frames, p = coordinates.frames.copy(), model.normals[self._first[:-1][smooth]]
        frames[smooth] = frames_along(p, 0.0 * p)
        super().__init__(system, frames)
        self._initial_frames, self._frames = frames, frames.copy()
        self._smooth = self._nodes[numbering.n_rot[self._nodes] == 2]
        self._junctions = self._nodes[numbering.n_rot[self._nodes] == 3]
        self._spins = np.zeros((len(model.nodes), 3, 3))
        self._parts = self._parts_of_rows()
        self._initial_rows = self._set_values(frames)
        self._start = blank_place(system.elements, len(model.normals)).start
        self._at_state(coordinates.initial_state(model))

    def _at_state(self, state):
        """Vectors, gradients and angles of a state."""
        self._coordinates.place(state, self._start)
        self._at(state, self._start, self._rest)

    def _parts_of_rows(self):
        """(row, term, other vector) of all terms of both vectors of each product."""
        first, found = self._terms.first, []
        for one, other in (self._pairs.T, self._pairs.T[::-1]):
            counts = first[one + 1] - first[one]
            row = np.repeat(np.arange(len(one)), counts)
            term = np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts - first[one], counts)
            found.append((row, term, other[row]))
        return [np.concatenate(part) for part in zip(*found)]

    def _turn(self, p, A1=None):
        """Frames of nodes with normals p, and with their derivatives A1 the spins by which
        variables turn them; of smooth nodes without those about the normals, on which no
        constraint that holds depends."""
        i, d = self._smooth, self._first[self._smooth]
        before, now = self._normals[d], p[d]
        self._frames[i] = _least_turned(self._initial_frames[i], before, now)
        j, e = self._junctions, self._first[self._junctions]
        turn = np.swapaxes(_triads(self._normals[e], self._normals[e + 1]), 1, 2) @ _triads(
            p[e], p[e + 1])
        self._frames[j] = self._initial_frames[j] @ turn
        if A1 is not None:
            self._spins[i] = _cross(now[:, None], np.swapaxes(A1[d], 1, 2))
            self._spins[i, 2] = 0.0
            self._spins[j] = _spins(p[e][:, None], p[e + 1][:, None],
                                    np.swapaxes(A1[e], 1, 2), np.swapaxes(A1[e + 1], 1, 2))

    def _frames_at(self, state, start):
        self._turn(start.p)
        return self._frames

    def _at(self, state, work, dx):
        """Vectors, gradients and angles at a state, moved by dx, whose normals are in ``work``."""
        self._turn(work.p, work.A1)
        self._x = state.x + state.x_low + dx
        u, d = self._u[1], self._d[1]
        self._place(self._terms, state.x, state.x_low, dx, self._frames, u, d)
        self._J = self._jacobian(d)
        one, other = self._pairs.T
        raw = (np.einsum("rc,rcn->rn", u[other], self._J[one])
               + np.einsum("rc,rcn->rn", u[one], self._J[other]))
        self._weigh(self._links, u, self._weights)
        turned = (self._weights[:, None] * raw)[self._m:]
        self._G = np.concatenate([raw[:self._m], turned[::2] + turned[1::2]])
        self.off[:self._m] = np.sum(u[one] * u[other], axis=1)[:self._m] - self._values

    def _jacobian(self, d):
        """J (n_vectors, 3, n_local) of all vectors, with the d of their terms."""
        terms = self._terms
        vector = np.repeat(np.arange(len(terms.first) - 1), np.diff(terms.first))
        at, J = self._local[terms.node], np.zeros((len(self._u[1]), 3, len(self.dofs)))
        for c in range(3):
            np.add.at(J, (vector, c, at + c), terms.alpha)
        for k in range(3):
            turns = np.flatnonzero(self._n_rot[terms.node] > k)
            swing = _cross(self._spins[terms.node[turns], k], d[turns])
            for c in range(3):
                np.add.at(J, (vector[turns], c, at[turns] + 3 + k), swing[:, c])
        return J

    def _on_products(self, forces):
        """(n_pairs,) forces on products, of those of rows."""
        return self._weights * forces[self._links.rows]

    def _turning_twice(self, on):
        """(n_nodes, 3, 3) ``(w d^T + d w^T)/2 - w . d`` and (n_nodes, 3) torques ``d x w``, summed
        up with the forces ``on`` products."""
        row, term, other = self._parts
        d, w, i = self._d[1][term], on[row, None] * self._u[1][other], self._terms.node[term]
        n = len(self._model.nodes)
        twice, torques = np.zeros((n, 3, 3)), np.zeros((n, 3))
        outer = 0.5 * (w[:, :, None] * d[:, None] + d[:, :, None] * w[:, None])
        np.add.at(twice, i, outer - np.sum(w * d, axis=1)[:, None, None] * np.eye(3))
        np.add.at(torques, i, _cross(d, w))
        return twice, torques


def _least_turned(frames, before, now):
    """Frames (n, 3, 3) turned by the least turn from the vectors ``before`` to ``now`` (n, 3),
    about their first axis where that is half a turn."""
    cosine = np.sum(before * now, axis=1)
    back = cosine < -1.0 + 1e-9
    v = _cross(before, now)[:, None]
    turned = _cross(v, frames)
    found = frames + turned + _cross(v, turned) / np.where(back, 1.0, 1.0 + cosine)[:, None, None]
    found[back] = frames[back] * np.array([1.0, -1.0, -1.0])[:, None]
    return found


def _triads(a, b):
    """(n, 3, 3) rows: unit vectors a, across b, and normal to both."""
    normal = _cross(a, b)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    return np.stack([a, _cross(normal, a), normal], axis=1)


def _spins(a, b, da, db):
    """Spins that turn the unit vectors a and b by da and db."""
    spin, cosine = _cross(a, da), np.sum(a * b, axis=-1, keepdims=True)
    about = np.sum(db * _cross(a, b), axis=-1, keepdims=True)
    about = (about + cosine * np.sum(spin * b, axis=-1, keepdims=True)) / (1.0 - cosine**2)
    return spin + about * a


def _cross(a, b):
    """As ``np.cross`` of rows, which takes four times as long for few of them (measured)."""
    return a.take(ON, -1) * b.take(BEYOND, -1) - a.take(BEYOND, -1) * b.take(ON, -1)
