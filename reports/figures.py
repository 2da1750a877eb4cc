"""Figures of runs: each function returns a matplotlib ``Figure`` and a tidy table of its data.

The table holds exactly what is drawn, in SI units, one observation a row; ``save`` writes both.
"""

from .curves import (
    Curve,
    convergence,
    displacements,
    energies,
    energies_by_item,
    momenta,
    probes,
    total_energies,
)
from .scenes import sequence
from .shells import mesh_and_loads
from .style import save

__all__ = ["Curve", "convergence", "displacements", "energies", "energies_by_item",
           "mesh_and_loads", "momenta", "probes", "save", "sequence", "total_energies"]
