"""The recipes of docs/extending.md followed in copies of the files that they name."""

import json
import shutil
import sys
from importlib import import_module

import pytest
from click.testing import CliRunner

from corovec import benchmarks
from corovec.benchmarks import case_names, read_case
from corovec.convergence import study
from corovec.reports import drawings, page, parts
from corovec.reports.parts import Results
from corovec.reports.reproduce import run_parts
from corovec.solver.cli import cli
from corovec.solver.input import files
from corovec.verification import registry, suites

SIZE = "quick"

PRINTED = """
[fifth]
table = "Table 9"
mesh = ["4×30"]
elements = [120]
energy = ["1.000"]
error = ["0.000%"]
nodes = { "120" = "155" }

[fifth.claims]
"Figure 18" = ["nodes"]
"Figure 19" = ["energy"]
"""

DRAWINGS = """
[fifth]
short = "fifth shell"

[[fifth.figures]]
label = "Figure 18"
topic = "mesh, loads"
[[fifth.figures.drawings]]
name = "figure-18"
title = "The mesh"
kind = "mesh"

[[fifth.figures]]
label = "Figure 19"
topic = "energies"
level = true
[[fifth.figures.drawings]]
name = "figure-19"
title = "Energies"
kind = "energies"
"""

PLAN = "fifth = [{ elements = 120, dt = 4e-5, end_time = 0.006, frame_every = 25 }]\n"

FINDING = """
[[beyond.finding]]
title = "A finding of a reader"
text = "Something that nobody has seen."
command = "corovec verify element-spectrum"
cases = ["element-spectrum"]
rows = ["square: zero modes"]
"""

SUITE = '''
from ..case import Case, small


def run():
    yield small("one", 0.0, 1e-9, "rounding")
    yield small("other", 1.0, 1e-9, "rounding")


CASES = (Case("own-case", "own", "that it is found", "own", "none", run),)
'''


def extended(path, folder, text):
    """A copy of a file in ``folder`` with ``text`` at its end."""
    folder.mkdir(exist_ok=True)
    copy = folder / path.name
    copy.write_text(path.read_text(encoding="utf-8") + text, encoding="utf-8")
    return copy


def inserted(path, folder, text, before):
    """A copy of a file in ``folder`` with ``text`` before some other."""
    copy = extended(path, folder, "")
    head, found, tail = copy.read_text(encoding="utf-8").partition(before)
    assert found
    copy.write_text(head + text + found + tail, encoding="utf-8")
    return copy


@pytest.fixture(autouse=True)
def files_are_read_again():
    """What a test has read of its copies is forgotten."""
    yield
    clear()


def clear():
    for cached in (read_case, drawings.benchmarks, parts.plan):
        cached.cache_clear()


@pytest.fixture
def fifth(tmp_path, monkeypatch):
    """A fifth benchmark of the page, by its files alone."""
    folder, data = tmp_path / "benchmarks", tmp_path / "data"
    shutil.copytree(benchmarks.FOLDER, folder, ignore=shutil.ignore_patterns("*.py", "__pycache__"))
    text = (folder / "ruler.toml").read_text(encoding="utf-8")
    (folder / "fifth.toml").write_text(text.replace('"ruler"', '"fifth"').replace(
        'title = "ruler-shaped plate', 'title = "a fifth shell'), encoding="utf-8")
    monkeypatch.setattr(benchmarks, "FOLDER", folder)
    monkeypatch.setattr(files, "installed_models",
                        lambda: {path.stem: path for path in folder.glob("*.toml")})
    monkeypatch.setattr(study, "PRINTED", extended(study.PRINTED, data, PRINTED))
    monkeypatch.setattr(drawings, "DRAWINGS", extended(drawings.DRAWINGS, data, DRAWINGS))
    monkeypatch.setattr(parts, "PLAN", inserted(parts.PLAN, data, PLAN, before="\n[full]"))
    clear()
    return "fifth"


@pytest.fixture
def here(monkeypatch):
    """Parts run in this process: another one would not see the copies."""
    def execute(command, log):
        done = CliRunner().invoke(cli, command)
        log.write_text(f"{done.output}\n{done.exception or ''}", encoding="utf-8")
        return done.exit_code

    monkeypatch.setattr("corovec.reports.reproduce.execute", execute)


@pytest.mark.slow
def test_a_benchmark(fifth, here, tmp_path):
    """Listed, run, and on the page with its tables, figures and verdicts; nothing else edited."""
    assert fifth in case_names()
    assert "fifth" in CliRunner().invoke(cli, ["list"]).output
    folder = tmp_path / "results"
    chosen = parts.select(parts.parts(SIZE, folder), ["run-fifth-120", "claims-fifth"])
    assert run_parts(chosen, folder, 1) == 0
    assert "converge-fifth" in Results(SIZE, folder).parts
    html = page.build(SIZE, folder).read_text(encoding="utf-8")
    for text in ('<section id="fifth">', 'id="table-9"', "120 elements: nodes", "energy drift, 120",
                 "figures/figure-19.csv", ">fifth shell<"):
        assert text in html, text


def test_a_verification_row(tmp_path, monkeypatch):
    """A module of a suite with a function that yields rows; found, run and reported by its name."""
    (tmp_path / "own.py").write_text(SUITE, encoding="utf-8")
    monkeypatch.setattr(suites, "__path__", [*suites.__path__, str(tmp_path)])
    own = import_module("corovec.verification.suites.own")
    monkeypatch.setitem(sys.modules, own.__name__, own)
    monkeypatch.setattr(registry, "CASES", (*registry.CASES, *own.CASES))
    outcomes = [registry.run_case(case) for case in registry.find(["own"])]
    (case,) = json.loads(json.dumps(registry.make_report(outcomes, "", True)))["cases"]
    assert [row["verdict"] for row in case["rows"]] == ["match", "deviates (open)"]


@pytest.mark.slow
def test_a_figure_of_a_known_kind_and_a_finding(tmp_path, monkeypatch):
    """An entry of drawings.toml and one of findings.toml: on the page, with the evidence."""
    entry = ('[[plates.figures]]\nlabel = "Figure 14b"\ntopic = "mesh"\n'
             '[[plates.figures.drawings]]\nname = "figure-14b"\ntitle = "Again"\nkind = "mesh"\n\n')
    monkeypatch.setattr(drawings, "DRAWINGS", inserted(
        drawings.DRAWINGS, tmp_path, entry, '[[plates.figures]]\nlabel = "Figure 15"'))
    clear()
    monkeypatch.setattr(page, "FINDINGS", extended(page.FINDINGS, tmp_path, FINDING))
    folder = tmp_path / "results"
    path = parts.suite_file(folder, "kernel")
    (part,) = parts.select(parts.parts(SIZE, folder), ["verify-kernel"])
    report = registry.make_report([registry.run_case(case) for case in registry.find(
        ["element-spectrum"])], "2000-01-01", True)
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps(report), encoding="utf-8")
    (folder / "parts").mkdir()
    Results(SIZE, folder).stamps.write(part, "finished", 1.0)
    html = page.build(SIZE, folder).read_text(encoding="utf-8")
    assert 'id="figure-14b"' in html and "figures/figure-14b.csv" in html
    shown = html.partition("A finding of a reader")[2].partition("</article>")[0]
    assert "square: zero modes" in shown and "rhombus" not in shown
