"""How kernels are compiled: cached, and with divisions by zero that give infinities, which checks
find, instead of exceptions."""

from numba import njit

OPTIONS = {"cache": True, "error_model": "numpy"}

kernel = njit(**OPTIONS)
inlined = njit(**OPTIONS, inline="always")
internal = njit(**OPTIONS, no_cpython_wrapper=True)
"""For kernels alone: what it takes or returns, Python does not know."""
