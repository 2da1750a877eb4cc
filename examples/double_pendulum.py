"""A double pendulum of two soft strips, released level, beside geometrically exact beams (Exudyn).

Usage: python double_pendulum.py [PICTURE]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from corovec import Gravity, Hinge, Model, Scheme, Settings, Support, block, cut, simulate

N, DT, LENGTH, WIDTH = 32, 0.00125, 0.25, 0.01
mesh = block([(0, 0, 0), (2 * LENGTH, 0, 0), (2 * LENGTH, WIDTH, 0), (0, WIDTH, 0)], (2 * N, 1))
mesh, *sides = cut(mesh, (LENGTH, 0, 0), (LENGTH, WIDTH, 0))
model = Model.of(mesh, 0.002, 2e7, 0.0, 1000.0, loads=[Gravity((0, 0, -9.81))],
                 joints=[Hinge(*sides)], supports=[Support(mesh.nodes_at(x=0.0), ("x", "y", "z"))])
along = {f"p{k}": (k * LENGTH / 8, 0, 0) for k in range(17)}

result = simulate(model, Settings(dt=DT, end_time=1.0, scheme=Scheme("exact")), probes=along)

time, x, z, tip_x, tip_z = np.loadtxt(Path(__file__).with_name("double_pendulum.csv"),
                                      delimiter=",").T
places = np.stack([result.probes[name]["displacement"][:, [0, 2]] + (place[0], 0)
                   for name, place in along.items()], axis=1)
every = round(time[1] / DT)
ends = places[::every, [8, 16]]
known = np.stack([np.c_[x, z], np.c_[tip_x, tip_z]], axis=1)
gap = np.linalg.norm(ends - known, axis=2).max(axis=0)
short = np.linalg.norm(places[:, 16] - places[:, 8], axis=1).min()
print(f"joint and tip stay within {1e3 * gap[0]:.2f} and {1e3 * gap[1]:.2f} mm of Exudyn's, the "
      f"lower strip of {LENGTH} m bends to a chord of {short:.3f} m")
print(f"energies and works differ by {result.energy_balance:.0e}")

fig, panel = plt.subplots(figsize=(5, 4.5), layout="constrained")
panel.plot(*np.moveaxis(places[::every * 10], 2, 0).transpose(0, 2, 1), color="C0", linewidth=1)
panel.plot(tip_x, tip_z, "k:", label="tip, Exudyn")
panel.set(xlabel="x [m]", ylabel="z [m]", aspect="equal")
panel.legend()
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "double_pendulum.png", dpi=100)
