"""Constraints in a step of the generalized midpoint, in the rotational variables of nodes.

They hold at the end of each step by forces ``-G_m^T l`` along the gradient at its middle, and the
rates at both ends get the impulses of the exact scheme, see ``multipliers``.  Neither is exact
here: a gradient in the middle is no discrete one, and the impulses have the lumped inertia of
normals.  What they leave of the energy is of third order in a step, as what the scheme itself
leaves.
"""

import numpy as np

from ..kernels import hinges
from ..kernels.calls import Call
from ..kernels.nodes import derivatives
from ..model.bodies import spreads
from .chart_rows import ChartRows
from .multipliers import inverse_mass
from .step_links import StepLinks
from .turning import nearest


class QuasiLinks(ChartRows, StepLinks):
    """The constraints of a model in the scheme quasi."""

    def __init__(self, system):
        super().__init__(system)
        elements, model = system.elements, system.model
        self._inertia = np.bincount(elements.directors.ravel(), elements.rotary.sum(axis=2).ravel(),
                                    len(model.normals)) + spreads(model.bodies, len(model.normals))
        self._inverse, self._held_back = inverse_mass(system, self.dofs, turning=False)
        self._turning_dofs = np.isin(self.dofs, system.translations, invert=True)
        self._derive, self._A1_end = Call(derivatives), np.zeros((len(model.normals), 3, 3))
        self._mobile = self._mobilities(self._start.A1)
        self._check(self._mobility(self._G[:self._hard]))

    def _masses(self, A1):
        """(n_local, n_local) lumped inertia ``sum_d I_d A1_d^T A1_d`` of turns, 0 of places."""
        masses = np.zeros((len(self.dofs),) * 2)
        for i in self._nodes:
            at, n = self._local[i] + 3, self._n_rot[i]
            d = slice(self._first[i], self._first[i + 1])
            A = A1[d, :, :n]
            masses[at:at + n, at:at + n] = np.einsum("d,dcr,dcs->rs", self._inertia[d], A, A)
        return masses

    def _mobilities(self, A1):
        """(n_local, n_local) inverse mass of what supports leave free, of turns the lumped one."""
        mobile = self._inverse[self.dofs].copy()
        turning = np.flatnonzero(self._turning_dofs & ~self._held)
        block = np.ix_(turning, turning)
        mobile[block] = np.linalg.inv(self._masses(A1)[block])
        return mobile

    def _moved(self, mobile, impulse):
        """(n_dof,) rates by an impulse (n_local,)."""
        rates = self._inverse @ impulse
        turning = self._turning_dofs
        rates[self.dofs[turning]] = mobile[turning] @ impulse
        return rates

    def begin(self, state, start):
        """Start a step from a ``state`` and its ``Start``: no forces yet."""
        self._at(state, start, self._rest)
        self._before = self._spins.copy()
        self._mobile_0 = self._mobile = self._mobilities(start.A1)
        self._G_0[:] = self._G[:self._hard]
        self._leave(self._links, self._mobile, self._work)
        self._rates_0 = self._G_0[self._m:] @ state.velocity[self.dofs]
        self._work.drive[:] = np.inf

    def add_forces(self, iterate, driven, slacks, motors, work, forces):
        """Add the forces of the constraints, and of the impulses, at an iterate to ``forces``
        (n_dof,).

        Args:
            iterate: ``Iterate``.
            driven: ``Rates``.
            slacks: (n,) angles at which springs are slack at the end [rad].
            motors: (n,) moments of motors [N m].
            work: ``NodalWork`` of it.
            forces: added to.
        """
        state, step, delta = iterate[:3]
        self._at(state, iterate, (1.0 - step.alpha_f) * work.dx)
        self._middle, x_m = self._spins.copy(), self._x
        self._G_m[:] = self._G
        masses = self._masses(iterate.A1)
        self._derive(self._coordinates.nodes, state.chart, work.p_end, self._A1_end)
        self._at(state, self._start._replace(p=work.p_end, A1=self._A1_end), work.dx)
        self._D[:] = self._G
        self._G_1[:] = self._G[:self._hard]
        self._mobile = self._mobilities(self._A1_end)
        places = self._places
        before = state.hinges[places, hinges.ANGLE]
        self._work.change[:] = nearest(self._angles(self._u[1]) - self._initial, before) - before
        self._miss_angles(state, step, driven, slacks, motors)
        rates = 2.0 * step.rate_delta * delta[self.dofs] - state.velocity[self.dofs]
        self._rates_end(rates, driven)
        n, impulse, kick = self._work.n, self._work.impulse, self._work.kick
        spread = np.where(self._turning_dofs & ~self._held, masses @ (n @ kick), n @ impulse)
        self._rate, self._told = step.rate_delta, (state.x + state.x_low, x_m, self._x)
        forces[self.dofs] += step.velocity * spread - self._G_m.T @ self.forces

    def _end_at(self, state):
        """As of ``Multipliers``."""
        self._at_state(state)
        self._mobile = self._mobilities(self._start.A1)
        self._G_1[:] = self._G[:self._hard]

    def _pushed(self, last, first=None):
        """As of ``Multipliers``."""
        moved = self._moved(self._mobile, last)
        if first is not None:
            moved += self._moved(self._mobile_0, first)
        return self._coordinates.free(moved)

    def _acting(self, rows):
        """Forces (n_local,) of some rows, and the places and spins of nodes where they act."""
        middle, first, last = self._forces_of(rows)
        return zip((first, middle, last),
                   zip(self._told, (self._before, self._middle, self._spins)))

    def _place_of(self, i, when):
        """(3,) of node i [m]."""
        return when[0][i]

    def _torque(self, i, f, when):
        """(3,) moment on node i of forces."""
        at, n = self._local[i] + 3, self._n_rot[i]
        return np.linalg.pinv(when[1][i, :n]) @ f[at:at + n]
