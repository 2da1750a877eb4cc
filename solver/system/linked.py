"""Constraints of a model's joints and bodies, and the angles of its revolute joints, at a state."""

import numpy as np

from ..errors import InputError
from ..kernels import hinges, multipliers
from ..kernels.arguments import Links, Spans
from ..kernels.calls import Call
from ..kernels.hinges import moments
from ..model.bodies import GROUND
from ..model.joints import names_of
from ..model.linkages import Tie
from .rows import Rows
from .turning import nearest

DEPENDENT = 1e-9
"""Smallest eigenvalue of the constraints' scaled matrix ``G M^-1 G^T`` below which they depend on
each other."""

MOST_NAMED = 4
"""Nodes of supports that a message names."""

CLOSED = 1e-7
"""Part of the size of its vectors by which a constraint may be off before the last correction,
which squares it."""


class Linked:
    """Rows are constraints, products of vectors; then driven angles; then the moments of revolute
    joints.

    Attributes:
        dofs: (n_local,) unknowns on which constraints depend.
        forces: (m,) multipliers l of the last iterate.
        owners: (m,) number of the joint, or of the body after all joints, of each row.
        off: (m,) by how much each is missed in the last iterate.
    """

    def __init__(self, system, frames):
        """``frames``: (n_nodes, 3, 3) of the initial configuration."""
        model, numbering = system.model, system.numbering
        self._n_dof = numbering.n_dof
        self._rows_of = rows = Rows(model, numbering.n_rot, frames)
        self._model, self._free = model, system.coordinates.free
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
        self._held = system.coordinates.fixed[self.dofs]
        self._links = self._make_links()
        self._values = self._links.values
        n_terms = len(self._terms.node)
        self._u, self._d = np.zeros((3, len(rows.vectors), 3)), np.zeros((3, n_terms, 3))
        self._rest, self._weights = np.zeros_like(model.nodes), np.zeros(len(self._pairs))
        self._place, self._gradients = Call(multipliers.carry), Call(multipliers.gradients)
        self._weigh, self._moments = Call(multipliers.weigh), Call(moments)
        self.forces, self.off = np.zeros((2, m))

    def _make_links(self):
        """``Links``, their values to be filled."""
        m, count = self._m, len(self.owners)
        rows = np.concatenate([np.arange(m), np.repeat(np.arange(m, count), 2)])
        first, spans = self._terms.first, [set() for _ in range(count)]
        for row, pair in zip(rows, self._pairs):
            for k in pair:
                spans[row].update(self._terms.node[first[k]:first[k + 1]].tolist())
        node = np.array([i for span in spans for i in sorted(span)], dtype=np.int64)
        begin = self._local[node]
        return Links(self._terms, self._pairs, rows, np.zeros(m), self._nodes, self._local,
                     self._n_rot, self.dofs, Spans(np.cumsum([0, *map(len, spans)]), node, begin,
                                                   begin + 3 + self._n_rot[node]))

    def __bool__(self):
        return len(self.owners) > 0

    def _set_values(self, frames):
        """Products of the initial configuration; the gradients there."""
        X, rest, u, d = self._model.nodes, self._rest, self._u[0], self._d[0]
        self._place(self._terms, X, rest, rest, frames, u, d)
        one, other = self._pairs[:self._m].T
        self._values[:] = np.sum(u[one] * u[other], axis=1)
        lengths = np.linalg.norm(u, axis=1)
        moving = np.zeros(len(u), dtype=bool)
        owner = np.repeat(np.arange(len(u)), np.diff(self._terms.first))
        moving[owner[self._terms.alpha != 0.0]] = True
        scale = np.where(moving, np.maximum(lengths, self._model.size), 1.0)
        self._scale = np.concatenate([scale[one] * scale[other],
                                      np.ones(len(self.owners) - self._m)])
        self._initial = self._angles(u)
        self._weigh(self._links, u, self._weights)
        G = np.zeros((len(self.owners), len(self.dofs)))
        self._gradients(self._links, self._weights, frames, rest, u, d, G)
        return G

    def _products(self, u):
        """Cosines and sines of the angles."""
        one, other = self._pairs[self._m:].T
        return np.sum(u[one] * u[other], axis=1).reshape(-1, 2).T

    def _angles(self, u):
        """(k,) angles, in (-pi, pi]."""
        c, s = self._products(u)
        return np.arctan2(s, c)

    def _check(self, S):
        names, diagonal = self._names(), np.diag(S)
        if np.any(diagonal <= 0.0):
            raise InputError(f"{names[self.owners[np.argmin(diagonal)]]}: supports hold what it "
                             "joins already")
        scale = 1.0 / np.sqrt(diagonal)
        sizes, modes = np.linalg.eigh(scale[:, None] * S * scale)
        if len(sizes) and sizes[0] < DEPENDENT:
            count = int(np.sum(sizes < DEPENDENT))
            rows = np.flatnonzero(np.abs(modes[:, :count]).max(axis=1) > 0.1)
            involved = [*sorted({names[k] for k in self.owners[rows]}), *self._supports_of(rows)]
            raise InputError(f"{', '.join(involved)}: {count} of their constraints follow from the "
                             "others: leave out one, or take one that holds less")

    def _supports_of(self, rows):
        """The supports of nodes that some rows depend on, in words."""
        spans = self._links.spans
        of_rows = [s for k in rows for s in range(spans.first[k], spans.first[k + 1])]
        nodes = sorted({int(spans.node[s]) for s in of_rows
                        if self._held[spans.begin[s]:spans.end[s]].any()})
        if nodes:
            yield f"the support{'s' * (len(nodes) > 1)} of node{'s' * (len(nodes) > 1)} " + (
                ", ".join(map(str, nodes[:MOST_NAMED])) + ", ..." * (len(nodes) > MOST_NAMED))

    def _names(self):
        """Of joints, then of bodies."""
        return [*names_of(self._model.joints), *(f"body {b.name}" for b in self._model.bodies)]

    def _frames_at(self, state, start):
        """(n_nodes, 3, 3) frames of nodes at a ``state`` and its ``Start``."""
        return state.chart

    def follow(self, state, start):
        """Angles of a ``state`` and its ``Start``."""
        if len(self._places):
            self._place(self._terms, state.x, state.x_low, self._rest,
                        self._frames_at(state, start), self._u[1], self._d[1])
            at = self._places, hinges.ANGLE
            state.hinges[at] = nearest(self._angles(self._u[1]) - self._initial, state.hinges[at])

    def closed(self):
        """Whether the constraints hold, but for what the next correction mends."""
        return bool(np.all(np.abs(self.off) <= CLOSED * self._scale))

    def about_axes(self):
        """(n_joints,) moments that turn joints on, of drives too [N m]."""
        return np.bincount(self.owners[self._m:], -self.forces[self._m:], len(self._model.joints))

    def ground(self):
        """The same of all joints to the ground, together."""
        grounded = [k for k, joint in enumerate(self._model.joints) if GROUND in joint.ends]
        parts = [self.on(k) for k in grounded] or [np.zeros((2, 3))]
        return tuple(np.sum(parts, axis=0))

    def late(self):
        """(n_dof,) forces that impulses have beside those in the residual; none in equilibrium."""
        return np.zeros(self._n_dof)

    def _end_of(self, number):
        """Nodes of the end on which a joint's force is told."""
        joint = self._model.joints[number]
        if isinstance(joint, Tie):
            return joint.nodes
        end = joint.one if joint.other == GROUND else joint.other
        return [self._rows_of.node(end)]
