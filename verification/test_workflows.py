"""Workflows of the hosted runner: they call tox environments that exist, and may do little."""

import re
from configparser import ConfigParser
from pathlib import Path

import yaml

ROOT = Path(__file__).parent.parent
FOLDER = ROOT / ".github" / "workflows"


def environments():
    """Names of the environments of tox.ini."""
    parser = ConfigParser(interpolation=None)
    parser.read(ROOT / "tox.ini", encoding="utf-8")
    listed = re.split(r"[,\s]+", parser["tox"]["env_list"])
    return {*listed, *(name.removeprefix("testenv:") for name in parser.sections())}


def workflows():
    """``{name: contents}`` of all workflow files."""
    return {path.stem: yaml.load(path.read_text(encoding="utf-8"), yaml.BaseLoader)
            for path in FOLDER.iterdir()}


def steps(workflow):
    return [step for job in workflow["jobs"].values() for step in job["steps"]]


def called(workflow):
    """The tox environments that a workflow calls, those of a matrix each."""
    names = set()
    for job in workflow["jobs"].values():
        matrix = job.get("strategy", {}).get("matrix", {})
        for step in job["steps"]:
            for name in re.findall(r"tox -e (.*)", step.get("run", "")):
                choices = re.fullmatch(r"\$\{\{ matrix\.(\w+) \}\}", name)
                names |= {*matrix[choices[1]], *(row[choices[1]] for row in matrix["include"])
                          } if choices else {*name.split(",")}
    return names


def test_workflows_call_environments_that_exist():
    named = {name: called(workflow) for name, workflow in workflows().items()}
    assert named["nightly"] == {"nightly", "slow", "timing"}
    assert {"lint", "py"} <= named["tests"] and set().union(*named.values()) <= environments()


def test_tests_run_on_every_push_and_pull_request():
    triggers = workflows()["tests"]["on"]
    assert triggers == {"push": "", "pull_request": ""}


def test_workflows_only_read_and_know_no_secrets():
    for path in FOLDER.iterdir():
        assert "secrets" not in path.read_text(encoding="utf-8")
    for workflow in workflows().values():
        assert workflow["permissions"] == {"contents": "read"}
        assert not any("permissions" in job for job in workflow["jobs"].values())
        for step in steps(workflow):
            assert re.fullmatch(r"actions/[\w/-]+@v\d+", step.get("uses", "actions/x@v1"))


def test_records_are_kept_also_when_a_verdict_fell():
    for job in workflows()["nightly"]["jobs"].values():
        used = {step["uses"].partition("@")[0]: step for step in job["steps"] if "uses" in step}
        restored, saved = (used[f"actions/cache/{what}"] for what in ("restore", "save"))
        assert restored["with"]["path"] == saved["with"]["path"]
        assert "records" in saved["with"]["path"] and saved["if"] == "always()"
        assert used["actions/upload-artifact"]["if"] == "always()"
        assert saved["with"]["key"].startswith(restored["with"]["restore-keys"])
