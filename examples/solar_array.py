"""Six panels on a free hub, folded in a zigzag, unfold by torsion springs until latches hold them.

Usage: python solar_array.py [PICTURE]
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

from corovec import Hinge, JointProbe, Model, Scheme, Settings, block, cut, join, simulate

ends, parts = [np.array((-1.0, 0, 0)), np.zeros(3)], []
angles = np.radians([0, 85, -85, 85, -85, 85, -85])  # of the hub and the panels, from the x axis
for angle in angles[1:]:
    ends.append(ends[-1] + (np.cos(angle), 0, np.sin(angle)))
for k, (a, b) in enumerate(zip(ends, ends[1:])):
    y = np.array((0, 1.0, 0))
    parts.append(block([a, b, b + y, a + y], (2, 2)).named("panels" if k else "hub"))
mesh, hinges = join(parts), []
for k, turn in enumerate(np.diff(angles)):
    mesh, nodes, others = cut(mesh, ends[k + 1], ends[k + 1] + y)
    hinges.append(Hinge(nodes, others, stiffness=0.5, rest=turn, lock=turn, lock_stiffness=200.0,
                        lock_damping=5.0, name=f"hinge{k + 1}"))
model = Model.of(mesh, {"hub": 0.2, "panels": 0.02}, 1e9, 0.3, {"hub": 500.0, "panels": 100.0},
                 joints=hinges)

result = simulate(model, Settings(dt=0.02, end_time=30.0, scheme=Scheme("exact")),
                  probes={hinge.name: JointProbe(hinge.name) for hinge in hinges})

time, history = result.history["time"], result.history
for hinge in hinges:
    open_by = result.probes[hinge.name]["angle"] / hinge.lock
    print(f"{hinge.name} holds from {time[np.argmax(open_by >= 1.0)]:.2f} s, "
          f"at the end {np.degrees(hinge.lock * open_by[-1]):.2f} degrees")
across = np.ptp(model.nodes + result.displacement, axis=0)
print(f"the springs had {history['strain_energy'][0]:.4f} J, latches took "
      f"{history['dissipated'][-1]:.4f} J, not told of: {result.energy_balance:.1e}")
momenta = [np.abs(history[f"{kind}_momentum"]).max() for kind in ("linear", "angular")]
print(f"momenta stay within {momenta[0]:.1e} N s and {momenta[1]:.1e} N m s")
print(f"hub and array are {np.linalg.norm(across):.3f} m long from corner to corner")

fig, panel = plt.subplots(figsize=(5, 3), layout="constrained")
for hinge in hinges:
    panel.plot(time, np.degrees(result.probes[hinge.name]["angle"]), label=hinge.name)
panel.set(xlabel="time [s]", ylabel="angle [degrees]")
panel.legend(fontsize=7)
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "solar_array.png", dpi=100)
