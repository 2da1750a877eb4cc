"""Linear solvers behind one small interface: analyse once, then assemble, factor, solve.

Each solver owns the storage that the assembly writes to and has

- ``name``: which solver it is, recorded with every result;
- ``storages``: an ``arguments.Storage`` for the cells of each kind, the elements first; ``storage``
  is that of the elements;
- ``values``: the 1-D array that holds the lower triangle of the symmetric part; ``factor`` may
  overwrite it;
- ``skew``: the same of the skew part, empty where the solver takes symmetric matrices only;
- ``factor()``: factorize the matrix; returns how many pivots are negative (None where the method
  does not tell), raises ``SingularMatrix``;
- ``solve(rhs)``: a new vector;
- ``solve_rows(rows)``: the same of each row, in its place.
"""

from functools import cache, cached_property, partial
from importlib import import_module

import numpy as np
from scipy.linalg import lapack
from scipy.sparse import csc_array, csr_array, diags_array
from scipy.sparse.linalg import LinearOperator, cg, splu

from ..errors import InputError
from ..kernels import banded, gauss, skyline, storage
from ..kernels.arguments import DONE, Storage
from .failure import SingularMatrix
from .numbering import node_pairs

SOLVERS = ("auto", "skyline", "dense")

SKYLINE_COST = 1.6
"""Time of an operation of the skyline's factorization over one of banded Cholesky's, which works
on blocks (measured: 1.5 to 1.6 on rings of 5000 and 21 000 unknowns, where both do the same)."""

DIRECT_LIMIT = 1e10
"""Operations of banded Cholesky up to which ``auto`` prefers it, or the skyline, to SuperLU
(measured: equal at 21 000 unknowns on a ring, SuperLU ahead by 1.5 at 83 000)."""

SPARSE_LIMIT = 1e9
"""The same up to which they are preferred to RSLAB."""

SIDE_BY_SIDE = 3
"""Right-hand sides from which a kernel that takes eight at once is faster than LAPACK, one by one
(measured: eight take as long as two or three, 2700 unknowns, 75 entries a row)."""

MASS_ERROR, MOST_ITERATIONS = 1e-14, 200
"""Residual of the accelerations at the start, relative, and iterations after which a mass matrix is
factorized all the same (measured: 45 suffice)."""

NOT_TOLD = -1
"""Number of indefinite matrices where the solver does not tell."""

NO_SKEW = np.zeros(0)
"""The skew part of a matrix that has none."""


class OneByOne:
    """A solver that takes several right-hand sides one after the other."""

    def solve_rows(self, rows):
        """Overwrite rows (m, n_dof) with solutions."""
        for row in rows:
            row[:] = self.solve(row)


class Skyline(OneByOne):
    """LDL^T on one-dimensional storage, the paper's solver (own kernels)."""

    name = "skyline"

    def __init__(self, numbering):
        rows = np.arange(numbering.n_dof)
        diagonal = np.cumsum(row_lengths(numbering) + 1) - 1
        self.values = np.zeros(int(diagonal[-1]) + 1)
        self.skew = NO_SKEW
        self.storages = affine_storages(numbering, diagonal - rows, diagonal, 1)
        self.storage = self.storages[0]
        self._work = skyline.workspace(diagonal)

    def factor(self):
        """Factorize the matrix, see the module."""
        negative, failed = skyline.factor(self.values, self.storage.diagonal, *self._work)
        if failed != DONE:
            raise SingularMatrix(f"pivot {failed} of the skyline factorization is zero")
        return negative

    def solve(self, rhs):
        """A new vector (n_dof,), see the module."""
        x = rhs.copy()
        skyline.solve(self.values, self.storage.diagonal, x, self._work[-1])
        return x


