"""Rigid bodies and joints with multipliers: what they conserve, what they hold, against motions of
rigid bodies integrated otherwise, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from corovec import (
    Ball,
    Cylindrical,
    Damping,
    Drive,
    Expression,
    Gravity,
    InputError,
    JointProbe,
    Mesh,
    Model,
    NodalLoad,
    PointMass,
    Prismatic,
    Revolute,
    RigidBody,
    RigidLink,
    Scheme,
    Settings,
    Spherical,
    Spring,
    Steps,
    Support,
    Tie,
    TimeFunction,
    Universal,
    block,
    join,
    load_control,
    rigid_velocity,
    simulate,
    total_energy,
)
from corovec.solver.dynamics.newton import StepRecord
from corovec.solver.dynamics.settings import Newton
from corovec.solver.dynamics.stepping import Stepper
from corovec.solver.system.exact import ExactSystem
from corovec.solver.system.moving import MovingSystem
from corovec.solver.system.multipliers import Multipliers
from corovec.verification.linked_shells import (
    AXIS,
    KINDS,
    PULSE,
    alone,
    double_pendulum,
    small,
    wings,
)
from corovec.verification.suites.exact import EXACT

GAP = 1e-11


SAMPLE = ("one body", "revolute", "latch", "driven from the ground")


@pytest.mark.parametrize("kind", [kind if kind in SAMPLE else pytest.param(
    kind, marks=pytest.mark.slow) for kind in KINDS])
def test_energy_and_momenta(kind):
    """Energy is work to rounding error, and momenta are impulses, with every joint."""
    balanced(wings(**KINDS[kind]), kind)


def balanced(model, kind):
    """Balances of 0.8 s."""
    history = simulate(model, Settings(dt=0.02, end_time=0.8, scheme=EXACT)).history
    energy = total_energy(history)
    missed = energy - energy[0] - history["external_work"] + history["dissipated"]
    assert np.abs(missed).max() < GAP * energy.max()
    assert history["halvings"].sum() == 0
    if kind == "damper":
        assert history["dissipated"][-1] > 1e-4 * energy.max()
    free = history["time"] > 0.51
    for name, scale in (("linear_momentum", "momentum_scale"),
                        ("angular_momentum", "angular_scale")):
        change = np.abs(history[name][free] - history[name][free][0]).max()
        if model.grounded:
            moved = np.diff(history[name], axis=0) / 0.02
            told = "reaction_moment" if name.startswith("ang") else "reaction"
            acting = "load_moment" if name.startswith("ang") else "load"
            off = moved - history[told][1:] - history[acting][1:]
            assert np.abs(off).max() < 1e-8 * np.abs(moved).max()
        else:
            assert change < GAP * history[scale].max()


def tees(kind, end):
    """Three plates that meet in a line, one end of which a joint ties to ``end``: the same of three
    others, a body, or the ground."""
    corners = [[(0, 0), (1, 0)], [(1, 0), (2, 0)], [(1, 0), (1, 1)]]
    tee = join([block([(a, -.5, c), (b, -.5, d), (b, .5, d), (a, .5, c)], (2, 2))
                for (a, c), (b, d) in corners])
    one, bodies, mesh = int(tee.nodes_at(x=1.0, y=0.5, z=0.0)[0]), [], tee
    place = tee.nodes[one]
    other = len(tee.nodes) + one if end == "plates" else end
    if end == "plates":
        turned = place + Rotation.from_rotvec((0.4, 0.3, 1.2)).apply(tee.nodes - place)
        mesh = Mesh(np.r_[tee.nodes, turned], np.r_[tee.quads, tee.quads + len(tee.nodes)])
    elif end == "body":
        bodies = [RigidBody("body", 20.0, (2.0, 3.0, 4.0), (1.2, 1.3, 0.1))]
    joint = {"ball": lambda: Ball(one, other), "revolute": lambda: Revolute(one, other, None, AXIS),
             "universal": lambda: Universal(one, other, None, (1, 0, 0), (0, 1, 0)),
             "cylindrical": lambda: Cylindrical(one, other, None, AXIS),
             "prismatic": lambda: Prismatic(one, other, None, AXIS),
             "spring": lambda: Revolute(one, other, None, AXIS, stiffness=4.0, rest=0.5),
             "table": lambda: Revolute(one, other, None, AXIS, rest=0.5, spring_angles=(-0.4, 0, 1),
                                       spring_moments=(-3, 0, 1), damper_rates=(-1, 0, 1),
                                       damper_moments=(-1, 0, 2)),
             "drive": lambda: Revolute(one, other, None, AXIS, 0.5, Expression("1-cos(t)"))}[kind]()
    far = [int(np.argmin(np.linalg.norm(mesh.nodes - at, axis=1))) for at in (
        (2, -0.5, 0), (1, -0.5, 1))]
    loads = [NodalLoad(i, f, PULSE) for i, f in zip(far, ((0, 1, 16.0), (6.0, 2, 3)))]
    return Model.of(mesh, 0.02, 2e8, 0.3, 1000.0, loads=loads, joints=[joint], bodies=bodies)


@pytest.mark.parametrize("end", ["plates", "body", "ground"])
@pytest.mark.parametrize("kind", ["table", *(
    pytest.param(kind, marks=pytest.mark.slow) for kind in (
        "ball", "revolute", "universal", "cylindrical", "prismatic", "spring", "drive"))])
def test_ends_where_plates_meet(kind, end):
    """A node with several normals turns as a body does: joints hold its axes, moments turn it."""
    balanced(tees(kind, end), kind)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_constraints_where_plates_meet(kind):
    worst = np.max([missed(*at) for at in steps(tees(kind, "plates"), 0.02, 60)], axis=0)
    assert worst[0] < 1e-13 and worst[1] < 1e-12


def test_a_drive_that_begins_with_the_cube_of_time():
    """The plates of a drive at rest: its first rates are those of rounding and of differences."""
    model = wings([Revolute("ground", "b", (0, 0, 0), AXIS, 1.0, Expression("t**3"), name="drive"),
                   Ball("a", "b", (0, 0, 0))], loads=False)
    result = simulate(model, Settings(dt=0.02, end_time=0.1, scheme=EXACT),
                      probes={"drive": JointProbe("drive")})
    np.testing.assert_allclose(result.probes["drive"]["angle"], result.history["time"]**3,
                               atol=1e-14)


def steps(model, dt, n):
    """System, and state after each of n steps."""
    system = ExactSystem(model)
    stepper, state = Stepper(system, EXACT, Newton()), system.initial_state()
    place = system.observe(state)
    for k in range(n):
        stepper.advance(state, place, k * dt, dt, StepRecord())
        yield system, state


def missed(system, state):
    """Constraints and their rates, each relative to its parts."""
    linked = system.linked
    linked.begin(state)
    one, other = linked._pairs[:linked._m].T
    u = linked._u[0]
    off = np.abs(np.sum(u[one] * u[other], axis=1) - linked._values) / linked._scale[:linked._m]
    rates = linked._G_0 @ state.velocity[linked.dofs]
    return off.max(), np.abs(rates).max() / np.abs(state.velocity[system.translations]).max()


@pytest.mark.parametrize("kind", ["link", *(pytest.param(kind, marks=pytest.mark.slow) for kind in (
    "one body", "revolute", "prismatic", "ground"))])
def test_constraints_and_rates(kind):
    worst = np.max([missed(*at) for at in steps(wings(**KINDS[kind]), 0.02, 60)], axis=0)
    assert worst[0] < 1e-13 and worst[1] < 1e-12


def test_rates_need_impulses(monkeypatch):
    """Without them rates of constraints alternate and grow; energy and momenta would not tell."""
    begin = Multipliers.begin

    def without(self, *arguments):
        begin(self, *arguments)
        self._work.impulse[:] = 0.0

    monkeypatch.setattr(Multipliers, "begin", without)
    monkeypatch.setattr(Multipliers, "settle", lambda *arguments: np.zeros(0))
    worst = [missed(*at)[1] for at in steps(wings(**KINDS["link"]), 0.02, 60)]
    assert max(worst) > 1e-5


@pytest.mark.slow
def test_gradients_at_the_end_gain_energy(monkeypatch):
    """Constraint forces along the gradient at the end of a step do work."""
    class AtEnd(Multipliers):
        def __init__(self, system):
            super().__init__(system)
            constrain = self._constrain

            def at_end(*arguments):
                constrain(*arguments[:-1], 0.0 * arguments[-1])
                self._u[0], self._d[0] = self._u[1], self._d[1]
                return constrain(*arguments)

            self._constrain = at_end

    monkeypatch.setattr("corovec.solver.system.exact.Multipliers", AtEnd)
    history = simulate(wings(**KINDS["link"]), Settings(dt=0.02, end_time=1.0,
                                                        scheme=EXACT)).history
    energy = total_energy(history)
    assert np.abs(energy - history["external_work"]).max() > 1e-6 * energy.max()


@pytest.mark.slow
def test_second_order():
    """Distance from a run with a small step falls as dt^2."""
    def tip(dt):
        *_, (system, state) = steps(wings(**KINDS["revolute"]), dt, round(0.6 / dt))
        return state.x.copy()

    exact = tip(0.0025)
    errors = [np.abs(tip(dt) - exact).max() for dt in (0.02, 0.01)]
    assert 3.0 < errors[0] / errors[1] < 6.0


# ------------------------------------------------------------------ rigid bodies

@pytest.mark.slow
def test_free_top():
    """An asymmetric body that tumbles about its middle axis follows Euler's equations."""
    inertia, spin = np.array([2.0, 3.0, 4.0]), np.array([0.05, 2.0, 0.02])
    model = alone([RigidBody("top", 5.0, inertia, (0.0, 0.0, 0.0))])
    velocity = np.zeros((5, 3))
    velocity[4] = 0.5, 0.0, 0.0
    rates = np.zeros((7, 3))
    rates[4:] = np.cross(spin, np.eye(3))
    model = alone([RigidBody("top", 5.0, inertia, (0.0, 0.0, 0.0))], velocity=velocity,
                  normal_velocity=rates)

    def euler(t, y):
        R, w = y[:9].reshape(3, 3), y[9:]
        return np.r_[np.cross(w @ R, R).ravel(), np.cross(inertia * w, w) / inertia]

    end = 6.0
    path = solve_ivp(euler, (0.0, end), np.r_[np.eye(3).ravel(), spin], method="DOP853",
                     rtol=1e-12, atol=1e-12)
    exact, errors = path.y[:9, -1].reshape(3, 3), []
    for dt in (0.02, 0.01):
        result = simulate(model, Settings(dt=dt, end_time=end, scheme=EXACT))
        errors.append(np.abs(result.directors[4:] - exact).max())
        np.testing.assert_allclose(result.displacement[4], (0.5 * end, 0.0, 0.0), atol=1e-12)
    assert errors[1] < 5e-3 and 3.8 < errors[0] / errors[1] < 4.2


