"""Three plates that meet along a line spin freely: both momenta stay what they were.

Usage: python t_junction.py [PICTURE]
"""

import sys
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

from corovec import Model, Settings, rigid_velocity, simulate

N, SPIN = 4, (0.3, 0.0, 2.0)  # elements a side, [rad/s]
where = {}


def number(*point):
    """The node at a point; plates share those of their common line."""
    return where.setdefault(tuple(np.round(point, 9)), len(where))


quads = [[number(s[i] * dx, s[i] * dy, z) for i, z in ((j, z1), (j + 1, z1), (j + 1, z2), (j, z2))]
         for dx, dy in ((-1.0, 0.0), (1.0, 0.0), (0.0, 1.0))
         for s in [np.linspace(0.0, 1.0, N + 1)]
         for j in range(N) for z1, z2 in zip(s[:-1], s[1:])]
nodes = np.array(list(where))
model = Model(nodes, quads, thickness=0.02, youngs=2e7, poisson=0.3, density=100.0)
centre = (0.0, 1.0 / 6.0, 0.5)  # of mass [m]
velocity, normal_velocity = rigid_velocity(model, (0.5, 0.0, 0.0), SPIN, about=centre)
model = replace(model, velocity=velocity, normal_velocity=normal_velocity, normals=None)

result = simulate(model, Settings(dt=5e-3, end_time=5.0))

history, drift = result.history, result.drift
print(f"linear momentum {history['linear_momentum'][-1].round(9).tolist()} kg m/s")
print(f"angular momentum about the origin {history['angular_momentum'][-1].round(6).tolist()} "
      f"kg m^2/s, changed by {drift.angular_momentum:.1e}; energy by {drift.energy:.1e}")

fig, axes = plt.subplots(figsize=(5, 3), layout="constrained")
for c in range(3):
    axes.plot(history["time"], history["angular_momentum"][:, c], label="xyz"[c])
axes.set(xlabel="time [s]", ylabel="angular momentum [kg m²/s]")
axes.legend(loc="center right")
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "t_junction.png", dpi=100)
