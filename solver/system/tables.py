"""Rows of constants with tables of springs and dampers, as ``kernels.tables`` takes them."""

import numpy as np


def columns_of(tables, share=1.0):
    """Numbers of points of ``tables``, places and values each, then the tables with ``share`` of
    the values."""
    return [*(len(places) for places, _ in tables),
            *(number for places, values in tables for number in _table(places, values, share))]


def stacked(rows, least):
    """Rows of constants as one array, the shorter ones filled with zeros, of ``least`` columns at
    least."""
    constants = np.zeros((len(rows), max(map(len, rows), default=least)))
    for own, row in zip(constants, rows):
        own[:len(row)] = row
    return constants


def _table(places, values, share):
    """Places, ``share`` of the values there, and their integrals from zero, of a table that is
    constant beyond its ends; of none nothing."""
    if not places:
        return []
    x, m = np.array(places), share * np.array(values)
    sums = np.r_[0.0, np.cumsum(0.5 * (m[1:] + m[:-1]) * np.diff(x))]
    inside = np.clip(0.0, x[0], x[-1])
    k = min(np.searchsorted(x, inside, side="right") - 1, len(x) - 2)
    slope, d = (m[k + 1] - m[k]) / (x[k + 1] - x[k]), inside - x[k]
    zero = sums[k] + (m[k] + 0.5 * slope * d) * d - np.interp(0.0, x, m) * inside
    return [*x, *m, *(sums - zero)]
