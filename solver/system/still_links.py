"""Constraints of joints and bodies in an equilibrium, with their second derivatives.

With the vectors u and w of a constraint and the spins ``th = W dn`` of nodes

    ddg = 2 (J_u dq) . (J_w dq) + sum (th . w) (th . d) - (w . d) th^2 + q . dW dn

with the torque q = d x w, the sum over the terms of both, see ``chart_rows``.
"""

import numpy as np
from scipy.linalg import block_diag, qr, solve_triangular
from scipy.sparse import coo_array, csc_array, hstack
from scipy.sparse.csgraph import connected_components

from ..kernels import hinges
from ..kernels.nodes import curvature
from .chart_rows import ChartRows
from .failure import SingularMatrix
from .turning import nearest

LEAST_HOLD = 1e-10
"""Part of the largest by which the weakest constraint of joints that belong together must hold."""


class StillLinks(ChartRows):
    """The constraints of a model in an equilibrium; moments of joints are forces with a stiffness.

    Attributes:
        acting: (n_local,) forces of joints in the last iterate.
    """

    def __init__(self, system):
        super().__init__(system)
        self.acting, self._slopes = np.zeros(len(self.dofs)), np.zeros(
            len(self.owners) - self._hard)
        self._ahead = 0.0
        self._columns(system)
        scaled = self._of_free(self._G[:self._hard])
        self._check(scaled @ scaled.T)

    # ------------------------------------------------------------------ at a state

    def driven(self, value):
        """(n,) angles of drives with ``value(history)`` [rad]."""
        return np.array([joint.angle * value(joint.driving) for joint in self._driven])

    def add_forces(self, iterate, driven, slacks, motors, work, forces):
        """Add the forces of the constraints and of the moments at an iterate to ``forces``
        (n_dof,).

        Args:
            iterate: ``Iterate``.
            driven: (n,) angles of drives [rad].
            slacks: (n,) angles at which springs are slack [rad].
            motors: (n,) moments of motors [N m].
            work: ``NodalWork`` of it.
            forces: added to.
        """
        state, places, n = iterate.state, self._places, len(self._driven)
        self._at(state, iterate, work.dx)
        angle = nearest(self._angles(self._u[1]) - self._initial,
                        state.hinges[places, hinges.ANGLE])
        self.off[self._m:self._hard] = angle[:n] - driven
        places, found = places[n:], np.empty((len(places) - n, 2))
        if len(places):
            self._moments(self._turnings.constants[places], state.hinges[places], slacks[places],
                          angle[n:], 1.0, 0.0, found)
            self._slopes = found[:, 1]
            self.forces[self._hard:] = -(found[:, 0] + motors[places])
        self.acting = -self._G.T @ self.forces
        forces[self.dofs] += self.acting

    def foresee(self, motion):
        """See ``StillSystem.foresee``."""
        self._ahead = self._slopes * (self._G[self._hard:] @ motion[self.dofs])

    def second(self, nodes, iterate):
        """(n_dof, n_dof) sparse, what joints add to the matrix of the iterate whose forces were
        added last."""
        forces = self.forces.copy()
        forces[self._hard:] += self._ahead
        on = self._on_products(forces)
        one, other = ((on[:, None, None] * self._J[self._pairs[:, 0]]), self._J[self._pairs[:, 1]])
        H = one.reshape(-1, len(self.dofs)).T @ other.reshape(-1, len(self.dofs))
        H += H.T
        soft = self._G[self._hard:]
        H += soft.T @ (self._slopes[:, None] * soft)
        turned, torques = self._turning_twice(on)
        none, K = np.zeros_like(iterate.p), np.empty((3, 3))
        for i in self._nodes:
            n, at, spins = self._n_rot[i], self._local[i] + 3, self._spins[i]
            curvature(nodes, i, iterate.p, iterate.A1, iterate.state.chart, none, -torques, K)
            block = K + spins @ turned[i] @ spins.T
            H[at:at + n, at:at + n] += block[:n, :n]
        rows, columns = np.meshgrid(self.dofs, self.dofs, indexing="ij")
        return iterate.step.stiffness * coo_array(
            (H.ravel(), (rows.ravel(), columns.ravel())), shape=(self._n_dof,) * 2).tocsc()

    # ------------------------------------------------------------------ what is left free

    def _columns(self, system):
        """The free unknowns on which constraints depend, by groups of constraints that have some in
        common."""
        T = system.coordinates.basis().tocsc()
        local = T[self.dofs]
        here = np.diff(local.tocsc().indptr) > 0
        self._T_others, self._T_here = T[:, ~here], T[:, here]
        self._local_T = local[:, here].toarray()
        self._lengths = np.abs(self._local_T).T @ system.lengths[self.dofs] / np.abs(
            self._local_T).sum(axis=0)
        on = np.zeros((len(self._u[1]), len(self.dofs)), dtype=bool)
        vector = np.repeat(np.arange(len(on)), np.diff(self._terms.first))
        for k in range(6):
            has = 3 + self._n_rot[self._terms.node] > k
            on[vector[has], self._local[self._terms.node[has]] + k] = True
        pairs = on[self._pairs[:, 0]] | on[self._pairs[:, 1]]
        driven = slice(self._m, self._m + 2 * len(self._driven))
        rows = np.concatenate([pairs[:self._m], pairs[driven][::2] | pairs[driven][1::2]])
        touched = coo_array(rows.astype(float) @ np.abs(self._local_T))
        n_rows, n_columns = touched.shape
        links = coo_array((touched.data, (touched.coords[0], n_rows + touched.coords[1])),
                          shape=(n_rows + n_columns,) * 2)
        n, group = connected_components(links, directed=False)
        self._groups = [(np.flatnonzero(group[:n_rows] == k), np.flatnonzero(group[n_rows:] == k))
                        for k in range(n)]

    def _of_free(self, G):
        """Rows (k, n_local) for the free unknowns, each a length."""
        return G @ self._local_T / self._lengths

    def reduce(self):
        """Take the basis of what constraints leave free at the state of the last iterate.

        Raises:
            SingularMatrix: joints hold the same twice there.
        """
        G, self._factors, blocks, order = self._of_free(self._G[:self._hard]), [], [], []
        for rows, columns in self._groups:
            m = len(rows)
            Q, R = qr(G[np.ix_(rows, columns)].T)
            sizes = np.abs(np.diag(R))
            if m > len(columns) or m and sizes.min() < LEAST_HOLD * sizes.max():
                names = sorted({self._names()[k] for k in self.owners[rows]})
                raise SingularMatrix(f"{', '.join(names)}: where they have come to joints hold the "
                                     "same twice")
            self._factors.append((Q[:, :m], R[:m]))
            blocks.append(Q[:, m:])
            order.append(columns)
        order = np.concatenate(order)
        free = np.zeros((len(order), sum(block.shape[1] for block in blocks)))
        free[order] = block_diag(*blocks)
        free /= self._lengths[:, None]
        return hstack([self._T_others, csc_array(self._T_here @ free)]).tocsr()

    def closing(self, pushed, missed):
        """The least motion (n_dof,) that takes off what is ``missed`` of constraints (hard ones),
        beside that of supports, see ``StillSystem.solve``."""
        wanted = np.zeros(self._hard) if missed is None else -missed[:self._hard]
        if pushed is not None:
            wanted -= self._G[:self._hard] @ pushed[self.dofs]
        found = np.zeros(len(self._lengths))
        for (rows, columns), (Q, R) in zip(self._groups, self._factors):
            found[columns] = Q @ solve_triangular(R, wanted[rows], trans="T")
        return self._T_here @ (found / self._lengths)

    def pull(self, residual):
        """Changes (m,) of the multipliers that balance a residual (n_dof,), as nearly as they
        can; zero of moments."""
        forces = self._T_here.T @ residual / self._lengths
        change = np.zeros(len(self.forces))
        for (rows, columns), (Q, R) in zip(self._groups, self._factors):
            change[rows] = solve_triangular(R, Q.T @ forces[columns])
        return change

    def linear(self, motion):
        """Changes (n_dof,) of the forces of springs by a small ``motion`` (n_dof,)."""
        change, soft = np.zeros_like(motion), self._G[self._hard:]
        less = self._slopes * (soft @ motion[self.dofs])
        self.forces[self._hard:] += less
        change[self.dofs] = -soft.T @ less
        return change

    def hold(self, residual):
        """Take the multipliers that balance a ``Residual``, and add their forces (n_dof,) to it.

        Returns:
            these forces.
        """
        self.reduce()
        change, forces = self.pull(residual.balance), np.zeros(self._n_dof)
        forces[self.dofs] = -self._G.T @ change
        self.forces += change
        residual.unmasked[:] += forces
        residual.applied[:] += forces
        residual.balance[:] += self._free(forces)
        return forces

    # ------------------------------------------------------------------ results

    def torques(self):
        """(n_nodes, 3) of all joints on nodes [N m]."""
        return -self._turning_twice(self._on_products(self.forces))[1]

    def on(self, number):
        """Force [N] and moment about the origin [N m], (3,) each, of the joint ``number`` on its
        end ``other``, or on ``one`` where the other is the ground."""
        forces = self.forces * (self.owners == number)
        acting = -self._G.T @ forces
        torques = -self._turning_twice(self._on_products(forces))[1]
        force, moment = np.zeros((2, 3))
        for i in self._end_of(number):
            own = acting[self._local[i] + np.arange(3)]
            force += own
            moment += np.cross(self._x[i], own) + torques[i]
        return force, moment

    # ------------------------------------------------------------------ motions of rigid parts

    def sides(self):
        """Nodes that each constraint, or part of an angle, connects."""
        first, node = self._terms.first, self._terms.node
        for one, other in self._pairs:
            yield np.r_[node[first[one]:first[one + 1]], node[first[other]:first[other + 1]]]

    def joints_of(self, nodes):
        """Names of joints with an end at some of the ``nodes``."""
        found = {self._names()[owner] for owner, side in zip(self._owners_of_pairs(), self.sides())
                 if owner < len(self._model.joints) and np.isin(side, nodes).any()}
        return sorted(found)

    def _owners_of_pairs(self):
        """Numbers of the joints and bodies of ``sides``."""
        return [*self.owners[:self._m], *np.repeat(self.owners[self._m:], 2)]

    def holds(self):
        """Rows (k, n_local) of all that holds a rigid motion: of constraints, drives and
        springs."""
        soft = self.owners[self._hard:]
        stiff = [self._model.joints[number].springs_back for number in soft]
        return self._initial_rows[np.r_[np.ones(self._hard, dtype=bool), np.array(stiff, bool)]]

    def at_nodes(self, rows):
        """(node, (k, 3) on its place, (k, 3) on its turn) of ``rows``, for every node."""
        for i in self._nodes:
            at, n, axes = self._local[i], self._n_rot[i], self._initial_frames[i]
            if n == 2:
                axes = np.stack([axes[1], -axes[0]])
            yield i, rows[:, at:at + 3], rows[:, at + 3:at + 3 + n] @ axes
