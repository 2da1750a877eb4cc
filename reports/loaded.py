"""What the server of ``processes.py`` loads by importing this module: libraries and kernels, with
one thread for each of the processes that it forks."""

import os
from contextlib import suppress
from importlib import import_module

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")

COMMANDS = ("solver.cli", "convergence.cli", "convergence.tables", "timing.cli",
            "verification.cli")
"""Modules that import all that the commands need."""

os.environ.update(dict.fromkeys(THREADS, "1"))
for name in COMMANDS:
    import_module(f"corovec.{name}")
with suppress(Exception):  # a command that needs the kernels says why there are none
    import_module("corovec.solver.compilation").warm_up()
