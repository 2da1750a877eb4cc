"""Newton's iteration of one time step (Eqs. 61-67), with a new matrix in every iteration as in the
paper, or with one factorization for many of them."""

import math
import time

import numpy as np

from ..kernels import transport as corotation
from ..system.linear import SingularMatrix, row_lengths

MAX_DAMPINGS = 4
"""How often a correction is halved when it would leave the chart of a normal."""

BEYOND = 1e-12
"""A kept matrix goes on until the work ratio to be expected after the last correction is ``BEYOND``
times the tolerance, but not below ``EXACT``: as far as Newton's iteration, whose last correction
squares the ratio, gets by the paper's rule.  (Measured on a stiff plate that flips over: with 1e-8
energy drifts by 1e-4 in 2000 steps, and the second order in dt is lost.)"""

EXACT = 1e-18
"""Work ratio at which residuals are 1e-9 of the first: no rule asks for more."""

STALLED = 0.25
"""Part of the work that may be left after a correction with a kept matrix."""

PATIENCE, PATIENCE_ROW = (4, 11), 12.0
"""A step may take r / ``PATIENCE_ROW`` iterations with a kept matrix, r being the root mean square
of the rows' lengths, within these bounds, before the next one makes its own: the longer the rows,
the dearer that is (measured, see timing/README.md)."""

LONGEST = 1.65
"""Times that many iterations expected for a step, a kept matrix is replaced within it."""


def _ends(rule, k, work, first, left, new):
    """Whether the k-th correction is the last, with the work that it does, the first did, and the
    ratio to the one before; ``new``: whether it has its own matrix."""
    if k < rule.least:
        return False
    if not rule.keep or new:
        return work <= rule.tolerance * first
    return work * min(left, 1.0) <= _enough(rule) * first


def _too_slow(rule, k, work, first, left, longest):
    """Whether the next correction needs its own matrix: the kept one has stalled, or would take
    more than ``longest`` iterations."""
    if left > STALLED:
        return True
    missing = math.log(work * left / (_enough(rule) * first))
    return k + missing / -math.log(left) > longest


def _enough(rule):
    return max(BEYOND * rule.tolerance, EXACT)


class KeptMatrix:
    """The factorization of a step's matrix, carried along with the nodes afterwards.

    Attributes:
        patience: iterations that a step may take with it before the next one makes its own.
    """

    def __init__(self, system):
        self._system = system
        numbering, n_nodes = system.numbering, len(system.model.nodes)
        row = np.sqrt(np.mean(row_lengths(numbering).astype(float)**2))
        self.patience = float(np.clip(row // PATIENCE_ROW, *PATIENCE))
        self._numbers = (numbering.start, numbering.n_rot)
        self._corner = np.empty(n_nodes, dtype=np.int64)
        self._corner[system.model.quads] = np.arange(len(system.model.quads))[:, None]
        self._held = np.zeros(n_nodes, dtype=bool)
        self._held[numbering.node_of_dof[system.fixed]] = True
        self._free = not system.fixed.any()
        self._frames, self._rates, self._Q, self._J = np.zeros((4, n_nodes, 3, 3))
        self._turned = np.zeros(numbering.n_dof)
        self.forget()

    def forget(self):
        """Drop the factorization: the next step starts with its own."""
        self._step, self._carried = None, False

    def serves(self, step):
        """Whether there is a factorization for steps of this length and scheme."""
        return self._step == step

    def make(self):
        """Factorize the assembled matrix, for one iteration.

        Returns:
            How many pivots are negative, None if the solver does not tell.

        Raises:
            SingularMatrix: a pivot is zero or not finite.
        """
        self.forget()
        return self._system.factorize()

    def keep(self, step, state):
        """As ``make``, and keep it for other steps; this one starts at ``state``."""
        negative = self.make()
        self._step = step
        corotation.keep(*self._place(state), self._frames, self._rates)
        return negative

    def carry(self, state):
        """Turn the factorization along with the nodes to a step that starts at ``state``."""
        corotation.carry(*self._place(state), self._held, self._frames, self._rates, self._Q,
                         self._J)
        self._carried = True

    def solve(self, residual):
        """Correction for a residual."""
        solver = self._system.solver
        if not self._carried:
            return solver.solve(residual)
        corotation.turn_back(*self._numbers, self._Q, self._J, residual, self._turned)
        correction = solver.solve(self._turned)
        corotation.turn_on(*self._numbers, self._Q, self._J, correction)
        if self._free:
            corotation.balance(self._numbers[0], self._system.nodal_mass, self._step[2], residual,
                               correction)
        return correction

    def _place(self, state):
        system = self._system
        return (system.nodes, system.elements.nodes, self._corner, state.x, state.x_low,
                state.chart, system.p, system.A1)


def iterate(system, state, scheme, rule, dt, loads, record):
    """The increment of a step of length ``dt`` from ``state`` under ``loads``.

    Args:
        system: ``System``.
        rule: ``Newton``.
        record: ``StepRecord``, added to.

    Returns:
        (increment (n_dof,), None), or (None, the reason why there is none).
    """
    step = scheme.midpoint(dt)
    averaged = scheme.transformation == "average"
    kept = system.kept
    new = not (rule.keep and kept.serves(step))
    if not new:
        kept.carry(state)
    delta = dt * state.velocity
    correction = delta
    floor = system.roundoff_work
    first = last = 0.0
    made = 0
    for k in range(1, rule.max_iterations + 1):
        for _ in range(MAX_DAMPINGS + 1):
            if system.assemble(state, step, averaged, delta, loads, new) == 0:
                break
            correction = 0.5 * correction
            delta = delta - correction
        else:
            return None, "a normal left the chart of its rotational variables"
        if new:
            try:
                record.count(kept.keep(step, state) if rule.keep else kept.make())
            except SingularMatrix as error:
                return None, str(error)
            made = k
        clock = time.perf_counter()
        correction = kept.solve(system.residual[0])
        system.seconds.solve += time.perf_counter() - clock
        work = abs(float(system.residual[0] @ correction))
        if not math.isfinite(work):
            return None, "the residual is not finite"
        record.iterations += 1
        first = work if k == 1 else first
        record.residual = work / first if first > 0.0 else 0.0
        left = work / last if last > 0.0 else 1.0
        if left > 1.0 and made == 0:
            return None, "the matrix of an earlier step does not serve any more"
        delta = delta + correction
        if _ends(rule, k, work, first, left, new) or (k >= rule.least and work <= floor):
            if k - made > kept.patience:
                kept.forget()
            if system.inside(state, step, delta):
                return delta, None
            return None, "a normal left its chart"
        new = not rule.keep or (k > 1 and _too_slow(
            rule, k, work, first, left, LONGEST * kept.patience))
        last = work
    return None, (f"{rule.max_iterations} iterations reached cc = {record.residual:.2g} "
                  f"instead of {rule.tolerance:.2g}")
