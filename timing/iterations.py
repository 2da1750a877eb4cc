"""What the symmetric matrix costs in iterations, and whether delaying M and F_m does harm.

Eqs. (58)-(66): within an iteration M and F_m are those of the previous iterate and their increments
are left out of the matrix; the paper says that this compromises neither energy nor momenta, that
the error is negligible once the iteration has converged, and that it does not accumulate.  The
30-element L-plate is taken in free flight and iterated with three matrices: the symmetric one of
Eq. (64), the Jacobian but for the derivative of M U_ddot + F_m, and the Jacobian.
"""

from dataclasses import replace

import numpy as np

from corovec import Newton, Scheme, Settings, simulate
from corovec.benchmarks import load_case
from corovec.solver.system.system import System
from corovec.verification.helpers import assemble, full_matrix, relative
from corovec.verification.jacobian import newton, step_jacobian

from .measure import Stepper
from .solvers import make_system

CASE, ELEMENTS = "l-plate", 30
START_DT = 0.01
STEPS = (1e-4, 1e-3, 5e-3, 1e-2, 2e-2)
PAPER = Newton("full", min_iterations=1)
CONVERGED = Newton("full", tolerance=1e-14, min_iterations=1, max_iterations=40)

WEIGHTLESS = 1e-30
"""Young's modulus [Pa] at which only the inertial part of a residual is left."""


def symmetric(system, state, step, delta):
    """The paper's iteration matrix, Eq. (64a)."""
    assemble(system, state, step, delta)
    return full_matrix(system)


def delayed(system, state, step, delta):
    """The Jacobian with constant mass: d F_int / d U unsymmetric, M of the iterate, no more."""
    inertia = System(replace(system.model, youngs=WEIGHTLESS), "skyline")
    return (step_jacobian(system, state, step, delta) + symmetric(inertia, state, step, delta)
            - step_jacobian(inertia, state, step, delta))


MATRICES = {"symmetric": symmetric, "M and F_m delayed": delayed, "Jacobian": step_jacobian}


def flight():
    """(system, state) of the L-plate in free flight, once unloaded."""
    model = load_case(CASE).model(ELEMENTS)
    stepper = Stepper(model, START_DT, "skyline")
    stepper.steps(round(model.unloaded_at / START_DT))
    return make_system(replace(model, loads=()), "skyline"), stepper.state


def step_iterations(dts=STEPS):
    """Iterations of one step by matrix, and how far the end of the paper's iteration is from that
    of the Jacobian's, converged: a row a time step and matrix.

    ``gap`` is the largest entry of matrix - Jacobian over that of the Jacobian, at the first
    iterate; ``error`` is relative to the largest displacement of the step; ``paper_error`` is that
    of the paper's full rule, cc <= 1e-6 and k >= 3.
    """
    system, state = flight()
    rows = []
    for dt in dts:
        exact, _ = newton(system, state, dt, CONVERGED, step_jacobian)
        size = np.abs(exact).max()
        step, start = Scheme().midpoint(dt), dt * state.velocity
        J = step_jacobian(system, state, step, start)
        for name, matrix in MATRICES.items():
            early, works = newton(system, state, dt, PAPER, matrix)
            full, more = newton(system, state, dt, CONVERGED, matrix)
            ruled, _ = newton(system, state, dt, Newton("full"), matrix)
            gap = relative(matrix(system, state, step, start), J)
            rows.append({"dt": dt, "matrix": name, "gap": float(gap), "iterations": len(works),
                         "iterations_converged": len(more),
                         "rate": float((more[-1] / more[0]) ** (0.5 / max(len(more) - 1, 1))),
                         "error": float(np.abs(early - exact).max() / size),
                         "paper_error": float(np.abs(ruled - exact).max() / size),
                         "converged_error": float(np.abs(full - exact).max() / size)})
    return rows


def long_run(dt=START_DT, times=(2.0, 5.0, 10.0), tolerance=1e-13):
    """The paper's rule against a tight one from rest on: whether the error of stopping early
    accumulates.  A row a time: energy drifts, and the largest difference of displacements [m]."""
    model = load_case(CASE).model(ELEMENTS)
    rules = {"paper": Newton("full"), "tight": Newton("full", tolerance=tolerance)}
    rows = []
    for end in times:
        row, ends = {"dt": dt, "time": end}, []
        for name, rule in rules.items():
            result = simulate(model, Settings(dt=dt, end_time=end, newton=rule))
            row[f"{name}_energy_drift"] = result.drift.energy
            row[f"{name}_angular_momentum_drift"] = result.drift.angular_momentum
            row[f"{name}_iterations"] = float(result.history["iterations"][1:].mean())
            ends.append(result.displacement)
        rows.append({**row, "difference": float(np.abs(ends[0] - ends[1]).max()),
                     "travelled": float(np.abs(ends[1]).max())})
    return rows
