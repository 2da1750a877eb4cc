"""Running a model: settings, the loop over time steps, and the result."""

import hashlib
import platform
import time
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from .errors import InputError
from .linear import SOLVERS
from .model import Model, NodalLoad, TimeFunction
from .recorder import HISTORY, Recorder
from .scheme import SCHEMES, TRANSFORMATIONS, make_scheme
from .system import NewtonRule, Seconds, StepRecord, System

DEFAULT_FRAMES = 200
"""Frames written when their interval is not given."""


@dataclass(frozen=True)
class Settings:
    """How a model is run.

    Attributes:
        dt: time step [s]; end_time: simulated time [s], a multiple of dt.
        scheme, rho_inf, transformation: see :func:`solver.make_scheme`.
        solver: ``auto``, ``skyline`` or ``dense``.
        tolerance, min_iterations: convergence rule of Eq. (67).
        max_iterations: iterations after which a step is halved.
        frame_every: steps between two frames (and checkpoints); 0 for about 200 frames a run.
    """

    dt: float
    end_time: float
    scheme: str = "quasi"
    rho_inf: float = 1.0
    transformation: str = "midpoint"
    solver: str = "auto"
    tolerance: float = 1e-6
    min_iterations: int = 3
    max_iterations: int = 20
    frame_every: int = 0

    def __post_init__(self):
        for name in ("dt", "end_time"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise InputError(f"{name} must be positive and finite [s], is {value:g}")
        steps = self.end_time / self.dt
        if abs(steps - round(steps)) > 1e-6 or round(steps) < 1:
            below = int(steps)
            raise InputError(f"end_time {self.end_time:g} s is not a multiple of dt {self.dt:g} s; "
                             f"the nearest ones are {below * self.dt:g} and "
                             f"{(below + 1) * self.dt:g} s")
        for name, choices in (("scheme", SCHEMES), ("transformation", TRANSFORMATIONS),
                              ("solver", SOLVERS)):
            if getattr(self, name) not in choices:
                raise InputError(f"{name} '{getattr(self, name)}' is unknown, must be one of: "
                                 f"{', '.join(choices)}")
        if self.frame_every < 0:
            raise InputError(f"frame_every must not be negative, is {self.frame_every}")
        make_scheme(self.scheme, self.rho_inf, self.transformation)
        NewtonRule(self.tolerance, self.min_iterations, self.max_iterations)

    @property
    def n_steps(self):
        return round(self.end_time / self.dt)

    @property
    def newton(self):
        return NewtonRule(self.tolerance, self.min_iterations, self.max_iterations)

    @property
    def frame_steps(self):
        """Steps after which a frame is written: every n-th one, and the last."""
        every = self.frame_every or max(1, self.n_steps // DEFAULT_FRAMES)
        steps = np.arange(0, self.n_steps + 1, every)
        return steps if steps[-1] == self.n_steps else np.append(steps, self.n_steps)


@dataclass(frozen=True)
class Drift:
    """Largest change since unloading: of the energy relative to itself, of the momenta relative to
    the largest sum m |v| and sum m |x - x_c| |v| of the whole run."""

    energy: float
    linear_momentum: float
    angular_momentum: float
    angular_momentum_printed: float


@dataclass(frozen=True)
class Result:
    """Histories and last state of a run.

    Attributes:
        history: (n_steps + 1,) structured array, fields of ``solver.recorder.HISTORY``.
        displacement: (n_nodes, 3) at the end [m]; normals: (n_nodes, 3).
        unloaded_at: time from which no load acts [s].
        solver: the linear solver that ran.
        seconds: wall-clock seconds by phase, of this process.
        settings: :class:`Settings`.
    """

    history: np.ndarray
    displacement: np.ndarray
    normals: np.ndarray
    unloaded_at: float
    solver: str
    seconds: Seconds
    settings: Settings

    @property
    def total_energy(self):
        """(n_steps + 1,) kinetic plus strain energy [J]."""
        return total_energy(self.history)

    @property
    def drift(self):
        """:class:`Drift` since unloading; None if the run ends before."""
        return drift(self.history, self.unloaded_at)


def total_energy(history):
    """Kinetic plus strain energy [J] of a history array."""
    return history["kinetic_energy"] + history["strain_energy"]


def unloaded_row(history, unloaded_at):
    """Index of the first row at or after ``unloaded_at``, or None."""
    rows = np.flatnonzero(history["time"] >= unloaded_at * (1.0 - 1e-12))
    return int(rows[0]) if len(rows) else None


def drift(history, unloaded_at):
    """:class:`Drift` of a history since ``unloaded_at``; None where it ends before."""
    first = unloaded_row(history, unloaded_at)
    if first is None:
        return None
    energy = total_energy(history)[first:]

    def change(name, scale):
        values = history[name][first:]
        largest = history[scale].max()
        return float(np.abs(values - values[0]).max() / largest) if largest > 0.0 else 0.0

    return Drift(
        float(np.abs(energy - energy[0]).max() / energy[0]) if energy[0] > 0.0 else 0.0,
        change("linear_momentum", "momentum_scale"), change("angular_momentum", "angular_scale"),
        change("angular_momentum_printed", "angular_scale"))


def simulate(model, settings, *, output=None, overwrite=False, resume=False, progress=None,
             case=None):
    """Run ``model`` from rest (or its initial velocities) to ``settings.end_time``.

    Linear algebra runs on one thread: faster at these sizes, and bitwise repeatable.

    Args:
        model: :class:`solver.Model`; settings: :class:`Settings`.
        output: result file (HDF5); None keeps the result in memory only.
        overwrite: replace ``output`` if it exists.
        resume: continue ``output`` from its last checkpoint if it exists.
        progress: called after every step with (step, n_steps, history row).
        case: name and mesh of a benchmark, stored with the result.

    Returns:
        :class:`Result`.

    Raises:
        InputError: a wrong parameter; nothing has been computed.
        ResultFileError: ``output`` exists, is damaged, foreign, or from other parameters.
        StepError: a step did not converge; ``output`` keeps everything up to its last checkpoint.
    """
    for k, support in enumerate(model.supports):
        if support.displacement != 0.0:
            raise InputError(f"support {k}: displacements can be prescribed in statics only")
    with threadpool_limits(1):
        return _simulate(model, settings, output, overwrite, resume, progress, case)


def _simulate(model, settings, output, overwrite, resume, progress, case):
    system = System(model, settings.solver)
    scheme = make_scheme(settings.scheme, settings.rho_inf, settings.transformation)
    state = system.initial_state()
    n_steps, frame_steps = settings.n_steps, settings.frame_steps
    history = np.zeros(n_steps + 1, dtype=HISTORY)
    done = 0
    recorder = None
    frame_of_step = {int(s): k for k, s in enumerate(frame_steps)}
    if output is not None:
        description = describe(model, settings, system.solver.name, case)
        if resume and Path(output).exists():
            recorder, done, state, rows = Recorder.resume(output, description)
            history[:done + 1] = rows
            system.observe(state)
        else:
            recorder = Recorder.create(output, model, description, state, frame_steps, n_steps,
                                       overwrite)
    written = done + 1
    if done == 0:
        _fill(history[0], 0.0, system.observe(state), state, StepRecord())
        if recorder:
            recorder.write(0, state, history[:1], 0, _frame(system, state, 0))
    clock = time.perf_counter()
    system.seconds = Seconds()
    for step in range(done + 1, n_steps + 1):
        record = StepRecord()
        instant = system.advance(state, scheme, settings.newton, (step - 1) * settings.dt,
                                 settings.dt, record)
        _fill(history[step], step * settings.dt, instant, state, record)
        if recorder and step in frame_of_step:
            recorder.write(step, state, history[written:step + 1], written,
                           _frame(system, state, frame_of_step[step]))
            written = step + 1
        if progress is not None:
            progress(step, n_steps, history[step])
    system.seconds.total = time.perf_counter() - clock
    return Result(history, state.x - model.nodes + state.x_low, system.p.copy(), model.unloaded_at,
                  system.solver.name, system.seconds, settings)


def warm_up():
    """Compile (or load from the cache) every kernel a run needs; returns the seconds it took."""
    clock = time.perf_counter()
    nodes = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)]
    pulse = TimeFunction((0.0, 1.0), (1.0, 0.0))
    plate = Model(nodes, [(0, 1, 2, 3)], thickness=0.1, youngs=1.0, poisson=0.0, density=1.0,
                  loads=[NodalLoad(0, (0.0, 0.0, 1e-3), pulse)])
    for solver in ("auto", "skyline", "dense"):
        simulate(plate, Settings(dt=0.01, end_time=0.01, solver=solver))
    return time.perf_counter() - clock


