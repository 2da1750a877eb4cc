"""Running a model: the loop over time steps."""

import math
import time
from collections.abc import Callable
from typing import Annotated

import numpy as np
from threadpoolctl import threadpool_limits

from ..errors import InputError, StepError
from ..kernels.hinges import SLACK
from ..model.histories import Steps, TimeFunction
from ..model.joints import names_of
from ..model.loads import Centrifugal, Drive
from ..model.model import Model
from ..results.files import output_path
from ..results.layout import Sizes
from ..results.recorder import Recorder
from ..results.snapshot import snapshot
from ..results.stresses import Configuration, configuration
from ..runtime.memory import ELEMENT, check_memory, peak_memory
from ..runtime.provenance import describe
from ..signatures import Count, File, checked
from ..system.exact import ExactSystem
from ..system.failure import told
from ..system.loads import at_time
from ..system.moving import MovingSystem
from ..system.reactions import no_reactions
from ..system.system import System
from .adaptive import Adaptive
from .balance import Halvings, review
from .composed import Composed
from .newton import StepRecord
from .probes import Probes, probes_of
from .result import Result
from .settings import Settings
from .stepping import Stepper

LOST_IMPULSE = 0.05
"""Largest error of a load's impulse by sampling it once a step, relative to the impulse."""

SUDDEN = 0.5
"""Part of the range of a motion that may lie between two points within one step."""


@checked
def simulate(model: Model, settings: Settings, *, output: File = None, overwrite: bool = False,
             resume: bool = False, progress: Callable = None, case: str = None,
             probes: Annotated[dict, probes_of] = None, start: Configuration = None,
             threads: Count = 1):
    """Run ``model`` from rest (or its initial velocities, or ``start``) to ``settings.end_time``.

    Results are the same to the last bit with any number of threads.

    Args:
        model: ``Model``.
        settings: ``Settings``.
        output: result file (HDF5); None keeps the result in memory only.
        overwrite: replace ``output`` if it exists.
        resume: continue ``output`` from its last checkpoint if it exists.
        progress: called after every step with (step, n_steps, history row).
        case: name of the benchmark or the model file, stored with the result.
        probes: ``{name: node}``, or its initial place (x, y, z) [m]: nodes whose displacement and
            velocity are kept of every step; or a ``StressProbe``, an ``EnergyProbe`` or a
            ``JointProbe``.
        start: where it starts from: a state of a ``StaticResult``, at rest, or ``Result.state``,
            with its velocities; supports hold what is held where it is.
        threads: as many at most assemble, where there are some thousand nodes, and, with RSLAB,
            factorize and solve; the rest of linear algebra runs on one.

    Returns:
        ``Result``.

    Warns:
        AccuracyWarning: energy and work of the loads drift apart, many steps are halved, or
            rounding leaves few digits.

    Raises:
        InputError: a wrong parameter, or a history that does not fit into memory; nothing has
            been computed.
        ResultFileError: ``output`` exists, is damaged, foreign, or from other parameters.
        StepError: a step did not converge; ``output`` keeps everything up to its last checkpoint.
    """
    output = output_path(output, overwrite, resume)
    probes = check_run(model, settings, probes)
    if output is not None:
        _check_frames(model, settings)
    start = None if start is None else _start(model, start)
    with threadpool_limits(1), told():
        return _simulate(model, settings, output, overwrite, resume, progress, case, probes,
                         start, threads)


