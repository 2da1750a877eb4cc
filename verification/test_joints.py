"""Joints: hinges and spherical joints that conserve what they should, and what they refuse."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from corovec import (
    Cyclic,
    Drive,
    Gravity,
    Hinge,
    InputError,
    JointProbe,
    Mesh,
    Model,
    NodalLoad,
    RigidLink,
    Scheme,
    Settings,
    Spherical,
    Spring,
    Support,
    TimeFunction,
    block,
    cut,
    join,
    load_control,
    read,
    rigid_velocity,
    simulate,
    solve_linear,
    total_energy,
)
from corovec.solver.kernels import hinges
from corovec.solver.model.cutting import apart
from corovec.solver.model.mesh import node_at
from corovec.solver.system.joints import Hinges
from corovec.solver.system.turning import Turnings
from corovec.verification.fuzz.kills import assert_same_bits
from corovec.verification.shells import CLAMPED
from corovec.verification.suites.joints import (
    EXACT,
    HAT,
    MOMENTS,
    TURN,
    chain,
    drifts,
    errors,
    folded,
    kernel_forces,
    midpoint_forces,
    random_step,
    swung,
)

ROUNDING = 1e-14
"""Of a work of order one; 2000 steps had 2e-15."""

ROUNDED = 1e-10
"""Of energy and momenta: rounding of the residuals of 100 steps; quasi has 1e-6 and more."""


# ------------------------------------------------------------------ the angle of a hinge


@given(st.integers(0, 2**32))
@settings(max_examples=100)
def test_work_of_a_moment(seed):
    """It is moment times change of angle in any step, whatever turns, with no moment about the
    origin; a rigid motion does no work."""
    rng = np.random.default_rng(seed)
    start, end = random_step(rng)
    work, moment = errors(kernel_forces(start, end), start, end)
    assert work < ROUNDING and moment < ROUNDING
    turned = Rotation.from_rotvec(rng.normal(size=3)).apply(start)
    assert abs(np.sum(kernel_forces(start, turned) * (turned - start))) < ROUNDING
    assert np.allclose(kernel_forces(start, end, -3.0), -3.0 * kernel_forces(start, end),
                       rtol=1e-13, atol=1e-13)


def test_the_derivative_in_the_middle_does_other_work():
    for seed in range(20):
        rng = np.random.default_rng(seed)
        start, end = folded(rng, 0.5, (0.0, 0.0, 0.0)), folded(rng, 1.2, (0.3, 0.2, 0.1))
        assert errors(kernel_forces(start, end), start, end)[0] < ROUNDING
        assert errors(midpoint_forces(start, end), start, end)[0] > 1e-2


# ------------------------------------------------------------------ chains of plates in flight


def run(model, scheme=EXACT, dt=0.02, end=2.0, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # drifts of other schemes and of wrong variants
        return simulate(model, Settings(dt=dt, end_time=end, scheme=scheme), **options)


@pytest.mark.parametrize("kind", [kind if kind in ("spring table", "latch") else pytest.param(
    kind, marks=pytest.mark.slow) for kind in MOMENTS])
def test_chain_conserves(kind):
    """Energy, works and losses, and both momenta; what is joined stays so to the last bit."""
    model = chain(**MOMENTS[kind])
    result = run(model)
    assert drifts(result).max() < ROUNDED
    for joint in model.joints:
        assert np.array_equal(*((result.displacement + model.nodes)[list(side)]
                                for side in (joint.nodes, joint.others)))
    others = [node for joint in model.joints for node in joint.others]
    assert np.abs(result.displacement[others]).max() > 0.1
    quasi = drifts(run(model, Scheme()))
    assert 1e-9 < quasi.max() < 1e-4


def test_corners_that_turn_freely():
    """A staircase of plates that hang together by their corners."""
    plate = block([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], (2, 2))
    n = len(plate.nodes)
    corners = [node_at(plate.nodes, corner) for corner in ((2, 1, 0), (0, 0, 0))]
    joints = [Spherical((corners[0] + k * n, corners[1] + k * n + n)) for k in range(2)]
    loads = [NodalLoad(node, (0.0, 1.0, force), HAT) for node, force in
             ((1, 8.0), (n + 2, -9.0), (3 * n - 1, 5.0))]
    model = Model(np.concatenate([plate.nodes + k * np.array((2.0, 1.0, 0.0)) for k in range(3)]),
                  np.concatenate([plate.quads + k * n for k in range(3)]), 0.02, 2e8, 0.3, 1000.0,
                  loads=loads, joints=joints)
    result = run(model)
    assert drifts(result).max() < ROUNDED
    x = model.nodes + result.displacement
    for joint in joints:
        assert np.array_equal(*x[list(joint.nodes)])
    assert np.ptp(result.directors[n:2 * n] @ result.directors[0]) > 0.0
    assert result.directors[n] @ result.directors[0] < 0.99


@pytest.mark.parametrize("kind", ["spring", "servo", "spring table", "stops", "latch", "motor"])
def test_moments_that_are_no_discrete_gradient_lose_energy(kind, monkeypatch):
    """The derivative at the end of the step instead, which is right to first order."""
    add_forces = Hinges.add_forces

    def at_end(self, dofs, iterate, *others):
        step = iterate.step._replace(alpha_f=0.0)
        add_forces(self, dofs, iterate._replace(step=step), *others)

    monkeypatch.setattr(Hinges, "add_forces", at_end)
    assert drifts(run(chain(**MOMENTS[kind])))[0] > 1e5 * ROUNDED


@pytest.mark.slow
def test_each_moment_acts():
    """The moments of ``MOMENTS`` do what they are there for, else nothing would be tested."""
    ends = {kind: run(chain(**moments)) for kind, moments in MOMENTS.items()}
    for kind, result in ends.items():
        lost = result.history["dissipated"]
        assert np.all(np.diff(lost) >= 0.0)
        assert (lost[-1] > 1e-3) == (kind in ("damper", "damper table", "latch")), kind
        moved = np.abs(result.displacement - ends["free"].displacement).max()
        assert kind == "free" or moved > 0.01, kind


def test_a_latch_holds():
    """Before its angle it does nothing; then it is a spring about it: the servo that has pushed the
    plates there does not take them back."""
    states, latch = [], Turnings.latch

    def watched(self, state):
        latch(self, state)
        states.append(state.hinges.copy())

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Turnings, "latch", watched)
        run(chain(2, **{**MOMENTS["latch"], "lock_damping": 20.0},
                  turning=TimeFunction((2.0, 3.0), (1.0, -1.0))), end=6.0)
    angles, locked, _ = np.moveaxis(states, 2, 0)
    locked = locked > 0.0
    assert np.all(np.diff(locked.astype(int), axis=0) >= 0) and locked[-1].all()
    assert not locked[0].any()
    assert angles[~locked].max() < 0.3
    assert np.abs(angles[-50:].mean() - (200.0 * 0.3 - 3.0 * 2.0) / 203.0) < 0.02


def test_what_a_damper_takes_is_what_is_lost():
    """Two plates that fold freely at the start."""
    model = chain(2, damping=20.0)
    right = model.nodes[:, 0] > 2.0
    right[list(model.joints[0].others)] = True
    v, w = rigid_velocity(model, (0.0, 0.0, 0.0), (0.0, -2.0, 0.0), (2.0, 0.0, 0.0))
    v[~right] = w[~right] = 0.0
    joined = [*model.joints[0].nodes, *model.joints[0].others]
    v[joined] = 0.0
    history = run(replace(model, loads=(), velocity=v, normal_velocity=w)).history
    energy, lost = total_energy(history), history["dissipated"]
    assert lost[-1] > 0.1 * energy[0]
    assert np.abs(energy[0] - energy - lost).max() < ROUNDED * energy[0]


@pytest.mark.slow
def test_a_parted_run_ends_in_the_same_bits(tmp_path):
    """Angles, and whether a latch holds, are part of a checkpoint."""
    class Ended(Exception):
        pass

    def ends(step, n_steps, row):
        if step == 230:
            raise Ended

    model = chain(**MOMENTS["latch"])
    whole, parted = tmp_path / "whole.h5", tmp_path / "parted.h5"
    given = Settings(dt=0.02, end_time=6.0, scheme=EXACT, frame_every=5)
    simulate(model, given, output=whole)
    with pytest.raises(Ended):
        simulate(model, given, output=parted, progress=ends)
    assert 0 < read(parted)["step"] < 230
    simulate(model, given, output=parted, resume=True)
    assert_same_bits(whole, parted)


# ------------------------------------------------------------------ tables


TABLE = {"spring_angles": (-0.5, -0.1, 0.3, 1.0), "spring_moments": (-4.0, 1.0, 2.0, 1.5)}
DAMPER = {"damper_rates": (-2.0, 0.0, 1.0), "damper_moments": (-3.0, 0.0, 2.0)}


def of_table(before, after, rest=(0.0, 0.0), dt=0.1, **tables):
    """Moment in a step, its derivative by the angle after, the energies at both ends and what is
    lost, of the whole of a hinge by the solver's kernels."""
    turnings = Turnings(chain(2, (2, 1), **tables))
    constants = np.ascontiguousarray(turnings.constants[:1])
    states = np.array([[[angle, 0.0, slack]] for angle, slack in zip((before, after), rest)])
    found, done = np.empty((1, 2)), np.empty((1, 2))
    hinges.moments(constants, states[0], np.array([rest[1]]), np.array([after]), 0.5, 1.0 / dt,
                   found)
    hinges.done(constants, states[0], states[1], dt, done)
    energies = [hinges.energy(constants, state) for state in states]
    return 2.0 * np.array([*found[0], *energies, done[0, 1]])  # each node has half of the edge


