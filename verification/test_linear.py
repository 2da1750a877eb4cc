"""The linear solvers against LAPACK, on random matrices and on real tangents."""

import numpy as np
import pytest
import scipy.linalg
from scipy.sparse import csc_array

from corovec import InputError
from corovec.solver.dynamics.scheme import Scheme
from corovec.solver.kernels import gauss, skyline
from corovec.solver.kernels.arguments import MASS_ONLY
from corovec.solver.system import linear
from corovec.solver.system.failure import SingularMatrix
from corovec.solver.system.linear import (
    Banded,
    Skyline,
    SparseLDL,
    SuperLU,
    make_solver,
    solve_mass,
)
from corovec.solver.system.numbering import number_dofs
from corovec.verification.helpers import SOLVERS, assemble, full_matrix, make_system
from corovec.verification.models import cross_code_plate, rectangle, warped_patch


def random_skyline(rng, n, reach, definite=True):
    """A random symmetric matrix with a ragged profile, full and in skyline storage."""
    first = np.array([rng.integers(max(0, i - reach), i + 1) for i in range(n)])
    L, d = np.zeros((n, n)), rng.uniform(0.5, 2.0, n)
    if not definite:
        d[rng.permutation(n)[:n // 3]] *= -1.0
    for i in range(n):
        L[i, first[i]:i] = rng.uniform(-1.0, 1.0, i - first[i]) / np.sqrt(reach)
        L[i, i] = 1.0
    A = L @ np.diag(d) @ L.T
    diagonal = np.cumsum(np.arange(n) - first + 1) - 1
    values = np.concatenate([A[i, first[i]:i + 1] for i in range(n)])
    return A, values, diagonal, d


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 9, 40, 173])
@pytest.mark.parametrize("reach", [12, 70])
@pytest.mark.parametrize("definite", [True, False])
def test_skyline_against_lapack(n, reach, definite):
    """LDL^T, its pivots' signs (Sylvester) and the solution, for profiles of every raggedness."""
    rng = np.random.default_rng(n)
    A, values, diagonal, d = random_skyline(rng, n, reach, definite)
    negative, failed = skyline.factor(values, diagonal, *skyline.workspace(diagonal))
    assert failed == -1
    assert negative == np.sum(np.linalg.eigvalsh(A) < 0.0)
    assert np.allclose(values[diagonal], d, rtol=1e-9)
    b = rng.normal(size=n)
    x = b.copy()
    skyline.solve(values, diagonal, x, np.zeros(8))
    reference = scipy.linalg.solve(A, b)
    # backward stable up to the growth of L (entries below 1): condition times eps, with margin
    assert np.abs(x - reference).max() < 1e-14 * np.linalg.cond(A) * np.abs(reference).max()


def test_skyline_zero_pivot_is_reported():
    values, diagonal = np.array([1.0, 1.0, 1.0]), np.array([0, 2])
    assert skyline.factor(values, diagonal, *skyline.workspace(diagonal)) == (0, 1)
    for wrong in (np.nan, np.inf, -np.inf):
        values = np.array([1.0, 0.0, wrong])
        assert skyline.factor(values, diagonal, *skyline.workspace(diagonal)) == (0, 1)


@pytest.mark.parametrize("n", [1, 2, 7, 60])
def test_gauss_against_lapack(n):
    """Gaussian elimination with partial pivoting on unsymmetric matrices."""
    rng = np.random.default_rng(n)
    A, b = rng.normal(size=(n, n)), rng.normal(size=n)
    A[0, 0] = 0.0 if n > 1 else 2.0
    factors, rows, x = A.copy(), np.zeros(n, dtype=np.int64), b.copy()
    assert gauss.factor(factors, rows) == -1
    gauss.solve(factors, rows, x)
    assert np.array_equal(rows, scipy.linalg.lu_factor(A)[1])
    assert np.allclose(x, np.linalg.solve(A, b), rtol=0, atol=1e-13 * np.linalg.cond(A))


def test_gauss_singular_is_reported():
    assert gauss.factor(np.zeros((3, 3)), np.zeros(3, dtype=np.int64)) == 0
    assert gauss.factor(np.ones((2, 2)), np.zeros(2, dtype=np.int64)) == 1


@pytest.mark.parametrize("kind", SOLVERS)
@pytest.mark.parametrize("shell", ["warped", "plate"])
def test_real_tangents(kind, shell):
    """Solutions with the iteration matrix of a step, against LAPACK on the full matrix."""
    rng = np.random.default_rng(4)
    model = warped_patch(rng, (5, 4)) if shell == "warped" else cross_code_plate(1)
    system = make_system(model, kind)
    state, n = system.initial_state(), system.numbering.n_dof
    delta = rng.uniform(-1e-3, 1e-3, n)
    step = Scheme().midpoint(1e-2)
    assemble(system, state, step, delta)
    A, b = full_matrix(system), rng.normal(size=n)
    negative = system.solver.factor()
    x = system.solver.solve(b)
    reference = scipy.linalg.solve(A, b, assume_a="sym")
    assert np.abs(x - reference).max() < 1e-15 * np.linalg.cond(A) * np.abs(reference).max()
    assert negative in (None, int(np.sum(np.linalg.eigvalsh(A) < 0.0)))


