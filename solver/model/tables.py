"""Springs and dampers given as tables: what holds back at changes, and at their rates."""

import numpy as np

from ..checks import TINY, numbers
from ..errors import InputError
from ..fields import put

ROUNDING = 1e-12
"""Part of the values of a damper's table by which the one at rest may miss zero."""


def check_tables(what, item, spring, damper, units):
    """Check the tables of an item, and make tuples of them.

    Args:
        what: name of the item in messages.
        item: what has them.
        spring, damper: two names each, of their places, rising, and of the values there.
        units: of the damper's places, and of its values.

    Raises:
        InputError: places that do not rise or are fewer than two, other numbers of values, a
            damper that drives the motion or acts at rest.
    """
    for places, values in (spring, damper):
        x, f = (numbers(f"{what}: {name}", getattr(item, name)) for name in (places, values))
        put(item, **{places: x, values: f})
        if len(x) != len(f):
            raise InputError(f"{what}: {len(x)} {places} but {len(f)} {values}")
        if len(x) == 1:
            raise InputError(f"{what}: {places} must be two or more, one is given")
        for k, (one, other) in enumerate(zip(x, x[1:])):
            if not other - one >= TINY:
                raise InputError(f"{what}: {places} must rise, {places}[{k + 1}] = {other:g} "
                                 f"follows {one:g}")
    x, f = (getattr(item, name) for name in damper)
    values, (of_rate, unit) = damper[1], units
    for k, (rate, value) in enumerate(zip(x, f)):
        if rate * value < 0.0:
            raise InputError(f"{what}: {values}[{k}] = {value:g} {unit} drives the motion at "
                             f"{rate:g} {of_rate}: its sign must be that of the rate")
    if x and abs(np.interp(0.0, x, f)) > ROUNDING * max(map(abs, f)):
        raise InputError(f"{what}: {values} must be zero at rest, are {np.interp(0.0, x, f):g} "
                         f"{unit} there")
