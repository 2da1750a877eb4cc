"""Co-rotational four-node shell dynamics with vectorial rotational variables.

A :class:`Model` is made of arrays, :func:`simulate` runs it with :class:`Settings` and returns a
:class:`Result`; :func:`read` opens a result file.  ``solver.cases`` holds the benchmarks.
"""

from .errors import InputError, ResultFileError, StepError
from .model import Model, NodalLoad, Support, TimeFunction, rigid_velocity
from .recorder import read
from .scheme import Scheme, make_scheme
from .simulation import Drift, Result, Settings, drift, simulate, total_energy, warm_up

__all__ = [
    "Drift", "InputError", "Model", "NodalLoad", "Result", "ResultFileError", "Scheme", "Settings",
    "StepError", "Support", "TimeFunction", "drift", "make_scheme", "read", "rigid_velocity",
    "simulate", "total_energy", "warm_up",
]
