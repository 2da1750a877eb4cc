"""Sparse matrices of small motions about a state, in its translations and rotational variables."""

import numpy as np
from scipy.sparse import block_diag, coo_array, kron

from ..errors import AccuracyWarning, warn
from ..kernels.arguments import MASS_ONLY, STATIC
from ..system.linear import UnsymmetricLU
from ..system.loads import unloaded
from ..system.rounding import EPS, FEW
from ..system.still import StillSystem

NO_SKEW = 1e-12
"""Largest entry of a skew part beside that of the matrix that is rounding alone."""


def sparse_system(model):
    """``StillSystem`` with sparse matrices, with the skew part of the loads' stiffness."""
    system = StillSystem(model)
    system.take(UnsymmetricLU(system.numbering))
    return system


def stiffness(system, state, place, loads):
    """Tangent K (n, n) of the free dofs at a state under loads, its symmetric part.

    Warns:
        AccuracyWarning: the loads' stiffness has a skew part, or the state is no equilibrium.
    """
    if system.linked:
        system.lean(state, place, loads)
    K = _assembled(system, state, place, STATIC, loads)
    sizes, size = system.lengths, system.model.size
    left, *others = (np.abs(forces / sizes).sum() for forces in system.residual)
    of_free = (system.basis() ** 2).T @ sizes
    rounding = EPS * size * np.sum(np.abs(K.diagonal()) / of_free**2)
    if left > FEW * max(others) and left > rounding:
        warn(f"the state is no equilibrium: forces balance to {left / max(others):.1g} only",
             AccuracyWarning)
    return symmetric(system, K)


def mass(system, state, place):
    """Consistent mass M (n, n) of the free dofs at a state, Eqs. (40), (41)."""
    return _assembled(system, state, place, MASS_ONLY, system.loads_by(unloaded))


def symmetric(system, matrix):
    """The symmetric part of a matrix that was assembled last, with a warning if it has another."""
    solver = system.solver
    if np.abs(solver.skew).max() > NO_SKEW * np.abs(solver.values).max():
        warn("loads follow the shell and their stiffness is not symmetric: its symmetric part is "
             "taken, which knows no flutter", AccuracyWarning)
    return (0.5 * (matrix + matrix.T)).tocsc()


def coriolis(system, place, omega):
    """``G = 2 J^T diag(M W, I W) J`` (n, n), ``W a = omega x a``, of the free dofs in a
    frame that turns at ``omega`` [rad/s]; skew.  J takes rates of the unknowns to those of
    positions and normals."""
    W = np.cross(omega, np.eye(3)).T
    elements, nodes = system.elements, system.dofs.nodes
    by_node = _between(elements.nodes, elements.mass, len(nodes.start))
    by_director = _between(elements.directors, elements.rotary, len(nodes.body))
    J = rates_of_places(system, place)
    G = 2.0 * J.T @ block_diag([kron(by_node, W), kron(by_director, W)]) @ J
    T = system.basis()
    return (T.T @ G @ T).tocsr()


def rates_of_places(system, place):
    """J (3 n_nodes + 3 n_directors, n_dof): displacements and changes of normals, one node or
    normal after the other, of an increment: 1 and A1."""
    nodes, translations = system.dofs.nodes, system.translations.ravel()
    own = np.repeat(np.arange(len(nodes.start)), np.diff(nodes.first))
    column = np.arange(3) < nodes.n_rot[own][:, None]
    director, k = np.nonzero(column)
    rows = 3 * len(nodes.start) + 3 * director[:, None] + np.arange(3)
    columns = np.broadcast_to((nodes.start[own][director] + 3 + k)[:, None], rows.shape)
    values = place.start.A1[director, :, k]
    rows = np.concatenate([np.arange(len(translations)), rows.ravel()])
    columns = np.concatenate([translations, columns.ravel()])
    values = np.concatenate([np.ones(len(translations)), values.ravel()])
    shape = 3 * len(nodes.start) + 3 * len(own), system.numbering.n_dof
    return coo_array((values, (rows, columns)), shape=shape).tocsr()


def of_all(system, vectors):
    """(n_dof, k) of vectors (n, k) of the free dofs, zero at the held ones."""
    return system.basis() @ vectors


def free_matrix(system):
    """The matrix that was assembled last, of the free dofs."""
    T = system.basis()
    return (T.T @ system.solver.matrix() @ T).tocsc()


def _assembled(system, state, place, factors, loads):
    system.assemble(state, place, factors, np.zeros(system.numbering.n_dof), loads)
    return free_matrix(system)


def _between(vertices, mass, n):
    """(n, n) of element masses (n_elem, 4, 4) between their vertices."""
    rows = np.broadcast_to(vertices[:, :, None], mass.shape)
    columns = np.broadcast_to(vertices[:, None, :], mass.shape)
    return coo_array((mass.ravel(), (rows.ravel(), columns.ravel())), shape=(n, n))
