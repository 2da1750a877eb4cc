"""The documentation is true: functions exist where it says, examples and commands are real."""

import contextlib
import importlib
import io
import json
import re
import subprocess
import sys
from functools import reduce
from pathlib import Path

import numpy as np
import pytest

import corovec
from corovec.verification.helpers import corovec as command

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"

ROW = re.compile(r"^\| (.*) \| `([\w.]+)` \| `([\w/]+)\.py` \|$", re.MULTILINE)

REQUIRED = (1, 3, 4, 7, 8, 10, 15, 16, 24, 27, 28, 29, 34, 37, 40, 45, 49, 50, 55, 56, 57, 58, 60,
            63, 64, 67, 68, 69, 70)
"""Equations that the table must have at least."""


def text_of(name):
    return (DOCS / name).read_text(encoding="utf-8")


ROWS = dict.fromkeys((module, function)
                     for _, function, module in ROW.findall(text_of("equations.md")))


@pytest.mark.parametrize(("module", "function"), ROWS,
                         ids=lambda value: value.rsplit("/", 1)[-1])
def test_function_of_an_equation_exists(module, function):
    found = importlib.import_module("corovec." + module.replace("/", "."))
    reduce(getattr, function.split("."), found)


def test_table_of_equations_is_complete():
    listed = set()
    for numbers, _, _ in ROW.findall(text_of("equations.md")):
        for first, last in re.findall(r"\((\d+)[a-g]?\)(?: to \((\d+)\))?", numbers.split("|")[0]):
            listed.update(range(int(first), int(last or first) + 1))
    assert set(REQUIRED) <= listed


def test_api_shows_every_public_name():
    shown = re.findall(r"^::: corovec\.(\w+)$", text_of("api.md"), re.MULTILINE)
    assert sorted(shown) == sorted(corovec.__all__)


def test_model_file_is_read(tmp_path):
    """The one of ``own-shell.md``, on both its meshes."""
    read_model = importlib.import_module("corovec.solver.input.files").read_model
    text = re.search(r"^```toml\n(.*?)^```$", text_of("own-shell.md"), re.DOTALL | re.MULTILINE)[1]
    path = tmp_path / "shell.toml"
    path.write_text(text, encoding="utf-8")
    for elements in (32, 128):
        assert len(read_model(path).model(elements).quads) == elements


def test_shaken_plate_is_the_model_in_python(tmp_path):
    """The model file of ``own-shell.md`` with all that is attached, and the lines of Python there,
    which print what stands below them."""
    page = text_of("own-shell.md")
    text = re.search(r"^```\n(name = \"shaken\"\n.*?)^```$", page, re.DOTALL | re.MULTILINE)[1]
    (tmp_path / "shaken.toml").write_text(text, encoding="utf-8")
    result = corovec.run_model(corovec.read_model(tmp_path / "shaken.toml")).dynamic
    block = re.search(r"^```pycon\n(>>> from corovec import Damping.*?)^```$", page,
                      re.DOTALL | re.MULTILINE)[1]
    lines = re.findall(r"^(?:>>>|\.\.\.) (.*)$", block, re.MULTILINE)
    names = {name: getattr(corovec, name) for name in ("Model", "Settings", "block", "simulate")}
    with contextlib.redirect_stdout(io.StringIO()) as said:
        exec("\n".join(lines), names)
    assert said.getvalue() == block.splitlines()[-1] + "\n"
    told = names["result"].history
    for name in told.dtype.names:
        assert np.array_equal(result.history[name], told[name]), name


def test_ten_lines_give_stresses(tmp_path):
    """The model file of ``own-shell.md`` with a mesh of its own; reactions bear the pressure."""
    text = re.search(r"^```\n(name = \"panel\"\n.*?)^```$", text_of("own-shell.md"),
                     re.DOTALL | re.MULTILINE)[1]
    (tmp_path / "panel.toml").write_text(text, encoding="utf-8")
    skin = corovec.block([(0, 0, 0), (400, 0, 0), (400, 300, 0), (0, 300, 0)], (8, 6))
    corovec.Mesh(skin.nodes, skin.quads, {"skin": range(48)}, lines={"rim": skin.boundary()}
                 ).write(tmp_path / "panel.msh")
    output = tmp_path / "panel.h5"
    run = json.loads(command("run", str(tmp_path / "panel.toml"), "--output", str(output),
                             "--json").stdout)
    assert run["reaction"][2] == pytest.approx(-2e3 * 0.4 * 0.3, rel=1e-2)
    contents = corovec.read(output)
    assert contents["von_mises"].shape == (11, 48, 3) and contents["von_mises"][-1].max() > 1e6


def test_pages_link_to_what_exists():
    """Relative links of all Markdown at the top and in docs/, also without mkdocs."""
    for page in (*ROOT.glob("*.md"), *DOCS.rglob("*.md"), ROOT / "timing" / "README.md"):
        for link in re.findall(r"\]\(([^)#]+?)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
            if "://" not in link:
                assert (page.parent / link).exists(), f"{page.name}: {link}"


def test_the_same_example_everywhere():
    """The 15-line example of the README, word for word."""
    def example(text):
        return re.search(r"^```python\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)[1]

    readme = example((ROOT / "README.md").read_text(encoding="utf-8"))
    assert example(text_of("index.md")) == example(text_of("own-shell.md")) == readme


def test_example_of_modes():
    """That of ``modes.md`` prints what the page says."""
    text = text_of("modes.md")
    example = re.search(r"^```python\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)[1]
    done = subprocess.run([sys.executable, "-c", example], text=True, capture_output=True,
                          check=True)
    assert done.stdout.strip() == re.search(r"It prints `(.*?)`", text)[1]
