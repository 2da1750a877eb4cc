"""The command line, as a user meets it."""

import json
import math
import os
import signal
import subprocess
import sys
import time
from copy import copy
from dataclasses import fields, is_dataclass
from functools import partial

import pytest
from click.testing import CliRunner

from corovec import Newton, Scheme, Settings
from corovec.solver.fields import called
from corovec.solver.input.files import read_model
from corovec.verification import registry
from corovec.verification.case import Case, small
from corovec.verification.cli import verify
from corovec.verification.helpers import COMMAND, corovec, in_process

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
    run = json.loads(in_process(*QUICK, "--output", path, "--json").stdout)
    info = json.loads(in_process("info", path, "--json").stdout)
    for key in ("total_energy", "linear_momentum", "drift_since_unloading", "solver", "elements"):
        assert info[key] == run[key]
    assert info["steps"] == info["steps_planned"] == 120
    listing = in_process("list").stdout
    assert "30, 120, 480, 1920, 7680" in listing and "[assumed]" in listing
    cases = json.loads(in_process("list", "--json").stdout)
    assert {row["provenance"] for row in cases["l-plate"]["provenance"]} == {
        "printed", "assumed", "selected"}


@pytest.mark.parametrize("options, scheme, newton", [
    ((), {"name", "rho_inf", "transformation", "axes"}, {"kind", "tolerance", "max_iterations"}),
    (("--newton", "full"), {"name", "rho_inf", "transformation", "axes"},
     {"kind", "tolerance", "min_iterations", "max_iterations"}),
    (("--scheme", "newmark"), {"name", "axes"}, {"kind", "tolerance", "max_iterations"}),
    (("--scheme", "exact", "--newton", "full"), {"name"}, {"kind", "max_iterations"}),
    (("--scheme", "exact", "--dissipation", "0.1"), {"name", "dissipation", "dissipates"},
     {"kind", "max_iterations"})])
def test_summaries_tell_the_settings_that_take_part(tmp_path, options, scheme, newton):
    """Those of another scheme, or of nothing that is dissipated, are not told."""
    path = str(tmp_path / "run.h5")
    run = json.loads(in_process("run", "l-plate", "--elements", "30", "--dt", "0.01", "--end-time",
                                "0.5", "--output", path, "--json", *options).stdout)
    info = json.loads(in_process("info", path, "--json").stdout)
    for summary in (run, info):
        assert set(summary["scheme"]) == scheme and set(summary["newton"]) == newton


def test_every_setting_has_an_option():
    """With its default, choices and unit, from the fields of the settings themselves."""
    text = " ".join(in_process("run", "--help").stdout.split())
    for kind in (Settings, Scheme, Newton):
        for field in fields(kind):
            if not is_dataclass(field.type):
                assert f"--{called(field).replace('_', '-')} " in text
                assert "One of: " + ", ".join(field.metadata["choices"]) in text
    assert "Time step [s]. Default: the model file's." in text
    assert "[default: 1e-06]" in text and "[default: quasi]" in text


SHELL = """
name = "strip"

[defaults]
elements = 4
dt = 0.01
end_time = 0.2

[parameters]
thickness = 0.1
youngs = 1e5
poisson = 0.3
density = 1.0

[[geometry.blocks]]
corners = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
divisions = [4, 1]

[[meshes]]
elements = 4
refinement = 1

[histories.pulse]
times = [0.0, 0.05, 0.1]
values = [0.0, 1.0, 0.0]

[[loads]]
name = "tip"
history = "pulse"
force = [0.0, 0.0, 2.0]
at = [4.0, 1.0, 0.0]

[[loads]]
name = "edge"
history = "pulse"
force = [0.0, 1.0, 0.0]
line = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
"""
"""A user's own model file: plain values in the units of the code."""


def test_run_of_an_own_model_file(tmp_path):
    """Plain values are those with a unit; the result names the file."""
    path, output = tmp_path / "strip.toml", tmp_path / "strip.h5"
    path.write_text(SHELL)
    done = corovec("run", str(path), "--output", str(output), "--rho-inf", "0.9", "--json")
    assert done.stderr == ""
    summary = json.loads(done.stdout)
    assert summary["case"] == "strip.toml" and summary["scheme"]["rho_inf"] == 0.9
    assert summary["dt"] == 0.01 and summary["nodes"] == 10
    model = read_model(path)
    assert {row[3] for row in model.provenance()} == {"given"}
    assert [load.force for load in model.model(4).loads] == [
        (0.0, 0.0, 2.0), (0.0, 0.5, 0.0), (0.0, 0.5, 0.0)]
    assert [model.load_number(4, k) for k in range(3)] == [0, 1, 1]
    again = json.loads(in_process("info", str(output), "--json").stdout)
    assert again["case"] == "strip.toml" and again["newton"] == summary["newton"]


