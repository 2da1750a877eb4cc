"""How a run moves, from its frames: symmetry planes, extreme displacements, whether it repeats."""

from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import periodogram

from solver.mesh import node_at
from verification.suites.benchmarks import asymmetry

BAND = (1e-13, 1e-3)
"""Asymmetry over the size of the shell between which its growth is fitted: above rounding, below
saturation."""

FINER = 8
"""Points between two frames at which displacements are interpolated, and between two frequencies
of a spectrum."""

MAIN_LOBE = 2 * FINER
"""Points on either side over which Hann's window spreads a line of a spectrum."""


class Growth(NamedTuple):
    """Exponential growth fitted from ``begin`` to ``end`` [s]: rate [1/s], R² of the straight line
    through the logarithms; NaN where too little lies in the band."""

    rate: float
    r_squared: float
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


def growth(time, values, band=BAND):
    """:class:`Growth` of ``values`` between the last time below ``band`` and the first above."""
    above = np.flatnonzero(values > band[1])
    end = above[0] if len(above) else len(values)
    below = np.flatnonzero(values[:end] < band[0])
    part = slice(below[-1] + 1 if len(below) else 0, end)
    t, logarithm = time[part], np.log(values[part])
    if len(t) < 3:
        return Growth(np.nan, np.nan, np.nan, np.nan)
    rate = np.polyfit(t, logarithm, 1)[0]
    return Growth(float(rate), float(np.corrcoef(t, logarithm)[0, 1] ** 2), float(t[0]),
                  float(t[-1]))


def recurrence(time, values):
    """:class:`Recurrence` of equally spaced ``values``: over lags from where the correlation of
    the overlapping parts first turns negative up to half of the record."""
    lags = np.arange(1, len(values) // 2)
    correlation = np.array([np.corrcoef(values[:-k], values[k:])[0, 1] for k in lags])
    negative = np.flatnonzero(correlation < 0.0)
    if not len(negative):
        return Recurrence(np.nan, np.nan)
    best = negative[0] + np.argmax(correlation[negative[0]:])
    return Recurrence(float(lags[best] * (time[1] - time[0])), float(correlation[best]))


def dominant_line(time, values):
    """:class:`Line` of equally spaced ``values`` about their mean, by Hann's window."""
    frequency, power = periodogram(values, 1.0 / (time[1] - time[0]), window="hann",
                                   nfft=FINER * len(values), detrend="constant")
    peak = int(np.argmax(power[1:])) + 1
    lobe = power[max(1, peak - MAIN_LOBE):peak + MAIN_LOBE + 1]
    return Line(float(1.0 / frequency[peak]), float(lobe.sum() / power[1:].sum()))
