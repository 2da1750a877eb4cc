"""What several tests use: systems with a chosen solver, their matrices, and the command line."""

import subprocess
import sys
from pathlib import Path

import numpy as np

from corovec.solver.statics.path import STATIC
from corovec.solver.system.linear import SuperLU
from corovec.solver.system.system import System

COMMAND = Path(sys.executable).with_name("corovec")

SOLVERS = ("skyline", "dense", "auto", "superlu")


def make_system(model, solver="skyline"):
    system = System(model, "auto" if solver == "superlu" else solver)
    if solver == "superlu":
        system.solver = SuperLU(system.numbering)
    return system


def full_matrix(system):
    """The lower triangle in the solver's storage as a full symmetric matrix."""
    solver, n = system.solver, system.numbering.n_dof
    if solver.name == "dense":
        lower = np.tril(solver.values.reshape(n, n))
    elif solver.name == "banded":
        lower = np.zeros((n, n))
        band = solver.values.reshape(n, -1)
        for j in range(n):
            rows = min(band.shape[1], n - j)
            lower[j:j + rows, j] = band[j, :rows]
    elif solver.name == "skyline":
        lower, diagonal = np.zeros((n, n)), solver.storage[2]
        for i in range(n):
            start = diagonal[i - 1] + 1 if i else 0
            lower[i, i - (diagonal[i] - start):i + 1] = solver.values[start:diagonal[i] + 1]
    else:
        solver._matrix.data[:] = solver.values[solver._source]
        return solver._matrix.toarray()
    return lower + np.tril(lower, -1).T


def no_loads(system):
    """Loads of ``System.loads_at``, all zero."""
    model = system.model
    return (np.zeros(system.numbering.n_dof), np.zeros((len(model.nodes), 3)),
            np.zeros(len(model.quads)), False)


def static_system(system, state, delta, tangent=True):
    """(residual, K) of f(x + delta) without loads or inertia."""
    status = system.assemble(state, STATIC, False, delta, no_loads(system), tangent)
    assert status == 0
    return system.residual[0].copy()


def central_differences(function, at, step):
    """Derivative of a vector function at ``at`` by central differences, a column a variable."""
    return np.column_stack([(function(at + shift) - function(at - shift)) / (2.0 * step)
                            for shift in step * np.eye(len(at))])


def corovec(*arguments, **options):
    """Run the installed command; text of both streams and the exit status."""
    return subprocess.run([COMMAND, *arguments], text=True, capture_output=True, check=False,
                          **options)
