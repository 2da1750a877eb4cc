"""Model files of users, with every key, and the files beside them, edited and damaged at random: an
error of one line that names the file, or a model, which may run."""

import re
import tomllib
import warnings
from pathlib import Path
from resource import RUSAGE_SELF, getrusage

import meshio
import numpy as np
import tomlkit

from corovec import (
    InputError,
    Mesh,
    MeshWarning,
    ResultFileError,
    StepError,
    read_model,
    run_model,
    warm_up,
)
from corovec.solver.dynamics.settings import Settings
from corovec.solver.input.reference import EXAMPLES, START
from corovec.verification.models import rectangle

from .campaign import Fault, Target
from .models import changed_bytes, changed_line, changed_value

FILES = Path(__file__).with_name("shells.toml")

FORMATS = {"SHELL.msh": ("gmsh22", False), "SHELL22.msh": ("gmsh22", True),
           "SHELL41.msh": ("gmsh", True), "SHELL.inp": None, "SHELL.bdf": None,
           "SHELL.vtu": ("vtu", True), "SHELL.vtk": ("vtk", True)}
"""Mesh files, with what meshio calls the format, and whether it is binary; None: as text."""

MOST_MEMORY = 2**20
"""What a try may take more than any before it [KiB]."""

NUMBER = r"(?<![\w.'\"])-?\d[\d.e+-]*"

NUMBERS = ("nan", "inf", "-inf", "-1", "0", "0.0", "-0.0", "1e308", "-1e308", "1e-320", "1e16", "3",
           "1_0", "9223372036854775807", "-9223372036854775808", "9" * 400, "true", "'1'", "0x10",
           "[]", "{}", "1979-05-27", "1000000", "1e9")
"""What may stand where a number stood."""

WORDS = ("'\u0661'", "'\u00e4\u00f6'", "'\U0001f600'", "'\u202e'", "'\ufeff'", "''", "' '", "'x y'",
         "'a.b'", "\"a\\nb\"", "\"\\u0000\"", "'..'", "'/'", "'.'", "'/dev/zero'", "'nowhere.msh'",
         "'SHELL.inp'", "'SHELL.vtu'", "'SHELL.bdf'", "'gust.csv'", "'shell.toml'", "'all'", "'x'",
         "'clamped'", "'symmetry y'", "'t'", "'1 / t'", "'x ** -9e9'", "'9 ** 9 ** 9'", "'tip'",
         "'exp(9e9 * t)'", "'log(-x)'", "'skin'", "1", "['x']")
"""What may stand where a text stood."""

LARGEST, STEPS = 60, 4
"""Elements and steps of a model that runs."""


def prepare(folder):
    """``{name: bytes}`` of the files beside a model file, and the texts of model files."""
    warm_up()
    plate = rectangle(2.0, 1.0, (4, 2))
    tip = np.flatnonzero(plate.nodes[:, 0] == 2.0)
    mesh = Mesh(plate.nodes, plate.quads, {"skin": [4, 5, 6]}, {"corner": [4]},
                {"tip": np.column_stack([tip[:-1], tip[1:]])})
    beside = {"gust.csv": b"t;f;g\n0;1;0\n0.02;3;1\n0.04;1;0\n"}
    for name, kind in FORMATS.items():
        path = folder / name
        mesh.write(path, overwrite=True)
        if kind:
            _written(path, *kind)
        beside[name] = path.read_bytes()
    files = tomllib.loads(FILES.read_text(encoding="utf-8"))
    texts = [START.read_text(encoding="utf-8").replace("FILE", "shell.toml"),
             *map(tomlkit.dumps, files.values())]
    examples = tomllib.loads(EXAMPLES.read_text(encoding="utf-8"))
    lines = [f"{key} = {value}" for table in examples.values() for key, value in table.items()
             if "below" not in value and "=" not in value[:6]]
    return beside, texts, lines


def _written(path, kind, binary):
    """Write a mesh file again, as text or binary."""
    mesh = meshio.read(path)
    if kind == "gmsh":  # meshio writes names of entities only, of which there are none
        mesh = meshio.Mesh(mesh.points, [("quad", mesh.get_cells_type("quad"))])
    mesh.write(path, kind, binary=binary)


def changed_number(chance, text):
    """A number replaced."""
    return _replaced(chance, text, NUMBER, NUMBERS)


def scaled_number(chance, text):
    """A number times a power of ten, or turned round."""
    factor = chance.choice((-1.0, 0.5, 3.0, 10.0**chance.randrange(-12, 13)))
    number = chance.choice(re.findall(NUMBER, text) or ["0"])
    try:
        return text.replace(number, f"{factor * float(number):g}", 1).encode()
    except ValueError:
        return text.encode()


