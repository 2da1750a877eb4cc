"""Functions of time that loads and prescribed displacements follow: plain data, called with a time.

A time may be an array.  In statics the load factor stands for it.
"""

import csv
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..checks import integers, number, numbers, path, positive, shown, text
from ..errors import InputError
from .arithmetic import arithmetic

FINER = 8
"""Points in each step at which a function without a closed integral is summed."""


class FunctionOfTime:
    """A function f(t) of the time [s].

    Attributes:
        end: time from which it is zero for good; infinity if it never is.
        settled: time from which it is constant; infinity if it never is.
    """

    end = settled = np.inf

    def lost(self, middle, dt):
        """What steps of ``dt`` that see f at their ``middle`` miss of its integral; all of it [s].

        Here the sums over all steps of ``|f - mean f| dt`` and of ``mean |f| dt``, of ``FINER``
        points in each step.
        """
        within = ((np.arange(FINER) + 0.5) / FINER - 0.5) * dt
        values = self((np.asarray(middle)[:, None] + within).ravel()).reshape(-1, FINER)
        lost = np.abs(self(middle) - values.mean(axis=1)).sum()
        return float(lost * dt), float(np.abs(values).mean(axis=1).sum() * dt)

    def curve(self, end=1.0):
        """(times, values) of points that draw f from 0 to ``end`` [s] as lines."""
        times = np.linspace(0.0, end, 1001)
        return times, self(times)


class _Tabulated(FunctionOfTime):
    """A function given by ``times`` and ``values``, whose ``integral`` is known."""

    def __post_init__(self):
        what = type(self).__name__
        for name in ("times", "values"):
            items = numbers(f"{what}: {name}", getattr(self, name))
            object.__setattr__(self, name, items)
        if len(self.times) != len(self.values) or not self.times:
            raise InputError(f"{what}: {len(self.times)} times but {len(self.values)} values")
        if np.any(np.diff(self.times) <= 0.0):
            raise InputError(f"{what}: times {shown(self.times)} must increase")

    @property
    def end(self):
        """Time from which the function is zero for good; infinity if it never is."""
        acting = np.flatnonzero(self.values)
        if not len(acting):
            return 0.0
        last = int(acting[-1])
        return self.times[last + 1] if last + 1 < len(self.times) else np.inf

    @property
    def settled(self):
        """Time of the last point [s]."""
        return self.times[-1]

    def lost(self, middle, dt):
        """What the steps miss of the integral in sum, and its size, at least a thousandth of that
        of the largest value."""
        exact = self.integral(len(middle) * dt)
        least = 1e-3 * np.abs(self.values).max() * len(middle) * dt
        return abs(float(self(middle).sum()) * dt - exact), max(abs(exact), least)


@dataclass(frozen=True)
class TimeFunction(_Tabulated):
    """Piecewise linear f(t) through the points (times, values); constant beyond both ends."""

    times: tuple
    values: tuple

    def __call__(self, time):
        """f at a time [s]."""
        if np.ndim(time) == 0:
            return self.values[-1] if time >= self.times[-1] else float(
                np.interp(time, *self._points))
        return np.interp(time, *self._points)

    @cached_property
    def _points(self):
        return np.array(self.times), np.array(self.values)

    def integral(self, end):
        """Exact integral of f from 0 to ``end``: the impulse per unit of force."""
        inside = [t for t in self.times if 0.0 < t < end]
        points = np.array([0.0, *inside, end])
        return float(np.trapezoid(np.interp(points, self.times, self.values), points))

    def curve(self, end=None):
        """Its points."""
        return self._points


@dataclass(frozen=True)
class Steps(_Tabulated):
    """f(t) that jumps: ``values[k]`` from ``times[k]`` on, zero before the first; a sudden release
    is ``Steps((0.0, t), (1.0, 0.0))``."""

    times: tuple
    values: tuple

    def __call__(self, time):
        """f at a time [s]."""
        found = np.searchsorted(self.times, time, side="right")
        value = np.array((0.0, *self.values))[found]
        return float(value) if np.ndim(time) == 0 else value

    def integral(self, end):
        """Exact integral of f from 0 to ``end`` [s]."""
        edges = np.clip((*self.times, end), 0.0, end)
        return float(np.dot(np.diff(edges), self.values))

    def curve(self, end=0.0):
        """Its corners."""
        last = max(end, 1.2 * self.times[-1])
        times = np.repeat((0.0, *self.times, last), 2)[1:-1]
        return times, np.repeat((0.0, *self.values), 2)


@dataclass(frozen=True)
class Harmonic(FunctionOfTime):
    """f(t) = mean + amplitude sin(2 pi frequency t + phase).

    Attributes:
        frequency: [Hz].
        amplitude: of the oscillation.
        phase: [rad].
        mean: about which it oscillates.
    """

    frequency: float
    amplitude: float = 1.0
    phase: float = 0.0
    mean: float = 0.0

    def __post_init__(self):
        object.__setattr__(self, "frequency",
                           positive("harmonic: frequency", self.frequency, "Hz"))
        for name, unit in (("amplitude", ""), ("phase", "rad"), ("mean", "")):
            value = number(f"harmonic: {name}", getattr(self, name), unit)
            object.__setattr__(self, name, value)

    def __call__(self, time):
        """f at a time [s]."""
        value = self.mean + self.amplitude * np.sin(
            2.0 * np.pi * self.frequency * np.asarray(time) + self.phase)
        return float(value) if np.ndim(time) == 0 else value


@dataclass(frozen=True)
class Expression(FunctionOfTime):
    """Arithmetic in the time t [s], as ``Expression("2 * sin(2 * pi * 5 * t) * exp(-t)")``.

    What it may consist of: see ``model.arithmetic``.  Nothing of it is executed as Python.
    """

    text: str

    def __post_init__(self):
        text("expression", self.text)
        self(np.linspace(0.0, 1.0, 3))

    def __call__(self, time):
        """f at a time [s]."""
        return arithmetic(self.text, t=time)


def read_time_function(file, columns=(0, 1)):
    """``TimeFunction`` of two columns of a CSV file, times [s] and values; a heading is skipped.

    Args:
        file: its path.
        columns: numbers of the two columns, from 0.

    Raises:
        InputError: the file cannot be read, has no such columns, or holds what is no number.
    """
    file, columns = path("file", file), integers("columns", columns)
    if len(columns) != 2 or min(columns) < 0:
        raise InputError(f"columns must be two numbers of columns, from 0, is {columns}")
    try:
        with open(file, newline="", encoding="utf-8-sig") as stream:
            rows = [row for row in csv.reader(stream) if row]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{file} cannot be read: {getattr(error, 'strerror', None) or error}"
                         ) from None
    points = []
    for k, row in enumerate(rows):
        try:
            points.append(tuple(float(row[column]) for column in columns))
        except (ValueError, IndexError):
            if k:
                raise InputError(f"{file}: row {k + 1} has no numbers in columns "
                                 f"{columns[0]} and {columns[1]}: {shown(row)}") from None
    if not points:
        raise InputError(f"{file} holds no numbers")
    try:
        return TimeFunction(*map(tuple, zip(*points)))
    except InputError as error:
        raise InputError(f"{file}: {error}") from None


CONSTANT = TimeFunction((0.0,), (1.0,))
