"""Histories as tables of pandas."""

from typing import Annotated

import numpy as np

from ..checks import shown
from ..errors import InputError
from ..signatures import checked


def rows_of(name, values):
    """A structured array of rows, of a run or a static path."""
    columns = getattr(getattr(values, "dtype", None), "names", None) or ()
    if (not {"time", "kinetic_energy", "strain_energy"} <= set(columns)
            and not {"factor", "strain_energy"} <= set(columns)) or np.ndim(values) != 1:
        raise InputError(f"{name} must be that of a result, as read(path)[\"history\"], is "
                         f"{shown(values)}")
    return values


COMPONENTS = {"_n": ("xx", "yy", "xy"), "_m": ("xx", "yy", "xy"), "_q": ("xz", "yz"),
              "_von_mises": ("top", "middle", "bottom")}
"""What the numbers of a column that ends so are called; of any other x, y, z."""

Rows = Annotated[np.ndarray, rows_of]


@checked
def data_frame(history: Rows):
    """A history as a ``pandas.DataFrame``, a row a step: vectors become columns with ``_x``, ``_y``
    and ``_z`` behind their names, what belongs to single items (``joints.work``, see
    ``energy_table``, ``joints.force`` of a static path) with the numbers of these.

    Args:
        history: ``read(path)["history"]``, or that of a ``Result``; results have ``frame()``.

    Raises:
        InputError: no history.
    """
    return table({name: history[name] for name in history.dtype.names})


def table(columns):
    """A ``pandas.DataFrame`` of arrays (n,), (n, 3) and, of items, (n, k) and (n, k, 3) by their
    names."""
    from pandas import DataFrame
    flat = {}
    for name, values in columns.items():
        ends = [""]
        for number, size in enumerate(values.shape[1:]):
            parts = next((parts for end, parts in COMPONENTS.items() if name.endswith(end)), "xyz")
            parts = range(size) if "." in name and number == 0 else parts
            ends = [f"{end}_{part}" for end in ends for part in parts]
        flat |= {f"{name}{end}": each for end, each in zip(
            ends, values.reshape(len(values), len(ends)).T)}
    return DataFrame(flat)
