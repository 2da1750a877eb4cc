"""Point masses, springs, foundations, damping, and supports that move."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from corovec import (
    AccuracyWarning,
    Damping,
    Drive,
    Expression,
    Gravity,
    GroundSpring,
    Harmonic,
    InputError,
    Model,
    Newton,
    NodalLoad,
    NodalMoment,
    PointMass,
    Scheme,
    Settings,
    Spring,
    Steps,
    Support,
    TimeFunction,
    buckling,
    energy_table,
    foundation,
    load_control,
    rigid_velocity,
    simulate,
    solve_linear,
    total_energy,
)
from corovec.solver.system.system import System
from corovec.verification.models import folded, rectangle

TIGHT = Newton(tolerance=1e-12)

EI = 1e9 * 0.1 * 0.01**3 / 12.0
"""Of ``strip`` [N m^2]."""


def strip(divisions=8, youngs=1e9, **options):
    """A cantilever along x, 1 m by 0.1 m by 0.01 m, and the nodes of its ends."""
    mesh = rectangle(1.0, 0.1, (divisions, 1))
    root = np.flatnonzero(mesh.nodes[:, 0] == 0.0)
    tip = np.flatnonzero(mesh.nodes[:, 0] == 1.0)
    options.setdefault("supports", [Support(tuple(root), ("x", "y", "z", "px", "py", "pz"))])
    return Model(mesh.nodes, mesh.quads, 0.01, youngs, 0.0, 1000.0, **options), root, tip


def frequency(history, column="tip_u"):
    """Mean angular frequency between the first and the last crossing of zero [rad/s]."""
    t, u = history["time"], history[column][:, 2]
    k = np.flatnonzero(np.sign(u[1:]) != np.sign(u[:-1]))
    at = t[k] - u[k] * (t[k + 1] - t[k]) / (u[k + 1] - u[k])
    return np.pi * (len(at) - 1) / (at[-1] - at[0])


def swing(model, tip, omega, periods, steps=60, force=1e-3, **options):
    """Free vibration from the equilibrium under a small force at the tip."""
    bent = Model(**{**fields(model), "loads": [NodalLoad(int(i), (0.0, 0.0, force / len(tip)))
                                               for i in tip]})
    start = load_control(bent, [1.0]).states[-1]
    dt = 2.0 * np.pi / omega / steps
    return simulate(model, Settings(dt=dt, end_time=round(periods * steps) * dt, newton=TIGHT),
                    start=start, probes={"tip": int(tip[0])}, **options)


def fields(model):
    """Arguments of a model."""
    names = ("nodes", "quads", "thickness", "youngs", "poisson", "density", "supports",
             "attached", "damping", "loads")
    return {name: getattr(model, name) for name in names}


def test_tip_mass():
    """``w^2 = 3 E I / (L^3 (M + 33 m / 140))``, a closed form by Rayleigh, to 0.5 %."""
    plain, _, tip = strip()
    model, *_ = strip(attached=[PointMass(int(i), 1.0) for i in tip])
    assert model.mass == pytest.approx(plain.mass + 2.0, rel=1e-14)
    m = plain.mass
    exact = np.sqrt(3.0 * EI / (2.0 + 33.0 / 140.0 * m))
    assert frequency(swing(model, tip, exact, 3).history) == pytest.approx(exact, rel=5e-3)
    alone = frequency(swing(plain, tip, np.sqrt(3.0 * EI * 140.0 / 33.0 / m), 3).history)
    assert alone > 1.5 * exact  # the check can tell


def test_a_free_plate_with_a_mass_keeps_its_momenta():
    """Kinetic energy, momenta and inertia know the mass, its rotary inertia and its arm."""
    mesh = rectangle(1.0, 0.5, (4, 2))
    attached = [PointMass(0, 3.0, 0.2), PointMass(7, 1.0)]
    model = Model(mesh.nodes, mesh.quads, 0.01, 1e9, 0.3, 1000.0, attached=attached)
    v, w = rigid_velocity(model, (0.1, 0.2, 0.3), (1.0, 2.0, 0.5), model.centre)
    model = Model(mesh.nodes, mesh.quads, 0.01, 1e9, 0.3, 1000.0, attached=attached, velocity=v,
                  normal_velocity=w)
    system = System(model)
    observed = system.observe(system.initial_state()).observed
    spin = np.array([1.0, 2.0, 0.5])
    exact = 0.5 * spin @ model.inertia @ spin + 0.5 * model.mass * 0.14
    assert observed.kinetic == pytest.approx(exact, rel=1e-12)
    one, two = (simulate(model, Settings(dt=dt, end_time=1.0, newton=TIGHT)).drift
                for dt in (0.01, 0.005))
    assert max(one.linear_momentum, two.linear_momentum) < 1e-12  # of second order, quasi:
    assert two.angular_momentum < 1e-5 and two.angular_momentum < 0.35 * one.angular_momentum


def test_masses_weigh():
    """A cantilever's root bears them: reactions in equilibrium."""
    model, *_ = strip(attached=[PointMass(4, 5.0)], loads=[Gravity((0.0, 0.0, -9.81))])
    result = solve_linear(model)
    assert result.reactions.sum(axis=0)[2] == pytest.approx(9.81 * model.mass, rel=1e-9)


