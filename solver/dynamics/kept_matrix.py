"""One factorization for many iterations and steps: a step's matrix, carried along with the nodes.

See ``kernels.transport`` for how it is turned; here is when it is made, kept and given up.
"""

import math

import numpy as np

from ..kernels import transport
from ..kernels.arguments import Turning
from ..kernels.calls import Call
from ..system.linear import row_lengths

LEAST_PATIENCE, MOST_PATIENCE, PATIENCE_ROW = 4, 11, 12.0
"""A step may take r / ``PATIENCE_ROW`` iterations with a kept matrix, r being the root mean square
of the rows' lengths, between the other two, before the next one makes its own: the longer the rows,
the dearer that is (measured, see the documentation on speed)."""

REPLACED_AFTER = 1.65
"""Times the patience, in iterations expected for a step: then it is replaced within the step."""

STALLED_RATIO = 0.25
"""Part of the work that may be left after a correction with a kept matrix."""


class KeptMatrix:
    """The factorization of a step's matrix, and how far the nodes have turned since.

    Attributes:
        patience: iterations that a step may take with it before the next one makes its own.
    """

    replaced_after = REPLACED_AFTER

    def __init__(self, system):
        numbering, quads, fixed = system.numbering, system.model.quads, system.dofs.fixed
        n_nodes = len(system.model.nodes)
        row = np.sqrt(np.mean(row_lengths(numbering).astype(float)**2))
        self.patience = float(np.clip(row // PATIENCE_ROW, LEAST_PATIENCE, MOST_PATIENCE))
        corner = np.empty(n_nodes, dtype=np.int64)
        corner[quads] = np.arange(len(quads))[:, None]
        alone = []
        for body, (node, _) in zip(system.model.bodies, system.model.body_masses):
            corner[node] = corner[body.nodes[0]] if body.nodes else 0
            alone.extend([] if body.nodes else [node])
        held = np.zeros(n_nodes, dtype=bool)
        held[numbering.node_of_dof[fixed]] = True
        held[alone] = True
        if system.coordinates.constraints:
            held[system.coordinates.constraints.nodes] = True
        twin = np.arange(n_nodes)
        for group in system.model.joined:
            held[group] = held[group].any()
            twin[group] = group[0]
        blocks = np.zeros((4, n_nodes, 3, 3))
        self._turning = Turning(corner, held, twin, *blocks, *blocks[2:])
        self._system, self._nodes, self._quads = system, system.dofs.nodes, quads
        self._mass = system.nodal_mass
        self._free = system.floating
        self._turned = np.zeros(numbering.n_dof)
        self._keep, self._carry = Call(transport.keep), Call(transport.carry)
        self._turn_back, self._turn_on = Call(transport.turn_back), Call(transport.turn_on)
        self._balance = Call(transport.balance)
        self.forget()

    def forget(self):
        """Drop the factorization: the next step starts with its own."""
        self._step, self._number, self._carried, self._columns = None, None, False, False

    def serves(self, step):
        """Whether there still is the factorization of a step of this length and scheme."""
        return self._step == step and self._number == self._system.factorizations

    def made(self, step, state, place):
        """Take the factorization that the solver has just made for a step from ``state``."""
        self._step, self._number, self._carried = step, self._system.factorizations, False
        self._keep(self._nodes, self._quads, state.motion, place.start, self._turning)

    def carry(self, state, place):
        """Turn the factorization along with the nodes to a step that starts at ``state``."""
        self._carry(self._nodes, self._quads, state.motion, place.start, self._turning)
        self._carried = True

    def solve(self, residual):
        """Correction for a residual, ``T K_0^-1 T^T r``; of a free shell with its exact mean; with
        the multipliers of constraints, whose columns ``K^-1 G_m^T`` are kept with the
        factorization."""
        linked = self._system.linked
        if linked:
            correction = self._with_multipliers(linked, residual)
        else:
            correction = self._solved(residual)
        if not self._carried:
            return correction
        self._turn_on(self._nodes, self._turning, correction)
        if self._free:
            self._balance(self._nodes.start, self._mass, self._step.delta, residual, correction)
        return correction

    def _with_multipliers(self, linked, residual):
        if not self._columns:
            linked.take_columns(self._solve_rows)
            self._columns = True
        correction = self._solved(residual)
        linked.split(self._turning, self._carried, correction)
        return correction

    def _solved(self, residual):
        """``K_0^-1 T^T r``"""
        if not self._carried:
            return self._system.solver.solve(residual)
        self._turn_back(self._nodes, self._turning, residual, self._turned)
        return self._system.solver.solve(self._turned)

    def _solve_rows(self, rows):
        """The same of each row, in its place."""
        if self._carried:
            for row in rows:
                self._turn_back(self._nodes, self._turning, row, self._turned)
                row[:] = self._turned
        self._system.solver.solve_rows(rows)

    def too_slow(self, k, work, wanted, left):
        """Whether the correction after the k-th needs its own matrix: this one has stalled, or
        would take too many iterations.

        Args:
            k: number of the correction; work: that it has done.
            wanted: work at which the iteration ends.
            left: ratio of the work to that of the correction before.
        """
        if left > STALLED_RATIO:
            return True
        missing = math.log(work * left / wanted)
        return k + missing / -math.log(left) > self.replaced_after * self.patience


class TurnedMatrix(KeptMatrix):
    """The same of the exact scheme: a matrix of the middle of a step, whose corrections are turned
    to its end, see ``kernels.transport``; it is carried along within steps.  Iterations go on to
    rounding error: there are more of them."""

    replaced_after = 2.5

    def __init__(self, system):
        super().__init__(system)
        blocks = self._turning.Q, self._turning.J
        self._turning = self._turning._replace(Q_forces=np.zeros_like(blocks[0]),
                                               J_forces=np.zeros_like(blocks[1]))
        self._keep, self._carry = Call(transport.keep_step), Call(transport.carry_step)

    def forget(self):
        """Drop the factorization: the next step starts with its own."""
        super().forget()
        self._carried, self.stale = True, False

    def made(self, step, state, place):
        """Take the factorization that the solver has just made for an iterate."""
        self._step, self._number, self.stale = step, self._system.factorizations, False
        self._keep(self._nodes, self._quads, state.motion, self._system.nodal, self._turning)

    def carry(self, state, place):
        """Turn the factorization along with the nodes to the iterate that was assembled last."""
        self._carry(self._nodes, self._quads, state.motion, self._system.nodal, self._turning)