@pytest.mark.parametrize("solver_class", [Skyline, Banded, SuperLU, SparseLDL])
def test_indefinite_matrix_is_handled_and_told(solver_class):
    """An indefinite tangent is solved all the same, and its negative pivots are counted."""
    rng = np.random.default_rng(0)
    model = rectangle(3.0, 2.0, (3, 2))
    numbering = number_dofs((model.quads,), np.full(len(model.nodes), 2))
    solver = solver_class(numbering)
    system = make_system(model)
    system.solver = solver
    n = numbering.n_dof
    assemble(system, system.initial_state(), Scheme().midpoint(1e-2), np.zeros(n))
    solver.values[solver.storage.diagonal[7]] -= 1e6
    A, b = full_matrix(system), rng.normal(size=n)
    assert solver.factor() == np.sum(np.linalg.eigvalsh(A) < 0.0) == 1
    residual = A @ solver.solve(b) - b
    assert np.abs(residual).max() < 1e-8


def test_a_pivot_off_the_diagonal_is_refused():
    """SuperLU takes one where that on the diagonal is zero; the signs of its pivots would tell
    nothing of the eigenvalues, here 1 and -1."""
    with pytest.raises(SingularMatrix, match="zero"):
        linear.diagonal_lu(csc_array([[0.0, 1.0], [1.0, 0.0]]))


@pytest.mark.parametrize("solver_class", [Skyline, Banded, SuperLU, SparseLDL])
def test_singular_matrix_raises(solver_class):
    model = rectangle(1.0, 1.0, (1, 1))
    with pytest.raises(SingularMatrix):
        solver_class(number_dofs((model.quads,), np.full(4, 2))).factor()


def test_node_order_narrows_the_band():
    """L-plate 8x60: the mean row holds little more than one row of 9 nodes (45) plus a neighbour
    and a half row, although the corner couples two rows."""
    model = cross_code_plate(4)
    numbering = number_dofs((model.quads,), np.full(len(model.nodes), 2))
    solver = Skyline(numbering)
    n = numbering.n_dof
    assert n == 2745
    assert 45 * n < len(solver.values) < 65 * n
    assert sorted(numbering.start) == list(range(0, n, 5))


def test_unknown_solver():
    model = rectangle(1.0, 1.0, (1, 1))
    with pytest.raises(InputError, match="solver 'cramer' is unknown, must be one of: auto"):
        make_solver("cramer", number_dofs((model.quads,), np.full(4, 2)))


def test_masses_need_no_factorization(monkeypatch):
    """Accelerations at the start by conjugate gradients, as by a factorization, which there is
    where they do not converge."""
    rng = np.random.default_rng(2)
    model = warped_patch(rng, (5, 4))
    systems = [make_system(model, kind) for kind in ("superlu", "skyline")]
    found = []
    for system in systems:
        n = system.numbering.n_dof
        assemble(system, system.initial_state(), MASS_ONLY, np.zeros(n))
        b, A = np.cos(np.arange(n)), full_matrix(system)
        found.append(solve_mass(system.solver, b))
        # the residual of conjugate gradients is 1e-14 of b, the condition of the matrix 1e3
        assert np.abs(found[-1] - np.linalg.solve(A, b)).max() < 1e-12 * np.abs(found[-1]).max()
    assert systems[0].solver._factor is None
    monkeypatch.setattr(linear, "MOST_ITERATIONS", 3)
    again = solve_mass(systems[0].solver, b)
    assert systems[0].solver._factor is not None
    assert np.abs(again - found[0]).max() < 1e-12 * np.abs(again).max()


def test_full_matrix_of_a_lower_triangle():
    """Pattern and places of the values: the whole matrix is that of both triangles."""
    rng = np.random.default_rng(3)
    solver = make_system(warped_patch(rng, (4, 3)), "superlu").solver
    solver.values[:] = rng.normal(size=len(solver.values))
    lower = np.tril(solver.matrix().toarray())
    assert np.count_nonzero(lower) == len(solver.values)
    assert np.array_equal(solver.matrix().toarray(), lower + np.tril(lower, -1).T)
    assert solver.matrix().has_sorted_indices


def test_auto_takes_rslab_where_it_is_installed(monkeypatch):
    """Of a model for which banded Cholesky would take long; SciPy alone goes on with SuperLU."""
    model = rectangle(1.0, 1.0, (45, 45))
    numbering = number_dofs((model.quads,), np.full(len(model.nodes), 2))
    monkeypatch.setattr(linear, "DIRECT_LIMIT", linear.SPARSE_LIMIT)
    assert isinstance(make_solver("auto", numbering), SparseLDL)
    monkeypatch.setattr(linear, "rslab", lambda: None)
    assert isinstance(make_solver("auto", numbering), SuperLU)
