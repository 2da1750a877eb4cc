"""Steps that choose themselves: their error, points of functions of time, what they keep."""

import numpy as np
import pytest

from corovec import (
    Drive,
    Expression,
    Harmonic,
    InputError,
    NodalLoad,
    Revolute,
    RigidBody,
    Scheme,
    Settings,
    TimeFunction,
    simulate,
)
from corovec.benchmarks import load_case
from corovec.solver.dynamics.stepping import Stepper
from corovec.verification.fuzz.kills import assert_same_bits
from corovec.verification.linked_shells import alone
from corovec.verification.models import cross_code_plate

LOADED = load_case("l-plate").model(30)
SCHEMES = {"exact": Scheme("exact"), "dissipating": Scheme("exact", dissipation=0.3),
           "quasi": Scheme()}


def run(error=0.0, dt=0.04, end_time=2.0, scheme="exact", **options):
    settings = Settings(dt, end_time, SCHEMES[scheme], error=error, frame_every=options.pop(
        "frame_every", 0))
    return simulate(LOADED, settings, **options)


@pytest.mark.parametrize("scheme", ["exact", "quasi"])
def test_less_error_is_asked_for_and_found(scheme):
    """Parts get shorter with the error that is asked for, and the path nearer to that of short
    steps; a step is divided in powers of two."""
    exact = run(dt=0.002, scheme=scheme).displacement
    missed, parts = [], []
    for error in (1e-4, 1e-6):
        result = run(error, scheme=scheme)
        rows = result.history[1:]
        assert np.all(rows["local_error"] <= error)
        assert result.history["parts"][1:].min() < result.history["parts"].max()
        missed.append(np.abs(result.displacement - exact).max())
        parts.append(rows["parts"].sum())
    assert missed[1] < 0.5 * missed[0] and parts[1] > 3 * parts[0]


@pytest.mark.parametrize("scheme", ["exact", "dissipating"])
def test_what_a_step_keeps_all_its_parts_keep(scheme):
    """Energy, less what was dissipated and the work, and both momenta, through parts of many
    lengths."""
    result = run(1e-5, end_time=4.0, scheme=scheme)
    rows = result.history
    missed = result.total_energy + rows["dissipated"] - rows["external_work"]
    assert len(set(rows["parts"][1:])) > 1 and rows["rejected"].sum() > 0
    assert np.abs(missed).max() < 1e-11 * result.total_energy.max()
    assert result.drift.linear_momentum < 1e-12 and result.drift.angular_momentum < 1e-11
    assert (rows["dissipated"][-1] > 1e-3) == (scheme == "dissipating")


def test_points_of_functions_of_time_are_ends_of_parts():
    """A pulse shorter than dt, with points beside the grid, has its exact impulse; steps of dt are
    refused, which would miss it."""
    pulse = TimeFunction((0.0, 0.003, 0.0101, 0.0177), (0.0, 0.0, 1.0, 0.0))
    model = cross_code_plate(1)
    model = model.under([NodalLoad(0, (0.0, 0.0, 5.0), pulse)], [])
    with pytest.raises(InputError, match="too long for its time function"):
        simulate(model, Settings(0.05, 0.2, SCHEMES["exact"]))
    result = simulate(model, Settings(0.05, 0.2, SCHEMES["exact"], error=1e-3))
    momentum = result.history["linear_momentum"][-1]
    assert np.allclose(momentum, (0.0, 0.0, 5.0 * pulse.integral(1.0)), rtol=1e-13, atol=1e-15)


def test_parts_of_whole_steps_are_equal_to_the_last_bit(monkeypatch):
    """A length rounded otherwise, as t + dt - t is, would not find the matrix that is kept."""
    lengths, advance = set(), Stepper.advance

    def told(self, state, place, time, dt, *others):
        lengths.add(dt)
        advance(self, state, place, time, dt, *others)
    monkeypatch.setattr(Stepper, "advance", told)
    run(1e-5, dt=0.05)  # no points within steps
    assert lengths <= {0.05 / 2**k for k in range(11)}


@pytest.mark.parametrize(("kind", "held"), [("load", False), ("drive", True)])
def test_functions_of_time_without_points_are_seen(kind, held):
    """Of a period that divides the parts the motion would begin with: they would see none of it,
    and find no error."""
    model, shake = cross_code_plate(1), Harmonic(80.0, 1.0)
    if held:
        model = model.under([], [Drive((0, 1), translation=(0.0, 0.0, 1e-3), history=shake)])
    else:
        model = model.under([NodalLoad(0, (0.0, 0.0, 5.0), shake)], [])
    seen, whole = (simulate(model, Settings(dt, 0.1, SCHEMES["exact"], error=error))
                   .total_energy[-1] for dt, error in ((0.1, 1e-4), (2e-4, 0.0)))
    assert 0.3 * whole < seen < 3.0 * whole


@pytest.mark.filterwarnings("ignore::corovec.AccuracyWarning")  # rows have none of the energy
@pytest.mark.parametrize("driving", [TimeFunction((0.0, 0.013, 0.07), (0.0, 0.0, 1.0)),
                                     Expression("exp(-((t - 0.015)/0.002)**2)")])
def test_drives_of_joints_are_seen(driving, monkeypatch):
    """A point between the ends of parts is one; a turn to and fro within a step divides it."""
    body = RigidBody("body", 2.0, (0.3, 0.3, 0.4), (1.0, 0.0, 0.0))
    model = alone([body], [Revolute("ground", "body", (0, 0, 0), (0, 0, 1), 0.1, driving)])
    starts, advance = [], Stepper.advance

    def told(self, state, place, time, *others):
        starts.append(time)
        advance(self, state, place, time, *others)
    monkeypatch.setattr(Stepper, "advance", told)
    simulate(model, Settings(0.025, 0.025, SCHEMES["exact"], error=1e-3))
    assert 0.013 in starts if isinstance(driving, TimeFunction) else len(starts) > 10


@pytest.mark.parametrize("scheme", list(SCHEMES))
def test_resumed_runs_have_the_same_bits(scheme, tmp_path):
    """What the next part depends on is in the checkpoint."""
    whole, parted = tmp_path / "whole.h5", tmp_path / "parted.h5"
    run(1e-5, scheme=scheme, output=whole, frame_every=10)

    def stop(step, *_):
        if step == 37:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(1e-5, scheme=scheme, output=parted, frame_every=10, progress=stop)
    run(1e-5, scheme=scheme, output=parted, frame_every=10, resume=True)
    assert_same_bits(whole, parted)


@pytest.mark.parametrize("error", [-1e-3, 1.0, float("nan")])
def test_an_error_is_a_part_of_the_shells_size(error):
    """Between none and the whole size."""
    with pytest.raises(InputError, match="error must"):
        Settings(0.01, 1.0, error=error)


@pytest.mark.slow
def test_steps_that_cannot_be_short_enough_are_told_of():
    """Once a run."""
    with pytest.warns(UserWarning, match="take a smaller dt") as told:
        run(1e-14, end_time=0.12)
    assert len([one for one in told if "error of a step" in str(one.message)]) == 1