@pytest.mark.parametrize("solver", ["skyline", "auto"])
def test_rigid_plate_on_springs(solver):
    """``u = F / sum k``, and ``k_f A`` of a foundation."""
    mesh = rectangle(1.0, 1.0, (2, 2))
    n = len(mesh.nodes)
    loads = [NodalLoad(i, (1.0, 2.0, 3.0)) for i in range(n)]
    held = [Support((0,), ("px", "py")), Support((0, 2), ("y",))]
    springs = [GroundSpring(i, (10.0, 20.0, 40.0), turning=0.1) for i in range(n)]
    model = Model(mesh.nodes, mesh.quads, 0.5, 1e12, 0.0, 1.0, loads=loads, supports=held[:1],
                  attached=springs)
    u = solve_linear(model, solver=solver).displacement
    assert np.allclose(u, (0.1, 0.1, 0.075), rtol=1e-6)
    loads = [NodalLoad(i, (0.0, 0.0, share * 5.0)) for i, share in enumerate(
        -model.nodal_mass / model.mass)]
    soft = Model(mesh.nodes, mesh.quads, 0.5, 1e12, 0.0, 1.0, loads=loads,
                 attached=foundation(mesh.nodes, mesh.quads, (1.0, 1.0, 100.0)),
                 supports=[Support((0,), ("px", "py"))])
    assert np.allclose(solve_linear(soft, solver=solver).displacement[:, 2], -0.05, rtol=1e-6)


def test_springs_are_followed_by_newton_and_keep_energy():
    """Two plates joined by long springs: energy goes to and fro between springs and motion; its
    drift is of second order, linear momentum stays.  A spring whose force is that of the end of the
    step (a wrong variant) would pump energy: seen as drift."""
    mesh = rectangle(1.0, 0.5, (2, 1))
    nodes = np.vstack([mesh.nodes, mesh.nodes + (0.0, 0.0, 1.0)])
    quads = np.vstack([mesh.quads, mesh.quads + len(mesh.nodes)])
    n = len(mesh.nodes)
    attached = [Spring(i, i + n, 50.0, length=0.5) for i in (0, 2, 5)]
    model = Model(nodes, quads, 0.02, 1e8, 0.3, 1000.0, attached=attached)

    def run(dt):
        return simulate(model, Settings(dt=dt, end_time=2.0, newton=TIGHT))
    result = run(0.01)
    energy, finer = total_energy(result.history), total_energy(run(0.005).history)
    assert energy[0] == pytest.approx(3 * 0.5 * 50.0 * 0.25, rel=1e-12)
    assert result.history["kinetic_energy"].max() > 0.5 * energy[0]
    assert np.ptp(energy) < 3e-4 * energy[0] and np.ptp(finer) < 0.35 * np.ptp(energy)
    momentum = np.linalg.norm(result.history["linear_momentum"], axis=1).max()
    assert momentum < 1e-11 * result.history["momentum_scale"].max()
    with pytest.warns(AccuracyWarning, match="take a smaller dt"):
        wrong = simulate(model, Settings(dt=0.01, end_time=2.0, newton=TIGHT,
                                         scheme=Scheme(name="newmark")))
    assert np.ptp(total_energy(wrong.history)) > 10.0 * np.ptp(energy)


