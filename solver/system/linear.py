"""Linear solvers behind one small interface: analyse once, then assemble, factor, solve.

Each solver owns the storage that the assembly writes to (its lower triangle) and has

- ``name``: which solver it is, recorded with every result;
- ``storage``: ``(base, offset, diagonal, stride)``, see ``kernels.assembly``;
- ``values``: the 1-D array of that storage; ``factor`` may overwrite it;
- ``factor()``: factorize ``values``; returns how many pivots are negative (None where the method
  does not tell), raises ``SingularMatrix``;
- ``solve(rhs)``: a new vector.
"""

from functools import cached_property

import numpy as np
from scipy.linalg import lapack
from scipy.sparse import csc_array, csr_array, triu
from scipy.sparse.linalg import splu

from ..errors import InputError
from ..kernels import gauss, skyline

SOLVERS = ("auto", "skyline", "dense")

SKYLINE_COST = 1.6
"""Time of an operation of the skyline's factorization over one of banded Cholesky's, which works
on blocks (measured: 1.5 to 1.6 on rings of 5000 and 21 000 unknowns, where both do the same)."""

DIRECT_LIMIT = 1e10
"""Operations of banded Cholesky up to which ``auto`` prefers it, or the skyline, to SuperLU
(measured: equal at 21 000 unknowns on a ring, SuperLU ahead by 1.5 at 83 000)."""


class SingularMatrix(ArithmeticError):
    """A pivot is zero or not finite."""


class Skyline:
    """LDL^T on one-dimensional storage, the paper's solver (own kernels)."""

    name = "skyline"

    def __init__(self, numbering):
        rows = np.arange(numbering.n_dof)
        diagonal = np.cumsum(row_lengths(numbering) + 1) - 1
        self.values = np.zeros(int(diagonal[-1]) + 1)
        self.storage = (diagonal - rows, column_offsets(numbering, 1), diagonal, 1)
        self._work = skyline.workspace(diagonal)

    def factor(self):
        negative, failed = skyline.factor(self.values, self.storage[2], *self._work)
        if failed >= 0:
            raise SingularMatrix(f"pivot {failed} of the skyline factorization is zero")
        return negative

    def solve(self, rhs):
        x = rhs.copy()
        skyline.solve(self.values, self.storage[2], x, self._work[-1])
        return x


class Dense:
    """Gaussian elimination on full storage, the paper's baseline (own kernels)."""

    name = "dense"

    def __init__(self, numbering):
        n = numbering.n_dof
        rows = np.arange(n)
        self.values = np.zeros(n * n)
        self.storage = (rows * n, column_offsets(numbering, 1), rows * (n + 1), 1)
        self._exchanges = np.zeros(n, dtype=np.int64)

    def factor(self):
        self.complete()
        return self.eliminate()

    def complete(self):
        """The upper triangle, which an unsymmetric element would assemble."""
        gauss.mirror(self._matrix())

    def eliminate(self):
        """Factorize the completed matrix."""
        failed = gauss.factor(self._matrix(), self._exchanges)
        if failed >= 0:
            raise SingularMatrix(f"column {failed} of the dense matrix has no pivot")
        return None

    def solve(self, rhs):
        x = rhs.copy()
        gauss.solve(self._matrix(), self._exchanges, x)
        return x

    def _matrix(self):
        n = len(self._exchanges)
        return self.values.reshape(n, n)


class Banded:
    """LAPACK's banded Cholesky; a matrix that is not positive definite goes to the skyline LDL^T
    (measured: 15 times faster than SuperLU on 3000 unknowns)."""

    name = "banded"

    def __init__(self, numbering):
        n = numbering.n_dof
        rows = np.arange(n)
        self._numbering, self._width = numbering, half_bandwidth(numbering)
        self.values = np.zeros(n * (self._width + 1))
        self.storage = (rows, column_offsets(numbering, self._width), rows * (self._width + 1),
                        self._width)
        self._factor = None
        self._definite = True

    def factor(self):
        band = self.values.reshape(-1, self._width + 1).T
        self._factor, info = lapack.dpbtrf(band, lower=1)
        self._definite = info == 0
        if self._definite:
            return 0
        other, source = self._skyline
        np.take(self.values, source, out=other.values)
        return other.factor()

    def solve(self, rhs):
        if self._definite:
            return lapack.dpbtrs(self._factor, rhs, lower=1)[0]
        return self._skyline[0].solve(rhs)

    @cached_property
    def _skyline(self):
        """A ``Skyline``, and where each of its values stands in the band."""
        other = Skyline(self._numbering)
        base, _, diagonal, _ = other.storage
        rows = np.repeat(np.arange(len(diagonal)), np.diff(diagonal, prepend=-1))
        columns = np.arange(len(rows)) - base[rows]
        return other, rows + columns * self._width


