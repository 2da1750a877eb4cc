"""What the server of ``processes.py`` loads by importing this module: libraries and kernels, with
one thread for each of the processes that it forks."""

import os
from contextlib import suppress
from importlib import import_module

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")

MODULES = ("convergence.cli", "convergence.report", "convergence.tables", "timing.cli",
           "verification.cli", "reports.page")
"""They import all that the commands and the page need."""

os.environ.update(dict.fromkeys(THREADS, "1"))
for name in MODULES:
    import_module(f"corovec.{name}")
with suppress(Exception):  # a command that needs the kernels says why there are none
    import_module("corovec.solver.compilation").warm_up()
