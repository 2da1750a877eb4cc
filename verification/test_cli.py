"""The command line, as a user meets it."""

import json
import math
import os
import signal
import subprocess
import sys
import time
from copy import copy
from functools import partial

import pytest
from click.testing import CliRunner

from corovec.verification import cli
from corovec.verification.case import Case, small
from corovec.verification.cli import verify
from corovec.verification.helpers import COMMAND, corovec

QUICK = ("run", "l-plate", "--elements", "30", "--dt", "0.01", "--end-time", "1.2")


def test_run_prints_a_summary():
    done = corovec(*QUICK)
    assert done.returncode == 0 and done.stderr == ""
    for label in ("kinetic energy", "strain energy", "drift since unloading", "assembly", "solve",
                  "iterations per step", "factorization", "compilation", "skyline"):
        assert label in done.stdout


def test_run_json_is_one_object():
    done = corovec(*QUICK, "--json", "--solver", "skyline")
    summary = json.loads(done.stdout)
    assert summary["solver"] == "skyline" and summary["nodes"] == 48
    assert summary["total_energy"] == pytest.approx(70.64, rel=2e-3)
    assert summary["drift_since_unloading"]["linear_momentum"] < 1e-11
    assert set(summary["seconds"]) == {"assembly", "factorization", "solve", "rest", "total",
                                       "compilation"}


def test_info_and_list(tmp_path):
    path = str(tmp_path / "run.h5")
    run = json.loads(corovec(*QUICK, "--output", path, "--json").stdout)
    info = json.loads(corovec("info", path, "--json").stdout)
    for key in ("total_energy", "linear_momentum", "drift_since_unloading", "solver", "elements"):
        assert info[key] == run[key]
    assert info["steps"] == info["steps_planned"] == 120
    listing = corovec("list").stdout
    assert "30, 120, 480, 1920, 7680" in listing and "[assumed]" in listing
    cases = json.loads(corovec("list", "--json").stdout)
    assert {row["provenance"] for row in cases["l-plate"]["provenance"]} == {"printed", "assumed"}


def test_resume_of_a_finished_run_computes_nothing(tmp_path):
    path = str(tmp_path / "run.h5")
    first = json.loads(corovec(*QUICK, "--output", path, "--json").stdout)
    again = json.loads(corovec(*QUICK, "--output", path, "--resume", "--json").stdout)
    assert again["total_energy"] == first["total_energy"]
    assert again["seconds"]["assembly"] == 0.0


@pytest.mark.parametrize("arguments, message", [
    (("run", "plate"), "case 'plate' is unknown"),
    (("run", "l-plate", "--elements", "7"), "no mesh of 7 elements"),
    (("run", "l-plate", "--dt", "0"), "dt must be positive"),
    (("run", "l-plate", "--dt", "soon"), "'soon' is not a valid float"),
    (("run", "l-plate", "--scheme", "euler"), "scheme 'euler' is unknown"),
    (("run", "l-plate", "--solver", "lu"), "solver 'lu' is unknown"),
    (("run", "l-plate", "--rho-inf", "2"), "rho_inf must lie in [0, 1]"),
    (("run", "l-plate", "--membrane", "thick"), "membrane 'thick' is unknown"),
    (("run", "l-plate", "--resume"), "--resume needs --output"),
    (("run", "l-plate", "--output", "/no/such/place.h5"), "cannot be created: no folder"),
    (("info", "nothing.h5"), "nothing.h5 does not exist"),
    (("info", __file__), "damaged or not a result file"),
    (("converge", "plate"), "case 'plate' is unknown"),
    (("info", "/no/such/place.h5"), "place.h5 does not exist"),
    (("verify", "patch-finite", "--output", "/no/such/place.json"), "cannot be created: no folder"),
    (("verify", "slit-annulus", "--quick"), "slit-annulus: slow cases only"),
    (("converge", "--size", "huge"), "size 'huge' is unknown, must be one of: quick, full, paper"),
    (("converge", "--jobs", "0"), "jobs must be at least 1, is 0"),
    (("verify", "patch-finite", "--jobs", "0"), "jobs must be at least 1, is 0"),
    (("converge", "--jobs", "2", "--scheduler", "tcp://h:1"), "exclude each other"),
    (("converge", "--scheduler", "nonsense"), "scheduler 'nonsense' cannot be reached"),
    (("converge", "--output", "/dev/null/here"), "folder /dev/null/here cannot be written"),
    (("converge", "--output", "/dev/null"), "is not a folder"),
    (("reproduce", "--list", "--page-only"), "leave out --page-only"),
    (("run", "l-plate", "--dt", "1e-12"), "at most 1e+08 can be recorded"),
    (("run", "l-plate", "--scheme", "newmark", "--rho-inf", "0.5"), "belong to the scheme quasi"),
    (("run", "l-plate", "--output", ""), "is not a path of a file"),
    (("run", "l-plate", "--output", "x" * 300), f"error: '{'x' * 300}' is not a path of a file"),
    (("run", "l-plate", "--output", "/dev/null", "--overwrite"), "is not a regular file"),
    (("run", "l-plate", "--dt", "0.25", "--end-time", "1", "--speed", "9"), "No such option"),
    (("dance",), "No such command 'dance'"),
])
def test_wrong_usage_is_status_2_and_says_why(arguments, message):
    """Nothing has been said or computed before."""
    done = corovec(*arguments)
    assert done.returncode == 2 and done.stdout == ""
    assert message in done.stderr and done.stderr.count("\n") == 1


