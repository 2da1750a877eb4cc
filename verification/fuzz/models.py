"""Model files with random edits: an error that names the file and the place, or a model."""

import re
import tomllib

import tomlkit

from corovec import InputError
from corovec.benchmarks import FOLDER
from corovec.solver.input.files import read_model

from .campaign import Fault, Target
from .junk import spoiled

PLACE = ("line ", "end of document", "cannot be read", "codec", "nested")
"""How an error of a file that is no TOML tells its place, or that it has none."""


def texts(folder):
    """The texts of the model files of the benchmarks."""
    return [path.read_text(encoding="utf-8") for path in sorted(FOLDER.glob("*.toml"))]


def changed_value(chance, text):
    """A value replaced by junk, a key left out or put in."""
    data = spoiled(chance, tomllib.loads(text), odd=False)
    return tomlkit.dumps(data if isinstance(data, dict) else {}).encode("utf-8", "surrogatepass")


def changed_line(chance, text):
    """A line left out, doubled, or put elsewhere."""
    lines = text.splitlines(keepends=True)
    at, line = chance.randrange(len(lines)), chance.choice(lines)
    lines[at:at + chance.randrange(2)] = chance.choice(([], [line], [lines[at]] * 2))
    return "".join(lines).encode()


def changed_bytes(chance, text):
    """Some bytes changed, or the end cut off."""
    data = bytearray(text.encode())
    for _ in range(chance.choice((1, 1, 2, 10))):
        data[chance.randrange(len(data))] = chance.choice((0, 10, 32, 34, 46, 48, 91, 123, 200,
                                                           chance.randrange(256)))
    return bytes(data[:chance.randrange(len(data))] if chance.random() < 0.1 else data)


def attempt(chance, texts, folder):
    path = folder / "shell.toml"
    edit = chance.choice((changed_value, changed_line, changed_bytes))
    try:
        path.write_bytes(edit(chance, chance.choice(texts)))
    except (ValueError, TypeError):
        return "no TOML of it"  # None, and texts that it cannot hold
    try:
        model = read_model(path)
    except InputError as error:
        _check_message(str(error), path)
        return "InputError"
    try:
        model.model(model.sizes[0])
    except InputError as error:
        _check_line(str(error))
        return "InputError of the model"
    return "a model"


def _check_message(message, path):
    _check_line(message)
    if not message.startswith(str(path)):
        raise Fault(f"the file is not named: {message}")
    rest = message.removeprefix(str(path))
    if not any(word in rest for word in PLACE) and not re.match(r": .+: .+", rest):
        raise Fault(f"no place is named: {message}")


def _check_line(message):
    if not message.isprintable():
        raise Fault(f"not one printable line: {message!r}")


TARGET = Target("models", "an edited model file is an error with its place, or a model", texts,
                attempt)