@pytest.mark.slow
def test_double_pendulum():
    """Two bodies on revolute joints fall from a horizontal line as Lagrange's equations say."""
    bodies = [RigidBody("one", 2.0, (0.3, 0.3, 0.3), (1.0, 0.0, 0.0)),
              RigidBody("two", 1.5, (0.2, 0.2, 0.2), (1.8, 0.0, 0.0))]
    joints = [Revolute("ground", "one", (0, 0, 0), (0, 1, 0)),
              Revolute("one", "two", (1.0, 0, 0), (0, 1, 0))]
    model = alone(bodies, joints, loads=[Gravity((0, 0, -9.81))])
    p, q = double_pendulum(1.0)
    exact = np.array([[np.sin(p), 0.0, -np.cos(p)]])
    exact = np.r_[exact, exact + 0.8 * np.array([[np.sin(q), 0.0, -np.cos(q)]])]
    errors = []
    for dt in (0.005, 0.0025):
        result = simulate(model, Settings(dt=dt, end_time=1.0, scheme=EXACT))
        errors.append(np.abs(result.displacement[4:] + model.nodes[4:] - exact).max())
        energy = total_energy(result.history)
        assert np.abs(energy - energy[0] - result.history["external_work"]).max() < 1e-11 * 30.0
    assert errors[1] < 1e-4 and 3.8 < errors[0] / errors[1] < 4.2


