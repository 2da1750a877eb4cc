"""Shells of any size, stiffness, load and step: energy is work and forces balance, or it is said
that they do not."""

import math
import warnings
from dataclasses import replace

import numpy as np

from corovec import (
    AccuracyWarning,
    InputError,
    Model,
    Newton,
    NodalLoad,
    NodalMoment,
    Pressure,
    Scheme,
    Settings,
    StabilityWarning,
    StaticSettings,
    StepError,
    Support,
    TimeFunction,
    block,
    join,
    load_control,
    rigid_velocity,
    simulate,
    solve_linear,
    total_energy,
    warm_up,
)
from corovec.solver.dynamics.balance import END_SHARE, RUN_SHARE
from corovec.solver.model.mesh import vector_areas
from corovec.solver.system.system import ROUNDOFF

from .campaign import Fault, Target

FEW_PERCENT = 0.05
"""Part of the largest energy by which a run that warns may miss the work of its loads; one that
dissipates, whose work is not exact, by the bound of the solver."""

UNBALANCED = 1e-3
"""Part of the largest force that statics may leave without a word: rounding, of which a warning
speaks from there on."""

DRIFT = 1e-10
"""Largest change of what the exact scheme conserves, relative to its largest value, beside what
rounding of strains leaves of energies as small."""

SMALL = 1e-4
"""Turn up to which a shell is linear: to 1e-2, with moments and pressure that follow it."""


def prepare(folder):
    warm_up(exact=True)


def power(chance, low, high):
    """A number whose logarithm is uniform."""
    return 10.0 ** chance.uniform(low, high)


def mesh(chance, size):
    """Nodes and quads of a plate, of two that meet at a fold, or of three on one edge."""
    n, m = chance.randrange(1, 4), chance.randrange(1, 4)
    width = size * chance.uniform(0.3, 1.0)
    angles = chance.choice(((0.0,), (0.0,), (0.0, chance.uniform(50.0, 130.0)), (0.0, 90.0, 180.0)))
    turns = [(np.cos(np.radians(angle)), np.sin(np.radians(angle))) for angle in angles]
    made = join([block([(0, 0, 0), (size * c, 0, size * s), (size * c, width, size * s),
                        (0, width, 0)], (n, m)) for c, s in turns])
    return made.nodes, made.quads


def loads(chance, nodes, scale, history):
    """Forces, moments and pressure; the forces are of the size ``scale`` [N]."""
    size, found = np.ptp(nodes, axis=0).max(), []
    for _ in range(chance.randrange(1, 4)):
        node, along = chance.randrange(len(nodes)), [chance.gauss(0, 1) for _ in range(3)]
        kind = chance.randrange(4)
        if kind < 2:
            found.append(NodalLoad(node, scale * np.array(along), history))
        elif kind == 2:
            found.append(NodalMoment(node, size * scale * np.array(along), history))
        else:
            found.append(Pressure(scale * along[0] / size**2, None, history))
    return found


def support(chance, nodes):
    """The edge that all plates have in common clamped, or hinged beside another."""
    def edge(place):
        return Support(np.flatnonzero(np.abs(nodes[:, 0] - place) < 1e-9 * size), held)

    size, far = np.abs(nodes).max(), nodes[:, 0].max()
    held = ("x", "y", "z", "px", "py", "pz")[:chance.choice((3, 6))]
    return [edge(0.0)] if len(held) == 6 else [edge(0.0), edge(far)]


def sketched(chance):
    """A mesh, its size [m], thickness [m], Poisson's ratio and density [kg/m^3]."""
    size = power(chance, -3, 2)
    nodes, quads = mesh(chance, size)
    return nodes, quads, size, size * power(chance, -6, -0.5), chance.uniform(0, 0.45), power(
        chance, 0, 4)


