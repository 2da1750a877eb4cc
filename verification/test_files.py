"""Files that are written: their mode and owner, what is refused, and memory and disks that are too
small, each told in one line before long work begins."""

import errno
import os
import signal
import stat
import tempfile
from contextlib import contextmanager
from dataclasses import replace

import pytest

from corovec import InputError, ResultFileError, Settings, simulate
from corovec.benchmarks import load_case
from corovec.reports.cli import animate
from corovec.solver.dynamics.simulation import _check_frames, check_run
from corovec.solver.results.files import folder_path, replacing, writable_folder, writable_path
from corovec.solver.runtime import memory
from corovec.verification.helpers import in_process
from corovec.verification.models import cross_code_plate

MODEL = cross_code_plate(1)

SETTINGS = Settings(dt=0.01, end_time=0.02)


def mode(path):
    return stat.S_IMODE(path.stat().st_mode)


def full(*_, **__):
    raise OSError(errno.ENOSPC, "full")


@pytest.fixture
def no_umask(monkeypatch):
    """The umask of the process, other threads' too, is not touched."""
    def touched(mask):
        raise AssertionError("umask")

    monkeypatch.setattr(os, "umask", touched)


@pytest.mark.parametrize("mask", [0o022, 0o077])
def test_new_file_has_the_mode_of_a_new_file(tmp_path, monkeypatch, mask):
    old = os.umask(mask)
    try:
        monkeypatch.setattr(os, "umask", full)
        simulate(MODEL, SETTINGS, output=tmp_path / "run.h5")
        with replacing(tmp_path / "text") as partial:
            partial.write_text("new")
    finally:
        monkeypatch.undo()
        os.umask(old)
    assert mode(tmp_path / "run.h5") == mode(tmp_path / "text") == 0o666 & ~mask


@pytest.mark.parametrize("kept", [0o600, 0o640, 0o666])
def test_replaced_file_keeps_its_mode(tmp_path, no_umask, kept):
    path = tmp_path / "run.h5"
    path.write_text("old")
    path.chmod(kept)
    simulate(MODEL, SETTINGS, output=path, overwrite=True)
    assert mode(path) == kept and path.stat().st_size > 3


def test_draft_is_never_more_open_than_the_file(tmp_path):
    path = tmp_path / "secret"
    path.write_text("old")
    path.chmod(0o600)
    with replacing(path) as partial:
        assert mode(partial) == 0o600


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="needs root")
def test_replaced_file_keeps_its_owner(tmp_path):
    path = tmp_path / "text"
    path.write_text("old")
    os.chown(path, 12345, 23456)
    with replacing(path) as partial:
        partial.write_text("new")
    assert (path.stat().st_uid, path.stat().st_gid) == (12345, 23456)
    assert path.read_text() == "new"


def test_owner_that_cannot_be_kept(tmp_path, monkeypatch):
    """The old file stays, and nothing beside it."""
    path = tmp_path / "text"
    path.write_text("old")
    other, lstat = os.stat_result((0o100644, 0, 0, 1, 54321, 54321, 3, 0, 0, 0)), os.lstat

    def refused(*_):
        raise PermissionError(errno.EPERM, "no")

    monkeypatch.setattr(os, "lstat", lambda p: other if p == path else lstat(p))
    monkeypatch.setattr(os, "fchown", refused)
    with pytest.raises(ResultFileError, match="text cannot be written: Operation not permitted"):
        with replacing(path) as partial:
            partial.write_text("new")
    monkeypatch.undo()
    assert path.read_text() == "old" and os.listdir(tmp_path) == ["text"]


def test_film_keeps_the_mode(tmp_path):
    from click.testing import CliRunner
    run, film = tmp_path / "run.h5", tmp_path / "film.gif"
    simulate(MODEL, SETTINGS, output=run)
    film.write_text("old")
    film.chmod(0o600)
    done = CliRunner().invoke(animate, [str(run), "-o", str(film), "--overwrite", "--frames", "2"],
                              catch_exceptions=False)
    assert done.exit_code == 0 and film.read_bytes().startswith(b"GIF") and mode(film) == 0o600
    assert sorted(os.listdir(tmp_path)) == ["film.gif", "run.h5"]


def test_link_is_refused(tmp_path):
    """Where it leads stays as it is; links among the folders are followed."""
    target, link = tmp_path / "target", tmp_path / "link"
    target.write_text("precious")
    link.symlink_to(target)
    with pytest.raises(ResultFileError, match="link is a symbolic link"):
        writable_path(link, overwrite=True)
    assert target.read_text() == "precious"
    (tmp_path / "folder").mkdir()
    (tmp_path / "shortcut").symlink_to(tmp_path / "folder")
    assert writable_path(tmp_path / "shortcut" / "x") == tmp_path.resolve() / "folder" / "x"


