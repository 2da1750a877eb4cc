"""Springs of a model as items of the system: inner forces on cells of nodes of their own."""

import numpy as np

from ..kernels import springs
from ..model.attached import GroundSpring, Spring


class AxialSprings:
    """Springs between two nodes.

    Attributes:
        cells: (n, 2) nodes.
        grounded: whether the ground pulls.
    """

    grounded = False

    def __init__(self, model, given):
        self.cells = np.array([(item.node, item.other) for item in given])
        self._stiffness = np.array([item.stiffness for item in given])
        ends = model.nodes[self.cells]
        lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        self._lengths = np.array([length if item.length is None else item.length
                                  for item, length in zip(given, lengths)])

    def add_forces(self, dofs, iterate, forces):
        """Add the forces on the nodes at an iterate to ``forces`` (n_dof,) [N]."""
        springs.add_axial_forces(dofs.nodes, self.cells, self._stiffness, self._lengths,
                                 iterate.state.motion, iterate.delta, 1.0 - iterate.step.alpha_f,
                                 forces)

    def add_matrix(self, dofs, iterate, storage, values, skew):
        """Add their stiffness to a matrix."""
        springs.add_axial_stiffness(dofs, storage, self.cells, self._stiffness, self._lengths,
                                    iterate.state.motion, iterate.delta, iterate.step, values,
                                    skew)

    def energy(self, state):
        """``1/2 sum k (l - L)^2`` [J]."""
        return 0.5 * float(self._stiffness @ self._longer(state)**2)

    def energies(self, state):
        """(n,) that of each."""
        return 0.5 * self._stiffness * self._longer(state)**2

    def _longer(self, state):
        """(n,) ``l - L`` [m]."""
        x = state.x[self.cells[:, 1]] - state.x[self.cells[:, 0]]
        x += state.x_low[self.cells[:, 1]] - state.x_low[self.cells[:, 0]]
        return np.linalg.norm(x, axis=1) - self._lengths


class GroundSprings:
    """Springs between nodes and their initial places.

    Attributes:
        cells: (n, 1) nodes.
        grounded: whether the ground pulls.
    """

    grounded = True

    def __init__(self, model, given):
        self.cells = np.array([[item.node] for item in given])
        self._stiffness = np.array([item.stiffness for item in given])
        self._X = model.nodes[self.cells[:, 0]]

    def add_forces(self, dofs, iterate, forces):
        """Add the forces on the nodes at an iterate to ``forces`` (n_dof,) [N]."""
        springs.add_ground_forces(dofs.nodes, self.cells, self._stiffness, self._X,
                                  iterate.state.motion, iterate.delta, 1.0 - iterate.step.alpha_f,
                                  forces)

    def add_matrix(self, dofs, iterate, storage, values, skew):
        """Add their stiffness to a matrix."""
        springs.add_ground_stiffness(dofs, storage, self.cells, self._stiffness,
                                     iterate.step.stiffness, values, skew)

    def energy(self, state):
        """``1/2 sum u . k u`` [J]."""
        nodes = self.cells[:, 0]
        u = (state.x[nodes] - self._X) + state.x_low[nodes]
        return 0.5 * float(np.sum(self._stiffness * u**2))


class TurningSprings:
    """Springs that hold normals: ``k_t (1 - p . p_0)``, a constant force ``k_t p_0`` on p.

    Attributes:
        forces: (n_directors, 3) on the normals [N m].
    """

    def __init__(self, model):
        self._stiffness = np.zeros(len(model.normals))
        for item in model.attached:
            if isinstance(item, GroundSpring):
                self._stiffness[model.directors.first[item.node]] += item.turning
        self._p_0 = model.normals
        self.forces = self._stiffness[:, None] * model.normals

    def linear(self, nodes, start, motion):
        """Forces ``-k_t A1^T dp`` (n_dof,) by a small motion dp = A1 dn from p_0, and their moments
        ``-k_t p_0 x dp`` (n_nodes, 3)."""
        forces, moments = np.zeros_like(motion), np.zeros((len(nodes.start), 3))
        for d in np.flatnonzero(self._stiffness):
            i = np.searchsorted(nodes.first, d, side="right") - 1
            at, A1 = slice(nodes.start[i] + 3, nodes.start[i] + 5), start.A1[d, :, :2]
            pull = -self._stiffness[d] * (A1 @ motion[at])
            forces[at] = A1.T @ pull
            moments[i] = np.cross(start.p[d], pull)
        return forces, moments

    def energy(self, p):
        """``1/2 sum k_t |p - p_0|^2`` of the normals p (n_directors, 3) [J]."""
        return 0.5 * float(self._stiffness @ np.sum((p - self._p_0)**2, axis=1))


def items(model):
    """Items of the springs of a model."""
    axial = [item for item in model.attached if isinstance(item, Spring)]
    ground = [item for item in model.attached if isinstance(item, GroundSpring)]
    return [kind(model, given) for kind, given in ((AxialSprings, axial), (GroundSprings, ground))
            if given]