@pytest.mark.slow
def test_tie():
    """Plates with edges that do not match move as one plate does."""
    def tip(model, place):
        node = int(np.argmin(np.linalg.norm(model.nodes - place, axis=1)))
        load = NodalLoad(node, (0, 0, 4.0), PULSE)
        model = Model(model.nodes, model.quads, 0.02, 2e8, 0.3, 1000.0, loads=[load],
                      joints=model.joints)
        result = simulate(model, Settings(dt=0.01, end_time=1.0, scheme=EXACT))
        energy = total_energy(result.history)
        assert np.abs(energy - result.history["external_work"]).max() < GAP * energy.max()
        return result.displacement[node]

    def half(x, divisions):
        return block(np.array([[x, 0, 0], [x + 1, 0, 0], [x + 1, 1, 0], [x, 1, 0]]), divisions)

    one, two = half(0.0, (4, 4)), half(1.0, (4, 3))
    x = np.r_[one.nodes, two.nodes]
    on = np.flatnonzero(np.abs(x[:, 0] - 1.0) < 1e-12)
    line, nodes = on[on < len(one.nodes)], on[on >= len(one.nodes)]
    tied = Model(x, np.r_[one.quads, two.quads + len(one.nodes)], 0.02, 2e8, 0.3, 1000.0,
                 joints=[Tie(nodes.tolist(), line.tolist())])
    whole = block(np.array([[0.0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]]), (8, 4))
    whole = Model.of(whole, 0.02, 2e8, 0.3, 1000.0)
    u, v = tip(tied, (2, 1, 0)), tip(whole, (2, 1, 0))
    assert np.linalg.norm(u - v) < 0.02 * np.linalg.norm(v)


# ------------------------------------------------------------------ probes

