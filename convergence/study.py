"""Energy after unloading, mesh by mesh, beside the printed values (Table 1)."""

import tomllib
from pathlib import Path

import pandas as pd

from solver import InputError, Settings, simulate
from solver.cases import load_case
from solver.checks import number
from solver.simulation import unloaded_row

PRINTED = Path(__file__).with_name("printed.toml")

QUICK_MESHES = 3
"""The quick size runs this many of a case's meshes, the coarsest."""

FREE_FLIGHT = 1.2
"""A run ends at this multiple of the unloading time: long enough to show conservation."""

QUICK_STEPS = 500
"""Time steps until unloading.  For the L-plate dt = 2e-3 s, whose energy differs from that at half
the step by less than 2e-6 relative, far below the mesh error shown."""


def printed_energies(case):
    """``{elements: (energy [J], as printed)}`` and the table's name, of the paper."""
    with open(PRINTED, "rb") as file:
        table = tomllib.load(file)[case]
    texts = table["energy"]
    return dict(zip(table["elements"], zip(map(float, texts), texts))), table["table"]


def planned_runs(case, elements=(), *, dt=None, membrane="stress"):
    """``[(model, settings)]`` of a study of some meshes of ``case``.

    Args:
        case: name of the case; elements: meshes, by default the three coarsest.
        dt: time step [s], by default 1/500 of the loading time.
        membrane: assumed membrane field, see :class:`solver.Model`.

    Raises:
        InputError: no such case or mesh, or a wrong parameter.
    """
    definition = load_case(case)
    runs = []
    for size in elements or definition.sizes[:QUICK_MESHES]:
        model = definition.model(size, membrane=membrane)
        step = model.unloaded_at / QUICK_STEPS if dt is None else number("dt", dt, "s")
        if not 0.0 < step <= (FREE_FLIGHT - 1.0) * model.unloaded_at:
            raise InputError(f"dt must be positive and at most {FREE_FLIGHT - 1.0:.1f} of the "
                             f"loading time of {case}, {model.unloaded_at:g} s, is {step:g} s")
        end_time = round(FREE_FLIGHT * model.unloaded_at / step) * step
        runs.append((model, Settings(dt=step, end_time=end_time)))
    return runs


def mesh_study(case, runs, *, progress=None):
    """Energy after unloading of the ``runs`` (:func:`planned_runs`) of ``case``.

    ``progress(elements)`` makes the progress callback of each run.

    Returns:
        pandas.DataFrame, one row a mesh: elements, dt, energy and printed energy [J], difference
        [%], drift of energy and momenta in free flight, iterations a step, solver, seconds.
    """
    printed, _ = printed_energies(case)
    rows = []
    for model, settings in runs:
        size = len(model.quads)
        result = simulate(model, settings, progress=progress(size) if progress else None)
        energy = result.total_energy[unloaded_row(result.history, model.unloaded_at)]
        value, text = printed.get(size, (float("nan"), ""))
        rows.append({
            "elements": size, "dt": settings.dt, "energy": energy, "printed": text,
            "difference_percent": 100.0 * (energy / value - 1.0),
            "energy_drift": result.drift.energy,
            "linear_momentum_drift": result.drift.linear_momentum,
            "angular_momentum_drift": result.drift.angular_momentum,
            "iterations_per_step": result.history["iterations"][1:].mean(),
            "solver": result.solver, "seconds": result.seconds.total})
    return pd.DataFrame(rows)
