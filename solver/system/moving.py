"""The system of the scheme quasi with joints and bodies."""

from .quasi_links import QuasiLinks
from .step_links import FIRST
from .system import System


class MovingSystem(System):
    """As ``System``, with ``QuasiLinks`` where there are joints."""

    def __init__(self, model, solver="auto", follow=True, threads=1):
        super().__init__(model, solver, follow, threads=threads)
        self.linked = QuasiLinks(self)
        if not self.linked:
            self.linked = None

    def initial_state(self, start=None, accelerations=False):
        """State at t = 0; accelerations take no part."""
        state = self.start(start)
        if self.linked:
            place = self.observe(state)
            self.linked.check_rates(state, place.start, self.loads(0.0, 0.0, FIRST).driven)
        return state
