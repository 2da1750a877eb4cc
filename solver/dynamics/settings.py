"""How a model is run: time steps, scheme, Newton's iteration, linear solver, frames."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..checks import count, positive
from ..errors import InputError
from ..fields import check_fields, described, setting
from ..system.linear import SOLVERS
from .scheme import Scheme

NEWTON = ("modified", "full")

DEFAULT_FRAMES = 200
"""Frames written at most, beside the first, when their interval is not given."""

MOST_STEPS = 1e8
"""Longest history: 16 GB."""


@described
@dataclass(frozen=True)
class Newton:
    """When an iteration ends, ``cc <= tolerance`` and ``k >= min_iterations`` (Eq. 67), and what
    serves as its matrix; see ``dynamics.newton``.

    Raises:
        InputError: an unknown kind, or a number out of its range.
    """

    kind: str = setting("A factorization serves many iterations and steps, or a new one each time "
                        "(the paper's).", "modified", choices=NEWTON, option="newton")
    tolerance: float = setting("Work ratio cc at which an iteration ends (the paper's); exact goes "
                               "to rounding error. See the documentation on Newton.", 1e-6)
    min_iterations: int = setting("Fewest iterations of a step of full, but of exact.", 3)
    max_iterations: int = setting("Iterations after which a step is halved; twice as many of "
                                  "exact.", 20)

    def __post_init__(self):
        check_fields(self)
        if not 0.0 < self.tolerance < 1.0:
            raise InputError(f"tolerance must lie in (0, 1), is {self.tolerance:g}")
        count("max_iterations", self.max_iterations)
        if not 1 <= self.min_iterations <= self.max_iterations:
            raise InputError(f"min_iterations must lie in [1, {self.max_iterations}], is "
                             f"{self.min_iterations}")
        if self.max_iterations < self.least:
            raise InputError(f"a kept matrix takes {self.least} iterations at least, "
                             f"max_iterations is {self.max_iterations}")

    @property
    def keep(self):
        """Whether a factorization serves as long as it is good."""
        return self.kind == "modified"

    @cached_property
    def full(self):
        """The same rule with a new matrix in each iteration."""
        return replace(self, kind="full")

    @property
    def least(self):
        """Fewest iterations of a step; two tell how fast a kept matrix converges."""
        return 2 if self.keep else self.min_iterations


@described
@dataclass(frozen=True)
class Settings:
    """How a model is run.

    Raises:
        InputError: a value of another type or out of its range.
    """

    dt: float = setting("Time step.", unit="s")
    end_time: float = setting("Simulated time, a multiple of dt.", unit="s")
    scheme: Scheme = setting("How a step is integrated.", Scheme())
    newton: Newton = setting("How its equations are solved.", Newton())
    solver: str = setting("The linear solver; auto takes the fastest by the work expected, the "
                          "skyline, a banded Cholesky, RSLAB or SuperLU, and results name the one "
                          "that ran.", "auto", choices=SOLVERS)
    frame_every: int = setting(f"Steps between two frames; 0 for about {DEFAULT_FRAMES} frames a "
                               "run.", 0)
    stresses: bool = setting("Record stresses with every frame.", False)
    error: float = setting("Error of a step, in sizes of the shell, beyond which it is divided "
                           "into shorter ones; dt is then the longest. 0: steps of dt.", 0.0)

    def __post_init__(self):
        check_fields(self)
        positive("dt", self.dt, "s")
        positive("end_time", self.end_time, "s")
        steps = self.end_time / self.dt
        if steps > MOST_STEPS:
            raise InputError(f"end_time {self.end_time:g} s takes {steps:.3g} steps of dt "
                             f"{self.dt:g} s, at most {MOST_STEPS:.0e} can be recorded")
        if abs(steps - round(steps)) > 1e-6 or round(steps) < 1:
            nearest = [f"{n * self.dt:g}" for n in (int(steps), int(steps) + 1) if n]
            are = "nearest ones are" if len(nearest) > 1 else "smallest is"
            raise InputError(f"end_time {self.end_time:g} s is not a multiple of dt {self.dt:g} s; "
                             f"the {are} {' and '.join(nearest)} s")
        if not 0.0 <= self.error < 1.0:
            raise InputError(f"error must lie in [0, 1), is {self.error:g}")
        if self.error and self.scheme.order != 2:
            raise InputError("error chooses the lengths of steps of order 2, not of order 4")
        if self.frame_every < 0:
            raise InputError(f"frame_every must not be negative, is {self.frame_every}")

    @property
    def n_steps(self):
        """Number of steps."""
        return round(self.end_time / self.dt)

    @property
    def frame_steps(self):
        """Steps after which a frame is written: every n-th one, and the last."""
        every = self.frame_every or -(-self.n_steps // DEFAULT_FRAMES)
        steps = np.arange(0, self.n_steps + 1, every)
        return steps if steps[-1] == self.n_steps else np.append(steps, self.n_steps)


def taking_part(settings):
    """``settings``, as a dictionary, without what has no effect with its scheme and rule.

    ``exact`` has no parameter of ``quasi`` and no tolerance, ``newmark`` neither rho_inf nor T at a
    midpoint; where nothing is dissipated, nothing is said of it, and nothing of order 2.
    """
    scheme, newton = settings["scheme"], settings["newton"]
    idle = {"exact": {"rho_inf", "transformation", "axes", "tolerance", "min_iterations"},
            "newmark": {"rho_inf", "transformation"}}.get(scheme["name"], set())
    if not scheme["dissipation"]:
        idle = idle | {"dissipation", "dissipates"}
    if scheme["order"] == 2:
        idle = idle | {"order"}
    if newton["kind"] != "full":
        idle = idle | {"min_iterations"}
    return {**settings, "scheme": _without(scheme, idle), "newton": _without(newton, idle)}


def _without(values, names):
    return {name: value for name, value in values.items() if name not in names}
