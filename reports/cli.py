"""Command ``corovec reproduce``."""

import sys
from pathlib import Path

import click


@click.command()
@click.argument("names", metavar="[PART]...", nargs=-1)
@click.option("--size", default="quick", show_default=True,
              help="quick (minutes) or full (all meshes, the paper's simulated times: hours).")
@click.option("--jobs", type=int, help="Parts at a time.  Default: one a usable core.")
@click.option("--output", type=click.Path(file_okay=False), default="results/reproduce",
              show_default=True, help="Folder of all results; the page is SIZE/page/index.html.")
@click.option("--list", "list_only", is_flag=True, help="Show the parts and how they ended.")
@click.option("--page-only", is_flag=True, help="Run nothing; make the page of what is there.")
def reproduce(names, size, jobs, output, list_only, page_only):
    """Rerun every claim of the paper, and make one page of tables, figures and verdicts.

    Every PART (default: all of the size) is a corovec command of its own: timings, runs behind the
    figures, convergence studies, verification suites.  Finished parts are kept and not run again,
    interrupted runs go on, a part that fails is a row of the page.  Exit status 1 if one failed.

    \b
    Examples:
      corovec reproduce
      corovec reproduce --size full
      corovec reproduce time-table-2 verify
    """
    from convergence.store import writable_folder
    from solver import InputError

    from .page import build
    from .parts import Stamps, parts, select, status
    from .reproduce import run_parts
    if jobs is not None and jobs < 1:
        raise InputError(f"jobs must be at least 1, is {jobs}")
    chosen = select(parts(size, Path(output).resolve() / size), names)
    folder = writable_folder(Path(output) / size)
    if list_only:
        stamps = Stamps(folder / "parts")
        for part in parts(size, folder):
            click.echo(f"{part.name:<24} {status(part, stamps):<26} {part.shown()}")
        return
    failed = 0 if page_only else run_parts(chosen, folder, jobs, click.echo)
    page = build(size, folder)
    click.echo(f"{page} ({page.stat().st_size / 1e6:.1f} MB)")
    if failed:
        click.echo(f"{failed} of {len(chosen)} parts failed; their logs are in {folder / 'parts'}")
        sys.exit(1)
