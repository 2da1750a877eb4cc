"""Newton's iteration of a static equilibrium.

The load factor plays the part of time: every load and prescribed displacement is taken at
``t = factor``, so a load that is left constant is applied as ``factor * load``.  Assembly and
solvers are those of dynamics.  As the normals are the whole state (no rates to carry over), the
rotational variables may be switched after every iteration.
"""

import math

import numpy as np

from ..checks import instance
from ..errors import StepError
from ..kernels import updates
from ..kernels.arguments import STATIC
from ..kernels.hinges import SLACK
from ..model.model import Model
from ..system.failure import NotConverged
from ..system.loads import at_factor
from ..system.reactions import static_balance
from ..system.rounding import judge
from ..system.still import StillSystem
from .held import check_held
from .settings import StaticSettings

LARGEST_TURN = 1.0
"""Largest rotation of a normal in one iteration [rad]."""

PUSH = 1e-6
"""Part of the shell's size by which prescribed displacements are tried for their forces."""


class Equilibrium:
    """A state that is moved from equilibrium to equilibrium.

    Attributes:
        settings: ``StaticSettings``.
        system: ``StillSystem``, with the full tangent of loads that follow the shell.
        state: ``State``.
        place: ``Place`` of the last iterate.
        works: works of the corrections of the last step, first to last.
        pivots: number of negative pivots of every matrix since it was last emptied; None where the
            solver does not tell.
        pull: changes of the multipliers of joints by the last correction that was solved for; zero
            without any.
    """

    def __init__(self, model, settings, geometric=True, start=None):
        """``geometric=False`` leaves the geometric stiffness out, as linear theory does, a wrong
        variant of any other; ``start`` is the ``Configuration`` to begin with, with rates, if not
        that of the model."""
        instance("model", model, Model)
        self.settings = instance("settings", settings, StaticSettings)
        self.system = StillSystem(model, settings.solver, full_tangent=True, geometric=geometric)
        self.state = self.system.start(start)
        self.place = self.system.observe(self.state)
        self._held_back = self.place.observed.strain if model.heated else 0.0
        self.works, self.pivots, self.pull = [], [], 0.0
        self._sizes = []  # of all corrections [m]
        self._geometric = geometric
        self._predictions = self.system.predictions()
        self._zero = np.zeros(self.system.numbering.n_dof)
        check_held(model, self.system.linked)

    def free(self, vector):
        """``vector`` without what supports hold of it."""
        return self.system.free(vector)

    def equilibrate(self, goal):
        """Move to equilibrium at the load factor ``goal``; returns the iterations it took.

        Raises:
            NotConverged: why it did not get there; the state is as it was.
        """
        backup = self.backup()
        self.works = []
        try:
            return self._iterate(goal)
        except NotConverged:
            self.restore(backup)
            raise

    def backup(self):
        """What ``restore`` takes back."""
        linked = self.system.linked
        return self.state.pack(), linked and linked.forces.copy()

    def restore(self, backup):
        """Take back what has been done since."""
        packed, forces = backup
        self.state.unpack(packed)
        if self.system.linked:
            self.system.linked.forces[:] = forces

    def take(self, configuration):
        """Become the state of a ``Configuration``."""
        hinges = self.state.hinges.copy()
        system = self.system
        self.state.take(system.coordinates.initial_state(system.model, configuration))
        self.state.hinges[:] = hinges

    def lean(self, factor):
        """Take the multipliers of joints from the state at a load factor."""
        if self.system.linked:
            self.system.observe(self.state, self.place)
            self.system.lean(self.state, self.place, self.system.loads_by(at_factor(factor)))

    def warm(self):
        """Move to the equilibrium of a heated shell without loads; heat that is too much for one
        step grows from zero.

        Raises:
            StepError: no convergence even with the smallest step.
        """
        reached, goal = 0.0, 1.0
        while reached < 1.0:
            self.system.elements = self.system.model.partly_heated(goal)
            try:
                self.equilibrate(0.0)
            except NotConverged as failure:
                goal = 0.5 * (reached + goal)
                if goal - reached < 0.5**self.settings.max_divisions:
                    raise StepError(f"no equilibrium found beyond {reached:.6g} of the changes of "
                                    f"temperature: {failure}") from None
                continue
            reached, goal = goal, min(1.0, goal + 2.0 * (goal - reached))

    def _iterate(self, goal):
        mixed, driven = False, self.system.driven
        for k in range(1, self.settings.max_iterations + 1):
            self.system.observe(self.state, self.place)
            pushed = driven.correction(self.state, self.place.start, at_factor(goal))
            if pushed is not None:
                correction = self.solve_increment(pushed, goal)
            else:
                correction = self.correction(goal, mixed)
            self.works.append(self.work(correction))
            if not np.isfinite(self.works[-1]):
                raise NotConverged("the iteration diverges")
            self.move(correction, self.pull)
            mixed = True
            if pushed is None and self.converged(k, max(self.works)):
                return k
        raise NotConverged(self.too_slow(max(self.works)))

    def too_slow(self, first):
        """What the iterations so far reached, in words, ``first`` being the work of the first."""
        last, before = self.works[-1], self.works[-2]
        reached = f"{len(self.works)} iterations reached a work ratio of {last / first:.2g}"
        if last < before:
            reached += f"; it converges, slowly: {last / before:.2g} of the work is left each time"
        return reached

    def unit_forces(self):
        """Generalized forces (n_dof,) of the loads of factor 1 in the present state."""
        system = self.system
        if not system.all_dead:
            self.assemble(1.0, tangent=False)
        return system.applied(system.loads(1.0)).copy()

    def work(self, correction):
        """Work of the residual in a correction [J]."""
        return abs(float(self.system.residual.balance @ correction))

    def converged(self, k, first):
        """Whether the k-th correction is the last, compared with the work ``first``, but not with
        one far above the strain energy that the first correction overshot to, or that heat had
        when it was held back.

        Raises:
            StepError: rounding ends the iteration before any digit is correct.
        """
        last, strain = self.works[-1], max(self.place.observed.strain, self._held_back)
        first = min(first, max(self.works[0], strain))
        if self.system.linked and not self.system.linked.closed():
            return False
        if k > 1 and self.settings.tolerance * first < last <= self.system.roundoff_work(0.0):
            # of a small increment few digits serve; of a rigid motion works tell nothing
            sizes = self._sizes[-len(self.works):]
            judge(min(math.sqrt(last / max(first, strain)), sizes[-1] / max(sizes)),
                  "Newton's iteration ends at rounding error alone")
            return True
        return k > 1 and last <= self.settings.tolerance * first

    def solve_increment(self, pushed, factor, stiffness_at=None):
        """First correction of a step with prescribed displacements: the free dofs follow linearly.

        The forces of the push are taken from a small one.

        Args:
            pushed: (n_dof,) prescribed displacements.
            factor: of the loads.
            stiffness_at: factor of the loads in the matrix, to which those that follow add; left
                out, the same.

        Raises:
            SingularMatrix: the shell is a mechanism, or at a limit point.
        """
        system = self.system
        self.assemble(factor, tangent=stiffness_at is None)
        residual = system.residual.balance.copy()
        missed = system.linked and system.linked.off.copy()
        if np.any(pushed):
            fraction = PUSH * system.model.size / np.abs(pushed).max()
            forces = system.residual.unmasked.copy()
            system.assemble(self.state, self.place, STATIC, fraction * pushed,
                            system.loads_by(at_factor(factor)), tangent=False)
            residual += self.free(system.residual.unmasked - forces) / fraction
        if stiffness_at is not None:
            self.assemble(stiffness_at)
        self._factorize()
        correction, self.pull = system.solve(residual, pushed, missed)
        return correction + pushed

    def assemble(self, factor, mixed=False, tangent=True):
        """Residual, and matrix if wanted, of the state; ``mixed``: with predicted stresses."""
        predicted = self._predictions._replace(used=mixed or not self._geometric)
        if not self._geometric:
            predicted.b[:] = 0.0
            predicted.e[:] = 0.0
        self.state.hinges[:, SLACK] = self.system.turnings.slacks(at_factor(factor))
        self.system.observe(self.state, self.place)
        self.system.assemble(self.state, self.place, STATIC, self._zero,
                             self.system.loads_by(at_factor(factor)), tangent=tangent,
                             predicted=predicted)

    def reactions(self, factor):
        """``Reactions`` of the state, for which ``assemble`` was called last."""
        return self.system.reactions(self.state, self.place, STATIC,
                                     self.system.loads_by(at_factor(factor)))

    def balance(self, factor, reactions):
        """``Resultant`` of the loads and ``Balance`` of the state, as ``reactions``."""
        system, applied = self.system, self.system.loads_by(at_factor(factor))
        loads = system.resultant_of_loads(self.state, STATIC, self._zero, applied)
        nodal = system.acting(applied)[system.translations]
        return loads, static_balance(self.state.x, loads, nodal, reactions)

    def correction(self, factor, mixed):
        """The correction of the state under the loads of a factor."""
        self.assemble(factor, mixed)
        self._factorize()
        return self._solved(self.system.residual.balance,
                            self.system.linked and self.system.linked.off)

    def response(self, load):
        """The linear response (n_dof,) to a load, by the matrix of the last correction."""
        return self._solved(self.free(load))

    def _solved(self, residual, missed=None):
        correction, self.pull = self.system.solve(residual, missed=missed)
        return correction

    def move(self, correction, pull):
        """Apply a correction, scaled down if it turns a normal by more than ``LARGEST_TURN``, with
        its ``pull``; its linear part is the stress of the next tangent."""
        system, start = self.system, self.place.start
        turn = system.coordinates.largest_turn(start, correction)
        if turn > LARGEST_TURN:
            correction = LARGEST_TURN / turn * correction
        self._sizes.append(np.abs(system.lengths * correction).max())
        self.predict(correction)
        if system.linked:
            system.linked.forces += pull
        system.coordinates.correct(self.state, start, correction)

    def predict(self, correction):
        """Take the stresses of the next mixed tangent from the linear part of a correction."""
        updates.predict_strains(self.system.elements, self.system.dofs.nodes, self.state.motion,
                                self.place.start, correction, self._predictions)

    def strained(self, motion):
        """Whether the strains predicted for a ``motion`` are more than its rounding errors."""
        system, place = self.system, self.place.start
        changes = (self._predictions.b - place.b, self._predictions.e - place.e)
        size = np.abs(system.lengths * motion).max() / system.model.size
        return sum(float(np.sum(change**2)) for change in changes) > (
            1e6 * size**2 * system.roundoff_work(0.0))

    def _factorize(self):
        self.pivots.append(self.system.factorize())
