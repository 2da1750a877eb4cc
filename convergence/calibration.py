"""A load's peak from a printed energy, where the figure that shows the load is lost.

The energy of the mesh it is fitted to is no check any more; what is left are the other meshes,
conservation and symmetry.
"""

import numpy as np

from corovec import InputError, Settings, simulate, warm_up
from corovec.benchmarks import load_case
from corovec.solver.checks import number
from corovec.solver.dynamics.result import unloaded_row
from corovec.solver.input.model_file import Calibration

from .study import printed_results

STEPS = 200
"""Time steps until unloading, by default."""

TOLERANCE = 1e-6
"""Relative residual of the energy: below half the last printed digit of any table."""

MAX_ITERATIONS = 10
"""Runs after which a search is given up."""

LARGEST_STEP = 1.0
"""Largest change of ln factor from one run to the next."""

LARGEST_DT_CHANGE = 1e-4
"""Largest relative change of the energy at half the step with which a peak is accepted."""


def calibrate(case, elements, *, dt=None, progress=None):
    """Find the factor of the loads of ``case`` that gives the printed energy after unloading.

    Args:
        case: name of the benchmark.
        elements: the mesh, one whose energy is printed.
        dt: time step [s], by default 1/200 of the loading time.
        progress: called as ``progress(factor, energy)`` after each run.

    Returns:
        (factor, ``Calibration``).

    Raises:
        InputError: no printed energy of this mesh, or a time step that is too long.
    """
    definition = load_case(case)
    table = printed_results(case)
    printed = dict(zip(table["elements"], table["energy"]))
    if elements not in printed:
        raise InputError(f"{table['table']} has no energy of {elements} elements, must be one of: "
                         f"{', '.join(map(str, printed))}")
    target = float(printed[elements])
    unloaded_at = definition.model(elements).unloaded_at
    dt = unloaded_at / STEPS if dt is None else number("dt", dt, "s")
    if not 0.0 < dt <= unloaded_at:
        raise InputError(f"dt must be positive and at most the loading time of {case}, "
                         f"{unloaded_at:g} s, is {dt:g} s")

    def energy(factor, step=dt):
        found = energy_after_unloading(definition.model(elements, factor), step)
        if progress:
            progress(factor, found)
        return found

    warm_up()
    factor, found = find_factor(energy, target)
    change = energy(factor, 0.5 * dt) / found - 1.0
    if abs(change) > LARGEST_DT_CHANGE:
        raise InputError(f"dt {dt:g} s is too long: at half the step the energy changes by "
                         f"{change:.1e}, at most {LARGEST_DT_CHANGE:g} is allowed")
    return factor, Calibration(elements=elements, printed=printed[elements], table=table["table"],
                               dt=dt, residual=found / target - 1.0, dt_change=change)


def find_factor(energy, target):
    """``(factor, energy(factor))`` with energy = target, by secants of ln E over ln factor.

    The first secant has the slope 2 of a linear shell.

    Raises:
        InputError: not found in ``MAX_ITERATIONS``.
    """
    x, slope, last = 0.0, 2.0, None
    for _ in range(MAX_ITERATIONS):
        found = energy(float(np.exp(x)))
        miss = np.log(found / target)
        if abs(miss) <= TOLERANCE:
            return float(np.exp(x)), found
        if last is not None:
            slope = (miss - last[1]) / (x - last[0])
        last = x, miss
        x -= np.clip(miss / slope, -LARGEST_STEP, LARGEST_STEP)
    raise InputError(f"no load factor gives {target:g} J within {MAX_ITERATIONS} runs; the last, "
                     f"{np.exp(last[0]):g}, gave {found:g} J")


def energy_after_unloading(model, dt):
    """Kinetic plus strain energy [J] at the first step without load."""
    steps = int(np.ceil(model.unloaded_at / dt * (1.0 - 1e-9)))
    result = simulate(model, Settings(dt=dt, end_time=steps * dt))
    return float(result.total_energy[unloaded_row(result.history, model.unloaded_at)])