@given(st.floats(-2.0, 2.0), st.one_of(st.floats(-2.0, 2.0), st.floats(-1e-9, 1e-9)),
       st.floats(-1.0, 1.0))
@settings(max_examples=100)
def test_a_table_is_a_discrete_gradient(before, change, slack):
    """Its moment in a step takes from the energy just what it does, through kinks and beyond ends;
    the energy is the integral of the table."""
    after = before + change
    moment, _, first, last, _ = of_table(before, after, (slack, slack), **TABLE)
    assert abs(moment * (after - before) + last - first) < 1e-15 * 30.0  # of energies up to 8 J
    x = np.linspace(0.0, after - slack, 100001)
    values = np.interp(x, TABLE["spring_angles"], TABLE["spring_moments"])
    assert last == pytest.approx(np.trapezoid(values, x), abs=1e-8)


def test_the_middle_of_a_table_does_other_work():
    """Of a step over a kink, where the discrete gradient is exact."""
    before, after = -0.5, 0.7
    moment, _, first, last, _ = of_table(before, after, **TABLE)
    middle = -np.interp(0.5 * (before + after), TABLE["spring_angles"], TABLE["spring_moments"])
    assert abs(moment * (after - before) + last - first) < ROUNDING
    assert abs(middle * (after - before) + last - first) > 0.5


