"""Compilation of the kernels before they are needed, once for all processes of a user.

It takes more than a minute, half of it for a scheme's kernel that assembles, which a process
beside this one compiles where there is a core for it.
"""

import shutil
import subprocess
import sys
import time
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from filelock import FileLock, Timeout
from numpy import zeros

from .dynamics.kept_matrix import KeptMatrix
from .dynamics.probes import StressProbe
from .dynamics.scheme import Scheme
from .dynamics.settings import Settings
from .dynamics.simulation import simulate
from .kernels import assembly, exact, updates
from .model.histories import TimeFunction
from .model.loads import NodalLoad
from .model.model import Model
from .runtime.compiling import announce
from .runtime.process import child_environment
from .runtime.provenance import usable_cores
from .system.exact import ExactSystem
from .system.linear import SuperLU, make_solver
from .system.state import blank_place, blank_state
from .system.system import System

DT = 0.01

ASSEMBLING = {System: assembly.step_system, ExactSystem: exact.step_exact}
"""Kernels that assemble, of the quasi-conserving and of the exact scheme."""

PATIENCE = 2.0
"""Seconds of waiting that nobody is told of: others only load the kernels."""

BESIDE = "beside-"
"""How the folder of a process beside begins."""


def warm_up(exact=False):
    """Compile (or load from the cache) the kernels of a run under dead forces; seconds it took.

    With ``exact`` also those of the scheme of that name, which takes half as long again.
    Processes that come meanwhile wait for it instead of compiling the same.
    """
    clock = time.perf_counter()
    folder = _folder()
    folder.mkdir(parents=True, exist_ok=True)
    with _one_at_a_time(folder):
        wanted = (System, ExactSystem) if exact else (System,)
        new = [kind for kind in wanted if not list(folder.glob(_files_of(kind)))]
        if new:
            announce()
        if new and usable_cores() > 1:
            with ExitStack() as beside:
                for kind in new:
                    beside.enter_context(_assembly_beside(folder, kind))
                if System in new:
                    _compile_others()
        for solver in ("auto", "skyline", "dense"):
            # three steps without a checkpoint: the second and third carry the matrix of the first
            simulate(_plate(), Settings(dt=DT, end_time=3 * DT, solver=solver, frame_every=3),
                     probes={"stress": StressProbe(0)})
        if exact:
            for solver in ("auto", "skyline"):
                simulate(_plate(), Settings(dt=DT, end_time=3 * DT, scheme=Scheme("exact"),
                                            solver=solver, frame_every=3))
    return time.perf_counter() - clock


def _files_of(kind):
    """Pattern of the files of a kernel that assembles: its index and what the index names."""
    kernel = ASSEMBLING[kind].py_func
    return f"{kernel.__module__.rpartition('.')[2]}.{kernel.__name__}-*"


def _compile_others():
    """Compile what does not assemble."""
    system, scheme = System(_plate()), Scheme()
    coordinates, zero = system.coordinates, zeros(system.numbering.n_dof)
    state = coordinates.initial_state(system.model)
    place = system.observe(state)
    for name in ("dense", "skyline"):
        system.solver = make_solver(name, system.numbering)
        system.solver.values[system.solver.storage.diagonal] = 1.0
        system.factorize()
        system.solver.solve(zero)
    SuperLU(system.numbering)
    kept, step = KeptMatrix(system), scheme.midpoint(DT)
    kept.made(step, state, place)
    kept.carry(state, place)
    kept.solve(zero)
    system.inside(state, place, step, zero)
    coordinates.accept(state, scheme.end(DT), zero)
    coordinates.renew(state, DT)
    updates.predict_strains(system.elements, system.dofs.nodes, state.motion, place.start, zero,
                            system.predictions())
    coordinates.largest_turn(place.start, zero)
    coordinates.correct(state, place.start, zero)


def compile_assembly(name):
    """Compile the kernel that assembles for the class of systems ``name``; prints where its files
    are."""
    kind = next(kind for kind in ASSEMBLING if kind.__name__ == name)
    system = kind(_plate())
    model, n_dof = system.model, system.numbering.n_dof
    place = blank_place(system.elements, len(model.normals))
    system.assemble(blank_state(model.nodes, n_dof), place, Scheme().midpoint(DT), zeros(n_dof),
                    system.loads(0.0))
    print(_folder())


@contextmanager
def _one_at_a_time(folder):
    """Wait until no other process is here; where files cannot be locked, do not wait."""
    lock = FileLock(folder / "compiling.lock")
    try:
        try:
            lock.acquire(timeout=PATIENCE)
        except Timeout:
            _tell("waiting for another process, which compiles the kernels")
            lock.acquire()
    except (NotImplementedError, OSError):
        pass
    try:
        yield
    finally:
        lock.release()


@contextmanager
def _assembly_beside(folder, kind):
    """Compile a kernel of ``ASSEMBLING`` in a process beside; its files end in ``folder``.

    It has a cache of its own, for numba's is not safe for two that write.  If it fails, whoever
    needs the kernel compiles it.
    """
    beside = f"{BESIDE}{kind.__name__}-"
    for left in folder.glob(f"{beside}*"):  # of processes that were killed
        shutil.rmtree(left, ignore_errors=True)
    with TemporaryDirectory(prefix=beside, dir=folder) as own:
        with subprocess.Popen(
                [sys.executable, "-c",
                 "from corovec.solver.runtime.process import end_with_parent; end_with_parent(); "
                 f"from {__name__} import compile_assembly; compile_assembly({kind.__name__!r})"],
                stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                env=child_environment(NUMBA_CACHE_DIR=own)) as process:
            try:
                yield
                output = process.communicate()[0]
            finally:
                process.kill()
        if process.returncode == 0:
            # the index, .nbi, comes last: it must name nothing that is not there
            for path in sorted(Path(output.strip()).glob(_files_of(kind))):
                path.replace(folder / path.name)


def _tell(text):
    print(f"corovec: {text}", file=sys.stderr)


def _folder():
    """Where numba keeps compiled kernels."""
    return Path(assembly.step_system.stats.cache_path)


def _plate():
    """The smallest model: one element, under a pulse."""
    nodes = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)]
    pulse = TimeFunction((0.0, 1.0), (1.0, 0.0))
    return Model(nodes, [(0, 1, 2, 3)], thickness=0.1, youngs=1.0, poisson=0.0, density=1.0,
                 loads=[NodalLoad(0, (0.0, 0.0, 1e-3), pulse)])