def two_plates(attached, thickness=0.5, youngs=1e11, density=2.0, **options):
    """Two equal plates, one above the other, 1 m apart; stiff ones of 1 kg."""
    mesh = rectangle(1.0, 1.0, (2, 2))
    n = len(mesh.nodes)
    nodes = np.vstack([mesh.nodes, mesh.nodes + (0.0, 0.0, 1.0)])
    quads = np.vstack([mesh.quads, mesh.quads + n])
    return Model(nodes, quads, thickness, youngs, 0.0, density,
                 attached=[item(n) for item in attached], **options)


@pytest.mark.parametrize("given", [
    {"stiffness": 5.0, "damping": 0.4},
    {"spring_extensions": (-1.0, 1.0), "spring_forces": (-5.0, 5.0),
     "damper_rates": (-9.0, 9.0), "damper_forces": (-3.6, 3.6)},
    {"stiffness": 2.0, "damping": 0.3, "spring_extensions": (-1.0, 0.0, 0.5),
     "spring_forces": (-3.0, 0.0, 1.5), "damper_rates": (-2.0, 2.0),
     "damper_forces": (-0.2, 0.2)}])
def test_an_oscillator_with_a_damper(given):
    """``x = x_0 exp(-d t) (cos w t + d/w sin w t)`` of two plates of mass m with four springs k and
    dampers c between their corners: ``d = 4 c / m``, ``w^2 = 8 k / m - d^2``; given as numbers, as
    tables, and as both."""
    corners = (0, 2, 6, 8)
    model = two_plates([lambda n, i=i: Spring(i, i + n, length=0.75, **given) for i in corners])
    result = simulate(model, Settings(dt=0.0025, end_time=1.0, scheme=Scheme("exact")),
                      probes={"low": 0, "high": 9})
    time = result.history["time"]
    apart = 0.25 + result.history["high_u"][:, 2] - result.history["low_u"][:, 2]
    d, m = 4.0 * 0.4 / 1.0, 1.0
    w = np.sqrt(8.0 * 5.0 / m - d**2)
    exact = 0.25 * np.exp(-d * time) * (np.cos(w * time) + d / w * np.sin(w * time))
    assert np.abs(apart - exact).max() < 1e-5
    lost = result.history["dissipated"]
    assert lost[-1] == pytest.approx(4 * 0.5 * 5.0 * 0.25**2, rel=0.1) and np.all(
        np.diff(lost) >= 0.0)
    assert np.abs(result.energy_balance) < 1e-12
    table = energy_table(result)
    for k in range(4):
        own = table[table["item"] == f"spring {k}"]["dissipated"].to_numpy()
        np.testing.assert_allclose(own, lost / 4.0, rtol=1e-9, atol=1e-14)


@pytest.mark.parametrize("given", [{"damping": 0.4}, {"damper_rates": (-9.0, 9.0),
                                                     "damper_forces": (-3.6, 3.6)}])
@pytest.mark.parametrize("scheme", [Scheme(rho_inf=0.5), Scheme("newmark")])
@pytest.mark.filterwarnings("ignore::corovec.AccuracyWarning")
def test_a_damper_has_its_rate_in_schemes_that_dissipate(scheme, given):
    """``v = v_0 exp(-8 c t / m)`` between two plates of mass m with four dampers c."""
    rest = two_plates([])
    v = np.where(rest.nodes[:, 2:] > 0.5, (0.0, 0.0, 1.0), (0.0, 0.0, 0.0))
    model = two_plates([lambda n, i=i: Spring(i, i + n, **given) for i in (0, 2, 6, 8)],
                       velocity=v)
    result = simulate(model, Settings(dt=0.002, end_time=0.4, scheme=scheme, newton=TIGHT),
                      probes={"low": 0, "high": 9})
    apart = result.history["high_u"][:, 2] - result.history["low_u"][:, 2]
    decay = 8.0 * 0.4
    assert apart[-1] == pytest.approx((1.0 - np.exp(-decay * 0.4)) / decay, rel=1e-2)
    assert result.history["dissipated"][-1] == pytest.approx(
        0.25 * (1.0 - np.exp(-2.0 * decay * 0.4)), rel=2e-2)


