"""A chain of 50 hinged plates, pinned at one end, falls from level.

Usage: python chain.py [PICTURE]
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

from corovec import Gravity, Hinge, Model, Scheme, Settings, Support, block, cut, simulate

N, LENGTH = 50, 0.1
mesh = block([(0, 0, 0), (N * LENGTH, 0, 0), (N * LENGTH, 0.1, 0), (0, 0.1, 0)], (N, 1))
hinges = []
for x in LENGTH * np.arange(1, N):
    mesh, *sides = cut(mesh, (x, 0, 0), (x, 0.1, 0))
    hinges.append(Hinge(*sides))
model = Model.of(mesh, 0.005, 70e9, 0.3, 2700.0, loads=[Gravity((0, 0, -9.81))], joints=hinges,
                 supports=[Support(mesh.nodes_at(x=0.0), ("x", "y", "z"))])
ends = {f"p{k}": (k * LENGTH, 0, 0) for k in range(0, N + 1, 2)}

result = simulate(model, Settings(dt=0.00125, end_time=1.0, scheme=Scheme("exact")), probes=ends)

x, z = np.moveaxis([result.probes[name]["displacement"][:, [0, 2]] + (place[0], 0)
                    for name, place in ends.items()], 2, 0)
print(f"after 1 s the tip is at x = {x[-1, -1]:.4f} m, z = {z[-1, -1]:.4f} m; a stone that falls "
      f"freely is at {-9.81 / 2:.4f} m")
print(f"energies and works differ by {result.energy_balance:.1e}")

fig, panel = plt.subplots(figsize=(5, 4), layout="constrained")
panel.plot(x[:, ::80], z[:, ::80], ".-", markersize=3)
panel.set(xlabel="x [m]", ylabel="z [m]", aspect="equal")
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "chain.png", dpi=100)