def probed_joint(body, joint, loads=(), end_time=0.2):
    """History of a joint of one body that hangs at (1, 0, 0) or stands there, and its centre."""
    model = alone([body], [joint], loads=loads)
    return simulate(model, Settings(dt=0.01, end_time=end_time, scheme=EXACT),
                    probes={"it": JointProbe("it"), "body": 4}).history


@pytest.mark.parametrize("ends", [("ground", "body"), ("body", "ground")])
def test_force_on_a_body_that_hangs(ends):
    """At rest under its weight, below a ball joint: m g upwards on the body, at either end."""
    body = RigidBody("body", 2.0, (0.3, 0.3, 0.3), (1.0, 0.0, -0.7))
    told = probed_joint(body, Ball(*ends, (1.0, 0.0, 0.0), name="it"), [Gravity((0, 0, -9.81))])
    np.testing.assert_allclose(told["it_force"][1:], [[0.0, 0.0, 2.0 * 9.81]] * 20, atol=1e-9)
    np.testing.assert_allclose(told["body_u"], 0.0, atol=1e-12)
    assert np.all(told["it_angle"] == 0.0) and np.all(told["it_moment"] == 0.0)


def test_force_between_bodies():
    """The force is that on ``other``: of two bodies that hang in a row the lower one is held, and
    the upper one carries both."""
    bodies = [RigidBody("upper", 2.0, (0.3, 0.3, 0.3), (1.0, 0.0, -0.7)),
              RigidBody("lower", 3.0, (0.3, 0.3, 0.3), (1.0, 0.0, -1.9))]
    joints = [Ball("ground", "upper", (1.0, 0.0, 0.0), name="top"),
              None]
    for other, sign in (("lower", 1.0), ("upper", -1.0)):
        joints[1] = Ball({"lower": "upper", "upper": "lower"}[other], other, (1.0, 0.0, -1.2),
                         name="down")
        told = simulate(alone(bodies, joints, loads=[Gravity((0, 0, -9.81))]),
                        Settings(dt=0.01, end_time=0.1, scheme=EXACT),
                        probes={"top": JointProbe("top"), "down": JointProbe("down")}).history
        np.testing.assert_allclose(told["top_force"][1:, 2], 5.0 * 9.81, rtol=1e-10)
        np.testing.assert_allclose(told["down_force"][1:, 2], sign * 3.0 * 9.81, rtol=1e-10)


@pytest.mark.parametrize(("ends", "sense"), [(("ground", "body"), 1.0), (("body", "ground"), -1.0)])
def test_a_motor_turns_other_positively(ends, sense):
    """A torque T turns ``other`` against ``one`` by T t^2/(2 I) about the axis, I of the body about
    it; the force on the body is that towards the axis, m r w^2, and m r dw/dt across."""
    body = RigidBody("body", 2.0, (0.3, 0.3, 0.3), (1.5, 0.0, 0.0))
    joint = Revolute(*ends, (1.0, 0.0, 0.0), (0, 0, 1), name="it", torque=1.6)
    told = probed_joint(body, joint)
    t, rate = told["time"], 1.6 / (0.3 + 2.0 * 0.5**2)
    angle = 0.5 * rate * t**2
    np.testing.assert_allclose(told["it_angle"], angle, atol=1e-5)
    np.testing.assert_allclose(told["it_moment"][1:], 1.6, rtol=1e-9)
    np.testing.assert_allclose(told["it_rate"][1:], np.diff(told["it_angle"]) / 0.01, rtol=1e-9)
    np.testing.assert_allclose(told["it_work"], 1.6 * told["it_angle"], atol=1e-12)
    place = np.c_[np.cos(angle), sense * np.sin(angle), 0.0 * t]
    np.testing.assert_allclose(told["body_u"], 0.5 * (place - [1.0, 0.0, 0.0]), atol=1e-5)
    mid = 0.5 * (t[1:] + t[:-1])
    angle, spin = 0.5 * rate * mid**2, rate * mid
    along, across = (np.c_[np.cos(angle), sense * np.sin(angle)],
                     np.c_[-np.sin(angle), sense * np.cos(angle)])
    force = 2.0 * 0.5 * (rate * across - spin[:, None]**2 * along)
    np.testing.assert_allclose(told["it_force"][1:, :2], force, atol=2e-3)