@pytest.mark.parametrize("scheme, kept", [("exact", 1e-12), ("quasi", 1e-4)])
def test_bent_tables_of_springs_in_flight(scheme, kept):
    """Energy, what dampers took and both momenta of a free flight, in which springs pass the points
    of their tables."""
    attached = [lambda n, i=i: Spring(
        i, i + n, 0.5, length=0.9, spring_extensions=(-0.3, -0.1, 0.1, 0.4),
        spring_forces=(-3.0, -2.5, 0.5, 0.4), damper_rates=(-1.0, -0.2, 0.2, 3.0),
        damper_forces=(-0.3, 0.0, 0.0, 0.2)) for i in (0, 2, 6)]
    soft = {"thickness": 0.02, "youngs": 1e7, "density": 50.0}
    rest = two_plates(attached, **soft)
    v, w = rigid_velocity(rest, (0.1, 0.0, 0.2), (0.4, 0.3, 1.0), rest.centre)
    model = two_plates(attached, **soft, velocity=v, normal_velocity=w)
    result = simulate(model, Settings(dt=0.02, end_time=4.0, scheme=Scheme(scheme), newton=TIGHT))
    energy, lost = total_energy(result.history), result.history["dissipated"]
    assert np.abs(energy + lost - energy[0]).max() < kept * energy[0]
    assert lost[-1] > 0.01 * energy[0] and np.all(np.diff(lost) >= 0.0)
    assert result.drift.linear_momentum < 1e-12 and result.drift.angular_momentum < kept


def test_a_tabled_spring_in_equilibrium():
    """It pulls by what its table says, in a path and in a linear step; dampers take no part."""
    mesh = rectangle(1.0, 1.0, (2, 2))
    supports = [Support((0, 1, 2, 3, 5, 6, 7), ("x", "y", "z", "px", "py"))]
    spring = Spring(8, 0, spring_extensions=(-1.0, 0.0, 2.0), spring_forces=(-900.0, 0.0, 200.0),
                    damping=1e3)
    model = Model(mesh.nodes, mesh.quads, 0.01, 1e3, 0.0, 1.0, supports=supports, attached=[spring],
                  loads=[NodalLoad(8, (0.02, 0.02, 0.0))])
    linear = solve_linear(model).displacement[8, 0]
    result = load_control(model, np.array((0.5, 1.0)))
    u = result.displacement[-1, 8]
    plain = replace_attached(model, Spring(8, 0, 100.0))
    assert u == pytest.approx(load_control(plain, np.array((0.5, 1.0))).displacement[-1, 8],
                              rel=1e-9)
    assert linear == pytest.approx(solve_linear(plain).displacement[8, 0], rel=1e-4)


def replace_attached(model, *attached):
    return Model(**{**fields(model), "attached": list(attached)})


def test_ground_springs_hold_a_shell():
    """Supported, not free: momenta change, energy stays; a normal is turned back by its spring."""
    mesh = rectangle(1.0, 1.0, (2, 2))
    plain = Model(mesh.nodes, mesh.quads, 0.05, 1e7, 0.3, 1000.0)
    springs = [GroundSpring(i, (90.0 * m,) * 3, turning=1.0)
               for i, m in enumerate(plain.nodal_mass)]
    rest = Model(mesh.nodes, mesh.quads, 0.05, 1e7, 0.3, 1000.0, attached=springs)
    v, w = rigid_velocity(rest, (0.0, 0.0, 1.0), (0.5, 0.0, 0.3), rest.centre)
    model = Model(mesh.nodes, mesh.quads, 0.05, 1e7, 0.3, 1000.0, attached=springs, velocity=v,
                  normal_velocity=w)
    result = simulate(model, Settings(dt=0.005, end_time=1.0, newton=TIGHT))
    assert result.supported and result.drift.linear_momentum is None
    energy = total_energy(result.history)
    assert np.abs(energy / energy[0] - 1.0).max() < 1e-6
    z = result.history["linear_momentum"][:, 2] / model.mass
    assert np.abs(z - np.cos(np.sqrt(90.0) * result.history["time"])).max() < 2e-3  # its phase


