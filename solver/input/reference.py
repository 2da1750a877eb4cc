"""The format of model files for readers and editors: a reference, a JSON schema, a file to start
from; all made of the classes that read it."""

import re
import tomllib
from inspect import cleandoc, getdoc
from pathlib import Path
from typing import NamedTuple, get_args

from pydantic import BaseModel
from pydantic_core import PydanticUndefined

from .model_file import Calibration, ModelFile
from .values import Sourced, Strict

EXAMPLES = Path(__file__).with_name("examples.toml")
START = Path(__file__).with_name("panel.toml")

TITLES = {"Parameters": "[parameters]", "Material": "[materials.NAME]",
          "Limits": "strength of [materials.NAME]", "Layers": "[laminates.NAME]",
          "Layer": "plies of [laminates.NAME]", "SectionOf": "[[sections]]",
          "Group": "[groups.NAME]", "Geometry": "[geometry]",
          "Block": "[[geometry.blocks]]", "Sphere": "[geometry.sphere]",
          "Cylinder": "[geometry.cylinder]", "Refinement": "[[meshes]]", "Defaults": "[defaults]",
          "History": "[histories.NAME]", "Load": "[[loads]]", "Held": "[[supports]]",
          "Where": "where of nodes", "Driven": "[[drives]]", "MassAt": "[[masses]]",
          "SpringBetween": "[[springs]]", "SpringToGround": "[[ground_springs]]",
          "Foundation": "[[foundations]]", "BodyOf": "[[bodies]]", "JointOf": "[[joints]]",
          "Damped": "[damping]", "Probed": "[probes.NAME]",
          "Sector": "[cyclic]", "RigidMotion": "[motion]",
          "Static": "[[steps]], static", "Dynamic": "[[steps]], dynamic", "Output": "[output]",
          "Paper": "[paper]", "ModelFile": "the file"}
"""What the tables are called in a file."""


class Key(NamedTuple):
    """A key of a table: whether it is needed, its default, what it is with its unit, an example."""

    name: str
    needed: bool
    default: str
    about: str
    example: str


def tables():
    """``{heading: (what it is, [Key])}`` of everything that can stand in a model file."""
    with open(EXAMPLES, "rb") as file:
        examples = tomllib.load(file)
    return {TITLES[kind.__name__]: (_summary(kind), _keys(kind, examples[kind.__name__]))
            for kind in _kinds(ModelFile)}


def as_text():
    """The reference as text."""
    parts = ["A model file is a TOML file.  SI units.  A value is plain, or a table with value, "
             "unit,\nprovenance and source."]
    for heading, (about, keys) in tables().items():
        lines = [f"{heading}: {about}"]
        for key in keys:
            given = "needed" if key.needed else f"default {key.default}" if key.default else ""
            lines.append(f"  {key.name:<14} {key.about}" + (f" ({given})" if given else ""))
            lines.append(f"  {'':<14} example: {key.example}")
        parts.append("\n".join(lines))
    return "\n\n".join(parts)


def json_schema():
    """The JSON schema, for editors."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema",
            **ModelFile.model_json_schema()}


def _kinds(kind, found=None):
    """The classes of tables that stand in a table of ``kind``, itself first."""
    found = {} if found is None else found
    if kind not in found and kind not in (Sourced, Calibration):
        found[kind] = None
        for field in kind.model_fields.values():
            for inner in _inside(field.annotation):
                _kinds(inner, found)
    return list(found)


def _inside(annotation):
    """Classes of tables in an annotation."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [] if issubclass(annotation, Sourced) else [annotation]
    return [kind for part in get_args(annotation) for kind in _inside(part)]


def _keys(kind, examples):
    about = _attributes(kind)
    return [Key(name, field.is_required(), _default(field.default), about[name], examples[name])
            for name, field in kind.model_fields.items()]


def _default(default):
    if default is PydanticUndefined or default is None or default in ([], {}, ""):
        return ""
    if isinstance(default, BaseModel):
        return ""
    return str(default).lower() if isinstance(default, bool) else str(default)


def _summary(kind):
    return " ".join(getdoc(kind).partition("\n\n")[0].replace("``", "").split())


def _attributes(kind):
    """``{name: text}`` of the sections ``Attributes`` of a class and of what it is made of."""
    texts = [cleandoc(one.__doc__ or "").partition("Attributes:\n")[2]
             for one in reversed(kind.__mro__) if issubclass(one, Strict)]
    entries = re.findall(r"^ {4}(\w+): (.*(?:\n {8}.*)*)", "\n".join(texts), re.MULTILINE)
    return {name: re.sub(r"\s+", " ", about).replace("``", "").rstrip(".")
            for name, about in entries}
