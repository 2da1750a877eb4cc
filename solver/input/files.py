"""Model files: reading them, their names, and a copy with a calibrated peak."""

import tomllib
from difflib import get_close_matches
from functools import cache
from importlib import metadata, util
from pathlib import Path

from pydantic import ValidationError

from ..checks import shown
from ..errors import InputError
from ..names import printable
from ..signatures import File, checked
from .model_file import ModelFile, keys

EMPTY = '""'
"""The key of no characters, as TOML has it."""

GROUP = "corovec.models"
"""Entry points of packages that bring model files."""


@cache
def installed_models():
    """``{name: path}`` of the model files of all packages in the entry-point group ``GROUP``."""
    return _models(metadata.entry_points(group=GROUP))


def _models(entry_points):
    folders = [Path(util.find_spec(point.module).origin).parent for point in entry_points]
    return {path.stem: path for folder in folders for path in sorted(folder.glob("*.toml"))}


def find_model(model):
    """The path of a model file that is given by its path or by the name of an installed one.

    Raises:
        InputError: it is neither.
    """
    if Path(model).suffix == ".toml":
        return Path(model)
    # of this package alone: to look through all that is installed takes longer than a short run
    names = _models(metadata.distribution("corovec").entry_points.select(group=GROUP))
    if model not in names:
        names = installed_models()
    if model in names:
        return names[model]
    raise InputError(f"model '{model}' is unknown, must be the path of a .toml file or one of: "
                     f"{', '.join(sorted(names))}")


@checked
def read_model(path: File):
    """The ``ModelFile`` at ``path``, which ``run_model`` runs.

    Args:
        path: of a model file (TOML).

    Returns:
        ``ModelFile``; its ``model(elements)`` is a ``Model``.

    Raises:
        InputError: it cannot be read, or has errors: all of them, each with its path in the file.
    """
    try:
        if Path(path).exists() and not Path(path).is_file():
            raise ValueError("it is not a regular file")
        with open(path, "rb") as file:
            data = tomllib.load(file)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: {error}") from None
    except RecursionError:
        raise InputError(f"{path}: its values are nested too deeply") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{path} cannot be read: {reason}") from None
    try:
        return ModelFile.model_validate(data, context={"folder": str(Path(path).parent)})
    except ValidationError as errors:
        raise InputError(f"{path}: " + "; ".join(_line(data, error) for error in errors.errors())
                         ) from None


def calibrated_text(path, peak, calibration):
    """The text of the model file at ``path`` with its free peak calibrated; comments are kept.

    Args:
        path: of a model file that has a history with a peak.
        peak: the value that was found, in the unit of the old one.
        calibration: ``Calibration`` that tells how.
    """
    import tomlkit
    model, document = read_model(path), tomlkit.parse(path.read_text(encoding="utf-8"))
    unit = model.histories[model.free_peak].peak.unit
    found = tomlkit.inline_table()
    found.update({"value": peak, "unit": unit, "provenance": "calibrated",
                  "source": calibration.source})
    document["histories"][model.free_peak]["peak"] = found
    document["calibration"] = calibration.model_dump()
    return tomlkit.dumps(document)


IN_PYTHON = ("normals", "normal_velocity", "membrane", "shear", "fold_angle", "patches")
"""What only a ``Model`` takes."""


def _line(data, error):
    """Where in the file an error is, and what it says; one of the whole file names its place."""
    place, message = _place(data, error["loc"]), _message(error)
    return f"{place}: {message}" if place else message


def _message(error):
    """What an error says, in our words."""
    kind, given, place = error["type"], error["input"], error["loc"]
    if kind == "extra_forbidden":
        return _unknown(place[-1])
    if kind == "missing":
        return "is missing"
    if kind == "union_tag_not_found":
        return f"{error['ctx']['discriminator']} is missing".replace("'", "")
    if kind == "union_tag_invalid":
        tags = error["ctx"]["expected_tags"].replace("'", "")
        return f"kind must be one of {tags}, is '{printable(error['ctx']['tag'])}'"
    if kind == "list_type" and isinstance(given, dict):
        return f"must be a list of tables, write [[{'.'.join(map(str, place))}]]"
    wanted = {"list_type": "a list", "tuple_type": "a list", "dict_type": "a table",
              "model_type": "a table", "string_type": "a text", "literal_error": "{expected}",
              "too_long": "a list of at most {max_length}",
              "too_short": "a list of at least {min_length}"}
    if kind in wanted:
        wanted = wanted[kind].format(**error.get("ctx", {}))
        return f"must be {wanted}, is {shown(given)}"
    return error["msg"].removeprefix("Value error, ").lstrip()


def _unknown(key):
    """What is said of a key that is not known where it is."""
    if key in IN_PYTHON:
        return "is unknown here, it is given in Python (own-shell.md, Model files)"
    if key in keys():
        return "is unknown here"
    near = get_close_matches(key, keys(), 1)
    return "is unknown" + (f", did you mean '{near[0]}'?" if near else "")


def _place(data, loc):
    """Where in the file an error is; a plain value has no ``value`` of its own."""
    text = ""
    for k, name in enumerate(loc):
        if name == "[key]" or name == "value" and k and not isinstance(data, dict):
            continue
        text += f"[{name}]" if isinstance(name, int) else f".{name or EMPTY}"
        try:
            data = data[name]
        except (KeyError, IndexError, TypeError):
            data = {}
    return text.removeprefix(".")
