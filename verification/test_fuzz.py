"""A sample of the fuzzers, and how they tell what they find."""

import importlib
import json
import os
import subprocess
import sys
import time
import warnings
from pathlib import Path

import pytest

from corovec.verification.fuzz.campaign import Fault, Target, campaign, once
from corovec.verification.fuzz.targets import TARGETS

SAMPLE = {"api": 300, "commands": 20, "models": 40, "shells": 100, "damage": 40, "edits": 25,
          "kills": 1, "dynamics": 3, "exact": 3, "joints": 4, "statics": 25}
"""Tries of each target: a few seconds in all."""


@pytest.mark.parametrize("name", TARGETS)
def test_sample(name, tmp_path):
    target = TARGETS[name]
    prepared = target.prepare(tmp_path)
    for number in range(SAMPLE[name]):
        once(target, prepared, 1, number)


def nothing(folder):
    return None


def troubled(chance, prepared, folder):
    """As chance has it a fault, an error, a warning, a lost process, or all is well."""
    kind = chance.randrange(6)
    if kind == 0:
        raise Fault("two\nlines")
    if kind == 1:
        return 1 / 0
    if kind == 2:
        os._exit(7)
    if kind == 3:
        time.sleep(1000.0)
    if kind == 4:
        warnings.warn("odd", RuntimeWarning, stacklevel=1)
    (folder / "file").write_text("is left to be cleaned up")
    return "good"


TROUBLED = Target("troubled", "nothing", nothing, troubled)

SEED = 35
"""One by which a process is lost and a try hangs once each, among eight."""


@pytest.mark.slow
def test_campaign_survives_what_it_finds(monkeypatch):
    """Every try is counted once, whatever became of the process, and is the same when repeated."""
    monkeypatch.setattr("corovec.verification.fuzz.campaign.TRY_SECONDS", 3.0)
    monkeypatch.syspath_prepend(Path(__file__).parent)  # the worker finds the target there
    target = importlib.import_module(Path(__file__).stem).TROUBLED
    found = campaign(target, SEED, 300.0, tries=8)
    assert found["tries"] == 8 == sum(found["outcomes"].values())
    assert {failure["what"].split(" (")[0] for failure in found["failures"]} == {
        "two lines", "ZeroDivisionError: division by zero", "ends the process: exit code 7",
        "hangs: not over after 3 s", "RuntimeWarning: odd"}
    number = next(failure["try"] for failure in found["failures"] if "Zero" in failure["what"])
    with pytest.raises(ZeroDivisionError):
        once(TROUBLED, None, SEED, number)


@pytest.mark.slow
def test_command_reports(tmp_path):
    report = tmp_path / "fuzz.json"
    done = subprocess.run([sys.executable, "-m", "corovec.verification.fuzz", "--only", "models",
                           "--tries", "3", "--report", report], text=True, capture_output=True)
    assert done.returncode == 0 and done.stdout.startswith("models          3 tries")
    (target,) = json.loads(report.read_text())["targets"]
    assert target["tries"] == 3 and target["failures"] == []
    wrong = subprocess.run([sys.executable, "-m", "corovec.verification.fuzz", "--only", "none"],
                           text=True, capture_output=True)
    assert wrong.returncode == 2