@pytest.mark.parametrize(("before", "after"), [(-1.0, 2.0), (2.0, -1.0), (-0.3, 0.1), (0.0, 0.2),
                                               (0.3, 0.3), (-0.1, 1.5), (0.5, -0.3)])
def test_the_derivative_of_a_table(before, after):
    step, tables = 1e-6, {**TABLE, **DAMPER}
    found = of_table(before, after, **tables)
    ends = [of_table(before, after + sign * step, **tables)[0] for sign in (-1.0, 1.0)]
    slope = -(ends[1] - ends[0]) / (2.0 * step)
    assert found[1] == pytest.approx(slope, abs=1e-4) or before == after


@pytest.mark.parametrize("angles", [(-0.5, 1.0), (-1.0, 0.5), (-0.5, 0.0, 1.0), (-1.0, 0.5, 2.0)])
def test_the_energy_of_a_small_angle(angles):
    """Seen: 1e-8 of it was lost in the integrals from the ends of the table."""
    for angle in (1e-7, -1e-7):
        energy = of_table(0.0, angle, spring_angles=angles, spring_moments=tuple(
            3.0 * one for one in angles))[3]
        assert energy == pytest.approx(1.5 * angle**2, rel=1e-7)


def test_what_the_table_of_a_damper_takes():
    """The moment at the mean rate, on the whole way; at rest nothing."""
    for change in (-0.3, -0.1, 0.0, 0.05, 0.3):
        moment, _, _, _, lost = of_table(0.2, 0.2 + change, **DAMPER)
        wanted = np.interp(change / 0.1, DAMPER["damper_rates"], DAMPER["damper_moments"])
        assert moment == pytest.approx(-wanted) and lost == pytest.approx(wanted * change)
        assert lost >= 0.0


def test_a_line_is_a_table():
    """A table through a line is a spring, and a damper, to rounding, in flight."""
    line = dict(stiffness=3.0, damping=0.5)
    table = dict(spring_angles=(-9.0, 9.0), spring_moments=(-27.0, 27.0),
                 damper_rates=(-90.0, 90.0), damper_moments=(-45.0, 45.0))
    one, other = (run(chain(2, rest=0.5, **kind), end=0.5) for kind in (line, table))
    assert np.abs(one.displacement - other.displacement).max() < 1e-10
    assert np.abs(one.displacement).max() > 1e-3


# ------------------------------------------------------------------ what joints do


