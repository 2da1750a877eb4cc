"""Command line ``corovec``: runs cases, summarises result files, lists cases.

Commands of the suites around the solver join through the entry-point group ``corovec.commands``, so
that nothing in this package imports them.
"""

import json
import math
import os
import sys
from importlib import metadata

import click

from .errors import InputError, ResultFileError, StepError

WRONG_INPUT = 2
FAILED = 1
INTERRUPTED = 130

WORRYING_DRIFT = 0.01
"""Relative energy drift in free flight from which a run with rho_inf = 1 is warned of."""


class _Commands(click.Group):
    """A group whose further commands come from installed entry points, loaded when called."""

    def list_commands(self, ctx):
        return sorted([*super().list_commands(ctx), *_entry_points()])

    def get_command(self, ctx, name):
        own = super().get_command(ctx, name)
        return own if own or name not in _entry_points() else _entry_points()[name].load()


def _entry_points():
    return {point.name: point for point in metadata.entry_points(group="corovec.commands")}


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="corovec")
def cli():
    """Free-flying, large-rotation shell dynamics that conserves energy and momenta.

    SI units throughout.

    \b
    Examples:
      corovec list
      corovec run l-plate --elements 120 --dt 1e-2 --end-time 20 --output run.h5
      corovec info run.h5
      corovec converge l-plate
    """


def main():
    """Entry point: errors of the user are one line on standard error and exit status 2."""
    try:
        cli.main(standalone_mode=False)
        if sys.stdout is not None:
            sys.stdout.flush()
    except (InputError, ResultFileError) as error:
        _fail(error, WRONG_INPUT)
    except StepError as error:
        _fail(error, FAILED)
    except click.exceptions.NoArgsIsHelpError as error:
        error.show()
        sys.exit(error.exit_code)
    except click.ClickException as error:
        _fail(error.format_message(), error.exit_code)
    except (click.Abort, KeyboardInterrupt):
        _fail("interrupted", INTERRUPTED)
    except BrokenPipeError:
        sys.exit(FAILED)
    except OSError as error:
        _fail(f"{error.filename or 'output'} cannot be written: {error.strerror}", FAILED)


def _fail(message, status):
    click.echo(f"corovec: error: {message}", err=True)
    sys.exit(status)


@cli.command()
@click.argument("case")
@click.option("--elements", type=int, help="Mesh, by its number of elements (see corovec list).")
@click.option("--dt", type=float, help="Time step [s].")
@click.option("--end-time", type=float, help="Simulated time [s], a multiple of dt.")
@click.option("--scheme", default="quasi", show_default=True,
              help="quasi (energy-momentum conserving) or newmark (trapezoidal rule, a baseline).")
@click.option("--rho-inf", default=1.0, show_default=True,
              help="Spectral radius at infinity, 0 to 1; 1 conserves.")
@click.option("--transformation", default="midpoint", show_default=True,
              help="T at the generalized midpoint, or the average of both ends.")
@click.option("--axes", default="nodal", show_default=True,
              help="Axes of the rotational variables: nodal (following), or global (the paper's).")
@click.option("--solver", default="auto", show_default=True, help="auto, skyline or dense.")
@click.option("--newton", default="modified", show_default=True,
              help="modified (a factorization serves many iterations) or full (the paper's).")
@click.option("--tolerance", default=1e-6, show_default=True,
              help="Work ratio at which an iteration ends (the paper's); see the README on Newton.")
@click.option("--membrane", default="stress", show_default=True,
              help="Assumed membrane field: stress, strain, or compatible (none).")
@click.option("--output", type=click.Path(dir_okay=False), help="Result file (HDF5, ParaView).")
@click.option("--frame-every", default=0, show_default=True,
              help="Steps between frames and checkpoints; 0: about 200 frames a run.")
