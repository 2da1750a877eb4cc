"""Steps of order 4: their order, what they conserve, where they are refused."""

from dataclasses import replace

import numpy as np
import pytest

from corovec import (
    Damping,
    Drag,
    Hinge,
    InputError,
    Model,
    Newton,
    NodalLoad,
    RigidBody,
    RigidLink,
    Scheme,
    Settings,
    Spring,
    TimeFunction,
    block,
    cut,
    read,
    rigid_velocity,
    simulate,
)
from corovec.solver.dynamics import composed

TIGHT = Newton("modified", 1e-10)


def flying():
    """A thick soft plate that tumbles, whose vibrations the steps resolve."""
    mesh = block([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], (4, 2))
    rest = Model.of(mesh, 0.2, 3e4, 0.3, 1000.0)
    v, w = rigid_velocity(rest, (0.2, 0.0, 0.1), (1.0, 2.0, 0.7), rest.centre)
    v[:, 2] += 0.3 * (np.sin(0.5 * np.pi * mesh.nodes[:, 0]) - 0.6)
    return replace(rest, velocity=v, normal_velocity=w)


def fly(dt, name="exact", order=4):
    settings = Settings(dt=dt, end_time=0.5, scheme=Scheme(name, order=order), newton=TIGHT)
    return simulate(flying(), settings, probes={"corner": 0})


def errors(name, order, wanted):
    return [np.linalg.norm(fly(dt, name, order).history["corner_u"][-1] - wanted)
            for dt in (0.025, 0.0125)]


@pytest.mark.parametrize("name", ["quasi", "exact"])
def test_order(name, monkeypatch):
    """Twice as many steps leave a sixteenth of the error; five equal parts, a wrong variant, leave
    a quarter."""
    wanted = fly(0.025 / 8.0, name).history["corner_u"][-1]
    coarse, fine = errors(name, 4, wanted)
    assert 3.5 < np.log2(coarse / fine) < 4.5
    assert coarse < 0.05 * errors(name, 2, wanted)[0]
    monkeypatch.setattr(composed, "PARTS", (0.2,) * 5)
    coarse, fine = errors(name, 4, wanted)
    assert 1.5 < np.log2(coarse / fine) < 2.5


def test_conservation():
    """Of energy and both momenta, to rounding, in parts that go back too; five parts a step."""
    result = fly(0.025)
    assert max(result.drift.energy, result.drift.linear_momentum,
               result.drift.angular_momentum) < 1e-12
    assert np.all(result.history["parts"][1:] == 5) and not result.history["halvings"].any()


@pytest.mark.parametrize("name, kept", [("exact", 1e-11), ("quasi", 1e-4)])
def test_joints_bodies_and_loads(name, kept):
    """Energy is the work of the loads; constraints hold."""
    mesh = block([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], (4, 2))
    mesh, *sides = cut(mesh, (1, 0, 0), (1, 1, 0))
    hub = RigidBody("hub", 5.0, (0.4, 0.5, 0.6), (2.5, 0.5, 0.0), mesh.nodes_at(x=2.0))
    pulse = TimeFunction((0.0, 0.1, 0.2), (0.0, 1.0, 0.0))
    model = Model.of(mesh, 0.05, 1e6, 0.3, 300.0, bodies=[hub],
                     joints=[Hinge(*sides, stiffness=5.0), RigidLink(0, "hub", to=(2.5, 0.5, 0.3))],
                     attached=[Spring(0, 5, 20.0)], loads=[NodalLoad(0, (3.0, 20.0, 50.0), pulse)])
    result = simulate(model, Settings(dt=0.02, end_time=0.6, scheme=Scheme(name, order=4)))
    assert np.abs(result.energy_balance) < kept
    assert max(result.balance.forces, result.balance.moments) < max(kept, 1e-9)


def test_resumed_in_the_same_bits(tmp_path):
    whole, parts = tmp_path / "whole.h5", tmp_path / "parts.h5"
    settings = Settings(dt=0.025, end_time=1.0, scheme=Scheme("exact", order=4), frame_every=4)
    simulate(flying(), settings, output=whole)

    def stop(step, last, row):
        if step == 30:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(flying(), settings, output=parts, progress=stop)
    simulate(flying(), settings, output=parts, resume=True)
    one, other = read(whole), read(parts)
    assert np.array_equal(one["displacement"], other["displacement"])
    assert np.array_equal(one["history"], other["history"])


def test_losses_are_refused():
    """By their names: what goes back in time would give energy there."""
    model = flying()
    hinged = cut(block([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], (4, 2)), (1, 0, 0), (1, 1, 0))
    fold = Hinge(hinged.nodes, hinged.others, damping=1.0, name="fold")
    for given, told in (
            (replace(model, damping=Damping(1.0)), "order must be 2 where damping takes energy"),
            (replace(model, loads=[Drag(1.0, 1.2)]), "where load 0, a drag, takes energy"),
            (replace(model, attached=[Spring(0, 3, damping=1.0)]), r"the damper of attached\[0\]"),
            (Model.of(hinged.mesh, 0.2, 3e4, 0.3, 1000.0, joints=[fold]), "a latch of fold")):
        with pytest.raises(InputError, match=told):
            simulate(given, Settings(dt=0.1, end_time=0.2, scheme=Scheme("exact", order=4)))


def test_what_takes_nothing_is_no_loss():
    model = replace(flying(), damping=Damping(), loads=[Drag(0.0, 1.2)])
    assert not [*composed.losses(model)]


@pytest.mark.parametrize("scheme, told", [
    ({"order": 3}, "order must be 2 or 4, is 3"),
    ({"order": 4, "rho_inf": 0.9}, "rho_inf must be 1, is 0.9"),
    ({"order": 4, "name": "newmark"}, "quasi and exact, which conserve energy"),
    ({"order": 4, "name": "exact", "dissipation": 0.1}, "dissipation must be 0, is 0.1")])
def test_mistakes(scheme, told):
    with pytest.raises(InputError, match=told):
        Scheme(**scheme)


def test_an_error_chooses_steps_of_order_two():
    with pytest.raises(InputError, match="steps of order 2, not of order 4"):
        Settings(dt=0.1, end_time=0.2, scheme=Scheme(order=4), error=1e-3)
