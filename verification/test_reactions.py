"""Reactions of supports, in statics and in motion; probes."""

from dataclasses import replace

import h5py
import numpy as np
import pytest

from corovec import (
    Drive,
    EnergyProbe,
    Gravity,
    Harmonic,
    InputError,
    Model,
    Newton,
    NodalLoad,
    NodalMoment,
    Pressure,
    ResultFileError,
    RigidBody,
    Scheme,
    Settings,
    StressProbe,
    Support,
    TimeFunction,
    block,
    line_load,
    load_control,
    read,
    simulate,
    solve_linear,
    stresses,
)
from corovec.solver.dynamics.result import balance
from corovec.solver.system.reactions import Supported
from corovec.solver.system.system import System
from corovec.verification.models import cross_code_plate, folded, rectangle
from corovec.verification.shells import CLAMPED, strip

PULSE = TimeFunction((0.0, 0.1, 0.2), (0.0, 1.0, 0.0))


def root_of(model, x=0.0):
    """Numbers of the nodes at ``x``."""
    return tuple(int(i) for i in np.flatnonzero(model.nodes[:, 0] == x))


def clamped(loads, **options):
    plate = rectangle(2.0, 1.0, (6, 3), **options)
    return replace(plate, loads=loads, supports=[Support(root_of(plate), CLAMPED)])


@pytest.mark.parametrize("moment", [(0.0, 1.0, 0.0), (0.6, 0.0, 0.8)])
@pytest.mark.parametrize("factors", [[1.0], [0.5, 1.0]])
def test_clamp_reacts_to_a_moment(moment, factors):
    """1 N m applied, also in part about the normal: minus that, whatever the shell turns."""
    model = clamped([NodalMoment(27, moment)], poisson=0.0)
    linear = solve_linear(model)
    path = load_control(model, factors)
    assert np.allclose(path.reaction_moment[-1], -np.array(moment), rtol=1e-6, atol=1e-7)
    assert np.allclose(path.reactions[-1].sum(axis=0), 0.0, atol=1e-7)
    total = (linear.reaction_moments + np.cross(model.nodes, linear.reactions)).sum(axis=0)
    assert np.allclose(total, -np.array(moment), rtol=1e-9, atol=1e-9)


def test_moment_at_the_support_goes_into_it():
    """At a clamped node all of it, at a hinged one what is about the normal goes round."""
    model = clamped([NodalMoment(0, (0.1, 0.2, 0.3))])
    with pytest.warns(UserWarning, match="no load does anything"):
        linear = solve_linear(model)
    assert np.allclose(linear.reaction_moments[0], (-0.1, -0.2, -0.3), atol=1e-15)
    held = replace(model, loads=[NodalMoment(0, (0.0, 0.0, 0.3))], supports=[
        Support((0,), ("x", "px", "py", "pz")), Support(root_of(model)[1:], ("x", "y", "z"))])
    linear = solve_linear(held)
    total = (linear.reaction_moments + np.cross(held.nodes, linear.reactions)).sum(axis=0)
    assert np.allclose(total, (0.0, 0.0, -0.3), atol=1e-9)
    assert np.allclose(linear.reaction_moments[:, 2], 0.0, atol=1e-12)


def test_static_balance_at_large_rotations():
    """Loads in their moved places against reactions and their moments; a clamped fold too."""
    model, tip = strip(10.0, 16, lambda X, nodes: line_load(X, nodes, (0.0, 0.0, 8.0)))
    path = load_control(model, [1.0])
    x = model.nodes + path.displacement[-1]
    applied = sum(np.array(load.force) for load in model.loads)
    about = sum(np.cross(x[load.node], load.force) for load in model.loads)
    assert np.abs(path.displacement[-1]).max() > 5.0
    assert np.allclose(path.reactions[-1].sum(axis=0), -applied, atol=1e-8)
    assert np.allclose(path.reaction_moment[-1], -about, rtol=1e-8)
    assert path.frame()["reaction_moment_y"].iloc[-1] == path.reaction_moment[-1, 1]
    fold = folded()
    fold = replace(fold, supports=[Support((6, 7, 8), CLAMPED)],
                   loads=[NodalLoad(13, (1e-5, 2e-5, 0.0))])
    path = load_control(fold, [1.0])
    x = fold.nodes + path.displacement[-1]
    assert np.allclose(path.reaction_moment[-1], -np.cross(x[13], (1e-5, 2e-5, 0.0)), rtol=1e-5,
                       atol=1e-10)


