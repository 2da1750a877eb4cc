"""Campaigns of runs, and the convergence studies of the paper's benchmarks made of them.

Names are loaded when they are first asked for: the command line helps without them.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from corovec.solver.runtime.execution import dask_workers, processes

    from .campaign import Campaign, Outcome, run_many
    from .run import Run

__all__ = ["Campaign", "Outcome", "Run", "dask_workers", "processes", "run_many"]

_HOMES = {"Run": "corovec.convergence.run",
          **dict.fromkeys(("dask_workers", "processes"), "corovec.solver.runtime.execution")}


def __getattr__(name):
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES.get(name, "corovec.convergence.campaign")), name)
