"""Forces given as tables of a change: linear between their points, constant beyond both ends.

A table of n points is a row of numbers: their places, the values there and the integrals from zero
to there.  That of a spring and that of a damper stand one after the other from a column ``first``
on, the numbers of their points in the two columns before it.
"""

from .jit import internal


@internal
def in_table(own, first, n, x):
    """Value, integral from zero and slope at x of a table of n points from a column ``first`` on;
    constant beyond both ends."""
    last = first + n - 1
    if x <= own[first]:
        return own[first + n], own[first + 2 * n] + own[first + n] * (x - own[first]), 0.0
    if x >= own[last]:
        return own[last + n], own[last + 2 * n] + own[last + n] * (x - own[last]), 0.0
    i = first
    while x >= own[i + 1]:
        i += 1
    slope = (own[i + n + 1] - own[i + n]) / (own[i + 1] - own[i])
    d = x - own[i]
    value = own[i + n] + slope * d
    if own[i] <= 0.0 <= own[i + 1]:  # from zero: the integrals of the ends would cancel
        k = i if own[i] + own[i + 1] >= 0.0 else i + 1
        return value, (own[k + n] - slope * own[k] + 0.5 * slope * x) * x, slope
    return value, own[i + 2 * n] + (own[i + n] + 0.5 * slope * d) * d, slope


@internal
def table_mean(own, first, n, before, after, weight):
    """``(V_1 - V_0) / (after - before)`` of the integral V of a table, and its derivative by
    ``after``; of equal ends the value, and ``weight`` times the slope.

    Sums over what lies between the points: nothing cancels however small the change is.
    """
    value, _, slope = in_table(own, first, n, after)
    change = after - before
    low, high = min(before, after), max(before, after)
    if not high > low:
        return value, weight * slope
    mean, turn, a = 0.0, 0.0, low
    at, _, _ = in_table(own, first, n, low)
    for i in range(first, first + n + 1):
        b = high if i == first + n else min(own[i], high)
        if b > a:
            other, _, _ = in_table(own, first, n, b)
            mean += 0.5 * (at + other) * (b - a)
            turn += (other - at) * (0.5 * (a + b) - before)
            a, at = b, other
    return mean / (high - low), turn / (change * abs(change))


@internal
def pull(own, first, before, after, weight, change, rate):
    """Value of both tables, and its derivative by ``after``: of the spring the mean from ``before``
    to ``after``, of the damper that at ``rate change``."""
    n, m = int(own[first - 2]), int(own[first - 1])
    value, slope = 0.0, 0.0
    if n > 0:
        value, slope = table_mean(own, first, n, before, after, weight)
    if m > 0:
        braked, _, more = in_table(own, first + 3 * n, m, rate * change)
        value += braked
        slope += rate * more
    return value, slope


@internal
def energy_in(own, first, x):
    """Energy of the spring at x [J]."""
    n = int(own[first - 2])
    return in_table(own, first, n, x)[1] if n > 0 else 0.0


@internal
def taken(own, first, damping, change, dt):
    """What a damper and its table took of a change in a step of length dt [J]."""
    n, m = int(own[first - 2]), int(own[first - 1])
    braked = in_table(own, first + 3 * n, m, change / dt)[0] if m > 0 else 0.0
    return (damping * change / dt + braked) * change
