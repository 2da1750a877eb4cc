"""Command line ``corovec``: runs models, summarises result files.

Commands of the suites around the solver join through the entry-point group ``corovec.commands``, so
that nothing in this package imports them.
"""

import json
import math
import os
import re
import sys
import warnings
from contextlib import contextmanager, nullcontext
from dataclasses import MISSING, asdict, fields, is_dataclass
from importlib import metadata

import click

from .errors import InputError, ResultFileError, StepError
from .fields import called
from .names import printable

WRONG_INPUT = 2
FAILED = 1
INTERRUPTED = 130


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
    """Entry point: errors of the user are one line on standard error and exit status 2, warnings
    one line."""
    warnings.formatwarning = lambda message, *_: f"corovec: warning: {message}\n"
    try:
        cli.main(standalone_mode=False)
        if sys.stdout is not None:
            sys.stdout.flush()
    except (InputError, ResultFileError) as error:
        words = re.sub(r"(?<=[;,] )(?=overwrite replaces|resume continues)", "--", str(error))
        _fail(words, WRONG_INPUT)
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
    except MemoryError as error:
        _fail(f"not enough memory: {str(error) or 'none is left'}", FAILED)
    except OSError as error:
        _fail(f"{error.filename or 'output'} cannot be written: {error.strerror}", FAILED)


@contextmanager
def _in_other_words(words):
    """Errors that speak of an argument in Python, as ``rho_inf``, in the ``words`` of who gave it:
    an option, or a place in a model file."""
    try:
        yield
    except InputError as error:
        names = "|".join(words)
        raise InputError(re.sub(rf"(?<![\w'.-])({names})(?![\w'.])",
                                lambda found: words[found[0]], str(error))) from None


def _option(name):
    return "--" + name.replace("_", "-")


def _fail(message, status):
    click.echo(f"corovec: error: {printable(message)}", err=True)
    sys.exit(status)


class _Run(click.Command):
    """A command whose options of settings are the fields of ``Settings``, read when it is called:
    they need libraries that take time to load."""

    def get_params(self, ctx):
        own = super().get_params(ctx)
        return [*own[:3], *_settings_options(), *own[3:]]


@cli.command(cls=_Run)
@click.argument("model")
@click.option("--elements", type=int, help="Mesh, by its number of elements (see corovec list).")
@click.option("--membrane", default="stress", show_default=True,
              help="Assumed membrane field: stress, strain, or compatible (none).")
@click.option("-o", "--output", type=click.Path(dir_okay=False),
              help="Result file (HDF5, ParaView).")
@click.option("--overwrite", is_flag=True, help="Replace the result file if it exists.")
@click.option("--resume", is_flag=True, help="Continue the result file from its last checkpoint.")
@click.option("--threads", type=int, default=1, show_default=True,
              help="Threads that assemble and, with RSLAB, solve; results do not depend on it.")
