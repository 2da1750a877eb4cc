"""Result files of dynamics and statics, damaged or edited: an error, a warning with an earlier
checkpoint, or the same contents."""

import json
import warnings

import h5py
import numpy as np

from corovec import (
    ResultFileError,
    ResultFileWarning,
    Settings,
    arc_length,
    line_load,
    load_control,
    read,
    simulate,
)
from corovec.solver.results import checksums, layout, reading
from corovec.verification.models import cross_code_plate
from corovec.verification.shells import roof, strip

from .campaign import Fault, Target
from .junk import spoiled

SETTINGS = Settings(dt=0.01, end_time=0.1, frame_every=2, stresses=True)

MODEL = cross_code_plate(1)


def dynamic(path, **options):
    return simulate(MODEL, SETTINGS, output=path, probes={"tip": 5}, **options)


def controlled(path, **options):
    model, _ = strip(10.0, 4, lambda X, tip: line_load(X, tip, (0.0, 0.0, 4.0)))
    return load_control(model, [0.5, 1.0], output=path, **options)


def followed(path, **options):
    return arc_length(roof(2, 12.7), 1.0, lambda factor, u: u[0, 2] < -2.0, output=path, **options)


RUNS = {run.__name__: run for run in (dynamic, controlled, followed)}


def places(path):
    """Places of all datasets of a file, links and all."""
    with h5py.File(path) as file:
        sizes = layout.checked_sizes(file)
        return [*layout.fixed(sizes), *layout.growing(sizes), *layout.links(sizes), layout.TIMES]


def assert_same_start(contents, reference, described=True):
    """As the reference, or, with fewer steps, as its first ones."""
    for name in ("description", "n_steps", "memory") if described else ("n_steps",):
        assert contents[name] == reference[name], name
    assert len(contents["history"]) == contents["step"] + 1
    for name in reference.keys() - {"description", "n_steps", "step", "memory"}:
        assert np.array_equal(contents[name], reference[name][:len(contents[name])]), name


def looked_at(path, reference, described=True):
    """``same``, ``error`` or ``warning``; anything else is a failure."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            contents = read(path)
        except ResultFileError as error:
            assert str(error).isprintable() and str(path) in str(error), error
            return "error"
    assert all(warning.category is ResultFileWarning for warning in told), told[0].message
    assert_same_start(contents, reference, described)
    assert told or contents["step"] == reference["step"], "fewer steps, in silence"
    return "warning" if told else "same"


def signed(path, change):
    """Change an open file, and sign it as one does who knows how."""
    with h5py.File(path, "r+") as file:
        change(file)
        sizes = layout.checked_sizes(file)
        text = bytes(file.attrs["description"])
        file.attrs["checksum"] = checksums.of_fixed(file, text, sizes)
        start = 0
        for k, step in enumerate(file["frames/step"][:len(file[layout.TIMES])]):
            rows = reading._history(file, sizes, step)[start:]
            fields = [file[f"frames/{name}"][k * n:(k + 1) * n]
                      for name, (_, (n, *_)) in sizes.fields.items()]
            file["frames/checksum"][k] = checksums.of_frame(k, file[layout.TIMES][k], rows, fields)
            start = step + 1


def replaced(path, place, make):
    """Put what ``make(file, old)`` makes in the place of a dataset."""
    with h5py.File(path, "r+") as file:
        old = file[place][...]
        del file[place]
        make(file, old)


def prepare(folder):
    """``[(run, bytes of its file, contents, places)]``."""
    def whole(run):
        path = folder / f"{run.__name__}.h5"
        run(path)
        return run, path.read_bytes(), read(path), places(path)

    return [whole(run) for run in RUNS.values()]


def damaged(chance, whole):
    """The bytes of a file, some of them changed, or its end cut off."""
    data, at = bytearray(whole), chance.randrange(len(whole))
    if chance.random() < 0.5:
        at %= 40_000  # where HDF5 keeps its structure
    length = chance.choice((1, 1, 2, 8, 64, 4096))
    how = chance.randrange(6)
    if how == 0:
        data[at] ^= 1 << chance.randrange(8)
    elif how == 1:
        data[at:at + length] = chance.randbytes(len(data[at:at + length]))
    elif how == 2:
        data[at:at + length] = bytes(len(data[at:at + length]))
    elif how == 3:
        del data[at:]
    elif how == 4:
        other = chance.randrange(len(data))
        data[at:at + length] = data[other:other + length]
    else:
        del data[at:at + length]
    return bytes(data)


def attempt_damage(chance, runs, folder):
    run, whole, reference, _ = chance.choice(runs)
    path = folder / "run.h5"
    path.write_bytes(damaged(chance, whole))
    outcome = looked_at(path, reference)
    if chance.random() < 0.5:
        return outcome
    return f"{outcome}, {resumed(run, path, reference)}"


def resumed(run, path, reference):
    """What becomes of a file that is resumed: refused, or in the end as the reference."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ResultFileWarning)
            run(path, resume=True)
    except ResultFileError as error:
        assert str(error).isprintable(), error
        return "refused"
    contents = read(path)
    assert contents["step"] == reference["step"], "resumed, and fewer steps"
    assert_same_start(contents, reference)
    return "resumed"


