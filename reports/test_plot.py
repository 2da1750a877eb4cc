"""Commands ``corovec plot`` and ``corovec animate``."""

import os
import resource
import shutil
from dataclasses import replace

import h5py
import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from PIL import Image

from corovec import (
    Damping,
    Drive,
    EnergyProbe,
    Gravity,
    Harmonic,
    InputError,
    ResultFileError,
    Settings,
    StressProbe,
    Support,
    simulate,
)
from corovec.reports.cli import animate, plot
from corovec.reports.colours import coloured
from corovec.reports.curves import energies
from corovec.reports.gallery import gallery
from corovec.reports.recording import Recording
from corovec.solver.dynamics import simulation
from corovec.solver.names import printable
from corovec.verification.helpers import corovec
from corovec.verification.models import cross_code_plate

SEVERAL = {"l30-mesh", "l30-energies", "l30-momenta", "l30-motion", "l120-mesh", "l120-energies",
           "l120-momenta", "l120-motion", "displacements", "energies"}


def call(command, *arguments):
    return CliRunner().invoke(command, [str(argument) for argument in arguments])


def refused(command, *arguments):
    """The error that a call ends with."""
    outcome = call(command, *arguments)
    assert outcome.exit_code != 0
    return outcome.output if isinstance(outcome.exception, SystemExit) else outcome.exception


def small_limit():
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))


@pytest.mark.slow
def test_plot_of_two_meshes(runs, tmp_path):
    folder = tmp_path / "figures"
    done = corovec("plot", *runs, "--output", folder)
    assert done.returncode == 0 and done.stderr == ""
    names = {path.name for path in folder.iterdir()}
    assert names == {f"{name}.{kind}" for name in SEVERAL for kind in ("svg", "csv")}
    assert {line.rsplit("/", 1)[1] for line in done.stdout.splitlines()} == names
    table = pd.read_csv(folder / "displacements.csv")
    assert set(table["point"]) == {"S"} and set(table["elements"]) == {30, 120}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["total", "$x{", "_a\nb", "\x1b[31mred", "b\udcff"])
def test_plot_of_files_of_any_name(runs, tmp_path, name):
    """Nothing is taken for a formula, a colour, a line end, or the figure of all runs."""
    files = [tmp_path / f"{name}.h5", tmp_path / "other.h5"]
    for file in files:
        shutil.copy(runs[0], file)
    folder = tmp_path / "figures"
    done = call(plot, *map(os.fspath, files), "--output", folder)
    assert done.exit_code == 0, done.exception
    paths = done.output.splitlines()
    assert len(set(paths)) == len(paths) == 2 * len(SEVERAL) and all(map(str.isprintable, paths))
    assert len(list(folder.iterdir())) == len(paths)
    assert set(pd.read_csv(folder / "energies.csv")["run"]) == {printable(name), "other"}


@pytest.mark.slow
def test_plot_refuses_to_replace_before_it_draws(runs, tmp_path):
    (tmp_path / "l30-motion.csv").write_text("mine")
    error = refused(plot, runs[0], "--output", tmp_path)
    assert isinstance(error, ResultFileError) and "l30-motion.csv exists" in str(error)
    assert [path.name for path in tmp_path.iterdir()] == ["l30-motion.csv"]
    assert call(plot, runs[0], "--output", tmp_path, "--overwrite").exit_code == 0
    assert (tmp_path / "l30-motion.csv").read_text() != "mine"


def test_plot_of_an_own_unfinished_run(tmp_path, monkeypatch):
    """A run that is stopped shows what it has; the node that moves farthest is drawn."""
    monkeypatch.setattr(simulation, "MOST", 1)  # every frame is a checkpoint
    monkeypatch.setattr(simulation, "LEAST", 1)
    path, model = tmp_path / "own.h5", cross_code_plate(1)

    def stop(step, n_steps, row):
        if step == 7:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(model, Settings(dt=0.05, end_time=1.0, frame_every=2), output=path, progress=stop)
    assert call(plot, path, "--output", tmp_path, "--interval", 0.1).exit_code == 0
    assert pd.read_csv(tmp_path / "own-energies.csv")["time"].max() == pytest.approx(0.3)
    assert pd.read_csv(tmp_path / "own-motion.csv")["time"].unique() == pytest.approx(
        [0.0, 0.1, 0.2, 0.3])
    moved = np.linalg.norm(Recording.open(path).displacement, axis=2).max()
    table = pd.read_csv(tmp_path / "own-displacements.csv")
    across = table.pivot(index="time", columns="component", values="displacement")
    assert np.linalg.norm(across, axis=1).max() == pytest.approx(moved)
    assert "item" in pd.read_csv(tmp_path / "own-mesh.csv")


