"""Measured numbers in the Markdown are those of the snapshot, and the snapshot those of results."""

import json
import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from corovec.reports import numbers as module
from corovec.reports.numbers import COMMAND, MARKED, SNAPSHOT, numbers, pages, render

ROOT = Path(__file__).parents[1]


@pytest.mark.parametrize("page", pages(ROOT), ids=lambda page: str(page.relative_to(ROOT)))
def test_markdown_shows_the_snapshot(page):
    snapshot = json.loads((ROOT / SNAPSHOT).read_text(encoding="utf-8"))
    text = page.read_text(encoding="utf-8")
    assert text.count("<!-- number:") == len(MARKED.findall(text))
    assert render(text, snapshot) == text, f"stale numbers in {page.name}: run {COMMAND}"


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
             "summary": [{"quantity": quantity, "ours": -1.5} for quantity in (
                 "slope, finest mesh as reference", "R squared", "limit, successive differences",
                 "time step for a drift of 1e-06")]}
    path = folder / "convergence" / "l-plate" / "quick" / "study.json"
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps(study), encoding="utf-8")
    monkeypatch.setattr(module, "ROOT", tmp_path)
    result = CliRunner().invoke(numbers, [str(folder)], catch_exceptions=False)
    assert "README.md written anew" in result.output
    text = (tmp_path / "README.md").read_text(encoding="utf-8")
    assert ("| l-plate 30, 120 | 71.373, 72.455 | 70.000, 72.000 | 1, 1.5 | 4, 1e-2 | 1e-9 | 1e-15 "
            "| 3e-9 |") in text
    assert "Measured at commit 0123456, Abacus." in text
    assert "246.599, 246.585, 246.581" in text
    again = CliRunner().invoke(numbers, [str(folder)], catch_exceptions=False)
    assert again.output == ""


def test_an_empty_folder_is_an_error(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "ROOT", ROOT)
    result = CliRunner().invoke(numbers, [str(tmp_path)])
    assert "holds no study.json" in str(result.exception)