class Dense(OneByOne):
    """Gaussian elimination on full storage, the paper's baseline (own kernels)."""

    name = "dense"

    def __init__(self, numbering):
        n = numbering.n_dof
        rows = np.arange(n)
        self.values = np.zeros(n * n)
        self.skew = NO_SKEW
        self.storages = affine_storages(numbering, rows * n, rows * (n + 1), 1)
        self.storage = self.storages[0]
        self._exchanges = np.zeros(n, dtype=np.int64)

    def factor(self):
        """Factorize the matrix, see the module."""
        self.complete()
        self.eliminate()

    def complete(self):
        """The upper triangle, which an unsymmetric element would assemble."""
        gauss.mirror(self.matrix())

    def eliminate(self):
        """Factorize the completed matrix."""
        failed = gauss.factor(self.matrix(), self._exchanges)
        if failed != DONE:
            raise SingularMatrix(f"column {failed} of the dense matrix has no pivot")

    def solve(self, rhs):
        """A new vector (n_dof,), see the module."""
        x = rhs.copy()
        gauss.solve(self.matrix(), self._exchanges, x)
        return x

    def matrix(self):
        """The full matrix (n, n)."""
        n = len(self._exchanges)
        return self.values.reshape(n, n)


class Banded(OneByOne):
    """LAPACK's banded Cholesky; a matrix that is not positive definite goes to the skyline LDL^T
    (measured: 15 times faster than SuperLU on 3000 unknowns)."""

    name = "banded"

    def __init__(self, numbering):
        n = numbering.n_dof
        rows = np.arange(n)
        self._numbering, self._width = numbering, half_bandwidth(numbering)
        self.values = np.zeros(n * (self._width + 1))
        self.skew = NO_SKEW
        self.storages = affine_storages(numbering, rows, rows * (self._width + 1), self._width)
        self.storage = self.storages[0]
        self._factor = None
        self._definite = True

    def factor(self):
        """Factorize the matrix, see the module."""
        band = self.values.reshape(-1, self._width + 1).T
        self._factor, info = lapack.dpbtrf(band, lower=1)
        self._definite = info == 0
        if self._definite:
            return 0
        other, source = self._skyline
        np.take(self.values, source, out=other.values)
        return other.factor()

    def solve(self, rhs):
        """A new vector (n_dof,), see the module."""
        if self._definite:
            return lapack.dpbtrs(self._factor, rhs, lower=1)[0]
        return self._skyline[0].solve(rhs)

    def solve_rows(self, rows):
        if self._definite and len(rows) >= SIDE_BY_SIDE:
            banded.solve(self._factor.T, rows)
        else:
            super().solve_rows(rows)

    @cached_property
    def _skyline(self):
        """A ``Skyline``, and where each of its values stands in the band."""
        other = Skyline(self._numbering)
        base, diagonal = other.storage.base, other.storage.diagonal
        rows = np.repeat(np.arange(len(diagonal)), np.diff(diagonal, prepend=-1))
        columns = np.arange(len(rows)) - base[rows]
        return other, rows + columns * self._width


class Sparse(OneByOne):
    """A symmetric matrix in sparse storage; what factorizes it comes with a subclass.

    Attributes:
        lower: (n_dof, n_dof) lower triangle by rows, whose ``values`` are assembled into.
    """

    def __init__(self, numbering):
        self.storages, self.lower = sparse_storages(numbering)
        self.storage, self.skew = self.storages[0], NO_SKEW
        self.values = self.lower.data
        self._factor = None

    def matrix(self):
        """The assembled matrix, in the array of the last one."""
        matrix, source = self._mirror
        np.take(self.values, source, out=matrix.data, mode="clip")  # the others copy once more
        return matrix

    @cached_property
    def _mirror(self):
        """The full matrix, and of each entry the place in the values."""
        return _mirrored(self.lower)

    @property
    def sources(self):
        """Of each entry of ``matrix`` the place in the values."""
        return self._mirror[1]

    def solve(self, rhs):
        """A new vector (n_dof,), see the module."""
        return self._factor.solve(rhs)


class SuperLU(Sparse):
    """SciPy's SuperLU, tuned for a symmetric pattern, for bands too wide for Cholesky."""

    name = "superlu"

    def factor(self):
        """Factorize the matrix, see the module."""
        self._factor, negative = diagonal_lu(self.matrix())
        return negative