@pytest.mark.parametrize("kind", ["mass", "stiffness"])
@pytest.mark.parametrize("decade", range(6))
def test_decrement(kind, decade):
    """The amplitude of a mode falls by exp(-2 pi zeta) a period, over five decades of frequency."""
    youngs, zeta, periods = 1e5 * 100.0**decade, 0.02, 4
    plain, _, tip = strip(divisions=4, youngs=youngs)
    bending = EI * youngs / 1e9
    omega = 1.8751**2 * np.sqrt(bending / plain.mass)
    damping = (Damping(mass=2.0 * zeta * omega) if kind == "mass" else
               Damping(stiffness=2.0 * zeta / omega))
    model, *_ = strip(divisions=4, youngs=youngs, damping=damping)
    result = swing(model, tip, omega, periods, force=0.002 * bending)
    u = result.history["tip_u"][:, 2]
    peaks = [k for k in range(1, len(u) - 1) if u[k - 1] < u[k] > u[k + 1]]
    decrement = np.log(u[peaks[0]] / u[peaks[-1]]) / (len(peaks) - 1)
    assert decrement == pytest.approx(2.0 * np.pi * zeta, rel=0.03)  # peaks fall between steps
    history = result.history
    lost = history["dissipated"]
    assert np.all(np.diff(lost) >= 0.0)
    balance = total_energy(history) + lost
    assert np.abs(balance / balance[0] - 1.0).max() < 1e-6


@pytest.mark.slow
def test_damping_leaves_rigid_motion_and_momenta():
    """A plate that spins loses nothing; a plate that shakes and spins keeps both momenta."""
    mesh = rectangle(1.0, 0.5, (3, 2))
    damping = Damping.of_ratios(0.05, 5.0, 0.05, 50.0)
    still = Model(mesh.nodes, mesh.quads, 0.01, 1e8, 0.3, 1000.0)
    v, w = rigid_velocity(still, (1.0, 0.0, 0.0), (0.0, 0.0, 6.0), still.centre)
    spinning = Model(mesh.nodes, mesh.quads, 0.01, 1e8, 0.3, 1000.0, velocity=v,
                     normal_velocity=w, damping=damping)
    result = simulate(spinning, Settings(dt=0.01, end_time=2.0, newton=TIGHT))
    kinetic = result.history["kinetic_energy"]
    # the spin stretches the plate once, by E eps^2 = 1e-3 of its energy; nothing goes on falling
    assert result.history["dissipated"][-1] < 1e-3 * kinetic[0]
    assert result.history["dissipated"][-1] - result.history["dissipated"][100] < 1e-9 * kinetic[0]
    rng = np.random.default_rng(3)
    shaken = Model(mesh.nodes, mesh.quads, 0.01, 1e8, 0.3, 1000.0, damping=damping,
                   velocity=v + 0.2 * rng.normal(size=v.shape), normal_velocity=w)
    result = simulate(shaken, Settings(dt=0.002, end_time=1.0, newton=TIGHT))
    drift = result.drift
    assert result.history["dissipated"][-1] > 1e-3 * result.history["kinetic_energy"][0]
    assert drift.linear_momentum < 1e-11 and drift.angular_momentum < 1e-6


def test_damping_ratios():
    damping = Damping.of_ratios(0.02, 1.0, 0.05, 10.0)
    for zeta, f in ((0.02, 1.0), (0.05, 10.0)):
        omega = 2.0 * np.pi * f
        assert damping.mass / omega + damping.stiffness * omega == pytest.approx(2.0 * zeta)


SINE = Harmonic(frequency=2.0, amplitude=0.1)