def momenta(model, result):
    """(n_nodes, 3) linear momenta at the end of a run."""
    return model.nodal_mass[:, None] * result.velocity


@pytest.mark.parametrize("scheme", [EXACT, Scheme()])
def test_reactions_are_those_of_supports(scheme):
    """The first plate of a chain is clamped: with the loads, their resultant changes the momentum,
    and there are none at the joints."""
    model = chain(**MOMENTS["spring"])
    clamped = np.flatnonzero(model.nodes[:, 0] < 1e-9)
    model = replace(model, supports=[Support(clamped, CLAMPED)])
    result = run(model, scheme, end=0.5)
    history = result.history
    change = np.diff(history["linear_momentum"], axis=0) / 0.02
    reaction = history["reaction"][1:]
    assert np.abs(reaction).max() > 1.0
    missed = change - history["load"][1:] - reaction
    assert np.abs(missed).max() < 1e-6 * np.abs(reaction).max()


def test_frames_have_no_reactions_at_joints(tmp_path):
    model = chain(**MOMENTS["spring"])
    clamped = np.flatnonzero(model.nodes[:, 0] < 1e-9)
    path = tmp_path / "run.h5"
    run(replace(model, supports=[Support(clamped, CLAMPED)]), end=0.2, output=path)
    found = read(path)["reaction"]
    assert np.abs(found[-1][clamped]).max() > 0.1
    assert not np.delete(found, clamped, axis=1).any()
    run(model, end=0.2, output=tmp_path / "free.h5")
    assert "reaction" not in read(tmp_path / "free.h5")


@pytest.mark.parametrize("scheme", [EXACT, Scheme()])
def test_forces_of_joints_move_the_plates(scheme):
    """Force of a joint and of the loads on its first plate change the momentum of that plate; the
    second plate has both joints; the moment changes it about the hinge."""
    model = chain(**MOMENTS["spring"])
    result = run(model, scheme, end=0.3,
                 probes={name: JointProbe(name) for name in ("h1", "h2")})
    impulse = {name: 0.02 * result.probes[name]["joint_force"].sum(axis=0) for name in ("h1", "h2")}
    middle = model.nodes[model.quads].mean(axis=1)[:, 0]
    moved, loads = momenta(model, result), 0.02 * result.history["load"].sum(axis=0)
    plates = [np.unique(model.quads[(middle > low) & (middle < low + 2.0)])
              for low in (0.0, 2.0, 4.0)]
    first, second, third = (moved[plate].sum(axis=0) for plate in plates)
    applied = [sum(np.array(load.force) * 0.02 * sum(HAT(0.02 * k + 0.01) for k in range(15))
                   for load in model.loads if load.node in plate) for plate in plates]
    assert np.allclose(sum(applied), loads, rtol=1e-12)
    size = np.abs(impulse["h1"]).max()
    assert size > 0.1
    for found, wanted in ((first - applied[0], impulse["h1"]),
                          (second - applied[1], impulse["h2"] - impulse["h1"]),
                          (third - applied[2], -impulse["h2"])):
        assert np.abs(found - wanted).max() < 1e-8 * size


def test_energies_of_joints_are_those_of_the_run():
    """Stored, done and lost in all hinges: a free chain without loads has no other work or loss."""
    turning = {"turning": TURN, "stiffness": 3.0, "rest": 1.0}
    model = replace(chain(**turning, damping=0.2, torque=0.5, history=HAT), loads=())
    result = run(model, probes={name: JointProbe(name) for name in ("h1", "h2")})
    history = result.history
    for what, whole in (("work", "external_work"), ("lost", "dissipated")):
        assert np.abs(history[whole]).max() > 1e-3
        assert np.allclose(sum(result.probes[name][what] for name in ("h1", "h2")),
                           history[whole], rtol=1e-12, atol=1e-15)
    one = result.probes["h1"]
    assert np.abs(np.diff(one["angle"]) - 0.02 * one["rate"][1:]).max() < 1e-15
    slack = np.minimum(history["time"], 1.0)
    assert np.allclose(one["stored"], 1.5 * (one["angle"] - slack)**2, rtol=1e-4)
    middle = 0.5 * (one["angle"][1:] + one["angle"][:-1] - slack[1:] - slack[:-1])
    pushed = 0.5 * HAT(history["time"][1:] - 0.01) - 3.0 * middle - 0.2 * one["rate"][1:]
    assert np.allclose(one["hinge_moment"][1:], pushed, rtol=1e-9, atol=1e-9)


