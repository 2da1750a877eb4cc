"""Growth of time and memory with the number of unknowns, by phase."""

import os

import numpy as np

from corovec.benchmarks import load_case
from corovec.solver.runtime.execution import isolated
from corovec.solver.runtime.memory import peak_memory

from . import shapes
from .measure import Stepper, sample, single_thread, time_calls
from .tables import available

SERIES = (("l-plate", (30, 120, 480, 1920, 7680)), ("hemisphere", (1024, 4096, 16384)),
          ("plate", (1024, 4096, 16384, 65536)), ("ring", (968, 3872, 16200, 64800)),
          ("box", (1014, 4056, 16224, 64896)))
METHODS = ("auto", "skyline")
PHASES = ("assembly", "factorization", "solve", "step")

UNKNOWNS = {"l-plate": 5.6, "hemisphere": 5.2, "plate": 5.1, "ring": 5.1, "box": 5.1}
"""Unknowns an element, about, to tell beforehand which models are too large."""

SKYLINE_UNKNOWNS = 25_000
"""Largest model of the skyline: beyond, its storage takes gigabytes."""


def growth(effort, progress=lambda text: None):
    """(rows of the growth study: median CPU seconds of one assembly, factorization, solution and
    of a step, and bytes, for each mesh and method; how its rounds lie: a row a phase).

    Every model has a process of its own, so that its memory is told apart; ``matrix_bytes`` is the
    storage that is assembled into, ``memory_bytes`` what the process grew by in its steps,
    ``peak_memory`` the most that it has had at a time [MB], ``first_step`` the CPU seconds of the
    first step, with the analysis and factorization of the matrix.
    """
    rows, phases = [], []
    for case, sizes in SERIES:
        for method in METHODS if case not in shapes.SHAPES else METHODS[:1]:
            for elements in sizes:
                limit = effort.growth_unknowns if method == "auto" else min(
                    effort.growth_unknowns, SKYLINE_UNKNOWNS)
                row = {"case": case, "elements": elements, "method": method}
                if case not in shapes.SHAPES and not available(case, elements):
                    rows.append({**row, "basis": "not available"})
                elif elements * UNKNOWNS[case] <= limit:
                    progress(f"growth: {case}, {elements} elements, {method}")
                    found, samples = isolated(_measure, case, elements, method, effort)
                    rows.append({**row, "basis": "steps", **found,
                                 **{phase: one.median for phase, one in samples.items()}})
                    phases += [{**row, "phase": phase, **one.row("call")}
                               for phase, one in samples.items()]
    return rows, phases


def exponents(rows, smallest=500):
    """Exponents b of seconds ~ unknowns^b by least squares, for models above ``smallest``; of the
    matrix's bytes only where all models have the same solver."""
    result = []
    for case, method in dict.fromkeys((row["case"], row["method"]) for row in rows):
        series = [row for row in rows if (row["case"], row["method"]) == (case, method)
                  and row["basis"] == "steps" and row["unknowns"] >= smallest]
        if len(series) > 1:
            n = [row["unknowns"] for row in series]
            solvers = list(dict.fromkeys(row["solver"] for row in series))
            fits = {name: fit_exponent(n, [row[name] for row in series])
                    for name in (*PHASES, "matrix_bytes", "memory_bytes")}
            result.append({"case": case, "method": method, "points": len(series),
                           "solvers": ", ".join(solvers), **fits,
                           "matrix_bytes": fits["matrix_bytes"] if len(solvers) == 1 else None})
    return result


def fit_exponent(n, values):
    """Slope of log(values) over log(n); None where a value is not positive."""
    if any(value is None or value <= 0.0 for value in values):
        return None
    return float(np.polyfit(np.log(n), np.log(values), 1)[0])


def _measure(case, elements, method, effort):
    """One model in this process: what it is, and a ``Sample`` of single calls of each phase and of
    a step as it is taken, with few factorizations or many."""
    if case in shapes.SHAPES:
        model, dt = shapes.model(case, elements), shapes.time_step(case)
    else:
        definition = load_case(case)
        model, dt = definition.model(elements), definition.paper.dt.value
    with single_thread():
        before = _resident_bytes()
        stepper = Stepper(model, dt, method)
        first, once = sample(stepper.steps, 2).cpu
        count = int(np.clip(effort.round_seconds / once, 1, 100))
        step = sample(lambda: stepper.steps(count), effort.rounds).scaled(1.0 / count)
        memory = None if before is None else _resident_bytes() - before
        iterations, peak = stepper.iterations, peak_memory()
        calls = time_calls(stepper, effort)
    return {"unknowns": stepper.system.numbering.n_dof, "solver": stepper.system.solver.name,
            "first_step": first, "peak_memory": peak, "steps_per_round": count,
            "iterations_per_step": iterations,
            "matrix_bytes": stepper.system.solver.values.nbytes, "memory_bytes": memory}, dict(
                zip(PHASES, (calls.assembly, calls.factor, calls.solve, step)))


def _resident_bytes():
    """Resident memory of this process; None where the system does not tell."""
    try:
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return None
