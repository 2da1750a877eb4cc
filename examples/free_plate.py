"""A flexible plate is hit at one corner, flies and vibrates: its energy stays as the pulse left it.

Usage: python free_plate.py [PICTURE]
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

from corovec import Model, NodalLoad, Settings, TimeFunction, simulate

x, y = np.meshgrid(np.linspace(0.0, 2.0, 9), np.linspace(0.0, 1.0, 5))
nodes = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])  # [m]
first = np.array([9 * j + i for j in range(4) for i in range(8)])
quads = np.column_stack([first, first + 1, first + 10, first + 9])
pulse = TimeFunction(times=(0.0, 0.1, 0.2), values=(0.0, 1.0, 0.0))
model = Model(nodes, quads, thickness=0.02, youngs=1e8, poisson=0.3, density=1000.0,
              loads=[NodalLoad(0, (0.0, 0.0, 200.0), pulse)])

result = simulate(model, Settings(dt=2e-3, end_time=2.0))

history = result.history
momentum = history["linear_momentum"][-1, 2]
print(f"linear momentum {momentum:.9f} N s; the impulse of the pulse is 20 N s")
print(f"drift of the energy since unloading {result.drift.energy:.1e}")

fig, axes = plt.subplots(figsize=(5, 3), layout="constrained")
axes.plot(history["time"], history["kinetic_energy"], label="kinetic")
axes.plot(history["time"], history["strain_energy"], label="strain")
axes.plot(history["time"], result.total_energy, "k", label="sum")
axes.set(xlabel="time [s]", ylabel="energy [J]")
axes.legend()
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "free_plate.png", dpi=100)
