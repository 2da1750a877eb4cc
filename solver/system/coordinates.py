"""Coordinates: from the unknowns of a step to positions and normals (x, p), and back.

The element and its mass are functions of (x, p) alone.  What a scheme solves for is an increment of
coordinates: it places the directors and gives their derivatives, takes forces on (x, p) back to the
unknowns, and moves a state.  ``Charts`` are the paper's vectorial rotational variables; compiled
code goes through ``kernels.nodes``.
"""

import numpy as np
from scipy.sparse import eye_array
from scipy.spatial.transform import Rotation

from ..errors import InputError
from ..kernels import nodes, updates
from ..kernels.arguments import DONE, Nodes
from ..kernels.calls import Call
from ..kernels.hinges import SLACK
from ..model.joints import places_of
from .constraints import constraints
from .failure import NotConverged
from .state import blank_state

AXES = ("nodal", "global")
"""Axes of the rotational variables: following each node, or global ones (the paper's)."""

STILL = 1e-9
"""Velocity in an oblique direction, relative to the largest, that is none."""


class Charts:
    """Vectorial rotational variables in charts, Eqs. (5), (11).

    Attributes:
        nodes: ``arguments.Nodes``.
        kept: (n_nodes, 3) axis along which the component of the normal must stay a variable, zero
            for none.
        fixed: (n_dof,) bool, held by a support.
        constraints: ``Constraints``, None where every unknown is held or free by itself.
        frames: (n_nodes, 3, 3) rows e_x, e_y, e_z of nodal frames of the model, Eq. (12).
    """

    def __init__(self, model, numbering, follow=True):
        self._follow, self._normals = follow, model.normals
        self.kept, self.fixed = model.kept.copy(), _fixed(model, numbering)
        self.frames = _first_frames(model)
        owner = np.repeat(np.arange(len(model.nodes)), np.diff(model.directors.first))
        self.nodes = Nodes(numbering.start, numbering.n_rot, model.directors.first,
                           np.einsum("dij,dj->di", self.frames[owner], model.normals))
        self.constraints = constraints(model, numbering, self.fixed)
        self._translations, self._numbering = numbering.translations, numbering
        self._place, self._rates = Call(nodes.place_directors), Call(nodes.director_rates)
        self._advance, self._accept = Call(nodes.advance_nodes), Call(updates.accept)
        self._switch = Call(nodes.switch_charts)

    def initial_state(self, model, start=None):
        """State at t = 0, but for U_ddot, which is zero: of the ``model``, or a configuration
        ``start`` with its rates.

        Raises:
            InputError: a supported component has an initial velocity.
        """
        state = self.blank_state(model)
        p, velocity, rates = model.normals, model.velocity, model.normal_velocity
        if start is not None:
            state.x[:] += start.displacement
            p, velocity, rates = start.directors, start.velocity, start.director_rates
            if start.hinges is not None:
                state.hinges[:, :SLACK] = start.hinges
        state.velocity[self._translations] = velocity
        self._set_rotations(model, state, p, rates)
        if self.constraints:
            self.constraints.follow(state)
        moving = np.abs(state.velocity - self.free(state.velocity))
        still = STILL * np.abs(state.velocity).max() if self.constraints else 0.0
        if np.any(moving > still):
            node = self._numbering.node_of_dof[np.argmax(moving)]
            raise InputError(f"node {node}: initial velocity of a supported component must be "
                             "zero")
        state.velocity[:] = self.free(state.velocity)
        return state

    def blank_state(self, model):
        """A state of zeros."""
        return blank_state(model.nodes, self._numbering.n_dof, n_hinges=places_of(model.joints))

    def _set_rotations(self, model, state, p, rates):
        """Charts, variables and their rates of the normals p with these rates."""
        frames = turned_frames(self.frames, model.directors.first, model.normals, p)
        nodes.start_charts(self.nodes, self.kept, p, rates, frames, state.variables, state.chart,
                           state.velocity)

    def increment_to(self, state, i, turn):
        """Increments of the rotational variables of node i by which it comes to where ``turn``, a
        ``Rotation``, takes it from its initial place, Eqs. (5), (11)."""
        triad, n_rot = state.chart[i], self.nodes.n_rot[i]
        if n_rot == 2:
            there = triad[:2] @ turn.apply(self._normals[self.nodes.first[i]].copy())
        else:
            _, e_y, e_z = turn.apply(self.frames[i])
            there = np.array([triad[0] @ e_y, triad[1] @ e_y, triad[0] @ e_z])
        return there - state.variables[i, :n_rot]

    def free(self, vector):
        """A vector (n_dof,) without what supports hold of it."""
        free = np.where(self.fixed, 0.0, vector)
        return self.constraints.project(free) if self.constraints else free

    def basis(self):
        """T (n_dof, n_free), sparse, with orthonormal columns: ``dU = T dU_free``."""
        if self.constraints:
            return self.constraints.T
        return eye_array(len(self.fixed), format="csr")[:, ~self.fixed]

    def place(self, state, start):
        """Directors, derivatives and rates of ``state`` into ``start``.

        Raises:
            NotConverged: a normal has left its chart.
        """
        lost = self._place(self.nodes, state.variables, state.chart, start.p, start.A1)
        if lost != DONE:
            raise NotConverged(f"the normal of node {lost} has left its chart")
        self._rates(self.nodes, state.velocity, start.A1, start.p_dot)

    def advance(self, state, start, step, delta, work):
        """Directors of an iterate into ``work``.

        Raises:
            NotConverged: a normal leaves its chart.
        """
        node = self._lost(state, start, step, np.ascontiguousarray(delta, dtype=float), work)
        if node != DONE:
            raise NotConverged(self.lost(node))

    def inside(self, state, start, step, delta, work):
        """Whether every normal is still in its chart at the end of the increment ``delta``."""
        delta = np.ascontiguousarray(delta, dtype=float)
        return self._lost(state, start, step, delta, work) == DONE

    def _lost(self, state, start, step, delta, work):
        """The first node whose directors cannot be placed, or ``DONE``."""
        return self._advance(self.nodes, state.motion, step, delta, work)

    @staticmethod
    def lost(node):
        """What happened where the directors of a ``node`` cannot be placed."""
        return f"a normal of node {node} leaves the chart of its variables"

    def change_of_directors(self, start, increment):
        """``A1 dn`` (n_directors, 3) of a small increment (n_dof,) at a ``Start``."""
        change = np.zeros_like(start.p)
        self._rates(self.nodes, increment, start.A1, change)
        return change

    def velocity(self, state):
        """Velocities of the nodes (n_nodes, 3) [m/s]."""
        return state.velocity[self._translations]

    def accept(self, state, end, delta):
        """Move ``state`` by the increment of a converged step."""
        self._accept(self.nodes, end, np.ascontiguousarray(delta, dtype=float), state.motion)

    def renew(self, state, dt):
        """Renew the axes for the next step of length ``dt``; how many global ones switched."""
        switched = self._switch(self.nodes, self.kept, self._follow, dt, state.motion)
        if self.constraints:
            self.constraints.follow(state)
        return switched

    def correct(self, state, start, correction):
        """Move a static state: nodes by displacements, normals along great circles."""
        nodes.turn_normals(self.nodes, self.kept, correction, state.variables, state.chart,
                           start.p, start.A1)
        if self.constraints:
            self.constraints.follow(state)
        updates.move_nodes(self.nodes.start, correction, state.x, state.x_low)

    def largest_turn(self, start, correction):
        """Largest angle [rad] by which a correction turns a normal."""
        return nodes.largest_turn(self.nodes, correction, start.A1)


