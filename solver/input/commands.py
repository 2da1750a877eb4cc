"""Commands around the format of model files: ``corovec schema``, ``corovec new``."""

import json

import click

from ..results.files import replacing, writable_path


@click.command()
@click.option("--json", "as_json", is_flag=True, help="Print the JSON schema, for editors.")
def schema(as_json):
    """Print what can stand in a model file: every key, its unit, its default, an example.

    \b
    Examples:
      corovec schema
      corovec schema --json > model.schema.json
    """
    from . import reference
    click.echo(json.dumps(reference.json_schema(), indent=1) if as_json else reference.as_text())


@click.command()
@click.argument("file", type=click.Path(dir_okay=False))
@click.option("--overwrite", is_flag=True, help="Replace the file if it exists.")
def new(file, overwrite):
    """Write a commented model FILE to start from, which runs as it is.

    \b
    Examples:
      corovec new my_shell.toml
      corovec run my_shell.toml --output my_shell.h5
    """
    from .reference import START
    path = writable_path(file, overwrite)
    with replacing(path) as partial:
        partial.write_text(START.read_text(encoding="utf-8").replace("FILE", path.name),
                           encoding="utf-8")
    click.echo(f"{path}: corovec check {path} shows it, corovec run {path} runs it")
