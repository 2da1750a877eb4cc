"""Six cantilevers of different thickness vibrate, in parallel; their periods as one table.

Usage: python variants.py [PICTURE]
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from corovec import Model, Settings, Support
from corovec.convergence import run_many

N, E, RHO = 16, 1e8, 1000.0  # elements along 1 m, [Pa], [kg/m^3]


def beam_period(h):
    """First period of a cantilever by Euler and Bernoulli [s]."""
    return 2.0 * np.pi / 1.875104**2 * np.sqrt(12.0 * RHO / (E * h**2))


def cantilever(h):
    """It starts flat, with velocities near its first mode, small beside its thickness."""
    x = np.linspace(0.0, 1.0, N + 1)
    nodes = np.array([(X, Y, 0.0) for Y in (0.0, 0.1) for X in x])
    quads = [(i, i + 1, N + 2 + i, N + 1 + i) for i in range(N)]
    velocity = np.zeros_like(nodes)
    velocity[:, 2] = 0.1 * h / beam_period(h) * (1.0 - np.cos(np.pi * nodes[:, 0] / 2.0))
    return Model(nodes, quads, thickness=h, youngs=E, poisson=0.0, density=RHO, velocity=velocity,
                 supports=[Support((0, N + 1), ("x", "y", "z", "px", "py", "pz"))])


if __name__ == "__main__":
    table = pd.DataFrame({"thickness": np.linspace(0.01, 0.03, 6)})
    table["beam"] = [beam_period(h) for h in table["thickness"]]
    results = run_many([(cantilever(h), Settings(dt=period / 80.0, end_time=3.0 * period))
                        for h, period in zip(table["thickness"], table["beam"])], jobs=2)
    spectra = [np.abs(np.fft.rfft(r.history["strain_energy"] - r.history["strain_energy"].mean(),
                                  2**14)) for r in results]  # the energy has twice the frequency
    table["ours"] = [2.0 * 2**14 / np.argmax(spectrum) * r.settings.dt
                     for spectrum, r in zip(spectra, results)]
    print(table.to_string(index=False, float_format="%.4f"))

    fig, axes = plt.subplots(figsize=(5, 3), layout="constrained")
    axes.plot(table["thickness"], table["beam"], label="Euler and Bernoulli")
    axes.plot(table["thickness"], table["ours"], "o", label="corovec")
    axes.set(xlabel="thickness [m]", ylabel="period [s]")
    axes.legend()
    fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "variants.png", dpi=100)
