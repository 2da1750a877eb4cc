"""Settings that are typed once: the fields of a dataclass say what they are, for the checks, the
documentation and the command line."""

from dataclasses import MISSING, field, fields, is_dataclass
from functools import wraps

from .checks import choice, number, shown
from .errors import InputError
from .signatures import by_type


def setting(help, default=MISSING, *, unit="", choices=(), option=None):
    """A field of a dataclass of settings.

    Args:
        help: what it is, a sentence without unit and choices.
        default: its value if it is not given; without one it must be.
        unit: of its value.
        choices: strings, one of which it is.
        option: what it is called on the command line; by default as in Python.
    """
    return field(default=default, metadata={"help": help, "unit": unit, "choices": choices,
                                            "option": option})


def called(field):
    """What a setting is called on the command line, with underscores."""
    return field.metadata["option"] or field.name


def described(cls):
    """A class of settings whose docstring lists its fields, as they describe themselves; a keyword
    that is none of them is an ``InputError``, which says where it belongs."""
    lines = [f"        {f.name}: {_sentence(f.metadata)}" for f in fields(cls)]
    cls.__doc__ = "\n".join([cls.__doc__.rstrip(), "", "    Attributes:", *lines, ""])
    made = cls.__init__

    @wraps(made)
    def init(self, *arguments, **options):
        for name in options.keys() - {f.name for f in fields(cls)}:
            raise InputError(_no_field(cls, name))
        made(self, *arguments, **options)

    cls.__init__ = init
    return cls


def _no_field(cls, name):
    """What is said of a keyword that is no field of ``cls``."""
    for outer in fields(cls):
        if is_dataclass(outer.type) and name in {f.name for f in fields(outer.type)}:
            return (f"{cls.__name__} has no {name}: it belongs to {outer.name}, as "
                    f"{cls.__name__}({outer.name}={outer.type.__name__}({name}=...))")
    return (f"{cls.__name__} has no {shown(name)}, must be one of: "
            f"{', '.join(f.name for f in fields(cls))}")


def put(item, **values):
    """Set fields of a frozen dataclass, while it is made."""
    for name, value in values.items():
        object.__setattr__(item, name, value)


def check_fields(settings):
    """Give every field of a dataclass its own type.

    Raises:
        InputError: a value of another type, not finite, or none of the choices.
    """
    for f in fields(settings):
        value = getattr(settings, f.name)
        put(settings, **{f.name: _checked(f, value)})


def _checked(field, value):
    name, about, kind = field.name, field.metadata, field.type
    if about.get("choices"):
        return choice(name, value, about["choices"])
    if kind is float:
        return number(name, value, about.get("unit"))
    if is_dataclass(kind) and isinstance(value, str):
        inner = next((f.name for f in fields(kind) if f.metadata.get("option") == name), None)
        if inner:
            raise InputError(f"{name} must be a {kind.__name__}, as {name}={kind.__name__}"
                             f"({inner}={shown(value)}), is {shown(value)}")
    return by_type(name, kind, value)


def _sentence(metadata):
    unit, choices = metadata["unit"], ", ".join(f"``{name}``" for name in metadata["choices"])
    unit, choices = f" [{unit}]" if unit else "", f"  One of {choices}." if choices else ""
    return f"{metadata['help'].removesuffix('.')}{unit}.{choices}"
