"""Charts of smooth nodes: the vectorial rotational variables of one normal (Eqs. 5, 24-29).

A smooth node has two variables, components of its normal in the axes t_1, t_2, t_3 of its *triad*:
``p = n t_1 + m t_2 + sqrt(1 - n^2 - m^2) t_3``.  Triads are renewed between two steps only.
Either they are global axes, permuted and signed, as in the paper (the variables are then the
smaller components of p), or they follow the node, with t_3 along p as it will be at the middle of
the next step.
"""

import math

from .jit import inlined, internal, kernel
from .vectors import along, cross, dot

CHART_LIMIT = 0.95
"""n^2 + m^2 (and k^2 / (1 - n^2)) beyond which a chart is left: far outside a sound step."""

SWITCH_RATIO = 1.001
"""Hysteresis of global axes: t_3 changes once another component exceeds that along t_3 by this
ratio half a step ahead.

Just enough to stop a node from switching to and fro.  The border and its timing matter: rotational
oscillations far faster than the step are neither resolved nor damped; they keep their size in n,
so p_dot = A1 n_dot changes with the chart.  Switching late by an angle d multiplies them by
tan(45 deg + d) with every quarter turn; switching half a step ahead of the border is late as often
as early.  Axes that follow the node do not multiply them at all.
"""

EARLIEST = 0.4
"""Size of the dependent component now that a chart chosen ahead must have: a step may turn far."""

OBLIQUE = 3
"""What stands for the number of a kept axis that is no global one."""


@kernel
def normal(n, m, triad, p):
    """``p`` (3,) from its two variables; False (p untouched) where they leave the chart."""
    rest = 1.0 - n * n - m * m
    if not rest >= 1.0 - CHART_LIMIT:
        return False
    s = math.sqrt(rest)
    for c in range(3):
        p[c] = n * triad[0, c] + m * triad[1, c] + s * triad[2, c]
    return True


@kernel
def first_derivatives(p, triad, A1):
    """``A1`` (3, >=2) of Eq. (27): ``dp/dn = t_1 - (n/s) t_3``, ``dp/dm = t_2 - (m/s) t_3``."""
    s = along(p, triad, 2)
    a, b = along(p, triad, 0) / s, along(p, triad, 1) / s
    for c in range(3):
        A1[c, 0] = triad[0, c] - a * triad[2, c]
        A1[c, 1] = triad[1, c] - b * triad[2, c]


@kernel
def second_derivatives(p, triad):
    """``(s_nn, s_nm, s_mm)`` of Eq. (29) for s = p . t_3; the other components are linear."""
    n, m, s = along(p, triad, 0), along(p, triad, 1), along(p, triad, 2)
    cube = s * s * s
    return -1.0 / s - n * n / cube, -n * m / cube, -1.0 / s - m * m / cube


@internal
def convective(p, triad, rates):
    """The single component (along t_3) of A2, Eq. (28)."""
    nn, nm, mm = second_derivatives(p, triad)
    return (nn * rates[0] * rates[0] + 2.0 * nm * rates[0] * rates[1]
            + mm * rates[1] * rates[1])


@kernel
def empty(triad):
    """Whether a node has no triad yet."""
    return triad[2, 0] == 0.0 and triad[2, 1] == 0.0 and triad[2, 2] == 0.0


@inlined
def kept_component(kept):
    """Number of the global axis that ``kept`` (3,) is; ``OBLIQUE`` for another, -1 for zero."""
    if kept[0] == 0.0 and kept[1] == 0.0 and kept[2] == 0.0:
        return -1
    for c in range(3):
        if kept[c] == 1.0:
            return c
    return OBLIQUE


@kernel
def choose_triad(v, ahead, old, kept, follow, triad):
    """Fill ``triad`` for a unit vector ``v`` that moves to ``ahead``; False if it is ``old``.

    Axes that ``follow`` the node, where there are any before and they suit ``v``: t_3 along
    ``ahead``, t_1 as near to the old one as it can be.  Else global ones.  A unit vector ``kept``,
    along which a support fixes the component, stays t_1 (zero: none); where it is no global axis,
    the others always follow.
    """
    component = kept_component(kept)
    if component != OBLIQUE and (
            not follow or (old[2, 0] == 0.0 and old[2, 1] == 0.0 and old[2, 2] == 0.0)):
        return _choose_global(v, ahead, old, component, triad)
    if component >= 0:
        share = dot(ahead, kept)
        for c in range(3):
            triad[0, c] = kept[c]
            triad[2, c] = ahead[c] - share * kept[c]
    else:
        for c in range(3):
            triad[2, c] = ahead[c]
    size = math.sqrt(dot(triad[2], triad[2]))
    for c in range(3):
        triad[2, c] /= size
    if component < 0:
        share = dot(old[0], triad[2])
        for c in range(3):
            triad[0, c] = old[0, c] - share * triad[2, c]
        size = math.sqrt(dot(triad[0], triad[0]))
        for c in range(3):
            triad[0, c] /= size
    if size > 0.1 and dot(v, triad[2]) > EARLIEST:
        cross(triad[2], triad[0], triad[1])
        return True
    if component == OBLIQUE:
        return _choose_about(v, kept, triad)
    return _choose_global(v, v, old, component, triad)


@internal
def _choose_about(v, kept, triad):
    """Axes with t_1 ``kept`` and t_3 as near to ``v`` as it can be."""
    share = dot(v, kept)
    size = math.sqrt(1.0 - share * share)
    for c in range(3):
        triad[0, c] = kept[c]
        triad[2, c] = (v[c] - share * kept[c]) / size
    cross(triad[2], triad[0], triad[1])
    return True


@internal
def _choose_global(v, ahead, old, fixed_component, triad):
    """Global axes: the one along t_3 stays unless another component exceeds it by
    ``SWITCH_RATIO`` (``old = 0``: none yet, the largest)."""
    best, size = -1, -1.0
    if not empty(old):
        for c in range(3):
            if abs(old[2, c]) == 1.0:
                best, size = c, abs(ahead[c]) * SWITCH_RATIO
    before = best
    for c in range(3):
        if c != fixed_component and abs(ahead[c]) > size:
            best, size = c, abs(ahead[c])
    if best == before or (before >= 0 and abs(v[best]) < EARLIEST):
        for row in range(3):
            for c in range(3):
                triad[row, c] = old[row, c]
        return False
    one, two = (best + 1) % 3, (best + 2) % 3
    if two == fixed_component:
        one, two = two, one
    for row in range(3):
        for c in range(3):
            triad[row, c] = 0.0
    triad[0, one] = triad[1, two] = 1.0
    triad[2, best] = 1.0 if v[best] >= 0.0 else -1.0
    return True
