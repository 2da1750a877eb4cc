"""A round panel with a hole, a mesh of Gmsh, bends under pressure and vibrates when that is gone.

Its rim is clamped, the edge of the hole is free.
Usage: python panel.py [PICTURE]
"""

import sys
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from corovec import Mesh, Model, Pressure, Settings, Support, load_control, simulate, stresses

mesh = Mesh.read(Path(__file__).with_name("panel.msh"))  # elements skin; lines rim and hole
model = Model.of(mesh, thickness=0.01, youngs=70e9, poisson=0.33, density=2700.0,
                 loads=[Pressure(1000.0, mesh.groups["skin"])],
                 supports=[Support(mesh.node_sets["rim"], ("x", "y", "z", "px", "py", "pz"))])
hole = mesh.node_sets["hole"]

static = load_control(model, [1.0])
found = stresses(model, static.states[-1])
result = simulate(replace(model, loads=[]), Settings(dt=1e-4, end_time=0.1),
                  start=static.states[-1], probes={"edge": hole[0]})

time, height = result.history["time"], result.probes["edge"]["displacement"][:, 2]
upwards = time[1:][(height[:-1] < 0.0) & (height[1:] >= 0.0)]
print(f"the rim holds {-static.reactions[-1, :, 2].sum():.2f} N; "
      f"the hole rises by {1e6 * static.displacement[-1, hole, 2].mean():.2f} um")
print(f"von Mises stress {1e-6 * found.von_mises.max():.3f} MPa at most")
print(f"released, it vibrates with {1.0 / np.diff(upwards).mean():.2f} Hz")

fig, (left, right) = plt.subplots(1, 2, figsize=(8, 3), layout="constrained")
halves = np.vstack([mesh.quads[:, :3], mesh.quads[:, [0, 2, 3]]])
drawn = left.tripcolor(*mesh.nodes[:, :2].T, halves,
                       facecolors=1e-6 * np.tile(found.von_mises[:, 0], 2))
fig.colorbar(drawn, label="von Mises stress, top [MPa]")
left.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
right.plot(time, 1e6 * height)
right.set(xlabel="time [s]", ylabel="edge of the hole [µm]")
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "panel.png", dpi=100)
