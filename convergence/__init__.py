"""Campaigns of runs, and the convergence studies of the paper's benchmarks made of them."""

from corovec.solver.runtime.execution import dask_workers, processes

from .campaign import Campaign, Outcome, run_many
from .run import Run

__all__ = ["Campaign", "Outcome", "Run", "dask_workers", "processes", "run_many"]