def test_a_shaken_plate_follows():
    """Every node is driven: x(t) exactly, and the supports do the work that is its energy."""
    mesh = rectangle(1.0, 0.5, (2, 1))
    everywhere = tuple(range(len(mesh.nodes)))
    model = Model(mesh.nodes, mesh.quads, 0.01, 1e9, 0.3, 1000.0, supports=[
        Drive(everywhere, translation=(1.0, 2.0, -1.0), rotation=(0.0, 5.0, 3.0),
              about=(0.5, 0.2, 0.0), history=SINE)])
    result = simulate(model, Settings(dt=0.01, end_time=0.73), probes={"corner": 0})
    t = result.history["time"]
    h = SINE(t)
    arm = mesh.nodes[0] - (0.5, 0.2, 0.0)
    exact = (Rotation.from_rotvec(np.outer(h, (0.0, 5.0, 3.0))).apply(arm) - arm
             + np.outer(h, (1.0, 2.0, -1.0)))
    assert np.abs(result.history["corner_u"] - exact).max() < 1e-13
    history = result.history
    assert np.abs(total_energy(history) - total_energy(history)[0]
                  - history["support_work"]).max() < 1e-7 * total_energy(history).max()
    assert np.ptp(history["support_work"]) > 1.0


@pytest.mark.slow
def test_a_driven_edge_balances_its_energy():
    """A strip shaken at its root: work of the supports, energy and damping close to 1e-6."""
    model, root, tip = strip(damping=Damping(mass=1.0, stiffness=1e-3), supports=[])
    model = Model(**{**fields(model), "supports": [
        Drive(tuple(root), translation=(0.0, 0.0, 1.0), rotation=(0.0, 0.3, 0.0),
              history=Expression("0.05 * (1 - cos(20 * t))"))]})
    history = simulate(model, Settings(dt=5e-4, end_time=0.5, newton=TIGHT)).history
    balance = (total_energy(history) + history["dissipated"] - history["external_work"]
               - history["support_work"])
    assert np.abs(balance).max() < 1e-6 * total_energy(history).max()
    assert history["dissipated"][-1] > 1e-3 * total_energy(history).max()


def test_folded_supports_turn_together():
    """A junction in a driven edge turns as one body."""
    model = folded()
    at = tuple(int(i) for i in np.flatnonzero(model.nodes[:, 1] == model.nodes[:, 1].min()))
    ramp = Expression("t * t")
    driven = Model(model.nodes, model.quads, model.thickness, model.youngs, model.poisson,
                   model.density, supports=[Drive(at, rotation=(0.0, 0.0, 0.5), history=ramp)])
    result = simulate(driven, Settings(dt=0.02, end_time=1.0))
    turn = Rotation.from_rotvec((0.0, 0.0, 0.5))
    first = driven.directors.first
    for i in at:
        x = model.nodes[i].copy()
        assert np.allclose(result.displacement[i], turn.apply(x) - x, atol=1e-12)
        members = slice(first[i], first[i + 1])
        assert np.allclose(result.directors[members], turn.apply(driven.normals[members].copy()),
                           atol=1e-12)


def turned_strip(divisions, angle, **history):
    """A strip whose tip turns about the pole from which it gets to the end of a circular arc."""
    model, root, tip = strip(divisions=divisions)
    R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    end = np.array([np.sin(angle), 1.0 - np.cos(angle)]) / angle
    x, z = np.linalg.solve(np.eye(2) - R, end - R @ (1.0, 0.0))
    drive = Drive(tuple(tip), rotation=(0.0, -angle, 0.0), about=(x, 0.0, z), **history)
    return Model(**{**fields(model), "supports": [*model.supports, drive]}), tip


def test_end_rotation_returns_its_moment():
    """``theta = M L / (E I)``: of a small angle at once, of a large one with the mesh."""
    model, tip = turned_strip(16, 1e-3)
    moments = solve_linear(model).reaction_moments
    assert abs(moments[tip, 1].sum()) == pytest.approx(1e-3 * EI, rel=1e-6)
    errors = []
    for divisions in (8, 16):
        model, tip = turned_strip(divisions, 0.5)
        moments = load_control(model, np.linspace(0.25, 1.0, 4)).reaction_moments[-1]
        errors.append(abs(abs(moments[tip, 1].sum()) / (0.5 * EI) - 1.0))
    assert errors[1] < 0.015 and errors[1] < 0.3 * errors[0]  # of a polygon in the arc


