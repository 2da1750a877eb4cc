"""A path of equilibria: what load control and arc length share, and a row of each state."""

import time

import numpy as np

from ..errors import AccuracyWarning, StabilityWarning, warn
from ..kernels.hinges import ANGLE, LOCKED
from ..runtime.memory import peak_memory
from ..runtime.provenance import describe
from ..system.linear import NOT_TOLD
from ..system.loads import at_factor
from ..system.rounding import FEW
from .equilibrium import Equilibrium
from .result import Rows, StaticResult

MOVED = 1e3
"""Times the energy of rounded strains: below it a shell without loads has moved as a rigid body."""


class Path:
    """Equilibria of a model, one after the other, each with a row.

    Attributes:
        equilibrium: ``Equilibrium``.
        rows: ``Rows``, the first at zero load.
        unseen: critical points between the last two rows that are no limit points.
    """

    def __init__(self, model, settings):
        self.equilibrium = Equilibrium(model, settings)
        self.unseen = 0
        self._settings = settings
        self._clock = time.perf_counter()
        self._heat = 0.0
        if model.heated:
            self.equilibrium.assemble(0.0, tangent=False)
            self._heat = self._sum(self.equilibrium.system.residual.unmasked)
        self.rows = Rows(self.equilibrium.system, self.equilibrium.state, self.equilibrium.place,
                         settings.stresses)

    def begin(self, first_step, output, overwrite, resume, n_steps, **plan):
        """The row of zero load, or every row of the file that is continued.

        Args:
            first_step: step to be tried first.
            output: result file or None; overwrite, resume: what to do with it.
            n_steps: how many steps it has room for.
            plan: what is asked for, kept in the file.
        """
        system, description = self.equilibrium.system, None
        if output is not None:
            description = describe(system.model, self._settings, system.solver.name, **plan)
            if resume and output.exists():
                self.rows.resume(output, description)
                self.equilibrium.lean(self.rows.reached[0])
                return
        if system.model.heated:
            self.equilibrium.warm()
        self.append(0.0, 0, 0, first_step, 0.0)
        if output is not None:
            self.rows.create(output, description, n_steps, overwrite)

    def append(self, factor, iterations, steps, next_step, shown, turned=False):
        """A row of the state.

        Args:
            factor: its load factor.
            iterations: iterations since the row before; steps: load steps.
            next_step: step to be tried next.
            shown: its time in ParaView.
            turned: whether the load turned round since the row before.
        """
        equilibrium = self.equilibrium
        equilibrium.lean(factor)
        equilibrium.assemble(factor, tangent=False)
        of_joints = self._of_joints()
        reactions = equilibrium.reactions(factor)
        loads, left = equilibrium.balance(factor, reactions)
        if len(self.rows):
            self._check_balance(factor)
        pivots, equilibrium.pivots = equilibrium.pivots, []
        told = None not in pivots
        indefinite = sum(map(bool, pivots)) if told else NOT_TOLD
        negative = (pivots or [0])[-1] if told else NOT_TOLD
        self.unseen = self._passed(negative, turned)
        self.rows.append((factor, equilibrium.place.observed.strain, *loads, reactions.force,
                          reactions.moment, *left, iterations, steps, indefinite, negative,
                          next_step, *of_joints.values()),
                         reactions, shown)

    def _of_joints(self):
        """Columns of the joints in the state that was assembled last, see ``OF_JOINTS``."""
        equilibrium = self.equilibrium
        system, state, place = equilibrium.system, equilibrium.state, equilibrium.place
        last = self.rows.last("joints.angle") if len(self.rows) and system.model.joints else (
            np.zeros(len(system.model.joints)))
        forces = system.joints(state, place)
        found = {"joints.force": forces[:, :3], "joints.moment": forces[:, 3],
                 "joints.couple": forces[:, 4:],
                 "joints.angle": system.angles(state, place, last),
                 "places.angle": state.hinges[:, ANGLE], "places.latched": state.hinges[:, LOCKED]}
        return {name: found[name] for name in self.rows.row.names if name in found}

    def result(self, first):
        """``StaticResult`` of the rows from ``first`` on."""
        equilibrium = self.equilibrium
        return StaticResult(*self.rows.columns(first), tuple(equilibrium.works),
                            equilibrium.system.solver.name, self.rows.indefinite,
                            time.perf_counter() - self._clock, peak_memory())

    def warn_of_bifurcation(self, onwards):
        """Warn where a bifurcation lies between the last two rows; ``onwards``: what to do."""
        if self.unseen:
            warn(f"a bifurcation lies before load factor {self.rows.reached[0]:.6g}, where the "
                 f"tangent has {self.rows.negative_pivots} negative pivots: {onwards}",
                 StabilityWarning)

    def _passed(self, negative, turned):
        """Critical points since the row before that are no limit points: at a simple one the number
        of negative pivots changes by one, at a limit point the load turns round as well."""
        if not len(self.rows) or NOT_TOLD in (negative, self.rows.negative_pivots):
            return 0
        return max(0, abs(negative - self.rows.negative_pivots) - turned)

    def _check_balance(self, factor):
        """Warn of an equilibrium that leaves more than little of its forces, or of those by which
        heat was held back at first: of a thin shell under small loads those of the membrane are
        rounding errors, though its displacements are not."""
        system = self.equilibrium.system
        left, unmasked, applied = (self._sum(forces) for forces in system.residual)
        inner = self._sum(system.inner_forces)
        sprung = self._sum(system.of_springs()) > system.rounding_of_springs(self.equilibrium.state)
        largest = max(applied, unmasked, inner, self._heat)
        moved = self.equilibrium.place.observed.strain <= MOVED * system.roundoff_work(0.0)
        if left > FEW * largest and not (moved and not (sprung or self._loaded(factor))):
            warn(f"at load factor {factor:.6g} forces balance to {left / largest:.1g} only: "
                 "reactions have few digits", AccuracyWarning)

    def _loaded(self, factor):
        """Whether any load acts."""
        loads = self.equilibrium.system.loads_by(at_factor(factor))
        return any(np.any(forces) for forces in (*loads.dead[:2], *loads.items))

    def _sum(self, forces):
        """Sum of the magnitudes of generalized forces, moments by the size of the shell [N]."""
        return float(np.abs(forces / self.equilibrium.system.lengths).sum())