def describe(model, settings, solver, case=None):
    """What a result file says of its run; a resumed run must agree but for versions and machine."""
    return {"case": case, "model": fingerprint(model), "settings": asdict(settings),
            "solver": solver, "unloaded_at": model.unloaded_at,
            "versions": versions(), "machine": machine()}


def fingerprint(model):
    """SHA-256 of everything that defines a model."""
    digest = hashlib.sha256()
    for array in (model.nodes, model.quads, model.thickness, model.youngs, model.poisson,
                  model.density, model.normals, model.velocity, model.normal_velocity):
        digest.update(np.ascontiguousarray(array).tobytes())
    digest.update(repr((model.loads, model.supports, model.membrane, model.shear)).encode())
    return digest.hexdigest()


def versions():
    """Versions that a result depends on."""
    names = ("corovec", "numpy", "scipy", "numba", "h5py")
    return {"python": platform.python_version(), **{name: metadata.version(name) for name in names}}


def machine():
    """Processor and operating system."""
    model = platform.processor() or platform.machine()
    try:
        with open("/proc/cpuinfo") as info:
            model = next(line.split(":", 1)[1].strip() for line in info if "model name" in line)
    except (OSError, StopIteration):
        pass
    return {"processor": model, "system": f"{platform.system()} {platform.machine()}"}


def _fill(row, time_, instant, state, record):
    for name, value in (
            ("time", time_), ("kinetic_energy", instant.kinetic),
            ("strain_energy", instant.strain), ("external_work", state.external_work),
            ("linear_momentum", instant.linear_momentum),
            ("angular_momentum", instant.angular_momentum),
            ("angular_momentum_printed", instant.angular_momentum_printed),
            ("momentum_scale", instant.momentum_scale), ("angular_scale", instant.angular_scale),
            ("iterations", record.iterations), ("residual", record.residual),
            ("switches", record.switches), ("halvings", record.halvings),
            ("indefinite", record.indefinite)):
        row[name] = value


def _frame(system, state, index):
    displacement = state.x - system.model.nodes + state.x_low
    return index, displacement, system.p, system.element_energy
