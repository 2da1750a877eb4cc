"""Joints: the work of a hinge's moment, conservation with every kind of moment, a rigid limit."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from corovec import (
    Ball,
    Gravity,
    Hinge,
    Mesh,
    Model,
    NodalLoad,
    Revolute,
    RigidBody,
    Scheme,
    Settings,
    Support,
    TimeFunction,
    block,
    cut,
    simulate,
)
from corovec.solver.kernels import hinges
from corovec.solver.kernels.arguments import Motion, Nodes
from corovec.solver.model.mesh import node_at

from ..case import Case, at_least, small

EXACT = Scheme("exact")
HAT = TimeFunction((0.0, 0.5, 1.0), (0.0, 1.0, 0.0))
TURN = TimeFunction((0.0, 1.0), (0.0, 1.0))
MOMENTS = {
    "free": {},
    "spring": {"stiffness": 3.0, "rest": 1.0},
    "servo": {"stiffness": 6.0, "rest": 1.5, "turning": TURN},
    "damper": {"damping": 0.5},
    "spring table": {"spring_angles": (-0.6, -0.1, 0.0, 0.1, 0.5),
                     "spring_moments": (-4.0, -2.0, 0.0, 0.2, 5.0), "rest": 0.5, "turning": TURN},
    "damper table": {"damper_rates": (-1.0, -0.1, 0.1, 1.0),
                     "damper_moments": (-1.0, -0.6, 0.6, 1.0)},
    "stops": {"stops": (-0.3, 0.3), "stop_stiffness": 50.0},
    "latch": {"stiffness": 3.0, "rest": 2.0, "lock": 0.3, "lock_stiffness": 200.0,
              "lock_damping": 1.0},
    "motor": {"torque": 2.0, "history": TimeFunction((0.0, 1.0, 2.0), (0.0, 1.0, 0.0))},
}
ROUNDED = "rounding of residuals, gathered over the steps"



def measured(e, p_a, p_b):
    """The angle from its definition."""
    return np.arctan2(e @ np.cross(p_a, p_b) / np.linalg.norm(e), p_a @ p_b)


def kernel_forces(start, end, moment=1.0):
    """Forces of a moment on the edge, p_a and p_b by the solver's kernel; ``start`` and ``end``:
    (e, p_a, p_b)."""
    (e_0, *p_0), (e_1, *p_1) = start, end
    nodes = Nodes(np.array([0, 5]), np.array([2, 2]), np.arange(3), np.zeros((2, 3)))
    place = np.array([[0.3, -0.2, 0.7]])
    x = np.concatenate([place, place + e_0])
    motion = Motion(x, np.zeros_like(x), np.zeros((2, 3)), np.zeros((2, 3, 3)), np.zeros(10),
                    np.zeros(10))
    delta = np.zeros(10)
    delta[5:8] = e_1 - e_0
    constants = np.array([[0, 0, 0, -np.inf, np.inf, 0, np.inf, 0, 0, 0, 0]], dtype=float)
    one, edge, on = np.array([[0, 1]]), np.zeros(3), np.zeros((2, 3))
    for columns in ([0, 1, 2], [2, 0, 1]):
        A1 = np.tile(np.ascontiguousarray(np.eye(3)[:, columns]), (2, 1, 1))
        forces = np.zeros(10)
        hinges.add_hinge_forces(
            nodes, one, one, one, constants, np.zeros((1, 3)), np.array([moment]), np.zeros(1),
            motion, delta, EXACT.midpoint(0.1), np.array(p_0), np.array(p_1), A1, forces,
            np.zeros((1, 6)))
        assert np.array_equal(forces[:3], -forces[5:8])
        edge, on[:, columns[0]], on[:, columns[1]] = forces[5:8], forces[3::5], forces[4::5]
    return np.stack([edge, *on])


def folded(rng, angle, turn):
    """(e, p_a, p_b) of a hinge that has folded by ``angle``, normals a little off its axis, and
    turned by a rotation vector."""
    p_b = Rotation.from_rotvec((angle, 0.0, 0.0)).apply((0.0, 0.0, 1.0))
    parts = [(rng.uniform(0.5, 2.0), 0.0, 0.0), *(
        p + rng.uniform(-0.1, 0.1, 3) for p in ((0.0, 0.0, 1.0), p_b))]
    e, *normals = Rotation.from_rotvec(turn).apply(parts)
    return np.array([e, *(p / np.linalg.norm(p) for p in normals)])


def random_step(rng):
    """Both ends of a step of a hinge."""
    angle, first = rng.uniform(-3.0, 3.0), rng.normal(size=3)
    return (folded(rng, angle, first), folded(rng, angle + rng.uniform(-1.0, 1.0),
                                              first + 0.5 * rng.normal(size=3)))


def errors(forces, start, end):
    """What the work and the moment about the origin are off by, of a moment 1 of the hinge."""
    change = measured(*end) - measured(*start)
    change -= 2.0 * np.pi * np.round(change / (2.0 * np.pi))
    work = np.sum(forces * (end - start)) - change
    return abs(work), np.abs(np.cross(0.5 * (start + end), forces).sum(axis=0)).max()


def midpoint_forces(start, end):
    """The wrong variant: the derivative of the angle in the middle."""
    middle, step, found = 0.5 * (start + end), 1e-6, np.zeros((3, 3))
    for k in np.ndindex(3, 3):
        for sign in (0.5, -0.5):
            moved = middle.copy()
            moved[k] += sign * step
            found[k] += 2.0 * sign * measured(*moved) / step
    return found


def chain(n=3, divisions=(2, 2), **moments):
    """A free chain of n hinged plates 2 m x 1 m along x, under forces at three corners."""
    mesh = block([(0, 0, 0), (2.0 * n, 0, 0), (2.0 * n, 1, 0), (0, 1, 0)],
                 (n * divisions[0], divisions[1]))
    joints = []
    for k in range(1, n):
        mesh, *sides = cut(mesh, (2.0 * k, 0, 0), (2.0 * k, 1, 0))
        joints.append(Hinge(*sides, name=f"h{k}", **moments))
    corners = ((0.0, 0.0, 0.0), (2.0 * n, 1.0, 0.0), (2.0 * n, 0.0, 0.0))
    loads = [NodalLoad(node_at(mesh.nodes, corner), (0.0, 0.0, force), HAT)
             for corner, force in zip(corners, (8.0, 5.0, -9.0))]
    return Model.of(mesh, 0.02, 2e8, 0.3, 1000.0, loads=loads, joints=joints)


def drifts(result):
    """Largest errors of energy and works, of both momenta and the impulses of loads, relative."""
    history = result.history
    found, (dt, *_) = [abs(result.energy_balance)], np.diff(history["time"])
    for momentum, load in (("linear_momentum", "load"), ("angular_momentum", "load_moment")):
        missed = history[momentum] - dt * np.cumsum(history[load], axis=0)
        found.append(np.abs(missed - missed[0]).max() / np.abs(history[momentum]).max())
    return np.array(found)


def double_pendulum(bodies, gravity, start, times):
    """Angles (n, 2) from the vertical of two rigid bodies, hinged at the origin and at the end of
    the first; ``bodies``: (mass, place of its centre, moment of inertia about its centre, length).
    """
    (m1, c1, I1, l1), (m2, c2, I2, _) = bodies

    def rates(_, y):
        a, b, da, db = y
        cos, sin = np.cos(a - b), np.sin(a - b)
        M = np.array([[I1 + m1 * c1**2 + m2 * l1**2, m2 * l1 * c2 * cos],
                      [m2 * l1 * c2 * cos, I2 + m2 * c2**2]])
        f = [-m2 * l1 * c2 * sin * db**2 - (m1 * c1 + m2 * l1) * gravity * np.sin(a),
             m2 * l1 * c2 * sin * da**2 - m2 * c2 * gravity * np.sin(b)]
        return [da, db, *np.linalg.solve(M, f)]

    return solve_ivp(rates, times[[0, -1]], [*start, 0.0, 0.0], "DOP853", times, rtol=1e-12,
                     atol=1e-12).y[:2].T


def swung():
    """How far hinge and end of two stiff plates, released level and hung from an edge that turns
    freely, are from those of rigid bodies [m], the largest in 1 s."""
    mesh = block([(0, 0, 0), (2, 0, 0), (2, 0.5, 0), (0, 0.5, 0)], (4, 1))
    mesh, *sides = cut(mesh, (1, 0, 0), (1, 0.5, 0))
    top = np.flatnonzero(mesh.nodes[:, 0] < 1e-9)
    model = Model.of(mesh, 0.05, 1e12, 0.0, 1000.0, loads=[Gravity((0.0, 0.0, -9.81))],
                     joints=[Hinge(*sides)], supports=[Support(top, ("x", "y", "z"))])
    result = simulate(model, Settings(dt=0.001, end_time=1.0, scheme=EXACT), probes={
        "end": (2.0, 0.0, 0.0), "elbow": sides[0][0]})
    mass = 1000.0 * 0.05 * 0.5
    bodies = [(mass, 0.5, mass * (1.0 + 0.05**2) / 12.0, 1.0)] * 2
    angles = double_pendulum(bodies, 9.81, (np.pi / 2, np.pi / 2), result.history["time"])
    arms = np.stack([np.sin(angles), -np.cos(angles)], axis=2)
    for name, place, start in (("elbow", arms[:, 0], 1.0), ("end", arms.sum(axis=1), 2.0)):
        moved = result.probes[name]["displacement"][:, [0, 2]] + (start, 0.0)
        yield np.abs(moved - place).max()


def run_work():
    """Worst of 200 random hinges and steps."""
    found = []
    for seed in range(200):
        start, end = random_step(np.random.default_rng(seed))
        found.append((*errors(kernel_forces(start, end), start, end),
                      errors(midpoint_forces(start, end), start, end)[0]))
    work, moment, wrong = np.transpose(found)
    return [small("work - M (phi_1 - phi_0)", work.max(), 1e-14, "rounding; M = 1"),
            small("moment of its forces about the origin", moment.max(), 1e-14, "rounding; M = 1"),
            at_least("work by the derivative of the angle in the middle", np.median(wrong), 1e-3,
                     "it is no discrete gradient")]


def run_conservation():
    """Energy and losses less works, momenta less impulses."""
    for kind, moments in MOMENTS.items():
        result = simulate(chain(**moments), Settings(dt=0.02, end_time=2.0, scheme=EXACT))
        energy, linear, angular = drifts(result)
        yield small(f"{kind}: energy + lost - works", energy, 1e-11, ROUNDED)
        yield small(f"{kind}: L - impulses", linear, 1e-12, ROUNDED)
        yield small(f"{kind}: J - moments of impulses", angular, 1e-11, ROUNDED)
    quasi = drifts(simulate(chain(**moments), Settings(dt=0.02, end_time=2.0)))
    yield at_least("the last by quasi: energy + lost - works", quasi[0], 1e-9,
                   "of second order in dt")


def linked(joint):
    """Two free plates 2 m x 1 m, each with a body at its inner edge, and a joint between these at
    the origin, under forces at three corners."""
    plates = [block([(x, -0.5, 0), (x + 2, -0.5, 0), (x + 2, 0.5, 0), (x, 0.5, 0)], (2, 2))
              for x in (0.2, -2.2)]
    n = len(plates[0].nodes)
    mesh = Mesh(np.concatenate([plate.nodes for plate in plates]),
                np.concatenate([plates[0].quads, plates[1].quads + n]))
    bodies = [RigidBody(name, mass, (2.0, 3.0, 4.0), centre, np.flatnonzero(
        np.abs(mesh.nodes[:, 0] - x) < 1e-9).tolist()) for name, mass, centre, x in (
            ("a", 20.0, (0.1, 0.0, 0.0), 0.2), ("b", 30.0, (-0.1, 0.0, 0.1), -0.2))]
    corners = ((2.2, 0.5, 0.0), (-2.2, -0.5, 0.0), (2.2, -0.5, 0.0))
    loads = [NodalLoad(node_at(mesh.nodes, corner), force, HAT)
             for corner, force in zip(corners, ((0, 0, 16.0), (2.0, 6.0, 10.0), (0, 5.0, -9.0)))]
    return Model.of(mesh, 0.02, 2e8, 0.3, 1000.0, loads=loads, joints=[joint], bodies=bodies)


def apart(model, result):
    """Distance at the end of the points of two bodies that were at the origin, over the shell's
    size, and the difference of their velocities over the fastest node's."""
    first, x, found = model.directors.first, model.nodes + result.displacement, []
    for i in range(len(model.nodes) - 2, len(model.nodes)):
        own = slice(first[i], first[i] + 3)
        arm = -model.normals[own] @ model.nodes[i]
        found.append((x[i] + arm @ result.directors[own],
                      result.velocity[i] + arm @ result.director_rates[own]))
    (place, rate), (other, other_rate) = found
    return (np.linalg.norm(place - other) / model.size,
            np.linalg.norm(rate - other_rate) / np.linalg.norm(result.velocity, axis=1).max())


