"""Values that are no argument, and good ones with something spoiled in them."""

import copy
import datetime

import numpy as np


class Unshowable:
    """Something whose representation fails."""

    def __repr__(self):
        raise RuntimeError("no")


PLAIN = (
    None, True, False, 0, 1, -1, 2, 3, 7, 10**9, 10**16, 2**63, -2**63, 0.0, -0.0, 0.1, -1.5, 45.0,
    1e-9, 1e-300, 5e-324, 1e29, 1e30, 1e300, -1e300, float("nan"), float("inf"), float("-inf"),
    "", " ", "x", "1", "nan", "a\nb", "a$x{}%s", "\x00", "\udcff", "\u0663", "x" * 5000, "quasi",
    "newmark", "full", "skyline", "x y z", "run.h5", "/dev/zero", "N", "m", [], {}, [[]],
    [[1, 2], [3]], [1, "a", None], {"a": 1}, {"value": 1.0})
"""Values that TOML has too, but for None."""

ODD = (
    10**5000, b"", b"1", b"\xff\x00", bytearray(3), 1j, complex("nan"), object(), Unshowable(), int,
    type, NotImplemented, ..., range(3), range(0), slice(1), set(), {1, 2}, frozenset(),
    memoryview(b"abc"), np.ma.masked, np.nan, np.float32(0.5), np.float16(2), np.longdouble(1),
    np.int8(-3), np.uint64(2**64 - 1), np.bool_(True), np.str_("a"), np.bytes_(b"a"),
    np.complex64(1j), np.datetime64("2020-01-01"), np.datetime64("NaT"), np.timedelta64(1),
    np.void(b"abc"), datetime.date(2020, 1, 1), datetime.timedelta(1))
"""Values that only Python has."""

TYPES = ("f8", "f4", "f2", "g", "i8", "i1", "u8", "u1", "?", "c16", "O", "U3", "S3", "V4", "M8[s]",
         "m8[s]", ">f8", "f8,i4")


def value(chance, odd=True, depth=2):
    """Any value; ``odd`` ones too."""
    kind = chance.randrange(8)
    if depth and kind == 0:
        return [value(chance, odd, depth - 1) for _ in range(chance.choice((1, 2, 3, 3, 4)))]
    if odd and kind == 1:
        return _array(chance)
    if odd and kind < 4:
        return chance.choice(ODD)
    return copy.copy(chance.choice(PLAIN))


def spoiled(chance, good, odd=True):
    """A good value with something in it replaced, left out, put in or turned round."""
    if isinstance(good, np.ndarray) and odd and chance.random() < 0.8:
        return _spoiled_array(chance, good)
    if isinstance(good, dict) and good and chance.random() < 0.9:
        return _spoiled_items(chance, dict(good), chance.choice(list(good)), odd)
    if isinstance(good, list | tuple) and good and chance.random() < 0.7:
        changed = _spoiled_items(chance, list(good), chance.randrange(len(good)), odd)
        return tuple(changed) if isinstance(good, tuple) and chance.random() < 0.8 else changed
    if isinstance(good, float) and chance.random() < 0.5:
        return good * chance.choice((-1.0, 0.0, 1e-30, 1e-9, 0.5, 2.0, 1e9, 1e30))
    return value(chance, odd)


def _spoiled_items(chance, items, at, odd):
    how = chance.randrange(6)
    if how == 0:
        del items[at]
    elif how == 1 and isinstance(items, list):
        items.insert(at, items[at])
    elif how == 1:
        items[chance.choice(("x", "value", "", "a b"))] = value(chance, odd)
    elif how == 2 and isinstance(items, list):
        items.reverse()
    else:
        items[at] = spoiled(chance, items[at], odd)
    return items


def _array(chance):
    shape = tuple(chance.choice((0, 1, 2, 3, 4, 6)) for _ in range(chance.randrange(4)))
    return np.zeros(shape, chance.choice(TYPES))


def _spoiled_array(chance, good):
    if good.dtype.names:
        return chance.choice((good[:0], good[::-1], good[0], good[good.dtype.names[0]], good[None],
                              good[list(good.dtype.names[:1])], good.tolist()))
    how = chance.randrange(7)
    if how == 0:
        return good.astype(chance.choice(("f4", "f2", "i8", "u1", "?", "c16", "O", "U9", "S9")))
    if how == 1:
        return good[chance.choice((slice(1, None), slice(None, None, -1), slice(0), None))]
    if how == 2:
        return np.ma.masked_equal(good, good.flat[chance.randrange(good.size)])
    if how == 3:
        return np.moveaxis(good, 0, -1) if chance.random() < 0.5 else good.tolist()
    if how == 4:
        return good * chance.choice((-1, 0, 2, 10**9))
    changed = good.astype(object) if how == 5 else good.copy()
    entry = value(chance) if how == 5 else chance.choice(
        (0, 1, -1, 2**40) if good.dtype.kind == "i" else (0, np.nan, np.inf, 1e-12, 1e29, 1e300))
    changed[tuple(chance.randrange(n) for n in good.shape)] = entry
    return changed
