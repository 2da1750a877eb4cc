"""Plates on rigid bodies with a joint of every kind between them, and bodies alone."""

import numpy as np
from scipy.integrate import solve_ivp

from corovec import (
    Ball,
    Cylindrical,
    Expression,
    Model,
    NodalLoad,
    Prismatic,
    Revolute,
    RigidBody,
    RigidLink,
    TimeFunction,
    Universal,
    block,
    join,
)

PULSE = TimeFunction((0.0, 0.25, 0.5), (0.0, 1.0, 0.0))
AXIS = (1.0, 0.3, 0.2)


def plate(x, n=4):
    """A plate 3 m x 1 m, from x on."""
    return block(np.array([[x, -.5, 0], [x + 3, -.5, 0], [x + 3, .5, 0], [x, .5, 0]]), (n, 2))


def wings(joints=(), bodies=None, loads=True, **options):
    """Two plates, each carried at its inner edge by a body."""
    right, left = plate(0.5), plate(-3.5)
    mesh = join([right, left], apart=True)
    edges = [np.flatnonzero(np.abs(mesh.nodes[:, 0] - x) < 1e-9).tolist() for x in (0.5, -0.5)]
    if bodies is None:
        bodies = [RigidBody("a", 20.0, (2.0, 3.0, 4.0), (0.3, 0.0, 0.0), edges[0]),
                  RigidBody("b", 30.0, (3.0, 3.5, 4.0), (-0.3, 0.0, 0.1), edges[1])]
    far = [int(np.argmin(np.linalg.norm(mesh.nodes - place, axis=1)))
           for place in ((3.5, 0.5, 0.0), (-3.5, -0.5, 0.0))]
    forces = [NodalLoad(far[0], (0, 0, 16.0), PULSE), NodalLoad(far[1], (2.0, 6.0, 10.0), PULSE)]
    return Model.of(mesh, 0.02, 2e8, 0.3, 1000.0, loads=forces if loads else (), joints=joints,
                    bodies=bodies, **options)


INNER = [int(i) for i in np.flatnonzero(np.abs(np.abs(np.r_[
    plate(0.5).nodes, plate(-3.5).nodes][:, 0]) - 0.5) < 1e-9)]
"""Nodes of both inner edges."""

KINDS = {
    "one body": dict(bodies=[RigidBody("hub", 50.0, (5.0, 6.0, 8.0), (0.0, 0.0, 0.0), INNER)]),
    "ball": dict(joints=[Ball("a", "b", (0, 0, 0))]),
    "revolute": dict(joints=[Revolute("a", "b", (0, 0, 0), AXIS)]),
    "universal": dict(joints=[Universal("a", "b", (0, 0, 0), (1, 0, 0), (0, 1, 0))]),
    "cylindrical": dict(joints=[Cylindrical("a", "b", (0, 0, 0), AXIS)]),
    "prismatic": dict(joints=[Prismatic("a", "b", (0, 0, 0), (0, 1, 1))]),
    "link": dict(joints=[RigidLink("a", "b", (0.3, 0.2, 0), (-0.3, -0.2, 0.1))]),
    "link of nodes": dict(joints=[RigidLink(0, 19)], bodies=[]),
    "spring": dict(joints=[Revolute("a", "b", (0, 0, 0), AXIS, stiffness=4.0, rest=1.0)]),
    "damper": dict(joints=[Revolute("a", "b", (0, 0, 0), AXIS, damping=1.0)]),
    "stops": dict(joints=[Revolute("a", "b", (0, 0, 0), AXIS, stops=(-0.02, 0.02),
                                   stop_stiffness=20.0)]),
    "motor": dict(joints=[Revolute("a", "b", (0, 0, 0), AXIS, torque=2.0, history=PULSE)]),
    "latch": dict(joints=[Revolute("a", "b", (0, 0, 0), AXIS, stiffness=4.0, rest=2.0, lock=0.1,
                                   lock_stiffness=300.0, lock_damping=0.5)]),
    "servo": dict(joints=[Revolute("a", "b", (0, 0, 0), AXIS, stiffness=40.0, rest=1.0,
                                   turning=Expression("1-cos(t)"))]),
    "drive": dict(joints=[Revolute("a", "b", (0, 0, 0), AXIS, 1.0, Expression("1-cos(t)"))]),
    "ground": dict(joints=[Revolute("ground", "b", (0, 0, 0), AXIS), Ball("b", "a", (0, 0, 0.2))]),
    "driven from the ground": dict(joints=[
        Revolute("ground", "b", (0, 0, 0), AXIS, 1.0, Expression("1-cos(t)")),
        Ball("a", "b", (0, 0, 0))]),
}


def small():
    """A plate that has next to no mass, far away."""
    return block(np.array([[50.0, 0, 0], [51, 0, 0], [51, 1, 0], [50, 1, 0]]), (1, 1))


def alone(bodies, joints=(), **options):
    return Model.of(small(), 1e-3, 1e6, 0.3, 1e-3, bodies=bodies, joints=joints, **options)


def double_pendulum(end, lengths=(1.0, 0.8), masses=(2.0, 1.5), inertias=(0.3, 0.2), g=9.81):
    """Angles against -z of two bodies at the ends of rods, by Lagrange's equations."""
    (a, b), (m, n), (I, J) = lengths, masses, inertias

    def rates(t, y):
        p, q, u, w = y
        c, s = np.cos(p - q), np.sin(p - q)
        M = np.array([[(m + n) * a**2 + I, n * a * b * c], [n * a * b * c, n * b**2 + J]])
        f = [-n * a * b * s * w**2 - (m + n) * g * a * np.sin(p),
             n * a * b * s * u**2 - n * g * b * np.sin(q)]
        return np.r_[u, w, np.linalg.solve(M, f)]

    path = solve_ivp(rates, (0.0, end), [0.5 * np.pi, 0.5 * np.pi, 0.0, 0.0], method="DOP853",
                     rtol=1e-12, atol=1e-12)
    return path.y[:2, -1]
