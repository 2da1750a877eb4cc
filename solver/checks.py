"""Checks of single values: each returns the value in its own type or raises ``InputError``."""

import numpy as np

from .errors import InputError

HUGE = 1e100
"""Largest size of an input number; squares and products of larger ones overflow."""


def number(name, value, unit=""):
    """A finite float; bools, strings and arrays are refused."""
    if isinstance(value, bool | np.bool_ | str | complex) or np.ndim(value) or value is None:
        raise InputError(f"{name} must be a number{_in(unit)}, is {value!r}")
    try:
        result = float(value)
    except (TypeError, ValueError):
        raise InputError(f"{name} must be a number{_in(unit)}, is {value!r}") from None
    if not abs(result) < HUGE:
        raise InputError(f"{name} must be finite and below {HUGE:g}{_in(unit)}, is {result:g}")
    return result


def integer(name, value):
    """An int; floats, bools and strings are refused."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | np.integer):
        raise InputError(f"{name} must be an integer, is {value!r}")
    return int(value)


def vector(name, value, unit=""):
    """Three finite floats as a tuple."""
    try:
        items = tuple(value) if not isinstance(value, str) else ()
    except TypeError:
        items = ()
    if len(items) != 3:
        raise InputError(f"{name} must be three numbers{_in(unit)}, is {value!r}")
    return tuple(number(f"{name}[{k}]", item, unit) for k, item in enumerate(items))


def integers(name, values):
    """A tuple of ints from any sequence of integers."""
    try:
        items = tuple(values) if not isinstance(values, str) else None
    except TypeError:
        items = None
    if items is None:
        raise InputError(f"{name} must be a sequence of integers, is {values!r}")
    return tuple(integer(f"{name}[{k}]", item) for k, item in enumerate(items))


def choice(name, value, choices):
    """One of ``choices``."""
    if not isinstance(value, str) or value not in choices:
        raise InputError(f"{name} '{value}' is unknown, must be one of: {', '.join(choices)}")
    return value


def floats(name, values, shape):
    """A read-only C-contiguous float64 array of the given shape; None stands for any size."""
    needed = ", ".join("n" if size is None else str(size) for size in shape)
    try:
        array = np.asarray(values)
    except ValueError:
        raise InputError(f"{name}: rows of different lengths, ({needed}) needed") from None
    if array.dtype.kind not in "iuf":
        raise InputError(f"{name}: not an array of numbers")
    array = np.array(array, dtype=np.float64, order="C")
    wanted = tuple(size if want is None else want for want, size in zip(shape, array.shape))
    if array.ndim != len(shape) or array.shape != wanted or not array.size:
        raise InputError(f"{name}: shape {array.shape} given, ({needed}) needed")
    bad = np.argwhere(~(np.abs(array) < HUGE))
    if len(bad):
        where = ", ".join(str(int(i)) for i in bad[0])
        raise InputError(f"{name}[{where}] is {array[tuple(bad[0])]}, must be finite and below "
                         f"{HUGE:g}")
    array.setflags(write=False)
    return array


def _in(unit):
    return f" [{unit}]" if unit else ""
