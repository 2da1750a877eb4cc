"""The exact scheme: its discrete Jacobian, conservation to rounding error, order, dissipation."""

from dataclasses import replace

import numpy as np

from corovec import (
    Drag,
    FollowerForce,
    Gravity,
    Newton,
    NodalLoad,
    NodalMoment,
    Pressure,
    Scheme,
    Settings,
    TimeFunction,
    UserForce,
    rigid_velocity,
    simulate,
    total_energy,
)
from corovec.benchmarks import load_case

from ..case import Case, Row, at_least, small
from ..discrete_oracle import (
    increment,
    jacobian,
    local_variables,
    measured,
    random_step,
    unbalanced,
)
from ..models import box, cross_code_plate, folded, rectangle, spinning, warped_patch

EXACT = Scheme("exact")
PULSE = TimeFunction((0.0, 0.1, 0.2), (0.0, 1.0, 0.0))
ROUNDING = "rounding of residuals, gathered over the steps"


def run_jacobian():
    """Worst of 50 random elements, strained by up to 30 % and turned by 1 rad in the step."""
    errors = []
    for seed in range(50):
        initial, start, end = random_step(np.random.default_rng(seed))
        dq, mean = increment(start, end), measured(*(0.5 * (a + b) for a, b in zip(start, end)))
        du = local_variables(*end, *initial) - local_variables(*start, *initial)
        T, last = jacobian(start, end), measured(*end)
        errors.append((np.abs(T @ dq - du).max(), *unbalanced(T, start, end),
                       np.abs(jacobian(start, end, (last, last)) @ dq - du).max(),
                       np.abs(jacobian(start, end, (mean, mean)) @ dq - du).max()))
    errors = np.array(errors)
    work, forces, moments = errors[:, :3].max(axis=0)
    return [small("T_bar dq - du_L, local variables from the printed equations", work, 2e-14,
                  "rounding; du_L is of order one"),
            small("sum of the forces of any row", forces, 1e-15, "rounding"),
            small("sum of their moments about the middle", moments, 5e-15, "rounding"),
            at_least("T_bar dq - du_L with the end's invariants for the means", errors[:, 3].min(),
                     1e-3, "T of one side is no discrete Jacobian"),
            at_least("with those of the mean configuration", errors[:, 4].min(), 1e-3,
                     "nor is T of the midpoint")]


def gap(result):
    """Largest difference of energy, works and losses, relative to the largest of them."""
    history = result.history
    energy, works = total_energy(history), [history[name] for name in (
        "external_work", "support_work", "dissipated")]
    missed = energy - energy[0] - works[0] - works[1] + works[2]
    return np.abs(missed).max() / max(np.abs(values).max() for values in (energy, *works))


def swirl(t, x, v, p):
    """Forces without a potential."""
    return np.cross((0.0, 0.1, np.cos(t)), x) - 0.02 * np.linalg.norm(v, axis=1, keepdims=True) * v


def flying():
    """``{what: (model, dt, end)}`` of free shells under loads."""
    plate, fold, closed = rectangle(2.0, 1.0, (4, 2)), folded(), box((1.0, 0.8, 0.6), 2,
                                                                     thickness=0.02)
    forces = [NodalLoad(0, (1.0, 2.0, 3.0), PULSE), NodalLoad(14, (-1.0, 0.0, -2.0), PULSE)]
    moments = [NodalMoment(0, (0.1, 0.2, 0.3), PULSE), NodalMoment(7, (-0.1, 0.0, -0.2), PULSE)]
    patch = warped_patch(np.random.default_rng(1), loads=[
        replace(load, node=node) for load, node in zip(forces, (0, 11))])
    small_ones = [replace(load, force=0.01 * np.array(load.force)) for load in forces]
    return {
        "dead forces": (replace(plate, loads=forces), 0.02, 1.0),
        "moments, about normals too": (replace(plate, loads=moments), 0.02, 1.0),
        "weight for a while": (replace(plate, loads=[*forces, Gravity((0, 0, -9.81), PULSE)]),
                               0.02, 1.0),
        "pressure on one side": (replace(plate, loads=[Pressure(3.0, None, PULSE), forces[0]]),
                                 0.02, 1.0),
        "a force that follows, wind, one of a user": (replace(plate, loads=[
            forces[0], FollowerForce(7, 5.0, PULSE), Drag(1.0, 0.5, velocity=(1.0, 0.0, 3.0)),
            UserForce(swirl)]), 0.02, 1.0),
        "warped patch": (patch, 0.02, 1.0),
        "fold": (replace(fold, loads=[*small_ones, NodalMoment(6, (1e-3, 2e-3, 3e-3), PULSE)]),
                 0.02, 1.0),
        "box under inner pressure": (replace(closed, loads=[
            Pressure(30.0, None, PULSE), NodalLoad(0, (0.1, 0.2, 0.3), PULSE)]), 0.02, 1.0),
        "L-plate, steps of 0.1 s": (load_case("l-plate").model(30), 0.1, 5.0),
        "ruler, steps of 5e-4 s": (load_case("ruler").model(120), 5e-4, 0.04),
        "cross-code plate, steps of 0.02 s": (cross_code_plate(1), 0.02, 3.0)}


