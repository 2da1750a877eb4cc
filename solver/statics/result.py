"""Rows of a static path: what is kept of each equilibrium, in memory and in a result file."""

from dataclasses import dataclass

import numpy as np

from ..results.frame import table
from ..results.layout import OF_JOINTS, statics
from ..results.reading import read
from ..results.recorder import Recorder
from ..results.snapshot import snapshot
from ..results.stresses import Configuration
from ..system.reactions import Balance

NODAL = ("displacement", "normal", "director", "reaction", "reaction_moment")
"""Values of the nodes that are kept with every row, (n_nodes, 3), of ``director`` (n_directors, 3).
"""


@dataclass(frozen=True, eq=False, repr=False)
class LinearResult:
    """A linear solution; it unpacks into its first two.

    Attributes:
        displacement: (n_nodes, 3) [m].
        change_of_normals: (n_nodes, 3), at a junction of that of the first plate.
        change_of_directors: (n_directors, 3), of all.
        reactions: (n_nodes, 3) forces of the supports [N].
        reaction_moments: (n_nodes, 3) moments of the supports about the nodes [N m].
        reaction: (3,) resultant force of supports and joints to the ground [N].
        reaction_moment: (3,) their moment about the origin [N m].
        balance: ``Balance`` of loads and reactions in their initial places; of hinges that are
            loaded at the start moments lack what these do as they turn with the plates.
        joint_forces: (n_joints, 3) as of ``StaticResult``.
        joint_moments: (n_joints,) the same.
        joint_couples: (n_joints, 3) the same.
    """

    displacement: np.ndarray
    change_of_normals: np.ndarray
    change_of_directors: np.ndarray
    reactions: np.ndarray
    reaction_moments: np.ndarray
    reaction: np.ndarray
    reaction_moment: np.ndarray
    balance: Balance
    joint_forces: np.ndarray
    joint_moments: np.ndarray
    joint_couples: np.ndarray

    def __iter__(self):
        return iter((self.displacement, self.change_of_normals))

    def __repr__(self):
        return (f"<LinearResult: {len(self.displacement)} nodes, "
                f"{np.linalg.norm(self.displacement, axis=1).max():.6g} m at most>")

    @property
    def state(self):
        """``Configuration``, for ``stresses``."""
        return Configuration(self.displacement, self.change_of_directors, linear=True)


@dataclass(frozen=True, eq=False, repr=False)
class StaticResult:
    """Equilibrium states, one a row.

    Attributes:
        factors: (n,) load factors.
        displacement: (n, n_nodes, 3) [m].
        normals: (n, n_nodes, 3), at a junction that of the first plate.
        strain_energy: (n,) [J].
        directors: (n, n_directors, 3) all normals.
        reactions: (n, n_nodes, 3) forces of the supports [N].
        reaction_moments: (n, n_nodes, 3) moments of the supports about the nodes [N m].
        reaction: (n, 3) resultant force of supports and joints to the ground [N].
        reaction_moment: (n, 3) their moment about the origin [N m].
        load: (n, 3) resultant of the loads [N].
        load_moment: (n, 3) its moment about the origin [N m].
        balances: (n, 2) what is left of the sums of loads and reactions, of forces and of moments,
            relative to the sums of the magnitudes of all nodal ones.
        iterations: (n,) Newton iterations since the row before.
        steps: (n,) load steps taken since the row before.
        negative_pivots: (n,) of the last tangent before each row: as many directions in which the
            state is unstable; -1 where the solver does not tell.
        works: works of the corrections of the last step computed, first to last.
        joint_forces: (n, n_joints, 3) force of each joint of the model on the plate of its
            ``nodes``, of a spherical one on the first node, of one with ends on ``other``, or on
            ``one`` where that is the ground [N].
        joint_moments: (n, n_joints) moments of springs, stops, motors and drives that turn joints
            on [N m].
        joint_couples: (n, n_joints, 3) moments of joints with ends about their places, on the same
            end as their forces [N m].
        joint_angles: (n, n_joints) of hinges, and of revolute joints whose angle takes part [rad].
        hinges: (n, n_places, 2) angles of joints at their places, as of a ``Configuration``.
        solver: the linear solver that ran.
        indefinite: factorizations with negative pivots (None: the solver does not tell).
        seconds: wall-clock seconds.
        memory: most that this process has had at a time until the end of the run [MB], None if
            unknown.
    """

    factors: np.ndarray
    displacement: np.ndarray
    normals: np.ndarray
    strain_energy: np.ndarray
    directors: np.ndarray
    reactions: np.ndarray
    reaction_moments: np.ndarray
    reaction: np.ndarray
    reaction_moment: np.ndarray
    load: np.ndarray
    load_moment: np.ndarray
    balances: np.ndarray
    iterations: np.ndarray
    steps: np.ndarray
    negative_pivots: np.ndarray
    joint_forces: np.ndarray
    joint_moments: np.ndarray
    joint_couples: np.ndarray
    joint_angles: np.ndarray
    hinges: np.ndarray
    works: tuple
    solver: str
    indefinite: int
    seconds: float
    memory: float | None

    def __repr__(self):
        return (f"<StaticResult: {len(self.factors)} equilibria to factor "
                f"{self.factors[-1]:.6g}, {self.displacement.shape[1]} nodes>")

    @property
    def states(self):
        """``Configuration`` of every row, for ``stresses``."""
        return [Configuration(displacement, directors, hinges=hinges) for
                displacement, directors, hinges in zip(self.displacement, self.directors,
                                                       self.hinges)]

    @property
    def balance(self):
        """``Balance`` of forces and of moments, the largest of all rows."""
        return Balance(*map(float, self.balances.max(axis=0)))

    def frame(self):
        """The rows as a ``pandas.DataFrame``, with the resultants of loads and reactions, moments
        about the origin, and forces, moments and angles of joints; displacements, normals and
        reactions of the nodes are left out."""
        return table({"factor": self.factors, "strain_energy": self.strain_energy,
                      "load": self.load, "load_moment": self.load_moment,
                      "reaction": self.reaction,
                      "reaction_moment": self.reaction_moment,
                      "force_balance": self.balances[:, 0],
                      "moment_balance": self.balances[:, 1], "iterations": self.iterations,
                      "steps": self.steps, "negative_pivots": self.negative_pivots,
                      "joints.force": self.joint_forces, "joints.moment": self.joint_moments,
                      "joints.couple": self.joint_couples, "joints.angle": self.joint_angles})


