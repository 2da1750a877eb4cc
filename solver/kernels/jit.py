"""How kernels are compiled: cached, with divisions by zero that give infinities, which checks find,
instead of exceptions, and such that several threads run them side by side."""

from numba import njit

OPTIONS = {"cache": True, "error_model": "numpy", "nogil": True}

kernel = njit(**OPTIONS)
inlined = njit(**OPTIONS, inline="always")
internal = njit(**OPTIONS, no_cpython_wrapper=True)
"""For kernels alone: what it takes or returns, Python does not know."""
