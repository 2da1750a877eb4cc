"""The Jacobian of a time step by finite differences, and Newton's iteration with any matrix."""

import numpy as np

from corovec.solver.dynamics.scheme import make_scheme

from .helpers import central_differences, no_loads


def step_jacobian(system, state, step, delta):
    """Derivative of the residual of a time step, in the sign of the iteration matrix."""
    def residual(at):
        system.assemble(state, step, False, at, no_loads(system), False)
        return system.residual[0].copy()

    return -central_differences(residual, delta, 1e-6)


def newton(system, state, dt, rule, matrix):
    """Newton's iteration of a time step without loads, whatever its matrix.

    ``matrix(system, state, step, delta)`` gives it as a full array; see ``step_jacobian``.

    Returns:
        (increment (n_dof,), works |residual . correction| of the iterations).
    """
    step = make_scheme().midpoint(dt)
    delta, works = dt * state.velocity, []
    while len(works) < rule.max_iterations:
        K = matrix(system, state, step, delta)
        system.assemble(state, step, False, delta, no_loads(system), False)
        correction = np.linalg.solve(K, system.residual[0])
        works.append(abs(system.residual[0] @ correction))
        delta = delta + correction
        if len(works) >= rule.min_iterations and works[-1] <= rule.tolerance * works[0]:
            break
    return delta, works
