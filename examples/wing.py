"""A laminated wing in a gust: plies aside of its span twist it as it bends.

Usage: python wing.py [PICTURE]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import corovec as cv

span, chord = 3.0, 0.1
carbon = cv.Lamina(E1=130e9, E2=9e9, nu12=0.3, G12=5e9, G13=5e9, G23=3e9, density=1600.0)
wing = cv.Laminate([cv.Ply(carbon, 0.002, 20.0)] * 4)
mesh = cv.block([(0, 0, 0), (span, 0, 0), (span, chord, 0), (0, chord, 0)], (36, 2))
root = cv.Support(np.flatnonzero(mesh.nodes[:, 0] == 0.0), ("x", "y", "z", "px", "py", "pz"))


def winged(*history, **options):
    """The wing under 20 Pa, times a function of time."""
    lift = cv.surface_load(mesh.nodes, mesh.quads, (0.0, 0.0, 20.0), *history)
    return cv.Model.of(mesh, sections=[cv.Section(wing, direction=(1, 0, 0))], supports=[root],
                       loads=lift, **options)


gust = cv.read_time_function(Path(__file__).with_name("gust.csv"))
front, back = (int(np.argmin(np.linalg.norm(mesh.nodes - (span, y, 0), axis=1)))
               for y in (0.0, chord))
still = cv.load_control(winged(), [1.0])  # in steady flight, where the gust begins
result = cv.simulate(winged(gust, damping=cv.Damping.of_ratios(0.02, 1.0, 0.02, 20.0)),
                  cv.Settings(dt=0.0025, end_time=1.0), start=still.states[-1],
                  probes={"front": front, "back": back})

z = {name: probe["displacement"][:, 2] for name, probe in result.probes.items()}
rise, twist = 0.5 * (z["front"] + z["back"]), np.degrees((z["back"] - z["front"]) / chord)
print(f"steady: tip {rise[0]:.4f} m, twist {twist[0]:.4f} degrees")
print(f"in the gust: {rise.max() / rise[0]:.3f} times that, energy balance "
      f"{result.energy_balance:.1e}")

fig, (up, around) = plt.subplots(2, 1, figsize=(5, 4), sharex=True, layout="constrained")
time = result.history["time"]
up.plot(time, rise)
around.plot(time, twist)
up.set(ylabel="tip [m]")
around.set(xlabel="time [s]", ylabel="twist [degrees]")
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "wing.png", dpi=100)