def test_pressure_balance():
    """3 Pa on 2 m^2, in the middle of the plate."""
    plate = rectangle(2.0, 1.0, (6, 3))
    model = replace(plate, loads=[Pressure(3.0)], supports=[Support(root_of(plate), CLAMPED)])
    linear = solve_linear(model)
    assert np.allclose(linear.reactions.sum(axis=0), (0.0, 0.0, -6.0), atol=1e-8)
    total = (linear.reaction_moments + np.cross(model.nodes, linear.reactions)).sum(axis=0)
    assert np.allclose(total, -np.cross((1.0, 0.5, 0.0), (0.0, 0.0, 6.0)), rtol=1e-8)


def run(model, steps=40, dt=0.01, newton=None, **options):
    return simulate(model, Settings(dt=dt, end_time=steps * dt, scheme=Scheme(**options),
                                    newton=newton or Newton()))


def loaded(model, dt, steps):
    """Forces of dead loads at the middle of each step, (steps, 3)."""
    middle = (np.arange(steps) + 0.5) * dt
    return sum(np.outer([load.history(t) for t in middle], load.force) for load in model.loads)


@pytest.mark.parametrize("transformation", ["midpoint", "average"])
@pytest.mark.parametrize("newton, exact", [(Newton(), 1e-5), (Newton("full"), 1e-6),
                                           (Newton("full", 1e-24), 1e-11)])
def test_momentum_changes_by_loads_and_reactions(transformation, newton, exact):
    """dL = dt (F + R) at the middle of every step, but for the residual that the iteration leaves
    at the free nodes (measured 4e-6, 2e-7 and 1e-12)."""
    model = clamped([NodalLoad(27, (0.5, 1.0, 3.0), PULSE)])
    result = run(model, newton=newton, transformation=transformation)
    change = np.diff(result.history["linear_momentum"], axis=0) / 0.01
    reaction = result.history["reaction"][1:]
    assert np.abs(reaction).max() > 1.0 and not result.history["reaction"][0].any()
    assert np.allclose(change, loaded(model, 0.01, 40) + reaction,
                       rtol=0.0, atol=exact * np.abs(reaction).max())


def test_angular_momentum_changes_by_moments():
    """dJ/dt = x x F + M about the origin, to the second order of the scheme."""
    errors = []
    for steps in (40, 80):
        dt = 0.4 / steps
        model = clamped([NodalLoad(27, (0.5, 1.0, 3.0), PULSE)])
        result = simulate(model, Settings(dt=dt, end_time=0.4), probes={"tip": 27})
        tip = model.nodes[27] + result.probes["tip"]["displacement"]
        moment = np.cross(0.5 * (tip[1:] + tip[:-1]), loaded(model, dt, steps))
        change = np.diff(result.history["angular_momentum"], axis=0) / dt
        missed = change - moment - result.history["reaction_moment"][1:]
        errors.append(np.abs(missed).max() / np.abs(change).max())
    assert errors[1] < 0.35 * errors[0] < 0.01


def test_halved_steps_have_the_mean_of_their_parts(monkeypatch):
    """The momentum balance holds over halved steps as well."""
    from corovec.solver.dynamics.newton import Iteration
    from corovec.solver.system.failure import NotConverged
    solve = Iteration.increment

    def halving(self, problem, rule, record):
        if problem.dt > 0.006:
            raise NotConverged("tried")
        return solve(self, problem, rule, record)

    monkeypatch.setattr(Iteration, "increment", halving)
    model = clamped([NodalLoad(27, (0.5, 1.0, 3.0), PULSE)])
    with pytest.warns(UserWarning, match="halvings"):
        result = run(model, 10)
    assert np.all(result.history["halvings"][1:] == 1)
    change = np.diff(result.history["linear_momentum"], axis=0) / 0.01
    assert np.allclose(change, loaded(model, 0.01, 10) + result.history["reaction"][1:], atol=1e-8)