def test_full_disk_names_the_file(tmp_path, monkeypatch):
    """Found before the work as far as it is full then, and named when it fills up later."""
    path = tmp_path / "verdicts.json"
    with pytest.raises(ResultFileError, match="verdicts.json cannot be written: No space left"):
        with replacing(path):
            full()
    assert os.listdir(tmp_path) == []
    monkeypatch.setattr(tempfile, "TemporaryFile", full)
    with pytest.raises(ResultFileError, match="verdicts.json cannot be written: No space left"):
        writable_path(path)
    with pytest.raises(ResultFileError, match="folder .*/new cannot be written: No space left"):
        writable_folder(tmp_path / "new")


@pytest.mark.parametrize("given", ["", "a\0b", 5])
def test_folder_that_is_no_path(given):
    with pytest.raises(ResultFileError, match="is not a path of a folder"):
        folder_path(given)


@contextmanager
def in_time(seconds):
    """What takes longer ends with ``TimeoutError``."""
    def late(*_):
        raise TimeoutError(f"took longer than {seconds} s")

    old = signal.signal(signal.SIGALRM, late)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, old)


UNWRITABLE = "/proc/nowhere"
"""No folder or file can be made there, by root neither."""


@pytest.mark.parametrize("command, output", [
    (("verify",), UNWRITABLE), (("peers",), UNWRITABLE), (("converge", "l-plate"), UNWRITABLE),
    (("calibrate", "ruler", "--elements", "480"), UNWRITABLE), (("reproduce",), UNWRITABLE),
    (("time",), UNWRITABLE), (("claims", "l-plate"), UNWRITABLE),
    (("calibrate", "ruler", "--elements", "480"), ""), (("reproduce",), ""),
    (("converge", "l-plate"), "loop"), (("reproduce",), "loop"), (("verify",), "loop")])
@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="needs /proc")
def test_output_is_checked_before_the_work(tmp_path, monkeypatch, command, output):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "loop").symlink_to("loop")
    done = in_process(*command, "--output", output)
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert output in done.stderr and done.stdout == ""
    assert os.listdir(tmp_path) == ["loop"]


@pytest.mark.parametrize("command", [
    ("run", "pipe.toml"), ("run", "l-plate", "--output", "pipe.h5", "--resume"),
    ("info", "pipe.h5"), ("plot", "pipe.h5"), ("animate", "pipe.h5", "-o", "x.gif"),
    ("claims", "l-plate", "pipe.h5"), ("verify", "--output", "pipe.h5", "--overwrite")])
def test_pipe_does_not_hang(tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    for name in ("pipe.toml", "pipe.h5"):
        os.mkfifo(tmp_path / name)
    with in_time(60):
        done = in_process(*command)
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert "is not a regular file" in done.stderr


def test_history_that_memory_does_not_hold(tmp_path, monkeypatch):
    """1e8 steps are 30 GB: told before anything is written."""
    monkeypatch.setattr(memory, "available_memory", lambda: 8e9)
    long = Settings(dt=1e-5, end_time=1e3)
    with pytest.raises(InputError, match="history of 100000000 steps would take 31.2 GB of "
                                         "memory, 8 GB are free"):
        simulate(MODEL, long, output=tmp_path / "run.h5")
    assert os.listdir(tmp_path) == []
    frames = Settings(dt=1e-4, end_time=3e3, frame_every=1)
    with pytest.raises(InputError, match="history of 30000000 steps would take 16.9"):
        simulate(MODEL, frames)


def test_mesh_that_memory_does_not_hold(monkeypatch):
    monkeypatch.setattr(memory, "available_memory", lambda: 1e6)
    with pytest.raises(InputError, match="a mesh of 480 elements would take"):
        load_case("l-plate").model(480)
    with pytest.raises(InputError, match="model of .* elements would take"):
        simulate(cross_code_plate(8), SETTINGS)


def test_frames_that_memory_does_not_hold(tmp_path, monkeypatch):
    """Those between two checkpoints: all of 80 steps here, twice as much while they are written.
    Without a file none wait."""
    shell = load_case("l-plate").model(1920)
    monkeypatch.setattr(memory, "available_memory", lambda: 4e7)
    many = Settings(dt=0.01, end_time=0.8, frame_every=1, stresses=True)
    with pytest.raises(InputError, match=r"81 frames between two checkpoints would take 0\.\d+ GB"):
        simulate(shell, many, output=tmp_path / "run.h5")
    assert os.listdir(tmp_path) == []
    check_run(shell, many, None)
    _check_frames(shell, replace(many, frame_every=40))


def test_memory_that_is_free():
    assert memory.available_memory() is None or memory.available_memory() > 1e7