@click.option("--json", "as_json", is_flag=True, help="Print the summary as one JSON object.")
def run(model, elements, membrane, output, overwrite, resume, threads, as_json, **options):
    """Simulate a MODEL: the path of a .toml file, or the name of a benchmark.

    Options that are left out take the defaults of the model's file, or those shown.

    \b
    Examples:
      corovec run l-plate
      corovec run shell.toml --output shell.h5
      corovec run l-plate --elements 480 --dt 1e-3 --end-time 2 --output l480.h5
      corovec run l-plate --elements 480 --dt 1e-3 --end-time 2 --output l480.h5 --resume
      corovec run l-plate --elements 30 --solver skyline --json
      corovec run shell.toml --scheme exact --dissipation 0.1 --error 1e-5 --output shell.h5
    """
    from .checks import count
    from .compilation import warm_up
    from .dynamics.settings import taking_part
    from .input.files import find_model, read_model
    from .input.running import ReadySteps
    from .model.mechanism import summary
    from .results.files import RUN, writable_path
    from .runtime.provenance import body
    if resume and overwrite:
        raise InputError("--resume and --overwrite exclude each other")
    if resume and output is None:
        raise InputError("--resume needs --output, the file to continue")
    with _in_other_words({"threads": "--threads"}):
        threads = count("threads", threads)
    if output is not None:
        output = writable_path(output, overwrite or resume, RUN)
    path = find_model(model)
    definition = read_model(path)
    case = printable(os.path.basename(model))  # of a benchmark its name
    words, settings = _words(options, path), None
    if definition.dynamic is None:
        _refuse_settings(path)
    else:
        options["stresses"] = options["stresses"] or definition.output.stresses
        options["frame_every"] = options["frame_every"] or definition.output.frame_every
        for name in ("scheme", "dissipation", "dissipates", "rho_inf", "order", "error"):
            if not _given(name):
                options[name] = getattr(definition.dynamic, name)
                words[name] = f"{name} of {path}"
        settings = _settings(options, definition.dynamic, words)
    with _in_other_words({**words, "membrane": "--membrane"}), _in_file(path):
        steps = ReadySteps(definition, elements, settings, membrane)
    shell = steps.dynamic or steps.static
    if settings and not as_json:
        click.echo(f"{definition.heading}: {steps.elements} elements, {len(shell.nodes)} nodes, "
                   f"{settings.n_steps} steps of {settings.dt:g} s")
        if resume and not os.path.exists(output):
            click.echo(f"{printable(str(output))} does not exist yet: a new run")
    compile_seconds = warm_up(exact=bool(settings and settings.scheme.exact))
    with _Progress(settings.n_steps, shell.unloaded_at) if settings else nullcontext() as progress:
        try:
            with _in_other_words(words):
                static, result = steps.run(output, overwrite, resume, progress, case,
                                           threads)
        except KeyboardInterrupt:
            _fail(f"interrupted; {output} keeps everything up to its last checkpoint, --resume "
                  "continues it" if output else "interrupted", INTERRUPTED)
    of_static = static and _of_static(static, shell, steps.static_output(output))
    if result is None:
        return show({"case": case, **of_static}, as_json)
    seconds = {name: getattr(result.seconds, name) for name in
               ("assembly", "factorization", "solve", "rest", "total")}
    show({"case": case, **({"static": of_static} if static else {}), "elements": steps.elements,
          "nodes": len(shell.nodes), "membrane": membrane,
          "edges": shell.folds._asdict(), "body": body(shell), **summary(shell.mechanism),
          **taking_part(asdict(settings)),
          "solver": result.solver,
          **_summary(result.history, shell.unloaded_at, result.supported),
          "output": output and str(output), "memory": result.memory,
          "seconds": {**seconds, "compilation": compile_seconds}}, as_json)


def _given(name):
    """Whether an option stands in the command line."""
    source = click.get_current_context().get_parameter_source(name)
    return source is click.core.ParameterSource.COMMANDLINE


def _refuse_settings(path):
    """Raise ``InputError`` for options of a motion beside a file that has none."""
    from .dynamics.settings import Settings
    for option in (option for field in fields(Settings) for option in _options(field)):
        if _given(option.name):
            raise InputError(f"{option.opts[0]} is of a motion, {path} has a static step only")


def _of_static(result, shell, output):
    """What ``run`` says of a static step."""
    import numpy as np

    from .model.mechanism import summary
    largest = np.linalg.norm(result.displacement[-1], axis=1)
    return {
        "elements": len(shell.quads), "nodes": len(shell.nodes), **summary(shell.mechanism),
        "load_factor": 1.0,
        "strain_energy": float(result.strain_energy[-1]),
        "largest_displacement": float(largest.max()), "at_node": int(largest.argmax()),
        "reaction": result.reaction[-1].tolist(),
        "reaction_moment": result.reaction_moment[-1].tolist(),
        "balance": result.balance._asdict(),
        "iterations": int(result.iterations.sum()), "memory": result.memory,
        "output": output and str(output)}


def _settings_options():
    """Options for the fields of ``Settings``, and of the settings in it."""
    from .dynamics.settings import Settings
    return [option for field in fields(Settings) for option in _options(field)]


def _options(field):
    if is_dataclass(field.type):
        return [option for inner in fields(field.type) for option in _options(inner)]
    about = field.metadata
    choices = f"  One of: {', '.join(about['choices'])}." if about["choices"] else ""
    unit = f" [{about['unit']}]" if about["unit"] else ""
    given = field.default is not MISSING
    rest = "" if given else "  Default: the model file's."
    return [click.Option([_option(called(field))], type=field.type, is_flag=field.type is bool,
                         default=field.default if given else None,
                         show_default=given and field.type is not bool,
                         help=f"{about['help'].removesuffix('.')}{unit}.{choices}{rest}")]


@contextmanager
def _in_file(path):
    """Errors of what stands in a model file with its path."""
    try:
        yield
    except InputError as error:
        text = str(error)
        raise InputError(f"{path}: {text}" if text.startswith("loads[") else text) from None


def _words(options, path):
    """``{name of a setting: what it is called where it was given}``."""
    from .dynamics.settings import Settings
    own = [field for field in fields(Settings) if not is_dataclass(field.type)]
    return {field.name: _option(called(field)) if options[called(field)] is not None else
            f"defaults.{field.name} of {path}" for field in own}


