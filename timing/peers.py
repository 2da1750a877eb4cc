"""The L-plate by other open codes, beside ours, see ``corovec peers`` (``tox -e peers``).

Kratos (ShellThickElementCorotational3D4N) and CalculiX (S4, the ``ccx`` program) run the same
meshes, loads and time steps, each in a process of its own with one thread.  What is not installed
is reported as missing.  Energies are those codes' own: CalculiX prints them; for Kratos the kinetic
energy is that of its mass matrices and the strain energy that of its nodal forces and stiffness.
"""

import contextlib
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from importlib import metadata
from pathlib import Path

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation

from corovec import Newton, Settings, simulate, warm_up
from corovec.benchmarks import load_case
from corovec.solver.errors import StepError
from corovec.solver.runtime.execution import isolated
from corovec.solver.system.numbering import node_pairs

CASE = "l-plate"
SAMPLES = 200
"""Instants at which energy and momenta of the other codes are taken, at most."""

SIZES = {"quick": ((30,), (0.01, 0.02, 0.05), 2.0),
         "full": ((30, 120, 480, 1920, 7680), (0.01, 0.02, 0.05), 20.0)}
"""Meshes, time steps [s] and simulated time [s]."""

STEPS = {1920: 40, 7680: 20}
"""Steps of large meshes, at most, with the first time step alone: minutes of the slowest code.
Such runs end before the plate is free, so that of energies nothing is told."""

ENVIRONMENT = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1",
               "CCX_NPROC_EQUATION_SOLVER": "1"}

MAX_ITERATIONS = 20


def run_ours(elements, dt, end_time, solver):
    """One of our runs: ``skyline`` (the paper's, full Newton) or ``auto`` (production).  CPU time
    is less that of a run of one step, as that of CalculiX."""
    warm_up()
    model, reached = load_case(CASE).model(elements), [0.0]

    def keep(step, n_steps, row):
        reached[0] = float(row["time"])

    def run(until):
        cpu, wall = time.process_time(), time.perf_counter()
        settings = Settings(dt=dt, end_time=until, solver=solver,
                            newton=Newton("modified" if solver == "auto" else "full"))
        result = simulate(model, settings, progress=keep)
        return time.process_time() - cpu, time.perf_counter() - wall, result

    base = run(dt)[0]
    try:
        cpu, wall, result = run(end_time)
    except StepError:
        return {"survived": False, "reached": reached[0]}
    cpu = max(cpu - base, 0.0)
    history = result.history
    samples = [(row["time"], row["kinetic_energy"], row["strain_energy"], row["linear_momentum"],
                row["angular_momentum"]) for row in history]
    return {**_summary(end_time, history["iterations"][1:].tolist(), cpu, wall, samples, model),
            "halvings": int(history["halvings"].sum())}


