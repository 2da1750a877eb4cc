"""Measured numbers in the Markdown are those of the snapshot, and the snapshot those of results."""

import json
import re
import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from corovec.reports import numbers as module
from corovec.reports.cli import numbers
from corovec.reports.numbers import (
    COMMAND,
    MARKED,
    SNAPSHOT,
    TABLES,
    collect,
    pages,
    render,
)

ROOT = Path(__file__).parents[1]

MEASURED = re.compile(r"\d(?:\.\d+)?e-\d+|\d (?:%|ms|µs|s|h|GB|m)(?![\w/])")
"""What looks like a measured number: small ones, as drifts are, and such with a unit."""

ALLOWED = {
    "convergence.md": {
        "1e-4 over thousands of turns": "bound that corovec verify rotations checks",
        "period 3e-4 s": "closed form, h^2/12",
        "until the paper's end": "printed", "at 1 s": "what the command was given",
        "from some 40 s on": "which rows of the table beside it",
        "more than 5 % of an impulse": "limit of the code"},
    "speed.md": {
        "13.460 s": "printed", "13,460 s": "printed", "8400 to 9300 s": "from printed numbers",
        "80 s on 480 elements take 29.9 h in the paper": "printed",
        "cc ≤ 1e-6": "a tolerance", "1e-14": "a tolerance", "1e-18": "a tolerance",
        "calls of 0.1 s": "limit of the code", "above 1 s one": "limit of the code",
        "above 100 s": "limit of the code", "dt = 1e-4": "a time step", "5e-4 s is": "a time step",
        "to 1 %": "bound of the target", "until 10 s": "instant of the table beside it",
        "at 20 s": "instant of the table beside it", "668 s": "printed"}}
"""What may stand in a page unmarked, and why; a fragment of its line."""


@pytest.mark.parametrize("page", pages(ROOT), ids=lambda page: str(page.relative_to(ROOT)))
def test_markdown_shows_the_snapshot(page):
    snapshot = json.loads((ROOT / SNAPSHOT).read_text(encoding="utf-8"))
    text = page.read_text(encoding="utf-8")
    assert text.count("<!-- number:") == len(MARKED.findall(text))
    assert "-->–<!--" not in text, "no such row"
    assert render(text, snapshot) == text, f"stale numbers in {page.name}: run {COMMAND}"


@pytest.mark.parametrize("page", pages(ROOT), ids=lambda page: str(page.relative_to(ROOT)))
def test_every_marker_has_a_known_name(page):
    snapshot = json.loads((ROOT / SNAPSHOT).read_text(encoding="utf-8"))
    names = {*TABLES, *snapshot["commands"], *snapshot["convergence"], *snapshot["timing"]}
    found = {match[2].split("|")[0].strip()
             for match in MARKED.finditer(page.read_text(encoding="utf-8"))}
    assert found <= names
    assert not {*TABLES} & {*snapshot["commands"]}


@pytest.mark.parametrize("name", ["nothing", "nothing | R squared | .4f",
                                  "l-plate | mesh | elements=30 | energies | .1f"])
def test_an_unknown_name_is_an_error(name):
    snapshot = json.loads((ROOT / SNAPSHOT).read_text(encoding="utf-8"))
    with pytest.raises((LookupError, ValueError)):
        render(f"<!-- number: {name} --><!-- end -->", snapshot)


def test_every_command_of_the_snapshot_is_shown():
    snapshot = json.loads((ROOT / SNAPSHOT).read_text(encoding="utf-8"))
    shown = {match[2] for page in pages(ROOT)
             for match in MARKED.finditer(page.read_text(encoding="utf-8"))}
    assert {*snapshot["commands"], *TABLES} <= shown


@pytest.mark.parametrize("page", ALLOWED)
def test_no_measured_number_is_typed(page):
    """Outside of markers and code a page has none but those that are ``ALLOWED``."""
    text = MARKED.sub("", (ROOT / "docs" / page).read_text(encoding="utf-8"))
    text = re.sub(r"```.*?```|`[^`\n]*`", "", text, flags=re.DOTALL)
    for fragment in ALLOWED[page]:
        text = text.replace(fragment, "")
    assert [line for line in text.splitlines() if MEASURED.search(line)] == []


