"""Loads without a potential: what they are, their derivatives, their work in both schemes."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from corovec import (
    Drag,
    Drive,
    Expression,
    FollowerForce,
    Gravity,
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
    StaticSettings,
    StepError,
    Steps,
    Support,
    TimeFunction,
    UserForce,
    load_control,
    rigid_velocity,
    simulate,
    solve_linear,
    total_energy,
)
from corovec.solver.kernels.arguments import STATIC
from corovec.solver.model.nonconservative import identity
from corovec.solver.modes.matrices import sparse_system
from corovec.solver.runtime.provenance import fingerprint
from corovec.verification.helpers import assemble, central_differences
from corovec.verification.models import folded, rectangle, warped_patch
from corovec.verification.shells import CLAMPED

SCHEMES = ("quasi", "exact")
PULSE = TimeFunction((0.0, 0.5, 1.0), (0.0, 1.0, 0.0))
FOLD = 7
"""A node of the junction of ``folded``."""


def swirl(t, x, v, p):
    """Neither of a potential nor against the velocity."""
    return np.cross((0.0, 0.1, np.cos(t)), x) - 0.02 * np.linalg.norm(v, axis=1, keepdims=True) * v


def blown(t, x, v, p):
    """Along the normals of smooth nodes."""
    return 0.2 * np.sin(3.0 * t) * p


def flying(loads, **options):
    """A plate that is pushed, and turns."""
    return rectangle(2.0, 1.0, (4, 2), loads=[NodalLoad(2, (0.5, 1.0, 10.0), PULSE), *loads],
                     **options)


LOADS = {
    "follower": [FollowerForce(0, 5.0, PULSE)],
    "drag": [Drag(1.0, 0.5)],
    "wind": [Drag(1.0, 0.5, [0, 1, 5], (3.0, 1.0, 2.0))],
    "user": [UserForce(swirl), UserForce(blown, PULSE)],
}


def missed(result):
    """Largest difference of energy and works, relative to the largest energy."""
    history = result.history
    energy = total_energy(history)
    off = energy - energy[0] - history["external_work"] - history["support_work"]
    return np.abs(off).max() / energy.max()


@pytest.mark.parametrize("kind", [kind if kind == "drag" else pytest.param(
    kind, marks=pytest.mark.slow) for kind in LOADS])
def test_energy_is_work(kind):
    """To rounding error in the exact scheme, 300 steps; by quasi of second order in dt.  The load
    counts: without it the energy is another."""
    settings = Settings(dt=0.01, end_time=3.0, scheme=Scheme("exact"))
    result, without = (simulate(flying(loads), settings) for loads in (LOADS[kind], ()))
    assert missed(result) < 1e-13
    energies = [total_energy(one.history)[-1] for one in (result, without)]
    assert abs(energies[0] / energies[1] - 1.0) > 0.01
    coarse, fine = (missed(simulate(flying(LOADS[kind]), Settings(
        dt=dt, end_time=3.0, newton=Newton(tolerance=1e-12)))) for dt in (0.01, 0.005))
    assert 1e-12 < fine < coarse / 3.0


@pytest.mark.slow
@pytest.mark.parametrize("scheme", SCHEMES)
def test_impulses_are_those_of_the_loads(scheme):
    """Momenta of a free shell are impulses: forces and moments of the loads are theirs; J of quasi
    to second order in dt."""
    loads = [load for kind in LOADS.values() for load in kind]
    result = simulate(flying(loads), Settings(dt=0.01, end_time=1.0, scheme=Scheme(scheme),
                                              newton=Newton(tolerance=1e-16)))
    forces, moments = result.balance
    assert forces < (1e-12 if scheme == "exact" else 1e-9)  # what its iteration leaves
    assert moments < (1e-12 if scheme == "exact" else 1e-3)


def fold_with(force):
    return replace(folded(), loads=[FollowerForce(FOLD, force)])


SHELLS = {
    "follower": lambda: replace(warped_patch(np.random.default_rng(3)),
                                loads=[FollowerForce(0, 2.0), FollowerForce(5, -3.0)]),
    "junction": lambda: fold_with((2.0, -1.0, 3.0)),
    "drag": lambda: replace(warped_patch(np.random.default_rng(3)),
                            loads=[Drag(2.0, 40.0), Drag(1.0, 30.0, [0, 1], (1.0, -2.0, 3.0))]),
}


@pytest.mark.parametrize("moves", [False, pytest.param(True, marks=pytest.mark.slow)])
@pytest.mark.parametrize("shell", SHELLS)
def test_matrix_is_the_derivative(shell, moves):
    """At a state with strains and turned normals, at rest and in a step; of drag by positions and
    velocities."""
    model = SHELLS[shell]()
    system, bare = sparse_system(model), sparse_system(replace(model, loads=()))
    state, rng = system.initial_state(), np.random.default_rng(1)
    at = 0.05 * rng.standard_normal(system.numbering.n_dof)
    state.velocity[:] = rng.standard_normal(len(at)) if moves else 0.0
    step = Scheme().midpoint(0.1) if moves else STATIC

    def force(delta):
        return (assemble(system, state, step, delta, 0.0, tangent=False)
                - assemble(bare, state, step, delta, tangent=False))

    def matrix(of, time):
        assemble(of, state, step, at, time)
        return of.solver.matrix().toarray()

    K = matrix(system, 0.0) - matrix(bare, None)
    found = -central_differences(lambda d: force(at + d), np.zeros(len(at)), 1e-5)
    assert np.abs(found).max() > 1.0
    # the difference of two matrices up to 1e5 times as large, and the error of the step squared
    assert np.abs(K - found).max() < 1e-6 * np.abs(found).max()


def test_damping_of_drag_is_symmetric_and_positive():
    """What the velocities add to the matrix, of a motion along the normals."""
    model = SHELLS["drag"]()
    system = sparse_system(replace(model, loads=model.loads[:1]))
    state, found = system.initial_state(), []
    state.velocity[:] = 1.0
    for rate in (0.0, 10.0):
        step = STATIC._replace(rate_delta=rate, rate_velocity=-1.0)
        assemble(system, state, step, np.zeros(len(state.velocity)), 0.0)
        found.append(system.solver.matrix().toarray())
    damping = found[1] - found[0]
    assert np.abs(damping - damping.T).max() < 1e-9 * np.abs(damping).max()
    values = np.linalg.eigvalsh(damping)
    assert values.max() > 1.0 and values.min() > -1e-9 * values.max()


@pytest.mark.parametrize("scheme", SCHEMES)
def test_drag_takes_energy_in_every_step(scheme):
    """Of a free plate that tumbles in a medium at rest, whatever it does."""
    model = rectangle(2.0, 1.0, (4, 2), loads=[Drag(1.0, 0.2)])
    velocity, rates = rigid_velocity(model, (1.0, 0.0, 3.0), (2.0, 3.0, 1.0))
    model = replace(model, velocity=velocity, normal_velocity=rates)
    result = simulate(model, Settings(dt=0.02, end_time=4.0, scheme=Scheme(scheme)))
    work = result.history["external_work"]
    assert np.all(np.diff(work) < 0.0) and work[-1] < -0.2 * total_energy(result.history)[0]


def test_plate_that_falls_comes_to_its_terminal_speed():
    """``v = v_t tanh(g t/v_t)``, ``v_t^2 = 2 m g/(rho C A)``: the closed form of quadratic drag."""
    g, density, coefficient = 9.81, 1.2, 1.1
    model = rectangle(1.0, 1.0, (2, 2), thickness=0.05, youngs=1e8, density=40.0, loads=[
        Gravity((0.0, 0.0, -g)), Drag(coefficient, density)])
    result = simulate(model, Settings(dt=0.01, end_time=2.0, scheme=Scheme("exact")),
                      probes={"a": 0})
    final = np.sqrt(2.0 * model.mass * g / (density * coefficient))
    v = result.history["linear_momentum"][:, 2] / model.mass
    exact = -final * np.tanh(g * result.history["time"] / final)
    assert abs(exact[-1]) > 0.9 * final
    assert np.abs(v - exact).max() < 1e-4 * final  # dt^2, and the plate bends a little


def test_drag_only_feels_the_normal_component_and_the_relative_velocity():
    """A plate that slides along itself, or flies with the medium, is free."""
    base = rectangle(1.0, 1.0, (2, 2))
    for loads, velocity, expected in (
            ([Drag(1.0, 1.0)], (3.0, 2.0, 0.0), 0.0),
            ([Drag(1.0, 1.0, None, (0.0, 1.0, 3.0))], (0.0, 0.0, 3.0), 0.0),
            ([Drag(1.0, 1.0, [0])], (0.0, 0.0, 3.0), -0.5 * 0.25 * 9.0),
            ([Drag(3.0, 1.0, [0], (0.0, 0.0, 5.0))], (7.0, 0.0, 3.0), 1.5 * 0.25 * 4.0)):
        model = replace(base, loads=loads, velocity=np.tile(velocity, (9, 1)))
        result = simulate(model, Settings(dt=1e-6, end_time=1e-6, scheme=Scheme("exact")))
        assert result.history["load"][1] == pytest.approx([0.0, 0.0, expected], abs=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("scheme", SCHEMES)
def test_follower_force_turns_with_the_node(scheme):
    """Nodes that are driven round: the force is R f, of constant size, at a smooth node and at a
    junction; a dead one would stay.  The mean of the step is turned by the mean angle."""
    fold, turn = folded(), 2.0
    drive = Drive(range(len(fold.nodes)), rotation=(0.0, turn, 0.0),
                  history=Expression("t * t / 2"))
    along = fold.normals[fold.directors.first[0]]
    for load, start in ((FollowerForce(FOLD, (2.0, -1.0, 3.0)), np.array((2.0, -1.0, 3.0))),
                        (FollowerForce(0, -4.0), -4.0 * along)):
        model = replace(fold, loads=[load], supports=[drive])
        with pytest.warns(UserWarning, match="no load does anything"):
            result = simulate(model, Settings(dt=0.01, end_time=1.5, scheme=Scheme(scheme)))
        history = result.history
        assert np.allclose(np.linalg.norm(history["load"][1:], axis=1), np.linalg.norm(start),
                           rtol=1e-12)
        end = history["time"]
        angle = 0.25 * turn * (end[1:]**2 + end[:-1]**2)
        if scheme == "quasi":  # its variables are the mean, not the angle
            angle = angle[-1:]
        c, s = np.cos(angle), np.sin(angle)
        expected = np.stack([c * start[0] + s * start[2], 0.0 * c + start[1],
                             c * start[2] - s * start[0]], axis=1)
        assert np.abs(history["load"][-len(angle):] - expected).max() < 1e-3


def test_thrust_on_a_rigid_body_turns_with_it():
    """A force fixed to the centre of a body that spins about z pushes it along a half turn."""
    base = rectangle(1.0, 1.0, (1, 1))
    nodes = np.concatenate([base.nodes, [(5.0, 0.0, 0.0)]])
    model = Model(nodes, base.quads, 0.1, 1e6, 0.3, 1.0, loads=[FollowerForce(4, (1.0, 0.0, 0.0))],
                  bodies=[RigidBody("hub", 2.0, (1.0, 1.0, 1.0), (5.0, 0.0, 0.0))])
    spin = np.cross((0.0, 0.0, np.pi), model.normals)
    spin[:model.directors.first[4]] = 0.0
    model = replace(model, normal_velocity=spin)
    result = simulate(model, Settings(dt=0.005, end_time=1.0, scheme=Scheme("exact")))
    impulse = result.history["linear_momentum"]
    # int (cos pi t, sin pi t) dt; steps are quadrature by the midpoint rule
    assert impulse[-1] == pytest.approx([0.0, 2.0 / np.pi, 0.0], abs=1e-4)
    assert missed(result) < 1e-12


def strip(loads, **options):
    model = rectangle(4.0, 0.5, (16, 1), thickness=0.05, youngs=1e7, poisson=0.0, **options)
    root = np.flatnonzero(model.nodes[:, 0] == 0.0)
    tip = np.flatnonzero(model.nodes[:, 0] == 4.0)
    return replace(model, supports=[Support(root, CLAMPED)], loads=loads(tip)), tip


def test_follower_force_at_a_tip_in_statics():
    """A cantilever under a force that stays normal to its tip, against the elastica: ``EI th'' =
    -P cos(th - th_L)`` by shooting.  Newton's iteration converges quadratically."""
    EI, P, L = 1e7 * 0.5 * 0.05**3 / 12.0, 10.0, 4.0

    def beam(tip_angle):
        """From the tip, where there is no moment, back to the root."""
        return solve_ivp(lambda s, y: (y[1], -P / EI * np.cos(y[0] - tip_angle), np.cos(y[0]),
                                       np.sin(y[0])), (0.0, L), (tip_angle, 0.0, 0.0, 0.0),
                         rtol=1e-10, atol=1e-12).y[:, -1]

    tip_angle = brentq(lambda angle: beam(angle)[0], 0.5, 2.5)
    expected = beam(tip_angle)[2:]
    model, tip = strip(lambda tip: [FollowerForce(i, 0.5 * P) for i in tip])
    result = load_control(model, np.linspace(0.2, 1.0, 5))
    end = model.nodes[tip].mean(axis=0) + result.displacement[-1, tip].mean(axis=0)
    assert np.allclose(end[[0, 2]], expected, atol=0.01)  # shear, and 16 elements
    assert result.iterations.max() <= 9
    dead = load_control(strip(lambda tip: [NodalLoad(i, (0.0, 0.0, 0.5 * P)) for i in tip])[0],
                        np.linspace(0.2, 1.0, 5))
    assert np.abs(dead.displacement[-1, tip] - result.displacement[-1, tip]).max() > 0.2


