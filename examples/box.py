"""A folded box, a mesh of Abaqus, is pulled and bent at its lid: what cuts carry, by hand.

Usage: python box.py [PICTURE]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from corovec import Mesh, Model, Support, solve_linear, stresses, surface_load

LENGTH, AREA, FORCE = 1.2, 0.3 * 0.2, np.array([2000.0, 0.0, -500.0])  # [m], of the lid, [N]
mesh = Mesh.read(Path(__file__).with_name("box.inp"))  # element sets and the node set ROOT
sheets = {"FLOOR": 0.002, "ROOF": 0.002, "FRONT": 0.001, "BACK": 0.001, "LID": 0.003}  # [m]
lid = mesh.groups["LID"]
model = Model.of(mesh, thickness=sheets, youngs=70e9, poisson=0.33, density=2700.0,
                 loads=surface_load(mesh.nodes, mesh.quads[lid], FORCE / AREA),
                 supports=[Support(mesh.node_sets["ROOT"], ("x", "y", "z", "px", "py", "pz"))])
along = np.tile((1.0, 0.0, 0.0), (len(mesh.quads), 1))  # x of the stresses
along[lid] = (0.0, 1.0, 0.0)

found = stresses(model, solve_linear(model).state, axes=along)

corners = mesh.nodes[mesh.quads]
places, width = corners.mean(axis=1), np.ptp(corners[:, :, 1:], axis=1).max(axis=1)
flow = np.column_stack([found.n[:, [0, 2]], found.q[:, 0]])  # through a cut x = const [N/m]
force = width[:, None] * np.einsum("ek,ekc->ec", flow, found.axes)  # in x, y, z [N]
moment = np.cross(places * (0.0, 1.0, 1.0) - (0.0, 0.15, 0.1), force)  # about the box's axis [N m]
cuts = places[:, 0].round(9)
for x in np.unique(cuts)[:-1:4]:  # the last one is the lid
    axial, _, shear = force[cuts == x].sum(axis=0)
    print(f"cut at {x:.2f} m: N {axial:.6f} N, V {shear:.6f} N, M {moment[cuts == x, 1].sum():.2f} "
          f"N m; by hand {FORCE[0]:g}, {FORCE[2]:g}, {-FORCE[2] * (LENGTH - x):g}")

fig, axes = plt.subplots(figsize=(5, 3), layout="constrained")
for name in ("ROOF", "FRONT", "FLOOR"):
    rows = mesh.groups[name]
    axes.plot(places[rows, 0], 1e-3 * found.n[rows, 0], ".", label=name.lower())
axes.set(xlabel="x [m]", ylabel="force along the box [kN/m]")
axes.legend()
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "box.png", dpi=100)