def check_run(model, settings, probes):
    """``Probes`` of a run that can begin.

    Raises:
        InputError: as of ``simulate``, for these arguments.
    """
    for k, load in enumerate(model.loads):
        if isinstance(load, Centrifugal):
            raise InputError(f"load {k}: centrifugal forces are those of a frame that turns, of "
                             "statics and modes; a shell in motion has them by its velocity, see "
                             "rigid_velocity")
    for number, section in enumerate(model.sections if settings.scheme.exact else ()):
        if section.laminate.arm:
            raise InputError(f"sections[{number}]: its mass is centred {section.laminate.arm:g} m "
                             "above the nodes, the scheme exact takes mass that is centred on "
                             "them: take quasi")
    if _joined(model) and not settings.scheme.takes_joints:
        raise InputError("rigid bodies, and joints but for hinges and spherical ones, need the "
                         "scheme exact, or quasi with rho_inf = 1")
    probes = Probes(model, probes or {})
    _check_memory(model, settings, probes.row)
    _check_moved(model, settings)
    if not settings.error:
        _check_impulses(model, settings)
    return probes


def _start(model, start):
    """A ``Configuration`` to start from, checked, with rates."""
    found = configuration("start", model, start)
    if np.any(model.velocity) or np.any(model.normal_velocity):
        raise InputError("start has its own velocities, the model must have none")
    return found


def _joined(model):
    """Whether a model has joints with multipliers, as bodies have."""
    return bool(model.linked or model.bodies)


def _dividing(stepper, settings, model):
    """What divides the steps of a run, or a ``Stepper`` that does not."""
    if settings.error:
        return Adaptive(stepper, settings, model)
    return Composed(stepper, model) if settings.scheme.order == 4 else stepper


def _simulate(model, settings, output, overwrite, resume, progress, case, probes, start,
              threads):
    scheme = settings.scheme
    if scheme.exact:
        system = ExactSystem(model, settings.solver, threads=threads)
    else:
        in_charts = MovingSystem if _joined(model) else System
        system = in_charts(model, settings.solver, scheme.axes == "nodal", threads=threads)
    stepper = Stepper(system, scheme, settings.newton, probes.joints)
    run = _Run(system, settings, probes, start)
    stepper.start(run.state)
    advance = _dividing(stepper, settings, model).advance
    if output is not None:
        run.record(output, overwrite, resume, case)
    clock = time.perf_counter()
    try:
        for step in range(run.done + 1, settings.n_steps + 1):
            record = StepRecord()
            advance(run.state, run.place, (step - 1) * settings.dt, settings.dt, record)
            if run.append(step, record):
                stepper.forget()
            if progress is not None:
                progress(step, settings.n_steps, run.history[step])
    except StepError:
        run.flush(everything=True)
        raise
    finally:
        run.flush()
    seconds = stepper.iteration.seconds
    seconds.total = time.perf_counter() - clock
    review(settings.scheme, run.history, system.roundoff_work(0.0))
    return Result(run.history, system.displacement(run.state), system.nodal_normals(run.place),
                  run.place.start.p, system.coordinates.velocity(run.state).copy(),
                  run.place.start.p_dot, model.unloaded_at, model.grounded,
                  system.solver.name, seconds, peak_memory(), settings, probes.energies.names,
                  run.state.hinges[:, :SLACK].copy())


RARELY, LEAST, MOST = 2e6, 25, 200
"""Checkpoints are frames at least ``RARELY`` / unknowns steps after the last one, but not more than
``MOST`` and not fewer than ``LEAST``: about a second of work, or 25 steps, is lost with a run that
is killed, and a factorization is dropped no more often."""


def _rarely(n_dof):
    """Steps after a checkpoint from which the next frame is one."""
    return int(np.clip(RARELY / n_dof, LEAST, MOST))


