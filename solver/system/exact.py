"""The system of the exact scheme: spins for charts, the discrete Jacobian for T."""

import numpy as np

from ..kernels import exact
from ..kernels.arguments import spin_work
from ..kernels.calls import Call
from ..model.attached import GroundSpring, Spring
from ..model.bodies import spreads
from .bodies import Bodies
from .multipliers import Multipliers
from .rounding import EPS
from .spins import Spins
from .step_links import FIRST
from .system import System

ROUNDED = 64.0
"""Times the rounding error of a force's parts that a residual may be which is rounding error alone
(measured: 1 to 3, on a narrow warped shell up to 30); asked only where fresh matrices gain nothing
any more."""


class ExactSystem(System):
    """As ``System``, for steps of the exact scheme.

    The rotary inertia of the normals is lumped, each element's at its vertices: a spin then belongs
    to one node.
    """

    exact = True
    kind_of_bodies = Bodies

    def _make_coordinates(self, follow):
        elements, model = self.elements, self.model
        lumped = elements.rotary.sum(axis=2)
        rotary = np.zeros_like(elements.rotary)
        rotary[:, np.arange(4), np.arange(4)] = lumped
        self.elements = elements._replace(rotary=rotary)
        inertia = np.bincount(elements.directors.ravel(), lumped.ravel(), len(model.normals))
        inertia += spreads(model.bodies, len(model.normals))
        return Spins(model, self.numbering, inertia)

    def _make_kernels(self, threads):
        self._step = Call(exact.step_exact)
        self.nodal = spin_work(len(self.model.nodes), len(self.model.normals))
        self._stiffness, self._stiff_forces = self._stiffnesses()
        self.linked = Multipliers(self)

    def _stiffnesses(self):
        """(n_dof,) sums of ``E h`` at displacements and ``E h a`` at rotational variables, a the
        diagonals of the elements around, and the same times a; of springs ``k`` and ``k L``, L the
        shell's size: forces of unit displacements and of unit strains."""
        model, n = self.model, len(self.model.nodes)
        corners, at = model.nodes[model.quads], model.quads.ravel()
        a = np.linalg.norm(corners[:, 2:] - corners[:, :2], axis=2).max(axis=1)
        sums = [np.bincount(at, np.repeat(model.youngs * model.thickness * a**k, 4), n)
                for k in range(3)]
        for item in model.attached:
            if isinstance(item, Spring):
                on, k = [item.node, item.other], item.steepest
            elif isinstance(item, GroundSpring):
                on, k = item.node, max(item.stiffness)
                sums[2][on] += item.turning
            else:
                continue
            sums[0][on] += k
            sums[1][on] += k * model.size
        found = []
        for of_displacement, of_turn in zip(sums, sums[1:]):
            found.append(of_turn[self.numbering.node_of_dof])
            found[-1][self.translations] = of_displacement[:, None]
        return found

    def at_rounding(self, state, step):
        """Whether the residual of the last iterate, of a step from ``state``, is rounding error of
        the forces that it consists of, of displacements and of velocities."""
        parts = self._stiff_forces + np.abs(self.residual.applied)
        parts += np.abs(self.nodal.dx).max() * self._stiffness
        if self.linked:
            parts[self.linked.dofs] += self.linked.parts()
        fastest = np.abs(state.velocity[self.translations]).max()
        parts[self.translations] += step.velocity * fastest * self.nodal_mass[:, None]
        if self.linked:
            self.linked.pass_on(parts)
        return bool(np.all(np.abs(self.residual.balance) <= ROUNDED * EPS * parts))

    def initial_state(self, start=None, accelerations=False):
        """State at t = 0; accelerations take no part."""
        state = self.start(start)
        if self.linked:
            self.linked.check_rates(state, None, self.loads(0.0, 0.0, FIRST).driven)
        return state

    def _assemble(self, state, place, step, delta, dead, averaged, tangent, predicted):
        return self._step(
            self.elements, self.dofs, self.coordinates.inertia, state.motion, place.start, step,
            state.lags, delta, dead, self.solver.storage, tangent, self.solver.values,
            self.residual, self.nodal, self._placing)

    def _moments_on_normals(self, place, averaged):
        work, at = self.nodal, self._supported.directors
        moments = np.cross(work.p_mid[at], work.force_p[at])
        first = self.model.directors.first
        owner = np.searchsorted(first, at, side="right") - 1
        once = at == first[owner]
        moments[once] += work.spin_rate[owner[once]]
        return moments
