"""Command ``corovec time``."""

import datetime
import json
import sys

import click

from corovec.solver.errors import InputError
from corovec.solver.results.files import writable_folder, writable_path

from .measure import SIZES, single_thread, surroundings
from .report import NAMES, run, text


@click.command()
@click.argument("names", nargs=-1, metavar="[TABLE]...")
@click.option("--size", type=click.Choice(list(SIZES)), default="quick", show_default=True,
              help="Minutes, with large dense matrices extrapolated, or hours.")
@click.option("--output", type=click.Path(file_okay=False), help="Folder for timing.json and CSVs.")
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
