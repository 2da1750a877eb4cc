"""A shallow hinged roof snaps through under a central force: the path beyond the limit point.

One quarter of the roof of Sze, Liu and Lo (2004), section 3.8, with a thickness of 12.7 mm.
Usage: python snap_through.py [PICTURE]
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

from corovec import Model, NodalLoad, Support, arc_length

N, RADIUS, HALF, FORCE = 12, 2.54, 0.254, 3000.0  # elements a side, [m], [m], [N]
x, angle = (grid.ravel() for grid in np.meshgrid(np.linspace(0.0, HALF, N + 1),
                                                 np.linspace(0.0, 0.1, N + 1)))
normals = np.column_stack([0.0 * x, np.sin(angle), np.cos(angle)])
nodes = np.column_stack([x, RADIUS * normals[:, 1], RADIUS * normals[:, 2]])
first = np.array([(N + 1) * j + i for j in range(N) for i in range(N)])
quads = np.column_stack([first, first + 1, first + N + 2, first + N + 1])
supports = [Support(np.flatnonzero(x == 0.0), ("x", "px")),  # planes of symmetry
            Support(np.flatnonzero(angle == 0.0), ("y", "py")),
            Support(np.flatnonzero(angle == 0.1), ("x", "y", "z"))]  # hinged edge
model = Model(nodes, quads, thickness=0.0127, youngs=3.10275e9, poisson=0.3, density=1.0,
              loads=[NodalLoad(0, (0.0, 0.0, -FORCE / 4.0))], supports=supports, normals=normals)

result = arc_length(model, 0.02, until=lambda factor, u: -u[0, 2] > 0.028)

force, sag = FORCE * result.factors, -result.displacement[:, 0, 2]
limit = int(np.argmax(np.diff(force) < 0.0))
print(f"limit load {force[limit]:.1f} N at a deflection of {1e3 * sag[limit]:.2f} mm")
print(f"least load afterwards {force[limit:].min():.1f} N")

fig, axes = plt.subplots(figsize=(5, 3), layout="constrained")
axes.plot(1e3 * sag, force, ".-")
axes.set(xlabel="deflection at the centre [mm]", ylabel="force [N]")
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "snap_through.png", dpi=100)
