"""Digits that rounding takes: told, or refused, never lost in silence."""

import numpy as np
import pytest

from corovec import (
    AccuracyWarning,
    Model,
    NodalLoad,
    NodalMoment,
    Settings,
    StepError,
    Support,
    TimeFunction,
    line_load,
    load_control,
    simulate,
    solve_linear,
)
from corovec.solver.dynamics.balance import PESSIMISM
from corovec.solver.system.rounding import FEW, NONE, judge
from corovec.verification.models import rectangle
from corovec.verification.shells import CLAMPED


def film(slenderness, tilt=0.0):
    """A clamped strip of 20 x 2 m, its thickness a part of its length, turned about Y, under a
    force across its tip; the tip's mean deflection of it is 0.1 of the length by beam theory."""
    length, width, thickness = 20.0, 2.0, 20.0 * slenderness
    strip = rectangle(length, width, (40, 2))
    root = tuple(int(i) for i in np.flatnonzero(strip.nodes[:, 0] < 1e-9))
    tip = [int(i) for i in np.flatnonzero(strip.nodes[:, 0] > length - 1e-9)]
    c, s = np.cos(tilt), np.sin(tilt)
    turn = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    nodes = strip.nodes @ turn.T
    force = 0.3 / length * 1e9 * thickness**3 / 12.0 / length * (turn @ (0.0, 0.0, 1.0))
    model = Model(nodes, strip.quads, thickness, 1e9, 0.0, 1.0,
                  loads=line_load(nodes, tip, force), supports=[Support(root, CLAMPED)])
    return model, lambda displacement: (displacement @ turn)[tip, 2].mean() / (0.1 * length)


@pytest.mark.parametrize("tilt", [0.0, 0.7])
@pytest.mark.parametrize("slenderness", [1e-4, 1e-5, 1e-6])
def test_refined_linear_solution_of_a_film(slenderness, tilt):
    """The matrix alone gives 7 to 10 % of error at h/L = 1e-6; 40 elements have 1.6e-4."""
    model, deflection = film(slenderness, tilt)
    displacement, _ = solve_linear(model)
    assert deflection(displacement) == pytest.approx(1.0 - 0.25 / 40**2, rel=1e-6)


@pytest.mark.parametrize("slenderness", [1e-7, 1e-8])
def test_no_digits_are_no_answer(slenderness):
    model, _ = film(slenderness)
    with pytest.raises(StepError, match=r"relative error of about .* the condition of the matrix"):
        solve_linear(model)
    with pytest.raises(StepError):
        load_control(model, [1.0])


def test_newton_that_ends_at_rounding_is_told():
    """A load so small that its work is at rounding error: the iteration ends after one correction
    of a matrix that has lost bending, and says so."""
    factor = 1e-12
    model, deflection = film(1e-6)
    with (pytest.warns(AccuracyWarning, match="ends at rounding error"),
          pytest.warns(AccuracyWarning, match="forces balance to 0.* reactions have few digits")):
        displacement = load_control(model, [factor]).displacement[-1]
    assert 1e-3 < abs(deflection(displacement) / factor - 1.0) < 0.2
    model, deflection = film(1e-3)
    displacement = load_control(model, [factor]).displacement[-1]
    assert deflection(displacement) == pytest.approx(factor, rel=2e-4)


def test_energies_of_rounding():
    """A run whose energy is that of rounded strains is refused, one with some digits more told."""
    plate = rectangle(1.0, 1.0, (2, 2))

    def run(force):
        pulse = TimeFunction((0.0, 0.5, 1.0), (0.0, 1.0, 0.0))
        model = Model(plate.nodes, plate.quads, 0.1, 1e9, 0.3, 1.0,
                      loads=[NodalLoad(0, (0.0, 0.0, force), pulse)])
        return simulate(model, Settings(dt=0.1, end_time=1.0))

    energy = run(1e-3).total_energy[-1]
    roundoff = (4.0 * np.finfo(float).eps)**2 * 1e8
    lost = 1e-3 * np.sqrt(roundoff / energy) / PESSIMISM
    with pytest.raises(StepError, match="relative error of about"):
        run(lost)
    with pytest.warns(AccuracyWarning, match="relative error of about"):
        run(100.0 * lost)
    assert run(1e4 * lost).drift is None


@pytest.mark.parametrize("what", ["force", "moment", "displacement"])
def test_loads_that_are_held_are_no_rounding(what):
    """A step in which nothing is added has nothing but rounding to iterate on."""
    strip = rectangle(10.0, 1.0, (10, 1))
    root = tuple(int(i) for i in np.flatnonzero(strip.nodes[:, 0] < 1e-9))
    held = TimeFunction((0.0, 1.0, 2.0), (0.0, 1.0, 1.0))
    loads = {"force": [NodalLoad(21, (0.0, 0.0, 1.0), held)],
             "moment": [NodalMoment(21, (0.0, 1.0, 0.0), held)]}
    supports = [Support(root, CLAMPED)]
    if what == "displacement":
        supports.append(Support((21,), ("z",), 0.1, held))
    model = Model(strip.nodes, strip.quads, 0.1, 1.2e6, 0.0, 1.0, loads=loads.get(what, ()),
                  supports=supports)
    displacement = load_control(model, (0.5, 1.0, 1.0 + 1e-13, 1.5, 2.0)).displacement
    assert np.allclose(displacement[1:], displacement[1], atol=1e-9)


@pytest.mark.parametrize("thickness", [0.1, 0.01])
def test_rotations_count_where_nothing_else_moves(thickness):
    """A moment M in the middle of two elements that are clamped at both ends: no node is displaced,
    the middle turns by M/(2 (EI/L + kGA L/4)), with L = 1 of an element."""
    strip = rectangle(2.0, 1.0, (2, 1))
    ends = tuple(int(i) for i in np.flatnonzero(np.abs(strip.nodes[:, 0] - 1.0) > 0.5))
    model = Model(strip.nodes, strip.quads, thickness, 1e6, 0.0, 1.0,
                  loads=[NodalMoment(i, (0.0, 1.0, 0.0)) for i in (1, 4)],
                  supports=[Support(ends, CLAMPED)])
    displacement, change = solve_linear(model)
    assert np.abs(displacement).max() < 1e-12 * np.abs(change).max()
    stiffness = 1e6 * thickness**3 / 12.0 + 5.0 / 6.0 * 0.5e6 * thickness / 4.0
    assert change[1, 0] == pytest.approx(1.0 / stiffness, rel=1e-12)


@pytest.mark.parametrize(("error", "told", "refused"), [
    (0.5 * FEW, False, False), (2.0 * FEW, True, False), (2.0 * NONE, False, True),
    (np.nan, False, True)])
def test_judgement(error, told, refused):
    if refused:
        with pytest.raises(StepError, match="of about .*: thin"):
            judge(error, "thin")
    elif told:
        with pytest.warns(AccuracyWarning, match="of about 0.002: thin"):
            judge(error, "thin")
    else:
        judge(error, "thin")


def test_reactions_of_rounded_strains_are_told():
    """Membrane forces of 1 N beside a membrane stiffness of 1e15 N: the strain that they need is at
    the last digit of the coordinates."""
    plate = rectangle(1.0, 1.0, (2, 2), thickness=1e-3, youngs=1e18, supports=[
        Support((0, 3, 6), CLAMPED)], loads=[NodalLoad(8, (1.0, 0.3, 1.0))])
    with pytest.warns(AccuracyWarning, match="reactions have few digits"):
        load_control(plate, [1.0])