@pytest.mark.parametrize(("ends", "sense"), [(("ground", "body"), 1.0), (("body", "ground"), -1.0)])
def test_slides_and_couples(ends, sense):
    """A body on a slope of a rail beside it: it slides by g_x t^2/2, its weight across the rail is
    carried by a force, and the moment of that about the rail by a couple on the body."""
    body = RigidBody("body", 2.0, (0.3, 0.3, 0.3), (1.0, 0.4, 0.0))
    told = probed_joint(body, Prismatic(*ends, (1.0, 0.0, 0.0), (1, 0, 0), name="it"),
                        [Gravity((3.0, 0.0, -9.81))])
    t = told["time"]
    np.testing.assert_allclose(told["it_slide"], sense * 1.5 * t**2, atol=1e-12)
    np.testing.assert_allclose(told["it_speed"][1:], np.diff(told["it_slide"]) / 0.01, atol=1e-12)
    np.testing.assert_allclose(told["it_force"][1:], [[0.0, 0.0, 19.62]] * 20, atol=1e-9)
    couple = -np.cross((0.0, 0.4, 0.0), (0.0, 0.0, -19.62))
    np.testing.assert_allclose(told["it_couple"][1:], [couple] * 20, atol=1e-8)
    assert not told["it_angle"].any() and not told["it_moment"].any()


@pytest.mark.parametrize("kind", [Revolute, Cylindrical])
def test_joints_without_a_moment_tell_their_angle(kind):
    """A pendulum that swings freely through more than half a turn: its angle is that of its place,
    by whole turns; it has no couple about its axis, and a force alone elsewhere."""
    body = RigidBody("body", 2.0, (0.01, 0.01, 0.01), (1.5, 0.0, 0.0))
    told = probed_joint(body, kind("ground", "body", (1.0, 0.0, 0.0), (0, 1, 0), name="it"),
                        [Gravity((0, -0.0, -9.81)), Gravity((-4.0, 0.0, 0.0))], end_time=1.2)
    place = told["body_u"] + (0.5, 0.0, 0.0)
    angle = np.unwrap(np.arctan2(-place[:, 2], place[:, 0]))
    np.testing.assert_allclose(told["it_angle"], angle, atol=1e-9)
    assert told["it_angle"].max() > 3.3
    np.testing.assert_allclose(told["it_rate"][1:], np.diff(told["it_angle"]) / 0.01, rtol=1e-9)
    np.testing.assert_allclose(told["it_couple"], 0.0, atol=1e-7)
    np.testing.assert_allclose(told["it_slide"], 0.0, atol=1e-12)


@pytest.mark.parametrize(("ends", "sense"), [(("ground", "body"), 1), (("body", "ground"), -1)])
def test_angles_of_a_cross(ends, sense):
    """A body that tumbles at a universal joint: turns about both axes, by these angles, make its
    attitude."""
    body = RigidBody("body", 2.0, (0.02, 0.03, 0.04), (1.3, 0.2, 0.1))
    axes = (0.0, 0.6, 0.8), (1.0, 0.0, 0.0)
    model = alone([body], [Universal(*ends, (1.0, 0.0, 0.0), *axes, name="it")],
                  loads=[Gravity((3.0, 2.0, -9.81))])
    result = simulate(model, Settings(dt=0.01, end_time=0.5, scheme=EXACT),
                      probes={"it": JointProbe("it")})
    told = result.history
    first, other = told["it_angle"][-1], told["it_second"][-1]
    assert min(abs(first), abs(other)) > 0.3
    turned = Rotation.from_rotvec(first * np.array(axes[0])) * (
        Rotation.from_rotvec(other * np.array(axes[1])))
    np.testing.assert_allclose((turned.as_matrix() if sense > 0 else turned.inv().as_matrix()).T,
                               result.directors[-3:], atol=1e-11)
    np.testing.assert_allclose(told["it_second_rate"][1:], np.diff(told["it_second"]) / 0.01,
                               rtol=1e-9)


def test_moment_of_a_drive():
    """A revolute joint whose angle grows as a t^2/2: its moment is I a, the angle is that."""
    body = RigidBody("body", 2.0, (0.3, 0.3, 0.4), (1.0, 0.0, 0.0))
    told = probed_joint(body, Revolute("ground", "body", (1.0, 0.0, 0.0), (0, 0, 1), 0.5,
                                       Expression("t**2"), name="it"))
    np.testing.assert_allclose(told["it_angle"], 0.5 * told["time"]**2, atol=1e-12)
    np.testing.assert_allclose(told["it_moment"][1:], 0.4, rtol=1e-4)


# ------------------------------------------------------------------ refused

@pytest.mark.parametrize("joints, message", [
    ([Ball("a", "c", (0, 0, 0))], "'c' is no body, must be one of: a, b, ground"),
    ([Ball("a", "b")], "at is missing"),
    ([Ball("ground", "ground2", (0, 0, 0))], "'ground2' is no body"),
    ([Ball("a", 700, (0, 0, 0))], "node 700 does not exist"),
    ([Ball("a", 2, (0, 0, 0))], "node 2 is at .* the joint at"),
    ([RigidLink("a", "b", (0, 0, 0), (0, 0, 0))], "both points are at"),
    ([RigidLink(2, "b", (9, 9, 9), (0, 0, 0.1))], "node 2 is at .* the joint at"),
    ([Spherical([2, 30])], "node 30 is that of a rigid body"),
    ([Ball("a", "b", (0, 0, 0), name="x"), Ball("a", "b", (0, 0, 0.5), name="x")],
     "two joints are named 'x'"),
])
def test_wrong_ends(joints, message):
    with pytest.raises(InputError, match=message):
        simulate(wings(joints), Settings(dt=0.02, end_time=0.02, scheme=EXACT))


