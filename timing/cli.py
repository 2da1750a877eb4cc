"""Commands ``corovec time`` and ``peers``."""

import datetime
import json
import sys

import click

from corovec.solver.errors import InputError
from corovec.solver.results.files import writable_folder, writable_path


@click.command()
@click.argument("names", nargs=-1, metavar="[TABLE]...")
@click.option("--size", type=click.Choice(["quick", "full"]), default="quick", show_default=True,
              help="Minutes, with large dense matrices extrapolated, or hours.")
@click.option("-o", "--output", type=click.Path(file_okay=False),
              help="Folder for timing.json and CSVs.")
@click.option("--overwrite", is_flag=True, help="Replace the results in that folder.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead of tables.")
def time(names, size, output, overwrite, as_json):
    """CPU times beside the paper's Tables 2, 4, 6 and 8, and what explains them.

    TABLE is table-2, table-4, table-6, table-8, iterations, growth or targets; without any, all.

    \b
    Examples:
      corovec time table-2 targets
      corovec time --size full --output timings
    """
    from .measure import SIZES, single_thread, surroundings
    from .report import NAMES, run, text
    for name in names:
        if name not in NAMES:
            raise InputError(f"table '{name}' is unknown, must be one of: {', '.join(NAMES)}")
    folder = None if output is None else _folder(output, overwrite)
    report = {"date": datetime.datetime.now().isoformat(timespec="seconds"), "size": size,
              "effort": vars(SIZES[size]), **surroundings()}
    if not as_json:
        click.echo(f"{report['machine']['processor']}, {report['cores']} cores, load "
                   f"{report['load']}, commit {report['commit']}; CPU seconds, one thread\n")
    from tqdm import tqdm
    with single_thread(), tqdm(disable=None, file=sys.stderr, leave=False,
                               bar_format="{desc}") as bar:
        for tables in run(names or NAMES, report, SIZES[size], folder, bar.set_description_str):
            for name, rows in tables.items():
                if rows and not as_json:
                    click.echo(text(name, rows))
    if as_json:
        click.echo(json.dumps(report))


def _folder(path, overwrite):
    """The folder of the results, made if it does not exist."""
    folder = writable_folder(path)
    writable_path(folder / "timing.json", overwrite)
    return folder


@click.command()
@click.option("--size", type=click.Choice(["quick", "full"]), default="full", show_default=True,
              help="Minutes, or hours: meshes 30 to 480 for 20 s, 1920 and 7680 for a few steps.")
@click.option("--elements", type=int, multiple=True, help="Elements of a mesh; may be repeated.")
@click.option("--dt", type=float, multiple=True, help="Time step [s]; may be repeated.")
@click.option("--end-time", type=float, help="Simulated time [s].")
@click.option("-o", "--output", type=click.Path(), default="peers.json", show_default=True,
              help="JSON of all rows, written after each.")
@click.option("--overwrite", is_flag=True, help="Replace that file.")
def peers(size, elements, dt, end_time, output, overwrite):
    """The L-plate by Kratos and CalculiX, as far as they are installed, beside ours.

    Kratos is the Python package KratosStructuralMechanicsApplication, CalculiX the program ccx.

    \b
    Examples:
      corovec peers --size quick
      corovec peers --elements 480 --dt 0.01 --end-time 1.2
    """
    from corovec import Settings
    from corovec.benchmarks import load_case
    from corovec.solver.results.files import replacing

    from . import peers as codes
    from .measure import load, surroundings
    meshes, dts, seconds = codes.SIZES[size]
    meshes, dts = elements or meshes, dt or dts
    seconds = seconds if end_time is None else end_time
    for n in meshes:
        load_case(codes.CASE).mesh(n)
    for step in dts:
        Settings(dt=step, end_time=seconds)
    path = writable_path(output, overwrite)
    report = {"date": datetime.datetime.now().isoformat(timespec="seconds"), **surroundings()}

    def write(rows):
        report.update(rows=rows, speedups=codes.speedups(rows), load_at_end=load())
        with replacing(path) as partial:
            partial.write_text(json.dumps(report, indent=1), encoding="utf-8")
        click.echo(codes.line(rows[-1]))

    codes.compare(codes.plan(meshes, dts, seconds), write)
    for row in report["speedups"]:
        click.echo(f"{row['elements']} elements, dt = {row['dt']:g}: {row['factor']:.1f} times "
                   f"faster than {row['fastest']}")
