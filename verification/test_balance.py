"""Energy and the work of the loads: a run that breaks their balance does not return in silence."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from corovec import (
    AccuracyWarning,
    Damping,
    Model,
    Newton,
    NodalLoad,
    Pressure,
    Scheme,
    Settings,
    StepError,
    TimeFunction,
    simulate,
    total_energy,
)
from corovec.benchmarks import load_case
from corovec.solver.dynamics import balance
from corovec.solver.dynamics.newton import StepRecord
from corovec.solver.dynamics.stepping import Stepper
from corovec.solver.system.failure import NotConverged
from corovec.solver.system.system import System
from corovec.verification.models import rectangle


def turned(size, thickness, youngs, density, force, seconds, divisions=4, poisson=0.3):
    """A free square plate that forces at three of its corners turn, from rest."""
    plate = rectangle(size, size, (divisions, divisions))
    corner = [int(np.argmin(np.abs(plate.nodes[:, :2] - size * np.array(at)).sum(axis=1)))
              for at in ((0, 0), (1, 1), (1, 0))]
    pulse = TimeFunction((0.0, seconds / 2, seconds), (0.0, 1.0, 0.0))
    loads = [NodalLoad(corner[0], (0.0, 0.0, force), pulse),
             NodalLoad(corner[1], (0.0, 0.0, -force), pulse),
             NodalLoad(corner[2], (0.3 * force, 0.0, 0.0), pulse)]
    return Model(plate.nodes, plate.quads, thickness, youngs, poisson, density, loads=loads)


def gap(result):
    """Largest difference of energy and work, relative to the larger of both."""
    energy, work = total_energy(result.history), result.history["external_work"]
    return np.abs(energy - work).max() / max(energy.max(), np.abs(work).max())


@pytest.mark.parametrize("kind", ["modified", "full"])
@pytest.mark.parametrize(("model", "dt"), [
    (("steel", 5e-3, 1e-4, 2.1e11, 7850.0, 1e-8), 1e-2),
    (("steel", 5e-3, 1e-4, 2.1e11, 7850.0, 1e-8), 2e-3),
    (("stiff", 1.0, 1e-2, 1e18, 1000.0, 1.0), 2e-3)],
    ids=["steel 0.01", "steel 0.002", "stiff"])
def test_no_energy_from_nothing(model, dt, kind):
    """Plates turned slowly with steps of millions of membrane periods: all energy is work."""
    result = simulate(turned(*model[1:], 0.2), Settings(dt=dt, end_time=0.5, newton=Newton(kind)))
    assert gap(result) < 1e-5


ENDED = {11}
"""Seeds whose loads fold a plate that no step resolves."""


@pytest.mark.parametrize("seed", [1, 2, 3, 4, 5, 7, 8, 10, 11])
def test_any_stiffness_load_and_step(seed):
    """E dt^2/(rho L^2) from 1 to 1e12, dt to 1e3 s, loads that turn by 1e-8 to 5 rad a step: energy
    and work agree, or the run ends."""
    rng = np.random.default_rng(seed)
    size, density, dt = 10.0**rng.uniform((-3, 0, -5), (2, 4, 3))
    thickness = size * 10.0**rng.uniform(-3, -0.8)
    youngs = 10.0**rng.uniform(0, 12) * density * (size / dt)**2
    turn = 10.0**rng.uniform(-8, 0.7)
    force = turn * density * size**3 * thickness / dt**2 / 25.0 / size
    model = turned(size, thickness, youngs, density, force, dt * 2 * rng.integers(1, 5),
                   int(rng.integers(1, 4)), rng.uniform(0.0, 0.45))
    kind = ("modified", "full")[seed % 2]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AccuracyWarning)
        settings = Settings(dt=dt, end_time=20 * dt, newton=Newton(kind))
        if seed in ENDED:
            with pytest.raises(StepError, match="no convergence"):
                simulate(model, settings)
        else:
            assert gap(simulate(model, settings)) < 1e-3


def pulse_at(force, function, youngs=1e6, velocity=None):
    plate = rectangle(1.0, 1.0, (3, 3))
    return Model(plate.nodes, plate.quads, 0.1, youngs, 0.3, 1.0, velocity=velocity,
                 loads=[NodalLoad(0, (0.0, 0.0, force), function)])


def test_small_loads_before_large_ones():
    """A pulse that begins with 1e-44 of its peak, and a tiny constant load: energies at rounding
    error are compared with nothing, and no step is halved for them."""
    t = np.linspace(0.0, 1.0, 101)
    bell = TimeFunction(tuple(t), tuple(np.exp(-((t - 0.4) / 0.04)**2)))
    late = TimeFunction((0.0, 0.5, 0.6, 0.7), (1e-12, 1e-12, 1.0, 0.0))
    for function in (bell, late):
        result = simulate(pulse_at(1.0, function), Settings(dt=0.01, end_time=1.0))
        assert result.history["halvings"].sum() == 0 and gap(result) < 1e-3


@pytest.mark.parametrize("speed", [1e-2, 1.0, 100.0])
def test_no_energy_from_nothing_in_moving_shells(speed):
    """The steel plate flies as well: its energy about the mass centre is the work as it is at
    rest, and the energy of its vibrations no larger part of it."""
    model = turned(5e-3, 1e-4, 2.1e11, 7850.0, 1e-8, 0.2)
    moving = replace(model, velocity=np.tile([0.0, 0.0, speed], (len(model.nodes), 1)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AccuracyWarning)
        last = simulate(moving, Settings(dt=1e-2, end_time=0.5)).history[-1]
    assert last["strain_energy"] < 1e-3 * 6e-13


@pytest.mark.parametrize("rho", [0.0, 0.5])
def test_sudden_loads_with_dissipation_are_not_halved(rho):
    """Generalized-alpha overshoots in the first step after a sudden load, as it should."""
    model = pulse_at(1.0, TimeFunction((0.0,), (1.0,)))
    result = simulate(model, Settings(dt=0.01, end_time=0.5, scheme=Scheme(rho_inf=rho)))
    assert result.history["halvings"].sum() == 0


@pytest.mark.slow
def test_work_of_pressure_with_dissipation():
    """It is that of the dead force equal to it on a flat plate that only moves: m v^2/2."""
    plate = rectangle(1.0, 1.0, (2, 2))
    pulse = TimeFunction((0.0, 0.05, 0.1), (0.0, 1.0, 0.0))
    model = Model(plate.nodes, plate.quads, 0.1, 1e6, 0.3, 1.0, loads=[Pressure(10.0, None, pulse)])
    result = simulate(model, Settings(dt=0.01, end_time=0.2, scheme=Scheme(rho_inf=0.0)))
    work = result.history["external_work"][-1]
    assert work == pytest.approx(0.5 * 0.1 * (10.0 * 0.05 / 0.1)**2, rel=0.02)


def test_steps_longer_than_the_vibrations():
    """The rates of vibrations that the step does not resolve mislead Newton's iteration; without
    them the L-plate needs a few halvings at 0.05 s (with them 1.7 a step until 30 s)."""
    settings = Settings(dt=5e-2, end_time=20.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AccuracyWarning)
        history = simulate(load_case("l-plate").model(30), settings).history
    assert history["halvings"].sum() < 0.25 * settings.n_steps


def stepper(scheme):
    system = System(turned(1.0, 0.05, 1e6, 1.0, 1.0, 0.2, 1))
    state = system.initial_state()
    return Stepper(system, scheme, Newton()), state, system.observe(state)


def wrong_work(monkeypatch, factor):
    """Count ``factor`` times the work of the loads."""
    settle = balance.settle

    def wrong(scheme, state, time, before, after, work, roundoff):
        state.external_work += (factor - 1.0) * work
        settle(scheme, state, time, before, after, factor * work, roundoff)
    monkeypatch.setattr(balance, "settle", wrong)


def test_a_step_that_breaks_the_balance_is_taken_back(monkeypatch):
    """As if the loads did half of their work: halved to the end, the state as it was."""
    wrong_work(monkeypatch, 0.5)
    steps, state, place = stepper(Scheme())
    start, first = state.pack(), place.observed
    with pytest.raises(StepError, match="the energy changed by .* J, the loads did"):
        steps.advance(state, place, 0.0, 0.02, StepRecord())
    assert np.array_equal(state.pack(), start)
    assert place.observed.energy == first.energy


def test_a_balance_lost_little_by_little_ends_the_run(monkeypatch):
    monkeypatch.setattr(balance, "STEP_SHARE", 10.0)
    wrong_work(monkeypatch, 0.5)
    with pytest.raises(StepError, match=r"until t = .* have drifted apart"):
        simulate(turned(1.0, 0.05, 1e6, 1.0, 1.0, 0.2, 1), Settings(dt=0.02, end_time=1.0))


def test_a_balance_that_is_somewhat_off_is_told(monkeypatch):
    monkeypatch.setattr(balance, "STEP_SHARE", 10.0)
    wrong_work(monkeypatch, 0.95)
    with pytest.warns(AccuracyWarning, match="take a smaller dt"):
        simulate(turned(1.0, 0.05, 1e6, 1.0, 1.0, 0.2, 1), Settings(dt=0.02, end_time=1.0))


def test_a_shell_at_rest_is_not_told_to_take_shorter_steps():
    """What moves it in the exact scheme are rounded strains: of those it is told, no dt helps."""
    plate = rectangle(2.0, 1.0, (4, 2))
    model = Model(plate.nodes, plate.quads, 0.02, 1e8, 0.3, 1000.0)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        simulate(model, Settings(5e-3, 0.5, Scheme("exact")))
    assert not [one for one in told if "smaller dt" in str(one.message)]


def test_strong_damping_ends_where_rounding_does():
    """Damping of the strains, 1e7 times as stiff as the shell in a step, strengthens what rounding
    leaves of them as much: the work that ends an iteration of the exact scheme is higher."""
    model = replace(turned(1.0, 0.05, 1e6, 1.0, 1e-3, 0.2, 2), damping=Damping(stiffness=1e4))
    result = simulate(model, Settings(1e-3, 0.02, Scheme("exact")))
    assert not result.history["halvings"].any()


@pytest.mark.parametrize(("scheme", "missed", "wrong"), [
    (Scheme(), 0.1, True), (Scheme(), -0.1, True), (Scheme(), 0.01, False),
    (Scheme(rho_inf=0.5), 0.1, False), (Scheme("newmark"), 0.1, False), (Scheme(), np.nan, True)])
def test_who_must_keep_the_balance(scheme, missed, wrong):
    """Only schemes that conserve: dissipation loses energy, the baseline newmark does anything."""
    _, state, _ = stepper(Scheme())
    state.peak = 1.0
    if wrong:
        with pytest.raises(NotConverged):
            balance.settle(scheme, state, 0.0, 0.5, 0.5 + missed, 0.0, 1e-9)
    else:
        balance.settle(scheme, state, 0.0, 0.5, 0.5 + missed, 0.0, 1e-9)


@pytest.mark.parametrize("kind", ["modified", "full"])
def test_elements_lost_in_their_coordinates(kind):
    """A step of 1e17 m: the size of an element is lost beside its place, but for the low parts of
    the positions."""
    plate = rectangle(1.0, 1.0, (1, 1))
    model = Model(plate.nodes, plate.quads, 0.1, 1e6, 0.3, 1.0,
                  velocity=np.tile([1e18, 1e17, 0.0], (4, 1)))
    with pytest.warns(AccuracyWarning, match="halvings in the first"):
        result = simulate(model, Settings(dt=0.1, end_time=1.0, newton=Newton(kind)))
    assert np.allclose(result.displacement, [1e18, 1e17, 0.0], rtol=1e-12, atol=0.1)


def test_many_halvings_are_told_as_soon_as_they_are():
    """Not at the end of a long run: at the step where they are many, once, with a time step."""
    told = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        simulate(load_case("l-plate").model(30), Settings(dt=0.1, end_time=8.0),
                 progress=lambda step, n_steps, row: told.append(len(caught)))
    assert told[-1] == len(caught) == 1 and told.index(1) < 40
    assert "a smaller dt, of about 0.0" in str(caught[0].message)
