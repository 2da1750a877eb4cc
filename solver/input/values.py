"""Values of a model file: plain, in the unit that the code understands, as ``thickness = 0.1``, or
as a table with where they come from: ``value``, ``unit``, ``provenance`` and ``source``.
"""

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Generic, Literal, TypeVar

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict

from ..checks import (
    count,
    names_columns,
    not_negative,
    number,
    positive,
    shown,
    single,
    text,
    vector,
)
from ..errors import InputError

Provenance = Literal["printed", "derived", "assumed", "selected", "calibrated", "given"]
"""``selected``: chosen among candidates by a printed result; it proves as little as what was
``calibrated`` to one."""


def probe_name(name):
    """A name that is fit for columns of a table."""
    if not names_columns(name):
        raise InputError("a name is letters, digits and _, and begins with a letter")
    return name


def within(low, high):
    """The type of a number between two others."""

    def check(value):
        if not low < number("", value) < high:
            raise InputError(f"must lie in ({low:g}, {high:g}), is {value}")
        return value

    return Annotated[float, BeforeValidator(check)]


def number_or_vector(given):
    """A number, or three."""
    if single(given):
        return number("", given)
    try:
        return vector("", given)
    except InputError:
        raise InputError(f"must be a number or three, is {shown(given)}") from None


# what a check says of a value without a name, its place in the file stands before
Number = Annotated[float, BeforeValidator(partial(number, ""))]
Positive = Annotated[float, BeforeValidator(partial(positive, ""))]
NotNegative = Annotated[float, BeforeValidator(partial(not_negative, ""))]
Count = Annotated[int, BeforeValidator(partial(count, ""))]
Name = Annotated[str, BeforeValidator(partial(text, ""))]
Beside = Annotated[Name, AfterValidator(lambda file, info: str(
    Path((info.context or {}).get("folder", ""), file)))]
"""The path of a file, from the folder of the model file."""
Probe = Annotated[str, BeforeValidator(probe_name)]
Title = Annotated[str, BeforeValidator(lambda given: given if given == "" else text("", given))]
Polar = within(0.0, 180.0)
Numbers = tuple[Number, ...]
Point = tuple[Number, Number, Number]
NumberOrPoint = Annotated[Number | Point, BeforeValidator(number_or_vector)]
Line = tuple[Point, Point]
Divisions = tuple[Count, Count]
T = TypeVar("T")


class Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    def __copy__(self):
        """A copy without what was cached, which need not hold where the copy's fields differ."""
        copy = super().__copy__()
        for name in vars(copy).keys() - type(self).model_fields.keys():
            del vars(copy)[name]
        return copy


@dataclass(frozen=True)
class Unit:
    """What a plain value of a field is in; None where that follows from other fields."""

    unit: str | None

    def __get_pydantic_json_schema__(self, core, handler):
        """A plain value, or the table of a ``Sourced`` one."""
        table = handler(core)
        return {"anyOf": [handler.resolve_ref_schema(table)["properties"]["value"], table]}


class Sourced(Strict, Generic[T]):
    """A value with its unit, its provenance and where it comes from."""

    value: T
    unit: str
    provenance: Provenance
    source: str


def sourced(value, unit=""):
    """A plain value as the table of a ``Sourced`` one."""
    if isinstance(value, dict | Sourced):
        return value
    return {"value": value, "unit": unit, "provenance": "given", "source": ""}


def in_unit(unit, kind):
    """The type of a ``Sourced`` value in a unit, the only one that the code understands."""

    def check(value):
        if value.unit != unit:
            raise ValueError(f"in '{value.unit}', must be in '{unit}'")
        return value

    return Annotated[Sourced[kind], BeforeValidator(lambda value: sourced(value, unit)),
                     AfterValidator(check), Unit(unit)]


def columns(given):
    """(value, unit, provenance, source) of a ``Sourced`` value."""
    value = list(given.value) if isinstance(given.value, tuple) else given.value
    return value, given.unit, given.provenance, given.source


def only_one(item, names):
    """The one of some optional fields that is given.

    Raises:
        ValueError: none is, or several are.
    """
    given = [name for name in names if getattr(item, name) is not None]
    if len(given) != 1:
        told = f"{' and '.join(given)} are given" if given else "none is given"
        raise ValueError(f"one of {', '.join(names)} is needed, {told}")
    return given[0]
