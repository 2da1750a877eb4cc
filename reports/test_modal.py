"""Commands ``corovec modes`` and ``corovec buckling``: summaries, figures, films, files."""

import json

import meshio
import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from PIL import Image

from corovec import InputError, buckling, modes
from corovec.reports import cli as commands
from corovec.reports.modal import LARGEST, PERIOD, oscillation, shapes
from corovec.solver.input.modal import buckling_of, modes_of

BLADE = """
name = "blade"
[parameters]
thickness = 0.05
youngs = 1.2e8
poisson = 0.0
density = 1.0
[[geometry.blocks]]
corners = [[0, -0.25, 0], [10, -0.25, 0], [10, 0.25, 0], [0, 0.25, 0]]
divisions = [16, 1]
[[supports]]
fix = "clamped"
where = { x = 0.0 }
[[loads]]
name = "acts"
%s
[[steps]]
kind = "static"
increments = 1
"""
def call(command, *arguments):
    return CliRunner().invoke(command, [str(argument) for argument in arguments])


SPIN = "centrifugal = [0, 0, 9.486832980505138]\nabout = [0, 0, 0]"
THRUST = "line = [[10, -0.25, 0], [10, 0.25, 0]]\nforce = [-1, 0, 0]"


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Model files of a blade that spins at 6 units of its bending, and of one under thrust."""
    folder = tmp_path_factory.mktemp("modal")
    for name, load in (("spin", SPIN), ("thrust", THRUST)):
        (folder / f"{name}.toml").write_text(BLADE % load)
    return folder


@pytest.mark.slow
def test_modes_of_a_file_are_those_of_its_static_step(files, tmp_path):
    """Its spin stiffens: 7.3604 instead of 3.516 (Wright et al. 1982), a mesh of 16 x 1."""
    unit = np.sqrt(2.5e4) / 100.0
    paths = {name: tmp_path / f"m.{end}" for name, end in (("output", "vtu"), ("plot", "png"),
                                                          ("film", "gif"))}
    options = [text for name, path in paths.items() for text in (f"--{name}", str(path))]
    done = call(commands.modes, files / "spin.toml", "--number", "3", "--json", *options)
    assert done.exit_code == 0, done.exception
    told = json.loads(done.output)
    assert told["about"] == "the static step"
    assert told["modes"]["omega"][0] == pytest.approx(7.3604 * unit, rel=3e-3)
    assert len(meshio.read(paths["output"]).point_data) == 3
    with Image.open(paths["film"]) as film:
        assert film.n_frames == PERIOD and paths["plot"].stat().st_size > 0
    still, summary = modes_of(str(files / "spin.toml"), number=1, unloaded=True)
    assert still.omega[0] == pytest.approx(3.516 * unit, rel=3e-3)
    assert summary["about"] == "the initial shell" and "effective_mass_z" in summary["modes"]


def test_buckling_of_a_file(files):
    """A table of load factors: Euler's first, of a mesh of 16 x 1."""
    done = call(commands.buckling, files / "thrust.toml", "--number", "2")
    assert done.exit_code == 0, done.exception
    factor = float(done.output.splitlines()[-2].split()[1])
    assert factor == pytest.approx(np.pi**2 * 2.5e4 * 0.05 / 400.0, rel=3e-3)


def test_what_is_drawn(files):
    """The largest displacement is a tenth of the shell; a film keeps its energy."""
    for found in (modes_of(str(files / "spin.toml"), number=2)[0],
                  buckling_of(str(files / "thrust.toml"), number=2)[0]):
        figure, table = shapes(found)
        assert isinstance(table, pd.DataFrame) and len(figure.axes) == 3
        drawn = np.linalg.norm(table[["u", "v", "w"]], axis=1)
        for _, of in table.groupby("shape"):
            assert drawn[of.index].max() <= LARGEST * 10.0 * (1.0 + 1e-12)
        film = oscillation(found, 1)
        total = film.history["strain_energy"] + film.history["kinetic_energy"]
        assert found.names()[1] == film.name and film.displacement.shape[0] == PERIOD
        if hasattr(found, "frequencies"):
            assert np.allclose(total, total[0]) and total[0] > 0.0
    with pytest.raises(InputError, match="shape 3 is not among 2 shapes"):
        oscillation(found, 2)


def test_what_cannot_be_written_is_refused_first(files, tmp_path):
    """One line, and no file."""
    path = str(files / "thrust.toml")
    for option, name, words in (("--plot", "x.jpg", "x.jpg: must end in one of"),
                                ("--output", "x.vtk", "must end in .vtu"),
                                ("--film", "x.avi", "the ending of a film must be"),
                                ("--elements", "3", "no mesh of 3 elements")):
        given = name if option == "--elements" else tmp_path / name
        error = call(commands.buckling, path, option, given).exception
        assert isinstance(error, InputError) and words in str(error)
    assert not any(tmp_path.iterdir())


def test_names_are_those_of_python(files):
    """The commands give what the functions give."""
    found, _ = buckling_of(str(files / "thrust.toml"), number=1)
    assert np.array_equal(buckling(found.model, 1).factors, found.factors)
    assert modes(found.model, 1).omega[0] > 0.0
