"""What ``corovec check`` says of a model file, and its picture."""

from collections import Counter
from pathlib import Path

import numpy as np

from corovec.solver.cli import show
from corovec.solver.errors import InputError
from corovec.solver.input.files import find_model, read_model
from corovec.solver.model.attached import GroundSpring, PointMass, Spring
from corovec.solver.model.constants import local_frames
from corovec.solver.model.loads import Drive
from corovec.solver.model.mechanism import summary as of_mechanism
from corovec.solver.model.mesh import vector_areas
from corovec.solver.names import printable
from corovec.solver.results.files import writable_path
from corovec.solver.runtime.provenance import body

from .shells import whole_model
from .style import FORMATS, save


def check_model(model, elements=None, output=None, view=None, overwrite=False, as_json=False):
    """Print what a model is, and draw it.

    Raises:
        InputError: all errors of its file, or no such mesh.
        ResultFileError: the picture exists, or cannot be written.
    """
    path = find_model(model)
    picture = Path(output or f"{path.stem}-check.png")
    if picture.suffix.removeprefix(".") not in FORMATS:
        raise InputError(f"output {picture}: must end in one of: "
                         f"{', '.join(f'.{name}' for name in FORMATS)}")
    writable_path(picture, overwrite)
    definition = read_model(path)
    elements = definition.elements if elements is None else elements
    shell = definition.model(elements)
    figure, data = whole_model(shell, definition, view)
    written = save(figure, data, picture.parent, picture.stem, (picture.suffix[1:],), overwrite)
    show({"model": printable(definition.heading), **summary(definition, shell),
          "picture": printable(str(written[0]))}, as_json)


def summary(definition, shell):
    """What a model is, as plain values."""
    mesh = definition.mesh(len(shell.quads))
    corners = shell.nodes[shell.quads]
    slender = shell.thickness / np.sqrt(np.linalg.norm(vector_areas(corners), axis=1))
    warp = _warp(corners)
    steps = [step.kind for step in definition.steps] or ["dynamic"]
    return {
        "elements": len(shell.quads), "nodes": len(shell.nodes), "body": body(shell),
        "extent": np.ptp(shell.nodes, axis=0).tolist(),
        "thickness": [float(shell.thickness.min()), float(shell.thickness.max())],
        "thickest_element": {"number": int(slender.argmax()),
                             "thickness over size": float(slender.max())},
        "most_warped_element": {"number": int(warp.argmax()), "angle [deg]": float(warp.max())},
        "edges": shell.folds._asdict(),
        "groups": {name: len(numbers) for name, numbers in mesh.groups.items()} or None,
        "node_sets": {name: len(numbers) for name, numbers in mesh.node_sets.items()} or None,
        "loads": {printable(load.name): load.kind for load in definition.loads} or None,
        "held_nodes": int(shell.fixed.any(axis=1).sum()), **_attached(shell),
        **of_mechanism(shell.mechanism),
        "probes": {name: _probe(probe) for name, probe in definition.probes.items()} or None,
        "steps": ", ".join(steps)}


def _probe(probe):
    """What a probe records."""
    if probe.joint:
        return f"joint {printable(probe.joint)}"
    return "stress" if probe.stress else f"energy of {probe.energy}"


def _attached(shell):
    """What moves, is attached to nodes, and damps."""
    moved = {node for support in shell.supports if isinstance(support, Drive)
             for node in support.nodes}
    counts = Counter(type(item) for item in shell.attached)
    return {
        "moved_nodes": len(moved) or None,
        "point_masses": {"number": counts[PointMass], "kg": sum(
            item.mass for item in shell.attached if isinstance(item, PointMass))}
        if counts[PointMass] else None,
        "springs": counts[Spring] or None, "springs_to_the_ground": counts[GroundSpring] or None,
        "damping": {"mass [1/s]": shell.damping.mass, "stiffness [s]": shell.damping.stiffness}
        if shell.damping else None}


def _warp(corners):
    """(n_elem,) largest angle between the normal of an element and those at its corners [deg]."""
    around = np.roll(corners, -1, axis=1) - corners
    at = np.cross(np.roll(around, 1, axis=1), around)
    at /= np.linalg.norm(at, axis=2, keepdims=True)
    cosine = np.einsum("eic,ec->ei", at, local_frames(corners)[:, 2])
    return np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))).max(axis=1)
