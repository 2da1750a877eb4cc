"""The README is true: its example runs, its commands exist, CI calls its test command."""

import re
from pathlib import Path

import numpy as np

from corovec.verification.helpers import in_process

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language, text=README):
    fenced = re.findall(r"^```(\w*)\n(.*?)^```$", text, flags=re.DOTALL | re.MULTILINE)
    return [text for name, text in fenced if name == language]


def test_example_runs_as_printed(tmp_path, monkeypatch, capsys):
    """The 15-line example, word for word; it conserves, and its file is one of ours."""
    (code,) = blocks("python")
    assert len(code.strip().splitlines()) == 15
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(compile(code, "README.md", "exec"), names)
    assert (tmp_path / "shell.h5").exists()
    assert names["energy"].shape == (1001,) and names["spin"].shape == (1001, 3)
    assert names["frames"].shape == (201, 45, 3)
    assert names["result"].drift.energy < 1e-5
    assert np.abs(names["result"].drift.linear_momentum) < 1e-11
    printed = re.findall(r"It prints `(.*?)`", README)
    assert printed == capsys.readouterr().out.splitlines()


def test_commands_exist():
    """Every ``corovec X`` that README and documentation show has a help page with the options
    shown, and they show every command."""
    pages = [README, *(page.read_text(encoding="utf-8")
                       for page in (ROOT / "docs").rglob("*.md"))]
    text = "\n".join(block for page in pages for block in blocks("", page))
    shown = re.findall(r"^corovec (\w+)(.*)$", text, flags=re.MULTILINE)
    listed = re.findall(r"^  (\w+)  ", in_process("--help").stdout.split("Commands:")[1],
                        flags=re.MULTILINE)
    assert {name for name, _ in shown} == set(listed)
    options = {}
    for name, rest in shown:
        options.setdefault(name, set()).update(re.findall(r"--[a-z-]+", rest))
    for name, used in options.items():
        text = in_process(name, "--help").stdout
        assert all(option in text for option in used), name


def test_ci_runs_the_test_command():
    command = "python3 -m pip install tox && tox"
    assert command in [text.strip() for text in blocks("")]
    assert command in (ROOT / ".ci" / "run").read_text(encoding="utf-8").splitlines()