@pytest.mark.parametrize("change, message", [
    (("thickness = 0.1", "thickness = -0.1"), "parameters.thickness: must be positive"),
    (("youngs = 1e5", 'youngs = "stiff"'), "parameters.youngs: must be a number, is 'stiff'"),
    (("force = [0.0, 0.0, 2.0]", "force = [0.0, 2.0]"), "loads[0].force[2]: is missing"),
    (("at = [4.0, 1.0, 0.0]", "at = [4.0, 1.5, 0.0]"), "loads[0].at: no node at [4.0, 1.5, 0.0]"),
    (('name = "strip"', ""), "name: is missing"),
    (("poisson = 0.3", "poisson = 0.3\ncolour = 1"), "parameters.colour: is unknown"),
])
def test_errors_in_an_own_model_file(tmp_path, change, message):
    """One line with the file and the place in it, whether a value is plain or not."""
    path = tmp_path / "strip.toml"
    assert change[0] in SHELL
    path.write_text(SHELL.replace(*change))
    done = in_process("run", str(path))
    assert done.returncode == 2 and done.stdout == "" and done.stderr.count("\n") == 1
    assert f"{path}: " in done.stderr and message in done.stderr


@pytest.mark.parametrize("change, options, message", [
    (("", ""), ("--dt", "0.1"),
     "loads[0].history: --dt 0.1 s is too long for its time function"),
    (("dt = 0.01", "dt = 0.03"), (), "defaults: end_time 0.2 s is not a multiple of dt 0.03 s"),
    (("", ""), ("--dt", "0.03"), "defaults.end_time of {path} 0.2 s is not a multiple of --dt"),
])
def test_errors_name_a_value_as_it_was_given(tmp_path, change, options, message):
    """An option, or its place in the file, whose loads have other numbers than the model's."""
    path = tmp_path / "strip.toml"
    path.write_text(SHELL.replace(*change))
    assert message.format(path=path) in in_process("run", str(path), *options).stderr


def test_summaries_tell_what_folds(tmp_path):
    """Both of a run and of its file; a benchmark of three plates has them."""
    path = tmp_path / "plates.h5"
    run = json.loads(in_process("run", "plates", "--dt", "0.01", "--end-time", "0.01", "--output",
                             str(path), "--json").stdout)
    assert run["edges"] == pytest.approx({"folded": 12, "smooth": 766, "smallest_fold": 90.0,
                                          "largest_smooth": 0.0})
    assert ("edges                  folded 12, smooth 766, smallest fold 90, largest smooth 0 deg"
            in in_process("info", str(path)).stdout)


def test_all_errors_of_a_model_file_at_once(tmp_path):
    path = tmp_path / "strip.toml"
    path.write_text(SHELL.replace("0.1\n", "-0.1\n").replace("poisson", "poison"))
    said = in_process("run", str(path)).stderr
    for message in ("parameters.thickness: ", "parameters.poisson: ", "parameters.poison: "):
        assert message in said


@pytest.mark.slow
def test_files_of_a_script_disturb_nothing(tmp_path):
    """Modules called solver, model or timing beside a user's script are not corovec's."""
    for name in ("solver", "model", "timing", "benchmarks", "verification", "reports"):
        (tmp_path / f"{name}.py").write_text("raise RuntimeError('imported')\n")
    script = tmp_path / "script.py"
    script.write_text(
        "from corovec import Settings, simulate\n"
        "from corovec.benchmarks import load_case\n"
        "import corovec.convergence.cli, corovec.reports.cli, corovec.timing.cli\n"
        "import corovec.verification.cli\n"
        "model = load_case('l-plate').model(30)\n"
        "print(simulate(model, Settings(dt=0.01, end_time=0.02)).solver)\n")
    done = subprocess.run([sys.executable, str(script)], cwd=tmp_path, capture_output=True,
                          text=True, check=False)
    assert done.stdout.split() == ["skyline"] and done.stderr == ""
    shown = subprocess.run([sys.executable, "-m", "corovec", "list"], cwd=tmp_path,
                           capture_output=True, text=True, check=False)
    assert shown.returncode == 0 and "l-plate" in shown.stdout


