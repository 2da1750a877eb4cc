"""A box of folded sheets is shaken at its base, in its first mode, with five percent of damping.

Usage: python shaken.py [PICTURE]
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import corovec as cv

A, HEIGHT, RATIO, SHAKE = 0.2, 1.5, 0.05, 1e-3  # [m], [m], [-], [m]
ring = [(0, 0), (A, 0), (A, A), (0, A)]
walls = [cv.block([(*p, 0), (*q, 0), (*q, HEIGHT), (*p, HEIGHT)], (2, 6))
         for p, q in zip(ring, ring[1:] + ring[:1])]
mesh = cv.join([*walls, cv.block([(*p, HEIGHT) for p in ring], (2, 2))])
sheets = {"thickness": 0.005, "youngs": 70e9, "poisson": 0.33, "density": 2700.0}
base = mesh.nodes_at(z=0.0)

# the first mode after Rayleigh: the shape under a weight across
held = cv.Model.of(mesh, **sheets, loads=[cv.Gravity((1.0, 0.0, 0.0))],
                   supports=[cv.Support(base, ("x", "y", "z", "px", "py", "pz"))])
u, mass = cv.solve_linear(held).displacement[:, 0], held.nodal_mass
hertz = np.sqrt((mass @ u) / (mass @ u**2)) / (2.0 * np.pi)
share = u.max() * (mass @ u) / (mass @ u**2)  # of the base's acceleration that drives the top

shake = cv.Expression(f"(1 - exp(-{hertz} * t)) * sin(2 * pi * {hertz} * t)")  # from rest
model = cv.Model.of(mesh, **sheets,
                    damping=cv.Damping.of_ratios(RATIO, hertz, RATIO, 10.0 * hertz),
                    supports=[cv.Drive(base, translation=(SHAKE, 0.0, 0.0), history=shake)])
result = cv.simulate(model, cv.Settings(dt=0.025 / hertz, end_time=15.0 / hertz),
                     probes={"top": (0.0, 0.0, HEIGHT)})

history, moved = result.history, 1e3 * result.probes["top"]["displacement"][:, 0]
print(f"first mode {hertz:.1f} Hz; the top moves {1e-3 * np.abs(moved).max() / SHAKE:.2f} times as "
      f"far as the base, one mode {share / (2.0 * RATIO):.2f} times")
print(f"supports did {history['support_work'][-1]:.2f} J, damping took "
      f"{history['dissipated'][-1]:.2f} J; energy balances to {result.energy_balance:.1e}")

fig, axes = plt.subplots(figsize=(5, 3), layout="constrained")
axes.plot(history["time"], moved)
axes.set(xlabel="time [s]", ylabel="displacement of the top [mm]")
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "shaken.png", dpi=100)