def moving(chance):
    """A model, free or supported, from rest or not, and its settings."""
    nodes, quads, size, thickness, poisson, density = sketched(chance)
    dt = power(chance, -5, 3)
    youngs = min(power(chance, 0, 12) * density * (size / dt)**2, 1e25)
    turn = power(chance, -8, chance.choice((0.0, 0.0, 0.7, 4.0)))
    scale = turn * density * size**2 * thickness / dt**2 / 25.0
    seconds = dt * 2 * chance.randrange(1, 5)
    pulse = TimeFunction((0.0, seconds / 2, seconds), (0.0, 1.0, 0.0))
    held = support(chance, nodes) if chance.random() < 0.3 else []
    given = {"thickness": thickness, "youngs": youngs, "poisson": poisson, "density": density,
             "loads": loads(chance, nodes, scale, pulse) if chance.random() < 0.8 else []}
    model = Model(nodes, quads, **given, supports=held)
    if not held and chance.random() < 0.6:
        velocity, omega = ([power(chance, -6, 0.5) * chance.gauss(0, 1) / dt for _ in range(3)]
                           for _ in range(2))
        v, w = rigid_velocity(model, size * np.array(velocity), omega, nodes.mean(axis=0))
        if chance.random() < 0.5:
            v = v * (1.0 + 0.3 * np.array([[chance.gauss(0, 1)] for _ in nodes]))
        model = Model(nodes, quads, **given, velocity=v, normal_velocity=w)
    scheme = Scheme(rho_inf=chance.choice((1.0, 1.0, chance.random(), 0.0)),
                    axes=chance.choice(("nodal", "nodal", "global")))
    return model, Settings(dt=dt, end_time=20 * dt, scheme=scheme,
                           newton=Newton(chance.choice(("modified", "full"))))


def flying(chance):
    """A free model for the scheme ``exact``, and its settings: E dt^2/(rho L^2) from 1 to 1e10,
    loads that turn it, about the axis of its least inertia, by 1e-6 to 0.05 rad in the first step,
    a rigid motion of up to about 0.3 rad a step.

    A moment is no more than a node resists: a larger one winds it up alone, for ever.
    """
    nodes, quads, size, _, poisson, density = sketched(chance)
    if chance.random() < 0.4:
        nodes = nodes + 0.05 * size * np.array([[chance.uniform(-1, 1) for _ in range(3)]
                                                for _ in nodes])
    thickness, dt = size * power(chance, -2.5, -0.8), power(chance, -5, 3)
    youngs, turn = power(chance, 0, 10) * density * (size / dt)**2, power(chance, -6, -1.3)
    seconds = dt * 2 * chance.randrange(1, 4)
    pulse = TimeFunction((0.0, seconds / 2, seconds), (0.0, 1.0, 0.0))
    model = Model(nodes, quads, thickness, youngs, poisson, density)
    inertia = np.linalg.eigvalsh(model.mass_properties.inertia)[0]
    force = turn * inertia / (size * dt**2)
    bending = min(1.0, 0.1 * turn * youngs * thickness**3 / (size * force))
    given = [replace(load, moment=bending * np.array(load.moment))
             if isinstance(load, NodalMoment) else load
             for load in loads(chance, nodes, force, pulse)]
    model = replace(model, loads=given)
    if chance.random() < 0.6:
        velocity, omega = ([power(chance, -4, -0.5) * chance.gauss(0, 1) / dt for _ in range(3)]
                           for _ in range(2))
        v, w = rigid_velocity(model, size * np.array(velocity), omega, nodes.mean(axis=0))
        model = replace(model, velocity=v, normal_velocity=w)
    scheme = Scheme("exact", dissipation=chance.choice((0.0, 0.0, chance.random())),
                    dissipates=chance.choice(("selective", "constant")))
    if not scheme.dissipation and chance.random() < 0.1:
        scheme = Scheme("exact", order=4)
    return model, Settings(dt=dt, end_time=12 * dt, scheme=scheme,
                           newton=Newton(chance.choice(("modified", "full"))))


def attempt_exact(chance, prepared, folder):
    try:
        model, settings = flying(chance)
    except InputError:  # its folds make no shell
        return "refused"
    result, _ = recorded(simulate, model, settings)
    check_conserved(model, result)
    return "halved" if result.history["halvings"].any() else "conserved"


def check_conserved(model, result):
    """Raise ``Fault`` where a free shell gains or loses what is none of its loads, or, by
    dissipation, gains energy."""
    history, n = result.history, len(result.history)
    energy, work = total_energy(history), history["external_work"]
    peak = max(energy.max(), np.abs(work).max())
    corners = model.nodes[model.quads]
    areas = np.linalg.norm(vector_areas(corners), axis=1)
    stretch = float(np.sum(model.youngs * model.thickness * areas))
    most = DRIFT + n * ROUNDOFF * math.sqrt(stretch / peak)
    missed = energy - energy[0] - work + history["dissipated"]
    off, off_balance = np.abs(missed).max() / peak, result.balance
    if not off <= most:
        raise Fault(f"energy and works differ by {off:.2g} of the largest, {most:.2g} are allowed")
    if not max(off_balance.forces, off_balance.moments) <= most:
        raise Fault(f"momenta miss their impulses by {off_balance}")
    if np.any(np.diff(history["dissipated"]) < 0.0):
        raise Fault("dissipation gave energy")