def _settings(options, defaults, words):
    """``Settings`` of the options of a command; those without a value are of ``defaults``.

    ``words``: what those of ``Settings`` itself, and others that are no options, are called in
    errors.
    """
    from .dynamics.settings import Settings

    def made(kind):
        values = {field.name: made(field.type) if is_dataclass(field.type) else value(field)
                  for field in fields(kind)}
        called_here = words if kind is Settings else {
            field.name: words.get(field.name, _option(called(field))) for field in fields(kind)}
        with _in_other_words(called_here):
            return kind(**values)

    def value(field):
        option = options[called(field)]
        return getattr(defaults, field.name) if option is None else option

    return made(Settings)


@cli.command()
@click.argument("file", type=click.Path(dir_okay=False))
@click.option("--energy", is_flag=True,
              help="Also the energies of the last step by shell, body, joint, spring, loads.")
@click.option("--csv", type=click.Path(dir_okay=False),
              help="Write these energies of all steps, of a static path its rows, to a file.")
@click.option("--overwrite", is_flag=True, help="Replace that file if it exists.")
@click.option("--json", "as_json", is_flag=True, help="Print the summary as one JSON object.")
def info(file, energy, csv, overwrite, as_json):
    """Summarise a result FILE of dynamics or statics, finished or not.

    \b
    Examples:
      corovec info run.h5
      corovec info run.h5 --energy --csv energies.csv
      corovec info path.h5 --csv path.csv
    """
    from .dynamics.settings import taking_part
    from .model.mechanism import summary as joined
    from .results.frame import data_frame
    from .results.layout import is_static
    from .results.reading import read
    contents = read(file)
    description, history = contents["description"], contents["history"]
    static = is_static(history.dtype)
    if static:
        settings, outcome = description["settings"], _static_summary(history)
    else:
        settings = taking_part(description["settings"])
        outcome = _summary(history, description["unloaded_at"], description["supported"])
    open_end = settings.get("method") == "arc length"
    summary = {
        "case": description["case"] or "own model",
        **{key: description[key] for key in ("elements", "nodes", "membrane", "shear")},
        "edges": description["edges"], "body": description["body"], **joined(description),
        **settings, "solver": description["solver"], "steps": contents["step"],
        "steps_planned": None if open_end else contents["n_steps"],
        "frames": len(contents["displacement"]), **outcome, "memory": contents["memory"],
        "versions": description["versions"], "machine": description["machine"]}
    table = None
    if static and energy:
        raise InputError(f"{printable(file)} is a static path, which has no energies by item")
    if static and csv:
        _write_table(data_frame(history), csv, overwrite)
    elif energy or csv:
        table = _energies(contents, csv, overwrite)
    if energy and as_json:
        summary["energies"] = table.to_dict("records")
    show(summary, as_json)
    if energy and not as_json:
        _show_energies(table, history)


def _energies(contents, csv, overwrite):
    """Energies of a run by item in its last step, those of all steps in a file ``csv``."""
    from .dynamics.energies import energy_table
    if csv:
        _write_table(energy_table(contents), csv, overwrite)
    return energy_table(contents, -1)


def _write_table(table, csv, overwrite):
    """Write a DataFrame to a file."""
    from .results.files import replacing, writable_path
    with replacing(writable_path(csv, overwrite)) as partial:
        table.to_csv(partial, index=False)


def _show_energies(table, history):
    """Print the table, the sum of it, and what is left over of that at the start."""
    from .dynamics.energies import COLUMNS
    from .dynamics.result import gained
    rows = [(f"{row['item']} ({row['kind']})" if row["kind"] != row["item"] else row["item"],
             [row[name] for name in COLUMNS]) for row in table.to_dict("records")]
    rows.append(("sum", table[list(COLUMNS)].sum().tolist()))
    width = max(22, *(len(item) for item, _ in rows))
    click.echo(f"  {'energies [J]':<{width}}" + "".join(f"{name:>14}" for name in COLUMNS))
    for item, values in rows:
        click.echo(f"    {printable(item):<{width - 2}}" + "".join(f"{v:14.6g}" for v in values))
    click.echo(f"  {'left over':<{width}}{gained(history)[0][-1]:14.6g}")


