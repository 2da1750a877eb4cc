"""Generalized-midpoint time integration: its parameters and coefficients (paper Eqs. 56, 57).

A scheme is data: four integration parameters and where the transformation T is taken.  The step
itself (``system.system``) is the same for all of them.
"""

from dataclasses import dataclass

from ..checks import choice
from ..errors import InputError

SCHEMES = ("quasi", "newmark")
TRANSFORMATIONS = ("midpoint", "average")


@dataclass(frozen=True)
class Scheme:
    """Integration parameters of one scheme.

    Attributes:
        name: one of ``SCHEMES``.
        alpha_m, alpha_f, gamma, beta: parameters of Eqs. (56), (57).
        transformation: T at the generalized midpoint, or the weighted mean of both ends.
    """

    name: str
    alpha_m: float
    alpha_f: float
    gamma: float
    beta: float
    transformation: str = "midpoint"

    def midpoint(self, dt):
        """(alpha_f, factor of K_G, factors of (delta, U_dot, U_ddot) in Eqs. 57b and 57a)."""
        weight, inertia = 1.0 - self.alpha_f, 1.0 - self.alpha_m
        gamma, beta = self.gamma, self.beta
        return (self.alpha_f, weight,
                inertia / (beta * dt**2), inertia / (beta * dt),
                (1.0 - 2.0 * beta - self.alpha_m) / (2.0 * beta),
                weight * gamma / (beta * dt), (gamma - beta - self.alpha_f * gamma) / beta,
                (gamma - 2.0 * beta) * weight / (2.0 * beta) * dt)

    def end(self, dt):
        """Factors of (delta, U_dot, U_ddot) in U_dot and in U_ddot at t_{n+1} (Newmark)."""
        gamma, beta = self.gamma, self.beta
        return (gamma / (beta * dt), (beta - gamma) / beta,
                (2.0 * beta - gamma) / (2.0 * beta) * dt,
                1.0 / (beta * dt**2), -1.0 / (beta * dt), (2.0 * beta - 1.0) / (2.0 * beta))


def make_scheme(name="quasi", rho_inf=1.0, transformation="midpoint"):
    """The scheme ``name``.

    ``quasi``: the paper's quasi energy-momentum scheme with
    ``alpha_m = (2 rho - 1)/(rho + 1)``, ``alpha_f = rho/(rho + 1)``, ``gamma = 1/2 - alpha_m +
    alpha_f``, ``beta = (1 - alpha_m + alpha_f)^2 / 4`` (Chung and Hulbert 1993; the paper points to
    its reference [67]).  rho_inf = 1 conserves, smaller values dissipate high frequencies.

    ``newmark``: the trapezoidal rule with equilibrium at t_{n+1}, a baseline that does not
    conserve.

    Raises:
        InputError: unknown name or transformation, rho_inf outside [0, 1].
    """
    choice("scheme", name, SCHEMES)
    choice("transformation", transformation, TRANSFORMATIONS)
    if name == "newmark":
        if rho_inf != 1.0 or transformation != "midpoint":
            raise InputError("rho_inf and transformation belong to the scheme quasi; newmark has "
                             "none")
        return Scheme(name, 0.0, 0.0, 0.5, 0.25)
    if not 0.0 <= rho_inf <= 1.0:
        raise InputError(f"rho_inf must lie in [0, 1], is {rho_inf:g}")
    alpha_m = (2.0 * rho_inf - 1.0) / (rho_inf + 1.0)
    alpha_f = rho_inf / (rho_inf + 1.0)
    shift = alpha_f - alpha_m
    return Scheme(name, alpha_m, alpha_f, 0.5 + shift, 0.25 * (1.0 + shift) ** 2, transformation)