def test_a_hinge_without_a_moment_has_an_angle():
    """Also beyond half a turn, of a plate that turns about one that is held."""
    model = chain(2)
    joint, = model.joints
    right = np.isin(np.arange(len(model.nodes)), joint.others) | (model.nodes[:, 0] > 2.0)
    v, w = rigid_velocity(model, (0.0, 0.0, 0.0), (0.0, 4.0, 0.0), (2.0, 0.0, 0.0))
    v[~right] = w[~right] = v[list(joint.others)] = 0.0
    held = Support(np.flatnonzero(~right), CLAMPED)
    model = replace(model, loads=(), velocity=v, normal_velocity=w, youngs=2e10,
                    supports=[held], joints=[replace(joint, name="")])
    result = run(model, dt=0.01, probes={"a": JointProbe("joint 0"), "tip": (4.0, 0.0, 0.0)})
    found = result.probes["a"]
    assert np.abs(found["angle"] - 4.0 * result.history["time"]).max() < 0.02
    assert not any(found[what].any() for what in ("hinge_moment", "stored", "work", "lost"))
    assert np.abs(result.probes["tip"]["displacement"][-1] + (2.0, 0.0, 0.0)
                  - (2.0 * np.cos(8.0), 0.0, -2.0 * np.sin(8.0))).max() < 0.05


@pytest.mark.parametrize(("probe", "told"), [
    (lambda: JointProbe(3), "joint must be one line of"),
    (lambda: JointProbe("h9"), "probes: a: joint 'h9' is unknown, must be one of: h1")])
def test_wrong_probes_of_joints(probe, told):
    with pytest.raises(InputError, match=told):
        simulate(chain(), Settings(dt=0.1, end_time=0.1), probes={"a": probe()})


# ------------------------------------------------------------------ statics and rigid limits


def cantilever(k, force=1e-6):
    """Two plates in a line, clamped at x = 0, that a spring holds together at x = 1."""
    mesh = block([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], (8, 2))
    mesh, *sides = cut(mesh, (1, 0, 0), (1, 1, 0))
    clamped = np.flatnonzero(mesh.nodes[:, 0] < 1e-9)
    tip = np.flatnonzero(mesh.nodes[:, 0] > 2.0 - 1e-9)
    loads = [NodalLoad(i, (0.0, 0.0, force * share)) for i, share in zip(tip, (0.25, 0.5, 0.25))]
    return Model.of(mesh, 0.05, 1e9, 0.0, 1000.0, loads=loads, joints=[Hinge(*sides, stiffness=k)],
                    supports=[Support(clamped, CLAMPED)]), tip[1]


def test_a_hinge_that_cannot_turn_is_told():
    """Its supports hold the normals of both plates, as those of ``nodes_at`` a line do."""
    model, _ = cantilever(50.0)
    at = np.flatnonzero(model.nodes[:, 0] <= 1.0)
    with pytest.warns(UserWarning, match="joint 0: supports hold the normals on both of its sides"):
        load_control(replace(model, supports=[Support(at, CLAMPED)]), (1.0,))


@pytest.mark.parametrize("held", ["plate", "edge"])
def test_reactions_at_a_plate_of_a_hinge(held):
    """A plate that hangs from one that is held, all of it or its far edge: reactions of normals at
    the hinge have its moment, in statics, linear too, and in motion, but for what Newton's
    iteration leaves (2e-9; without it 0.2 to 0.4)."""
    model, _ = cantilever(50.0, 1.0)
    at = np.flatnonzero(model.nodes[:, 0] < 1.0)
    if held == "plate":
        at = np.concatenate([at, list(model.joints[0].nodes)])
    model = replace(model, supports=[Support(at, CLAMPED)])
    for result in (load_control(model, (1.0,)), solve_linear(model), simulate(
            model, Settings(dt=0.01, end_time=0.1, scheme=EXACT))):
        assert max(result.balance) < 1e-8