class _Run:
    """A state, its history, and the file they are written to.

    Attributes:
        state: ``State`` reached.
        place: ``Place`` of it.
        history: rows of all steps, see ``DYNAMICS``.
        done: step reached when the run starts.
        frame_of_step: number of the frame of each step that has one.
    """

    def __init__(self, system, settings, probes, start):
        self._system, self._settings, self._probes = system, settings, probes
        self._start = start and [array for array in start if isinstance(array, np.ndarray)]
        self.state = system.initial_state(start, settings.scheme.uses_accelerations)
        system.driven.check(self.state, at_time(0.0))
        system.driven.set_rates(self.state, at_time, 0.0, settings.dt)
        if system.linked and system.driven.moving:
            driven = system.loads(0.0, 0.0, settings.dt).driven
            system.linked.keep_rates(self.state, driven.before)
        self.place = system.observe(self.state)
        self.history = np.zeros(settings.n_steps + 1, dtype=probes.row)
        probes.attach(self.history)
        self.frame_of_step = {int(step): k for k, step in enumerate(settings.frame_steps)}
        self.done = 0
        self._recorder, self._written = None, 1
        self._rarely = _rarely(system.numbering.n_dof)
        self._checkpoint = 0
        self._halvings = Halvings(settings.dt, 0)
        self._fill(0, StepRecord())

    def record(self, output, overwrite, resume, case):
        """Write to a new file, or take over the state of the one to be continued."""
        model, settings = self._system.model, self._settings
        description = describe(model, settings, self._system.solver.name, case,
                               self._probes.description, self._start,
                               self._probes.energies.names)
        if resume and output.exists():
            self._recorder, self.done, rows = Recorder.resume(output, model, description,
                                                              self.state, settings.frame_steps)
            self.history[:self.done + 1] = rows
            self._system.observe(self.state, self.place)
        else:
            self._recorder = Recorder.create(output, model, description, self.state,
                                             self.history[:1], self._frame(0, StepRecord()),
                                             settings.frame_steps, overwrite)
        self._written, self._checkpoint = self.done + 1, self.done
        self._halvings = Halvings(settings.dt, int(self.history["halvings"].sum()))

    def append(self, step, record):
        """The history row of a step, and its frame if it has one; whether there is a checkpoint.

        A run that is resumed starts from a checkpoint without what is kept between steps, so all
        runs of these settings drop it there, recorded or not: they end in the same bits.
        """
        self._fill(step, record)
        self._halvings.add(step, record.halvings)
        if step not in self.frame_of_step:
            return False
        checkpoint = step - self._checkpoint >= self._rarely or step == len(self.history) - 1
        if checkpoint:
            self._checkpoint = step
        if self._recorder:
            self._recorder.keep(step, self.state, self.history[self._written:step + 1],
                                self._frame(step, record), checkpoint)
            self._written = step + 1
        return checkpoint

    def flush(self, everything=False):
        """Write what waits to be written, see ``Recorder.flush``."""
        if self._recorder:
            self._recorder.flush(everything)

    def _fill(self, step, record):
        """The history row of a step."""
        row = self.history[step]
        row["time"] = step * self._settings.dt
        for name in ("external_work", "support_work", "dissipated"):
            row[name] = getattr(self.state, name)
        for name, value in self.place.observed._asdict().items():
            row[OBSERVED.get(name, name)] = value
        for name in RECORDED:
            row[name] = getattr(record, name)
        row["load"] = record.loads.force / self._settings.dt
        row["load_moment"] = record.loads.moment / self._settings.dt
        if record.impulses:
            row["reaction"] = record.impulses.force / self._settings.dt
            row["reaction_moment"] = record.impulses.moment / self._settings.dt
        self._probes.write(step, self._system, self.state, self.place, record,
                           self._settings.dt)

    def _frame(self, step, record):
        system, reactions = self._system, None
        if system.supported:
            none = no_reactions(len(system.model.nodes))
            reactions = none.plus(record.impulses or none, 1.0 / self._settings.dt)
        return (self.frame_of_step[step], self.history["time"][step],
                snapshot(system, self.state, self.place, reactions, self._settings.stresses))


RECORDED = ("iterations", "work_ratio", "switches", "halvings", "indefinite", "parts", "rejected",
            "local_error")
"""Columns of the history that are those of a ``StepRecord``."""

OBSERVED = {"kinetic": "kinetic_energy", "strain": "strain_energy"}
"""Columns of the history that are called differently in an ``Observation``."""


SAMPLE, FRAME = 40, 250
"""Bytes that a step takes in memory beside its row, for the samples of its loads, and a frame."""


