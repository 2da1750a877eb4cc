"""A four-bar linkage: a driven crank and a rocker, joined by a strip that bends; Exudyn beside it.

Usage: python four_bar.py [PICTURE]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import corovec as cv

N, DT = 32, 0.005
AXIS, DEPTH = np.array((0, 0, 1)), np.array((0, 0, 0.05))
A, B, D = np.array((0.0, 0, 0)), np.array((0.3, 0, 0)), np.array((1.0, 0, 0))
C = B + 0.9 * np.array((9 / 14, np.sqrt(1 - (9 / 14)**2), 0))
mesh = cv.block([B, C, C + DEPTH, B + DEPTH], (N, 1))
bodies, joints = [], []
for name, ground, pin, mass in (("crank", A, B, 0.5), ("rocker", D, C, 1.0)):
    bar, inertia = pin - ground, mass * np.sum((pin - ground)**2) / 12
    bodies.append(cv.RigidBody(name, mass, (0.001 * inertia, inertia, inertia),
                               (ground + pin + DEPTH) / 2, axes=(bar, np.cross(AXIS, bar), AXIS)))
    joints += [cv.Ball(name, mesh.nodes_at(x=pin[0], z=z)[0]) for z in (0.0, 0.05)]
turn = cv.Expression("2 * pi * ((t**4 + 0.25**4)**0.25 - 0.25)")  # a turn a second, from rest
joints += [cv.Revolute("ground", "crank", A, AXIS, 1.0, turn, name="drive"),
           cv.Revolute("ground", "rocker", D, AXIS)]
model = cv.Model.of(mesh, 0.006, 3e9, 0.0, 1200.0, bodies=bodies, joints=joints)

places = {"b": B, "middle": (B + C) / 2, "c": C}
result = cv.simulate(model, cv.Settings(dt=DT, end_time=2.0, scheme=cv.Scheme("exact")), probes={
    "drive": cv.JointProbe("drive"), **{name: tuple(x) for name, x in places.items()}})

known = np.loadtxt(Path(__file__).with_name("four_bar.csv"), delimiter=",").T
time, moment = result.history["time"], result.probes["drive"]["hinge_moment"]
b, middle, c = (result.probes[name]["displacement"] + x for name, x in places.items())
off = np.cross(c - b, middle - b)[:, 2] / np.linalg.norm(c - b, axis=1)
off, moment = np.interp(known[0], time, off), np.interp(known[0], time - DT / 2, moment)
print(f"the strip of 0.9 m bends by {1e3 * np.abs(off).max():.2f} mm, as Exudyn's within "
      f"{1e3 * np.abs(off - known[1]).max():.2f} mm; the drive has {np.abs(moment).max():.2f} N m, "
      f"within {np.abs(moment - known[2])[1:-1].max():.3f} N m")
print(f"energy and the work of the drive differ by {result.energy_balance:.0e}")

fig, panels = plt.subplots(2, 1, figsize=(6, 5), sharex=True, layout="constrained")
for panel, own, other, name in zip(panels, (1e3 * off, moment), (1e3 * known[1], known[2]),
                                   ("middle of the strip [mm]", "drive [N m]")):
    panel.plot(known[0], own, known[0], other, "k:")
    panel.set(ylabel=name)
panels[1].set(xlabel="time [s]")
panels[0].legend(["corovec", "Exudyn"])
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "four_bar.png", dpi=100)