@pytest.mark.slow
def test_plot_of_statics(static_path, tmp_path):
    assert call(plot, static_path, "--output", tmp_path, "--format", "png").exit_code == 0
    assert {path.stem for path in tmp_path.iterdir()} == {
        f"cantilever-{name}" for name in ("mesh", "energies", "probes", "motion", "displacements")}


def test_a_run_without_frames(tmp_path):
    path = tmp_path / "start.h5"

    def stop(*_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(cross_code_plate(1), Settings(dt=0.05, end_time=1.0, frame_every=5), output=path,
                 progress=stop)
    for error in (refused(plot, path, "--output", tmp_path),
                  refused(animate, path, "-o", tmp_path / "a.gif")):
        assert isinstance(error, ResultFileError) and "start.h5 holds the start" in str(error)


def test_files_that_are_no_results(runs, tmp_path):
    (tmp_path / "empty.h5").touch()
    (tmp_path / "text.h5").write_text("hello")
    with h5py.File(tmp_path / "foreign.h5", "w") as file:
        file["x"] = 1.0
    (tmp_path / "cut.h5").write_bytes(runs[0].read_bytes()[:50_000])
    for name in ("none", "empty", "text", "foreign", "cut"):
        for error in (refused(plot, tmp_path / f"{name}.h5", "--output", tmp_path / "figures"),
                      refused(animate, tmp_path / f"{name}.h5", "-o", tmp_path / "a.gif")):
            assert isinstance(error, ResultFileError) and f"{name}.h5" in str(error)
    assert "is a directory" in refused(plot, tmp_path)
    assert not (tmp_path / "figures").exists()


@pytest.mark.parametrize("options, message", [
    (("--format", "eps"), "format 'eps' is unknown"),
    (("--interval", 3), "interval 3 is longer than l30, which ends at 1.2"),
    (("--interval", 0), "interval must be positive"),
    (("--at", 1, 2, 9), "l30 (30 elements): no node at [1.0, 2.0, 9.0]"),
    (("--scale", "nan"), "scale must be finite"),
])
def test_plot_says_what_is_wrong(runs, tmp_path, options, message):
    error = refused(plot, runs[0], "--output", tmp_path / "figures", *options)
    assert isinstance(error, InputError) and message in str(error)
    assert not (tmp_path / "figures").exists()


def test_files_that_do_not_go_together(runs, static_path, tmp_path):
    copy, own = tmp_path / "l30.h5", tmp_path / "own.h5"
    shutil.copy(runs[0], copy)
    simulate(cross_code_plate(1), Settings(dt=0.05, end_time=0.2), output=own)
    for other, message in ((copy, "whose names must differ"), (own, "is of l-plate"),
                           (static_path, "is of l-plate")):
        assert message in str(refused(plot, runs[0], other, "--output", tmp_path))
    assert "a run and a static path" in str(refused(plot, own, static_path))


@pytest.mark.slow
def test_a_gif_moves(runs, tmp_path):
    path = tmp_path / "motion.gif"
    done = corovec("animate", runs[0], "-o", path, "--frames", "5", "--fps", "20")
    assert (done.returncode, done.stdout, done.stderr) == (0, f"{path}\n", "")
    with Image.open(path) as film:
        assert film.n_frames == 5 and film.info["duration"] == 50
        pictures = []
        for k in range(5):
            film.seek(k)
            pictures.append(np.asarray(film.convert("RGB"), dtype=float))
    left = slice(0, 500)  # the shell's half of the picture
    for one, two in zip(pictures, pictures[1:]):
        assert np.mean(np.abs(one - two)[:, left].max(axis=2) > 30.0) > 1e-3
    assert [path.name for path in tmp_path.iterdir()] == ["motion.gif"]


@pytest.mark.slow
def test_a_page_holds_all_frames(runs, tmp_path):
    path = tmp_path / "motion.html"
    assert call(animate, runs[0], "-o", path, "--follow", "--view", 40, -30).exit_code == 0
    assert path.read_text().count("data:image/png;base64") == 13


@pytest.mark.slow
def test_an_mp4(runs, tmp_path):
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    path = tmp_path / "motion.mp4"
    assert call(animate, runs[0], "-o", path, "--frames", 6, "--fps", 10).exit_code == 0
    frames, seconds = ffmpeg.count_frames_and_secs(str(path))
    assert frames == 6 and seconds == pytest.approx(0.6, abs=0.05)


def test_an_mp4_without_ffmpeg(runs, tmp_path, monkeypatch):
    monkeypatch.setattr("shutil.which", lambda name: None)
    monkeypatch.setitem(__import__("sys").modules, "imageio_ffmpeg", None)
    error = refused(animate, runs[0], "-o", tmp_path / "a.mp4")
    assert isinstance(error, InputError) and "corovec[mp4]" in str(error)


@pytest.mark.parametrize("name, options, message", [
    ("a.avi", (), "a.avi: the ending of a film must be one of: .gif, .mp4, .html"),
    ("a.gif", ("--fps", 0), "fps must be positive"),
    ("a.gif", ("--fps", 60), "fps must lie in [0.002, 50] in a GIF, is 60"),
    ("a.gif", ("--fps", 1e-3), "fps must lie in [0.002, 50] in a GIF, is 0.001"),
    ("a.gif", ("--frames", 1), "frames must be 2 at least, is 1"),
    ("a.gif", ("--view", "nan", 0), "view must be finite"),
    ("none/a.gif", (), "no folder"),
])
def test_animate_says_what_is_wrong(runs, tmp_path, name, options, message):
    error = refused(animate, runs[0], "-o", tmp_path / name, *options)
    assert isinstance(error, InputError | ResultFileError) and message in str(error)
    assert not list(tmp_path.iterdir())


def test_animate_does_not_replace(runs, tmp_path):
    path = tmp_path / "a.gif"
    path.write_text("mine")
    assert "a.gif exists" in str(refused(animate, runs[0], "-o", path, "--frames", 2))
    assert path.read_text() == "mine"
    assert call(animate, runs[0], "-o", path, "--frames", 2, "--overwrite").exit_code == 0
    assert path.read_bytes()[:3] == b"GIF"


@pytest.mark.slow
def test_a_full_disk_is_one_line(runs, tmp_path):
    """A limit of 20 kB a file stands for it; what was there stays."""
    path = tmp_path / "a.gif"
    path.write_text("mine")
    for arguments, name in ((("animate", runs[0], "-o", path, "--frames", "4", "--overwrite"),
                             "a.gif"),
                            (("plot", runs[0], "--output", tmp_path / "figures"), "l30-mesh.svg")):
        done = corovec(*arguments, preexec_fn=small_limit)
        assert done.returncode == 2 and len(done.stderr.splitlines()) == 1
        assert f"{name} cannot be written: File too large" in done.stderr
    assert path.read_text() == "mine"
    assert {item.name for item in tmp_path.iterdir()} == {"a.gif", "figures"}
    assert not list((tmp_path / "figures").glob("*.part"))


def test_help_starts_without_matplotlib():
    """Start-up stays fast: what draws is loaded when something is drawn."""
    done = corovec("plot", "--help")
    assert "corovec plot run.h5" in done.stdout
    import subprocess
    import sys
    loaded = subprocess.run([sys.executable, "-c", "import sys, reports.cli; print(sorted(set("
                             "sys.modules) & {'matplotlib', 'pandas', 'h5py', 'numpy'}))"],
                            capture_output=True, text=True, check=True)
    assert loaded.stdout.strip() == "[]"


@pytest.mark.slow
def test_plot_of_stresses(tmp_path):
    """The largest von Mises stress of the last frame, where stresses are recorded."""
    run = tmp_path / "stressed.h5"
    simulate(cross_code_plate(1), Settings(dt=0.01, end_time=0.1, stresses=True), output=run)
    done = call(plot, run, "--output", tmp_path / "figures")
    assert done.exit_code == 0, done.exception
    table = pd.read_csv(tmp_path / "figures" / "stressed-von-mises.csv")
    recording = Recording.open(run)
    values = table[["top", "middle", "bottom"]].to_numpy()[::4]
    assert np.allclose(values, recording.contents["von_mises"][-1], rtol=1e-12)
    moved = (recording.nodes + recording.displacement[-1])[recording.quads]
    assert np.allclose(table[["x", "y", "z"]].to_numpy(), moved.reshape(-1, 3))


@pytest.mark.slow
def test_plot_and_film_are_coloured_by_a_stress(tmp_path):
    """The motion, and the last frame; signed colours are even about zero."""
    run, film = tmp_path / "stressed.h5", tmp_path / "film.gif"
    simulate(cross_code_plate(1), Settings(dt=0.02, end_time=0.4, stresses=True), output=run)
    contents = Recording.open(run).contents
    for color, values in (("m_xy", contents["moment"][..., 2]),
                          ("von_mises", contents["von_mises"].max(axis=2))):
        folder = tmp_path / color
        assert call(plot, run, "--output", folder, "--color", color).exit_code == 0
        motion = pd.read_csv(folder / "stressed-motion.csv")
        shown = motion[color].to_numpy()[::4].reshape(-1, values.shape[1])
        assert np.allclose(shown[-1], values[-1], rtol=1e-12) and len(shown) == 8
        assert (folder / "stressed-von-mises.csv").exists()
        assert (folder / "stressed-m-xy.csv").exists() == (color == "m_xy")
    end = pd.read_csv(tmp_path / "m_xy" / "stressed-m-xy.csv")
    assert np.allclose(end["m_xy"].to_numpy()[::4], contents["moment"][-1, :, 2], rtol=1e-12)
    colours = coloured(Recording.open(run), "m_xy")
    assert colours.label == "moment m_xy [N]" and colours.values.min() < 0.0
    assert colours.scale.norm.vmin == -colours.scale.norm.vmax
    assert call(animate, run, "-o", film, "--frames", 3, "--color", "q_xz").exit_code == 0


@pytest.mark.parametrize("color, message", [
    ("n_xx", "color n_xx: l30 has no stresses, run it with --stresses"),
    ("n_x", "color 'n_x' is unknown, must be one of: strain_energy_density, von_mises, n_xx"),
])
def test_colours_that_are_not_there(runs, tmp_path, color, message):
    for error in (refused(plot, runs[0], "--output", tmp_path / "figures", "--color", color),
                  refused(animate, runs[0], "-o", tmp_path / "a.gif", "--color", color)):
        assert isinstance(error, InputError) and message in str(error)
    assert not list(tmp_path.iterdir())


def test_energies_show_damping_and_supports_that_move(tmp_path):
    """Where there are any: a plate that is shaken has two more curves."""
    plate = cross_code_plate(1)
    shaken = replace(plate, normals=None, damping=Damping(mass=1.0), supports=[
        Drive((0, 1), (0.0, 0.0, 0.1), history=Harmonic(1.0))])
    for model, more in ((plate, []), (shaken, ["support work", "dissipated"])):
        result = simulate(model, Settings(dt=0.05, end_time=0.5))
        figure, data = energies(result.history)
        words = [text.get_text() for text in figure.legends[0].get_texts()]
        assert words == ["total energy", "external work", "kinetic energy", "strain energy", *more]
        assert len(data.columns) == 5 + len(more)
    assert np.array_equal(data["dissipated"], result.history["dissipated"])


def test_reactions_and_probes_are_drawn(tmp_path):
    """A panel for each that is there, with every step in the CSV; none where there is nothing."""
    shell = cross_code_plate(1)
    path = tmp_path / "run.h5"
    held = Support(tuple(range(3)), ("x", "y", "z", "px", "py", "pz"))
    model = replace(shell, supports=[held], loads=[Gravity((0.0, 0.0, -9.81))])
    history = simulate(model, Settings(dt=0.01, end_time=0.1), output=path, probes={
        "tip": 5, "root": StressProbe(0), "all": EnergyProbe()}).history
    figures = gallery([Recording.open(path)])
    figure, table = figures["run-probes"]()
    assert len(figure.axes) == 2 + 2 + 4 + 1 and len(table) == 11
    assert np.array_equal(table["tip_u_z"], history["tip_u"][:, 2])
    assert np.array_equal(table["reaction_z"], history["reaction"][:, 2])
    assert figure.axes[2].get_ylabel().endswith("[J]")  # all, root, tip
    simulate(shell, Settings(dt=0.01, end_time=0.1), output=tmp_path / "free.h5")
    assert "free-probes" not in gallery([Recording.open(tmp_path / "free.h5")])
