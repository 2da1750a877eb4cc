"""Command ``corovec list``."""

import json

import click


@click.command("list")
@click.option("--json", "as_json", is_flag=True, help="Print as one JSON object.")
def list_cases(as_json):
    """Show the benchmarks, their meshes, and where every parameter comes from.

    \b
    Example:
      corovec list
    """
    from . import case_names, load_case
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
