"""Command ``corovec verify``: runs the verification cases and writes one JSON of verdicts."""

import datetime
import json
import sys

import click

from corovec.solver.names import printable
from corovec.solver.results.files import replacing, writable_path
from corovec.solver.runtime.execution import complete, processes


@click.command()
@click.argument("names", nargs=-1)
@click.option("--quick", is_flag=True, help="Leave out the slow cases, as the tests do.")
@click.option("--list", "list_only", is_flag=True, help="Show the cases and what they claim.")
@click.option("--jobs", type=int, help="Worker processes.  Default: one a usable core.")
@click.option("-o", "--output", type=click.Path(dir_okay=False), default="verification.json",
              show_default=True, help="File of the verdicts (JSON).")
@click.option("--overwrite", is_flag=True, help="Replace the file if it exists.")
@click.option("--json", "as_json", is_flag=True, help="Print the verdicts instead of a table.")
def verify(names, quick, list_only, jobs, output, overwrite, as_json):
    """Run verification cases: all, or those with the NAMES of cases or suites.

    Every case runs in a worker process; one that fails does not stop the others.  The file is
    written after every case.  Exit status 1 if a row deviates without an explanation or a case
    ends with an error.

    \b
    Examples:
      corovec verify --list
      corovec verify
      corovec verify patch linear --jobs 2
      corovec verify roll-up --json
    """
    from .registry import Outcome, describe, find, make_report, run_case
    cases = find(names, quick)
    if list_only:
        for case in cases:
            slow = " (slow)" if case.slow else ""
            click.echo(f"{case.suite:<10} {case.name:<28} {case.claim}{slow}; {case.source}")
        return
    workers, output = processes(jobs), writable_path(output, overwrite)
    ended, shown = {}, 0
    from tqdm import tqdm
    with tqdm(total=len(cases), unit="case", disable=None, file=sys.stderr, leave=False) as bar:
        for case, outcome, error in complete(workers, run_case, cases):
            ended[case.name] = Outcome(case, [], error=describe(error)) if error else outcome
            outcomes = [ended[case.name] for case in cases if case.name in ended]
            report = make_report(outcomes, datetime.datetime.now().isoformat(timespec="seconds"),
                                 complete=len(outcomes) == len(cases))
            with replacing(output) as partial:
                partial.write_text(json.dumps(report, indent=1), encoding="utf-8")
            bar.set_postfix_str(f"last: {case.name}", refresh=False)
            bar.update()
            while not as_json and shown < len(cases) and cases[shown].name in ended:
                _show(ended[cases[shown].name])
                shown += 1
    open_rows = sum(outcome.deviations for outcome in outcomes)
    errors = sum(outcome.error is not None for outcome in outcomes)
    if as_json:
        click.echo(json.dumps(report))
    else:
        total = sum(len(outcome.rows) for outcome in outcomes)
        click.echo(f"{total - open_rows} of {total} rows as they should be, {open_rows} deviate "
                   f"without explanation; {errors} of {len(cases)} cases failed; written to "
                   f"{printable(output)}")
    if open_rows or errors:
        sys.exit(1)


def _show(outcome):
    case = outcome.case
    click.echo(f"{case.suite}: {case.name} ({outcome.seconds:.1f} s): {case.claim}")
    if outcome.error is not None:
        click.echo(f"  failed: {outcome.error}")
    for row in outcome.rows:
        click.echo(f"  {row}")
