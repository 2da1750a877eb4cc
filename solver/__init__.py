"""Co-rotational four-node shell dynamics with vectorial rotational variables.

A :class:`Model` is made of arrays, :func:`simulate` runs it with :class:`Settings` and returns a
:class:`Result`; :func:`read` opens a result file.  ``solver.cases`` holds the benchmarks.
"""

from .compilation import warm_up
from .errors import InputError, ResultFileError, StepError
from .loads import (
    NodalLoad,
    NodalMoment,
    Pressure,
    Support,
    TimeFunction,
    line_load,
    line_moment,
    surface_load,
)
from .model import Model, rigid_velocity
from .recorder import read
from .scheme import Scheme, make_scheme
from .simulation import Drift, Result, Settings, drift, simulate, total_energy
from .static_result import StaticResult
from .statics import StaticSettings, arc_length, load_control, solve_linear

__all__ = [
    "Drift", "InputError", "Model", "NodalLoad", "NodalMoment", "Pressure", "Result",
    "ResultFileError", "Scheme", "Settings", "StaticResult", "StaticSettings", "StepError",
    "Support", "TimeFunction", "arc_length", "drift", "line_load", "line_moment", "load_control",
    "make_scheme", "read", "rigid_velocity", "simulate", "solve_linear", "surface_load",
    "total_energy", "warm_up",
]