def test_redundant():
    """Two revolute joints on one axis hold what one does: both are named."""
    joints = [Revolute("a", "b", (0, 0, 0), (0, 1, 0), name="front"),
              Revolute("a", "b", (0, 0.4, 0), (0, 1, 0), name="back")]
    with pytest.raises(InputError, match="back, front: 5 of their constraints follow from the"):
        ExactSystem(wings(joints))


def test_a_loop_in_a_plane():
    """Four revolute joints of parallel axes hold three motions twice."""
    corners = np.array([(0, 0, 0), (0, 0.3, 0), (1, 0.7, 0), (1, 0, 0)], dtype=float)
    bodies = [RigidBody(name, 1.0, (0.1, 0.1, 0.1), centre) for name, centre in zip(
        ("crank", "coupler", "rocker"), 0.5 * (corners[1:] + corners[:-1]))]
    ends = ("ground", "crank", "coupler", "rocker", "ground")
    joints = [Revolute(*pair, at, (0, 0, 1), name=name) for *pair, at, name in zip(
        ends, ends[1:], corners, "ABCD")]
    with pytest.raises(InputError, match="A, B, C, D: 3 of their constraints follow from the"):
        ExactSystem(alone(bodies, joints))


BODY = RigidBody("body", 2.0, (0.3, 0.3, 0.3), (1.0, 0.0, 0.0))
STRAY = RigidBody("stray", 2.0, (0.3, 0.3, 0.3), (1.0, 0.0, 0.0), [77])
MISTAKES = {
    "one body": (lambda: Ball("a", "a", (0, 0, 0), name="neck"), "neck: both ends are 'a'"),
    "no axis": (lambda: Revolute("a", "b", (0, 0, 0), name="neck"), "neck: axis is missing"),
    "axis of nothing": (lambda: Prismatic("a", "b", (0, 0, 0), (0, 0, 0), name="neck"),
                        "prismatic joint neck: axis must not be zero"),
    "cross that is none": (lambda: Universal("a", "b", (0, 0, 0), (1, 0, 0), (1, 1, 0)),
                           "axis and other_axis must be at right angles"),
    "no number": (lambda: Ball("a", "b", (0, np.nan, 0)), r"at\[1\] must be finite"),
    "stops beside the start": (
        lambda: Revolute("a", "b", (0, 0, 0), AXIS, stops=(0.1, 1.0), stop_stiffness=1.0,
                         name="neck"), r"neck: stops must be two angles, .*\(0.1, 1.0\)"),
    "drive and spring": (lambda: Revolute("a", "b", (0, 0, 0), AXIS, 0.5, stiffness=1.0),
                         "a joint that is driven by its angle has no spring"),
    "spring in a body": (
        lambda: alone([replace(BODY, nodes=(0, 3))], [], attached=[Spring(3, 0, 1.0)]),
        "body body carries nodes 0 and 3, a spring between them does nothing"),
    "drive off the start": (
        lambda: simulated(Revolute("ground", "body", (0, 0, 0), AXIS, 0.5, name="neck")),
        "neck: angle times driving begins 0.5 rad off the angle that the joint has"),
    "drive without an angle": (
        lambda: Revolute("a", "b", (0, 0, 0), AXIS, driving=PULSE, name="neck"),
        "neck: driving needs an angle"),
    "drive that jumps": (
        lambda: driven(Steps((0.0, 0.03), (0.0, 1.0))),
        "neck: its time function jumps at t = 0.04 s, a joint cannot: give the points of a ramp"),
    "drive that begins fast": (
        lambda: driven(Expression("t")),
        "neck: its drive begins at 0.5 rad/s, the initial velocities turn it at 0 rad/s: let it"),
    "ramp that begins fast": (
        lambda: driven(TimeFunction((0.0, 1.0), (0.0, 1.0))),
        "neck: its drive begins at 0.5 rad/s, the initial velocities turn it at 0 rad/s: let it"),
    "probe with a column of the run": (
        lambda: simulate(alone([BODY], [Ball("ground", "body", (0, 0, 0), name="neck")]),
                         Settings(dt=0.02, end_time=0.1, scheme=EXACT),
                         probes={"load": JointProbe("neck")}),
        "probes: load: its column load_moment is one of the run: take another name"),
    "ends of the ground": (lambda: Ball("ground", "ground", (0, 0, 0)), "both ends are 'ground'"),
    "point of the ground": (lambda: simulated(RigidLink("body", "ground", (0, 0, 0), name="rod")),
                            "rod: its point of the ground is missing"),
    "held by a support": (
        lambda: ExactSystem(Model.of(small(), 1e-3, 1e6, 0.3, 1e-3, supports=[Support(
            [0], ("x", "y", "z"))], joints=[Ball(0, "ground", name="pin")])),
        "pin: supports hold what it joins already"),
    "carried already": (lambda: ExactSystem(wings([Ball("a", 0, name="neck")])),
                        "body a, neck: 3 of their constraints follow from the others"),
    "stray node": (lambda: alone([STRAY]), "body stray: node 77 does not exist"),
    "driven in statics, no support": (
        lambda: load_control(alone([BODY], [Revolute("ground", "body", (0, 0, 0), AXIS, 0.5,
                                                     Expression("t**2"))]), (1.0,)),
        "the supports leave 6 rigid motions of the part with node 0 free, translation along x, y"),
}


