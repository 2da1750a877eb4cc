"""What the solver must reach, beside what it does, every row measured in one run.

Times of steps are in units of D, the time of one LAPACK LU of a full matrix on the same machine,
which is measured before and after them.
"""

import subprocess
import sys
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack

from corovec import Settings, read, simulate
from corovec.benchmarks import load_case
from corovec.solver.dynamics.result import unloaded_row
from corovec.solver.model.mesh import node_at

from .measure import Stepper, extent, sample, time_calls

CASE = "l-plate"
SMALL, PAPER = 30, 480
PAPER_UNKNOWNS = 2745
SKYLINE_STEPS = 100

RUN_SECONDS, COMPARED_SECONDS, REFERENCE_DT = 80.0, 20.0, 1e-4
CANDIDATES = (0.05, 0.025, 0.02, 0.0125, 0.01, 0.005, 0.0025, 0.002, 0.001, 5e-4)
FRAME_SECONDS = 0.2
ENERGY_BOUND, PATH_BOUND = 1e-3, 1e-2
"""Largest changes of the energy after unloading, relative, and of the displacement of S over the
plate's largest side, from those with the paper's step."""


@dataclass(frozen=True)
class Target:
    """A number beside what it must be, and what it should be; both are upper bounds.

    ``rounds``: the number as each round has it; ``missed``: whether there are none because it
    cannot be reached at all.
    """

    name: str
    unit: str
    target: float
    goal: float
    rounds: tuple = ()
    detail: str = ""
    missed: bool = False

    @property
    def value(self):
        """Median of the rounds, None without any."""
        return float(np.median(self.rounds)) if self.rounds else None

    @property
    def met(self):
        """``goal``, ``target``, ``no``, or ``not measured``."""
        if self.value is None:
            return "no" if self.missed else "not measured"
        return "goal" if self.value <= self.goal else "target" if self.value <= self.target else (
            "no")

    def row(self):
        """The row of the table."""
        return {**vars(self), "value": self.value, **extent(self.rounds), "met": self.met}


def targets(effort, folder=None, progress=lambda text: None):
    """(rows of all ``Target`` s, the dense LU's time as a row).

    ``folder``: where the runs of the whole-run target are kept and, if they are there, resumed;
    without it, or in the quick size, that target is not measured.
    """
    definition = load_case(CASE)
    small, paper = definition.model(SMALL), definition.model(PAPER)
    dt = definition.paper.dt.value
    progress("D, the dense LU")
    D, rows, hundred = dense_lu(effort.rounds), [], []
    for method, target, goal, name in (
            ("skyline", 4.0, 3.0, "skyline, full Newton: 100 steps of the L-plate 8x60"),
            ("auto", 1.0, 0.5, "production: 100 steps of the L-plate 8x60")):
        progress(name)
        hundred.append((name, target, goal, _hundred_steps(paper, dt, method, effort)))
    D += dense_lu(effort.rounds)
    for name, target, goal, time_ in hundred:
        rows.append(Target(name, "D", target, goal, time_.scaled(1.0 / D.median).cpu,
                           f"{time_.median:.4g} s"))
    progress("element tangents and forces")
    rows += _elements(paper, dt, effort.rounds)
    progress("factorizations")
    rows.append(_factorization(paper, dt, effort))
    progress("production step of the small model")
    rows.append(_overhead(small, dt, effort.rounds))
    progress("start of a second process")
    rows.append(_start())
    rows.append(_whole_run(paper, folder, progress) if effort.reference and folder is not None
                else _run_target())
    return rows, {"unknowns": PAPER_UNKNOWNS, **D.row("D")}


def dense_lu(rounds, n=PAPER_UNKNOWNS):
    """``Sample`` of one LAPACK LU (getrf) of a full random matrix of ``n`` unknowns: D."""
    matrix = np.random.default_rng(1).standard_normal((n, n))
    held = {}

    def copy():
        held["a"] = matrix.copy(order="F")

    def factor():
        lapack.dgetrf(held["a"], overwrite_a=1)

    copy()
    factor()
    return sample(factor, max(rounds, 5), copy)


def _hundred_steps(model, dt, method, effort):
    stepper = Stepper(model, dt, method)
    once = sample(stepper.steps, 1).median
    count = int(np.clip(effort.round_seconds / once, 1, SKYLINE_STEPS))
    return sample(lambda: stepper.steps(count), effort.rounds).scaled(SKYLINE_STEPS / count)