class SparseLDL(Sparse):
    """LDL^T of RSLAB, where it is installed: analysed once, several times as fast as SuperLU on
    large models, the same to the last bit on every run and with any number of threads.

    It takes lower triangles by columns.  Those of the last unknown first are the rows that are
    assembled, backwards.
    """

    name = "rslab"

    def __init__(self, numbering, threads=1):
        super().__init__(numbering)
        self._analysis, self._threads = None, threads

    def factor(self):
        """Factorize the matrix, see the module."""
        values = self.values[::-1].copy()
        if self._analysis is None:
            self._analysis = rslab().analyze(_backwards(self.lower, values), path="ldlt",
                                             threads=self._threads)
        try:
            self._factor = self._analysis.factor(values)
        except RuntimeError as error:
            raise SingularMatrix(str(error)) from None
        _, negative, zero = self._factor.inertia
        if zero or self._factor.n_perturbed:
            raise SingularMatrix("a pivot of the sparse factorization is zero")
        return negative

    def solve(self, rhs):
        """A new vector (n_dof,), see the module."""
        return self._factor.solve(rhs[::-1].copy(), refine=0)[::-1].copy()


class UnsymmetricLU(Sparse):
    """SciPy's SuperLU of a matrix with a skew part: the tangent of loads that follow the shell."""

    name = "superlu (unsymmetric)"

    def __init__(self, numbering):
        super().__init__(numbering)
        self.skew = np.zeros_like(self.values)
        full, self._source = self._mirror
        columns = np.repeat(np.arange(numbering.n_dof), np.diff(full.indptr))
        self._sign = np.where(full.indices < columns, -1.0, 1.0)

    def matrix(self):
        """The assembled matrix, in the array of the last one."""
        matrix = super().matrix()
        matrix.data[:] += self._sign * self.skew[self._source]
        return matrix

    def factor(self):
        """Factorize the matrix; the number of negative pivots is not told."""
        self._factor = unsymmetric_lu(self.matrix())


@cache
def rslab():
    """The module of that name, None where it is not installed."""
    try:
        return import_module("rslab")
    except ImportError:
        return None


def make_solver(name, numbering, threads=1):
    """The solver ``name`` (one of ``SOLVERS``) for a numbering; ``auto`` picks the fastest: the
    skyline where its rows are short beside the longest, else banded Cholesky, and for the largest
    models RSLAB or, where that is not installed, SuperLU.  RSLAB alone takes several ``threads``.
    """
    if name == "skyline":
        return Skyline(numbering)
    if name == "dense":
        return Dense(numbering)
    if name == "auto":
        lengths = row_lengths(numbering).astype(float)
        work = {Skyline: SKYLINE_COST * np.sum(lengths**2),
                Banded: len(lengths) * np.max(lengths)**2}
        work.update({partial(SparseLDL, threads=threads): SPARSE_LIMIT} if rslab()
                    else {SuperLU: DIRECT_LIMIT})
        return min(work, key=work.get)(numbering)
    raise InputError(f"solver '{name}' is unknown, must be one of: {', '.join(SOLVERS)}")


def solve_mass(solver, rhs):
    """Solution (n_dof,) for the mass matrix that ``solver`` has assembled, whatever its size.

    Scaled by its diagonal a mass matrix has a condition number of about ten, so that conjugate
    gradients are at rounding error soon: in 2 s for 100 000 elements, where SuperLU took 30 s and
    2 GB for a factorization that nothing else needs.
    """
    if isinstance(solver, SuperLU | SparseLDL):
        lower = solver.lower.copy()
        lower.eliminate_zeros()
        diagonal, upper = lower.diagonal(), lower.T
        matrix = LinearOperator(lower.shape, dtype=float,
                                matvec=lambda x: lower @ x + upper @ x - diagonal * x)
        x, missed = cg(matrix, rhs, rtol=MASS_ERROR, maxiter=MOST_ITERATIONS,
                       M=diags_array(1.0 / diagonal))
        if not missed:
            return x
    solver.factor()
    return solver.solve(rhs)


def row_lengths(numbering):
    """(n_dof,) distances of the first entries of the lower triangle's rows from the diagonal."""
    return np.arange(numbering.n_dof) - numbering.first_neighbour[numbering.node_of_dof]


def half_bandwidth(numbering):
    """Largest distance of an entry of the lower triangle from the diagonal."""
    return int(np.max(row_lengths(numbering)))


def affine_storages(numbering, base, diagonal, stride):
    """``Storage`` s in which the columns of a row are ``stride`` apart, the first dof of the model
    at ``base``."""
    return tuple(Storage(base, _column_offsets(numbering, cell, stride), diagonal, stride)
                 for cell in numbering.cells)


