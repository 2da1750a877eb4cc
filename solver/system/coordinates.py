"""Coordinates: from the unknowns of a step to positions and normals (x, p), and back.

The element and its mass are functions of (x, p) alone.  What a scheme solves for is an increment of
coordinates: it places the directors and gives their derivatives, takes forces on (x, p) back to the
unknowns, and moves a state.  ``Charts`` are the paper's vectorial rotational variables; compiled
code goes through ``kernels.nodes``.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from ..errors import InputError
from ..kernels import nodes, updates
from ..kernels.arguments import DONE, Nodes
from ..kernels.calls import Call
from .failure import NotConverged
from .state import blank_state

AXES = ("nodal", "global")
"""Axes of the rotational variables: following each node, or global ones (the paper's)."""


class Charts:
    """Vectorial rotational variables in charts, Eqs. (5), (11).

    Attributes:
        nodes: ``arguments.Nodes``.
        fixed_component: (n_nodes,) component of the normal that must stay a variable, -1 for none.
        fixed: (n_dof,) bool, held by a support.
    """

    def __init__(self, model, numbering, follow=True):
        self._follow = follow
        # the nodal frame of a junction starts along the global axes, Eq. (12)
        self.nodes = Nodes(numbering.start, numbering.n_rot, model.directors.first,
                           model.normals.copy())
        self.fixed_component, self.fixed = _supports(model, numbering)
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
        state = blank_state(model.nodes, self._numbering.n_dof)
        p, velocity, rates = model.normals, model.velocity, model.normal_velocity
        if start is not None:
            state.x[:] += start.displacement
            p, velocity, rates = start.directors, start.velocity, start.director_rates
        state.velocity[self._translations] = velocity
        nodes.start_charts(self.nodes, self.fixed_component, p, rates,
                           _frames(model.directors.first, model.normals, p), state.variables,
                           state.chart, state.velocity)
        moving = self.fixed & (state.velocity != 0.0)
        if np.any(moving):
            node = self._numbering.node_of_dof[np.argmax(moving)]
            raise InputError(f"node {node}: initial velocity of a supported component must be "
                             "zero")
        return state

    def place(self, state, start):
        """Directors, derivatives and rates of ``state`` into ``start``.

        Raises:
            NotConverged: a normal has left its chart.
        """
        lost = self._place(self.nodes, state.variables, state.chart, start.p, start.A1)
        if lost != DONE:
            raise NotConverged(f"the normal of node {lost} has left its chart")
        self._rates(self.nodes, state.velocity, start.A1, start.p_dot)

    def inside(self, state, step, delta, work):
        """Whether every normal is still in its chart at the end of the increment ``delta``."""
        delta = np.ascontiguousarray(delta, dtype=float)
        return self._advance(self.nodes, state.motion, step, delta, work) == DONE

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
        return self._switch(self.nodes, self.fixed_component, self._follow, dt, state.motion)

    def correct(self, state, start, correction):
        """Move a static state: nodes by displacements, normals along great circles."""
        nodes.turn_normals(self.nodes, self.fixed_component, correction, state.variables,
                           state.chart, start.p, start.A1)
        updates.move_nodes(self.nodes.start, correction, state.x, state.x_low)

    def largest_turn(self, start, correction):
        """Largest angle [rad] by which a correction turns a normal."""
        return nodes.largest_turn(self.nodes, correction, start.A1)


def _frames(first, before, p):
    """(n_nodes, 3, 3) rows e_x, e_y, e_z of nodal frames, along the global axes at first; those of
    junctions turned as their directors from ``before`` to p, by least squares."""
    frames = np.tile(np.eye(3), (len(first) - 1, 1, 1))
    for i in np.flatnonzero(np.diff(first) > 1):
        members = slice(first[i], first[i + 1])
        frames[i] = Rotation.align_vectors(p[members], before[members])[0].as_matrix().T
    return frames


def _supports(model, numbering):
    """Component of the normal that must stay a variable (n_nodes,), -1 for none, and held dofs.

    Two fixed components of a unit normal fix it altogether; a single one is kept as the first
    rotational variable of its node.
    """
    mask = model.fixed
    fixed = np.zeros(numbering.n_dof, dtype=bool)
    fixed_component = np.full(len(model.nodes), -1, dtype=np.int64)
    for i in np.flatnonzero(mask.any(axis=1)):
        first = numbering.start[i]
        fixed[first:first + 3] = mask[i, :3]
        components = np.flatnonzero(mask[i, 3:])
        if len(components) == 1:
            fixed_component[i] = components[0]
        fixed[first + 3:first + 3 + min(len(components), numbering.n_rot[i])] = True
    return fixed_component, fixed