def test_frames_have_reactions(tmp_path):
    """Nodal ones, whose resultant is the row's; a free shell has none, and zeros in its history."""
    path = tmp_path / "run.h5"
    model = clamped([NodalLoad(27, (0.5, 1.0, 3.0), PULSE)])
    settings = Settings(dt=0.01, end_time=0.2, frame_every=5)
    simulate(model, settings, output=path)
    contents = read(path)
    rows = contents["history"][contents["frame_steps"]]
    assert np.allclose(contents["reaction"].sum(axis=1), rows["reaction"], atol=1e-12)
    moments = np.cross(model.nodes, contents["reaction"]) + contents["reaction_moment"]
    assert np.allclose(moments.sum(axis=1), rows["reaction_moment"], atol=1e-12)
    assert np.all(contents["reaction"][:, model.nodes[:, 0] > 0.0] == 0.0)
    free = tmp_path / "free.h5"
    result = simulate(cross_code_plate(1), settings, output=free)
    assert "reaction" not in read(free) and not result.history["reaction"].any()


# ------------------------------------------------------------------ global balance

EVERYTHING = [NodalLoad(27, (0.5, 1.0, 3.0), PULSE), NodalMoment(26, (0.1, 0.2, 0.3), PULSE),
              Pressure(2.0, None, PULSE), Gravity((0.0, 0.0, -1.0))]


def of_all_kinds(held):
    plate = clamped([*EVERYTHING, NodalMoment(0, (0.3, 0.1, 0.2))] if held else EVERYTHING)
    return plate if held else replace(plate, supports=[])


@pytest.mark.parametrize("held", [True, False])
def test_balance_of_a_run(held):
    """Forces of all kinds of loads and reactions change the momentum, to what Newton's iteration
    leaves (measured 1e-13); moments to the second order in dt."""
    model, newton = of_all_kinds(held), Newton("full", 1e-24)
    coarse, fine = (run(model, steps, 0.4 / steps, newton) for steps in (40, 80))
    assert max(coarse.balance.forces, fine.balance.forces) < 1e-11
    assert fine.balance.moments < 0.35 * coarse.balance.moments < 1e-5
    assert run(model, newton=Newton()).balance.forces < 1e-5


LIFT = Support((0, 10), ("z",), displacement=0.1,
               history=TimeFunction((0.0, 0.1, 0.2), (0.0, 1.0, 0.0)))
SWING = Drive((0, 5, 10), translation=(0.0, 0.0, 0.1), rotation=(0.0, 0.5, 0.1),
              history=Harmonic(2.0), turning=Harmonic(2.0))


@pytest.mark.parametrize(("support", "nodes"), [(LIFT, ()), (LIFT, (0, 5, 10)),
                                                (SWING, (1, 6, 11))])
def test_balance_of_moving_supports(support, nodes):
    """Where the velocity of a support jumps, the jump is among its reactions (0.25 without, at the
    steps of the jumps); so is what the impulses of a body move at its nodes (1e-6 of the energy
    without).  Those act at the ends of a step, reactions at its middle: moments to the second
    order."""
    mesh = block([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], (4, 2))
    bodies = [RigidBody("block", 50.0, (1.0, 2.0, 2.0), mesh.nodes[list(nodes)].mean(axis=0),
                        nodes)] if nodes else []
    model = Model.of(mesh, 0.2, 3e4, 0.3, 1000.0, bodies=bodies, supports=[support])
    found = run(model, 20, name="exact")
    assert max(found.balance.forces, found.energy_balance) < 1e-12
    assert found.balance.moments < 1e-6


@pytest.mark.parametrize("support", [LIFT, SWING])
def test_reactions_of_moving_supports_are_on_their_nodes(support, tmp_path):
    """Where their velocity jumps, with a body on their nodes, or beside them (it had 5000 N)."""
    mesh = block([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], (4, 2))
    nodes = (0, 5, 10) if support is LIFT else (1, 6, 11)
    body = RigidBody("block", 50.0, (1.0, 2.0, 2.0), mesh.nodes[list(nodes)].mean(axis=0), nodes)
    model = Model.of(mesh, 0.2, 3e4, 0.3, 1000.0, bodies=[body], supports=[support])
    found = simulate(model, Settings(dt=0.01, end_time=0.2, scheme=Scheme("exact"), frame_every=1),
                     output=tmp_path / "run.h5")
    forces = read(tmp_path / "run.h5")["reaction"]
    assert np.abs(np.delete(forces, support.nodes, axis=1)).max() == 0.0
    np.testing.assert_allclose(forces.sum(axis=1), found.history["reaction"], atol=1e-9)