@pytest.mark.slow
def test_drag_in_statics():
    """Nothing at rest in a medium at rest; in a wind that of a pressure ``rho C u^2/2`` along the
    normals of a plate that hardly bends."""
    still, tip = strip(lambda tip: [NodalLoad(tip[0], (0.0, 0.0, 0.1)), Drag(1.0, 50.0)])
    bare = replace(still, loads=still.loads[:1])
    one, other = (load_control(model, [1.0]).displacement for model in (still, bare))
    assert np.allclose(one, other, rtol=0.0, atol=1e-12)
    wind = replace(still, loads=[Drag(1.2, 2.0, None, (0.3, 0.0, 0.1))])
    pressed = replace(still, loads=[Pressure(0.5 * 1.2 * 2.0 * 0.01)])
    one, other = (solve_linear(model).displacement for model in (wind, pressed))
    assert np.abs(other).max() > 1e-4 and np.allclose(one, other, rtol=1e-9, atol=1e-15)
    assert load_control(wind, [1.0]).iterations.max() <= 6


def test_user_force_in_statics():
    """At v = 0 and t the load factor, which it is multiplied by as any constant load; t, x and p
    are those of the state."""
    seen = []

    def pull(t, x, v, p):
        seen.append((t, np.abs(v).max()))
        return np.where(x[:, :1] > 3.99, (0.0, 0.0, 0.05), 0.0)

    model, tip = strip(lambda tip: [UserForce(pull)])
    assert seen == [(0.0, 0.0)]
    one = load_control(model, [0.5, 1.0])
    other = load_control(strip(lambda tip: [NodalLoad(i, (0.0, 0.0, 0.05)) for i in tip])[0],
                         [0.5, 1.0])
    assert np.allclose(one.displacement, other.displacement, rtol=1e-9, atol=1e-12)
    assert {t for t, _ in seen[1:]} == {0.5, 1.0} and max(v for _, v in seen) == 0.0