def test_a_reproduction_changes_the_markdown(tmp_path, monkeypatch):
    """Of the parts that are there the new numbers come, of the others the old ones stay."""
    for page in (*pages(ROOT), ROOT / SNAPSHOT):
        copy = tmp_path / page.relative_to(ROOT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(page, copy)
    folder = tmp_path / "results" / "quick"
    study = {"origin": {"commit": "0123456789ab", "machine": {"processor": "Abacus"}},
             "mesh": [{"elements": 30, "printed": "71.373", "energy": 70.0, "order": None,
                       "order_of_printed": None},
                      {"elements": 120, "printed": "72.455", "energy": 72.0, "order": 1.5,
                       "order_of_printed": 1.0}],
             "drift": [{"until": 4.0, "dt": dt, "energy_drift": 1e-7 * dt,
                        "linear_momentum_drift": 1e-15, "angular_momentum_drift": 3e-9}
                       for dt in (0.02, 0.01)],
             "dissipation": [{"dt": 0.02, "rho_inf": rho, "time": time,
                              "energy_change": -time / 100}
                             for rho in (1.0, 0.9, 0.5) for time in (1.0, 4.0)],
             "summary": [{"quantity": quantity, "ours": -1.5} for quantity in (
                 "slope, finest mesh as reference", "R squared", "limit, successive differences",
                 "time step for a drift of 1e-06")]}
    path = folder / "convergence" / "l-plate" / "quick" / "study.json"
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps(study), encoding="utf-8")
    (folder / "peers.json").write_text(json.dumps({
        "commit": "abcdef012", "machine": {"processor": "Abacus"}, "speedups": [],
        "rows": [{"program": "Kratos Bossak", "version": "11", "elements": 30, "dt": 0.01,
                  "end_time": 1.0, "cpu_ms_per_step": 7.25, "survived": True, "reached": 1.0,
                  "energy_drift": 2e-3},
                 {"program": "CalculiX HHT", "version": None, "elements": 30, "dt": 0.01,
                  "end_time": 1.0, "missing": True}]}), encoding="utf-8")
    growth = folder / "timing" / "growth" / "timing.json"
    growth.parent.mkdir(parents=True)
    growth.write_text(json.dumps({
        "commit": None, "machine": {"processor": "Abacus"}, "tables": {
            "growth": [{"case": "l-plate"}],
            "growth-exponents": [{"case": "l-plate", "method": "auto", "solvers": "skyline",
                                  "points": 3, "assembly": 1.111, "factorization": 1.5,
                                  "solve": 1.5, "step": 1.0, "memory_bytes": None}]}}),
        encoding="utf-8")
    monkeypatch.setattr(module, "ROOT", tmp_path)
    result = CliRunner().invoke(numbers, [str(folder)], catch_exceptions=False)
    assert "README.md written anew" in result.output
    text = (tmp_path / "README.md").read_text(encoding="utf-8")
    assert ("| l-plate 30, 120 | 71.373, 72.455 | 70.000, 72.000 | 1, 1.5 | 4, 1e-2 | 1e-9 | 1e-15 "
            "| 3e-9 |") in text
    assert "Measured at commit 0123456, Abacus (l-plate" in text
    convergence = (tmp_path / "docs" / "convergence.md").read_text(encoding="utf-8")
    assert "| l-plate | – | -1.5e0 | 2e-2 | -4e-2 | -4e-2 |" in convergence
    speed = (tmp_path / "docs" / "speed.md").read_text(encoding="utf-8")
    assert "| 30, 0.01, 1 | – | – | 7.25, 2e-3 | – | – | – |" in speed
    assert "| l-plate, production (skyline) | 1.11 | 1.50 | 1.50 | 1.00 | – |" in speed
    assert "; commit abcdef0, Abacus (30)." in speed
    assert "246.599, 246.585, 246.581" in text
    again = CliRunner().invoke(numbers, [str(folder)], catch_exceptions=False)
    assert again.output == ""


def test_an_empty_folder_is_an_error(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "ROOT", ROOT)
    result = CliRunner().invoke(numbers, [str(tmp_path)])
    assert "holds no study.json" in str(result.exception)


def test_motion_of_the_smallest_step_is_kept(tmp_path):
    """Of the asymmetry the largest of all planes, at the first and the last instant."""
    dts, planes = (0.02, 0.01), ("x = 0", "y = 0")
    study = {"origin": {"commit": "0", "machine": {"processor": "Abacus"}}, "mesh": [],
             "drift": [{"until": 4.0, "dt": dt} for dt in dts], "dissipation": [], "summary": [],
             "motion": [{"dt": dt, "point": "A"} for dt in dts],
             "growth": [{"dt": dt, "plane": plane, "power": len(plane) * dt}
                        for dt in dts for plane in planes],
             "symmetry": [{"dt": dt, "plane": plane, "until": until,
                           "asymmetry": until * dt * (1 + planes.index(plane))}
                          for dt in dts for plane in planes for until in (0.1, 2.0, 4.0)]}
    path = tmp_path / "convergence" / "hemisphere" / tmp_path.name / "study.json"
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps(study), encoding="utf-8")
    kept = collect(tmp_path)["convergence"]["hemisphere"]
    assert [row["asymmetry"] for row in kept["symmetry"]] == [0.1 * 0.01 * 2, 4.0 * 0.01 * 2]
    assert [row["dt"] for row in kept["motion"] + kept["growth"]] == [0.01, 0.01]
