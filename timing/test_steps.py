"""Time of a step of each cell of the tables, for pytest-benchmark: ``pytest timing/test_steps.py
--benchmark-autosave``, comparable between commits (``pytest-benchmark compare``).  Nothing is
asserted about times."""

import time

import pytest

from corovec.benchmarks import load_case
from corovec.timing.measure import Stepper, single_thread
from corovec.timing.printed import cells
from corovec.timing.solvers import METHODS
from corovec.timing.tables import available

ROUNDS = 10

LARGEST = {"dense": 1000, "lapack-lu": 1000}
"""Unknowns up to which a step takes well below a second; ``corovec time`` does the larger ones."""

CELLS = tuple(dict.fromkeys((cell.case, cell.elements) for cell in cells()))


@pytest.fixture(scope="module", autouse=True)
def one_thread():
    with single_thread():
        yield


@pytest.mark.benchmark(timer=time.process_time, group="step")
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("case,elements", CELLS)
def test_step(benchmark, case, elements, method):
    """One step with the paper's dt, a few steps after the start."""
    if not available(case, elements):
        pytest.skip(f"{case} with {elements} elements is not available")
    definition = load_case(case)
    stepper = Stepper(definition.model(elements), definition.paper.dt.value,
                      method if method not in LARGEST else "skyline")
    unknowns = stepper.system.numbering.n_dof
    if unknowns > LARGEST.get(method, unknowns):
        pytest.skip(f"{unknowns} unknowns take too long")
    if method in LARGEST:
        stepper = Stepper(stepper.system.model, stepper.dt, method)
    benchmark.pedantic(stepper.steps, rounds=ROUNDS, warmup_rounds=1)
    benchmark.extra_info.update(unknowns=unknowns, iterations_per_step=stepper.iterations,
                                solver=stepper.system.solver.name)
    assert stepper.done == (ROUNDS + 1 if benchmark.enabled else 1)
    assert stepper.record.halvings == 0
