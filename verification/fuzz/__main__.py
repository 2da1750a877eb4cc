"""Command ``python -m corovec.verification.fuzz``."""

import json
import sys
import tempfile
import time
from pathlib import Path

import click

from corovec import warm_up
from corovec.solver.results.files import replacing, writable_path

from .campaign import ENDLESS, campaign, once
from .targets import TARGETS


@click.command()
@click.option("--seed", type=int, default=1, show_default=True, help="What all tries follow from.")
@click.option("--minutes", type=float, default=10.0, show_default=True,
              help="Time for all targets together.")
@click.option("--tries", type=int, default=ENDLESS, help="Tries of a target at most.")
@click.option("--only", "names", multiple=True, type=click.Choice(list(TARGETS)),
              help="A target; may be given several times.  Default: all.")
@click.option("--try", "number", type=int, help="Repeat one try of one target, here, with its "
              "traceback.")
@click.option("--report", type=click.Path(dir_okay=False), help="JSON of all outcomes.")
def fuzz(seed, minutes, tries, names, number, report):
    """Try what must never happen: errors that are none, wrong numbers, runs lost.

    Exit status 1 if anything failed.
    """
    targets = [TARGETS[name] for name in names or TARGETS]
    if number is not None:
        if len(targets) != 1:
            raise click.UsageError("--try needs one target, by --only")
        with tempfile.TemporaryDirectory() as folder:
            click.echo(once(targets[0], targets[0].prepare(Path(folder)), seed, number))
        return
    report = writable_path(report, overwrite=True) if report else None
    warm_up(exact=True)
    end, found = time.monotonic() + 60.0 * minutes, []
    for k, target in enumerate(targets):
        share = (end - time.monotonic()) / (len(targets) - k)
        found.append(campaign(target, seed, share, tries))
        show(found[-1], seed)
        if report:
            with replacing(report) as partial:
                partial.write_text(json.dumps({"seed": seed, "minutes": minutes, "targets": found},
                                              indent=1), encoding="utf-8")
    sys.exit(any(target["failures"] for target in found))


def show(target, seed):
    """A line for the target, and one for each failure."""
    kinds = ", ".join(f"{kind} {count}" for kind, count in sorted(target["outcomes"].items()))
    click.echo(f"{target['name']:<9} {target['tries']:>7} tries {target['seconds']:>7.1f} s  "
               f"{len(target['failures'])} failed  ({kinds})")
    for failure in target["failures"]:
        click.echo(f"  --seed {seed} --only {target['name']} --try {failure['try']}: "
                   f"{failure['what']}")


if __name__ == "__main__":
    fuzz()