def run_conservation():
    """Energy less works, momenta less impulses, also while loads act."""
    for name, (model, dt, end) in flying().items():
        result = simulate(model, Settings(dt=dt, end_time=end, scheme=EXACT))
        off = result.balance
        yield small(f"{name}: energy - works", gap(result), 1e-11, ROUNDING)
        yield small(f"{name}: L - impulses", off.forces, 1e-12, ROUNDING)
        yield small(f"{name}: J - moments of impulses", off.moments, 2e-11, ROUNDING)
        yield Row(f"{name}: halvings", result.history["halvings"].sum(), 0, "analytic", 0.0,
                  "steps that the motion allows", scale=1.0)
    quasi = simulate(model, Settings(dt=dt, end_time=end))
    yield at_least("the last by quasi: energy - works", gap(quasi), 1e-6, "of second order in dt")
    yield at_least("the last by quasi: J - moments of impulses", quasi.balance.moments, 1e-8,
                   "of second order in dt")


def swinging():
    """A free plate that spins and bends, its frequencies resolved by small steps."""
    plate = rectangle(2.0, 1.0, (4, 2), youngs=100.0)
    velocity, rates = rigid_velocity(plate, (1, 0, 0), (1.0, 2.0, 0.5), (1.0, 0.5, 0.0))
    phase = np.pi * plate.nodes[:, 0] / 2.0
    return replace(plate, velocity=velocity + np.outer(np.cos(phase), (0.0, 0.0, 0.2)),
                   normal_velocity=rates + np.outer(np.sin(phase), (0.1 * np.pi, 0.0, 0.0)))


def run_order():
    model = swinging()
    ends = [simulate(model, Settings(dt=dt, end_time=0.4, scheme=EXACT)).displacement
            for dt in (2e-3, 1e-3, 2.5e-4)]
    errors = [np.abs(end - ends[-1]).max() for end in ends[:2]]
    quasi = simulate(model, Settings(dt=2.5e-4, end_time=0.4, newton=Newton(tolerance=1e-12)))
    moved = np.abs(ends[-1]).max()
    return [Row("observed order", np.log2(errors[0] / errors[1]), 2.0, "converged", 0.15,
                "second order, and 0.07 by the reference with dt = 2.5e-4", scale=1.0),
            small("difference to quasi with dt = 2.5e-4", np.abs(ends[-1] - quasi.displacement)
                  .max() / moved, 1e-3, "the rotary inertia of normals is lumped")]


def run_spin():
    """Its vibrations damped away a plate turns about its normal for ever: a relative equilibrium,
    where nothing in the element's axes changes."""
    plate = spinning(rectangle(2.0, 1.0, (4, 2)), (0.0, 0.0, 4.0), about=(1.0, 0.5, 0.0))
    damped = simulate(plate, Settings(dt=0.05, end_time=50.0, scheme=Scheme(
        "exact", dissipation=1.0, dissipates="constant")))
    still = rectangle(2.0, 1.0, (4, 2))
    result = simulate(still, Settings(dt=0.05, end_time=15.0, scheme=EXACT), start=damped.state)
    strain = result.history["strain_energy"]
    return [small("energy, 300 steps", result.drift.energy, 1e-12, ROUNDING),
            small("angular momentum", result.drift.angular_momentum, 1e-12, ROUNDING),
            small("strain energy", np.ptp(strain) / strain[0], 0.05,
                  "the part of the velocities that changes its sign with every step is not damped"),
            Row("halvings", result.history["halvings"].sum(), 0, "analytic", 0.0,
                "a correction of the force along du_L would divide by du_L = 0", scale=1.0)]


def run_turns():
    """A stiff plate about no axis of inertia, 0.22 rad a step; and about its normal, 1 rad a step.
    """
    for omega, dt, end in (((2.0, 0.3, 1.0), 0.1, 600.0), ((0.0, 0.0, 20.0), 0.05, 320.0)):
        plate = spinning(rectangle(2.0, 1.0, (2, 1)), omega, about=(1.0, 0.5, 0.0))
        result = simulate(plate, Settings(dt=dt, end_time=end, scheme=EXACT))
        name = f"{np.linalg.norm(omega) * end / (2.0 * np.pi):.0f} turns"
        yield small(f"{name}: energy", result.drift.energy, 1e-11, ROUNDING)
        yield small(f"{name}: linear momentum", result.drift.linear_momentum, 1e-12, ROUNDING)
        yield small(f"{name}: angular momentum", result.drift.angular_momentum, 1e-11, ROUNDING)
        yield small(f"{name}: length of the normals",
                    np.abs(np.linalg.norm(result.directors, axis=1) - 1.0).max(), 1e-14, "rounding")


