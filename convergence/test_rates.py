"""Rates of convergence against closed-form sequences and against the paper's own tables."""

import tomllib

import numpy as np
import pytest

from corovec.convergence.rates import (
    crossing,
    finest_as_reference,
    log_log_fit,
    mesh_errors,
    richardson,
    step_limit,
)
from corovec.convergence.study import PRINTED

ELEMENTS = 30 * 4 ** np.arange(5)
TABLES = tomllib.loads(PRINTED.read_text(encoding="utf-8"))
TABLE_1 = [float(text) for text in TABLES["l-plate"]["energy"]]


def sequence(order, limit=73.5, factor=-2.0):
    """Energies whose error is exactly ``factor * h^order``, h halved from mesh to mesh."""
    return limit + factor * 0.5 ** (order * np.arange(5))


def test_fit_of_a_power_law():
    x = np.array([1.0, 2.0, 5.0, 9.0])
    fit = log_log_fit(x, 3.0 * x**-1.27)
    assert fit.slope == pytest.approx(-1.27, abs=1e-12)
    assert fit.r_squared == pytest.approx(1.0, abs=1e-12)
    assert log_log_fit(x, [1.0, 2.0, 1.0, 2.0]).r_squared < 0.5


def test_a_slope_needs_three_points():
    assert np.isnan(log_log_fit([1.0, 2.0, 3.0], [4.0, 1.0, 0.0])).all()
    assert log_log_fit([1.0, 2.0, 4.0], [4.0, 1.0, 0.25]).slope == pytest.approx(-2.0)


@pytest.mark.parametrize("values, limit, uncertainty, order", [
    ([5.0 + 3.2, 5.0 + 0.8, 5.0 + 0.2], 5.0, 0.2, 2.0), ([5.0 + 0.8, 5.0 + 0.2], 5.2, 0.6, None),
    ([5.0 + 0.8, 5.0 + 0.4, 5.0 + 0.2], 5.2, 0.2, None), ([5.0, 5.4, 5.1], 5.1, 0.3, None),
    ([5.0], 5.0, None, None), ([], None, None, None)])
def test_limit_in_the_time_step(values, limit, uncertainty, order):
    """Of second order it is extrapolated; else the last halving says how uncertain it is."""
    found = step_limit(values)
    for ours, expected in zip(found, (limit, uncertainty, order)):
        assert ours == pytest.approx(np.nan if expected is None else expected, nan_ok=True)


def test_slope_printed_with_table_1():
    """The paper's rule on the paper's energies gives the paper's -1.27 and 0.998, to its digits."""
    _, fit = finest_as_reference(ELEMENTS, TABLE_1)
    assert f"{fit.slope:.2f}" == TABLES["l-plate"]["slope"] == "-1.27"
    assert f"{fit.r_squared:.3f}" == TABLES["l-plate"]["r_squared"] == "0.998"


@pytest.mark.parametrize("case", TABLES)
def test_printed_errors_follow_from_printed_energies(case):
    table = TABLES[case]
    errors, _ = finest_as_reference(table["elements"], list(map(float, table["energy"])))
    assert [f"{error:.3%}" for error in errors] == table["error"]
    assert len(table["mesh"]) == len(table["elements"]) == len(table["energy"])


def test_printed_meshes_are_their_numbers_of_elements():
    for table in TABLES.values():
        for name, elements in zip(table["mesh"], table["elements"]):
            assert np.prod([int(part) for part in name.replace(",", "").split("×")]) == elements


@pytest.mark.parametrize("order", [0.8, 1.0, 2.0])
def test_richardson_finds_order_and_limit(order):
    """Exact for errors C h^p, whatever their sign; the finest mesh as reference is not."""
    for factor in (-2.0, 0.3):
        energies = sequence(order, factor=factor)
        found = richardson(ELEMENTS, energies)
        assert found.orders[2:] == pytest.approx(np.full(3, order), abs=1e-9)
        assert np.isnan(found.orders[:2]).all()
        assert found.limit == pytest.approx(73.5, abs=1e-9)
        assert -finest_as_reference(ELEMENTS, energies)[1].slope > order + 0.1


def test_richardson_of_table_1():
    """Successive differences of the printed energies: order 1.26, 1.00, 0.77, not 1.27."""
    assert np.diff(TABLE_1) == pytest.approx([1.082, 0.453, 0.227, 0.133], abs=1e-9)
    found = richardson(ELEMENTS, TABLE_1)
    assert [f"{order:.2f}" for order in found.orders[2:]] == ["1.26", "1.00", "0.77"]
    assert found.limit == pytest.approx(73.456, abs=1e-3)


def test_richardson_where_it_has_no_answer():
    alternating = 1.0 + (-0.5) ** np.arange(5)
    assert np.isnan(richardson(ELEMENTS, alternating).orders).all()
    growing = 1.0 + 2.0 ** np.arange(5)
    assert np.isnan(richardson(ELEMENTS, growing).limit)
    uneven = [30, 120, 270, 1080, 2430]
    assert np.isnan(richardson(uneven, sequence(1.0)).orders).all()
    assert np.isnan(richardson([30], [1.0]).limit)
    failed = [71.0, np.nan, 72.0, 72.5, 72.75]
    assert np.isnan(richardson(ELEMENTS, failed).orders).tolist() == [True] * 4 + [False]


def test_mesh_errors_are_changes_to_the_next_mesh():
    assert mesh_errors(TABLE_1) == pytest.approx([1.082, 0.453, 0.227, 0.133, 0.133], abs=1e-9)
    assert np.isnan(mesh_errors([71.0])).all()


def test_crossing():
    dt = np.array([0.01, 0.005, 0.0025])
    drift = 0.02 * dt**2
    inside, beyond = crossing(dt, drift, 1e-6)
    assert inside == pytest.approx(np.sqrt(5e-5)) and not beyond
    outside, beyond = crossing(dt, drift, 1e-9)
    assert outside == pytest.approx(np.sqrt(5e-8)) and beyond
    outside, beyond = crossing(dt, drift, 1e-4)
    assert outside == pytest.approx(np.sqrt(5e-3)) and beyond
    assert np.isnan(crossing(dt, [1e-6] * 3, 1e-9)[0])
    assert np.isnan(crossing(dt[:1], drift[:1], 1e-6)[0])
