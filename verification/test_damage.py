"""Damaged files and files from elsewhere: an error, a warning, or the same contents, never other
numbers, and never a reach for another file."""

import json
import random

import h5py
import numpy as np
import pytest
from click.testing import CliRunner

from corovec import (
    ResultFileError,
    ResultFileWarning,
    read,
)
from corovec.reports.cli import animate, plot
from corovec.solver.cli import info
from corovec.solver.dynamics import simulation
from corovec.solver.results import layout, recorder
from corovec.solver.results.reading import FORMAT
from corovec.verification.fuzz.files import (
    RUNS,
    dynamic,
    looked_at,
    places,
    replaced,
    signed,
)
from corovec.verification.helpers import corovec


@pytest.fixture(scope="module", params=[pytest.param(name, marks=[
    pytest.mark.slow] * (name != "dynamic")) for name in RUNS])
def run(request):
    return RUNS[request.param]


@pytest.fixture(scope="module")
def whole(run, tmp_path_factory):
    """The bytes of a finished file, whose frames were written one by one."""
    path = tmp_path_factory.mktemp("whole") / "run.h5"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(recorder, "WAIT", 0.0)
        patch.setattr(simulation, "MOST", 1)
        patch.setattr(simulation, "LEAST", 1)
        run(path)
    return path.read_bytes()


@pytest.fixture
def path(whole, tmp_path):
    """A copy of a finished file."""
    path = tmp_path / "run.h5"
    path.write_bytes(whole)
    return path


def refused(run, path, message=""):
    """The file is refused in one line, when it is read and (with a ``run``) when that is resumed,
    and left as it is."""
    before = path.read_bytes()
    with pytest.raises(ResultFileError, match=message) as error:
        read(path)
    assert "\n" not in str(error.value) and str(path) in str(error.value)
    if run is not None:
        with pytest.raises(ResultFileError, match=message):
            run(path, resume=True)
    assert path.read_bytes() == before


