"""A flapping wing: a plate whose root is turned to and fro in air, flexible and nearly rigid.

Usage: python flapping.py [PICTURE]
"""

import sys

import matplotlib.pyplot as plt

import corovec as cv

SPAN, CHORD, STROKE, HERTZ = 0.5, 0.2, 0.5, 2.0  # [m], [m], [rad], [Hz]
AIR, DRAG, END = 1.225, 2.0, 2.0  # [kg/m^3], [-], [s]

mesh = cv.block([(0, 0, 0), (SPAN, 0, 0), (SPAN, CHORD, 0), (0, CHORD, 0)], (10, 4))
beat = cv.Expression(f"(1 - exp(-25 * t * t)) * sin(2 * pi * {HERTZ} * t)")  # from rest
flap = cv.Drive(mesh.nodes_at(x=0.0), rotation=(0.0, -STROKE, 0.0), history=beat)

results = {}
for wing, youngs in (("flexible", 70e9), ("stiff", 70e11)):
    model = cv.Model.of(mesh, 1e-3, youngs, 0.33, 2700.0, supports=[flap],
                        loads=[cv.Drag(DRAG, AIR)])
    results[wing] = result = cv.simulate(
        model, cv.Settings(dt=0.005, end_time=END, scheme=cv.Scheme("exact")),
        probes={"tip": (SPAN, 0.0, 0.0)})
    history, energy = result.history, cv.total_energy(result.history)
    done, taken = history["support_work"][-1], -history["external_work"][-1]
    print(f"{wing}: the drive did {done:.5f} J, drag took {taken:.5f} J, the wing has "
          f"{energy[-1]:.5f} J; left over {abs(done - taken - energy[-1]):.0e} J")

fig, (above, below) = plt.subplots(2, 1, figsize=(6, 5), sharex=True, layout="constrained")
for wing, result in results.items():
    above.plot(result.history["time"], result.probes["tip"]["displacement"][:, 2], label=wing)
    below.plot(result.history["time"], result.history["support_work"], label=f"drive, {wing}")
    below.plot(result.history["time"], -result.history["external_work"], "--",
               label=f"drag, {wing}")
above.set(ylabel="rise of the tip [m]")
below.set(xlabel="time [s]", ylabel="work [J]")
above.legend()
below.legend(fontsize="small")
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "flapping.png", dpi=100)
