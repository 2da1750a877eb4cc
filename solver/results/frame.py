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
    and ``_z`` behind their names, energies of single items (``joints.work``, see ``energy_table``)
    with the numbers of these.

    Args:
        history: ``read(path)["history"]``, or that of a ``Result``; results have ``frame()``.

    Raises:
        InputError: no history.
    """
    return table({name: history[name] for name in history.dtype.names})


def table(columns):
    """A ``pandas.DataFrame`` of arrays (n,) and (n, 3) by their names."""
    from pandas import DataFrame
    flat = {}
    for name, values in columns.items():
        parts = next((parts for end, parts in COMPONENTS.items() if name.endswith(end)), "xyz")
        parts = range(values.shape[-1]) if "." in name else parts
        flat |= ({name: values} if values.ndim == 1 else
                 {f"{name}_{part}": values[:, k] for k, part in enumerate(parts)})
    return DataFrame(flat)
