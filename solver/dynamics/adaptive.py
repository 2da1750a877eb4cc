"""Steps that choose themselves: parts of a row's step, as short as an error of the motion asks.

A step of the history is divided where functions of time have points, and each of these segments
into 2^k equal parts: a power of two, so that matrices serve long and rows end where they should.
The error of a part of length h, mean velocities u of it and of the two before, is that of the
midpoint rule, ``h^3/12 x'''`` with x''' from divided differences of u; a part whose error is
larger than asked for is taken back.  A function of time without points would not be seen by parts
as long as its period, or as the pause before a pulse: it is sampled at the shortest parts, and may
change but little within one.  Each part is a step of the scheme: what it conserves, it conserves.
"""

import math

import numpy as np

from ..errors import AccuracyWarning, warn
from .newton import StepRecord

FINEST = 10
"""A segment is divided into at most 2^10 parts, by its error."""

FIRST = 3
"""So that the first one is divided into 2^3, before there is an error."""

SEEN = 0.25
"""Part of its range by which a function of time without points may change within a part: a
twelfth of a period of a sine."""

SAMPLES = 2**14
"""Times of a run at which the range of such a function is taken."""

EASY = 1.0 / 16.0
"""Part of the error asked for below which the next part is twice as long; the error is of third
order."""


class Adaptive:
    """Divides the steps of a run."""

    def __init__(self, stepper, settings, model):
        """``stepper``: ``Stepper``; ``settings``: ``Settings``, whose ``error`` is not zero;
        ``model``: ``Model``."""
        self._stepper, self._allowed, self._told = stepper, settings.error, False
        self._size = model.size
        self._weights = model.nodal_mass / model.nodal_mass.sum()
        self._kinks = np.array(sorted({time for history in histories_of(model)
                                       for time in getattr(history, "times", ())}))
        self._smooth = [history for history in histories_of(model) if not hasattr(history, "times")]
        self._ranges = np.ptp(self._values(0.0, settings.end_time, SAMPLES), axis=1)
        self._before = stepper.system.coordinates.blank_state(model)

    def advance(self, state, place, time, dt, record):
        """Move ``state`` and its ``place`` from ``time`` to ``time + dt`` [s]; arguments and errors
        of ``Stepper.advance``."""
        inside = self._kinks[(self._kinks > time + 1e-9 * dt)
                             & (self._kinks < time + (1.0 - 1e-9) * dt)]
        starts = [time, *inside.tolist()]
        # dt itself where it is whole: a length rounded anew would not find the matrix that is kept
        lengths = np.diff([*starts, time + dt]).tolist() if len(inside) else [dt]
        record.parts = 0
        for start, length in zip(starts, lengths, strict=True):
            self._segment(state, place, start, length, record)

    def _segment(self, state, place, start, length, record):
        """The parts of a segment."""
        whole = 2**FINEST
        values = self._values(start, length, whole)
        level = FIRST
        if state.part > 0.0:
            level = min(max(math.ceil(math.log2(length / state.part) - 1e-9), 0), FINEST)
        done = 0
        while done < whole:
            parts = whole >> level
            if level < FINEST and np.any(np.ptp(values[:, done:done + parts], axis=1)
                                         > SEEN * self._ranges):
                level += 1
                continue
            h = length * (parts / whole)
            own = StepRecord()
            self._before.take(state)
            x = state.x + state.x_low
            self._stepper.advance(state, place, start + length * (done / whole), h, own)
            error = self._error(state, ((state.x - x) + state.x_low) / h, h)
            if error > self._allowed and level < FINEST:
                state.take(self._before)
                self._stepper.system.observe(state, place)
                record.reject(own)
                level += 1
                continue
            if error > self._allowed and not self._told:
                self._told = True
                warn(f"at t = {start + length * (done / whole):.6g} s the error of a step is "
                     f"{error:.2g} of the shell's size though it was divided into {whole}: take a "
                     "smaller dt", AccuracyWarning)
            done += parts
            record.add(own)
            record.local_error = max(record.local_error, error)
            state.part = h
            if error < EASY * self._allowed and level and done % (2 * parts) == 0:
                level -= 1
                state.part = 2.0 * h

    def _values(self, start, length, n):
        """(functions, n) values of the functions without points, in the middle of n equal parts."""
        times = start + length * ((np.arange(n) + 0.5) / n)
        return np.array([history(times) for history in self._smooth]).reshape(-1, n)

    def _error(self, state, u, h):
        """Error of a part [sizes of the shell], whose mean velocity (n_nodes, 3) is ``u`` and goes
        to the ``means`` of the state."""
        lengths, means = state.spans, state.means
        error = 0.0
        if lengths[0] > 0.0:
            one, two = 0.5 * (h + lengths[1]), 0.5 * (lengths[1] + lengths[0])
            third = 2.0 * ((u - means[1]) / one - (means[1] - means[0]) / two) / (one + two)
            square = float(self._weights @ np.sum(third * third, axis=1))
            error = h**3 / 12.0 * math.sqrt(square) / self._size
        means[0], means[1] = means[1], u
        lengths[0], lengths[1] = lengths[1], h
        return error


def histories_of(model):
    """Functions of time of the loads, supports and joints of a model."""
    for item in (*model.loads, *model.supports, *model.joints):
        for name in ("history", "turning", "driving"):
            history = getattr(item, name, None)
            if history is not None:
                yield history