def pendulum(dt, n):
    """Of a unit mass at p on the unit sphere under a force, by the midpoint rule with a velocity of
    three components beside the constraint |p| = 1, n steps: the largest |p . w| / |w|, and what is
    wrong with the energy.

    ``w_1 - w_0 = dt (F - l p_m)``, ``p_1 - p_0 = dt w_m``, ``|p_1| = 1``; s is ``dt^2 l / 4``.
    """
    p, w, force = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.5]), np.array([0.0, 0.0, -9.81])
    states = []
    for _ in range(n):
        c = dt * w + 0.5 * dt**2 * force
        s = (2.0 * p @ c + c @ c) / (4.0 + 2.0 * p @ c)
        end = (p * (1.0 - s) + c) / (1.0 + s)
        p, w = end, 2.0 / dt * (end - p) - w
        states.append((abs(p @ w), np.linalg.norm(w), 0.5 * w @ w - force @ p))
    across, speeds, energies = np.array(states).T
    return (across / speeds.max()).max(), np.abs(energies / 0.625 - 1.0).max()


def run_rates():
    """A spin across the normal is all the velocity that it has; with a redundant one what lies
    along p obeys ``(p . w)_1 = -(p . w)_0 + dt/4 (|w_1|^2 - |w_0|^2)``, undamped."""
    result = simulate(load_case("l-plate").model(30), Settings(dt=0.05, end_time=4.0, scheme=EXACT))
    rates = result.director_rates
    yield small("p . w over the largest |w|, L-plate, steps of 0.05 s",
                np.abs(np.sum(result.directors * rates, axis=1)).max() / np.abs(rates).max(),
                1e-15, "rounding")
    across, energy = pendulum(0.05, 2000)
    yield small("a pendulum by redundant velocities: energy", energy, 1e-11, ROUNDING)
    yield at_least("its p . w over the largest |w|", across, 1e-3,
                   "conserving, it leaves its sphere's tangents")


def run_dissipation():
    """Energy and what was lost add up, energy never rises, momenta stay; orders of the loss."""
    L_plate = load_case("l-plate").model(30)
    for dissipates in ("selective", "constant"):
        scheme = Scheme("exact", dissipation=0.5, dissipates=dissipates)
        result = simulate(L_plate, Settings(dt=0.02, end_time=3.0, scheme=scheme))
        energy = (total_energy(result.history) - result.history["external_work"])
        yield small(f"{dissipates}: energy + lost - works", gap(result), 1e-11, ROUNDING)
        yield Row(f"{dissipates}: steps in which energy less work rises",
                  np.sum(np.diff(energy) > 0.0), 0, "analytic", 0.0,
                  "the loss of an element is a sum of squares", scale=1.0)
        yield small(f"{dissipates}: linear momentum", result.drift.linear_momentum, 1e-12, ROUNDING)
        yield small(f"{dissipates}: angular momentum", result.drift.angular_momentum, 1e-11,
                    ROUNDING)
        lost = [simulate(swinging(), Settings(dt=dt, end_time=0.4, scheme=scheme))
                .history["dissipated"][-1] for dt in (2e-3, 1e-3)]
        order = {"selective": 3.0, "constant": 1.0}[dissipates]
        yield Row(f"{dissipates}: order of what is lost", np.log2(lost[0] / lost[1]), order,
                  "analytic", 0.1, "resolved motion: lags of dt^2 and of 1 times D ~ dt^2 a step",
                  scale=1.0)


CASES = (
    Case("discrete-jacobian", "exact", "finite increments of the local variables without error, "
         "blind to rigid motion", "own", "elements 2 x 2, distorted and warped; both ends of a "
         "step strained by 30 %, turned by 1 rad", run_jacobian),
    Case("exact-conservation", "exact", "energy and momenta to rounding error, under loads too",
         "own", "plates, a patch, a fold, a box", run_conservation),
    Case("exact-order", "exact", "second order of accuracy in time", "own",
         "free plate 2 x 1 x 0.1, E = 100: all its frequencies are resolved", run_order),
    Case("exact-spin", "exact", "a relative equilibrium stays one", "own",
         "plate 2 x 1 x 0.1 about its normal, 4 rad/s, 0.2 rad a step", run_spin),
    Case("exact-turns", "exact", "no drift in a thousand turns", "own",
         "plate 2 x 1 x 0.1, 2 elements", run_turns, slow=True),
    Case("exact-rates", "exact", "rates stay across their normals", "own",
         "L-plate; beside it a pendulum by redundant velocities", run_rates),
    Case("exact-dissipation", "exact", "dissipation that takes energy alone", "own",
         "L-plate; free plate 2 x 1 x 0.1, E = 100", run_dissipation),
)
