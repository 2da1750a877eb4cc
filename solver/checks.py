"""Checks of single values: each returns the value in its own type or raises ``InputError``."""

import os
import re
from collections import Counter
from collections.abc import Mapping, Set

import numpy as np

from .errors import InputError

HUGE = 1e30
"""Input numbers are smaller: products of ten of them, such as E h^3 A^3, do not overflow."""

TINY = 1e-30
"""Sizes that must be positive are not smaller: products of ten of them do not underflow."""


LARGEST = 10**15
"""Integers are not larger: they are counts and numbers of nodes and elements."""

LONGEST_NAME = 200
"""Characters of a name."""

LONGEST_PATH = 4096
"""Characters of a path: no system takes more."""

NOT_NUMBERS = (bool, np.bool_, str, bytes, bytearray, complex, np.complexfloating, np.datetime64,
               np.timedelta64)
"""What Python takes for a number, or converts to one, and is none here."""


def number(name, value, unit=""):
    """A finite float; bools, strings, arrays and masked values are refused."""
    if type(value) is float and abs(value) < HUGE:  # most are, and large meshes have many
        return value
    try:
        if isinstance(value, NOT_NUMBERS) or not single(value) or np.ma.is_masked(value):
            raise TypeError
        result = float(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name} must be a number{_in(unit)}, is {shown(value)}") from None
    if not abs(result) < HUGE:
        raise InputError(f"{name} must be finite and below {HUGE:g}{_in(unit)}, is {result:g}")
    return result


def positive(name, value, unit=""):
    """A float of at least ``TINY``."""
    result = number(name, value, unit)
    if result < TINY:
        raise InputError(f"{name} must be positive{_in(unit)}, at least {TINY:g}, is {result:g}")
    return result


def not_negative(name, value, unit=""):
    """A float that is zero or more."""
    result = number(name, value, unit)
    if result < 0.0:
        raise InputError(f"{name} must not be negative, is {result:g}{' ' * bool(unit)}{unit}")
    return result


def integer(name, value):
    """An int; floats, bools and strings are refused."""
    if isinstance(value, NOT_NUMBERS) or not isinstance(value, int | np.integer):
        raise InputError(f"{name} must be an integer, is {shown(value)}")
    if abs(int(value)) > LARGEST:
        raise InputError(f"{name} must be at most {LARGEST:.0e}, is {shown(value)}")
    return int(value)


def flag(name, value):
    """A bool."""
    if not isinstance(value, bool | np.bool_):
        raise InputError(f"{name} must be True or False, is {shown(value)}")
    return bool(value)


def function(name, value):
    """Something that can be called, and is no class."""
    if not callable(value) or isinstance(value, type):
        raise InputError(f"{name} must be a function, is {shown(value)}")
    return value


def text(name, value):
    """A name: one line of printable characters."""
    if not isinstance(value, str) or not value.isprintable() or not 1 <= len(value) <= LONGEST_NAME:
        raise InputError(f"{name} must be one line of 1 to {LONGEST_NAME} printable characters, is "
                         f"{shown(value)}")
    return value


def names_columns(value):
    """Whether a value is a name that is fit for columns of a table."""
    return isinstance(value, str) and bool(re.fullmatch(r"[A-Za-z]\w{0,99}", value, re.ASCII))


def path(name, value):
    """A ``str``, or a path object of the system; whether there is a file is another matter."""
    if not isinstance(value, str | os.PathLike) or len(str(value)) > LONGEST_PATH:
        raise InputError(f"{name} must be a path, is {shown(value)}")
    return value


def count(name, value):
    """An int of at least 1."""
    result = integer(name, value)
    if result < 1:
        raise InputError(f"{name} must be at least 1, is {result}")
    return result


def vector(name, value, unit=""):
    """Three finite floats as a tuple."""
    items = _items(value)
    if items is None or len(items) != 3:
        raise InputError(f"{name} must be three numbers{_in(unit)}, is {shown(value)}")
    return tuple(number(f"{name}[{k}]", item, unit) for k, item in enumerate(items))


def numbers(name, values):
    """A tuple of floats from any sequence of numbers."""
    items = _items(values)
    if items is None:
        raise InputError(f"{name} must be a list of numbers, is {shown(values)}")
    return tuple(number(f"{name}[{k}]", item) for k, item in enumerate(items))


def integers(name, values):
    """A tuple of ints from any sequence of integers."""
    items = _items(values)
    if items is None:
        raise InputError(f"{name} must be a sequence of integers, is {shown(values)}")
    return tuple(integer(f"{name}[{k}]", item) for k, item in enumerate(items))


def distinct(name, values):
    """A tuple of ints, at least one, none of them twice."""
    items = integers(name, values)
    if not items:
        raise InputError(f"{name} must not be empty")
    item, times = Counter(items).most_common(1)[0]
    if times > 1:
        raise InputError(f"{name}: {item} is given {times} times")
    return items


def existing(name, numbers, size):
    """``numbers``, each of them one of 0 to ``size - 1``."""
    for item in numbers:
        if not 0 <= item < size:
            raise InputError(f"{name} {item} does not exist (0 to {size - 1})")
    return numbers


def choice(name, value, choices):
    """One of ``choices``."""
    if not isinstance(value, str) or value not in choices:
        raise InputError(f"{name} {shown(value)} is unknown, must be one of: "
                         f"{', '.join(choices)}")
    return value


def instance(name, value, kind):
    """An object of the class ``kind``."""
    if not isinstance(value, kind):
        raise InputError(f"{name} must be a {kind.__name__}, is {shown(value)}")
    return value


def plain_array(name, values, needed):
    """``values`` as an array; ragged rows, records and masked values are refused, naming the shape
    ``needed``."""
    try:
        array = np.ma.asarray(values)
    except (ValueError, TypeError):
        raise InputError(f"{name}: rows of different lengths, ({needed}) needed") from None
    if array.dtype.names:
        raise InputError(f"{name}: records given, an array ({needed}) needed")
    if np.ma.is_masked(array):
        raise InputError(f"{name}: some values are masked")
    return np.asarray(array)


def floats(name, values, shape):
    """A read-only C-contiguous float64 array of the given shape; None stands for any size."""
    needed = ", ".join("n" if size is None else str(size) for size in shape)
    array = plain_array(name, values, needed)
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


def single(value):
    """Whether a value is one, and no array or list of any kind."""
    try:
        return np.ndim(value) == 0
    except ValueError:  # ragged
        return False


def _items(values):
    """A tuple of the items; None for what has none or has them in no order."""
    if isinstance(values, str | bytes | bytearray | Set | Mapping):
        return None
    try:
        return tuple(values)
    except TypeError:
        return None


def shown(value):
    """The start of a value's representation, in one line."""
    try:
        text = " ".join(repr(value).split())
    except Exception as error:  # an integer of more digits than Python prints, an object's own
        text = f"a {type(value).__name__} that cannot be shown ({type(error).__name__})"
    return text if len(text) <= 80 else f"{text[:76]} ..."


def _in(unit):
    return f" [{unit}]" if unit else ""
