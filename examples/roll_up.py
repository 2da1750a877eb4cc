"""A clamped strip is rolled up to a full circle by a moment at its end, in ten steps of statics.

Usage: python roll_up.py [PICTURE]
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

from corovec import Model, Support, line_moment, load_control

LENGTH, N, H, E = 12.0, 32, 0.1, 1.2e6  # [m], elements, [m], [Pa]
x = np.linspace(0.0, LENGTH, N + 1)
nodes = np.array([(X, Y, 0.0) for Y in (0.0, 1.0) for X in x])
quads = np.array([(i, i + 1, N + 2 + i, N + 1 + i) for i in range(N)])
full_circle = 2.0 * np.pi * E * H**3 / 12.0 / LENGTH  # moment a width [N m/m]
model = Model(nodes, quads, thickness=H, youngs=E, poisson=0.0, density=1.0,
              loads=line_moment(nodes, (N, 2 * N + 1), (0.0, -full_circle, 0.0)),
              supports=[Support((0, N + 1), ("x", "y", "z", "px", "py", "pz"))])

result = load_control(model, np.linspace(0.1, 1.0, 10))

curves = nodes[:N + 1] + result.displacement[:, :N + 1]
print(f"the end comes back to within {np.linalg.norm(curves[-1, -1]):.4f} m of the start")
print(f"diameter {np.ptp(curves[-1, :, 2]):.4f} m; a circle of this length has "
      f"{LENGTH / np.pi:.4f} m")

fig, axes = plt.subplots(figsize=(5, 3), layout="constrained")
axes.plot(*nodes[:N + 1, ::2].T, "0.7")
for curve in curves:
    axes.plot(*curve[:, ::2].T, "C0", lw=1)
axes.set(xlabel="x [m]", ylabel="z [m]", aspect="equal")
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "roll_up.png", dpi=100)
