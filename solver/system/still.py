"""The system of equilibria and of small motions about them: joints hold without inertia.

Constraints ``g(q) = 0`` are solved for with Newton's correction,

    K d + G^T dl = F - G^T l,   G d = -g,   K = dF + sum l ddg,

in a basis of what they leave free.  A body has no stiffness and K no inverse, so that multipliers
cannot be eliminated as in a step; the matrix of the basis is symmetric, needs no penalty, and its
pivots tell stability.
"""

import numpy as np
from scipy.sparse import csc_array

from ..kernels.arguments import STATIC
from ..kernels.hinges import ANGLE, SLACK, K
from ..model.joints import Hinge
from .constrained import Linking
from .joints import Angle
from .linear import SuperLU, UnsymmetricLU
from .rounding import EPS
from .still_links import StillLinks
from .system import System


class StillSystem(System):
    """As ``System``, with ``StillLinks`` where there are joints or bodies.

    Attributes:
        second: (n_dof, n_dof) sparse, what the second derivatives of joints add to the matrix.
    """

    def __init__(self, model, solver="auto", full_tangent=False, geometric=True):
        """``geometric``: whether moments of hinges are in the tangent, as stresses are."""
        self._geometric, self._ahead = geometric, 0.0
        super().__init__(model, solver, full_tangent=full_tangent)
        self.second = csc_array((self.numbering.n_dof,) * 2)
        self._hinge_angles = {k: Angle(model, joint) for k, joint in enumerate(model.joints)
                              if isinstance(joint, Hinge)}
        self.linked = StillLinks(self) if model.linked or model.bodies else None

    def _make_solver(self, name, unsymmetric, threads):
        self._curved = self._geometric and bool(self.hinges)
        if not self._joins:
            return super()._make_solver(name, unsymmetric, threads)
        return Linking((UnsymmetricLU if unsymmetric else SuperLU)(self.numbering), self)

    @property
    def _joins(self):
        """Whether joints add to the matrix."""
        return bool(self.model.linked or self.model.bodies or self._curved)

    def take(self, solver):
        """Go on with a sparse ``solver``."""
        self.solver = Linking(solver, self) if self._joins else solver

    def basis(self):
        """T (n_dof, n), sparse: ``dU = T dU_free`` of the free dofs, in the state that was
        assembled last where there are joints; without them its columns are orthonormal."""
        return self.linked.reduce() if self.linked else self.coordinates.basis()

    def foresee(self, state, motion):
        """Let the next matrices have the moments of springs of joints after a small ``motion``
        (n_dof,) from a ``state``, which was assembled last."""
        if self._curved:
            self._ahead = self.hinges.moment_changes(self.dofs, state, motion)
        if self.linked:
            self.linked.foresee(motion)

    def loads_by(self, value, at_end=None, driven=None):
        """``Applied`` loads, and what drives do, with ``value(history)`` for each function of
        time."""
        return super().loads_by(value, at_end, self.linked and self.linked.driven(value))

    def solve(self, residual, pushed=None, missed=None):
        """Correction (n_dof,) for a residual, and the changes of the multipliers.

        Args:
            residual: (n_dof,) with that of ``pushed``.
            pushed: (n_dof,) prescribed displacements.
            missed: by how much constraints are, without these; not at all if left out.
        """
        if not self.linked:
            return self.solver.solve(residual), 0.0
        closing = self.linked.closing(pushed, missed)
        correction = closing + self.solver.solve(residual - self.solver.times(closing))
        return correction, self.linked.pull(residual - self.solver.times(correction))

    def lean(self, state, place, loads):
        """Take the multipliers that balance a state as nearly as they can."""
        self.linked.forces[:] = 0.0
        self.assemble(state, place, STATIC, np.zeros(self.numbering.n_dof), loads, tangent=False)
        self.hold()

    def hold(self):
        """Let joints take what they can of the residual of the last iterate."""
        if self.linked:
            self.inner_forces += self.linked.hold(self.residual)

    def of_springs(self):
        """(n_dof,) forces of springs in the last iterate, of joints with multipliers none."""
        found = self.inner_forces.copy()
        if self.linked:
            found[self.linked.dofs] -= self.linked.acting
        return found

    def rounding_of_springs(self, state):
        """Sum of the magnitudes of the forces that rounded angles and lengths leave in springs that
        are slack [N]."""
        angles = np.abs(state.hinges[:, ANGLE]) + np.abs(state.hinges[:, SLACK])
        turning = self.turnings.constants[:, K] @ angles / self.model.size
        return 8.0 * EPS * (turning + sum(spring.scale(state) for spring in self._springs))

    def acting(self, loads):
        """(n_dof,) forces of the loads, and of springs where there are no joints with multipliers,
        in the iterate that was assembled last."""
        return self.applied(loads) if self.linked else self.residual.applied

    def angles(self, state, place, last):
        """(n_joints,) angles of hinges and of revolute joints whose angle takes part, within half a
        turn of the ``last`` [rad]; zero of other joints."""
        found = np.zeros(len(self.model.joints))
        for k, measured in self._hinge_angles.items():
            found[k] = measured(state, place.start.p, last[k])
        own = self.turnings.joints[self.turnings.hinges:]
        found[own] = state.hinges[self.turnings.hinges:, ANGLE]
        return found

    def _add_items(self, iterate, loads):
        super()._add_items(iterate, loads)
        if self.linked:
            self.second = self.linked.second(self.dofs.nodes, iterate)
        if self._curved:
            curved = iterate.step.stiffness * self.hinges.curvature(
                self.dofs, iterate.state, iterate.p, iterate.A1, self.hinges.moments + self._ahead)
            self.second = self.second + curved if self.linked else curved

    def forces_of_springs(self, state, start, motion):
        """As of ``System``, with those of revolute joints, and as moments of hinges turn."""
        moments = self.hinges.moments.copy()
        change = super().forces_of_springs(state, start, motion)
        if self._curved:
            turned = self.hinges.curvature(self.dofs, state, start.p, start.A1, moments) @ motion
            self.inner_forces -= turned
            change -= turned
        if self.linked:
            of_joints = self.linked.linear(motion)
            self.inner_forces += of_joints
            change += of_joints
        return change