def test_a_cantilever_with_a_torsion_spring():
    """The tip rises by ``P L^3 / (3 E I) + P L / (5/6 G h) + P (L/2)^2 / k``, of width 1; what the
    spring adds is exact on any mesh."""
    tips = {}
    for k in (50.0, 200.0):
        model, tip = cantilever(k)
        path = load_control(model, (0.5, 1.0))
        tips[k] = path.displacement[-1][tip, 2]
        linear = solve_linear(model)
        assert np.isclose(linear.displacement[tip, 2], tips[k], rtol=1e-8)
        bent = 1e-6 * 2.0**3 / (3.0 * 1e9 * 0.05**3 / 12.0) + 1e-6 * 2.0 / (
            5.0 / 6.0 * 0.5e9 * 0.05)
        assert np.isclose(tips[k], bent + 1e-6 / k, rtol=0.005)
        slope = {"spring_angles": (-1.0, 0.0, 1.0), "spring_moments": (-k, 0.0, k)}
        table = replace(model, joints=[replace(model.joints[0], stiffness=0.0, **slope)])
        assert np.isclose(solve_linear(table).displacement[tip, 2], tips[k], rtol=1e-8)
    assert np.isclose(tips[50.0] - tips[200.0], 1e-6 * (1.0 / 50.0 - 1.0 / 200.0), rtol=1e-8)


def test_mechanisms_are_found_and_named():
    """Before anything is computed; each message tells what moves."""
    model, _ = cantilever(0.0)
    told = ("supports and joints leave 1 rigid motion free: of the part with node 5 rotation about "
            "an axis along y: hold them by a Support, or a Hinge by its stiffness")
    for solve in (solve_linear, lambda model: load_control(model, (1.0,))):
        with pytest.raises(InputError, match=told):
            solve(model)
    rest = {"loads": (), "supports": model.supports}
    three = chain(3)
    clamped = np.flatnonzero(three.nodes[:, 0] < 1e-9)
    hung = replace(three, **rest | {"supports": [Support(clamped, CLAMPED)]})
    with pytest.raises(InputError, match="leave 2 rigid motions free: of the part with node 3 rota"
                                         "tion about an axis along y; of the part with node 5 "):
        solve_linear(hung)
    end = np.flatnonzero(three.nodes[:, 0] > 6.0 - 1e-9)
    pinned = [Support([*clamped, *end], ("x", "y", "z"))]
    # three bars between two pins in a line: of first order, both inner hinges move
    with pytest.raises(InputError, match="leave 2 rigid motions free"):
        solve_linear(replace(three, loads=(), supports=pinned))
    held = replace(three, supports=[Support(clamped, CLAMPED)], joints=[
        replace(joint, stiffness=1.0) for joint in three.joints])
    assert np.isfinite(solve_linear(held).displacement).all()
    with pytest.raises(InputError, match="leave 6 rigid motions free: of the part with node 0 tr"):
        solve_linear(replace(held, supports=()))


def test_many_parts_are_looked_at():
    """50 hinged plates between a clamp and a pin: 49 hinges, less what the pin takes, are free."""
    many = chain(50, (1, 1))
    ends = [np.flatnonzero(many.nodes[:, 0] < 1e-9), np.flatnonzero(many.nodes[:, 0] > 99.9)]
    supports = [Support(ends[0], CLAMPED), Support(ends[1], ("x", "y", "z"))]
    with pytest.raises(InputError, match="leave 48 rigid motions free: .*; and of 46 parts more"):
        solve_linear(replace(many, loads=[Gravity((0.0, 0.0, -9.81))], supports=supports))


def test_two_stiff_plates_swing_as_a_double_pendulum():
    assert max(swung()) < 1e-4


# ------------------------------------------------------------------ meshes that are opened


def test_plates_that_are_apart_already():
    """Meshes of files have nodes for each plate: ``cut`` finds them, in the same order."""
    whole = block([(0, 0, 0), (4, 0, 0), (4, 1, 0), (0, 1, 0)], (4, 2))
    opened = cut(whole, (2, 0, 0), (2, 1, 0))
    again = cut(opened.mesh, (2, 0, 0), (2, 1, 0))
    assert again.mesh is opened.mesh and again[1:] == opened[1:]
    assert cut(opened.mesh, (2, 1, 0), (2, 0, 0))[1:] == (opened.others[::-1], opened.nodes[::-1])
    centres = opened.mesh.nodes[opened.mesh.quads].mean(axis=1)[:, 0]
    for side, right in ((opened.nodes, False), (opened.others, True)):
        own = np.isin(opened.mesh.quads, side).any(axis=1)
        assert np.all((centres[own] > 2.0) == right)
    plates = [block([(0, 0, 0), (0, 1, 0), (x, 1, z), (x, 0, z)], (1, 1))
              for x, z in ((1, 0), (-1, 0), (0, 1))]
    fan = Mesh(np.concatenate([plate.nodes for plate in plates]),
               np.concatenate([plate.quads + 4 * k for k, plate in enumerate(plates)]))
    with pytest.raises(InputError, match="3 plates have edges between these points"):
        cut(fan, (0, 0, 0), (0, 1, 0))


