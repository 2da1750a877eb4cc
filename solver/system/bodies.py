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
        self._nodes = self.cells[:, 0]
        self._mass = np.array([mass for _, mass in model.body_masses])
        self._spread = spreads(model.bodies, len(model.normals))
        self._dofs, self._first, self._start = None, model.directors.first, None

    def __bool__(self):
        return len(self.cells) > 0

    def number(self, numbering):
        """Take the numbers of the unknowns."""
        self._dofs = numbering.translations[self._nodes]
        self._start = numbering.start

    def add_forces(self, iterate, work, forces):
        """Add the inertial forces ``-M (v_1 - v_0)/dt`` at an iterate to ``forces`` (n_dof,) [N];
        ``work``: what it has of the nodes."""
        forces[self._dofs] -= self._mass[:, None] * work.inertial_x[self._nodes]

    def add_matrix(self, storage, iterate, values):
        """Add their mass to a matrix."""
        values[storage.diagonal[self._dofs]] += iterate.step.mass * self._mass[:, None]

    def kinetic(self, state, start):
        """(n,) kinetic energy of each [J]."""
        turns = self._spread[:, None] * start.p_dot**2
        return 0.5 * (self._mass * np.sum(state.velocity[self._dofs]**2, axis=1)
                      + turns[-3 * len(self._nodes):].reshape(-1, 9).sum(axis=1))

    def rates(self, work):
        """(n_directors, 3) inertial forces on their directors beside those of ``NodalWork``."""
        return np.zeros_like(work.rate_p)

    def observed(self, shell, state, start):
        """``arguments.Observation`` of the ``shell`` with these bodies."""
        at, own = self._nodes, slice(-3 * len(self._nodes), None)
        v, p, rates = state.velocity[self._dofs], start.p[own], start.p_dot[own]
        momenta, spins = self._mass[:, None] * v, self._spread[own, None] * rates
        products = (state.x[at] + state.x_low[at]).T @ momenta + p.T @ spins
        angular = (products - products.T)[(1, 2, 0), (2, 0, 1)]
        return shell._replace(
            kinetic=shell.kinetic + 0.5 * float(np.vdot(momenta, v) + np.vdot(spins, rates)),
            linear_momentum=shell.linear_momentum + momenta.sum(axis=0),
            angular_momentum=shell.angular_momentum + angular,
            angular_momentum_printed=shell.angular_momentum_printed + angular)


class TurningBodies(Bodies):
    """The same in charts, with the inertia of their turns: the exact scheme has that of all nodes.
    """

    def add_forces(self, iterate, work, forces):
        super().add_forces(iterate, work, forces)
        for i, d in self._directors():
            p_ddot, A1 = work.inertial_p[d], iterate.A1[d]
            forces[self._start[i] + 3 + np.arange(3)] -= np.einsum("k,kcr,kc->r", self._spread[d],
                                                                   A1, p_ddot)

    def add_matrix(self, storage, iterate, values):
        super().add_matrix(storage, iterate, values)
        rows, columns = np.tril_indices(3)
        for i, d in self._directors():
            A1 = iterate.A1[d]
            block = np.einsum("k,kcr,kcs->rs", iterate.step.mass * self._spread[d], A1, A1)
            at = storage.diagonal[self._start[i] + 3 + rows]
            values[at - (rows - columns) * storage.stride] += block[rows, columns]

    def rates(self, work):
        return self._spread[:, None] * work.inertial_p

    def _directors(self):
        for i in self._nodes:
            yield i, slice(self._first[i], self._first[i + 1])