def _first_frames(model):
    """(n_nodes, 3, 3) rows e_x, e_y, e_z of nodal frames: along the global axes, of a junction that
    turns about one axis only e_x along it, and of a slave those of its master, turned."""
    frames = np.tile(np.eye(3), (len(model.nodes), 1, 1))
    for i in np.flatnonzero(model.kept.any(axis=1) & (np.diff(model.directors.first) > 1)):
        e_x = model.kept[i]
        e_y = np.cross(np.eye(3)[np.argmin(np.abs(e_x))], e_x)
        e_y /= np.linalg.norm(e_y)
        frames[i] = e_x, e_y, np.cross(e_x, e_y)
    if model.pairs:
        frames[model.pairs.slaves] = frames[model.pairs.masters] @ model.pairs.rotation.T
    return frames


def turned_frames(frames, first, before, p):
    """Nodal frames of junctions turned as their directors from ``before`` to p, by least
    squares."""
    frames = frames.copy()
    for i in np.flatnonzero(np.diff(first) > 1):
        members = slice(first[i], first[i + 1])
        turn, _ = Rotation.align_vectors(p[members], before[members])
        frames[i] = frames[i] @ turn.as_matrix().T
    return frames


def _fixed(model, numbering):
    """(n_dof,) bool, what supports hold by itself.

    Two fixed components of a unit normal fix it altogether.  A single one is the first rotational
    variable of a smooth node; at a junction, which turns about its axis e_x only, n and k are held.
    """
    mask, fixed = model.fixed, np.zeros(numbering.n_dof, dtype=bool)
    kept = model.kept.any(axis=1)
    for i in np.flatnonzero(mask.any(axis=1) | kept):
        first = numbering.start[i]
        fixed[first:first + 3] = mask[i, :3]
        turning = fixed[first + 3:first + 3 + numbering.n_rot[i]]
        if kept[i]:
            turning[::2] = True
        elif mask[i, 3:].any():
            turning[:] = True
    return fixed