def spring(t, x, v, p, stiffness=0.0):
    return -stiffness * x


@pytest.mark.slow
def test_iteration_under_a_user_force_converges_linearly():
    """The matrix does not know of it: more corrections are needed the stiffer it is beside ``2
    m/dt^2``, and a stiff one fails; energy is work whatever it is."""
    model = rectangle(2.0, 1.0, (4, 2), velocity=np.tile((0.0, 0.0, 1.0), (15, 1)))
    settings = Settings(dt=0.01, end_time=0.2, scheme=Scheme("exact"))
    inertia = 2.0 * model.nodal_mass.min() / settings.dt**2
    counts = []
    for share in (0.0, 0.1, 0.3, 0.6):
        loads = [UserForce(partial(spring, stiffness=share * inertia))]
        result = simulate(replace(model, loads=loads), settings)
        assert missed(result) < 1e-12
        counts.append(result.history["iterations"].mean())
    assert counts[0] < counts[1] < counts[2] < counts[3]
    with pytest.raises(StepError, match="no convergence"):
        simulate(replace(model, loads=[UserForce(partial(spring, stiffness=1e7 * inertia))]),
                 settings)


def test_function_gets_the_midpoint():
    """t, x, v, p of the exact scheme are the means of both ends of a step, v the quotient of
    differences; the arrays cannot be written to."""
    seen = []

    def look(t, x, v, p):
        assert not (x.flags.writeable or v.flags.writeable or p.flags.writeable)
        seen.append((t, x.copy(), v.copy(), p.copy()))
        return np.zeros_like(x)

    dt = 0.1
    result = simulate(flying([UserForce(look)]), Settings(
        dt=dt, end_time=dt, scheme=Scheme("exact")))
    t, x, v, p = seen[-1]
    assert t == 0.5 * dt and len(p) == 15
    assert np.allclose(x, flying(()).nodes + 0.5 * result.displacement, atol=1e-12)
    assert np.allclose(v, result.displacement / dt, atol=1e-10)
    assert np.allclose(p, 0.5 * (flying(()).normals + result.directors), atol=1e-10)