@pytest.mark.parametrize("command", ["", "run", "info", "list", "converge", "verify", "time"])
def test_help_has_examples(command):
    done = corovec(*command.split(), "--help")
    assert done.returncode == 0 and "Example" in done.stdout and "corovec" in done.stdout


def own(name, run):
    return Case(name, "own", "claim", "source", "definition", run)


GOOD = own("good", partial(copy, [small("row", 0.0, 1.0, "")]))
BAD = own("bad", partial(math.sqrt, -1.0))
LATE = own("late", partial(subprocess.run, "sleep 2; false", shell=True, check=True))
DEADLY = own("deadly", partial(os._exit, 3))


def verdicts(monkeypatch, path, *cases):
    """``corovec verify`` of some cases: its result and the file it leaves."""
    monkeypatch.setattr(cli, "find", lambda names, quick: cases)
    done = CliRunner().invoke(verify, ["--output", str(path), "--jobs", "2"],
                              standalone_mode=False)
    assert os.listdir(path.parent) == [path.name]
    return done, json.loads(path.read_text())


def test_a_case_that_fails_does_not_end_the_others(tmp_path, monkeypatch):
    """One raises, late, and one takes its process with it; the order stays."""
    done, report = verdicts(monkeypatch, tmp_path / "verdicts.json", LATE, BAD, DEADLY, GOOD)
    assert done.exit_code == 1 and "failed: ValueError: " in done.stdout
    assert "1 of 1 rows as they should be, 0 deviate" in done.stdout
    assert "3 of 4 cases failed" in done.stdout and report["complete"] is True
    shown = [line.split()[1] for line in done.stdout.splitlines() if line.startswith("own: ")]
    assert shown == [case["name"] for case in report["cases"]] == ["late", "bad", "deadly", "good"]
    assert [(case["error"] or "").partition(":")[0] for case in report["cases"]] == [
        "CalledProcessError", "ValueError", "BrokenProcessPool", ""]
    assert [len(case["rows"]) for case in report["cases"]] == [0, 0, 0, 1]


def test_verdicts_up_to_an_interrupt_are_kept(tmp_path):
    """The file is there after every case, and says that it is not complete."""
    path = tmp_path / "verdicts.json"
    with subprocess.Popen([COMMAND, "verify", "patch-finite", "mutants-element", "--output", path,
                           "--jobs", "2"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                          text=True) as process:
        while not path.exists():
            assert process.poll() is None
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=20.0)  # mutants-element takes longer
    assert process.returncode == 130 and err.strip() == "corovec: error: interrupted"
    report = json.loads(path.read_text())
    assert report["complete"] is False
    assert [case["name"] for case in report["cases"]] == ["patch-finite"]


@pytest.mark.parametrize("module", ["corovec.solver.errors", "scipy", "numba"])
def test_interrupt_while_libraries_load_is_one_line(module):
    """Python tells what it has loaded (-X importtime), which makes the moment sure: the first
    module of ours, or one in the middle of the slow ones."""
    command = [sys.executable, "-X", "importtime", "-m", "corovec", "list"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True) as process:
        while process.stderr.readline().split()[-1:] != [module]:
            assert process.poll() is None
        process.send_signal(signal.SIGINT)
        out, err = process.communicate()
    said = [line for line in err.splitlines() if line and not line.startswith("import time:")]
    assert said == ["corovec: error: interrupted"] and out == "" and process.returncode == 130


def test_interrupt_lost_in_a_callback_ends_the_process():
    """As in the compiler's callbacks, whose exceptions Python drops."""
    code = ("import corovec.__main__, corovec.solver.cli\n"
            "class Lost:\n"
            "    def __del__(self):\n"
            "        raise KeyboardInterrupt\n"
            "corovec.solver.cli.main = Lost\n"
            "corovec.__main__.main()\n")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 130 and done.stderr.strip() == "corovec: error: interrupted"
