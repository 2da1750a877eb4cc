"""Rows of a static path: what is kept of each equilibrium, in memory and in a result file."""

from dataclasses import dataclass

import numpy as np

from ..results.frame import table
from ..results.layout import STATICS
from ..results.reading import read
from ..results.recorder import Recorder

NODAL = ("displacement", "normal", "reaction")
"""Values of the nodes that are kept with every row, (n_nodes, 3)."""


@dataclass(frozen=True, eq=False, repr=False)
class StaticResult:
    """Equilibrium states, one a row.

    Attributes:
        factors: (n,) load factors.
        displacement: (n, n_nodes, 3) [m].
        normals: (n, n_nodes, 3), at a junction that of the first plate.
        strain_energy: (n,) [J].
        reactions: (n, n_nodes, 3) forces of the supports [N].
        iterations: (n,) Newton iterations since the row before.
        steps: (n,) load steps taken since the row before.
        works: works of the corrections of the last step computed, first to last.
        solver: the linear solver that ran.
        indefinite: factorizations with negative pivots (None: the solver does not tell).
        seconds: wall-clock seconds.
    """

    factors: np.ndarray
    displacement: np.ndarray
    normals: np.ndarray
    strain_energy: np.ndarray
    reactions: np.ndarray
    iterations: np.ndarray
    steps: np.ndarray
    works: tuple
    solver: str
    indefinite: int
    seconds: float

    def __repr__(self):
        return (f"<StaticResult: {len(self.factors)} equilibria to factor "
                f"{self.factors[-1]:.6g}, {self.displacement.shape[1]} nodes>")

    def frame(self):
        """The rows as a ``pandas.DataFrame``, with the resultant of the reactions; displacements,
        normals and reactions of the nodes are left out."""
        return table({"factor": self.factors, "strain_energy": self.strain_energy,
                      "reaction": self.reactions.sum(axis=1), "iterations": self.iterations,
                      "steps": self.steps})


class Rows:
    """Rows of the path of ``state``, each with a frame; the first is at zero load."""

    def __init__(self, system, state, place):
        self._system, self._state, self._place = system, state, place
        self._history, self._nodal = [], []
        self._recorder = None

    def __len__(self):
        return len(self._history)

    @property
    def reached(self):
        """Load factor of the last row, and the step to try next."""
        row = self._history[-1][0]
        return float(row["factor"]), float(row["next_step"])

    @property
    def indefinite(self):
        """Factorizations with negative pivots; None where the solver does not tell."""
        counts = [int(row["indefinite"][0]) for row in self._history]
        return sum(counts) if min(counts) >= 0 else None

    def displacement(self, k):
        """Displacements (n_nodes, 3) of row ``k`` [m]."""
        return self._nodal[k]["displacement"]

    def columns(self, first):
        """The arrays of a ``StaticResult``, of the rows from ``first`` on."""
        history = np.concatenate(self._history[first:])
        displacement, normals, reactions = (
            np.array([nodal[name] for nodal in self._nodal[first:]]) for name in NODAL)
        return (history["factor"], displacement, normals, history["strain_energy"], reactions,
                history["iterations"], history["steps"])

    def append(self, row, reactions, shown):
        """Keep the state with its history ``row``; ``shown`` is its time in ParaView."""
        system, state = self._system, self._state
        displacement, normals = system.displacement(state), system.nodal_normals(self._place)
        self._history.append(np.array([row], dtype=STATICS))
        self._nodal.append(dict(zip(NODAL, (displacement, normals, reactions))))
        if self._recorder:
            self._recorder.write(len(self) - 1, state, self._history[-1], self._frame(shown))

    def create(self, path, description, n_steps, overwrite):
        """A new file with room for ``n_steps``, which gets the first row and all to come."""
        self._recorder = Recorder.create(
            path, self._system.model, description, self._state, self._history[0],
            self._frame(0.0), np.arange(n_steps + 1), overwrite)

    def resume(self, path, description):
        """Take over the state and all rows of a file, and continue it."""
        self._recorder, step, history = Recorder.resume(path, self._system.model, description,
                                                        self._state)
        contents = read(path)
        self._history = [history[k:k + 1] for k in range(step + 1)]
        self._nodal = [{name: contents[name][k] for name in NODAL} for k in range(step + 1)]

    def _frame(self, shown):
        return (len(self) - 1, shown,
                {"PointData": self._nodal[-1],
                 "CellData": {"strain_energy": self._place.start.energy}})