class Rows:
    """Rows of the path of ``state``, each with a frame; the first is at zero load.

    Attributes:
        row: type of a row.
    """

    def __init__(self, system, state, place, stresses):
        """``stresses``: whether they are recorded."""
        self._system, self._state, self._place, self._stresses = system, state, place, stresses
        self._history, self._nodal = [], []
        numbers = (("joints", len(system.model.joints)), ("places", len(state.hinges)))
        self.row = statics([(kind, number) for kind, number in numbers if number])
        self._recorder = self._frame = None

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

    @property
    def negative_pivots(self):
        """Negative pivots of the last row."""
        return int(self._history[-1]["negative_pivots"][0])

    def displacement(self, k):
        """Displacements (n_nodes, 3) of row ``k`` [m]."""
        return self._nodal[k]["displacement"]

    def last(self, name):
        """A column of the last row."""
        return self._history[-1][name][0]

    def columns(self, first):
        """The arrays of a ``StaticResult``, of the rows from ``first`` on."""
        history = np.concatenate(self._history[first:])
        displacement, normals, directors, reactions, moments = (
            np.array([nodal[name] for nodal in self._nodal[first:]]) for name in NODAL)
        left = np.stack([history["force_balance"], history["moment_balance"]], axis=1)
        return (history["factor"], displacement, normals, history["strain_energy"], directors,
                reactions, moments, history["reaction"], history["reaction_moment"],
                history["load"],
                history["load_moment"], left, history["iterations"], history["steps"],
                history["negative_pivots"], *self._of_joints(history))

    def _of_joints(self, history):
        """Forces, moments, couples and angles of joints, and angles and latches at places."""
        n, row = len(history), self.row.names
        for what, shape in OF_JOINTS["joints"].items():
            name = f"joints.{what}"
            yield history[name] if name in row else np.zeros((n, 0, *shape))
        places = [history[f"places.{what}"] if f"places.{what}" in row else np.zeros((n, 0))
                  for what in OF_JOINTS["places"]]
        yield np.stack(places, axis=-1)

    def append(self, row, reactions, shown):
        """Keep the state with its history ``row``; ``shown`` is its time in ParaView."""
        self._history.append(np.array([row], dtype=self.row))
        fields = snapshot(self._system, self._state, self._place, reactions, self._stresses)
        self._frame = len(self) - 1, shown, fields
        self._keep(fields)
        if self._recorder:
            self._recorder.keep(len(self) - 1, self._state, self._history[-1], self._frame)
            self._recorder.flush()

    def _keep(self, fields, k=...):
        """Keep the values of the nodes of a frame, the ``k``-th of several."""
        fields = {"director": fields["normal"], **fields}
        self._nodal.append({name: fields[name][k] for name in NODAL})

    def create(self, path, description, n_steps, overwrite):
        """A new file with room for ``n_steps``, which gets the first row and all to come."""
        self._recorder = Recorder.create(
            path, self._system.model, description, self._state, self._history[0],
            self._frame, np.arange(n_steps + 1), overwrite)

    def resume(self, path, description):
        """Take over the state and all rows of a file, and continue it."""
        self._recorder, step, history = Recorder.resume(path, self._system.model, description,
                                                        self._state)
        contents = read(path)
        self._history = [history[k:k + 1] for k in range(step + 1)]
        for k in range(step + 1):
            self._keep(contents, k)
