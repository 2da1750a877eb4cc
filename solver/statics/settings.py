"""How static equilibrium is iterated."""

from dataclasses import dataclass

from ..checks import count
from ..errors import InputError
from ..fields import check_fields, described, setting
from ..system.linear import SOLVERS


@described
@dataclass(frozen=True)
class StaticSettings:
    """How equilibrium is iterated.

    Raises:
        InputError: a value of another type or out of its range.
    """

    solver: str = setting("The linear solver; skyline takes indefinite matrices beyond limit "
                          "points as they are.  Loads that follow the shell (pressure, moments) "
                          "have an unsymmetric tangent and always take an unsymmetric LU.",
                          "skyline", choices=SOLVERS)
    tolerance: float = setting("Largest work of a correction relative to the largest of its step; "
                               "the work is quadratic, so 1e-16 stands for corrections "
                               "1e-8 times the first.", 1e-16)
    max_iterations: int = setting("Iterations after which a step is divided.", 16)
    fast_iterations: int = setting("A step converged within so many lets the next one grow by "
                                   "half.", 6)
    max_divisions: int = setting("A step is at most divided by two to this power.", 12)
    stresses: bool = setting("Record stresses with every frame.", False)

    def __post_init__(self):
        check_fields(self)
        if not 0 <= self.max_divisions <= 40:
            raise InputError(f"max_divisions must lie in [0, 40], is {self.max_divisions}")
        if not 0.0 < self.tolerance < 1.0:
            raise InputError(f"tolerance must lie in (0, 1), is {self.tolerance:g}")
        count("fast_iterations", self.fast_iterations)
        if self.max_iterations < 2:
            raise InputError(f"max_iterations must be at least 2, is {self.max_iterations}")


DEFAULT = StaticSettings()