@pytest.mark.parametrize("text", ["1-cos(6*t)", "90*(1-cos(0.3*t))", "sqrt(1+t**2)-1"])
def test_a_drive_from_rest(text):
    """Rounding of its values, over 1e-7 s, is no rate (that of the first would be 3e-10 rad/s)."""
    angle = 0.01 if text.startswith("90") else 0.5
    model = alone([BODY], [Revolute("ground", "body", BODY.centre, AXIS, angle, Expression(text))])
    simulate(model, Settings(dt=0.02, end_time=0.02, scheme=EXACT))


def test_work_of_a_pulse():
    """A body that is turned to and fro, up to 85 rad/s: energy is work at every step, also where a
    correction is no smaller than the one before (the steps at 9.5 and 12 ms missed 2e-5 and 5e-4 J
    of 2e3 J)."""
    model = alone([replace(BODY, inertia=(0.3, 0.3, 0.4))], [Revolute(
        "ground", "body", (0, 0, 0), (0, 0, 1), 0.1, Expression("exp(-((t-0.0101)/0.002)**2)"))])
    result = simulate(model, Settings(dt=5e-4, end_time=0.015, scheme=EXACT))
    assert result.energy_balance < 1e-12


def test_a_ramp_that_is_met():
    """A drive that begins with the spin that the body has, and goes on with it: it does no
    work."""
    model = alone([BODY], [Revolute("ground", "body", BODY.centre, AXIS, 0.5,
                                    TimeFunction((0.0, 1.0), (0.0, 1.0)), name="neck")])
    spin = 0.5 * np.array(model.joints[0].axis)
    velocity, rates = rigid_velocity(model, (0.0, 0.0, 0.0), spin, BODY.centre)
    model = replace(model, velocity=velocity, normal_velocity=rates)
    told = simulate(model, Settings(dt=0.02, end_time=0.1, scheme=EXACT),
                    probes={"neck": JointProbe("neck")}).history
    np.testing.assert_allclose(told["neck_angle"], 0.5 * told["time"], atol=1e-14)
    assert np.abs(told["neck_work"]).max() < 1e-12


def simulated(joint):
    return simulate(alone([BODY], [joint]), Settings(dt=0.02, end_time=0.1, scheme=EXACT))


def driven(driving):
    return simulated(Revolute("ground", "body", (0, 0, 0), AXIS, 0.5, driving, name="neck"))


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes(mistake):
    """Each has an error that tells what is wrong, and of which joint."""
    make, told = MISTAKES[mistake]
    with pytest.raises(InputError, match=told):
        make()


def test_axis_of_a_shell_node():
    model = wings([Revolute(3, "b", None, (1, 0, 0))], loads=False)
    with pytest.raises(InputError, match="node 3 of a shell has a normal only"):
        ExactSystem(model)
    model = wings([Revolute(3, "b", None, (0, 0, 1), stiffness=1.0)], loads=False)
    with pytest.raises(InputError, match="does not know turns about its normal"):
        ExactSystem(model)


@pytest.mark.parametrize("scheme", ["exact", "quasi"])
def test_a_spin_about_a_bearing_fits(scheme):
    """Of a body with oblique axes: no node moves along the bearing, but for rounding."""
    mesh = block([(0.1, 0, 0), (0.3, 0, 0), (0.3, 0.4, 0), (0.1, 0.4, 0)], (1, 1))
    body = RigidBody("b", 3.0, (0.05, 0.08, 0.06), (0.2, 0.0, 0.1), range(4),
                     axes=[[1, 0, 0], [0, 0.8, 0.6], [0, -0.6, 0.8]])
    model = Model.of(mesh, 0.02, 2e8, 0.3, 1000.0, bodies=[body],
                     joints=[Revolute("ground", "b", (0, 0, 0), (0, 0, 1))])
    velocity, rates = rigid_velocity(model, (0, 0, 0), (0, 0, 10.0), about=(0, 0, 0))
    model = replace(model, velocity=velocity, normal_velocity=rates)
    system = {"exact": ExactSystem, "quasi": MovingSystem}[scheme](model)
    assert np.abs(system.initial_state().velocity).max() > 1.0


