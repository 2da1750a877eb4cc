"""Generalized-midpoint time integration: its parameters and coefficients (paper Eqs. 56, 57).

A scheme is data: four integration parameters, where the transformation T is taken, and the axes of
the rotational variables.  The step itself (``system.system``) is the same for all of them.
"""

from dataclasses import dataclass
from functools import cached_property

from ..errors import InputError
from ..fields import check_fields, described, setting
from ..kernels.arguments import EndFactors, Factors
from ..system.coordinates import AXES

SCHEMES = ("quasi", "exact", "newmark")
TRANSFORMATIONS = ("midpoint", "average")
DISSIPATES = ("selective", "constant")
ORDERS = (2, 4)


@described
@dataclass(frozen=True)
class Scheme:
    """How a step is integrated.

    ``quasi`` has the parameters of Chung and Hulbert (1993), to whom the paper points as its
    reference [67].  ``exact`` conserves energy and both momenta to rounding error at any step (see
    the theory page of it); its parameters are those of rho_inf = 1.  ``newmark`` is the trapezoidal
    rule with equilibrium at t_{n+1}, a baseline that does not conserve.

    Raises:
        InputError: unknown name, transformation, axes or kind of dissipation; rho_inf outside
            [0, 1]; what belongs to another scheme.
    """

    name: str = setting("The quasi energy-momentum conserving scheme (the paper's), one that "
                        "conserves exactly, or the trapezoidal rule, a baseline.",
                        "quasi", choices=SCHEMES, option="scheme")
    rho_inf: float = setting("Spectral radius at infinity, 0 to 1; 1 conserves, smaller values "
                             "dissipate high frequencies.", 1.0)
    transformation: str = setting("T at the generalized midpoint, or the weighted mean of both "
                                  "ends.", "midpoint", choices=TRANSFORMATIONS)
    axes: str = setting("Axes of the rotational variables: following each node, or global ones "
                        "that are switched (the paper's).", "nodal", choices=AXES)
    dissipation: float = setting("Of exact: by how much strains are taken later than their mean, 0 "
                                 "to 1; energy then never rises, momenta are kept.", 0.0)
    dissipates: str = setting("Of exact: that much in elements that vibrate fast beside the step, "
                              "less where motion is resolved, or the same everywhere.",
                              "selective", choices=DISSIPATES)
    order: int = setting("Order in time, 2, or 4 by five steps of order 2 for one, which is dearer "
                         "and far more accurate; of what conserves energy.", 2)

    def __post_init__(self):
        check_fields(self)
        if self.name != "quasi" and (self.rho_inf, self.transformation) != (1.0, "midpoint"):
            raise InputError(f"rho_inf and transformation belong to the scheme quasi; {self.name} "
                             "has none")
        if self.exact and self.axes != "nodal":
            raise InputError("axes belong to the schemes quasi and newmark; exact has none")
        if not 0.0 <= self.dissipation <= 1.0:
            raise InputError(f"dissipation must lie in [0, 1], is {self.dissipation:g}")
        if self.dissipation and not self.exact:
            raise InputError(f"dissipation belongs to the scheme exact; {self.name} has "
                             + ("rho_inf" if self.name == "quasi" else "none"))
        if self.dissipates != "selective" and not self.exact:
            raise InputError(f"dissipates belongs to the scheme exact; {self.name} has none")
        if not 0.0 <= self.rho_inf <= 1.0:
            raise InputError(f"rho_inf must lie in [0, 1], is {self.rho_inf:g}")
        if self.order not in ORDERS:
            raise InputError(f"order must be 2 or 4, is {self.order}")
        if self.order == 4:
            self._check_order_4()

    def _check_order_4(self):
        why = "order 4 goes back in time for a part of each step"
        if self.name == "newmark":
            raise InputError(f"{why}: it belongs to quasi and exact, which conserve energy")
        if self.rho_inf < 1.0:
            raise InputError(f"{why}: rho_inf must be 1, is {self.rho_inf:g}")
        if self.dissipation:
            raise InputError(f"{why}: dissipation must be 0, is {self.dissipation:g}")

    @property
    def exact(self):
        """Whether energy and momenta are conserved exactly."""
        return self.name == "exact"

    @property
    def conserves(self):
        """Whether energy is conserved, as far as the scheme can."""
        return self.name != "newmark" and self.rho_inf == 1.0

    @property
    def takes_joints(self):
        """Whether bodies, and joints with multipliers, may take part."""
        return self.exact or not self.uses_accelerations

    @cached_property
    def uses_accelerations(self):
        """Whether a step depends on U_ddot at its start."""
        step, end = self.midpoint(1.0), self.end(1.0)
        return bool(step.acceleration or step.rate_acceleration or end.rate_acceleration)

    @cached_property
    def alpha_m(self):
        """``(2 rho - 1)/(rho + 1)``: inertia is taken at t_{n + 1 - alpha_m}."""
        return 0.0 if self.name == "newmark" else (2.0 * self.rho_inf - 1.0) / (self.rho_inf + 1.0)

    @cached_property
    def alpha_f(self):
        """``rho/(rho + 1)``: forces are taken at t_{n + 1 - alpha_f}."""
        return 0.0 if self.name == "newmark" else self.rho_inf / (self.rho_inf + 1.0)

    @cached_property
    def gamma(self):
        """``1/2 - alpha_m + alpha_f``."""
        return 0.5 + (self.alpha_f - self.alpha_m)

    @cached_property
    def beta(self):
        """``(1 - alpha_m + alpha_f)^2 / 4``."""
        return 0.25 * (1.0 + (self.alpha_f - self.alpha_m)) ** 2

    def midpoint(self, dt):
        """``arguments.Factors`` of a step, Eqs. (57), (59)-(61)."""
        weight, inertia = 1.0 - self.alpha_f, 1.0 - self.alpha_m
        gamma, beta = self.gamma, self.beta
        return Factors(
            strain_end=weight, strain_start=self.alpha_f, mass=inertia / (beta * dt**2),
            alpha_f=self.alpha_f, stiffness=weight,
            delta=inertia / (beta * dt**2), velocity=inertia / (beta * dt),
            acceleration=(1.0 - 2.0 * beta - self.alpha_m) / (2.0 * beta),
            rate_delta=weight * gamma / (beta * dt),
            rate_velocity=(gamma - beta - self.alpha_f * gamma) / beta,
            rate_acceleration=(gamma - 2.0 * beta) * weight / (2.0 * beta) * dt,
            per_step=1.0 / dt)

    def end(self, dt):
        """``arguments.EndFactors``: U_dot and U_ddot at t_{n+1} by Newmark's formulas."""
        gamma, beta = self.gamma, self.beta
        return EndFactors(
            rate_delta=gamma / (beta * dt), rate_velocity=(beta - gamma) / beta,
            rate_acceleration=(2.0 * beta - gamma) / (2.0 * beta) * dt,
            second_delta=1.0 / (beta * dt**2), second_velocity=-1.0 / (beta * dt),
            second_acceleration=(2.0 * beta - 1.0) / (2.0 * beta))
