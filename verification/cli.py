"""Command ``corovec verify``: runs the verification cases and writes one JSON of verdicts."""

import datetime
import json
import sys
import time

import click

from solver import ResultFileError
from solver.recorder import writable_path

from .case import OK
from .registry import find, make_report


@click.command()
@click.argument("names", nargs=-1)
@click.option("--quick", is_flag=True, help="Leave out the slow cases, as the tests do.")
@click.option("--list", "list_only", is_flag=True, help="Show the cases and what they claim.")
@click.option("--output", type=click.Path(dir_okay=False), default="verification.json",
              show_default=True, help="File of the verdicts (JSON).")
@click.option("--overwrite", is_flag=True, help="Replace the file if it exists.")
@click.option("--json", "as_json", is_flag=True, help="Print the verdicts instead of a table.")
def verify(names, quick, list_only, output, overwrite, as_json):
    """Run verification cases: all, or those with the NAMES of cases or suites.

    Exit status 1 if a row deviates without an explanation.

    \b
    Examples:
      corovec verify --list
      corovec verify
      corovec verify patch linear
      corovec verify roll-up --json
    """
    cases = find(names, quick)
    if list_only:
        for case in cases:
            slow = " (slow)" if case.slow else ""
            click.echo(f"{case.suite:<10} {case.name:<28} {case.claim}{slow}; {case.source}")
        return
    output = writable_path(output, overwrite)
    if not output.parent.is_dir():
        raise ResultFileError(f"{output} cannot be created: no folder {output.parent}")
    results, failed = [], 0
    from tqdm import tqdm
    with tqdm(cases, unit="case", disable=None, file=sys.stderr, leave=False) as bar:
        for case in bar:
            bar.set_postfix_str(case.name)
            clock = time.perf_counter()
            rows = case.run()
            seconds = time.perf_counter() - clock
            results.append((case, rows, seconds))
            failed += sum(row.verdict not in OK for row in rows)
            if not as_json:
                _show(case, rows, seconds)
    report = make_report(results, datetime.datetime.now().isoformat(timespec="seconds"))
    with open(output, "w", encoding="utf-8") as file:
        json.dump(report, file, indent=1)
    if as_json:
        click.echo(json.dumps(report))
    else:
        total = sum(len(rows) for _, rows, _ in results)
        click.echo(f"{total - failed} of {total} rows as they should be, {failed} deviate without "
                   f"explanation; written to {output}")
    if failed:
        sys.exit(1)


def _show(case, rows, seconds):
    click.echo(f"{case.suite}: {case.name} ({seconds:.1f} s): {case.claim}")
    for row in rows:
        click.echo(f"  {row.name:<64} {row.value:>12.6g} {row.reference:>12.6g} "
                   f"{row.difference:>+9.2%}  {row.verdict}")
