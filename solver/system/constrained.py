"""Linear solvers for unknowns that are tied to each other: ``x = T (T^T K T)^-1 T^T r``.

K is assembled in sparse storage.  The entries of the reduced matrix are sums of its entries with
constant factors, one sparse product.
"""

import numpy as np
from scipy.linalg import lapack
from scipy.sparse import coo_array

from ..kernels import storage
from ..kernels.calls import Call
from .constraints import Product
from .linear import DIRECT_LIMIT, OneByOne, SuperLU, UnsymmetricLU, diagonal_lu, unsymmetric_lu

PART, STEADY = 0.1, 12
"""Part of the way that unknowns move at once; and how often without a gain (measured: a hinge
across a plate of 12 elements leaves 87 of 100 entries a row, one across 20 of 298 leaves 176)."""


def constrained(numbering, T, unsymmetric):
    """The solver for a matrix T (n_dof, n_free), see ``constraints``: a banded one where the
    reduced matrix is narrow, else SuperLU."""
    if unsymmetric:
        return Constrained(UnsymmetricLU(numbering), T)
    solver = SuperLU(numbering)
    band = Band(solver, T)
    if T.shape[1] * float(band.width)**2 < DIRECT_LIMIT:
        return BandedConstrained(solver, T, band)
    return Constrained(solver, T)


class Constrained(OneByOne):
    """SuperLU of the reduced matrix."""

    def __init__(self, solver, T):
        """``solver``: a ``SuperLU`` or ``UnsymmetricLU``, whose storage is used; ``T``: see
        ``constrained``."""
        self.name = f"{solver.name}, constrained"
        self._solver, self._T, self._factor = solver, T, None
        self.storages, self.storage = solver.storages, solver.storage
        self.values, self.skew = solver.values, solver.skew

    def matrix(self):
        """The assembled matrix, of all unknowns."""
        return self._solver.matrix()

    def factor(self):
        """Factorize the matrix, see ``linear``."""
        return self._factor_reduced(self.matrix())

    def _factor_reduced(self, matrix):
        reduced = (self._T.T @ matrix @ self._T).tocsc()
        if self.skew.size:
            self._factor = unsymmetric_lu(reduced)
            return None
        self._factor, negative = diagonal_lu(reduced)
        return negative

    def solve(self, rhs):
        """A new vector (n_dof,) that keeps constraints, see ``linear``."""
        return self._T @ self._factor.solve(self._T.T @ rhs)


class Band:
    """The reduced matrix as a band, its unknowns in the order of the first that they stand for, but
    moved where they make it wide.

    Attributes:
        width: largest distance of an entry from the diagonal.
        T: (n_dof, n_free) with its columns in that order.
    """

    def __init__(self, solver, T):
        full = solver.matrix().copy()
        order = np.argsort(T.tocsc().indices[T.tocsc().indptr[:-1]], kind="stable")
        self.T = T.tocsr()[:, order]
        full.data[:] = np.arange(full.nnz)
        rows, columns, *rest = self._pairs(full.tocoo(), solver.sources)
        places = narrowed(rows, columns, self.T.shape[1])
        self.T = self.T[:, np.argsort(places)]
        one, other = places[rows], places[columns]
        self._parts = (np.maximum(one, other), np.minimum(one, other), *rest)
        self.width = int(np.max(self._parts[0] - self._parts[1], initial=0))

    def _pairs(self, full, sources):
        """Rows and columns of the reduced lower triangle to which entries of K contribute, their
        factors, and places of these entries in the values; in ``full`` their numbers."""
        i, j = full.coords
        pointer, sizes = self.T.indptr, np.diff(self.T.indptr)
        counts = sizes[i] * sizes[j]
        entry = np.repeat(np.arange(len(i)), counts)
        number = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        a = pointer[i[entry]] + number // sizes[j[entry]]
        b = pointer[j[entry]] + number % sizes[j[entry]]
        rows, columns = self.T.indices[a], self.T.indices[b]
        lower = rows >= columns
        source = sources[full.data[entry[lower]].astype(np.int64)]
        return (rows[lower].astype(np.int64), columns[lower].astype(np.int64),
                (self.T.data[a] * self.T.data[b])[lower], source)

    def sums(self):
        """What values add to the columns of the band, one after another: places, factors, sources;
        see ``storage.add_up``."""
        rows, columns, factors, source = self._parts
        places = columns * (self.width + 1) + rows - columns
        order = np.argsort(places, kind="stable")
        return places[order], factors[order], source[order]


def narrowed(rows, columns, n):
    """(n,) places of unknowns by which a matrix with entries at some ``rows`` and ``columns``
    becomes a narrower band: those with the neighbours farthest off move towards them."""
    best = places = np.arange(n)
    once = coo_array((np.ones(len(rows)), (rows, columns)), shape=(n, n)).tocsr().tocoo()
    (i, j), moved, width, since = once.coords, np.empty(n), np.inf, 0
    while since < STEADY:
        found = storage.pull(i, j, places, PART, moved)
        since += 1
        if found < width:
            best, width, since = places, found, 0
        places = np.empty(n, dtype=np.int64)
        places[np.argsort(moved, kind="stable")] = np.arange(n)
    return best


class BandedConstrained(Constrained):
    """LAPACK's banded Cholesky of the reduced matrix; one that is not positive definite goes to
    SuperLU (measured on 480 elements with a hinge: solves 6 times as fast as SuperLU's)."""

    def __init__(self, solver, T, band):
        super().__init__(solver, T)
        self.name = "banded, constrained"
        self._sums, self._columns = band.sums(), np.zeros((T.shape[1], band.width + 1))
        self._all, self._free = Product(band.T.tocsr()), Product(band.T.T.tocsr())
        self._add_up, self._definite = Call(storage.add_up), True

    def factor(self):
        """Factorize the matrix, see ``linear``."""
        self._add_up(*self._sums, self.values, self._columns.ravel())
        self._cholesky, info = lapack.dpbtrf(self._columns.T, lower=1, overwrite_ab=1)
        self._definite = info == 0
        return 0 if self._definite else super().factor()

    def solve(self, rhs):
        """A new vector (n_dof,), see ``linear``."""
        if not self._definite:
            return super().solve(rhs)
        return self._all(lapack.dpbtrs(self._cholesky, self._free(rhs), lower=1)[0])


class Linking(Constrained):
    """A sparse solver's matrix with what joints add to it, in a basis of what they leave free,
    which is another in each iterate."""

    def __init__(self, solver, system):
        """``solver``: a ``SuperLU`` or ``UnsymmetricLU``, whose storage is used; ``system``:
        ``StillSystem``."""
        super().__init__(solver, None)
        self._system = system

    def matrix(self):
        """The assembled matrix with that of joints, of all unknowns."""
        return (self._solver.matrix() + self._system.second).tocsc()

    def factor(self):
        """Factorize the matrix, see ``linear``."""
        self._matrix, self._T = self.matrix(), self._system.basis()
        return self._factor_reduced(self._matrix)

    def times(self, vector):
        """Product of the matrix that was factorized last with a vector (n_dof,)."""
        return self._matrix @ vector