@pytest.mark.parametrize("wrong", ["forces", "moments", "load"])
def test_wrong_reactions_break_the_balance(monkeypatch, wrong):
    """A hundredth too much of a reaction, or of a load."""
    right, applied = Supported.reactions, System.resultant_of_loads

    def reactions(self, *arguments):
        found = right(self, *arguments)
        return found._replace(force=1.01 * found.force) if wrong == "forces" else (
            found._replace(moment=1.01 * found.moment))

    def loads(self, *arguments):
        found = applied(self, *arguments)
        return found._replace(force=1.01 * found.force)

    if wrong == "load":
        monkeypatch.setattr(System, "resultant_of_loads", loads)
    else:
        monkeypatch.setattr(Supported, "reactions", reactions)
    # on a stiff shell most of a reaction swings to and fro: its impulse is what is left of that
    for model in (of_all_kinds(True), clamped(EVERYTHING[3:])):
        left = run(model).balance
        static = load_control(model, [1.0]).balance
        for found in (left, static):
            assert (found.moments if wrong == "moments" else found.forces) > 2e-4


def test_balance_of_equilibria():
    """Of load control and linear statics, at a junction that is clamped as well."""
    fold = replace(folded(), supports=[Support((6, 7, 8), CLAMPED)], loads=[
        NodalLoad(13, (1e-5, 2e-5, 0.0)), *(NodalMoment(k, (1e-5, 2e-5, 3e-5)) for k in (7, 12))])
    for model, exact in ((of_all_kinds(True), 1e-9), (fold, 1e-7)):
        path = load_control(model, [0.1, 0.2])
        assert path.balances.shape == (2, 2) and max(path.balance) < exact
        assert np.allclose(path.load + path.reactions.sum(axis=1), 0.0, atol=1e-8)
        # a linear solution has its moments about the initial places
        assert max(solve_linear(model).balance) < 1e-12


def test_balance_in_files(tmp_path):
    """The history of a file has what the result has, also one that is resumed."""
    path = tmp_path / "run.h5"
    settings = Settings(dt=0.01, end_time=0.2, frame_every=5)
    result = simulate(of_all_kinds(True), settings, output=path)
    history = read(path)["history"]
    assert balance(history) == result.balance
    assert {"load_x", "load_moment_z"} <= set(result.frame())
    load_control(of_all_kinds(True), [0.1], output=path, overwrite=True)
    with pytest.raises(InputError, match="must be that of a run in time"):
        balance(read(path)["history"])


# ------------------------------------------------------------------ probes

def test_probes(tmp_path):
    """By node and by place; in memory, in the file, as a table; the last row is the result's."""
    path, model = tmp_path / "run.h5", cross_code_plate(1)
    settings = Settings(dt=0.01, end_time=0.5, frame_every=10)
    result = simulate(model, settings, output=path, probes={"tip": 5, "corner": (2, 10, 0)})
    assert list(result.probes) == ["corner", "tip"]
    tip = result.probes["tip"]
    assert tip["displacement"].shape == tip["velocity"].shape == (51, 3)
    assert np.array_equal(tip["displacement"][-1], result.displacement[5])
    middle = 0.5 * (tip["velocity"][1:] + tip["velocity"][:-1])
    assert np.allclose(np.diff(tip["displacement"], axis=0) / 0.01, middle, atol=1e-9)
    contents = read(path)
    assert np.array_equal(contents["history"], result.history)
    assert contents["description"]["probes"]["tip"] == 5
    node = contents["description"]["probes"]["corner"]
    assert model.nodes[node].tolist() == [2.0, 10.0, 0.0]
    assert np.array_equal(contents["displacement"][:, node],
                          result.probes["corner"]["displacement"][::10])
    with h5py.File(path) as file:
        assert np.array_equal(file["probes/tip/velocity"], tip["velocity"])
    assert {"tip_u_x", "tip_v_z", "corner_u_y"} <= set(result.frame())


