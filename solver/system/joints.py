"""Hinges with moments, as an item of the system."""

import numpy as np

from ..kernels import hinges
from ..kernels.arguments import DONE
from ..kernels.calls import Call
from .failure import NotConverged
from .state import blank_state
from .turning import follow


class Hinges:
    """All places, two nodes each, at which a hinge has a moment.

    Attributes:
        cells: (n, 2) nodes, of ``nodes`` and of ``others``.
    """

    def __init__(self, model, turnings):
        """``turnings``: ``Turnings``, whose first places these are."""
        self._turnings, n = turnings, turnings.hinges
        cells, edges = [], []
        for number in dict.fromkeys(turnings.joints[:n].tolist()):
            joint = model.joints[number]
            line = joint.nodes
            for k, pair in enumerate(zip(line, joint.others)):
                cells.append(pair)
                edges.append((line[max(k - 1, 0)], line[min(k + 1, len(line) - 1)]))
        self.cells = np.array(cells, dtype=np.int64).reshape(-1, 2)
        self._edges = np.array(edges, dtype=np.int64).reshape(-1, 2)
        self._directors = model.directors.first[self.cells]
        self._constants = turnings.constants[:n]
        self._on_rotations, self._found = np.zeros((n, 5)), np.zeros(n)
        self._add_forces = Call(hinges.add_hinge_forces)
        self._add_stiffness = Call(hinges.add_hinge_stiffness)
        self._angles = Call(hinges.angles)
        self._initial = self._measured(blank_state(model.nodes, 0), model.normals).copy()

    def __bool__(self):
        return len(self.cells) > 0

    def follow(self, state, p):
        """Angles of a ``state`` with the normals p."""
        n = len(self.cells)
        follow(self._measured(state, p) - self._initial, state.hinges[:n, hinges.ANGLE])

    def add_forces(self, dofs, iterate, start, end, motors, slacks, forces):
        """Add the forces at an iterate to ``forces`` (n_dof,); ``start`` and ``end``: normals
        (n_directors, 3) there.

        Raises:
            NotConverged: plates fold by a right angle or more in the step.
        """
        n = len(self.cells)
        lost = self._add_forces(
            dofs.nodes, self._edges, self._directors, self.cells, self._constants,
            iterate.state.hinges[:n], motors[:n], slacks[:n], iterate.state.motion, iterate.delta,
            iterate.step, start, end, iterate.A1, forces, self._on_rotations)
        if lost != DONE:
            raise NotConverged(f"the hinge at node {lost} turns too far")

    def add_matrix(self, dofs, storage, values, skew):
        """Add their stiffness in the iterate whose forces were added last."""
        self._add_stiffness(dofs, storage, self.cells, self._on_rotations, values, skew)

    def rate(self, number, state, place):
        """Mean rate of the angle of the hinge ``number`` [rad/s]."""
        n = len(self.cells)
        a, b = self._directors.T
        i, j = self._edges.T
        edge = state.x[j] - state.x[i]
        edge /= np.linalg.norm(edge, axis=1, keepdims=True)
        p, rate = place.start.p, place.start.p_dot
        spin = np.cross(p[b], rate[b]) - np.cross(p[a], rate[a])
        return float(self._turnings.share(number)[:n] @ np.sum(spin * edge, axis=1))

    def _measured(self, state, p):
        """Angles (n,) of normals, in (-pi, pi]."""
        self._angles(self._edges, self._directors, state.motion, p, self._found)
        return self._found
