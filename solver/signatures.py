"""Arguments of public functions, checked by the annotations of their signatures in one place.

``float``, ``int``, ``bool``, ``str`` (a name), ``Callable`` and classes stand for the check of that
name, ``list[...]`` for one of each item, ``Annotated[..., check]`` for a check of its own.
"""

import inspect
from collections.abc import Callable, Mapping
from functools import partial, wraps
from os import PathLike
from types import NoneType, UnionType
from typing import Annotated, get_args, get_origin, get_type_hints

import numpy as np

from .checks import (
    count,
    flag,
    floats,
    function,
    instance,
    integer,
    integers,
    number,
    path,
    positive,
    shown,
    text,
    vector,
)
from .errors import InputError

SIMPLE = {bool: flag, int: integer, float: number, str: text, Callable: function}

Count = Annotated[int, count]
File = Annotated[str | PathLike, path]
Integers = Annotated[tuple, integers]
Nodes = Annotated[np.ndarray, partial(floats, shape=(None, 3))]
Positive = Annotated[float, positive]
Vector = Annotated[tuple, vector]


def checked(called):
    """``called`` with its annotated arguments checked, and in their own types, before it runs.

    None is taken where it is the default.  ``help`` shows the types, without their checks.
    """
    signature = inspect.signature(called)
    kinds = {name: parameter for name, parameter in signature.parameters.items()
             if parameter.annotation is not parameter.empty}

    @wraps(called)
    def call(*arguments, **options):
        given = signature.bind(*arguments, **options)
        for name in given.arguments.keys() & kinds.keys():
            value = given.arguments[name]
            if value is not None or kinds[name].default is not None:
                given.arguments[name] = by_type(name, kinds[name].annotation, value)
        return called(*given.args, **given.kwargs)

    plain = get_type_hints(called)
    call.__signature__ = signature.replace(parameters=[
        parameter.replace(annotation=plain.get(name, parameter.annotation))
        for name, parameter in signature.parameters.items()])
    return call


def by_type(name, kind, value):
    """``value`` as the annotation ``kind`` wants it.

    Raises:
        InputError: it is nothing of that kind.
    """
    origin, parts = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return parts[1](name, value)
    if origin is UnionType and parts[1] is NoneType:
        return None if value is None else by_type(name, parts[0], value)
    if origin is list:
        items = enumerate(_list(name, value))
        return [by_type(f"{name}[{k}]", parts[0], item) for k, item in items]
    return SIMPLE[kind](name, value) if kind in SIMPLE else instance(name, value, kind)


def _list(name, value):
    if isinstance(value, str | bytes | Mapping) or not np.iterable(value):
        raise InputError(f"{name} must be a list, is {shown(value)}")
    return value