def _column_offsets(numbering, cell, stride):
    """(n, k, k) ``stride`` times the first dof of the column node."""
    starts = stride * numbering.start[cell]
    n, k = cell.shape
    return np.ascontiguousarray(np.broadcast_to(starts[:, None, :], (n, k, k)))


def sparse_storages(numbering):
    """``Storage`` s and CSR pattern of the lower triangle, by blocks of nodes."""
    start, sizes = numbering.start, 3 + numbering.n_rot
    order = np.argsort(start)  # blocks are sorted by the places of their nodes
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    rows, columns = (rank[nodes] for nodes in node_pairs(numbering.cells))
    keep = columns <= rows
    blocks = csr_array((np.ones(keep.sum()), (rows[keep], columns[keep])), shape=2 * order.shape)
    blocks.sort_indices()
    widths = sizes[order[blocks.indices]]
    begin = np.cumsum(widths) - widths
    first = begin[blocks.indptr[:-1]]
    # offset of each block within the rows of its node, the own block last
    blocks.data = begin - np.repeat(first, np.diff(blocks.indptr)) + 1.0
    own = blocks.data[blocks.indptr[1:] - 1].astype(np.int64)
    lookup = blocks[rank][:, rank]
    columns = _ranges(start[order[blocks.indices]], widths)
    at = rank[numbering.node_of_dof]
    lengths = own[at] + np.arange(numbering.n_dof) - start[order[at]]
    row_pointer = np.r_[0, np.cumsum(lengths)].astype(np.int64)
    indices = columns[_ranges(first[at], lengths)].astype(np.int32)
    pattern = csr_array((np.zeros(len(indices)), indices, row_pointer.astype(np.int32)),
                        shape=(numbering.n_dof, numbering.n_dof))
    storages = tuple(Storage(row_pointer[:-1], _block_offsets(cell, lookup), row_pointer[1:] - 1, 1)
                     for cell in numbering.cells)
    return storages, pattern


def _block_offsets(cell, lookup):
    """(n, k, k) offsets of the blocks of a cell within the rows of their row node."""
    n, k = cell.shape
    offset = np.zeros((n, k, k), dtype=np.int64)
    for i in range(k):
        for j in range(k):
            offset[:, i, j] = np.asarray(lookup[cell[:, i], cell[:, j]]).ravel() - 1
    return offset


def _ranges(begin, lengths):
    """Ranges of these ``lengths``, one after another, each from its ``begin`` on."""
    skipped = begin - (np.cumsum(lengths) - lengths)
    return np.repeat(skipped, lengths) + np.arange(lengths.sum())


def _mirrored(lower):
    """The full matrix of a lower triangle, and of each entry the place in its values."""
    n, pointer = lower.shape[0], lower.indptr
    sizes = np.bincount(lower.indices, minlength=n) + np.diff(pointer) - 1
    full = np.r_[0, np.cumsum(sizes)].astype(np.int32)
    rows, source = np.empty(full[-1], dtype=np.int32), np.empty(full[-1], dtype=np.int64)
    storage.mirror(pointer, lower.indices, full[:-1].copy(), rows, source)
    return csc_array((np.zeros(full[-1]), rows, full), shape=lower.shape), source


def _backwards(lower, values):
    """A lower triangle by rows, the last unknown first: a lower triangle by columns; ``values`` are
    its own, backwards."""
    n = lower.shape[0]
    return csc_array((values, n - 1 - lower.indices[::-1], lower.nnz - lower.indptr[::-1]),
                     shape=lower.shape)


def diagonal_lu(matrix):
    """SuperLU of a symmetric sparse matrix with every pivot on the diagonal, and how many pivots
    are negative: as many eigenvalues are (Sylvester).

    Raises:
        SingularMatrix: a pivot is zero.
    """
    factor = unsymmetric_lu(matrix, threshold=0.0)
    if not np.array_equal(factor.perm_r, factor.perm_c):
        raise SingularMatrix("a pivot of the sparse factorization is zero")
    return factor, int(np.sum(factor.U.diagonal() < 0.0))


def unsymmetric_lu(matrix, threshold=0.01):
    """LU of a matrix with a symmetric pattern, tuned for one (measured: 4 to 15 times as fast as
    the default; MMD_AT_PLUS_A without the other options is a trap)."""
    try:
        return splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=threshold,
                    options={"SymmetricMode": True})
    except RuntimeError as error:
        raise SingularMatrix(str(error)) from None
