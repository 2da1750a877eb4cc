"""Fifty cantilevers, ten thicknesses times five sudden tip forces, run in parallel; one table.

Usage: python fifty.py [PICTURE]
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from corovec import Model, NodalLoad, Settings, Support, block
from corovec.convergence import run_many

E, RHO, WIDTH = 1e8, 1000.0, 0.1  # [Pa], [kg/m^3], [m]; 1 m long
STRIP = block([(0, 0, 0), (1, 0, 0), (1, WIDTH, 0), (0, WIDTH, 0)], (8, 1))


def variant(h, force):
    """A cantilever, its tip loaded from t = 0 on, with settings for four of its first periods."""
    period = 2.0 * np.pi / 1.875104**2 * np.sqrt(12.0 * RHO / E) / h
    model = Model.of(STRIP, thickness=h, youngs=E, poisson=0.0, density=RHO,
                     loads=[NodalLoad(tip, (0.0, 0.0, force / 2.0)) for tip in STRIP.nodes_at(x=1)],
                     supports=[Support(STRIP.nodes_at(x=0), ("x", "y", "z", "px", "py", "pz"))])
    return model, Settings(dt=period / 40.0, end_time=4.0 * period)


if __name__ == "__main__":
    table = pd.DataFrame([(h, force) for h in np.geomspace(0.01, 0.03, 10)
                          for force in np.linspace(0.01, 0.05, 5)], columns=["thickness", "force"])
    results = run_many([variant(*row) for row in table.to_numpy()], probes={"tip": (1, 0, 0)})
    tips = [result.frame()["tip_u_z"] for result in results]
    table["deflection"] = [tip.mean() for tip in tips]  # it vibrates about that of statics
    table["frequency"] = [np.argmax(np.abs(np.fft.rfft(tip - tip.mean(), 2**14)))
                          / (2**14 * result.settings.dt) for tip, result in zip(tips, results)]
    print(table.iloc[::7].to_string(index=False, float_format="%.5f"))
    known = np.column_stack([np.log(table[["thickness", "force"]]), np.ones(len(table))])
    for name in ("deflection", "frequency"):
        powers = np.linalg.lstsq(known, np.log(table[name]))[0]
        print(f"{name} as thickness^{powers[0]:.3f} force^{powers[1]:.3f}")

    fig, axes = plt.subplots(figsize=(5, 3), layout="constrained")
    for force, rows in table.groupby("force"):
        axes.loglog(rows["thickness"], rows["deflection"], ".-", label=f"{force:.2f} N")
    axes.set(xlabel="thickness [m]", ylabel="deflection of the tip [m]")
    axes.legend()
    fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "fifty.png", dpi=100)