def test_loads_that_end_are_not_called():
    calls = []

    def count(t, x, v, p):
        calls.append(t)
        return np.ones_like(x)

    model = flying([UserForce(count, Steps((0.0, 0.1), (1.0, 0.0)))])
    assert model.unloaded_at == 1.0 and flying([UserForce(count)]).unloaded_at == np.inf
    simulate(model, Settings(dt=0.05, end_time=0.5))
    assert max(calls) < 0.1


BAD = {
    "three": lambda t, x, v: x,
    "shape": lambda t, x, v, p: x[:3],
    "one": lambda t, x, v, p: 1.0,
    "none": lambda t, x, v, p: None,
    "nan": lambda t, x, v, p: np.full_like(x, np.nan),
    "raises": lambda t, x, v, p: x[99],
    "writes": lambda t, x, v, p: np.multiply(x, 2.0, out=x),
    "complex": lambda t, x, v, p: 1j * x,
}


@pytest.mark.parametrize("name, message", [
    ("three", r"user force <lambda>: its arguments must be \(t, x, v, p\), are \(t, x, v\)"),
    ("shape", r"forces must be an array \(15, 3\) of numbers, are shape \(3, 3\)"),
    ("one", r"forces must be an array \(15, 3\) of numbers, are shape \(\)"),
    ("none", r"forces must be an array \(15, 3\) of numbers, are None"),
    ("nan", r"user force <lambda>\[0, 0\] is nan, must be finite"),
    ("raises", "user force <lambda>: IndexError at t = 0 s: index 99 is out of bounds"),
    ("writes", "ValueError at t = 0 s: output array is read-only"),
    ("complex", r"forces must be an array \(15, 3\) of numbers"),
])
def test_user_force_is_checked_before_the_run(name, message):
    with pytest.raises(InputError, match=message):
        flying([UserForce(BAD[name])])


