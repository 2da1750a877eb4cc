"""Result files: safe against kills, bit-for-bit resume, readable by VTK."""

import errno
import os
import resource
import signal
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest

from corovec import (
    InputError,
    Newton,
    ResultFileError,
    ResultFileWarning,
    Scheme,
    Settings,
    StaticSettings,
    StepError,
    arc_length,
    data_frame,
    line_load,
    load_control,
    read,
    simulate,
    warm_up,
)
from corovec.benchmarks import load_case
from corovec.solver.dynamics import simulation
from corovec.solver.results import recorder
from corovec.solver.statics import arc_length as statics
from corovec.verification.fuzz.kills import assert_same_bits
from corovec.verification.helpers import COMMAND, corovec, in_process, read_killed, vtk_frames
from corovec.verification.models import cross_code_plate
from corovec.verification.shells import roof, strip

RUN = ("run", "l-plate", "--elements", "30", "--dt", "1e-3", "--end-time", "4",
       "--frame-every", "25")

STATIC_RUN = """
import sys, time
import numpy as np
from corovec import StaticSettings, arc_length, line_load, load_control
from corovec.solver.statics import arc_length as statics
from corovec.verification.shells import roof, strip

method, path = sys.argv[1:]
statics.ROOM = 2
if method == "load control":
    model, _ = strip(10.0, 16, lambda X, tip: line_load(X, tip, (0.0, 0.0, 40.0)))
    load_control(model, np.linspace(0.04, 1.0, 25), StaticSettings(max_iterations=4),
                 progress=lambda *_: time.sleep(0.03), output=path, resume=True)
else:
    arc_length(roof(4, 12.7), 2.0, lambda factor, u: time.sleep(0.03) or u[0, 2] < -26.0,
               output=path, resume=True)
"""
"""Both take steps of changing length: load control divides its first rows up to 11 times, the arc
passes a limit point, and outgrows the room of its file three times."""


@pytest.fixture
def model():
    return cross_code_plate(1)


