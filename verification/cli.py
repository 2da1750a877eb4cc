"""Command ``corovec verify``: runs the verification cases and writes one JSON of verdicts."""

import datetime
import json
import sys
import time

import click

from solver.recorder import replacing, writable_path

from .registry import Outcome, find, make_report


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

    The file is written after every case.  Exit status 1 if a row deviates without an explanation
    or a case ends with an error.

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
    outcomes = []
    from tqdm import tqdm
    with tqdm(cases, unit="case", disable=None, file=sys.stderr, leave=False) as bar:
        for case in bar:
            bar.set_postfix_str(case.name)
            outcomes.append(_run(case))
            report = make_report(outcomes, datetime.datetime.now().isoformat(timespec="seconds"),
                                 complete=len(outcomes) == len(cases))
            with replacing(output) as partial:
                partial.write_text(json.dumps(report, indent=1), encoding="utf-8")
            if not as_json:
                _show(outcomes[-1])
    open_rows = sum(outcome.deviations for outcome in outcomes)
    errors = sum(outcome.error is not None for outcome in outcomes)
    if as_json:
        click.echo(json.dumps(report))
    else:
        total = sum(len(outcome.rows) for outcome in outcomes)
        click.echo(f"{total - open_rows} of {total} rows as they should be, {open_rows} deviate "
                   f"without explanation; {errors} of {len(cases)} cases failed; written to "
                   f"{output}")
    if open_rows or errors:
        sys.exit(1)


def _run(case):
    """The outcome of one case, whatever it raises."""
    clock = time.perf_counter()
    try:
        rows, error = case.run(), None
    except Exception as raised:
        rows, error = [], f"{type(raised).__name__}: {raised}"
    return Outcome(case, rows, time.perf_counter() - clock, error)


def _show(outcome):
    case = outcome.case
    click.echo(f"{case.suite}: {case.name} ({outcome.seconds:.1f} s): {case.claim}")
    if outcome.error is not None:
        click.echo(f"  failed: {outcome.error}")
    for row in outcome.rows:
        click.echo(f"  {row.name:<64} {row.value:>12.6g} {row.reference:>12.6g} "
                   f"{row.difference:>+9.2%}  {row.verdict}")
