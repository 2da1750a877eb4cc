"""Forces and moments by which supports act on the shell, and the global balance with the loads."""

from typing import NamedTuple

import numpy as np

from .constraints import free_of_group


class Reactions(NamedTuple):
    """Forces and moments of the supports, or their impulses; sums are zero in equilibrium.

    Attributes:
        forces: (n_nodes, 3) [N].
        moments: (n_nodes, 3) about the nodes [N m].
        force: (3,) resultant [N].
        moment: (3,) resultant about the origin [N m].
    """

    forces: np.ndarray
    moments: np.ndarray
    force: np.ndarray
    moment: np.ndarray

    def plus(self, other, factor):
        """These and ``factor`` times others."""
        return Reactions(*(own + factor * given for own, given in zip(self, other)))


class Resultant(NamedTuple):
    """Loads of the whole shell, or their impulses.

    Attributes:
        force: (3,) [N].
        moment: (3,) about the origin [N m].
    """

    force: np.ndarray
    moment: np.ndarray

    def plus(self, other, factor):
        """This and ``factor`` times another."""
        return Resultant(*(own + factor * given for own, given in zip(self, other)))


NOTHING = Resultant(*np.zeros((2, 3)))


class Balance(NamedTuple):
    """What is left of the global balance of forces and of moments, relative.

    Attributes:
        forces: of loads, reactions and the rate of the linear momentum.
        moments: the same about the origin, with the rate of the angular momentum.
    """

    forces: float
    moments: float


def share(left, whole):
    """``left`` relative to ``whole``, zero of nothing."""
    return float(left / whole) if whole > 0.0 else 0.0


def static_balance(x, loads, nodal, reactions):
    """``Balance`` of an equilibrium, relative to the sums of the magnitudes of all nodal forces and
    of their moments.

    Args:
        x: (n_nodes, 3) positions [m].
        loads: ``Resultant``; nodal: (n_nodes, 3) forces of theirs [N].
        reactions: ``Reactions``.
    """
    sizes = np.linalg.norm(nodal, axis=1) + np.linalg.norm(reactions.forces, axis=1)
    arms = np.linalg.norm(x - x.mean(axis=0), axis=1)
    turning = (np.linalg.norm(reactions.moments, axis=1).sum() + arms @ sizes
               + np.linalg.norm(x.mean(axis=0)) * sizes.sum())
    return Balance(share(np.linalg.norm(loads.force + reactions.force), sizes.sum()),
                   share(np.linalg.norm(loads.moment + reactions.moment), turning))


def no_reactions(n_nodes):
    """``Reactions`` of zeros."""
    return Reactions(*np.zeros((2, n_nodes, 3)), *np.zeros((2, 3)))


class Supported:
    """Where supports act; takes their reactions from the residual of an iterate, and the forces of
    joints.

    Attributes:
        joined: (n,) nodes that move with others.
        held: (n_held,) nodes with a held normal.
        directors: (n,) their normals.
    """

    def __init__(self, model, numbering, fixed):
        """``fixed``: (n_dof,) bool."""
        directors = model.directors
        self._dofs, self._shape = numbering.translations, model.nodes.shape
        turning = fixed.copy()
        turning[self._dofs] = False
        nodes = numbering.node_of_dof[turning]
        if model.pairs:  # at the edges of a sector neighbours turn the normals
            nodes = np.concatenate([nodes, model.pairs.masters, model.pairs.slaves])
        self.held = np.unique(nodes)
        counts = np.diff(directors.first)[self.held]
        self._begins = np.cumsum(counts) - counts
        self.directors = np.concatenate([np.zeros(0, dtype=np.int64), *(
            np.arange(*directors.first[i:i + 2]) for i in self.held)])
        # a moment about the normal of a smooth node is shared by the elements around it, unless the
        # node is clamped; see ``loads.NormalCouples``
        self._shared = self.held[(counts == 1) & ~model.fixed[self.held].all(axis=1)]
        self._shared_directors = directors.first[self._shared]
        self.joined = np.array([i for group in model.joined for i in group], dtype=np.int64)
        free = [free_of_group(model, numbering.start, fixed, group) for group in model.joined]
        self._free = np.array([N @ N.T for group, N in zip(model.joined, free) for _ in group])

    def reactions(self, residual, inner, p, x, moments):
        """``Reactions`` at an iterate.

        ``R = M U_ddot + F_int - F_ext`` as far as it is held, and at nodes with a held normal
        ``M = sum_d p_d x f_d - M_ext``, with the inertial and internal forces f_d on the normals.

        Args:
            residual: ``arguments.Residual``.
            inner: (n, 3) ``p_d x f_d`` of the normals ``directors`` [N m].
            p: (n_directors, 3) normals there.
            x: (n_nodes, 3) positions there [m].
            moments: (n_nodes, 3) applied ones, of loads and of hinges [N m].
        """
        forces = (residual.balance - residual.unmasked)[self._dofs]
        forces[self.joined] -= self.of_joints(residual)
        total = np.zeros(self._shape)
        if len(self.directors):
            total[self.held] = np.add.reduceat(inner, self._begins) - moments[self.held]
            total[self._shared] += along(moments[self._shared], p[self._shared_directors])
        return Reactions(forces, total, forces.sum(axis=0),
                         np.cross(x, forces).sum(axis=0) + total.sum(axis=0))


    def of_joints(self, residual):
        """(n, 3) forces of joints on the nodes ``joined``, along what supports leave free there, of
        an iterate [N]."""
        if not len(self.joined):
            return np.zeros((0, 3))
        dofs = self._dofs[self.joined]
        return np.einsum("nij,nj->ni", self._free, (residual.balance - residual.unmasked)[dofs])


def along(moments, p):
    """The parts of moments (n, 3) along vectors p (n, 3)."""
    return (np.sum(moments * p, axis=1) / np.sum(p * p, axis=1))[:, None] * p