def test_force_that_stops_being_finite_is_told():
    def root(t, x, v, p):
        return np.zeros_like(x) + np.sqrt(np.array(0.1 - t))

    with np.errstate(invalid="ignore"), pytest.raises(
            StepError, match="user force .*root is not finite at t = 0.1"):
        simulate(flying([UserForce(root)]), Settings(dt=0.05, end_time=0.3))


@pytest.mark.parametrize("make, message", [
    (lambda: FollowerForce(0, (1.0, 2.0)), "follower force at node 0: force must be three numbers"),
    (lambda: FollowerForce(0, "up"), r"force must be a number \[N\], is 'up'"),
    (lambda: FollowerForce(1.5, 1.0), "follower force: node must be an integer"),
    (lambda: flying([FollowerForce(99, 1.0)]), "load 1: node 99 does not exist"),
    (lambda: flying([FollowerForce(0, (0.0, 0.0, 1.0))]), "load 1: node 0 is smooth, it does not "
     "turn about its normal: give a number"),
    (lambda: fold_with(3.0), f"load 0: node {FOLD} has 2 directors and no one normal"),
    (lambda: Drag(-1.0, 1.0), "drag: coefficient must not be negative"),
    (lambda: Drag(1.0, -1.0), "drag: density must not be negative"),
    (lambda: Drag(1.0, 1.0, velocity=3.0), r"drag: velocity must be three numbers \[m/s\]"),
    (lambda: Drag(1.0, 1.0, []), "drag: elements must not be empty"),
    (lambda: flying([Drag(1.0, 1.0, [8])]), "load 1: element 8 does not exist"),
    (lambda: UserForce(3.0), "user force: function must be a function, is 3.0"),
    (lambda: UserForce(dict), "user force: function must be a function"),
    (lambda: UserForce(swirl, 1.0), "history must be a TimeFunction"),
])
def test_wrong_loads_are_told(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_held_follower_does_nothing():
    model = rectangle(2.0, 1.0, (2, 1), loads=[FollowerForce(0, 1.0)],
                      supports=[Support((0, 3), CLAMPED)])
    with pytest.warns(UserWarning, match="no load does anything"):
        simulate(model, Settings(dt=0.1, end_time=0.1))


def of_size(size):
    def force(t, x, v, p):
        return size * p
    return force


def test_a_run_is_that_of_its_function(tmp_path):
    """Results know the source of a function and the numbers that it closes over: a resumed run
    refuses another one, and takes the same, made anew."""
    path, run = tmp_path / "run.h5", Settings(dt=0.05, end_time=0.2, frame_every=1)
    one, same, other = (flying([UserForce(of_size(size))]) for size in (0.1, 0.1, 0.2))
    simulate(one, run, output=path)
    simulate(same, run, output=path, resume=True)
    with pytest.raises(ResultFileError, match="its model is another one"):
        simulate(other, run, output=path, resume=True)
    prints = [fingerprint(flying([load])) for load in (
        UserForce(swirl), UserForce(blown), UserForce(partial(spring, stiffness=1.0)),
        UserForce(partial(spring, stiffness=2.0)), UserForce(swirl, PULSE), Drag(1.0, 1.0),
        Drag(1.0, 1.0, velocity=(1.0, 0.0, 0.0)), FollowerForce(0, 1.0))]
    assert len(set(prints)) == len(prints)


def test_identity_is_the_same_in_another_process():
    """No address is in it."""
    for called in (swirl, of_size(0.1), partial(spring, stiffness=1.0), Caller(2.0).__call__,
                   Caller(2.0), np.hypot):
        assert "0x" not in identity(called)
    assert identity(of_size(np.ones(2))) != identity(of_size(np.zeros(2)))
    assert identity(Caller(2.0)) != identity(Caller(3.0))


class Caller:
    """A function with a memory."""

    def __init__(self, size):
        self.size = size

    def __call__(self, t, x, v, p):
        return self.size * p


@pytest.mark.slow
@pytest.mark.parametrize("scheme", SCHEMES)
def test_moments_and_loads_together_with_supports(scheme):
    """A clamped plate under everything: forces and moments balance at its supports."""
    base = rectangle(2.0, 1.0, (4, 2))
    root = np.flatnonzero(base.nodes[:, 0] == 0.0)
    model = replace(base, supports=[Support(root, CLAMPED)], loads=[
        NodalMoment(14, (0.1, 0.2, 0.3), PULSE), FollowerForce(12, 3.0, PULSE),
        *(load for kind in LOADS.values() for load in kind)])
    result = simulate(model, Settings(dt=0.01, end_time=1.0, scheme=Scheme(scheme)))
    assert missed(result) < (2e-12 if scheme == "exact" else 1e-3)
    assert result.balance.forces < 1e-9


def test_statics_balances():
    model, _ = strip(lambda tip: [FollowerForce(tip[0], 1.0), Drag(1.0, 1.0, None, (0, 0, 1.0))])
    result = load_control(model, [0.5, 1.0], StaticSettings())
    assert np.abs(result.balance.forces).max() < 1e-9
