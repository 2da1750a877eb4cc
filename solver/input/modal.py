"""What ``corovec modes`` and ``corovec buckling`` compute of a model file."""

import numpy as np

from ..modes.buckling import buckling
from ..modes.vibration import modes
from ..names import printable
from ..statics.load_control import load_control
from .files import find_model, read_model


def modes_of(model, elements=None, number=10, unloaded=False):
    """Modes of a model file about the equilibrium of its static step, where it has one.

    Args:
        model: path of a file, or name of a benchmark.
        elements: of the mesh; left out, those of a run.
        number: how many modes.
        unloaded: about the initial shell nevertheless.

    Returns:
        (``Modes``, summary as plain values).
    """
    definition, elements = _read(model, elements)
    static = None if unloaded else definition.static
    shell = definition.model(elements, loads=static and static.loads,
                             rising=bool(static and definition.dynamic))
    state = None
    if static:
        state = load_control(shell, np.linspace(0.0, 1.0, static.increments + 1)[1:])
    found = modes(shell, number, state)
    return found, {**_about(definition, shell), "about": "the static step" if state else
                   "the initial shell", "mass": found.mass, "centre": found.centre.tolist(),
                   "modes": found.frame().to_dict("list")}


def buckling_of(model, elements=None, number=3):
    """Linear buckling of a model file under the loads of its static step, or all without one.

    Returns:
        (``Buckling``, summary as plain values).
    """
    definition, elements = _read(model, elements)
    static = definition.static
    shell = definition.model(elements, loads=static and static.loads,
                             rising=bool(static and definition.dynamic))
    found = buckling(shell, number)
    return found, {**_about(definition, shell), "shapes": found.frame().to_dict("list")}


def _read(model, elements):
    definition = read_model(find_model(model))
    return definition, definition.elements if elements is None else elements


def _about(definition, shell):
    return {"model": printable(definition.heading), "elements": len(shell.quads),
            "nodes": len(shell.nodes)}