@click.option("--overwrite", is_flag=True, help="Replace the result file if it exists.")
@click.option("--resume", is_flag=True, help="Continue the result file from its last checkpoint.")
@click.option("--json", "as_json", is_flag=True, help="Print the summary as one JSON object.")
def run(case, elements, dt, end_time, scheme, rho_inf, transformation, axes, solver, newton,
        tolerance, membrane, output, frame_every, overwrite, resume, as_json):
    """Simulate a benchmark CASE; options that are left out take the case's defaults.

    \b
    Examples:
      corovec run l-plate
      corovec run l-plate --elements 480 --dt 1e-3 --end-time 2 --output l480.h5
      corovec run l-plate --elements 480 --dt 1e-3 --end-time 2 --output l480.h5 --resume
      corovec run l-plate --elements 30 --solver skyline --json
    """
    from corovec.benchmarks import load_case

    from .compilation import warm_up
    from .dynamics.simulation import Settings, simulate
    from .results.files import writable_path
    if resume and overwrite:
        raise InputError("--resume and --overwrite exclude each other")
    if resume and output is None:
        raise InputError("--resume needs --output, the file to continue")
    if output is not None:
        output = str(writable_path(output, overwrite or resume))
    definition = load_case(case)
    settings = Settings(
        dt=definition.defaults.dt if dt is None else dt,
        end_time=definition.defaults.end_time if end_time is None else end_time,
        scheme=scheme, rho_inf=rho_inf, transformation=transformation, axes=axes,
        solver=solver, newton=newton, tolerance=tolerance, frame_every=frame_every)
    elements = definition.defaults.elements if elements is None else elements
    model = definition.model(elements, membrane=membrane)
    if not as_json:
        click.echo(f"{definition.title}: {elements} elements, {len(model.nodes)} nodes, "
                   f"{settings.n_steps} steps of {settings.dt:g} s")
        if resume and not os.path.exists(output):
            click.echo(f"{output} does not exist yet: a new run")
    compile_seconds = warm_up()
    with _Progress(settings.n_steps, model.unloaded_at) as progress:
        try:
            result = simulate(model, settings, output=output, overwrite=overwrite, resume=resume,
                              progress=progress, case=case)
        except KeyboardInterrupt:
            _fail(f"interrupted; {output} keeps everything up to its last checkpoint, --resume "
                  "continues it" if output else "interrupted", INTERRUPTED)
    summary = _summary(result.history, model.unloaded_at, result.supported)
    summary = {"case": case, "elements": elements, "nodes": len(model.nodes),
               "dt": settings.dt, "end_time": settings.end_time, "scheme": scheme,
               "rho_inf": rho_inf, "transformation": transformation, "axes": axes,
               "membrane": membrane, "solver": result.solver, "newton": newton,
               "tolerance": tolerance, **summary,
               "output": output,
               "seconds": {"assembly": result.seconds.assembly,
                           "factorization": result.seconds.factorization,
                           "solve": result.seconds.solve, "rest": result.seconds.rest,
                           "total": result.seconds.total, "compilation": compile_seconds}}
    _show(summary, as_json)
    if rho_inf == 1.0 and result.drift and result.drift.energy > WORRYING_DRIFT:
        click.echo(f"corovec: warning: the energy changed by {100 * result.drift.energy:.2g} % in "
                   "free flight: take a smaller dt, or a smaller tolerance", err=True)


@cli.command()
@click.argument("file", type=click.Path(dir_okay=False))
@click.option("--json", "as_json", is_flag=True, help="Print the summary as one JSON object.")
def info(file, as_json):
    """Summarise a result FILE of dynamics or statics, finished or not.

    \b
    Example:
      corovec info run.h5
    """
    from .results.reading import read
    contents = read(file)
    description, history = contents["description"], contents["history"]
    if "factor" in history.dtype.names:
        outcome = _static_summary(history)
    else:
        outcome = _summary(history, description["unloaded_at"], description["supported"])
    open_end = description["settings"].get("method") == "arc length"
    summary = {
        "case": description["case"] or "own model",
        **{key: description[key] for key in ("elements", "nodes", "membrane", "shear")},
        **description["settings"], "solver": description["solver"], "steps": contents["step"],
        "steps_planned": None if open_end else contents["n_steps"],
        "frames": len(contents["displacement"]), **outcome,
        "versions": description["versions"], "machine": description["machine"]}
    _show(summary, as_json)