def _elements(model, dt, rounds):
    """Whole assemblies an element: strains, forces, tangents, inertia and scattering."""
    stepper = Stepper(model, dt)
    stepper.steps()
    rows = []
    for name, tangent, target in (("element tangent and forces", True, 4.0),
                                  ("element forces alone", False, 1.0)):
        time_ = sample(lambda t=tangent: stepper.assemble(t), 5 * rounds)
        rows.append(Target(name, "µs/element", target, target / 2.0,
                           time_.scaled(1e6 / len(model.quads)).cpu,
                           f"whole assembly, scatter included, {len(model.quads)} elements"))
    return rows


def _factorization(model, dt, effort):
    """Skyline against LAPACK's banded Cholesky on the same matrix, both overwriting."""
    stepper = Stepper(model, dt, "skyline")
    skyline = time_calls(stepper, effort).factor
    stepper.use("banded-cholesky")
    stepper.assemble()
    system = stepper.system
    band = system.solver.values.reshape(system.numbering.n_dof, -1).copy()
    held = {}

    def copy():
        held["a"] = band.copy().T

    cholesky = sample(lambda: lapack.dpbtrf(held["a"], lower=1, overwrite_ab=1),
                      len(skyline.cpu), copy)
    return Target("skyline factorization / LAPACK banded Cholesky", "", 1.5, 1.0,
                  skyline.scaled(1.0 / cholesky.median).cpu,
                  f"{1e3 * skyline.median:.3g} ms / {1e3 * cholesky.median:.3g} ms, "
                  f"{system.numbering.n_dof} unknowns")


def _overhead(model, dt, rounds):
    """Of a production step of the small model, what is not assembly of forces."""
    stepper = Stepper(model, dt)
    stepper.steps()
    step = sample(lambda: stepper.steps(20), 3 * rounds).scaled(1.0 / 20.0)
    assembly = sample(lambda: stepper.assemble(False), 10 * rounds)
    beside = stepper.iterations * assembly.median
    return Target("production step of the 30-element model beyond the element work", "ms", 0.15,
                  0.075, tuple(1e3 * (seconds - beside) for seconds in step.cpu),
                  f"step {1e3 * step.median:.3g} ms, {stepper.iterations:.2f} assemblies of "
                  f"{1e3 * assembly.median:.3g} ms")


def _start():
    """Wall-clock seconds of a second process from its start to the end of its first step."""
    command = [sys.executable, "-m", "corovec", "run", CASE, "--elements", str(SMALL), "--dt",
               "1e-2", "--end-time", "1e-2", "--json"]

    def start():
        subprocess.run(command, check=True, capture_output=True)

    start()
    return Target("second process: start to the end of its first step", "s", 3.0, 1.5,
                  sample(start, 3).wall, "wall clock, whole corovec run of one step")


def _run_target(rounds=(), detail="full size with --output only", missed=False):
    return Target("the paper's whole L-plate run, 8x60, at the largest dt that keeps the answer",
                  "s", 60.0, 30.0, rounds, detail, missed)


def _whole_run(model, folder, progress):
    """The largest dt of ``CANDIDATES`` that keeps energy and path; the time of 80 s at it."""
    size = np.ptp(model.nodes, axis=0).max()
    node = node_at(model.nodes, load_case(CASE).points["S"].value)

    def path(dt):
        progress(f"{COMPARED_SECONDS:g} s with dt = {dt:g}")
        settings = Settings(dt=dt, end_time=COMPARED_SECONDS,
                            frame_every=round(FRAME_SECONDS / dt))
        output = folder / f"l-plate-480-{dt:g}.h5"
        result = simulate(model, settings, output=output, resume=True)
        energy = result.total_energy[unloaded_row(result.history, model.unloaded_at)]
        return energy, read(output)["displacement"][:, node]

    energy, reference = path(REFERENCE_DT)
    for dt in CANDIDATES:
        own, displacement = path(dt)
        change = abs(own / energy - 1.0)
        distance = np.linalg.norm(displacement - reference, axis=1).max() / size
        if change <= ENERGY_BOUND and distance <= PATH_BOUND:
            break
    else:
        return _run_target((), "no candidate step keeps the answer", missed=True)
    progress(f"{RUN_SECONDS:g} s with dt = {dt:g}")
    held = []
    time_ = sample(lambda: held.append(simulate(model, Settings(dt=dt, end_time=RUN_SECONDS))), 1)
    return _run_target(time_.cpu, f"dt = {dt:g}: energy {change:.1e}, path {distance:.1e}; "
                       f"energy drift {held[0].drift.energy:.1e} in {RUN_SECONDS:g} s")
