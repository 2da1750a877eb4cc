"""A square panel in compression: when it buckles, and how stiff it is afterwards.

Usage: python postbuckling.py [PICTURE]
"""

import sys
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

from corovec import Model, Support, block, buckling, load_control

side, h, E, nu = 1.0, 0.01, 70e9, 0.3
mesh = block([(0, 0, 0), (side, 0, 0), (side, side, 0), (0, side, 0)], (12, 12))
x, y, _ = mesh.nodes.T
left, right = np.flatnonzero(x == 0.0), np.flatnonzero(x == side)
rim = np.flatnonzero((x == 0.0) | (x == side) | (y == 0.0) | (y == side))
strain = np.pi**2 / (3.0 * (1.0 - nu**2)) * (h / side) ** 2  # critical in theory: k = 4
supports = [Support(rim, ("z",)), Support(left, ("x",)), Support([int(left[0])], ("y",)),
            Support(right, ("x",), displacement=-strain * side)]
plate = Model.of(mesh, h, E, nu, 2700.0, supports=supports)

found = buckling(plate, 1)
print(f"buckles at k = {4.0 * found.factors[0]:.4f}")
bent = replace(plate, nodes=plate.nodes + 0.005 * h * found.displacement[0], normals=None)
factors = np.concatenate([np.linspace(0.1, 0.9, 5), np.linspace(0.95, 2.0, 15)])
path = load_control(bent, factors)

force = -path.reactions[:, right, 0].sum(axis=1) / (E * h * strain * side)
rise = np.abs(path.displacement[:, :, 2]).max(axis=1) / h
before = force[0] / path.factors[0]
late = (path.factors > 1.2) & (path.factors < 1.6)
after = np.polyfit(path.factors[late], force[late], 1)[0]
print(f"stiffness afterwards {after / before:.4f} of that before, deflection {rise[-1]:.3f} h "
      f"at twice the shortening")

fig, (load, bend) = plt.subplots(1, 2, figsize=(7, 3), layout="constrained")
load.plot(path.factors, force, ".-")
bend.plot(path.factors, rise, ".-")
load.set(xlabel="shortening / critical", ylabel="force / (E A critical strain)")
bend.set(xlabel="shortening / critical", ylabel="deflection / h")
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "postbuckling.png", dpi=100)