def kill(command, path, target):
    """Run ``command`` and SIGKILL it as soon as ``path`` has recorded ``target`` steps."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 300.0
    while time.monotonic() < deadline and process.poll() is None:
        try:
            if read_killed(path)["step"] >= target:
                break
        except ResultFileError:
            pass  # not there yet, or being written at this instant
        time.sleep(0.005)
    assert process.poll() is None, "the run ended before it could be killed"
    process.send_signal(signal.SIGKILL)
    process.wait()
    contents = read_killed(path)
    assert target <= contents["step"] == len(contents["history"]) - 1
    assert np.all(np.isfinite(contents["displacement"]))
    return contents


def test_killed_run_resumes_bit_for_bit(tmp_path):
    """SIGKILL in the middle, twice; the file opens each time and ends as if nothing happened."""
    whole, killed = tmp_path / "whole.h5", tmp_path / "killed.h5"
    assert corovec(*RUN, "--output", str(whole)).returncode == 0
    for target in (300, 1100):
        resume = ["--resume"] if killed.exists() else []
        assert kill([COMMAND, *RUN, "--output", str(killed), *resume], killed,
                    target)["step"] < 4000
        info = in_process("info", str(killed))
        assert info.returncode == 0 and "steps planned          4000" in info.stdout
    assert corovec(*RUN, "--output", str(killed), "--resume").returncode == 0
    assert_same_bits(whole, killed)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["load control", "arc length"])
def test_killed_static_run_resumes_bit_for_bit(tmp_path, method):
    whole, killed = tmp_path / "whole.h5", tmp_path / "killed.h5"
    run = [sys.executable, "-c", STATIC_RUN, method]
    assert subprocess.run([*run, whole]).returncode == 0
    assert kill([*run, killed], killed, 4)["step"] < read(whole)["step"]
    assert subprocess.run([*run, killed]).returncode == 0
    assert_same_bits(whole, killed)


def often(monkeypatch):
    """Every frame is a checkpoint."""
    monkeypatch.setattr(simulation, "MOST", 1)
    monkeypatch.setattr(simulation, "LEAST", 1)


def test_damaged_newest_checkpoint_falls_back(tmp_path, model, monkeypatch):
    """A torn checkpoint is noticed by its checksum; the other slot resumes, bit for bit."""
    monkeypatch.setattr(recorder, "WAIT", 0.0)  # each frame at once
    often(monkeypatch)
    settings = Settings(dt=0.01, end_time=1.0, frame_every=10)
    whole, torn = tmp_path / "whole.h5", tmp_path / "torn.h5"
    simulate(model, settings, output=whole)
    simulate(model, settings, output=torn)
    with h5py.File(torn, "r+") as file:
        newest = int(np.argmax(file["checkpoint/stamp"][:, 0]))
        file["checkpoint/state"][newest, 700] += 1.0
    with pytest.warns(ResultFileWarning, match="torn.h5: what follows step 90 is damaged"):
        assert read(torn)["step"] == 90
    with pytest.warns(ResultFileWarning, match="torn.h5: what follows step 90 is damaged"):
        simulate(model, settings, output=torn, resume=True)
    assert_same_bits(whole, torn)


def test_both_checkpoints_damaged(tmp_path, model):
    path = tmp_path / "run.h5"
    simulate(model, Settings(dt=0.01, end_time=0.1), output=path)
    with h5py.File(path, "r+") as file:
        file["checkpoint/state"][:, 0] = 7.0
    with pytest.raises(ResultFileError, match="neither of its two checkpoints is intact"):
        simulate(model, Settings(dt=0.01, end_time=0.1), output=path, resume=True)


def test_file_holds_the_result(tmp_path, model):
    """What is read back is what the run returned; frames stand at their steps."""
    path = tmp_path / "run.h5"
    settings = Settings(dt=0.01, end_time=0.5, frame_every=20)
    result = simulate(model, settings, output=path)
    contents = read(path)
    assert np.array_equal(contents["history"], result.history)
    assert contents["frame_steps"].tolist() == [0, 20, 40, 50]
    assert np.array_equal(contents["displacement"][-1], result.displacement)
    assert np.array_equal(contents["normal"][-1], result.normals)
    assert np.all(contents["displacement"][0] == 0.0)
    strain = contents["strain_energy"].sum(axis=1)
    rows = result.history["strain_energy"][contents["frame_steps"]]
    assert np.allclose(strain, rows, rtol=1e-13)
    assert contents["description"]["solver"] == result.solver == "skyline"
    assert contents["description"]["versions"]["numpy"] == np.__version__


@pytest.mark.parametrize("last", [50, 35])
def test_vtk_reads_the_frames(tmp_path, model, last, monkeypatch):
    """VTK's own reader sees the mesh, the time steps and the same numbers, of a run that is
    interrupted too."""
    often(monkeypatch)
    path = tmp_path / "run.h5"

    def interrupts(step, n_steps, row):
        if step == last:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(model, Settings(dt=0.01, end_time=0.5, frame_every=10), output=path,
                 progress=interrupts)
    contents = read(path)
    assert len(contents["frame_steps"]) == last // 10 + 1
    times = 0.01 * contents["frame_steps"]
    for k, (time_, points, arrays) in enumerate(vtk_frames(path, times)):
        assert time_ == times[k]
        assert np.array_equal(points, model.nodes)
        assert arrays.keys() == {"displacement", "normal", "strain_energy"}
        for name, values in arrays.items():
            assert np.array_equal(values, contents[name][k])


def bending(factors, **options):
    """Load control of a strip under an end shear of 40 N/m."""
    model, _ = strip(10.0, 16, lambda X, tip: line_load(X, tip, (0.0, 0.0, 40.0)))
    return load_control(model, factors, **options)


def snap_through(**options):
    """Arc length of a shallow roof whose load falls between two limit points."""
    return arc_length(roof(4, 12.7), 2.0, lambda factor, u: u[0, 2] < -26.0, **options)


def test_static_file_holds_the_result(tmp_path):
    """A row and a frame for zero load and every factor; VTK shows the factors as time."""
    path, factors = tmp_path / "run.h5", (0.1, 0.3, 0.6, 1.0)
    result = bending(factors, output=path)
    assert_holds(path, result, 1)
    contents = read(path)
    assert contents["step"] == contents["n_steps"] == 4
    assert contents["history"]["factor"].tolist() == [0.0, *factors]
    # dead end shear of 40 N/m over a width of 1 m
    assert np.allclose(contents["history"]["reaction"][:, 2],
                       -40.0 * contents["history"]["factor"], atol=1e-6)
    assert_shown(path, contents["history"]["factor"])
    again = bending(factors, output=path, resume=True)
    for name in ("factors", "displacement", "normals", "strain_energy", "reactions", "iterations",
                 "steps", "indefinite", "solver"):
        assert np.array_equal(getattr(again, name), getattr(result, name)), name
    assert again.works == ()


def test_arc_length_outgrows_its_file(tmp_path, monkeypatch):
    """The file moves into longer ones without losing a row; VTK finds each frame by its number,
    also where the factor falls."""
    path = tmp_path / "run.h5"
    monkeypatch.setattr(statics, "ROOM", 2)
    result = snap_through(output=path)
    assert np.any(np.diff(result.factors) < 0.0)
    assert_holds(path, result, 0)
    contents = read(path)
    assert contents["n_steps"] == 23 and contents["step"] == len(result.factors) - 1 == 19
    assert_shown(path, np.arange(len(result.factors)))
    assert os.listdir(tmp_path) == ["run.h5"]
    info = in_process("info", str(path))
    assert f"largest factor         {result.factors.max():.6g}" in info.stdout
    assert "steps planned" not in info.stdout


def assert_holds(path, result, first):
    """The rows of a static result, which begin with row ``first`` of its file."""
    contents = read(path)
    history = contents["history"][first:]
    for name, values in (("factor", result.factors), ("strain_energy", result.strain_energy),
                         ("reaction", result.reactions.sum(axis=1)), ("steps", result.steps),
                         ("iterations", result.iterations)):
        assert np.array_equal(history[name], values), name
    for name, values in (("displacement", result.displacement), ("normal", result.normals),
                         ("reaction", result.reactions)):
        assert np.array_equal(contents[name][first:], values), name
    assert np.allclose(contents["strain_energy"].sum(axis=1), contents["history"]["strain_energy"],
                       rtol=1e-13)
    assert history["indefinite"].sum() == result.indefinite


def assert_shown(path, times):
    """VTK shows every frame of a static file at its time."""
    contents = read(path)
    for k, (time_, points, arrays) in enumerate(vtk_frames(path, times)):
        assert time_ == times[k] and np.array_equal(points, contents["nodes"])
        assert arrays.keys() == {"displacement", "normal", "reaction", "reaction_moment",
                                 "strain_energy"}
        for name, values in arrays.items():
            assert np.array_equal(values, contents[name][k]), name


def test_static_file_keeps_the_rows_before_a_failure(tmp_path):
    """Load control stops at the limit point, at 0.738 on this mesh; info summarises the rest."""
    path = tmp_path / "run.h5"
    with pytest.raises(StepError, match="no equilibrium found beyond"):
        load_control(roof(4, 12.7), [0.5, 0.7, 0.9], StaticSettings(max_divisions=2), output=path)
    assert read(path)["history"]["factor"].tolist() == [0.0, 0.5, 0.7]
    info = in_process("info", str(path))
    for line in ("method                 load control", "steps                  2",
                 "steps planned          3", "factor                 0.7",
                 "factors                3 from 0.5 to 0.9 "):
        assert "  " + line in info.stdout
    assert "reaction               (" in info.stdout and info.stdout.count(") N\n") == 1


def test_static_file_is_not_overwritten_or_mixed_up(tmp_path, model):
    """Every difference is named: the method, the factors, the first arc length."""
    path, factors = tmp_path / "run.h5", [0.5, 1.0]
    path.write_bytes(b"precious")
    for run in (snap_through, lambda **options: bending(factors, **options)):
        with pytest.raises(ResultFileError, match="overwrite replaces it, resume continues"):
            run(output=path)
        with pytest.raises(InputError, match="resume and overwrite exclude each other"):
            run(output=path, resume=True, overwrite=True)
    assert path.read_bytes() == b"precious"
    bending(factors, output=path, overwrite=True)
    with pytest.raises(ResultFileError, match="factors is 2 from 0.5 to 1 .* there and 3 from"):
        bending([0.5, 0.7, 1.0], output=path, resume=True)
    with pytest.raises(ResultFileError, match="method is load control there and arc length here"):
        snap_through(output=path, resume=True)
    with pytest.raises(ResultFileError, match="dt is None there and 0.01 here"):
        simulate(model, Settings(dt=0.01, end_time=0.1), output=path, resume=True)
    arc_length(roof(4, 12.7), 2.0, lambda factor, u: True, output=path, overwrite=True)
    with pytest.raises(ResultFileError, match="length is 2.0 there and 3.0 here"):
        arc_length(roof(4, 12.7), 3.0, lambda factor, u: True, output=path, resume=True)


def test_arc_length_goes_on_to_another_end(tmp_path):
    """Resumed with a farther end, the path is that of one run."""
    path, whole = tmp_path / "run.h5", tmp_path / "whole.h5"
    arc_length(roof(4, 12.7), 2.0, lambda factor, u: u[0, 2] < -13.0, output=path)
    before = read(path)["step"]
    result, reference = snap_through(output=path, resume=True), snap_through(output=whole)
    assert 1 < before < len(result.factors) - 1
    assert np.array_equal(result.displacement, reference.displacement)
    assert_same_bits(whole, path)


def test_two_static_runs_do_not_share_a_file(tmp_path):
    path = tmp_path / "run.h5"

    def takes_over(factor, last):
        if factor == 0.5:
            bending([0.25, 0.75], output=path, overwrite=True)

    with pytest.raises(ResultFileError, match="taken over by another run; this one stops"):
        bending([0.5, 1.0], output=path, progress=takes_over)
    assert read(path)["history"]["factor"].tolist() == [0.0, 0.25, 0.75]


def test_no_room_for_a_longer_file(tmp_path, monkeypatch):
    """A disk that fills up while a path grows: one clear line, and the rows so far are kept."""
    path = tmp_path / "run.h5"
    monkeypatch.setattr(statics, "ROOM", 4)

    def fills_up(factor, u):
        monkeypatch.setattr(recorder, "claim", no_space)

    def no_space(path, size):
        raise OSError(errno.ENOSPC, "full")

    with pytest.raises(ResultFileError, match="cannot be written after step 5: No space left"):
        arc_length(roof(4, 12.7), 2.0, fills_up, output=path)
    contents = read(path)
    assert contents["step"] == 4 and len(contents["displacement"]) == 5
    assert os.listdir(tmp_path) == ["run.h5"]
    with pytest.raises(ResultFileError, match="cannot be created: No space left"):
        bending([1.0], output=tmp_path / "other.h5")
    assert os.listdir(tmp_path) == ["run.h5"]


def test_space_claimed_covers_the_file(tmp_path, monkeypatch, model):
    """What is claimed before writing is no less than what the file takes."""
    claimed, claim = [], recorder.claim

    def noted(path, size):
        claimed.append(size)
        claim(path, size)

    monkeypatch.setattr(recorder, "claim", noted)
    monkeypatch.setattr(statics, "ROOM", 4)
    simulate(model, Settings(dt=0.01, end_time=0.5), output=tmp_path / "a.h5")
    bending(np.linspace(0.1, 1.0, 10), output=tmp_path / "b.h5")
    snap_through(output=tmp_path / "c.h5")
    before, after = np.array(claimed[::2]), np.array(claimed[1::2])
    assert len(before) == 5 and np.all(before >= after)
    assert np.all(before <= after + recorder.METADATA)
    # and a run writes into the space that its file has from the first moment on
    assert [os.path.getsize(tmp_path / name) for name in ("a.h5", "b.h5", "c.h5")] == [
        after[0], after[1], after[4]]


def test_existing_file_is_not_overwritten(tmp_path, model):
    path = tmp_path / "run.h5"
    path.write_bytes(b"precious")
    settings = Settings(dt=0.01, end_time=0.1)
    with pytest.raises(ResultFileError, match="overwrite replaces it, resume continues"):
        simulate(model, settings, output=path)
    with pytest.raises(ResultFileError, match="damaged or not a result file"):
        simulate(model, settings, output=path, resume=True)
    assert path.read_bytes() == b"precious"
    simulate(model, settings, output=path, overwrite=True)
    assert read(path)["step"] == 10


def test_other_nested_settings_are_refused_by_name(tmp_path, model):
    path = tmp_path / "run.h5"
    simulate(model, Settings(dt=0.01, end_time=0.1), output=path)
    with pytest.raises(ResultFileError, match="newton.tolerance is 1e-06 there and 1e-08 here"):
        simulate(model, Settings(dt=0.01, end_time=0.1, newton=Newton(tolerance=1e-8)),
                 output=path, resume=True)


def test_foreign_file_is_refused(tmp_path, model):
    path = tmp_path / "foreign.h5"
    with h5py.File(path, "w") as file:
        file["data"] = [1, 2, 3]
    before = path.read_bytes()
    with pytest.raises(ResultFileError, match="^[^ ]*foreign.h5 was not written by this"):
        simulate(model, Settings(dt=0.01, end_time=0.1), output=path, resume=True)
    assert path.read_bytes() == before


def test_truncated_file_is_refused(tmp_path, model):
    path = tmp_path / "run.h5"
    settings = Settings(dt=0.01, end_time=0.1)
    simulate(model, settings, output=path)
    path.write_bytes(path.read_bytes()[:5000])
    with pytest.raises(ResultFileError, match="damaged or not a result file"):
        simulate(model, settings, output=path, resume=True)


def test_file_of_other_parameters_is_refused(tmp_path, model):
    """The message names what differs: a setting, or the model."""
    path = tmp_path / "run.h5"
    simulate(model, Settings(dt=0.01, end_time=0.2), output=path)
    message = "^[^ ]*run.h5 is from other parameters: dt is 0.01 there and 0.02 here"
    with pytest.raises(ResultFileError, match=message):
        simulate(model, Settings(dt=0.02, end_time=0.2), output=path, resume=True)
    other = cross_code_plate(1, youngs=2e6)
    with pytest.raises(ResultFileError, match="other parameters: its model is another one"):
        simulate(other, Settings(dt=0.01, end_time=0.2), output=path, resume=True)


def limit_file_size():
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000))


def test_no_room_for_the_file(tmp_path):
    """All space is taken when the file is made: a full disk is one clear line, before any work."""
    path = tmp_path / "run.h5"
    warm_up()  # compiled kernels would not fit either
    done = corovec(*RUN, "--output", str(path), preexec_fn=limit_file_size)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1 and "cannot be created" in done.stderr
    assert "Traceback" not in done.stderr
    assert os.listdir(tmp_path) == []


def test_two_runs_do_not_share_a_file(tmp_path, model):
    """The run that comes second owns the file; the first stops at its next write, and says so."""
    path = tmp_path / "run.h5"
    settings = Settings(dt=0.01, end_time=0.4, frame_every=10)

    def takes_over(step, n_steps, row):
        if step == 15:
            simulate(model, Settings(dt=0.01, end_time=0.4, frame_every=10,
                                     scheme=Scheme(rho_inf=0.5)),
                     output=path, overwrite=True)

    with pytest.raises(ResultFileError, match="taken over by another run; this one stops"):
        simulate(model, settings, output=path, progress=takes_over)
    contents = read(path)
    assert contents["description"]["settings"]["scheme"]["rho_inf"] == 0.5
    assert contents["step"] == 40

    def resumes(step, n_steps, row):
        if step == 15:
            simulate(model, settings, output=path, resume=True)

    with pytest.raises(ResultFileError, match="taken over by another run"):
        simulate(model, settings, output=path, overwrite=True, progress=resumes)
    with pytest.raises(ResultFileError, match="has vanished"):
        simulate(model, settings, output=path, overwrite=True,
                 progress=lambda step, n, row: path.unlink(missing_ok=True))


def test_only_regular_files_are_replaced(tmp_path, model):
    """A device, a folder or a link is refused, a neighbour X.part not touched."""
    settings = Settings(dt=0.01, end_time=0.1)
    for other in ("/dev/null", tmp_path):
        with pytest.raises(ResultFileError, match="is not a regular file"):
            simulate(model, settings, output=other, overwrite=True)
    target, link, part = tmp_path / "run.h5", tmp_path / "link.h5", tmp_path / "run.h5.part"
    part.write_bytes(b"precious")
    for there in (False, True):
        link.unlink(missing_ok=True)
        link.symlink_to(target)
        for options in ({}, {"overwrite": True}, {"resume": True}):
            with pytest.raises(ResultFileError, match="link.h5 is a symbolic link"):
                simulate(model, settings, output=link, **options)
        assert target.exists() == there
        simulate(model, settings, output=target, overwrite=True)
    assert read(link)["step"] == 10
    assert part.read_bytes() == b"precious"
    assert sorted(os.listdir(tmp_path)) == ["link.h5", "run.h5", "run.h5.part"]


@pytest.mark.parametrize("output", [5, "", "a\0b", "x" * 300])
def test_output_that_is_no_path(model, output):
    with pytest.raises((InputError, ResultFileError),
                       match="^('.* is not a path of a file|output must be a path)"):
        simulate(model, Settings(dt=0.01, end_time=0.1), output=output)


def test_kill_before_the_first_step_resumes(tmp_path, model):
    """From the moment it exists, the file has a checkpoint."""
    path = tmp_path / "run.h5"
    settings = Settings(dt=0.01, end_time=0.2, frame_every=10)

    def dies(step, n_steps, row):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(model, settings, output=path, progress=dies)
    assert read(path)["step"] == 0
    simulate(model, settings, output=path, resume=True)
    whole = tmp_path / "whole.h5"
    simulate(model, settings, output=whole)
    assert_same_bits(whole, path)


def test_folder_that_does_not_exist(tmp_path, model):
    with pytest.raises(ResultFileError, match="run.h5 cannot be created: no folder .*no$"):
        simulate(model, Settings(dt=0.01, end_time=0.1), output=tmp_path / "no" / "run.h5")


def test_unknown_settings_are_refused_before_anything(tmp_path):
    with pytest.raises(InputError, match="name 'verlet' is unknown"):
        Settings(dt=0.01, end_time=0.1, scheme=Scheme("verlet"))


def test_every_case_describes_itself():
    """A result names its case, mesh, settings, versions and machine."""
    model = load_case("l-plate").model(30)
    from corovec.solver.runtime.provenance import describe
    text = describe(model, Settings(dt=0.1, end_time=0.1), "banded", "l-plate")
    assert text["settings"]["newton"] == {"kind": "modified", "tolerance": 1e-6,
                                          "min_iterations": 3, "max_iterations": 20}
    assert len(text["fingerprint"]) == 64 and text["machine"]["processor"]


def test_a_history_becomes_a_data_frame(tmp_path, model):
    """Every column, vectors by their components; of a run, its file and a static path."""
    result = simulate(model, Settings(dt=0.01, end_time=0.1), output=tmp_path / "run.h5")
    table = result.frame()
    assert len(table) == 11 and np.array_equal(table["time"], result.history["time"])
    for k, c in enumerate("xyz"):
        assert np.array_equal(table[f"angular_momentum_{c}"],
                              result.history["angular_momentum"][:, k])
    assert len(table.columns) == len(result.history.dtype.names) + 2 * 7  # seven vectors
    assert table.equals(data_frame(read(tmp_path / "run.h5")["history"])[table.columns])
    for wrong in (None, "run.h5", read(tmp_path / "run.h5"), result):
        with pytest.raises(InputError, match=r"history must be that of a result, as read\(path\)"
                           r'\["history"\], is '):
            data_frame(wrong)


def test_a_static_path_becomes_a_data_frame(tmp_path):
    result = bending([0.5, 1.0], output=tmp_path / "run.h5")
    stored = data_frame(read(tmp_path / "run.h5")["history"])[1:].reset_index(drop=True)
    table = result.frame()
    assert list(table.columns) == [name for name in stored.columns
                                   if name not in ("indefinite", "next_step")]
    np.testing.assert_allclose(table, stored[table.columns], rtol=1e-14, atol=0.0)


# ------------------------------------------------------------------ checkpoints and frames


def test_frames_do_not_touch_the_solver(model, monkeypatch):
    """A run has the same bits with many frames as with few, unless each is a checkpoint: there the
    factorization is dropped, in memory as in a file."""
    def last(frame_every):
        return simulate(model, Settings(0.01, 0.5, frame_every=frame_every)).displacement

    few = last(50)
    assert np.array_equal(last(5), few)
    often(monkeypatch)
    assert not np.array_equal(last(5), few)


def test_frames_since_the_last_checkpoint_wait_for_the_next(tmp_path, model):
    """A run that is stopped keeps what is before its last checkpoint, and goes on from there to the
    same bits; one that fails keeps all its frames."""
    whole, path = tmp_path / "whole.h5", tmp_path / "run.h5"
    settings = Settings(0.01, 4.0, frame_every=10)
    simulate(model, settings, output=whole)

    def stop(kind):
        def progress(step, *_):
            if step == 255:
                raise kind("stopped")
        return progress

    with pytest.raises(KeyboardInterrupt):
        simulate(model, settings, output=path, progress=stop(KeyboardInterrupt))
    assert read(path)["step"] == 200
    simulate(model, settings, output=path, resume=True)
    assert_same_bits(whole, path)
    failed = tmp_path / "failed.h5"
    with pytest.raises(StepError):
        simulate(model, settings, output=failed, progress=stop(StepError))
    assert read(failed)["step"] == 250
    simulate(model, settings, output=failed, resume=True)  # from a state that is that of its frame
    with h5py.File(whole) as one, h5py.File(failed) as other:
        assert np.allclose(one["frames/displacement"], other["frames/displacement"], rtol=1e-8,
                           atol=1e-9)