def test_velocities_that_do_not_fit():
    model = wings([Ball("a", "b", (0, 0, 0), name="neck")])
    velocity, rates = rigid_velocity(model, (0, 0, 0), (0, 1.0, 0))
    ExactSystem(wings([Ball("a", "b", (0, 0, 0))], velocity=velocity,
                      normal_velocity=rates)).initial_state()
    velocity = velocity.copy()
    velocity[-1] += 1.0
    model = wings([Ball("a", "b", (0, 0, 0), name="neck")], velocity=velocity,
                  normal_velocity=rates)
    with pytest.raises(InputError, match="(neck|body b): the initial velocities of what it joins"):
        ExactSystem(model).initial_state()


@pytest.mark.parametrize("scheme", [Scheme("newmark"), Scheme("quasi", 0.8)])
def test_other_schemes_refuse(scheme):
    with pytest.raises(InputError, match="need the scheme exact, or quasi with rho_inf = 1"):
        simulate(wings(loads=False), Settings(dt=0.02, end_time=0.02, scheme=scheme))


@pytest.mark.parametrize("values, message", [
    (dict(mass=0.0), "mass must be positive"),
    (dict(inertia=(1.0, 1.0, 3.0)), "belong to no body"),
    (dict(name="ground"), "can be named 'ground'"),
    (dict(axes=((1, 0, 0), (1, 1, 0), (0, 0, 1))), "three orthogonal vectors"),
])
def test_no_body(values, message):
    with pytest.raises(InputError, match=message):
        RigidBody(**{"name": "a", "mass": 1.0, "inertia": (1.0, 1.0, 1.0),
                     "centre": (0, 0, 0), **values})


@pytest.mark.parametrize("values, message", [
    (dict(damping=Damping(mass=1.0)), "mass acts on the shell alone"),
    (dict(attached=[PointMass(31, 1.0)]), "node 31 is that of a rigid body"),
])
def test_what_bodies_do_not_know(values, message):
    with pytest.raises(InputError, match=message):
        wings([Ball("a", "b", (0, 0, 0))], **values)


# ------------------------------------------------------------------ supports of what joints hold

ROCKING = Expression("1-cos(3*t)")
HELD = {
    "clamped body": Support([30], ("x", "y", "z", "px", "py", "pz")),
    "one direction of a body": Support([30], ("px",)),
    "a carried node": Support([0], ("x", "y", "z", "px", "py", "pz")),
}


@pytest.mark.parametrize("scheme", [EXACT, Scheme()], ids=["exact", "quasi"])
@pytest.mark.parametrize("kind", HELD)
def test_reactions_have_what_joints_pass_on(kind, scheme):
    """Momenta change by the impulses of loads and supports, also where these hold a body or what it
    carries (without the moments of joints: 2e-2 of the largest in a step)."""
    model = wings([Revolute("a", "b", (0, 0, 0), AXIS)], supports=[HELD[kind]])
    history = simulate(model, Settings(dt=0.02, end_time=0.4, scheme=scheme)).history
    for momentum, reaction, load, scale in (
            ("linear_momentum", "reaction", "load", "momentum_scale"),
            ("angular_momentum", "reaction_moment", "load_moment", "angular_scale")):
        off = np.diff(history[momentum], axis=0) - 0.02 * (history[reaction] + history[load])[1:]
        assert np.abs(off).max() < 1e-6 * history[scale].max()


@pytest.mark.parametrize("moved", [Support([30], ("x", "y", "z"), 0.2, ROCKING),
                                   Drive([30], (0.1, 0, 0.2), (0.2, 0.3, 0.1), (0, 0, 0), ROCKING)],
                         ids=["shifted", "driven"])
def test_work_of_supports_that_move_bodies(moved):
    """It is all that the energy changes by (4e-3 off without that of impulses, and where rates of
    constraints do not follow the supports)."""
    model = wings([Revolute("a", "b", (0, 0, 0), AXIS)], supports=[moved], loads=False)
    history = simulate(model, Settings(dt=0.02, end_time=0.4, scheme=EXACT)).history
    energy = total_energy(history)
    missed = energy - history["external_work"] - history["support_work"]
    assert energy.max() > 1.0 and np.abs(missed).max() < 1e-11 * energy.max()
