"""The balance of a run: the energy of the shell against the work of its loads."""

import math

import numpy as np

from ..errors import AccuracyWarning, StepError, warn
from ..system.failure import NotConverged
from ..system.rounding import judge
from .result import gained, total_energy

STEP_SHARE = 0.05
"""Part of the largest energy so far by which a step may miss the work of its loads (measured on the
benchmarks, at steps too long by far for anything else: 2e-3)."""

END_SHARE = 0.2
"""Part of it by which a run may, before it ends."""

ROUNDOFFS = 100.0
"""Times the work of rounding error by which either may as well: there Newton's iteration ends, and
energies as small have no digits to compare."""

RUN_SHARE = 0.01
"""Part of the largest of a whole run by which a run may, before it is warned of."""

PESSIMISM = 50.0
"""The energy of rounded strains over that of the displacements' errors, square roots (measured:
55 to 75 on a plate that is turned from rest)."""

MANY_HALVINGS, FEW_HALVINGS = 0.02, 10
"""Halvings a step, and at all, from which a run is warned of."""


def settle(scheme, state, time, before, after, work, roundoff):
    """Compare a step's change of energy with the work of its loads; keeps ``peak`` and ``missed``.

    Args:
        scheme: ``Scheme``; one that does not conserve energy is not judged.
        state: ``State`` at its end.
        time: its end [s].
        before, after: energies [J].
        work: of the loads in the step [J].
        roundoff: work that is rounding error alone, see ``System.roundoff_work`` [J].

    Raises:
        NotConverged: energy came from nothing, or was lost.
        StepError: so it did, little by little, and now it is much.
    """
    missed, least = after - before - work, ROUNDOFFS * roundoff
    state.missed += missed
    state.peak = max(state.peak, before, after, abs(state.external_work), abs(state.support_work),
                     state.dissipated)
    if not scheme.conserves:
        return
    if not abs(missed) <= STEP_SHARE * state.peak + least:
        raise NotConverged(f"the energy changed by {after - before:.3g} J, the loads did "
                           f"{work:.3g} J of work")
    if abs(state.missed) > END_SHARE * state.peak + least:
        raise StepError(f"until t = {time:.9g} s the energy of the shell, {after:.4g} J, and the "
                        f"work of its loads, {state.external_work:.4g} J, have drifted apart by "
                        f"{state.missed:.4g} J: take a smaller dt")


def review(scheme, history, roundoff):
    """Warn of a run whose energy and work drifted apart, or whose energy is near rounding error.

    Args:
        scheme: ``Scheme``.
        history: its rows.
        roundoff: energy that rounding of the strains may have [J].

    Raises:
        StepError: energy is rounding error alone.
    """
    missed, peak = gained(history)
    wrong = missed if scheme.rho_inf < 1.0 else np.abs(missed)  # some is to be lost with less
    worst, energy = int(np.argmax(wrong)), total_energy(history)
    work = energy - energy[0] - missed
    if peak > 0.0:
        judge(math.sqrt(roundoff / peak) / PESSIMISM, f"the energy is {peak:.1g} J at most, that "
              f"of rounded strains {roundoff:.1g} J")
    if wrong[worst] > RUN_SHARE * peak + ROUNDOFFS * roundoff:
        warn(f"at t = {history['time'][worst]:.6g} s the energy of the shell has changed by "
             f"{energy[worst] - energy[0]:.4g} J, the loads did {work[worst]:.4g} J of work: "
             "take a smaller dt", AccuracyWarning)


class Halvings:
    """Warns once of a run whose steps are halved often, as soon as they are."""

    def __init__(self, dt, before):
        """``dt``: the time step [s]; ``before``: halvings of the part that is resumed."""
        self._dt, self._count, self._told = dt, before, False

    def add(self, step, halvings):
        """Count those of a ``step``, the number of which is that of the steps so far."""
        self._count += halvings
        if (halvings and not self._told and self._count >= FEW_HALVINGS
                and self._count > MANY_HALVINGS * step):
            self._told = True
            parts = (step + self._count) / step
            warn(f"{self._count} halvings in the first {step} steps: a smaller dt, of about "
                 f"{0.5 * self._dt / parts:.1g} s, is faster and more accurate", AccuracyWarning)