def test_plates_that_touch_at_a_corner():
    """Each gets a node of its own."""
    mesh = join([block([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], (2, 2)),
                 block([(2, 1, 0), (4, 1, 0), (4, 2, 0), (2, 2, 0)], (2, 2))])
    opened, nodes = apart(mesh, (2, 1, 0))
    assert len(opened.nodes) == len(mesh.nodes) + 1 and len(nodes) == 2
    assert np.array_equal(opened.nodes[nodes[0]], opened.nodes[nodes[1]])
    assert sorted(np.count_nonzero(opened.quads == node) for node in nodes) == [1, 1]
    assert apart(opened, (2, 1, 0)) == (opened, nodes)
    with pytest.raises(InputError, match=r"one plate only is at \[0.0, 0.0, 0.0\]"):
        apart(mesh, (0, 0, 0))


# ------------------------------------------------------------------ mistakes


def two(**changes):
    """A chain of two plates whose hinge is changed, or with other fields of the model."""
    model = chain(2)
    joint, = model.joints
    return replace(model, joints=[replace(joint, **changes)])


def cornered():
    """A plate whose quarter is cut out, hinged on two edges that meet at a corner."""
    mesh = block([(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)], (2, 2))
    around = [node_at(mesh.nodes, place) for place in ((1, 0, 0), (1, 1, 0), (2, 1, 0))]
    quads, n = np.array(mesh.quads), len(mesh.nodes)
    corner = np.isin(quads, around).sum(axis=1) == 3
    for k, node in enumerate(around):
        quads[corner] = np.where(quads[corner] == node, n + k, quads[corner])
    return Model(np.concatenate([mesh.nodes, mesh.nodes[around]]), quads, 0.1, 1e6, 0.3, 1.0,
                 joints=[Hinge(around, range(n, n + 3))])


def unlike():
    """Plates with different divisions of a common edge."""
    plates = [block([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], (1, 2)),
              block([(1, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0)], (1, 3))]
    n = len(plates[0].nodes)
    edges = [np.flatnonzero(plate.nodes[:, 0] == 1.0) for plate in plates]
    return Hinge(edges[0], edges[1] + n)


def driven():
    model = chain(2)
    return replace(model, supports=[Drive(model.joints[0].nodes, (0.0, 0.0, 0.1), history=HAT)])


def moving():
    model = chain(2)
    velocity = np.zeros(model.nodes.shape)
    velocity[model.joints[0].others[1], 2] = 1.0
    return replace(model, velocity=velocity)


def tilted():
    """Normals that are not at right angles to the hinge."""
    model = chain(2, stiffness=1.0)
    return replace(model, normals=np.tile((0.0, 0.6, 0.8), (len(model.normals), 1)))


def nowhere():
    """An edge from a node to the other at the same place."""
    (one, *_), (other, *_) = chain(2).joints[0].tied.T.tolist()
    return two(nodes=(one, other), others=(other, one))


def within():
    """A spring between both sides of a hinge."""
    model = chain(2)
    return replace(model, attached=[Spring(*model.joints[0].tied[0].tolist(), 1.0)])


def on_the_edge_of_a_sector():
    c, s = np.cos(np.pi / 6.0), np.sin(np.pi / 6.0)
    mesh = block([(1, 0, 0), (2, 0, 0), (2 * c, 2 * s, 0), (c, s, 0)], (2, 1))
    mesh, *sides = cut(mesh, (1.5, 0, 0), (1.5 * c, 1.5 * s, 0))
    return Model.of(mesh, 0.1, 1e6, 0.3, 1.0, joints=[Hinge(*sides)], cyclic=Cyclic(12))


