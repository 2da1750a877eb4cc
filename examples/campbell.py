"""Campbell diagram: the frequencies of a spinning blade against its speed.

Usage: python campbell.py [PICTURE]
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

from corovec import Centrifugal, Model, Support, block, load_control, modes

mesh = block([(0, -0.25, 0), (10, -0.25, 0), (10, 0.25, 0), (0, 0.25, 0)], (30, 1))
root = Support(np.flatnonzero(mesh.nodes[:, 0] == 0.0), ("x", "y", "z", "px", "py", "pz"))
E, h, rho, length = 1.2e8, 0.05, 1.0, 10.0
unit = np.sqrt(E * h**2 / 12.0 / rho) / length**2  # sqrt(E I / m) / L^2 [rad/s]


def spun(speed):
    """Frequencies [rad/s] about the equilibrium at a speed [rad/s]."""
    blade = Model.of(mesh, h, E, 0.0, rho, supports=[root], loads=[Centrifugal((0, 0, speed))])
    return modes(blade, 4, load_control(blade, [1.0]) if speed else None).omega


speeds = np.array([0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0])
omega = np.array([spun(speed * unit) for speed in speeds]) / unit
print("speed, first flapping frequency, in sqrt(E I / m) / L^2:")
for speed, flap in zip(speeds, omega[:, 0]):
    print(f"{speed:5.1f} {flap:8.4f}")

fig, panel = plt.subplots(figsize=(5, 4), layout="constrained")
panel.plot(speeds, omega, "o-", color="tab:blue", markersize=3)
for order in range(1, 5):
    panel.plot(speeds, order * speeds, "--", color="0.6", linewidth=0.8)
    panel.annotate(f"{order}P", (12.15, 12.0 * order), color="0.4")
panel.set(xlabel=r"speed [$\sqrt{EI/m}/L^2$]", ylabel="frequencies, the same unit",
          xlim=(0, 13), ylim=(0, 65))
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "campbell.png", dpi=100)
