"""Linear constraints of increments, ``dU = T dU_free``: oblique supports, sectors, joints.

T is constant: rotational variables are components along axes that the support keeps
(``Model.kept``), and those of the one edge of a sector along the axes of the other, turned
(``Constraints.follow``).  Its columns are orthonormal, its rows at held dofs zero.  Kernels, states
and residuals stay in global axes; what supports do is what ``T T^T`` takes from a residual.
"""

import numpy as np
from scipy.sparse import coo_array, eye_array

from ..kernels import storage
from ..kernels.calls import Call

ZERO = 1e-15
"""Components of unit vectors below this are rounding."""


class Constraints:
    """What supports with axes of their own, the edges of a sector and joints leave free.

    Attributes:
        T: (n_dof, n_free) sparse.
        nodes: those with such a support, or on such an edge.
        holds: whether there are any.
    """

    def __init__(self, model, numbering, fixed):
        """``fixed``: (n_dof,) bool, unknowns that are held each by itself."""
        self.nodes, self._pairs = np.array(sorted(model.oblique), dtype=np.int64), model.pairs
        self.holds = len(self.nodes) > 0
        if self._pairs:
            self._variables = [np.concatenate([_variables(numbering, i) for i in side])
                               for side in (self._pairs.masters, self._pairs.slaves)]
        self.T = _columns(_blocks(model, numbering, fixed), fixed)
        onto = (self.T @ self.T.T).tocsr()
        away = onto - eye_array(numbering.n_dof, format="csr")
        away.eliminate_zeros()
        self._tied = np.flatnonzero(np.diff(away.indptr))
        self._onto = Product(onto[self._tied])

    def project(self, vector):
        """The part of a vector (n_dof,) that is free."""
        free = vector.copy()
        free[self._tied] = self._onto(vector)
        return free

    def follow(self, state):
        """Give the slaves of a sector the charts of their masters, turned, and their variables and
        rates."""
        if self._pairs:
            R, masters, slaves, _ = self._pairs
            state.chart[slaves] = state.chart[masters] @ R.T
            state.variables[slaves] = state.variables[masters]
            one, other = self._variables
            state.velocity[other] = state.velocity[one]
            state.acceleration[other] = state.acceleration[one]


class Product:
    """A constant sparse matrix, to be multiplied with one vector after another."""

    def __init__(self, matrix):
        """``matrix``: (n, k) sparse, by rows."""
        self._parts, self._n = (matrix.indptr, matrix.indices, matrix.data), matrix.shape[0]
        self._times = Call(storage.times)

    def __call__(self, vector):
        """The product (n,), a new vector."""
        found = np.empty(self._n)
        self._times(*self._parts, vector, found)
        return found


def constraints(model, numbering, fixed):
    """``Constraints`` of a model; None where every unknown is held or free by itself."""
    if model.oblique or model.joined:
        return Constraints(model, numbering, fixed)
    return None


def _blocks(model, numbering, fixed):
    """(unknowns, orthonormal columns of T there) of every node that has some."""
    start, slave_of = numbering.start, {}
    if model.pairs:
        R = model.pairs.rotation
        slave_of = dict(zip(model.pairs.masters, model.pairs.slaves))
    joined = {i for group in model.joined for i in group}
    for group in model.joined:
        dofs, N = start[group][:, None] + np.arange(3), free_of_group(model, start, fixed, group)
        yield dofs.ravel(), np.sqrt(1.0 / len(group)) * np.tile(N, (len(group), 1))
    for i in model.oblique.keys() - slave_of.values() - joined:
        N, dofs = _complement(model.oblique[i][0]), start[i] + np.arange(3)
        if i not in slave_of:
            yield dofs, N
            continue
        s = slave_of[i]
        yield (np.r_[dofs, start[s] + np.arange(3)], np.sqrt(0.5) * np.concatenate([N, R @ N]))
        turning = np.stack([_variables(numbering, i), _variables(numbering, s)])
        turning = turning[:, ~fixed[turning[0]]]
        yield turning.ravel(), np.sqrt(0.5) * np.tile(np.eye(turning.shape[1]), (2, 1))


def free_of_group(model, start, fixed, group):
    """(3, f) orthonormal directions that supports leave free of nodes that move together."""
    held = np.eye(3)[fixed[start[group[0]] + np.arange(3)]]
    return _complement(model.oblique.get(group[0], (held,))[0])


def _columns(blocks, fixed):
    """T of its blocks, and of the unknowns that are in none and free."""
    blocks, alone = list(blocks), ~fixed
    for dofs, _ in blocks:
        alone[dofs] = False
    rows, columns, values = [np.flatnonzero(alone)], [np.arange(alone.sum())], [
        np.ones(alone.sum())]
    n = len(rows[0])
    for dofs, N in blocks:
        row, column = np.nonzero(N)
        rows.append(dofs[row])
        columns.append(n + column)
        values.append(N[row, column])
        n += N.shape[1]
    places = np.concatenate(rows), np.concatenate(columns)
    return coo_array((np.concatenate(values), places), shape=(len(fixed), n)).tocsr()


def _variables(numbering, i):
    """Numbers of the rotational variables of a node."""
    return numbering.start[i] + 3 + np.arange(numbering.n_rot[i])


def _complement(directions):
    """(3, f) orthonormal columns at right angles to orthonormal ``directions`` (k, 3)."""
    if not len(directions):
        return np.eye(3)
    N = np.linalg.svd(directions)[2][len(directions):].T
    return np.where(np.abs(N) > ZERO, N, 0.0)