def recorded(function, *arguments):
    """What a run returns, and whether it warned of its accuracy; loads on held nodes do nothing."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        warnings.filterwarnings("ignore", "no load does anything")
        warnings.simplefilter("ignore", StabilityWarning)
        result = function(*arguments)
    for warning in told:
        if not issubclass(warning.category, AccuracyWarning):
            raise Fault(f"{warning.category.__name__}: {warning.message}")
    return result, bool(told)


def gap(result):
    """Largest difference of energy and work, relative to the largest of both; of a scheme that
    dissipates what is gained alone."""
    history = result.history
    for name in history.dtype.names:
        if not np.all(np.isfinite(history[name])):
            raise Fault(f"{name} is not finite")
    energy, work = total_energy(history), history["external_work"]
    missed = energy - energy[0] - work
    wrong = missed if result.settings.scheme.rho_inf < 1.0 else np.abs(missed)
    peak = max(energy.max(), np.abs(work).max())
    return wrong.max() / peak if peak > 0.0 else 0.0


def attempt_dynamics(chance, prepared, folder):
    model, settings = moving(chance)
    try:
        result, warned = recorded(simulate, model, settings)
    except (InputError, StepError) as error:
        return type(error).__name__
    missed = gap(result)
    most = FEW_PERCENT if settings.scheme.rho_inf == 1.0 else END_SHARE
    if not missed <= (most if warned else RUN_SHARE):
        raise Fault(f"energy and work differ by {missed:.2g} of the largest, "
                    f"{'with a' if warned else 'no'} warning")
    return "warned" if warned else "balanced"


def hanging(chance):
    """A supported model under loads of any size, the size of its linear turn."""
    nodes, quads, size, thickness, poisson, density = sketched(chance)
    youngs = power(chance, 0, 12)
    scale = power(chance, -8, 3) * youngs * thickness**3 / size
    return Model(nodes, quads, thickness, youngs, poisson, density,
                 loads=loads(chance, nodes, scale, TimeFunction((0.0,), (1.0,))),
                 supports=support(chance, nodes))


def applied(model, x):
    """Sum of all loads (3,), and the sum of their magnitudes [N], at positions ``x``."""
    forces = [np.array(load.force) for load in model.loads if isinstance(load, NodalLoad)]
    for load in model.loads:
        if isinstance(load, Pressure):
            forces.extend(load.pressure * vector_areas(x[model.quads]))
    return np.sum(forces, axis=0) if forces else np.zeros(3), sum(map(np.linalg.norm, forces))


def attempt_statics(chance, prepared, folder):
    model = hanging(chance)
    try:
        result, warned = recorded(load_control, model, [1.0], StaticSettings(max_divisions=5))
        linear, linear_warned = recorded(solve_linear, model)
    except (InputError, StepError) as error:
        return type(error).__name__
    if warned or linear_warned:
        return "warned"
    u, reactions = result.displacement[-1], result.reactions[-1]
    _check_forces(model, u, reactions)
    turned = np.abs(linear.change_of_normals).max()
    moved = np.abs(linear.displacement).max()
    size = max(moved, np.finfo(float).eps * model.size)  # held loads
    if max(turned, moved / model.thickness[0]) > SMALL:
        return "balanced"
    if not np.abs(u - linear.displacement).max() <= 1e-2 * size:
        raise Fault(f"at a turn of {turned:.1g} load control and the linear solution differ by "
                    f"{np.abs(u - linear.displacement).max() / size:.2g}")
    return "balanced, linear"


def _check_forces(model, u, reactions):
    force, magnitude = applied(model, model.nodes + u)
    largest = max(magnitude, np.abs(reactions).sum())
    missed = np.linalg.norm(force + reactions.sum(axis=0))
    if not missed <= UNBALANCED * largest:
        raise Fault(f"loads and reactions leave {missed / largest:.2g} of the largest force")


DYNAMICS = Target("dynamics", "energy is work, or a warning or an error says that it is not",
                  prepare, attempt_dynamics)
STATICS = Target("statics", "reactions balance the loads, small loads act linearly, or it is said",
                 prepare, attempt_statics)
EXACT = Target("exact", "the exact scheme always gets to the end, energy is work, momenta are "
               "impulses", prepare, attempt_exact)