def test_probes_change_nothing_and_resume(tmp_path):
    whole, part = tmp_path / "whole.h5", tmp_path / "part.h5"
    model, settings = cross_code_plate(1), Settings(dt=0.01, end_time=0.5, frame_every=10)
    plain = simulate(model, settings)
    probed = simulate(model, settings, output=whole, probes={"a": 3})
    for name in plain.history.dtype.names:
        assert np.array_equal(plain.history[name], probed.history[name])

    def interrupts(step, n_steps, row):
        if step == 33:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(model, settings, output=part, probes={"a": 3}, progress=interrupts)
    with pytest.raises(ResultFileError, match="probes are {'a': 3} there and {'a': 4} here"):
        simulate(model, settings, output=part, probes={"a": 4}, resume=True)
    again = simulate(model, settings, output=part, probes={"a": 3}, resume=True)
    assert np.array_equal(again.history, probed.history)
    assert np.array_equal(read(part)["history"], read(whole)["history"])


def test_changed_probe_is_damage(tmp_path):
    path = tmp_path / "run.h5"
    simulate(cross_code_plate(1), Settings(dt=0.01, end_time=0.1), output=path, probes={"a": 3})
    with h5py.File(path, "r+") as file:
        file["probes/a/velocity"][4] += 1.0
    with pytest.raises(ResultFileError, match="has changed"):
        read(path)


@pytest.mark.parametrize("probes, told", [
    (["tip"], "probes must be a dictionary"),
    ({"tip/x": 1}, "probes: a name is letters, digits and _, is 'tip/x'"),
    ({3: 1}, "probes: a name is letters"),
    ({"tip": 900}, "probes: tip: node 900 does not exist"),
    ({"tip": True}, "probes: tip must be an integer, is True"),
    ({"tip": (1.0, 2.0)}, "probes: tip must be three numbers"),
    ({"tip": (1.5, 2.0, 0.0)}, "probes: tip: no node at"),
    ({f"p{k}": 1 for k in range(101)}, "at most 100")])
def test_wrong_probes(probes, told):
    with pytest.raises(InputError, match=told):
        simulate(cross_code_plate(1), Settings(dt=0.01, end_time=0.1), probes=probes)


def test_probes_of_stresses_and_energies(tmp_path):
    """What ``stresses`` and the history have; by number and by place, along a direction, in the
    file."""
    path, model = tmp_path / "run.h5", cross_code_plate(1)
    settings = Settings(dt=0.01, end_time=0.5, frame_every=10)
    centre = model.nodes[model.quads[7]].mean(axis=0) + (0.01, 0.0, 0.02)
    result = simulate(model, settings, output=path, probes={
        "own": StressProbe(7), "along": StressProbe(centre, (1.0, 0.0, 0.0)), "tip": 5,
        "all": EnergyProbe(), "part": EnergyProbe([7, 3])})
    for name, axes in (("own", None), ("along", (1.0, 0.0, 0.0))):
        found, probe = stresses(model, result.state, axes), result.probes[name]
        for what, values in (("membrane_force", found.n), ("moment", found.m),
                             ("shear_force", found.q), ("von_mises", found.von_mises)):
            # strains are differences of numbers of order one, of few digits where they are small
            assert np.allclose(probe[what][-1], values[7], rtol=1e-9,
                               atol=1e-9 * np.abs(values).max())
    energy = result.probes["all"]["strain_energy"]
    assert np.allclose(energy, result.history["strain_energy"], rtol=1e-13)
    contents = read(path)
    assert np.array_equal(contents["history"], result.history)
    assert np.allclose(contents["strain_energy"][:, [3, 7]].sum(axis=1),
                       result.probes["part"]["strain_energy"][::10], rtol=1e-13)
    assert contents["description"]["probes"]["along"]["element"] == 7
    assert {"own_n_xx", "along_q_yz", "own_von_mises_top"} <= set(result.frame())


@pytest.mark.parametrize("make, told", [
    (lambda: StressProbe("root"), "at must be three numbers|at must be an integer"),
    (lambda: EnergyProbe([]), "elements must not be empty"),
    (lambda: StressProbe(900), "probes: a: element 900 does not exist"),
    (lambda: StressProbe(1, (0.0, 0.0, 1.0)), "probes: a: axes .* are no direction in the surface"),
    (lambda: EnergyProbe([1, 900]), "probes: a: element 900 does not exist")])
def test_wrong_probes_of_elements(make, told):
    with pytest.raises(InputError, match=told):
        simulate(cross_code_plate(1), Settings(dt=0.01, end_time=0.1), probes={"a": make()})