def test_a_motion_comes_to_rest_on_the_arc():
    model, _ = turned_strip(8, 0.5, history=TimeFunction((0.0, 1.0, 2.0), (0.0, 1.0, 1.0)))
    model = Model(**{**fields(model), "damping": Damping(stiffness=0.01)})
    history = simulate(model, Settings(dt=0.01, end_time=2.0)).history
    assert history["strain_energy"][-1] == pytest.approx(0.5 * EI * 0.25, rel=0.05)
    assert history["kinetic_energy"][-1] < 0.01 * history["kinetic_energy"].max()


@pytest.mark.parametrize("make, message", [
    (lambda: PointMass(0, -1.0), "point mass at node 0: mass must not be negative, is -1 kg"),
    (lambda: Spring(1, 1, 5.0), "spring: both ends are node 1"),
    (lambda: Spring(1, 2, 5.0, length=0.0), "spring at node 1: length"),
    (lambda: Spring(1, 2), "spring at node 1: a stiffness, a damping or a table is needed"),
    (lambda: Spring(1, 2, 1.0, damping=-1.0), "spring at node 1: damping must not be negative"),
    (lambda: Spring(1, 2, spring_extensions=(0.0, 1.0)), "2 spring_extensions but 0 spring_forces"),
    (lambda: Spring(1, 2, spring_extensions=(1.0, 0.0), spring_forces=(0.0, 1.0)),
     r"spring_extensions must rise, spring_extensions\[1\] = 0 follows 1"),
    (lambda: Spring(1, 2, spring_extensions=(0.0, 1e-320), spring_forces=(0.0, 1.0)),
     r"spring_extensions must rise, spring_extensions\[1\] = 9.99989e-321 follows 0"),
    (lambda: Spring(1, 2, damper_rates=(-1.0, 1.0), damper_forces=(1.0, 1.0)),
     r"damper_forces\[0\] = 1 N drives the motion at -1 m/s"),
    (lambda: Spring(1, 2, damper_rates=(1.0, 2.0), damper_forces=(1.0, 1.0)),
     "damper_forces must be zero at rest, are 1 N there"),
    (lambda: GroundSpring(3, (1.0, -2.0, 0.0)), "ground spring at node 3: stiffness"),
    (lambda: Damping(mass=-1.0), "damping: mass must not be negative"),
    (lambda: Damping.of_ratios(0.1, 1.0, 0.0001, 50.0), "neither may be negative"),
    (lambda: Damping.of_ratios(0.1, 1.0, 0.1, 1.0), "both frequencies are 1 Hz"),
    (lambda: Drive((0,), rotation=(1.0, 2.0)), "drive: rotation"),
    (lambda: strip(attached=[PointMass(99, 1.0)]), r"attached\[0\]: node 99 does not exist"),
    (lambda: strip(attached=[3.0]), r"attached\[0\] must be one of PointMass"),
    (lambda: strip(damping=0.1), "damping must be"),
])
def test_mistakes(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_junctions_have_no_rotary_inertia_of_one_normal():
    model = folded()
    junction = int(np.flatnonzero(np.diff(model.directors.first) > 1)[0])
    with pytest.raises(InputError, match=f"several plates meet at node {junction}"):
        folded(attached=[PointMass(junction, 1.0, 0.1)])


def test_a_moment_about_a_sprung_normal():
    """``M = k_t sin(angle)`` of a rigid plate on one turning spring."""
    mesh = rectangle(1.0, 1.0, (1, 1))
    model = Model(mesh.nodes, mesh.quads, 0.5, 1e12, 0.0, 1.0,
                  loads=[NodalMoment(0, (0.3, 0.0, 0.0))],
                  attached=[GroundSpring(0, (1e3,) * 3, turning=1.0)],
                  supports=[Support((1,), ("y", "z")), Support((0,), ("x", "y", "z"))])
    u = load_control(model, [1.0]).displacement[-1]
    corner = int(np.argmax(mesh.nodes[:, 1] * (mesh.nodes[:, 0] == 0.0)))
    angle = np.arctan2(u[corner, 2], 1.0 + u[corner, 1])
    assert 1.0 * np.sin(angle) == pytest.approx(0.3, rel=1e-3)


def test_springs_of_the_ground_are_reactions():
    """Loads are the weight alone; what the ground does is a reaction, in statics and motion."""
    model, _, tip = strip(attached=[GroundSpring(4, (0.0, 0.0, 50.0), turning=0.1)],
                          loads=[Gravity((0.0, 0.0, -9.81))])
    weight = 9.81 * model.mass
    linear, path = solve_linear(model), load_control(model, [1.0])
    run = simulate(model, Settings(dt=0.01, end_time=0.1, newton=TIGHT))
    assert path.load[-1, 2] == pytest.approx(-weight) and run.history["load"][-1, 2] == (
        pytest.approx(-weight))
    for reactions in (linear.reactions, path.reactions[-1]):
        assert reactions[:, 2].sum() == pytest.approx(weight, rel=1e-9) and reactions[4, 2] != 0.0
    for result in (linear, path, run):
        assert result.balance.forces < 1e-8 and result.balance.moments < 1e-6


def test_rigid_moves_and_foundations_give_no_alarm():
    mesh = rectangle(1.0, 0.5, (2, 1))
    on_ground = Model(mesh.nodes, mesh.quads, 0.02, 1e8, 0.3, 1000.0,
                      attached=foundation(mesh.nodes, mesh.quads, (1e2, 1e2, 1e3)),
                      loads=[Gravity((0.0, 0.0, -9.81))])
    path = load_control(on_ground, [1.0])
    assert path.displacement[-1, :, 2] == pytest.approx([-0.1962] * 6, rel=1e-9)
    turned = Model(mesh.nodes, mesh.quads, 0.02, 1e8, 0.3, 1000.0,
                   supports=[Drive((0, 3), rotation=(0.0, np.pi, 0.0))])
    moved = load_control(turned, [1.0]).displacement[-1] + mesh.nodes
    assert np.allclose(moved, mesh.nodes * (-1.0, 1.0, -1.0), atol=1e-9)
    with pytest.raises(InputError, match="cause no stress"):
        buckling(turned, 1)


@pytest.mark.parametrize("history, message", [
    (Expression("1 / t"), "support 0: its time function is inf at t = 0 s"),
    (Steps((0.0, 0.05), (0.0, 1.0)), "support 0: its time function jumps at t = 0.05 s"),
    (TimeFunction((0.0, 0.05, 0.051), (0.0, 0.0, 1.0)),
     "support 0: its time function goes from 0 to 1 within 0.001 s, a support cannot in a step")])
def test_supports_do_not_jump(history, message):
    model, root, _ = strip(supports=[])
    driven = Model(**{**fields(model), "supports": [
        Drive(tuple(root), translation=(0.0, 0.0, 1.0), history=history)]})
    with pytest.raises(InputError, match=message):
        simulate(driven, Settings(dt=0.01, end_time=0.1))


def test_functions_that_are_not_finite_in_statics():
    model, _, tip = strip()
    for options in ({"loads": [Gravity((0.0, 0.0, -1.0), Expression("sqrt(0.7 - t)"))]},
                    {"supports": [*model.supports, Support(tuple(tip), ("z",), 0.1,
                                                           Expression("sqrt(0.7 - t)"))]}):
        wrong = Model(**{**fields(model), **options})
        with pytest.raises(InputError, match="is nan at load factor 1"):
            load_control(wrong, [0.5, 1.0])
        with pytest.raises(InputError, match="is nan at load factor 1"):
            solve_linear(wrong)


def test_two_drives_may_be_alike():
    mesh = rectangle(1.0, 0.5, (2, 1))
    one, other = (Drive(nodes, translation=(0.0, 0.0, 0.1)) for nodes in ((0, 3), (3, 1)))
    Model(mesh.nodes, mesh.quads, 0.02, 1e8, 0.3, 1000.0, supports=[one, other])
    with pytest.raises(InputError, match="supports 0 and 1 give"):
        Model(mesh.nodes, mesh.quads, 0.02, 1e8, 0.3, 1000.0,
              supports=[one, Drive((3,), translation=(0.0, 0.0, 0.2))])
