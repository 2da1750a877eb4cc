"""Inertia of rigid bodies, at nodes that belong to no element."""

import numpy as np

from ..model.bodies import spreads


class Bodies:
    """The rigid bodies of a model; their turns are those of nodes with three directors, whose
    inertia ``Spins`` has.

    Attributes:
        cells: (n, 1) their nodes.
    """

    def __init__(self, model):
        self.cells = np.array([[node] for node, _ in model.body_masses], dtype=np.int64)
        self.cells = self.cells.reshape(-1, 1)
        self._mass = np.array([mass for _, mass in model.body_masses])
        self._spread = spreads(model.bodies, len(model.normals))
        self._dofs, self._first = None, model.directors.first

    def __bool__(self):
        return len(self.cells) > 0

    def number(self, numbering):
        """Take the numbers of the unknowns."""
        self._dofs = numbering.translations[self.cells[:, 0]]

    def add_forces(self, iterate, forces):
        """Add the inertial forces ``-M (v_1 - v_0)/dt`` at an iterate to ``forces`` (n_dof,) [N].
        """
        state, step, delta = iterate[:3]
        at = self._dofs
        rate = (step.delta * delta[at] - step.velocity * state.velocity[at]
                - step.acceleration * state.acceleration[at])
        forces[at] -= self._mass[:, None] * rate

    def add_matrix(self, storage, step, values):
        """Add their mass to a matrix."""
        values[storage.diagonal[self._dofs]] += step.mass * self._mass[:, None]

    def add_turning(self, numbering, storage, iterate, values):
        """Add their rotary inertia ``sum I_k A1_k^T A1_k`` in rotational variables to a matrix."""
        for i in self.cells[:, 0]:
            d = self._first[i] + np.arange(3)
            A1, I = iterate.A1[d], iterate.step.mass * self._spread[d]
            block = np.einsum("k,kcr,kcs->rs", I, A1, A1)
            rows, columns = np.tril_indices(3)
            at = storage.diagonal[numbering.start[i] + 3 + rows]
            values[at - (rows - columns) * storage.stride] += block[rows, columns]

    def observed(self, shell, state, start):
        """``arguments.Observation`` of the ``shell`` with these bodies."""
        at, m, I = self.cells[:, 0], self._mass[:, None], self._spread[:, None]
        v, x = state.velocity[self._dofs], state.x[at] + state.x_low[at]
        rates = start.p_dot
        momentum = np.sum(m * v, axis=0)
        angular = np.sum(np.cross(x, m * v), axis=0) + np.sum(I * np.cross(start.p, rates), axis=0)
        return shell._replace(
            kinetic=shell.kinetic + 0.5 * float(np.sum(m * v**2) + np.sum(I * rates**2)),
            linear_momentum=shell.linear_momentum + momentum,
            angular_momentum=shell.angular_momentum + angular,
            angular_momentum_printed=shell.angular_momentum_printed + angular)
