"""The system of the exact scheme: spins for charts, the discrete Jacobian for T."""

import numpy as np

from ..errors import InputError
from ..kernels import exact
from ..kernels.arguments import spin_work
from ..kernels.calls import Call
from .spins import Spins
from .system import System


class ExactSystem(System):
    """As ``System``, for steps of the exact scheme.

    The rotary inertia of the normals is lumped, each element's at its vertices: a spin then belongs
    to one node.
    """

    exact = True

    def _make_coordinates(self, follow):
        elements, model = self.elements, self.model
        if len(elements.eccentric):
            raise InputError("scheme exact: the mass must be centred on the surface of the nodes; "
                             "take quasi for sections whose mass is offset")
        lumped = elements.rotary.sum(axis=2)
        rotary = np.zeros_like(elements.rotary)
        rotary[:, np.arange(4), np.arange(4)] = lumped
        self.elements = elements._replace(rotary=rotary)
        inertia = np.bincount(elements.directors.ravel(), lumped.ravel(), len(model.normals))
        return Spins(model, self.numbering, inertia)

    def _make_kernels(self):
        self._step = Call(exact.step_exact)
        self.nodal = spin_work(len(self.model.nodes), len(self.model.normals))

    def initial_state(self, start=None):
        """State at t = 0; accelerations take no part."""
        return self.start(start)

    def _assemble(self, state, place, step, delta, dead, averaged, tangent, predicted):
        return self._step(
            self.elements, self.dofs, self.coordinates.inertia, state.motion, place.start, step,
            state.lags, delta, dead, self.solver.storage, tangent, self.solver.values,
            self.residual, self.nodal)

    def _moments_on_normals(self, place, averaged):
        work, at = self.nodal, self._supported.directors
        moments = np.cross(work.p_mid[at], work.force_p[at])
        first = self.model.directors.first
        owner = np.searchsorted(first, at, side="right") - 1
        once = at == first[owner]
        moments[once] += work.spin_rate[owner[once]]
        return moments
