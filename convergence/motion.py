"""How a run moves, from its frames: symmetry planes, extreme displacements, whether it repeats."""

from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from corovec.solver.model.mesh import node_at
from corovec.verification.symmetry import asymmetry

from .rates import log_log_fit, semi_log_fit

SATURATED = 1e-3
"""Asymmetry over the size of the shell up to which its growth is fitted."""

FINER = 8
"""Points between two frames at which displacements are interpolated, and between two frequencies
of a spectrum."""

MAIN_LOBE = 2 * FINER
"""Points on either side over which Hann's window spreads a line of a spectrum."""


class Growth(NamedTuple):
    """How values grow from ``begin`` to ``end`` [s]: the ``rate`` [1/s] of an exponential and the
    ``power`` of a power of time, with R² of both straight lines; NaN where there is too little."""

    rate: float
    rate_r_squared: float
    power: float
    power_r_squared: float
    begin: float
    end: float


class Recurrence(NamedTuple):
    """Lag [s] after which a history resembles itself most, and its correlation with itself there:
    1 if it is periodic, NaN where it does not oscillate."""

    lag: float
    correlation: float


class Line(NamedTuple):
    """Strongest line of a spectrum: its period [s] and its share of the variance."""

    period: float
    share: float


@cache
def deviations(outcome, axis):
    """Times of the frames [s], and the largest distance of nodes from the mirror images of their
    partners at the plane normal to ``axis``, over the largest distance of a node from the origin.
    """
    time, displacement = outcome.frames
    nodes = outcome.run.model.nodes
    return time, asymmetry(nodes, displacement, axis) / np.linalg.norm(nodes, axis=1).max()


def displacement(outcome, point, component):
    """Times since unloading [s], and a displacement component of the node at ``point`` [m]: a cubic
    spline through the frames, ``FINER`` times as dense."""
    time, frames = outcome.frames
    model = outcome.run.model
    node = node_at(model.nodes, point)
    free = time[time >= model.unloaded_at]
    step = (time[1] - time[0]) / FINER
    dense = free[0] + step * np.arange(int((free[-1] - free[0]) / step * (1.0 + 1e-12)) + 1)
    return dense, CubicSpline(time, frames[:, node, "xyz".index(component)])(dense)


def growth(time, values, begin):
    """``Growth`` of ``values`` from ``begin`` [s] until they first exceed ``SATURATED``.

    Rounding errors that accumulate grow with a power of time, those that an unstable motion
    multiplies exponentially: the better straight line tells.
    """
    above = np.flatnonzero(values > SATURATED)
    part = slice(np.searchsorted(time, begin), above[0] if len(above) else len(values))
    time, values = time[part], values[part]
    ends = map(float, time[[0, -1]]) if len(time) else (np.nan, np.nan)
    return Growth(*semi_log_fit(time, values), *log_log_fit(time, values), *ends)


def recurrence(time, values):
    """``Recurrence`` of equally spaced ``values``: over lags from where the correlation of
    the overlapping parts first turns negative up to half of the record."""
    lags = np.arange(1, len(values) // 2)
    correlation = np.array([np.corrcoef(values[:-k], values[k:])[0, 1] for k in lags])
    negative = np.flatnonzero(correlation < 0.0)
    if not len(negative):
        return Recurrence(np.nan, np.nan)
    best = negative[0] + np.argmax(correlation[negative[0]:])
    return Recurrence(float(lags[best] * (time[1] - time[0])), float(correlation[best]))


def dominant_line(time, values):
    """``Line`` of equally spaced ``values`` about their mean, by Hann's window."""
    from scipy.signal import periodogram
    frequency, power = periodogram(values, 1.0 / (time[1] - time[0]), window="hann",
                                   nfft=FINER * len(values), detrend="constant")
    peak = int(np.argmax(power[1:])) + 1
    lobe = power[max(1, peak - MAIN_LOBE):peak + MAIN_LOBE + 1]
    return Line(float(1.0 / frequency[peak]), float(lobe.sum() / power[1:].sum()))
