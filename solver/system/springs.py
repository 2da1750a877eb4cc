"""Springs of a model as items of the system: inner forces on cells of nodes of their own."""

import numpy as np

from ..kernels import springs
from ..model.attached import GroundSpring, Spring
from .tables import columns_of, stacked


class AxialSprings:
    """Springs and dampers between two nodes.

    Attributes:
        cells: (n, 2) nodes.
        grounded: whether the ground pulls.
    """

    grounded = False

    def __init__(self, model, given):
        self.cells = np.array([(item.node, item.other) for item in given])
        ends = model.nodes[self.cells]
        lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        self._constants = stacked([_constants(*each) for each in zip(given, lengths)],
                                  springs.TABLES)

    def add_forces(self, dofs, iterate, forces):
        """Add the forces on the nodes at an iterate to ``forces`` (n_dof,) [N]."""
        springs.add_axial_forces(dofs.nodes, self.cells, self._constants, iterate.state.motion,
                                 iterate.delta, iterate.step, forces)

    def add_matrix(self, dofs, iterate, storage, values, skew):
        """Add their stiffness to a matrix."""
        springs.add_axial_stiffness(dofs, storage, self.cells, self._constants,
                                    iterate.state.motion, iterate.delta, iterate.step, values,
                                    skew)

    def scale(self, state):
        """Sum of ``k (l + L)``, of whose rounding a slack spring's force is [N]."""
        k, L = self._constants[:, springs.K], self._constants[:, springs.LENGTH]
        return float(k @ (self._lengths(state) + L))

    def linear(self, state, u):
        """(n_nodes, 3) changes of the forces by small displacements u (n_nodes, 3), with the slopes
        of tables towards longer springs [N]."""
        found, change = np.empty((len(self.cells), 2)), np.zeros_like(u)
        lengths, moved = self._lengths(state), u[self.cells[:, 1]] - u[self.cells[:, 0]]
        springs.tensions(self._constants, lengths, found)
        per_length = np.divide(1.0, lengths, out=np.zeros_like(lengths), where=lengths > 0.0)
        n = self._along(state) * per_length[:, None]
        along, (tension, slope) = np.sum(n * moved, axis=1), found.T
        pull = n * (slope * along)[:, None] + (moved - n * along[:, None]) * (
            tension * per_length)[:, None]
        np.add.at(change, self.cells[:, 0], pull)
        np.subtract.at(change, self.cells[:, 1], pull)
        return change

    def energy(self, state):
        """Energy of all [J]."""
        return float(self.energies(state).sum())

    def energies(self, state):
        """(n,) ``1/2 k (l - L)^2``, and the integral of its table, of each [J]."""
        found = np.empty(len(self.cells))
        springs.stored(self._constants, self._lengths(state), found)
        return found

    def lost(self, before, after, dt):
        """(n,) what the damper of each took in a step of length dt [s] between two states [J]."""
        found = np.empty(len(self.cells))
        springs.lost(self._constants, self._lengths(after) - self._lengths(before), dt, found)
        return found

    def _along(self, state):
        """(n, 3) vectors from node to node [m]."""
        one, other = self.cells.T
        return (state.x[other] - state.x[one]) + (state.x_low[other] - state.x_low[one])

    def _lengths(self, state):
        """(n,) [m]."""
        return np.linalg.norm(self._along(state), axis=1)


def _constants(item, length):
    """The constants of a ``Spring`` whose ends are at first ``length`` [m] apart."""
    tables = [(item.spring_extensions, item.spring_forces), (item.damper_rates, item.damper_forces)]
    return [item.stiffness, length if item.length is None else item.length, item.damping,
            *columns_of(tables)]


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

    def scale(self, state):
        """Sum of ``k |u|`` [N]."""
        return float(np.sum(self._stiffness * np.abs(self._moved(state))))

    def linear(self, state, u):
        """(n_nodes, 3) changes of the forces by small displacements u (n_nodes, 3) [N]."""
        change, nodes = np.zeros_like(u), self.cells[:, 0]
        np.subtract.at(change, nodes, self._stiffness * u[nodes])
        return change

    def energy(self, state):
        """``1/2 sum u . k u`` [J]."""
        return 0.5 * float(np.sum(self._stiffness * self._moved(state)**2))

    def _moved(self, state):
        """(n, 3) displacements [m]."""
        nodes = self.cells[:, 0]
        return (state.x[nodes] - self._X) + state.x_low[nodes]


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
