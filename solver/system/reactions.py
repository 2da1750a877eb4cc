"""Forces and moments by which supports act on the shell."""

from typing import NamedTuple

import numpy as np


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


def no_reactions(n_nodes):
    """``Reactions`` of zeros."""
    return Reactions(*np.zeros((2, n_nodes, 3)), *np.zeros((2, 3)))


class Supported:
    """Where supports act; takes their reactions from the residual of an iterate."""

    def __init__(self, model, numbering, fixed):
        """``fixed``: (n_dof,) bool."""
        directors = model.directors
        self._dofs, self._shape = numbering.translations, model.nodes.shape
        self._held = fixed[self._dofs]
        turning = fixed.copy()
        turning[self._dofs] = False
        self._nodes = np.unique(numbering.node_of_dof[turning])
        counts = np.diff(directors.first)[self._nodes]
        self._begins = np.cumsum(counts) - counts
        self._directors = np.concatenate([np.zeros(0, dtype=np.int64), *(
            np.arange(*directors.first[i:i + 2]) for i in self._nodes)])
        # a moment about the normal of a smooth node is shared by the elements around it, unless the
        # node is clamped; see ``loads.NormalCouples``
        self._shared = self._nodes[(counts == 1) & ~model.fixed[self._nodes].all(axis=1)]
        self._shared_directors = directors.first[self._shared]

    def reactions(self, residual, work, x, moments, ends=None):
        """``Reactions`` at an iterate.

        ``R = M U_ddot + F_int - F_ext`` at held components, and at nodes with a held normal
        ``M = sum_d p_d x f_d - M_ext``, with the inertial and internal forces f_d on the normals.

        Args:
            residual: ``arguments.Residual``.
            work: ``arguments.NodalWork``.
            x: (n_nodes, 3) positions there [m].
            moments: (n_nodes, 3) applied ones about fixed axes [N m].
            ends: (2, n_directors, 3) normals at the end and the start of the step, where T is the
                average of both.
        """
        forces = np.where(self._held, -residual.unmasked[self._dofs], 0.0)
        total, at = np.zeros(self._shape), self._directors
        if len(at):
            p = work.p_mid[at]
            if ends is None:
                turning = np.cross(p, work.force_p[at] + work.rate_p[at])
            else:
                turning = np.cross(p, work.rate_p[at]) + sum(
                    np.cross(normals[at], of[at]) for normals, of in zip(ends, work.ends_p))
            total[self._nodes] = np.add.reduceat(turning, self._begins) - moments[self._nodes]
            p, given = work.p_mid[self._shared_directors], moments[self._shared]
            total[self._shared] += np.sum(given * p, axis=1, keepdims=True) * p
        return Reactions(forces, total, forces.sum(axis=0),
                         np.cross(x, forces).sum(axis=0) + total.sum(axis=0))