MISTAKES = {
    "one body": (lambda: two(others=chain(2).joints[0].nodes),
                 "h1: node 2 is joined to itself; each plate needs nodes of its own there"),
    "one element": (lambda: replace(chain(2), joints=[Spherical((0, 1))]),
                    "nodes 0 and 1 are 1 m apart, joined nodes must be at the same place"),
    "not at one place": (lambda: two(others=chain(2).joints[0].others[::-1]),
                         "h1: nodes 2 and 1[0-9] are 1 m apart, joined nodes must be at the same"),
    "different lengths": (unlike, "hinge: 3 nodes but 4 others"),
    "one node": (lambda: Hinge((1,), (2,)), r"an edge has two nodes or more, 1 given \(a single"),
    "curved edge": (cornered, "its edge is not straight: place 1 of it lies 0.707 m beside"),
    "axis along nothing": (nowhere, "h1: its edge begins and ends at one place"),
    "normal along the axis": (tilted, "h1: the normal of node 2 is not at right angles to the ax"),
    "edge of a sector": (on_the_edge_of_a_sector, "cyclic: the mesh along the edges differs at"),
    "driven node": (driven, "support 0: a Drive moves node 2, which is joined; hold its plate"),
    "velocities": (moving, "h1: nodes 7 and 1[0-9] start with different velocities"),
    "names twice": (lambda: replace(chain(3), joints=[
        replace(joint, name="a") for joint in chain(3).joints]), "two joints are named 'a'"),
    "stops without stiffness": (lambda: two(stops=(-1.0, 1.0)),
                                r"hinge h1: stop_stiffness must be positive \[N m/rad\]"),
    "stops beside the start": (lambda: two(stops=(0.1, 1.0), stop_stiffness=1.0),
                               "stops must be two angles, the smaller first, with the initial"),
    "latch at the start": (lambda: two(lock=0.0, lock_stiffness=1.0),
                           "hinge h1: lock must not be the initial angle 0: that is no joint"),
    "latch without stiffness": (lambda: two(lock=1.0), "lock_stiffness must be positive"),
    "tables": (lambda: two(spring_angles=(0.0, 1.0)), "h1: 2 spring_angles but 0 spring_moments"),
    "short table": (lambda: two(damper_rates=(1.0,), damper_moments=(1.0,)),
                    "h1: damper_rates must be two or more, one is given"),
    "falling table": (lambda: two(spring_angles=(0.0, 1.0, 0.5), spring_moments=(0.0, 1.0, 2.0)),
                      r"spring_angles must rise, spring_angles\[2\] = 0.5 follows 1"),
    "no damper": (lambda: two(damper_rates=(-1.0, 1.0), damper_moments=(-1.0, -0.5)),
                  r"damper_moments\[1\] = -0.5 N m drives the motion at 1 rad/s"),
    "sticking damper": (lambda: two(damper_rates=(-1.0, 1.0), damper_moments=(-1.0, 3.0)),
                        "damper_moments must be zero at rest, are 1 N m there"),
    "table of words": (lambda: two(spring_angles=("a", "b"), spring_moments=(0.0, 1.0)),
                       r"h1: spring_angles\[0\] must be a number"),
    "no joint": (lambda: replace(chain(2), joints=["h1"]), r"joints\[0\] must be one of Spherical"),
    "a spring in a hinge": (within, r"attached\[0\]: a joint holds nodes 2 and 1[0-9] as far"),
    "a spring along a link": (lambda: replace(
        two(), joints=[*two().joints, RigidLink(0, 5)], attached=[Spring(5, 0, 1.0)]),
        r"attached\[0\]: a joint holds nodes 0 and 5 as far apart as they are"),
    "unjoined": (lambda: replace(chain(2), joints=()), "nodes 2 and 1[0-9] are at the same place"),
    "missing node": (lambda: two(others=(90, 91, 92)), "h1: node 90 does not exist"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes(mistake):
    """Each has an error that tells what is wrong, and where."""
    make, told = MISTAKES[mistake]
    with pytest.raises(InputError, match=told):
        make()


@pytest.mark.filterwarnings("ignore::corovec.AccuracyWarning")
@pytest.mark.parametrize(("scheme", "close", "booked"), [
    (Scheme(rho_inf=0.5), 5e-3, 0.05), (Scheme("newmark"), 0.01, None)])
def test_a_damper_has_its_rate_in_other_schemes(scheme, close, booked):
    """Of a hinge that its spring opens: as in quasi (without it the corner moves by a third more),
    and what it took is what the energy has lost, to the dissipation of the scheme; newmark books
    that to the first order in dt alone."""
    mesh = block([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], (2, 1))
    mesh, *sides = cut(mesh, (1, 0, 0), (1, 1, 0))
    model = Model.of(mesh, 0.05, 1e6, 0.3, 300.0,
                     joints=[Hinge(*sides, stiffness=5.0, rest=0.5, damping=1.0)])
    one, other = (simulate(model, Settings(dt=0.01, end_time=0.4, scheme=scheme),
                           probes={"corner": 0}).history for scheme in (Scheme(), scheme))
    assert other["corner_u"][-1, 2] == pytest.approx(one["corner_u"][-1, 2], rel=close)
    assert total_energy(other)[-1] == pytest.approx(total_energy(one)[-1], rel=close)
    if booked:
        assert other["dissipated"][-1] == pytest.approx(one["dissipated"][-1], rel=booked)
