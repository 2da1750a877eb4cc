"""A satellite panel of two plates at 60 degrees spins about its intermediate axis, and turns over.

Usage: python satellite.py [PICTURE]
"""

import sys
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

from corovec import Model, Newton, Settings, block, join, rigid_velocity, simulate

s, c = np.sin(np.pi / 3.0), np.cos(np.pi / 3.0)
mesh = join([block([(-1, 0, 0), (0, 0, 0), (0, 1.5, 0), (-1, 1.5, 0)], (4, 6)),
             block([(0, 0, 0), (c, 0, s), (c, 1.5, s), (0, 1.5, 0)], (4, 6))])
model = Model.of(mesh, thickness=0.02, youngs=1e8, poisson=0.3, density=100.0)
moments, axes = np.linalg.eigh(model.inertia)  # ascending; axes are columns
spin = axes @ (0.0, 2.0, 0.02)  # [rad/s], one percent aside
velocity, normal_velocity = rigid_velocity(model, (0.0, 0.0, 0.0), spin, about=model.centre)
flying = replace(model, velocity=velocity, normal_velocity=normal_velocity)
probes = {"a": (-1.0, 0.0, 0.0), "b": (c, 0.0, s), "c": (-1.0, 1.5, 0.0)}

result = simulate(flying, Settings(dt=0.025, end_time=60.0, newton=Newton(tolerance=1e-14)),
                  probes=probes)

momentum = result.history["angular_momentum"]
arms = np.array(list(probes.values())) - model.centre
middle = sum(part * (arm + result.probes[name]["displacement"])
             for part, arm, name in zip(np.linalg.solve(arms.T, axes[:, 1]), arms, probes))
cosine = middle @ momentum[0] / np.linalg.norm(momentum[0])
time = result.history["time"]
flips = time[1:][cosine[:-1] * cosine[1:] < 0.0]
print(f"principal moments of inertia {moments.round(4).tolist()} kg m^2")
print(f"it turns over at {flips.round(2).tolist()} s")
print(f"momenta changed by {result.drift.linear_momentum:.1e} and "
      f"{result.drift.angular_momentum:.1e}, energy by {result.drift.energy:.1e}")

fig, panel = plt.subplots(figsize=(5, 3), layout="constrained")
panel.plot(time, cosine)
panel.set(xlabel="time [s]", ylabel="cosine between intermediate\naxis and angular momentum")
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "satellite.png", dpi=100)