@pytest.mark.slow
def test_every_dataset_is_guarded(whole, path):
    """Any byte of any dataset turned round: an error or the same contents, but of the newest
    checkpoint and its frame, which the one before replaces with a warning."""
    reference, chance = read(path), random.Random(1)
    seen = {}
    with h5py.File(path) as file:
        newest = int(np.argmax(file["checkpoint/stamp"][:, 0]))
        where = {place: (file[place].id.get_offset(), file[place].nbytes) for place in places(path)
                 if place != layout.TIMES}
        where[layout.TIMES] = (file[layout.TIMES].id.get_chunk_info(0).byte_offset,
                               file[layout.TIMES].nbytes)
    for place, (offset, size) in where.items():
        for at in {0, size - 1, size // 2, *(chance.randrange(size) for _ in range(6))}:
            damaged = bytearray(whole)
            damaged[offset + at] ^= 0xff
            path.write_bytes(damaged)
            seen.setdefault(place, set()).add(looked_at(path, reference))
    with h5py.File(path) as file:
        fixed = [*layout.fixed(layout.checked_sizes(file)), "VTKHDF/Points"]
    assert all(seen[place] == {"error"} for place in fixed)
    assert "error" in seen["frames/displacement"] | seen["frames/checksum"]
    assert "warning" in seen["checkpoint/state"] and newest in (0, 1)


def test_one_bit_of_an_energy(run, path):
    """What once gave half of the energy."""
    with h5py.File(path, "r+") as file:
        bits = file["history/strain_energy"][...].view(np.int64)
        bits[1] ^= 1 << 52
        file["history/strain_energy"][...] = bits.view(float)
    refused(run, path, r"damaged.*frame 1, or the history up to it, has changed: run it again")


def test_damaged_last_frame_is_said_on_the_terminal(tmp_path, monkeypatch):
    monkeypatch.setattr(recorder, "WAIT", 0.0)
    monkeypatch.setattr(simulation, "MOST", 1)  # every frame is a checkpoint
    monkeypatch.setattr(simulation, "LEAST", 1)
    path = tmp_path / "run.h5"
    dynamic(path)
    with h5py.File(path, "r+") as file:
        file["history/strain_energy"][10] *= 2.0
    done = corovec("info", str(path))
    assert done.returncode == 0 and "steps                  8\n" in done.stdout
    assert done.stderr == (f"corovec: warning: {path}: what follows step 8 is damaged or "
                           "incomplete; that step is the newest good checkpoint\n")
    with pytest.warns(ResultFileWarning, match="what follows step 8"):
        again = dynamic(path, resume=True)
    assert np.array_equal(again.history, dynamic(None).history)
    assert read(path)["step"] == 10


def fill(place, value):
    def change(file):
        file[place][1] = value
    return change


@pytest.mark.parametrize("place, value, message", [
    ("history/strain_energy", np.nan, "strain_energy is not finite"),
    ("history/strain_energy", np.inf, "strain_energy is not finite"),
    ("frames/displacement", np.nan, "frame 0 is not finite"),
    ("model/nodes", np.nan, "nodes is not finite"),
    ("model/quads", 9999, "an element has node 9999"),
    ("model/quads", -1, "an element has node"),
    ("frames/step", 0, "frames/step does not ascend"),
])
def test_nonsense_that_is_signed(run, path, place, value, message):
    signed(path, fill(place, value))
    refused(run, path, message)


@pytest.mark.slow
def test_every_dataset_is_needed(run, whole, path):
    """Each is refused if it is missing or of another type; every fourth is a group, shorter,
    filtered or empty besides."""
    def retyped(file, old):
        file[place] = old.astype("f4" if old.dtype.kind == "i" else "i2")

    always = (lambda file, old: None, retyped)
    rare = (lambda file, old: file.create_group(place),
            lambda file, old: file.create_dataset(place, data=old[:-1]),
            lambda file, old: file.create_dataset(place, data=old, chunks=True, shuffle=True),
            lambda file, old: file.create_dataset(place, dtype="f8"))
    for k, place in enumerate(places(path)):
        for change in (*always, rare[k % len(rare)]):
            path.write_bytes(whole)
            replaced(path, place, change)
            refused(run if change is retyped else None, path, "damaged")


@pytest.mark.slow
def test_files_that_reach_for_others(run, whole, path, tmp_path):
    """Links and storage elsewhere are refused before anything is read; the victim keeps its
    bytes."""
    victim, copy = tmp_path / "victim", tmp_path / "copy.h5"
    victim.write_bytes(bytes(10**6))
    copy.write_bytes(whole)

    def external(file, old):
        file[place] = h5py.ExternalLink(str(copy), place)

    def soft(file, old):
        file["moved"] = old
        file[place] = h5py.SoftLink("/moved")

    def stored(file, old):
        file.create_dataset(place, old.shape, old.dtype,
                            external=[(str(victim), 0, h5py.h5f.UNLIMITED)])

    def virtual(file, old):
        parts = h5py.VirtualLayout(old.shape, old.dtype)
        parts[...] = h5py.VirtualSource(copy, place, old.shape, old.dtype)
        file.create_virtual_dataset(place, parts)

    for place in places(path):
        for change in (external, soft, stored, virtual):
            path.write_bytes(whole)
            replaced(path, place, change)
            refused(run if change is stored else None, path,
                    f"damaged or not a result file: {place} ")
    for place in ("history", "frames", "checkpoint", "VTKHDF", "VTKHDF/Steps"):
        path.write_bytes(whole)
        with h5py.File(path, "r+") as file:
            del file[place]
            file[place] = h5py.ExternalLink(str(copy), place)
        refused(run, path, "is a link to somewhere else")
    assert victim.read_bytes() == bytes(10**6) and copy.read_bytes() == whole


def test_dataset_larger_than_the_file(run, path):
    def bomb(file, old):
        file.create_dataset("history/strain_energy", (10**12,), "f8", chunks=(10**6,))

    replaced(path, "history/strain_energy", bomb)
    refused(run, path, "history/strain_energy is not stored as")


def keys(description, place=()):
    """Places of all values of nested dictionaries."""
    for name, value in description.items():
        yield (*place, name)
        if isinstance(value, dict):
            yield from keys(value, (*place, name))


@pytest.mark.slow
def test_every_key_of_the_description_is_needed(run, path):
    """Each is refused if it is missing or of another type, though the file is signed."""
    text = read(path)["description"]
    for place in keys(text):
        *way, name = place
        for delete in (True, False):
            changed = json.loads(json.dumps(text))
            within = changed
            for step in way:
                within = within[step]
            if delete:
                del within[name]
            else:
                within[name] = ["a list"] if isinstance(within[name], str) else float("nan")

            def change(file, changed=changed):
                file.attrs["description"] = np.bytes_(json.dumps(changed))

            signed(path, change)
            refused(None if delete else run, path, f"description.{'.*'.join(place)}")


@pytest.mark.parametrize("text", ["{}", "[]", "nonsense", "", "[" * 5000, '"' + "x" * 70000])
def test_description_that_is_none(run, path, text):
    def change(file):
        file.attrs["description"] = np.bytes_(text)

    signed(path, change)
    refused(run, path, "damaged")
    with h5py.File(path, "r+") as file:
        file.attrs["description"] = 7
    refused(run, path, "description is not a text")


@pytest.mark.parametrize("command, options", [
    (info, ()), (plot, ("--output", "figures")), (animate, ("--output", "film.gif"))])
def test_commands_refuse(tmp_path, monkeypatch, command, options):
    """A column is missing: one line, as ``read`` says it."""
    monkeypatch.chdir(tmp_path)
    dynamic("run.h5")
    with h5py.File("run.h5", "r+") as file:
        del file["history/iterations"]
    result = CliRunner().invoke(command, ["run.h5", *options])
    assert isinstance(result.exception, ResultFileError)
    assert "history/iterations is missing" in str(result.exception)
    assert [path.name for path in tmp_path.iterdir()] == ["run.h5"]


def test_command_line_refuses_in_one_line(tmp_path):
    path = tmp_path / "run.h5"
    dynamic(path)
    with h5py.File(path, "r+") as file:
        del file["history/iterations"]
    done = corovec("info", str(path))
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert done.stderr.startswith(f"corovec: error: {path} is damaged or not a result file")


@pytest.mark.parametrize("back", [1, 6])
def test_older_format_is_told(path, run, back):
    name, _, number = FORMAT.rpartition("-")
    with h5py.File(path, "r+") as file:
        file.attrs["format"] = f"{name}-{int(number) - back}"
    refused(run, path, "of an older version of corovec .*repeat its run")


def test_description_has_the_keys_that_are_checked(path):
    """A new setting or number in the description must be checked too."""
    from corovec.solver.results.description import _Dynamics, _Statics
    text = read(path)["description"]
    kind = _Dynamics if "dt" in text["settings"] else _Statics
    assert kind.model_validate(text).model_dump() == text
