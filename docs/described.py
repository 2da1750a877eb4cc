"""Docstrings that are made when a class is: mkdocstrings reads sources, these are not in them."""

import inspect
from importlib import import_module

from griffe import Docstring, Extension


class Described(Extension):
    """Take the docstrings of classes with the decorator ``described`` from the classes."""

    def on_class_instance(self, *, cls, **_):
        if any(decorator.callable_path.endswith("described") for decorator in cls.decorators):
            made = getattr(import_module(cls.module.path), cls.name)
            cls.docstring = Docstring(inspect.getdoc(made), parent=cls)