def edit_links(chance, place, path):
    """What may stand in the place of a dataset: functions of (file, old values)."""
    copy = str(path.with_name("copy.h5"))

    def soft(file, old):
        file["moved"] = old
        file[place] = h5py.SoftLink("/moved")

    def external(file, old):
        file[place] = h5py.ExternalLink(copy, place)

    def stored(file, old):
        file.create_dataset(place, old.shape, old.dtype,
                            external=[(str(path.with_name("victim")), 0, h5py.h5f.UNLIMITED)])

    def virtual(file, old):
        parts = h5py.VirtualLayout(old.shape, old.dtype)
        parts[...] = h5py.VirtualSource(copy, place, old.shape, old.dtype)
        file.create_virtual_dataset(place, parts)

    def deleted(file, old):
        pass

    def group(file, old):
        file.create_group(place)

    def retyped(file, old):
        types = [kind for kind in ("f4", "f8", "i2", "i8", "u4", ">f8", "S8", "c16")
                 if old.dtype != kind]
        file[place] = np.zeros(old.shape, chance.choice(types))

    def resized(file, old):
        other = [old[:-1], old[..., None], old.ravel()[:0], np.concatenate([old, old])]
        file[place] = chance.choice(other)

    def filtered(file, old):
        file.create_dataset(place, data=old, chunks=True, compression="gzip")

    def hollow(file, old):
        file.create_dataset(place, dtype=old.dtype)

    return soft, external, stored, virtual, deleted, group, retyped, resized, filtered, hollow


def edit_description(chance, path):
    """A key or a value of the description changed, with all checksums right."""
    def change(file):
        text = json.loads(bytes(file.attrs["description"]))
        file.attrs["description"] = np.bytes_(json.dumps(_json(spoiled(chance, text, odd=False))))

    signed(path, change)


def _json(value):
    """What JSON holds of a value."""
    return json.loads(json.dumps(value, default=str).replace("\\u0000", ""))


def edit_attribute(chance, path):
    with h5py.File(path, "r+") as file:
        place = chance.choice(("/", "VTKHDF", "VTKHDF/Steps"))
        name = chance.choice(list(file[place].attrs))
        del file[place].attrs[name]
        if chance.random() < 0.7:
            file[place].attrs[name] = chance.choice(
                (0, 1.5, "x", b"y", np.zeros(3), np.bytes_("corovec-run-1"), h5py.Empty("f8")))


def attempt_edits(chance, runs, folder):
    run, whole, reference, names = chance.choice(runs)
    path, victim, copy = folder / "run.h5", folder / "victim", folder / "copy.h5"
    path.write_bytes(whole)
    victim.write_bytes(bytes(10**5))
    copy.write_bytes(whole)
    kind = chance.choice(("dataset", "dataset", "description", "attribute"))
    if kind == "dataset":
        place = chance.choice(names)
        kind = chance.choice(edit_links(chance, place, path))
        replaced(path, place, kind)
        kind = kind.__name__
    elif kind == "description":
        edit_description(chance, path)
    else:
        edit_attribute(chance, path)
    outcome = looked_at(path, reference, kind != "description")
    if outcome == "error":
        after = resumed(run, path, reference)
        if after != "refused":
            raise Fault(f"{kind}: an error when read, yet it is resumed")
    elif kind not in ("description", "attribute"):
        raise Fault(f"{kind} {place}: {outcome}, must be an error")
    if victim.read_bytes() != bytes(10**5) or copy.read_bytes() != whole:
        raise Fault(f"{kind}: another file has been written")
    return f"{kind}: {outcome}"


DAMAGE = Target("damage", "a damaged result file is an error, a warning or what it was", prepare,
                attempt_damage)
EDITS = Target("edits", "an edited result file is an error, and reaches no other", prepare,
               attempt_edits)
