"""Settings that are typed once: the fields of a dataclass say what they are, for the checks, the
documentation and the command line."""

from dataclasses import MISSING, field, fields, is_dataclass

from .checks import choice, instance, integer, number
from .errors import InputError


def setting(help, default=MISSING, *, unit="", choices=(), option=None):
    """A field of a dataclass of settings.

    Args:
        help: what it is, a sentence without unit and choices.
        default: its value if it is not given; without one it must be.
        unit: of its value.
        choices: strings, one of which it is.
        option: what it is called on the command line and in errors; by default as in Python.
    """
    return field(default=default, metadata={"help": help, "unit": unit, "choices": choices,
                                            "option": option})


def called(field):
    """What a setting is called in errors, with underscores."""
    return field.metadata["option"] or field.name


def described(cls):
    """A class of settings whose docstring lists its fields, as they describe themselves."""
    lines = [f"        {f.name}: {_sentence(f.metadata)}" for f in fields(cls)]
    cls.__doc__ = "\n".join([cls.__doc__.rstrip(), "", "    Attributes:", *lines, ""])
    return cls


def check_fields(settings):
    """Give every field of ``settings`` its own type.

    Raises:
        InputError: a value of another type, not finite, or none of the choices.
    """
    for f in fields(settings):
        value = getattr(settings, f.name)
        object.__setattr__(settings, f.name, _checked(f, value))


def _checked(field, value):
    name = called(field)
    if field.metadata["choices"]:
        return choice(name, value, field.metadata["choices"])
    if field.type is int:
        return integer(name, value)
    if field.type is float:
        return number(name, value, field.metadata["unit"])
    if is_dataclass(field.type) and isinstance(value, str):
        inner = next(f.name for f in fields(field.type) if f.metadata["option"] == field.name)
        raise InputError(f"{name} must be a {field.type.__name__}, as {name}="
                         f"{field.type.__name__}({inner}={value!r}), is {value!r}")
    return instance(name, value, field.type)


def _sentence(metadata):
    unit, choices = metadata["unit"], ", ".join(f"``{name}``" for name in metadata["choices"])
    unit, choices = f" [{unit}]" if unit else "", f"  One of {choices}." if choices else ""
    return f"{metadata['help'].removesuffix('.')}{unit}.{choices}"
