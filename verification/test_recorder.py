"""Result files: safe against kills, bit-for-bit resume, readable by VTK."""

import os
import resource
import signal
import subprocess
import time

import h5py
import numpy as np
import pytest

from solver import InputError, ResultFileError, Settings, read, simulate
from solver.cases import load_case
from verification.helpers import COMMAND, corovec
from verification.models import cross_code_plate

RUN = ("run", "l-plate", "--elements", "30", "--dt", "1e-3", "--end-time", "2",
       "--frame-every", "25")

def datasets(path):
    """Every dataset of a file but those that only say where and when it was written."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.update({name: item[...]})
                        if isinstance(item, h5py.Dataset) else None)
        found["NSteps"] = file["VTKHDF/Steps"].attrs["NSteps"]
    return found


def assert_same_bits(first, second):
    a, b = datasets(first), datasets(second)
    assert a.keys() == b.keys()
    for name in a:
        assert np.asarray(a[name]).tobytes() == np.asarray(b[name]).tobytes(), name


@pytest.fixture
def model():
    return cross_code_plate(1)


def test_killed_run_resumes_bit_for_bit(tmp_path):
    """SIGKILL in the middle, twice; the file opens each time and ends as if nothing happened."""
    whole, killed = tmp_path / "whole.h5", tmp_path / "killed.h5"
    assert corovec(*RUN, "--output", str(whole)).returncode == 0
    for target in (300, 1100):
        process = subprocess.Popen(
            [COMMAND, *RUN, "--output", str(killed),
             *(["--resume"] if killed.exists() else [])],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        deadline = time.monotonic() + 60.0
        while time.monotonic() < deadline and process.poll() is None:
            try:
                if read(killed)["step"] >= target:
                    break
            except ResultFileError:
                pass  # not there yet, or being written at this instant
            time.sleep(0.005)
        assert process.poll() is None, "the run ended before it could be killed"
        process.send_signal(signal.SIGKILL)
        process.wait()
        contents = read(killed)
        assert target <= contents["step"] < 2000
        assert len(contents["history"]) == contents["step"] + 1
        assert np.all(np.isfinite(contents["displacement"]))
        info = corovec("info", str(killed))
        assert info.returncode == 0 and "steps planned          2000" in info.stdout
    assert corovec(*RUN, "--output", str(killed), "--resume").returncode == 0
    assert_same_bits(whole, killed)


def test_damaged_newest_checkpoint_falls_back(tmp_path, model):
    """A torn checkpoint is noticed by its checksum; the other slot resumes, bit for bit."""
    settings = Settings(dt=0.01, end_time=1.0, frame_every=10)
    whole, torn = tmp_path / "whole.h5", tmp_path / "torn.h5"
    simulate(model, settings, output=whole)
    simulate(model, settings, output=torn)
    with h5py.File(torn, "r+") as file:
        newest = int(np.argmax(file["checkpoint/stamp"][:, 0]))
        file["checkpoint/state"][newest, 700] += 1.0
    assert read(torn)["step"] == 90
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
    assert contents["description"]["solver"] == result.solver == "banded"
    assert contents["description"]["versions"]["numpy"] == np.__version__


def test_vtk_reads_the_frames(tmp_path, model):
    """VTK's own reader (ParaView's) sees the mesh, the time steps and the same numbers."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import vtkDataObject
    from vtkmodules.vtkIOHDF import vtkHDFReader
    path = tmp_path / "run.h5"
    simulate(model, Settings(dt=0.01, end_time=0.5, frame_every=10), output=path)
    contents, reader = read(path), vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == 6
    for k in (0, 3, 5):
        reader.SetStep(k)
        reader.Update()
        grid = reader.GetOutputDataObject(0)
        assert grid.GetNumberOfCells() == 30 and grid.GetNumberOfPoints() == 48
        assert grid.GetInformation().Get(vtkDataObject.DATA_TIME_STEP()) == pytest.approx(0.1 * k)
        points, cells = grid.GetPointData(), grid.GetCellData()
        for name in ("displacement", "normal"):
            assert np.array_equal(vtk_to_numpy(points.GetArray(name)), contents[name][k])
        assert np.array_equal(vtk_to_numpy(cells.GetArray("strain_energy")),
                              contents["strain_energy"][k])
        assert np.array_equal(vtk_to_numpy(grid.GetPoints().GetData()), model.nodes)


def test_existing_file_is_not_overwritten(tmp_path, model):
    path = tmp_path / "run.h5"
    path.write_bytes(b"precious")
    settings = Settings(dt=0.01, end_time=0.1)
    with pytest.raises(ResultFileError, match="exists: use --overwrite .* or --resume"):
        simulate(model, settings, output=path)
    with pytest.raises(ResultFileError, match="damaged or not a result file"):
        simulate(model, settings, output=path, resume=True)
    assert path.read_bytes() == b"precious"
    simulate(model, settings, output=path, overwrite=True)
    assert read(path)["step"] == 10


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
            simulate(model, Settings(dt=0.01, end_time=0.4, frame_every=10, rho_inf=0.5),
                     output=path, overwrite=True)

    with pytest.raises(ResultFileError, match="taken over by another run; this one stops"):
        simulate(model, settings, output=path, progress=takes_over)
    assert read(path)["description"]["settings"]["rho_inf"] == 0.5 and read(path)["step"] == 40

    def resumes(step, n_steps, row):
        if step == 15:
            simulate(model, settings, output=path, resume=True)

    with pytest.raises(ResultFileError, match="taken over by another run"):
        simulate(model, settings, output=path, overwrite=True, progress=resumes)
    with pytest.raises(ResultFileError, match="has vanished"):
        simulate(model, settings, output=path, overwrite=True,
                 progress=lambda step, n, row: path.unlink(missing_ok=True))


def test_only_regular_files_are_replaced(tmp_path, model):
    """A device or folder is refused, a link followed, a neighbour X.part not touched."""
    settings = Settings(dt=0.01, end_time=0.1)
    for other in ("/dev/null", tmp_path):
        with pytest.raises(ResultFileError, match="is not a regular file"):
            simulate(model, settings, output=other, overwrite=True)
    target, link, part = tmp_path / "run.h5", tmp_path / "link.h5", tmp_path / "run.h5.part"
    part.write_bytes(b"precious")
    link.symlink_to(target)
    simulate(model, settings, output=link)
    assert link.is_symlink() and read(target)["step"] == 10
    assert part.read_bytes() == b"precious"
    assert sorted(os.listdir(tmp_path)) == ["link.h5", "run.h5", "run.h5.part"]


@pytest.mark.parametrize("output", [5, "", "a\0b", "x" * 300])
def test_output_that_is_no_path(model, output):
    with pytest.raises(ResultFileError, match="^'.*' is not a path of a file"):
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
    with pytest.raises(InputError, match="scheme 'verlet' is unknown"):
        Settings(dt=0.01, end_time=0.1, scheme="verlet")


def test_every_case_describes_itself():
    """A result names its case, mesh, settings, versions and machine."""
    model = load_case("l-plate").model(30)
    from solver.simulation import describe
    text = describe(model, Settings(dt=0.1, end_time=0.1), "banded", "l-plate")
    assert text["settings"]["tolerance"] == 1e-6 and text["settings"]["min_iterations"] == 3
    assert len(text["fingerprint"]) == 64 and text["machine"]["processor"]
