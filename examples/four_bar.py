"""A four-bar linkage: a driven crank swings a rocker by a thin strip that bends; Exudyn beside it.

Usage: python four_bar.py [PICTURE]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import corovec as cv

WIDTH, AXIS = 0.05, (0, 0, 1)
A, B, D = np.array((0.0, 0, 0)), np.array((0.3, 0, 0)), np.array((1.0, 0, 0))
C = B + 0.9 * np.array((9 / 14, np.sqrt(1 - (9 / 14)**2), 0))
DEPTH = WIDTH * np.array(AXIS)

mesh = cv.block([B, C, C + DEPTH, B + DEPTH], (32, 1))
bodies, joints = [], []
for name, ground, pin, mass in (("crank", A, B, 0.5), ("rocker", D, C, 1.0)):
    along, moment = pin - ground, mass * np.sum((pin - ground)**2) / 12
    bodies.append(cv.RigidBody(name, mass, (1e-3 * moment, moment, moment), 0.5 * (ground + pin + DEPTH),
                               axes=(along, np.cross(AXIS, along), AXIS)))
    joints += [cv.Ball(name, mesh.nodes_at(x=pin[0], z=z)[0]) for z in (0.0, WIDTH)]
turn = cv.Expression("(t**4 + 0.25**4)**0.25 - 0.25")
joints += [cv.Revolute("ground", "crank", A, AXIS, 2 * np.pi, turn, name="drive"),
           cv.Revolute("ground", "rocker", D, AXIS)]
model = cv.Model.of(mesh, 1e-3, 2.1e11, 0.0, 7850.0, bodies=bodies, joints=joints)

result = cv.simulate(model, cv.Settings(dt=0.0025, end_time=2.0, scheme=cv.Scheme("exact")), probes={
    "drive": cv.JointProbe("drive"), **{f"p{k}": tuple(B + k / 2 * (C - B)) for k in range(3)}})
