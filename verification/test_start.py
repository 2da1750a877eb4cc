"""Runs that start from an equilibrium or from the end of another run."""

import numpy as np
import pytest

from corovec import (
    Configuration,
    InputError,
    Model,
    NodalLoad,
    ResultFileError,
    Settings,
    Support,
    load_control,
    read,
    rigid_velocity,
    simulate,
    solve_linear,
)
from corovec.benchmarks import load_case
from corovec.verification.models import MATERIAL, rectangle

CLAMP = Support((0, 1, 2), ("x", "y", "z", "px", "py", "pz"))
LOAD = [NodalLoad(node, (0.0, 0.0, 0.01)) for node in (24, 25, 26)]


def strip(loads=(), supports=(CLAMP,)):
    """8 x 2 elements, 2 x 0.5 m, clamped at x = 0, whose nodes count up along y."""
    nodes, quads = rectangle(2.0, 0.5, (8, 2)).nodes, rectangle(2.0, 0.5, (8, 2)).quads
    order = np.lexsort((nodes[:, 1], nodes[:, 0]))
    return Model(nodes[order], np.argsort(order)[quads], **MATERIAL, loads=loads,
                 supports=supports)


def test_an_equilibrium_stays_under_its_loads():
    """Nothing moves: what moves is what the static iteration left over."""
    bent = load_control(strip(LOAD), [0.5, 1.0])
    result = simulate(strip(LOAD), Settings(dt=0.05, end_time=1.0), start=bent.states[-1])
    size = np.abs(bent.displacement[-1]).max()
    assert size > 1e-3
    assert np.abs(result.displacement - bent.displacement[-1]).max() < 1e-6 * size
    assert result.history["kinetic_energy"].max() < 1e-10 * bent.strain_energy[-1]


def test_sudden_release_turns_strain_into_motion():
    """Without its loads the strip swings: the energy is the strain energy it starts with, and
    after half a period the tip is as far on the other side (a small amplitude, a mixture of modes:
    to a tenth)."""
    bent = load_control(strip(LOAD), [1.0])
    before = bent.states[-1]
    result = simulate(strip(), Settings(dt=0.02, end_time=20.0), start=before,
                      probes={"tip": 25})
    energy = result.total_energy
    assert energy[0] == pytest.approx(bent.strain_energy[-1], rel=1e-12)
    np.testing.assert_allclose(energy, energy[0], rtol=1e-4)
    tip = result.probes["tip"]["displacement"][:, 2]
    assert tip.min() == pytest.approx(-tip[0], rel=0.1)
    assert result.history["external_work"].max() == 0.0


def test_the_end_of_a_run_is_the_start_of_another(tmp_path):
    """Two halves are the whole, to what Newton's iteration leaves over; junctions as well."""
    case = load_case("plates").model(432)
    spinning = rigid_velocity(case, (1.0, 0.0, 0.0), (0.3, 0.2, 0.5), case.centre)
    plates = Model(case.nodes, case.quads, case.thickness, case.youngs, case.poisson, case.density,
                   velocity=spinning[0], normal_velocity=spinning[1])
    still = Model(case.nodes, case.quads, case.thickness, case.youngs, case.poisson, case.density)
    halves = Settings(dt=0.01, end_time=0.5)
    first = simulate(plates, halves)
    second = simulate(still, halves, start=first.state, output=tmp_path / "b.h5")
    whole = simulate(plates, Settings(dt=0.01, end_time=1.0))
    moved = np.abs(whole.displacement).max()
    assert np.abs(second.displacement - whole.displacement).max() < 1e-5 * moved
    assert np.abs(second.directors - whole.directors).max() < 1e-5
    np.testing.assert_allclose(second.history["angular_momentum"][-1],
                               whole.history["angular_momentum"][-1], rtol=1e-6)
    assert read(tmp_path / "b.h5")["description"]["start"]


def test_another_start_is_another_run(tmp_path):
    """A file is not resumed from another start."""
    bent, path = load_control(strip(LOAD), [0.5, 1.0]), tmp_path / "run.h5"
    settings = Settings(dt=0.02, end_time=0.1)
    simulate(strip(), settings, output=path, start=bent.states[-1])
    with pytest.raises(ResultFileError, match="starts from another configuration"):
        simulate(strip(), settings, output=path, resume=True, start=bent.states[0])


@pytest.mark.parametrize("start, message", [
    (lambda bent: solve_linear(strip(LOAD)).state, "linear solution, which is no equilibrium"),
    (lambda bent: Configuration(bent[0][:-1], bent[1]), "start.displacement: shape"),
    (lambda bent: Configuration(bent[0], 2.0 * bent[1]), r"start.directors\[0\] is no unit"),
    (lambda bent: Configuration(bent[0], bent[1], velocity=np.ones(3)), "start.velocity: shape"),
    (lambda bent: bent[0], "start must be")])
def test_what_is_no_start(start, message):
    bent = load_control(strip(LOAD), [1.0]).states[-1]
    with pytest.raises(InputError, match=message):
        simulate(strip(), Settings(dt=0.02, end_time=0.1), start=start(bent))
    moving = strip(supports=())
    moving = Model(moving.nodes, moving.quads, **MATERIAL, velocity=np.ones_like(moving.nodes))
    with pytest.raises(InputError, match="the model must have none"):
        simulate(moving, Settings(dt=0.02, end_time=0.1), start=bent)