def _check_memory(model, settings, row):
    """The history of all steps is kept in memory, and where every frame is."""
    steps, frames = settings.n_steps, settings.n_steps // max(settings.frame_every, 1)
    check_memory(f"the history of {steps} steps",
                 steps * (row.itemsize + SAMPLE) + (frames * FRAME if settings.frame_every else 0))
    check_memory(f"a model of {len(model.quads)} elements", len(model.quads) * ELEMENT)


STATE = 3 * 40 * 8
"""Bytes that states for a checkpoint take a node: three of about 40 numbers."""


def _check_frames(model, settings):
    """Frames between two checkpoints wait in memory, and while they are written as long again."""
    fields = Sizes(False, len(model.nodes), len(model.quads), len(model.normals), 0, 0, 0,
                   bool(model.supports) or model.grounded, settings.stresses).fields
    each = 8 * sum(math.prod(shape) for _, shape in fields.values())
    between = np.diff(settings.frame_steps).max()
    waiting = min(-(-_rarely(5 * len(model.nodes)) // between), len(settings.frame_steps))
    check_memory(f"{waiting} frames between two checkpoints",
                 2 * waiting * each + STATE * len(model.nodes))


def _check_moved(model, settings):
    """Functions of time of supports that move, and of joints that are driven, are finite, and do
    not jump."""
    moved = [(f"support {k}", "support", history) for k, support in enumerate(model.supports)
             if isinstance(support, Drive) or support.displacement
             for history in {support.history, getattr(support, "turning", support.history)}]
    moved += [(name, "joint", joint.driving) for name, joint in zip(
        names_of(model.joints), model.joints) if getattr(joint, "angle", None) is not None]
    times = settings.dt * np.arange(settings.n_steps + 1)
    for name, what, history in moved:
        values = _finite(name, history, times)
        if isinstance(history, Steps) and np.any(np.diff(values)):
            raise InputError(f"{name}: its time function jumps at t = "
                             f"{times[np.argmax(np.diff(values) != 0.0) + 1]:g} s, a {what} "
                             "cannot: give the points of a ramp")
        if isinstance(history, TimeFunction):
            spans, changes = np.diff(history.times), np.abs(np.diff(history.values))
            sudden = (spans < settings.dt) & (changes > SUDDEN * np.ptp(history.values))
            if np.any(sudden):
                k = int(np.argmax(sudden))
                raise InputError(f"{name}: its time function goes from {history.values[k]:g} to "
                                 f"{history.values[k + 1]:g} within {spans[k]:g} s, a {what} "
                                 f"cannot in a step of {settings.dt:g} s: give a longer ramp, or a "
                                 "smaller dt")


def _finite(name, history, times):
    """Values of a function of time, which must be finite."""
    with np.errstate(all="ignore"):
        values = history(times)
    if not np.all(np.isfinite(values)):
        bad = np.argmin(np.isfinite(values))
        raise InputError(f"{name}: its time function is {values[bad]} at t = {times[bad]:g} s")
    return values


def _check_impulses(model, settings):
    """Loads are sampled once a step, at its generalized midpoint: dt must not miss a pulse."""
    alpha_f = settings.scheme.alpha_f
    for k, load in enumerate(model.loads):
        end = min(settings.end_time, load.history.settled)
        middle = (np.arange(int(np.ceil(end / settings.dt))) + 1.0 - alpha_f) * settings.dt
        _finite(f"load {k}", load.history, middle)
        lost, whole = load.history.lost(middle, settings.dt) if end > 0.0 else (0.0, 0.0)
        if lost > LOST_IMPULSE * whole:
            shortest = min(np.diff(getattr(load.history, "times", ())), default=end)
            raise InputError(f"load {k}: dt {settings.dt:g} s is too long for its time function: "
                             f"the steps miss {lost:.4g} s of its integral {whole:.4g} s up to t = "
                             f"{end:g} s; the shortest time between its points is "
                             f"{shortest:.4g} s")