@cli.command("list")
@click.option("--json", "as_json", is_flag=True, help="Print as one JSON object.")
def list_cases(as_json):
    """Show the cases, their meshes, and where every parameter comes from.

    \b
    Example:
      corovec list
    """
    from corovec.benchmarks import case_names, load_case
    cases = [load_case(name) for name in case_names()]
    if as_json:
        columns = ("parameter", "value", "unit", "provenance", "source")
        click.echo(json.dumps({case.name: {
            "title": case.title, "meshes": case.sizes,
            "provenance": [dict(zip(columns, row, strict=True)) for row in case.provenance()]}
            for case in cases}, indent=2))
        return
    for case in cases:
        click.echo(f"{case.name}: {case.title}")
        click.echo(f"  meshes (elements): {', '.join(map(str, case.sizes))}")
        click.echo(f"  defaults: {case.defaults.elements} elements, dt {case.defaults.dt:g} s, "
                   f"end time {case.defaults.end_time:g} s")
        for parameter, value, unit, provenance, source in case.provenance():
            text = f"{value:g}" if isinstance(value, float) else str(value)
            click.echo(f"  {parameter:<14} {text} {unit}".rstrip() + f"  [{provenance}] {source}")


class _Progress:
    """Progress bar: steps, simulated time, energy drift so far; silent when not a terminal."""

    def __init__(self, n_steps, unloaded_at):
        from tqdm import tqdm
        self._bar = tqdm(total=n_steps, unit="step", disable=None, file=sys.stderr)
        self._unloaded_at = unloaded_at
        self._reference = None
        self._largest = 0.0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._bar.close()

    def __call__(self, step, n_steps, row):
        if self._bar.disable:
            return
        energy = row["kinetic_energy"] + row["strain_energy"]
        if row["time"] >= self._unloaded_at * (1.0 - 1e-12):
            self._reference = energy if self._reference is None else self._reference
            if self._reference > 0.0:
                change = abs(energy / self._reference - 1.0)
                self._largest = max(self._largest, change)
        drift = f", drift {self._largest:.1e}" if self._reference is not None else ""
        self._bar.set_postfix_str(f"t = {row['time']:.4g} s{drift}", refresh=False)
        self._bar.update(step - self._bar.n)


def _summary(history, unloaded_at, supported):
    """What both ``run`` and ``info`` say of a history."""
    from .dynamics.simulation import drift
    last, changes = history[-1], drift(history, unloaded_at, supported)
    iterations = history["iterations"][1:]
    return {
        "time": float(last["time"]),
        "kinetic_energy": float(last["kinetic_energy"]),
        "strain_energy": float(last["strain_energy"]),
        "total_energy": float(last["kinetic_energy"] + last["strain_energy"]),
        "external_work": float(last["external_work"]),
        "linear_momentum": last["linear_momentum"].tolist(),
        "angular_momentum": last["angular_momentum"].tolist(),
        "unloaded_at": None if math.isinf(unloaded_at) else unloaded_at,
        "drift_since_unloading": None if changes is None else vars(changes),
        "iterations_per_step": float(iterations.mean()) if len(iterations) else 0.0,
        "switches": int(history["switches"].sum()),
        "halvings": int(history["halvings"].sum()),
        "indefinite_tangents": _indefinite(history)}


def _static_summary(history):
    """What ``info`` says of a static path."""
    last = history[-1]
    return {
        "factor": float(last["factor"]), "largest_factor": float(history["factor"].max()),
        "strain_energy": float(last["strain_energy"]), "reaction": last["reaction"].tolist(),
        "iterations": int(history["iterations"].sum()), "load_steps": int(history["steps"].sum()),
        "indefinite_tangents": _indefinite(history)}


def _indefinite(history):
    """Tangents with negative pivots; None where the solver does not tell."""
    return None if history["indefinite"].min() < 0 else int(history["indefinite"].sum())


UNITS = {"dt": "s", "length": "m", "reaction": "N", "end_time": "s", "time": "s",
         "kinetic_energy": "J", "strain_energy": "J", "total_energy": "J", "external_work": "J",
         "linear_momentum": "kg m/s", "angular_momentum": "kg m^2/s", "unloaded_at": "s",
         "seconds": "s"}


def _show(summary, as_json):
    if as_json:
        click.echo(json.dumps(summary))
        return
    for key, value in summary.items():
        if value is None:
            continue
        if isinstance(value, dict):
            text = ", ".join(f"{k.replace('_', ' ')} {_number(v)}" for k, v in value.items())
        else:
            text = _number(value)
        click.echo(f"  {key.replace('_', ' '):<22} {text} {UNITS.get(key, '')}".rstrip())


def _number(value):
    if value is None:
        return "not defined"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list):
        return "(" + ", ".join(f"{v:.6g}" for v in value) + ")"
    return str(value)