def test_resume_of_a_finished_run_computes_nothing(tmp_path):
    path = str(tmp_path / "run.h5")
    first = json.loads(in_process(*QUICK, "--output", path, "--json").stdout)
    again = json.loads(in_process(*QUICK, "--output", path, "--resume", "--json").stdout)
    assert again["total_energy"] == first["total_energy"]
    assert again["seconds"]["assembly"] == 0.0


@pytest.mark.parametrize("arguments, message", [
    (("run", "plate"), "model 'plate' is unknown, must be the path of a .toml file or one of: hem"),
    (("run", "no/such/shell.toml"), "no/such/shell.toml cannot be read: No such file"),
    (("run", "l-plate", "--newton", "broyden"), "--newton 'broyden' is unknown"),
    (("run", "l-plate", "--end-time", "-1"), "--end-time must be positive [s]"),
    (("run", "l-plate", "--max-iterations", "0"), "--max-iterations must be at least 1"),
    (("calibrate", "ruler", "--elements", "480", "--output", __file__), "exists; --overwrite r"),
    (("run", "l-plate", "--output", __file__), "--overwrite replaces it, --resume continues its"),
    (("run", "l-plate", "--elements", "7"), "no mesh of 7 elements"),
    (("run", "l-plate", "--dt", "0"), "--dt must be positive"),
    (("run", "l-plate", "--dt", "soon"), "'soon' is not a valid float"),
    (("run", "l-plate", "--scheme", "euler"), "--scheme 'euler' is unknown"),
    (("run", "l-plate", "--solver", "lu"), "--solver 'lu' is unknown"),
    (("run", "l-plate", "--rho-inf", "2"), "--rho-inf must lie in [0, 1]"),
    (("run", "l-plate", "--membrane", "thick"), "--membrane 'thick' is unknown"),
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
    (("calibrate", "ruler", "--elements", "7"), "Table 3 has no energy of 7 elements"),
    (("run", "l-plate", "--dt", "1e-12"), "at most 1e+08 can be recorded"),
    (("run", "l-plate", "--scheme", "newmark", "--rho-inf", "0.5"), "belong to the scheme quasi"),
    (("run", "l-plate", "--output", ""), "is not a path of a file"),
    (("run", "l-plate", "--output", "x" * 300), f"error: '{'x' * 75} ... is not a path of a file"),
    (("run", "l-plate", "--output", "/dev/null", "--overwrite"), "is not a regular file"),
    (("run", "l-plate", "--dt", "0.25", "--end-time", "1", "--speed", "9"), "No such option"),
    (("dance",), "No such command 'dance'"),
])
def test_wrong_usage_is_status_2_and_says_why(arguments, message):
    """Nothing has been said or computed before."""
    done = in_process(*arguments)
    assert done.returncode == 2 and done.stdout == ""
    assert message in done.stderr and done.stderr.count("\n") == 1


def test_wrong_usage_of_the_installed_command():
    done = corovec("run", "l-plate", "--dt", "0")
    assert done.returncode == 2 and done.stdout == "" and "--dt must be" in done.stderr


@pytest.mark.parametrize("command", ["", "run", "info", "list", "converge", "verify", "time"])
def test_help_has_examples(command):
    done = in_process(*command.split(), "--help")
    assert done.returncode == 0 and "Example" in done.stdout and "corovec" in done.stdout


def own(name, run):
    return Case(name, "own", "claim", "source", "definition", run)


GOOD = own("good", partial(copy, [small("row", 0.0, 1.0, "")]))
BAD = own("bad", partial(math.sqrt, -1.0))
LATE = own("late", partial(subprocess.run, "sleep 2; false", shell=True, check=True))
DEADLY = own("deadly", partial(os._exit, 3))


def verdicts(monkeypatch, path, *cases):
    """``corovec verify`` of some cases: its result and the file it leaves."""
    monkeypatch.setattr(registry, "find", lambda names, quick: cases)
    done = CliRunner().invoke(verify, ["--output", str(path), "--jobs", "2"],
                              standalone_mode=False)
    assert os.listdir(path.parent) == [path.name]
    return done, json.loads(path.read_text())


@pytest.mark.slow
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


@pytest.mark.slow
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
