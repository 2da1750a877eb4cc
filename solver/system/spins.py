"""Coordinates of the exact scheme: nodes turn by Cayley vectors; see ``kernels.spins``."""

import numpy as np
from scipy.spatial.transform import Rotation

from ..kernels import spins
from ..kernels.calls import Call
from ..kernels.junctions import spin_of
from ..model.joints import places_of
from .coordinates import Charts, turned_frames
from .state import blank_state


class Spins(Charts):
    """As ``Charts``, but the charts of a state are the frames of its nodes, in which the directors
    are constant, and a smooth node's normal is the third axis; all variables are zero.

    Attributes:
        inertia: (n_directors,) lumped at the normals [kg m^2].
        initial_frames: (n_nodes, 3, 3) of the initial configuration.
    """

    def __init__(self, model, numbering, inertia):
        super().__init__(model, numbering)
        self.inertia = inertia
        first, normals = model.directors.first, model.normals
        self._smooth = np.flatnonzero(numbering.n_rot == 2)
        self._junctions = np.flatnonzero(numbering.n_rot == 3)
        frames = self.frames.copy()
        for i in self._junctions[self.kept[self._junctions].any(axis=1)]:
            frames[i] = frames[i, [2, 0, 1]]  # it turns about t_2 alone
        frames[self._smooth] = frames_along(normals[first[self._smooth]], self.kept[self._smooth])
        if model.pairs:
            frames[model.pairs.slaves] = frames[model.pairs.masters] @ model.pairs.rotation.T
        self.initial_frames = frames
        owner = np.repeat(np.arange(len(model.nodes)), np.diff(first))
        self.nodes = self.nodes._replace(body=np.einsum("dij,dj->di", frames[owner], normals))
        self._place, self._advance = Call(spins.place), Call(spins.advance)
        self._accept, self._predict = Call(spins.accept), Call(spins.predict)
        self._largest_turn = Call(spins.largest_turn)

    def blank_state(self, model):
        """A state of zeros."""
        return blank_state(model.nodes, self._numbering.n_dof, len(model.quads),
                           places_of(model.joints))

    def _set_rotations(self, model, state, p, rates):
        """Frames and spins of the normals p with these rates."""
        first, smooth, at = model.directors.first, self._smooth, self._numbering.start + 3
        state.chart[:] = turned_frames(self.initial_frames, first, self._normals, p)
        d = first[smooth]
        if not np.array_equal(p, self._normals):
            state.chart[smooth] = frames_along(p[d], self.kept[smooth])
        spin = np.cross(p[d], rates[d])
        state.velocity[at[smooth]] = np.sum(state.chart[smooth, 1] * spin, axis=1)
        state.velocity[at[smooth] + 1] = -np.sum(state.chart[smooth, 0] * spin, axis=1)
        omega = np.empty(3)
        for i in self._junctions:
            d = first[i]
            spin_of(p[d], p[d + 1], rates[d], rates[d + 1], omega)
            state.velocity[at[i]:at[i] + 3] = state.chart[i] @ omega

    def place(self, state, start):
        """Directors, derivatives and rates of ``state`` into ``start``."""
        self._place(self.nodes, state.chart, start.p, start.A1)
        self._rates(self.nodes, state.velocity, start.A1, start.p_dot)

    def _lost(self, state, start, step, delta, work):
        return self._advance(self.nodes, self.inertia, state.motion, start, step, delta, work)

    @staticmethod
    def lost(node):
        """What happened where the directors of a ``node`` cannot be placed."""
        return f"node {node} turns too far"

    def predict(self, mass, state, place, dt, free, again):
        """Increment (n_dof,) that the iteration of a step starts from, see ``spins.predict``."""
        delta, observed = np.empty(self._numbering.n_dof), place.observed
        self._predict(self.nodes, mass, state.motion, place.start, dt, free, again,
                      observed.linear_momentum, observed.angular_momentum, delta)
        return self.free(delta)

    def size_of_turn(self, correction):
        """Largest turn of a node [rad] by a small correction."""
        return self._largest_turn(self.nodes, correction)

    def accept(self, state, end, delta):
        """Move ``state`` by the increment of a converged step."""
        self._accept(self.nodes, end, np.ascontiguousarray(delta, dtype=float), state.motion)

    def renew(self, state, dt):
        """Frames follow by themselves, those of the slaves of a sector their masters'."""
        if self.constraints:
            self.constraints.follow(state)
        return 0

    def increment_to(self, state, i, turn):
        """Increments of the rotational variables of node i by which it comes to where ``turn``, a
        ``Rotation``, takes it from its initial place."""
        frame, d = state.chart[i], self.nodes.first[i]
        if self.nodes.n_rot[i] == 2:
            p, goal = self.nodes.body[d] @ frame, turn.apply(self._normals[d].copy())
            th = np.cross(p, goal) * (2.0 / (1.0 + p @ goal))
            return np.array([frame[1] @ th, -(frame[0] @ th)])
        vector = (turn * Rotation.from_matrix(self.initial_frames[i].T)
                  * Rotation.from_matrix(frame)).as_rotvec()
        angle = np.linalg.norm(vector)
        return frame @ (vector * (2.0 * np.tan(0.5 * angle) / angle if angle > 0.0 else 1.0))


def frames_along(p, kept):
    """(n, 3, 3) rows t_1, t_2, t_3 of smooth nodes with the normals p (n, 3): t_3 = p, or, where a
    support keeps the component along an axis ``kept`` (n, 3), t_1 that axis and t_3 as near to p
    as it can be."""
    held = kept.any(axis=1)[:, None]
    t_1 = np.eye(3)[np.argmin(np.abs(p), axis=1)]
    t_1 = np.where(held, kept, t_1 - np.sum(t_1 * p, axis=1, keepdims=True) * p)
    t_1 = t_1 / np.linalg.norm(t_1, axis=1, keepdims=True)
    t_3 = np.where(held, p - np.sum(p * t_1, axis=1, keepdims=True) * t_1, p)
    t_3 = t_3 / np.linalg.norm(t_3, axis=1, keepdims=True)
    return np.stack([t_1, np.cross(t_3, t_1), t_3], axis=1)
