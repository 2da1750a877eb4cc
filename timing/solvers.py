"""Linear solvers for comparison only: what a matrix would need from LAPACK if it were unsymmetric.

Both have the interface of ``system.linear``.  The assembly gives them the lower triangle, and
``complete`` fills in the other one, which an unsymmetric element would assemble: it counts as
assembly, ``eliminate`` as factorization.
"""

import numpy as np
from scipy.linalg import lapack

from corovec.solver.system.failure import SingularMatrix
from corovec.solver.system.linear import (
    NO_SKEW,
    SOLVERS,
    Banded,
    Dense,
    affine_storages,
    half_bandwidth,
)
from corovec.solver.system.system import System


class DenseLU(Dense):
    """LAPACK's LU of the full matrix (getrf): dense elimination as fast as it gets."""

    name = "lapack-lu"

    def eliminate(self):
        self._lu, self._exchanges, info = lapack.dgetrf(self.matrix().T, overwrite_a=1)
        _check(info)

    def solve(self, rhs):
        return lapack.dgetrs(self._lu, self._exchanges, rhs)[0]


class BandedLU:
    """LAPACK's LU of the band with partial pivoting (gbtrf): sparsity used, symmetry not."""

    name = "banded-lu"

    def __init__(self, numbering):
        n, width = numbering.n_dof, half_bandwidth(numbering)
        rows = np.arange(n)
        self.values = np.zeros(n * (3 * width + 1))
        self.skew = NO_SKEW
        self.storages = affine_storages(numbering, rows + 2 * width,
                                        2 * width + rows * (3 * width + 1), 3 * width)
        self.storage = self.storages[0]
        self._width = width

    def factor(self):
        self.complete()
        self.eliminate()

    def complete(self):
        w, band = self._width, self._band()
        for d in range(1, w + 1):
            band[d:, 2 * w - d] = band[:-d, 2 * w + d]

    def eliminate(self):
        w = self._width
        self._lu, self._exchanges, info = lapack.dgbtrf(self._band().T, w, w, overwrite_ab=1)
        _check(info)

    def _band(self):
        return self.values.reshape(-1, 3 * self._width + 1)

    def solve(self, rhs):
        w = self._width
        return lapack.dgbtrs(self._lu, w, w, rhs, self._exchanges)[0]


COMPARED = {"lapack-lu": DenseLU, "banded-lu": BandedLU, "banded-cholesky": Banded}

METHODS = {"skyline": "skyline LDL^T", "dense": "dense Gaussian elimination",
           "auto": "production default", "lapack-lu": "LAPACK dense LU",
           "banded-lu": "LAPACK banded LU, unsymmetric",
           "banded-cholesky": "LAPACK banded Cholesky"}


def make_system(model, method):
    """``System`` with one of ``METHODS`` as its linear solver."""
    if method in SOLVERS:
        return System(model, method)
    system = System(model, "skyline")
    system.solver = COMPARED[method](system.numbering)
    return system


def _check(info):
    if info > 0:
        raise SingularMatrix(f"column {info - 1} of the matrix has no pivot")
