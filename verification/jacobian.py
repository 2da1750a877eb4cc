"""The Jacobian of a time step by finite differences, and Newton's iteration with any matrix."""

import numpy as np

from corovec import Scheme

from .helpers import assemble, central_differences


def step_jacobian(system, state, step, delta):
    """Derivative of the residual of a time step without loads, in the sign of the iteration
    matrix."""
    place, none = system.observe(state), system.loads_by(lambda history: 0.0)

    def residual(at):
        system.assemble(state, place, step, at, none, tangent=False)
        return system.residual.balance.copy()

    return -central_differences(residual, delta, 1e-6)


def newton(system, state, dt, rule, matrix):
    """Newton's iteration of a time step without loads, whatever its matrix.

    ``matrix(system, state, step, delta)`` gives it as a full array; see ``step_jacobian``.

    Returns:
        (increment (n_dof,), works |residual . correction| of the iterations).
    """
    step = Scheme().midpoint(dt)
    delta, works = dt * state.velocity, []
    while len(works) < rule.max_iterations:
        K = matrix(system, state, step, delta)
        residual = assemble(system, state, step, delta, tangent=False)
        correction = np.linalg.solve(K, residual)
        works.append(abs(residual @ correction))
        delta = delta + correction
        if len(works) >= rule.min_iterations and works[-1] <= rule.tolerance * works[0]:
            break
    return delta, works