class SuperLU:
    """SciPy's SuperLU, tuned for a symmetric pattern, for bands too wide for Cholesky."""

    name = "superlu"

    def __init__(self, numbering):
        row_pointer, lower, offset = _lower_pattern(numbering)
        self.values = np.zeros(lower.nnz)
        self.storage = (row_pointer[:-1], offset, row_pointer[1:] - 1, 1)
        lower.data[:] = np.arange(1.0, lower.nnz + 1.0)
        self._matrix = csc_array(lower + triu(lower.T, 1))
        self._source = self._matrix.data.astype(np.int64) - 1
        self._factor = None

    def factor(self):
        np.take(self.values, self._source, out=self._matrix.data)
        self._factor = _superlu(self._matrix)
        return _negative_pivots(self._factor)

    def solve(self, rhs):
        return self._factor.solve(rhs)


def make_solver(name, numbering):
    """The solver ``name`` (one of ``SOLVERS``) for a numbering; ``auto`` picks the fastest: the
    skyline where its rows are short beside the longest, else banded Cholesky, and SuperLU for the
    largest models."""
    if name == "skyline":
        return Skyline(numbering)
    if name == "dense":
        return Dense(numbering)
    if name == "auto":
        lengths = row_lengths(numbering).astype(float)
        work = {Skyline: SKYLINE_COST * np.sum(lengths**2),
                Banded: len(lengths) * np.max(lengths)**2, SuperLU: DIRECT_LIMIT}
        return min(work, key=work.get)(numbering)
    raise InputError(f"solver '{name}' is unknown, must be one of: {', '.join(SOLVERS)}")


def row_lengths(numbering):
    """(n_dof,) distances of the first entries of the lower triangle's rows from the diagonal."""
    return np.arange(numbering.n_dof) - numbering.first_neighbour[numbering.node_of_dof]


def half_bandwidth(numbering):
    """Largest distance of an entry of the lower triangle from the diagonal."""
    return int(np.max(row_lengths(numbering)))


def column_offsets(numbering, stride):
    """(n_elem, 4, 4) ``stride`` times the first dof of the column node: storages affine in j."""
    starts = stride * numbering.start[numbering.quads]
    return np.ascontiguousarray(np.broadcast_to(starts[:, None, :], (len(starts), 4, 4)))


def _lower_pattern(numbering):
    """Row pointer, CSR pattern and element offsets of the lower triangle, by blocks of nodes."""
    quads, start, sizes = numbering.quads, numbering.start, 3 + numbering.n_rot
    n_nodes = len(start)
    rows = np.repeat(quads, 4, axis=1).ravel()
    columns = np.tile(quads, (1, 4)).ravel()
    keep = start[columns] <= start[rows]
    pairs = np.unique(np.stack([start[rows[keep]], start[columns[keep]],
                                rows[keep], columns[keep]], axis=1), axis=0)
    row_node, column_node = pairs[:, 2], pairs[:, 3]
    widths = sizes[column_node]
    # offset of each block within the rows of its node: columns ascend inside a row node
    begin = np.cumsum(widths) - widths
    first_of_node = np.full(n_nodes, -1)
    head = np.flatnonzero(np.r_[True, row_node[1:] != row_node[:-1]])
    first_of_node[row_node[head]] = begin[head]
    block_offset = begin - first_of_node[row_node]
    before_own = np.zeros(n_nodes, dtype=np.int64)
    own = row_node == column_node
    before_own[row_node[own]] = block_offset[own]
    nodes = numbering.node_of_dof
    within = np.arange(numbering.n_dof) - start[nodes]
    lengths = before_own[nodes] + within + 1
    row_pointer = np.r_[0, np.cumsum(lengths)]
    lookup = csr_array((block_offset + 1.0, (row_node, column_node)), shape=(n_nodes, n_nodes))
    offset = np.zeros((len(quads), 4, 4), dtype=np.int64)
    for a in range(4):
        for b in range(4):
            offset[:, a, b] = np.asarray(lookup[quads[:, a], quads[:, b]]).ravel() - 1
    blocks_of = np.split(np.arange(len(pairs)), head[1:])
    columns_of = {row_node[group[0]]: np.concatenate(
        [np.arange(start[column_node[k]], start[column_node[k]] + widths[k]) for k in group])
        for group in blocks_of}
    indices = np.concatenate([columns_of[node][:length] for node, length in zip(nodes, lengths)])
    pattern = csr_array((np.zeros(len(indices)), indices, row_pointer),
                        shape=(numbering.n_dof, numbering.n_dof))
    return row_pointer.astype(np.int64), pattern, offset


def _superlu(matrix):
    try:
        return splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.01,
                    options={"SymmetricMode": True})
    except RuntimeError as error:
        raise SingularMatrix(str(error)) from None


def _negative_pivots(factor):
    """Negative diagonal entries of U: the inertia as far as pivots stayed on the diagonal."""
    return int(np.sum(factor.U.diagonal() < 0.0))