class _Progress:
    """Progress bar: steps, simulated time, energy drift so far; silent when not a terminal."""

    def __init__(self, n_steps, unloaded_at):
        from tqdm import tqdm

        from .dynamics.result import unaccounted
        self._bar = tqdm(total=n_steps, unit="step", disable=None, file=sys.stderr)
        self._unaccounted = unaccounted
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
        if row["time"] >= self._unloaded_at * (1.0 - 1e-12):
            left = self._unaccounted(row)
            if self._reference is None:
                self._reference = left, row["kinetic_energy"] + row["strain_energy"]
            first, energy = self._reference
            if energy > 0.0:
                self._largest = max(self._largest, abs(left - first) / energy)
        drift = f", drift {self._largest:.1e}" if self._reference is not None else ""
        self._bar.set_postfix_str(f"t = {row['time']:.4g} s{drift}", refresh=False)
        self._bar.update(step - self._bar.n)


def _summary(history, unloaded_at, supported):
    """What both ``run`` and ``info`` say of a history."""
    from .dynamics.result import balance, drift, energy_balance
    last, changes = history[-1], drift(history, unloaded_at, supported)
    iterations = history["iterations"][1:]
    return {
        "time": float(last["time"]),
        "kinetic_energy": float(last["kinetic_energy"]),
        "strain_energy": float(last["strain_energy"]),
        "total_energy": float(last["kinetic_energy"] + last["strain_energy"]),
        "external_work": float(last["external_work"]),
        **{name: float(last[name]) if history[name].any() else None
           for name in ("support_work", "dissipated")},
        "energy_balance": energy_balance(history),
        "linear_momentum": last["linear_momentum"].tolist(),
        "angular_momentum": last["angular_momentum"].tolist(),
        "balance": balance(history)._asdict(),
        "unloaded_at": None if math.isinf(unloaded_at) else unloaded_at,
        "drift_since_unloading": None if changes is None else vars(changes),
        "iterations_per_step": float(iterations.mean()) if len(iterations) else 0.0,
        "switches": int(history["switches"].sum()),
        "halvings": int(history["halvings"].sum()),
        "indefinite_tangents": _indefinite(history),
        **_parts(history)}


def _parts(history):
    """What is said of steps that chose themselves, nothing of others."""
    rows = history[1:]
    if not (rows["parts"] > 1).any() and not rows["rejected"].any():
        return {}
    parts = int(rows["parts"].sum())
    return {"parts": parts, "parts_rejected": int(rows["rejected"].sum()),
            "iterations_per_part": float(rows["iterations"].sum() / parts),
            "largest_local_error": float(rows["local_error"].max())}


def _static_summary(history):
    """What ``info`` says of a static path."""
    last = history[-1]
    return {
        "factor": float(last["factor"]), "largest_factor": float(history["factor"].max()),
        "strain_energy": float(last["strain_energy"]), "reaction": last["reaction"].tolist(),
        "reaction_moment": last["reaction_moment"].tolist(),
        "balance": {"forces": float(history["force_balance"].max()),
                    "moments": float(history["moment_balance"].max())},
        "iterations": int(history["iterations"].sum()), "load_steps": int(history["steps"].sum()),
        "indefinite_tangents": _indefinite(history)}


def _indefinite(history):
    """Tangents with negative pivots; None where the solver does not tell."""
    return None if history["indefinite"].min() < 0 else int(history["indefinite"].sum())


UNITS = {"edges": "deg", "body": "kg, m, kg m^2", "dt": "s", "length": "m", "reaction": "N",
         "reaction_moment": "N m", "end_time": "s", "time": "s", "kinetic_energy": "J",
         "strain_energy": "J", "total_energy": "J", "external_work": "J",
         "support_work": "J", "dissipated": "J",
         "extent": "m", "thickness": "m", "linear_momentum": "kg m/s",
         "angular_momentum": "kg m^2/s", "unloaded_at": "s", "memory": "MB", "seconds": "s"}


def show(summary, as_json):
    """Print a summary: a line a key, with units, or one JSON object."""
    if as_json:
        click.echo(json.dumps(summary))
        return
    for key, value in summary.items():
        if value is None:
            continue
        if key in ("joints", "bodies"):
            text = printable(_words_of(key, value))
        elif isinstance(value, dict):
            text = ", ".join(f"{k.replace('_', ' ')} {_number(v)}" for k, v in value.items())
        else:
            text = _number(value)
        click.echo(f"  {key.replace('_', ' '):<22} {text} {UNITS.get(key, '')}".rstrip())


def _words_of(key, value):
    """Joints or bodies of a summary in words."""
    from .model.mechanism import words_of_bodies, words_of_joints
    return {"joints": words_of_joints, "bodies": words_of_bodies}[key](value)


def _number(value):
    if value is None:
        return "not defined"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list):
        return "(" + ", ".join(map(_number, value)) + ")"
    return printable(value)