def changed_word(chance, text):
    """A text or a name replaced."""
    return _replaced(chance, text, r"\"[^\"\n]*\"|'[^'\n]*'", WORDS)


def changed_key(chance, text):
    """A key misspelt, in other letters, or that of another."""
    keys = re.findall(r"\b[a-z_]+(?= =)", text) or ["name"]
    key = chance.choice(keys)
    new = chance.choice((key[:-1], key + "s", key.upper(), f'"{key} "', '"\u00fc"', '""',
                         chance.choice(keys)))
    return _replaced(chance, text, rf"\b{key}(?= =)", (new,))


def _replaced(chance, text, pattern, by):
    places = list(re.finditer(pattern, text))
    if not places:
        return text.encode()
    found = chance.choice(places)
    return (text[:found.start()] + chance.choice(by) + text[found.end():]).encode(
        "utf-8", "surrogatepass")


def changed_table(chance, text):
    """A table left out, there twice, or put elsewhere."""
    parts = re.split(r"(?m)^(?=\[)", text)
    at = chance.randrange(len(parts))
    part = parts.pop(at)
    for _ in range(chance.randrange(3)):
        parts.insert(chance.randrange(len(parts) + 1), part)
    return "".join(parts).encode()


def with_example(lines):
    """A key put in with its example."""
    def changed(chance, text):
        parts = text.splitlines(keepends=True)
        parts.insert(chance.randrange(len(parts) + 1), chance.choice(lines) + "\n")
        return "".join(parts).encode()
    return changed


def damaged(chance, data):
    """The bytes of a file beside a model file, changed."""
    text = data.decode("latin-1")
    how = chance.randrange(6)
    if how == 0:
        return changed_bytes(chance, text)
    if how == 1:
        return changed_line(chance, text)
    if how == 2:
        return changed_number(chance, text)
    if how == 3:
        return data[:chance.randrange(len(data))]
    if how == 4:
        return bytes(chance.randrange(256) for _ in range(chance.randrange(200)))
    return chance.choice((b"", b"\xff\xfe", b"\n", data * 2, data[::-1], b"0," * 10**5))


def attempt(chance, prepared, folder):
    beside, texts, lines = prepared
    edits = (changed_value, changed_line, changed_bytes, changed_number, changed_word,
             changed_word, *[scaled_number] * 4, changed_key, changed_table, with_example(lines))
    text = chance.choice(texts).replace("SHELL.msh", chance.choice(list(FORMATS)))
    path = folder / "shell.toml"
    try:
        for _ in range(chance.choice((0, 1, 1, 1, 1, 2, 3))):
            text = chance.choice(edits)(chance, text).decode("utf-8", "surrogateescape")
    except (ValueError, TypeError):
        return "no TOML of it"  # None, and texts that it cannot hold; or it is none any more
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    files, spoil = dict(beside), chance.random() < 0.3
    used = [name for name in files if name in text]
    if spoil and used:
        name = chance.choice(used)
        files[name] = damaged(chance, files[name])
        if chance.random() < 0.1:
            del files[name]
    for name, data in files.items():
        (folder / name).write_bytes(data)
    before = getrusage(RUSAGE_SELF).ru_maxrss
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", category=MeshWarning)
        found = outcome(path, chance.random() < 0.5)
    more = getrusage(RUSAGE_SELF).ru_maxrss - before
    if more > MOST_MEMORY:
        raise Fault(f"{found}, with {more / 2**20:.1f} GiB")
    return found


def outcome(path, runs):
    """What becomes of a model file: the kind of an error, which is in order, or how far it got."""
    try:
        model = read_model(path)
    except InputError as error:
        check_line(str(error))
        if not str(error).startswith(str(path)):
            raise Fault(f"the file is not named: {error}") from None
        return "InputError"
    try:
        small = model.elements <= LARGEST and runs
        if not small:
            model.model(model.elements)
            return "a model"
        step, settings = model.dynamic, None
        if step:
            settings = Settings(step.dt, step.dt * min(STEPS, round(step.end_time / step.dt)))
        run_model(model, settings=settings, output=path.with_suffix(".h5"))
    except (InputError, ResultFileError, StepError) as error:
        check_line(str(error))
        return f"{type(error).__name__} of the run" if small else "InputError of the model"
    return "a run"


def check_line(message):
    """Raise ``Fault`` for a message that is not one printable line."""
    if not message.isprintable():
        raise Fault(f"not one printable line: {message!r}")


TARGET = Target("shells", "an edited model file of a user, and what lies beside it, is an error of "
                "one line, or a model that runs or says why not", prepare, attempt)
