"""Running a model: the loop over time steps, and the result."""

import time
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from ..checks import instance
from ..errors import InputError
from ..model.model import Model
from ..results.files import output_path
from ..results.recorder import Recorder
from ..runtime.provenance import describe
from ..system.system import Seconds, StepRecord, System
from .settings import Settings

HISTORY = np.dtype([
    ("time", "f8"), ("kinetic_energy", "f8"), ("strain_energy", "f8"), ("external_work", "f8"),
    ("linear_momentum", "f8", 3), ("angular_momentum", "f8", 3),
    ("angular_momentum_printed", "f8", 3), ("momentum_scale", "f8"), ("angular_scale", "f8"),
    ("iterations", "i4"), ("residual", "f8"), ("switches", "i4"), ("halvings", "i4"),
    ("indefinite", "i4")])
"""One row a step; ``angular_momentum_printed`` is Eq. (50) as printed (one sum over nodes)."""

LOST_IMPULSE = 0.05
"""Largest error of a load's impulse by sampling it once a step, relative to the largest impulse."""


@dataclass(frozen=True)
class Drift:
    """Largest change since unloading: of the energy relative to itself, of the momenta relative to
    the largest sum m |v| and sum m |x - x_c| |v| of the whole run (None for a supported shell,
    whose momenta are not conserved)."""

    energy: float
    linear_momentum: float | None
    angular_momentum: float | None
    angular_momentum_printed: float | None


@dataclass(frozen=True, eq=False)
class Result:
    """Histories and last state of a run.

    Attributes:
        history: (n_steps + 1,) structured array, fields of ``HISTORY``.
        displacement: (n_nodes, 3) at the end [m].
        normals: (n_nodes, 3) at the end, at a junction that of its first plate.
        unloaded_at: time from which no load acts [s].
        supported: whether the model has supports.
        solver: the linear solver that ran.
        seconds: wall-clock seconds by phase, of this process.
        settings: ``Settings``.
    """

    history: np.ndarray
    displacement: np.ndarray
    normals: np.ndarray
    unloaded_at: float
    supported: bool
    solver: str
    seconds: Seconds
    settings: Settings

    @property
    def total_energy(self):
        """(n_steps + 1,) kinetic plus strain energy [J]."""
        return total_energy(self.history)

    @property
    def drift(self):
        """``Drift`` since unloading; None if the run ends before or there."""
        return drift(self.history, self.unloaded_at, self.supported)


def total_energy(history):
    """Kinetic plus strain energy [J] of a history array."""
    return history["kinetic_energy"] + history["strain_energy"]


def unloaded_row(history, unloaded_at):
    """Index of the first row at or after ``unloaded_at``, or None."""
    rows = np.flatnonzero(history["time"] >= unloaded_at * (1.0 - 1e-12))
    return int(rows[0]) if len(rows) else None


def drift(history, unloaded_at, supported=False):
    """``Drift`` of a history since ``unloaded_at``; None where it ends before or there."""
    first = unloaded_row(history, unloaded_at)
    if first is None or first == len(history) - 1:
        return None
    energy = total_energy(history)[first:]

    def change(name, scale):
        if supported:
            return None
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
        model: ``Model``.
        settings: ``Settings``.
        output: result file (HDF5); None keeps the result in memory only.
        overwrite: replace ``output`` if it exists.
        resume: continue ``output`` from its last checkpoint if it exists.
        progress: called after every step with (step, n_steps, history row).
        case: name of the benchmark or the model file, stored with the result.

    Returns:
        ``Result``.

    Raises:
        InputError: a wrong parameter; nothing has been computed.
        ResultFileError: ``output`` exists, is damaged, foreign, or from other parameters.
        StepError: a step did not converge; ``output`` keeps everything up to its last checkpoint.
    """
    instance("model", model, Model)
    instance("settings", settings, Settings)
    for k, support in enumerate(model.supports):
        if support.displacement != 0.0:
            raise InputError(f"support {k}: displacements can be prescribed in statics only")
    if resume and output is None:
        raise InputError("resume needs output, the file to continue")
    output = output_path(output, overwrite, resume)
    _check_impulses(model, settings)
    with threadpool_limits(1):
        return _simulate(model, settings, output, overwrite, resume, progress, case)


def _simulate(model, settings, output, overwrite, resume, progress, case):
    scheme = settings.scheme
    system = System(model, settings.solver, scheme.axes == "nodal")
    state = system.initial_state()
    n_steps, frame_steps = settings.n_steps, settings.frame_steps
    history = np.zeros(n_steps + 1, dtype=HISTORY)
    done = 0
    recorder = None
    frame_of_step = {int(s): k for k, s in enumerate(frame_steps)}
    if output is not None:
        description = describe(model, settings, system.solver.name, case)
        if resume and output.exists():
            recorder, done, rows = Recorder.resume(output, model, description, state)
            history[:done + 1] = rows
            system.observe(state)
        else:
            _fill(history[0], 0.0, system.observe(state), state, StepRecord())
            recorder = Recorder.create(output, model, description, state, history[:1],
                                       _frame(system, state, 0, 0.0), frame_steps, overwrite)
    else:
        _fill(history[0], 0.0, system.observe(state), state, StepRecord())
    written = done + 1
    clock = time.perf_counter()
    system.seconds = Seconds()
    for step in range(done + 1, n_steps + 1):
        record = StepRecord()
        instant = system.advance(state, scheme, settings.newton,
                                 (step - 1) * settings.dt, settings.dt, record)
        _fill(history[step], step * settings.dt, instant, state, record)
        if step in frame_of_step:
            system.kept.forget()
        if recorder and step in frame_of_step:
            recorder.write(step, state, history[written:step + 1],
                           _frame(system, state, frame_of_step[step], history["time"][step]))
            written = step + 1
        if progress is not None:
            progress(step, n_steps, history[step])
    system.seconds.total = time.perf_counter() - clock
    return Result(history, state.x - model.nodes + state.x_low, system.nodal_normals,
                  model.unloaded_at, bool(model.supports), system.solver.name, system.seconds,
                  settings)


def _check_impulses(model, settings):
    """Loads are sampled once a step, at its generalized midpoint: dt must not miss a pulse."""
    alpha_f = settings.scheme.alpha_f
    for k, load in enumerate(model.loads):
        end = min(settings.end_time, load.history.times[-1])
        if end <= 0.0:
            continue
        steps = np.arange(int(np.ceil(end / settings.dt)))
        middle = (steps + 1.0 - alpha_f) * settings.dt
        sampled = settings.dt * np.interp(middle, load.history.times, load.history.values).sum()
        exact = load.history.integral(steps.size * settings.dt)
        largest = np.abs(load.history.values).max() * end
        if abs(sampled - exact) > LOST_IMPULSE * max(abs(exact), 1e-3 * largest):
            raise InputError(f"load {k}: dt {settings.dt:g} s is too long for its time function; "
                             f"the steps see {sampled:.4g} s of its integral {exact:.4g} s up to "
                             f"t = {end:g} s")


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


def _frame(system, state, index, time_):
    displacement = state.x - system.model.nodes + state.x_low
    return index, time_, {"PointData": {"displacement": displacement,
                                        "normal": system.nodal_normals},
                          "CellData": {"strain_energy": system.element_energy}}
