"""Errors and rates of convergence of a sequence of meshes, by the paper's rule and by Richardson's;
limits of a sequence of time steps.

The paper takes the finest mesh as the reference, which makes the rate of the finer meshes look
better than it is; Richardson's way needs no reference: it compares successive differences.
"""

from typing import NamedTuple

import numpy as np

EQUAL_RATIOS = 1e-2
"""Largest relative difference of two refinement ratios that count as the same."""


SECOND = (1.5, 2.5)
"""Observed orders in the time step with which its limit is extrapolated."""


class Fit(NamedTuple):
    """Straight line through logarithms; NaN where the points do not define it."""

    slope: float
    r_squared: float


class Richardson(NamedTuple):
    """Observed orders (n,), NaN for the first two meshes, and the extrapolated limit."""

    orders: np.ndarray
    limit: float


class Limit(NamedTuple):
    """A value at a time step of zero, its uncertainty, and the order that was used, NaN if none."""

    value: float
    uncertainty: float
    order: float


def log_log_fit(x, y):
    """``Fit`` by least squares; points that are not positive are left out.  Two points have no
    slope: any line goes through them."""
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    good = x > 0.0
    return semi_log_fit(np.log(x[good]), y[good])


def semi_log_fit(x, y):
    """``Fit`` of log y against x; otherwise as ``log_log_fit``."""
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    x, y = x[y > 0.0], np.log(y[y > 0.0])
    if len(x) < 3:
        return Fit(np.nan, np.nan)
    return Fit(float(np.polyfit(x, y, 1)[0]), float(np.corrcoef(x, y)[0, 1] ** 2))


def finest_as_reference(elements, values):
    """Relative errors |E_N - E_ref| / E_ref (n,) and their ``Fit`` against the elements along
    an edge, sqrt(elements): the paper's rule."""
    values = np.asarray(values, dtype=float)
    errors = np.abs(values - values[-1]) / abs(values[-1])
    return errors, log_log_fit(np.sqrt(elements)[:-1], errors[:-1])


def richardson(elements, values):
    """``Richardson`` of meshes refined in both directions.

    With differences d_k = E_k - E_(k-1) and the ratio r of element sizes, the order is
    ``log(d_(k-1) / d_k) / log r`` and the limit ``E_n + d_n / (r^p - 1)`` with the last order p.
    NaN where differences change their sign, do not decrease, or the ratio is not constant.
    """
    values = np.asarray(values, dtype=float)
    ratios = np.sqrt(np.asarray(elements[1:], dtype=float) / elements[:-1])
    orders, limit = np.full(len(values), np.nan), np.nan
    d = np.diff(values)
    for k in range(1, len(d)):
        if abs(ratios[k] / ratios[k - 1] - 1.0) < EQUAL_RATIOS and d[k] * d[k - 1] > 0.0:
            orders[k + 1] = np.log(d[k - 1] / d[k]) / np.log(ratios[k])
    if len(d) and orders[-1] > 0.0:
        limit = values[-1] + d[-1] / (ratios[-1] ** orders[-1] - 1.0)
    return Richardson(orders, float(limit))


def step_limit(values):
    """``Limit`` of values at time steps of which each is half of the one before.

    With three that show second order, Richardson's: ``E_n + d_n / (2^p - 1)``, uncertain by what it
    adds to E_n.  Else E_n, uncertain by d_n, what the last halving changed.
    """
    d = np.diff(np.asarray(values, dtype=float))
    if not len(d):
        return Limit(float(values[-1]) if len(values) else np.nan, np.nan, np.nan)
    order = np.log2(d[-2] / d[-1]) if len(d) > 1 and d[-1] * d[-2] > 0.0 else np.nan
    if not SECOND[0] <= order <= SECOND[1]:
        return Limit(float(values[-1]), float(abs(d[-1])), np.nan)
    added = d[-1] / (2.0**order - 1.0)
    return Limit(float(values[-1] + added), float(abs(added)), float(order))


def mesh_errors(values):
    """Change of each mesh's value to the next finer mesh (n,); the finest one's is that of the mesh
    before it, larger than its own error where refinement helps."""
    changes = np.abs(np.diff(np.asarray(values, dtype=float)))
    return np.append(changes, changes[-1:]) if len(changes) else np.full(len(values), np.nan)


def crossing(x, y, level):
    """Where log y(log x) reaches ``level``: (x, whether it lies beyond the points).

    Between two neighbouring points, or beyond the end that is nearer, by a straight line; NaN
    without two points or where that line is level.
    """
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    good = (x > 0.0) & (y > 0.0)
    order = np.argsort(x[good])
    x, y = np.log(x[good])[order], np.log(y[good])[order]
    if len(x) < 2:
        return np.nan, True
    target = np.log(level)
    inside = np.flatnonzero((y[:-1] <= target) & (target <= y[1:]))
    k = int(inside[0]) if len(inside) else 0 if target < y[0] else len(x) - 2
    slope = (y[k + 1] - y[k]) / (x[k + 1] - x[k])
    if slope <= 0.0:
        return np.nan, True
    return float(np.exp(x[k] + (target - y[k]) / slope)), not len(inside)