def run_linked():
    """Energy and losses less works, momenta less impulses, and how far joints come apart."""
    origin, axis = (0.0, 0.0, 0.0), (1.0, 0.3, 0.2)
    for kind, joint in (("ball", Ball("a", "b", origin)), ("revolute with spring and damper",
                        Revolute("a", "b", origin, axis, stiffness=4.0, damping=0.5))):
        model = linked(joint)
        result = simulate(model, Settings(dt=0.02, end_time=2.0, scheme=EXACT))
        energy, linear, angular = drifts(result)
        gap, rate = apart(model, result)
        yield small(f"{kind}: energy + lost - works", energy, 1e-11, ROUNDED)
        yield small(f"{kind}: L - impulses", linear, 1e-12, ROUNDED)
        yield small(f"{kind}: J - moments of impulses", angular, 1e-11, ROUNDED)
        yield small(f"{kind}: points apart, over the size", gap, 1e-12, ROUNDED)
        yield small(f"{kind}: their velocities, over the fastest", rate, 1e-10, ROUNDED)


def run_pendulum():
    elbow, end = swung()
    reason = "second order in dt, bending of E = 1e12"
    return [small("hinge", elbow, 1e-4, reason), small("end", end, 1e-4, reason)]


CASES = (
    Case("hinge-work", "joints", "a moment does the work moment times change of angle in any step, "
         "blind to rigid motion", "own", "folds up to 4 rad, normals off the axis, 1 rad of "
         "rotation a step", run_work),
    Case("joint-conservation", "joints", "energy and momenta to rounding error with springs, "
         "servos, dampers, stops, latches and motors", "own", "three free plates 2 x 1 x 0.02",
         run_conservation),
    Case("linked-conservation", "joints", "energy and momenta to rounding error with bodies and "
         "multipliers, nothing comes apart", "own", "two free plates 2 x 1 x 0.02 on bodies of 20 "
         "and 30 kg", run_linked),
    Case("double-pendulum", "joints", "stiff plates swing as rigid bodies do", "own",
         "two plates 1 x 0.5 x 0.05, E = 1e12, 1 s against DOP853", run_pendulum),
)
