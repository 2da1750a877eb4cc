"""The result of a run: histories, energies, drifts."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from ..checks import number
from ..errors import InputError
from ..results.frame import data_frame, rows_of
from ..results.layout import PROBES, probe_kinds
from ..results.stresses import Configuration
from ..signatures import checked
from ..system.reactions import Balance, share
from .newton import Seconds
from .settings import Settings


def motion_of(name, values):
    """The history of a run in time."""
    if "time" not in rows_of(name, values).dtype.names:
        raise InputError(f"{name} must be that of a run in time, is that of a static path")
    return values


def end_of(name, value):
    """A time, which may be infinite [s]."""
    return np.inf if isinstance(value, float) and value == np.inf else number(name, value, "s")


Motion = Annotated[np.ndarray, motion_of]
End = Annotated[float, end_of]


@dataclass(frozen=True)
class Drift:
    """Largest change since unloading: of the energy with what is dissipated and without the works
    (``unaccounted``) relative to the energy, of the momenta relative to the largest sum m |v| and
    sum m |x - x_c| |v| of the whole run (None for a supported shell, whose momenta are not
    conserved)."""

    energy: float
    linear_momentum: float | None
    angular_momentum: float | None
    angular_momentum_printed: float | None


@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """Histories and last state of a run.

    Attributes:
        history: (n_steps + 1,) structured array, fields of ``results.layout.DYNAMICS``.
        displacement: (n_nodes, 3) at the end [m].
        normals: (n_nodes, 3) at the end, at a junction that of its first plate.
        directors: (n_directors, 3) at the end, all of them.
        velocity: (n_nodes, 3) at the end [m/s].
        director_rates: (n_directors, 3) of all normals at the end [1/s].
        unloaded_at: time from which no load acts [s].
        supported: whether the model has supports.
        solver: the linear solver that ran.
        seconds: wall-clock seconds by phase, of this process.
        memory: most that this process has had at a time until the end of the run [MB], None if
            unknown.
        settings: ``Settings``.
        items: ``{kind: names}`` of the joints, bodies and springs whose energies are kept, see
            ``energy_table``.
        hinges: (n, 2) angles and latches of joints at the end, as of a ``Configuration``.
    """

    history: np.ndarray
    displacement: np.ndarray
    normals: np.ndarray
    directors: np.ndarray
    velocity: np.ndarray
    director_rates: np.ndarray
    unloaded_at: float
    supported: bool
    solver: str
    seconds: Seconds
    memory: float | None
    settings: Settings
    items: dict = None
    hinges: np.ndarray = None

    def __repr__(self):
        last = self.history[-1]
        return (f"<Result: {len(self.history) - 1} steps to {last['time']:g} s, "
                f"{len(self.displacement)} nodes, {self.total_energy[-1]:.6g} J>")

    @property
    def total_energy(self):
        """(n_steps + 1,) kinetic plus strain energy [J]."""
        return total_energy(self.history)

    @property
    def state(self):
        """``Configuration`` at the end, for ``stresses``, and for another run to start from."""
        return Configuration(self.displacement, self.directors, velocity=self.velocity,
                             director_rates=self.director_rates, hinges=self.hinges)

    @property
    def balance(self):
        """``Balance`` of the run, see ``balance``."""
        return balance(self.history)

    @property
    def probes(self):
        """``{name: {what: (n_steps + 1, ...)}}``: of a node ``displacement`` [m] and ``velocity``
        [m/s]; of a ``StressProbe`` ``membrane_force`` (xx, yy, xy) [N/m], ``moment`` [N],
        ``shear_force`` (xz, yz) [N/m] and ``von_mises`` (top, middle, bottom) [Pa]; of an
        ``EnergyProbe`` ``strain_energy`` [J]; of a ``JointProbe`` ``angle`` [rad], ``rate``
        [rad/s], ``hinge_moment`` [N m], ``joint_force`` [N], ``stored``, ``work`` and ``lost`` [J],
        ``slide`` [m], ``speed`` [m/s], ``couple`` [N m], ``second_angle`` [rad] and ``second_rate``
        [rad/s].
        """
        return {name: {what: self.history[f"{name}{end}"] for end, (what, _) in
                       PROBES[kind].items()}
                for name, kind in probe_kinds(self.history.dtype).items()}

    @property
    def energy_balance(self):
        """Of the run, see ``energy_balance``."""
        return energy_balance(self.history)

    def frame(self):
        """The history as a ``pandas.DataFrame``, see ``data_frame``."""
        return data_frame(self.history)

    @property
    def drift(self):
        """``Drift`` since unloading; None if the run ends before or there."""
        return drift(self.history, self.unloaded_at, self.supported)


@checked
def total_energy(history: Motion):
    """Kinetic plus strain energy [J] of a history array.

    Raises:
        InputError: no history of a run.
    """
    return history["kinetic_energy"] + history["strain_energy"]


@checked
def balance(history: Motion):
    """``Balance`` of momenta with the impulses of loads and reactions, the largest of all steps.

    ``L(t) - L(0) - int (F + R) dt`` with the linear momentum L, the loads F, the reactions R, and
    the same of the angular momentum about the origin; relative to the largest of ``sum m |v|``
    (``sum m |x - x_c| |v|``) and of the impulses ``int |F| dt``, ``int |R| dt``.

    With ``rho_inf = 1`` forces balance but for what Newton's iteration leaves, and moments to the
    second order in dt; with less, both to the order of the damping.

    Raises:
        InputError: no history of a run.
    """
    dt = np.diff(history["time"], prepend=history["time"][0])

    def left(momentum, scale, *forces):
        impulses = [dt[:, None] * history[name] for name in forces]
        changed = history[momentum] - history[momentum][0] - np.cumsum(sum(impulses), axis=0)
        sizes = [np.linalg.norm(impulse, axis=1).sum() for impulse in impulses]
        return share(np.linalg.norm(changed, axis=1).max(), max(*sizes, history[scale].max()))

    return Balance(left("linear_momentum", "momentum_scale", "load", "reaction"),
                   left("angular_momentum", "angular_scale", "load_moment", "reaction_moment"))


def unaccounted(rows):
    """``E + D - W - W_s`` [J] of one row or all of a history, with the dissipated D and the works W
    of the loads and W_s of the supports: constant but for what the scheme adds or loses (with
    ``rho_inf < 1`` it loses some, which no column books)."""
    return (rows["kinetic_energy"] + rows["strain_energy"] + rows["dissipated"]
            - rows["external_work"] - rows["support_work"])


def gained(history):
    """(n,) energy that came from nothing, the change of ``unaccounted`` [J]; and the largest of E
    and of the sum of what is dissipated and the works [J]."""
    energy, left = total_energy(history), unaccounted(history)
    return left - left[0], max(energy.max(), np.abs(energy - left).max())


@checked
def energy_balance(history: Motion):
    """``|E + D - W - W_s - E(0)|``, the largest of all steps, relative to that of E and the works.

    With ``rho_inf = 1`` of second order in dt; with less it has what the scheme takes.

    Raises:
        InputError: no history of a run.
    """
    left, largest = gained(history)
    return share(np.abs(left).max(), largest)


def unloaded_row(history, unloaded_at):
    """Index of the first row at or after ``unloaded_at``, or None."""
    rows = np.flatnonzero(history["time"] >= unloaded_at * (1.0 - 1e-12))
    return int(rows[0]) if len(rows) else None


@checked
def drift(history: Motion, unloaded_at: End, supported: bool = False):
    """``Drift`` of a history since ``unloaded_at``; None where it ends before or there.

    Args:
        history: of a ``Result`` or ``read``.
        unloaded_at: time from which no load acts [s].
        supported: whether the model has supports.

    Raises:
        InputError: an argument of another kind.
    """
    first = unloaded_row(history, unloaded_at)
    if first is None or first == len(history) - 1:
        return None
    start, left = float(total_energy(history)[first]), unaccounted(history)[first:]

    def change(name, scale):
        if supported:
            return None
        values = history[name][first:]
        largest = history[scale].max()
        return float(np.abs(values - values[0]).max() / largest) if largest > 0.0 else 0.0

    return Drift(
        float(np.abs(left - left[0]).max() / start) if start > 0.0 else 0.0,
        change("linear_momentum", "momentum_scale"), change("angular_momentum", "angular_scale"),
        change("angular_momentum_printed", "angular_scale"))
