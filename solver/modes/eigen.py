"""Eigenvalues of sparse symmetric matrices: shift-invert Lanczos (ARPACK) on our factorizations."""

from contextlib import contextmanager

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import block_array, block_diag
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from ..errors import InputError, StepError
from ..system.failure import SingularMatrix, told
from ..system.linear import diagonal_lu

MOST_SHIFTS = 200

DENSE = 0.4
"""Part of all eigenvalues from which they are computed at once, by LAPACK."""

ROUGH = 0.05
"""Relative error of an estimate of an eigenvalue."""

NONE = 1e-9
"""Largest eigenvalue relative to the largest of all that is rounding."""

LARGEST_DENSE = 4000
"""Free dofs up to which that is possible."""


def lowest(K, M, n, shift):
    """The lowest n of ``K v = lambda M v``, M positive definite: (lambda (n,), v (n_dof, n)) with
    ``v^T M v = 1``, ascending.

    Lanczos with ``(K + shift M)^-1``.  The shift is doubled until K + shift M is positive definite:
    no eigenvalue then lies below -shift, and those that are found are the lowest.

    Args:
        K, M: (n_dof, n_dof) sparse.
        n: how many.
        shift: to begin with; above zero, so that a free body's K will do.
    """
    check_number(n, K.shape[0])
    if n > DENSE * K.shape[0]:
        return eigh(K.toarray(), M.toarray(), subset_by_index=(0, n - 1))
    for _ in range(MOST_SHIFTS):
        try:
            factor, negative = diagonal_lu(K + shift * M)
        except SingularMatrix:
            negative = None
        if negative == 0:
            break
        shift *= 2.0
    else:
        raise StepError("no shift makes the tangent positive definite")
    with _arpack():
        values, vectors = eigsh(K, n, M, sigma=-shift, OPinv=_operator(K, factor.solve),
                                v0=first_vector(K))
    order = np.argsort(values)
    return values[order], vectors[:, order]


def lowest_gyroscopic(K, G, M, n):
    """The lowest n frequencies of ``M u'' + G u' + K u = 0``, G skew, K and M positive definite:
    (omega (n,), v (n_dof, n) complex) with ``v^H M v = 1``, of ``u = v exp(i omega t)``.

    With ``w = omega v``, ``[[-iG, M], [M, 0]] (v, w) = 1/omega [[K, 0], [0, M]] (v, w)``: both
    Hermitian, so that omega is real.

    Raises:
        StepError: K is not positive definite.
    """
    check_number(n, K.shape[0], DENSE)
    with told():
        (of_K, negative), (of_M, _) = diagonal_lu(K), diagonal_lu(M)
    if negative:
        raise StepError(f"without Coriolis forces the equilibrium is unstable in {negative} "
                        "directions: its modes in the frame that turns are not computed")
    A = block_array([[-1j * G, M], [M, None]]).tocsr()
    B = block_diag([K, M]).tocsr()
    half = K.shape[0]

    def solve(v):
        return np.concatenate([of.solve(part.real.copy()) + 1j * of.solve(part.imag.copy())
                               for of, part in ((of_K, v[:half]), (of_M, v[half:]))])

    with _arpack():
        inverse, vectors = eigsh(A, n, B, Minv=_operator(A, solve), which="LA",
                                 v0=first_vector(A).astype(complex))
    order = np.argsort(-inverse.real)
    vectors = vectors[:half, order]
    sizes = np.einsum("ij,ij->j", vectors.conj(), M @ vectors).real
    return 1.0 / inverse.real[order], vectors / np.sqrt(sizes)


def most_negative(A, K, n, solve):
    """The n most negative mu of ``A v = mu K v``, K positive definite with ``solve(v) = K^-1 v``:
    (mu, v), ascending, fewer than n where the others are rounding beside the largest.

    That one, roughly, is the shift of ``lowest``: of a cylinder many lie close together.
    """
    check_number(n, K.shape[0])
    with _arpack():
        rough, _ = eigsh(A, 1, K, Minv=_operator(A, solve), v0=first_vector(A), tol=ROUGH)
    largest = abs(rough[0])
    values, vectors = lowest(A, K, n, (1.0 + 2.0 * ROUGH) * largest)
    found = values < -NONE * largest
    return values[found], vectors[:, found]


def check_number(n, n_dof, part=1.0):
    """InputError where more eigenvalues are asked for than can be computed of ``n_dof``."""
    most = int(part * n_dof) if part < 1.0 or n_dof <= LARGEST_DENSE else int(DENSE * n_dof)
    if n > most:
        raise InputError(f"n must be {most} at most with {n_dof} free unknowns, is {n}")


def first_vector(K):
    """Where Lanczos starts: without any symmetry, the same every time."""
    return np.random.default_rng(0).standard_normal(K.shape[0])


def _operator(K, solve):
    return LinearOperator(K.shape, matvec=solve, dtype=K.dtype)


@contextmanager
def _arpack():
    """What ARPACK says, as ``StepError``."""
    try:
        yield
    except ArpackError as error:
        raise StepError(f"the eigenvalues were not found: {error}") from None