def run_kratos(elements, dt, end_time, damping):
    """A run of Kratos: Bossak with the ``damping`` factor alpha_m (0: Newmark's average
    acceleration), the fastest direct solver that Kratos finds, convergence to 1e-6."""
    os.environ.update(ENVIRONMENT)
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # its banners
    import KratosMultiphysics as Kratos
    import KratosMultiphysics.StructuralMechanicsApplication as Structural
    from KratosMultiphysics.StructuralMechanicsApplication import (
        structural_mechanics_implicit_dynamic_solver as implicit,
    )
    Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
    Kratos.ParallelUtilities.SetNumThreads(1)
    model = load_case(CASE).model(elements)
    solver = implicit.ImplicitMechanicalSolver(Kratos.Model(), Kratos.Parameters(json.dumps({
        "model_part_name": "plate", "domain_size": 3, "scheme_type": "bossak",
        "damp_factor_m": damping, "rotation_dofs": True, "compute_reactions": False,
        "model_import_settings": {"input_type": "use_input_model_part"},
        "time_stepping": {"time_step": dt}, "max_iteration": MAX_ITERATIONS,
        "convergence_criterion": "residual_criterion",
        "residual_relative_tolerance": 1e-6, "residual_absolute_tolerance": 1e-9})))
    solver.AddVariables()
    part = solver.main_model_part
    properties = part.CreateNewProperties(1)
    for variable, value in ((Kratos.DENSITY, model.density), (Kratos.THICKNESS, model.thickness),
                            (Kratos.YOUNG_MODULUS, model.youngs),
                            (Kratos.POISSON_RATIO, model.poisson)):
        properties.SetValue(variable, float(value[0]))
    # the name of the shell's law since Kratos 10; before, the plane-stress law of its material
    law = getattr(Structural, "ReissnerMindlinShellElasticConstitutiveLaw",
                  Structural.LinearElasticPlaneStress2DLaw)
    properties.SetValue(Kratos.CONSTITUTIVE_LAW, law())
    for i, x in enumerate(model.nodes.tolist(), 1):
        part.CreateNewNode(i, *x)
    for e, quad in enumerate(model.quads.tolist(), 1):
        part.CreateNewElement("ShellThickElementCorotational3D4N", e, [i + 1 for i in quad],
                              properties)
    for k, force in enumerate(model.loads, 1):
        part.CreateNewCondition("PointLoadCondition3D1N", k, [int(force.node) + 1], properties)
    solver.ImportModelPart()
    solver.PrepareModelPart()
    solver.AddDofs()
    solver.Initialize()
    solver.Check()
    free = model.unloaded_at * (1.0 - 1e-12)
    flexibilities = _kratos_flexibilities(Kratos, part) if end_time >= free else None
    samples, iterations, now, cpu, wall = [], [], 0.0, 0.0, 0.0
    n_steps = round(end_time / dt)
    for step in range(1, n_steps + 1):
        start, clock = time.process_time(), time.perf_counter()
        now = solver.AdvanceInTime(now)
        for force in model.loads:
            value = force.history(now) * np.asarray(force.force)
            part.GetNode(int(force.node) + 1).SetSolutionStepValue(
                Structural.POINT_LOAD, 0, value.tolist())
        solver.InitializeSolutionStep()
        solver.Predict()
        converged = solver.SolveSolutionStep()
        solver.FinalizeSolutionStep()
        cpu += time.process_time() - start
        wall += time.perf_counter() - clock
        iterations.append(part.ProcessInfo[Kratos.NL_ITERATION_NUMBER])
        if not converged:
            return _summary((step - 1) * dt, iterations, cpu, wall, samples, model, False)
        due = step % max(1, n_steps // SAMPLES) == 0 or step == n_steps
        if due and step * dt >= free:
            samples.append((step * dt, *_kratos_energies(Kratos, part, flexibilities)))
            if not np.isfinite(samples[-1][1]):
                return _summary((step - 1) * dt, iterations, cpu, wall, samples[:-1], model, False)
    return _summary(end_time, iterations, cpu, wall, samples, model)


def _kratos_flexibilities(Kratos, part):
    """(initial corners (4, 3), pseudo-inverse of the stiffness (24, 24)) of each element."""
    K, f, found = Kratos.Matrix(), Kratos.Vector(), []
    for element in part.Elements:
        element.CalculateLocalSystem(K, f, part.ProcessInfo)
        stiffness = np.array(K)
        found.append((_corners(element), np.linalg.pinv(0.5 * (stiffness + stiffness.T), 1e-10,
                                                        hermitian=True)))
    return found


def _kratos_energies(Kratos, part, flexibilities):
    """(kinetic energy, strain energy, linear momentum, angular momentum).

    The element offers no strain energy; a co-rotational one that is linear in its own frame has
    the complementary energy f . K^+ f / 2 of its nodal forces, turned back to where it started
    from (exact but for the strains, about 1e-3 of this energy).
    """
    M, R, velocities, info = Kratos.Matrix(), Kratos.Vector(), Kratos.Vector(), part.ProcessInfo
    kinetic, strain, L, J = 0.0, 0.0, np.zeros(3), np.zeros(3)
    for element, (initial, flexibility) in zip(part.Elements, flexibilities):
        element.CalculateMassMatrix(M, info)
        element.GetFirstDerivativesVector(velocities, 0)
        v = np.array(velocities)
        momentum = np.array(M) @ v
        kinetic += 0.5 * v @ momentum
        force, couple = np.split(momentum.reshape(4, 6), 2, axis=1)
        x = _corners(element)
        L += force.sum(axis=0)
        J += np.cross(x, force).sum(axis=0) + couple.sum(axis=0)
        element.CalculateRightHandSide(R, info)
        turn, _ = Rotation.align_vectors(initial - initial.mean(axis=0), x - x.mean(axis=0))
        f = turn.apply(np.array(R).reshape(8, 3)).ravel()
        strain += 0.5 * f @ flexibility @ f
    return kinetic, strain, L, J


def _corners(element):
    return np.array([[node.X, node.Y, node.Z] for node in element.GetNodes()])


def run_calculix(elements, dt, end_time, alpha):
    """A run of CalculiX: S4, HHT with ``alpha`` (its default is -0.05; 0: the trapezoidal rule),
    fixed steps, SPOOLES.  CPU time is the program's, less that of a run of one step."""
    with tempfile.TemporaryDirectory() as folder:
        base = _calculix(Path(folder, "one"), elements, dt, dt, alpha)[0]
        cpu, wall, job = _calculix(Path(folder, "plate"), elements, dt, end_time, alpha)
        model = load_case(CASE).model(elements)
        rows = [line.split() for line in job.with_suffix(".sta").read_text().splitlines()]
        rows = [row for row in rows if len(row) >= 5 and row[0].isdigit()]
        iterations = [int(row[3]) for row in rows]
        reached = float(rows[-1][4]) if rows else 0.0
        samples = _calculix_samples(job.with_suffix(".dat").read_text(), model, dt)
    cpu = max(cpu - base, 0.0)
    return _summary(reached, iterations, cpu, wall, samples, model,
                    reached > end_time - 0.5 * dt)


def _calculix(job, elements, dt, end_time, alpha):
    """(CPU seconds, wall-clock seconds, job) of one run of ccx."""
    import resource  # POSIX only
    job.with_suffix(".inp").write_text(calculix_input(elements, dt, end_time, alpha))
    before, clock = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    with open(job.with_suffix(".log"), "w") as log:
        done = subprocess.run(["ccx", job.name], cwd=job.parent, stdout=log, stderr=log,
                              check=False, env={**os.environ, **ENVIRONMENT})
    if not job.with_suffix(".sta").exists():
        said = job.with_suffix(".log").read_text(errors="replace").split()
        raise OSError(f"ccx ended with status {done.returncode}: {' '.join(said[-20:])}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return cpu, time.perf_counter() - clock, job


def calculix_input(elements, dt, end_time, alpha):
    """Input deck of the L-plate for CalculiX."""
    model = load_case(CASE).model(elements)
    pulse = model.loads[0].history
    lines = ["*NODE, NSET=NALL"]
    lines += [f"{i}, {x:.12g}, {y:.12g}, {z:.12g}" for i, (x, y, z) in enumerate(model.nodes, 1)]
    lines.append("*ELEMENT, TYPE=S4, ELSET=EALL")
    lines += [f"{e}, " + ", ".join(str(i + 1) for i in quad)
              for e, quad in enumerate(model.quads, 1)]
    lines += ["*MATERIAL, NAME=M", "*ELASTIC", f"{model.youngs[0]:g}, {model.poisson[0]:g}",
              "*DENSITY", f"{model.density[0]:g}", "*SHELL SECTION, ELSET=EALL, MATERIAL=M",
              f"{model.thickness[0]:g}", "*AMPLITUDE, NAME=PULSE",
              *(f"{t:g}, {value:g}" for t, value in zip(pulse.times, pulse.values)),
              f"{2.0 * end_time + pulse.times[-1]:g}, 0",
              f"*STEP, NLGEOM, INC={round(end_time / dt) + 10}",
              f"*DYNAMIC, DIRECT, ALPHA={alpha:g}", f"{dt:g}, {end_time:g}",
              "*CLOAD, AMPLITUDE=PULSE"]
    lines += [f"{force.node + 1}, {c + 1}, {value:g}" for force in model.loads
              for c, value in enumerate(force.force) if value != 0.0]
    lines += ["*NODE PRINT, NSET=NALL", "U", "*EL PRINT, ELSET=EALL, TOTALS=ONLY", "ELSE, ELKE",
              "*END STEP"]
    return "\n".join(lines) + "\n"


def _calculix_samples(text, model, dt):
    """Samples of a .dat file at about ``SAMPLES`` instants.

    Velocities that CalculiX prints for the nodes of a shell are not those of its mid-surface, so
    momenta are taken half a step earlier, from two displacements and our mass of the translations
    (rotary inertia left out, (h / length)^2 = 1e-4 of the angular momentum).
    """
    blocks, current = {}, None
    for line in text.splitlines():
        if "time" in line:
            kind = next((name for name in ("displacements", "internal energy", "kinetic energy")
                         if name in line), None)
            step = round(float(line.split()[-1]) / dt)
            current = blocks.setdefault(step, {}).setdefault(kind, [])
        elif line.strip():
            current.append(line)
    rows, columns = node_pairs((model.quads,))
    mass = csr_array((model.elements.mass.ravel(), (rows, columns)), shape=2 * (len(model.nodes),))

    def displacement(step):
        return np.array([line.split()[1:] for line in blocks[step]["displacements"]], dtype=float)

    samples = []
    for step in range(2, max(blocks, default=0) + 1, max(1, max(blocks, default=0) // SAMPLES)):
        u, before = displacement(step), displacement(step - 1)
        momentum = mass @ (u - before) / dt
        energy = [float(blocks[step][name][0].split()[-1])
                  for name in ("kinetic energy", "internal energy")]
        samples.append((step * dt, *energy, momentum.sum(axis=0),
                        np.cross(model.nodes + 0.5 * (u + before), momentum).sum(axis=0)))
    return samples


def _summary(reached, iterations, cpu, wall, samples, model, survived=True):
    """Drifts since unloading: energy relative to itself, momenta to their own size."""
    row = {"survived": survived, "reached": reached, "steps": len(iterations),
           "cpu_ms_per_step": 1e3 * cpu / max(len(iterations), 1),
           "wall_ms_per_step": 1e3 * wall / max(len(iterations), 1),
           "iterations_per_step": float(np.mean(iterations)) if iterations else None}
    free = [sample for sample in samples if sample[0] >= model.unloaded_at * (1.0 - 1e-12)]
    if len(free) < 2:
        return row  # ended before or soon after unloading
    energy = np.array([kinetic + strain for _, kinetic, strain, _, _ in free])

    def drift(k):
        values = np.array([sample[k] for sample in free])
        return float(np.abs(values - values[0]).max() / np.linalg.norm(values[0]))

    return {**row, "energy": float(energy[0]),
            "energy_drift": float(np.abs(energy / energy[0] - 1.0).max()),
            "energy_change": float(energy[-1] / energy[0] - 1.0),
            "linear_momentum_drift": drift(3), "angular_momentum_drift": drift(4)}


def programs():
    """``{name: (run, argument, version, settings)}``; the version is None where it is missing."""
    kratos = _kratos_version()
    ccx = _calculix_version()
    ours = metadata.version("corovec")
    return {
        "corovec quasi": (run_ours, "skyline", ours, "paper: skyline LDL^T, full Newton"),
        "corovec production": (run_ours, "auto", ours, "production default"),
        "Kratos Bossak": (run_kratos, -0.3, kratos, "ShellThickElementCorotational3D4N, Bossak "
                          "-0.3 (its default), fastest direct solver found"),
        "Kratos Newmark": (run_kratos, 0.0, kratos, "ShellThickElementCorotational3D4N, average "
                           "acceleration, fastest direct solver found"),
        "CalculiX HHT": (run_calculix, -0.05, ccx, "S4, HHT -0.05 (its default), SPOOLES"),
        "CalculiX trapezoidal": (run_calculix, 0.0, ccx, "S4, HHT 0, SPOOLES")}


def plan(meshes, dts, end_time):
    """``(elements, dt, end_time)`` of all runs: of large meshes short ones, see ``STEPS``."""
    return [(elements, dt, min(end_time, STEPS[elements] * dt) if elements in STEPS else end_time)
            for elements in meshes for dt in (dts[:1] if elements in STEPS else dts)]


def compare(runs, write=lambda rows: None):
    """Rows of all programs and ``runs``, of ``plan``; ``write(rows)`` is called after each."""
    rows = []
    for elements, dt, end_time in runs:
        for name, (run, argument, version, settings) in programs().items():
            row = {"program": name, "version": version, "settings": settings,
                   "elements": elements, "dt": dt, "end_time": end_time}
            rows.append({**row, **(_isolated(run, elements, dt, end_time, argument)
                                   if version is not None else {"missing": True})})
            write(rows)
    return rows


def speedups(rows):
    """How many times faster our production step is than that of the fastest other code that
    survived, by mesh and dt."""
    result = []
    for elements, dt in dict.fromkeys((row["elements"], row["dt"]) for row in rows):
        timed = {row["program"]: row["cpu_ms_per_step"] for row in rows
                 if (row["elements"], row["dt"]) == (elements, dt)
                 and row.get("survived") and row["cpu_ms_per_step"] > 0.0}
        ours = timed.get("corovec production")
        peers = {name: ms for name, ms in timed.items() if not name.startswith("corovec")}
        if ours and peers:
            fastest = min(peers, key=peers.get)
            result.append({"elements": elements, "dt": dt, "fastest": fastest,
                           "factor": peers[fastest] / ours, "target": 30.0, "goal": 50.0})
    return result


def _isolated(run, *arguments):
    """The row of ``run(*arguments)`` in a process of its own, or the error that ended it."""
    try:
        return isolated(run, *arguments)
    except Exception as error:
        return {"survived": False, "error": f"{type(error).__name__}: {error}"[:300]}


def _kratos_version():
    found = importlib.util.find_spec("KratosMultiphysics") is not None
    with contextlib.suppress(metadata.PackageNotFoundError):
        return metadata.version("KratosStructuralMechanicsApplication") if found else None
    return None


def _calculix_version():
    """Version of the program; None where there is none that runs."""
    if shutil.which("ccx") is None:
        return None
    try:
        said = subprocess.run(["ccx", "-v"], text=True, capture_output=True, check=False)
    except OSError:
        return None
    return said.stdout.split()[-1] if said.stdout.split() else "unknown"


def line(row):
    head = f"{row['program']:<22} {row['elements']:>4} elements, dt = {row['dt']:<5g} "
    if row.get("missing"):
        return head + "missing"
    if "cpu_ms_per_step" not in row:
        return head + f"failed: {row.get('error', row.get('reached'))}"
    def number(key, form):
        return "-" if row.get(key) is None else format(row[key], form)

    return head + (f"{row['cpu_ms_per_step']:8.2f} ms, {number('iterations_per_step', '.2f')} it, "
                   f"energy {number('energy_drift', '.1e')}, momenta "
                   f"{number('linear_momentum_drift', '.1e')} "
                   f"{number('angular_momentum_drift', '.1e')}, "
                   + ("survived" if row["survived"] else f"ended at {row['reached']:.3g} s"))
