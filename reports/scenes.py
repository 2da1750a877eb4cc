"""Figures in space: the mesh with its loads, and the deformed shell at several instants."""

from typing import Annotated, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.spatial import cKDTree

from corovec.solver.checks import numbers, shown
from corovec.solver.errors import InputError
from corovec.solver.input.schema import ModelFile
from corovec.solver.model.histories import TimeFunction
from corovec.solver.model.loads import NodalLoad
from corovec.solver.model.mesh import element_edges
from corovec.solver.names import mathtext
from corovec.solver.signatures import checked

from .recording import Recording
from .space import Space, View, best_view, bounds, density_bar, density_scale
from .style import BLUE, CURVES, VERMILLION, WIDTH, styled

ARROW = 0.22
"""Longest arrow relative to the size of the mesh."""

OUTWARD = 0.2
"""Weight of the distance from the middle of the mesh beside that from its nodes."""

MOVED = 0.5
"""A shell that travels this multiple of its size is drawn along its way, else frame by frame."""

MOST_NAMED = 21
"""Frames along a way that have their times beside them, at most."""

FRAMES = 8
"""Instants of a sequence, if none are asked for."""


class Drawn(NamedTuple):
    """A load: forces (n, 3) at their largest [N], per length for a line load of a case [N/m]; its
    function of time with the label of its axis."""

    name: str
    nodes: list
    forces: np.ndarray
    function: str
    history: TimeFunction
    label: str


def _shell(name, model):
    """Anything with nodes and quads."""
    if isinstance(model, type) or not (hasattr(model, "nodes") and hasattr(model, "quads")):
        raise InputError(f"{name} must be a Model or a Recording, is {shown(model)}")
    return model


def _angles(name, view):
    """An elevation and an azimuth [degrees]."""
    items = numbers(name, view)
    if len(items) != 2:
        raise InputError(f"{name} must be (elevation, azimuth), is {shown(view)}")
    return items


def _times(name, times):
    items = numbers(name, times)
    if not items:
        raise InputError(f"{name} must not be empty")
    return items


Angles = Annotated[tuple, _angles]


@checked
@styled
def mesh_and_loads(model: Annotated[object, _shell], case: ModelFile = None, view: Angles = None):
    """The undeformed mesh with its loads at their largest, and their functions of time.

    Figs. 2, 7, 10, 14.  An arrow pushes or pulls at the node that it touches; the longest one is
    that of the largest force.

    Args:
        model: ``Model``, whose moments and pressures are not drawn, or anything else
            with ``nodes`` and ``quads``.
        case: ``Case`` of the model, for the names of its loads and points; line
            loads are then forces per length [N/m], the same at all nodes of the line.
        view: (elevation, azimuth) [degrees]; default: where most is seen.

    Returns:
        (Figure, DataFrame): rows ``item`` = element (its corners x, y, z), load (x, y, z of its
        node and the drawn force fx, fy, fz), point, or function (``time``, ``value``).
    """
    corners = model.nodes[model.quads]
    loads = _nodal_loads(model) if case is None else _case_loads(model, case)
    points = {name: point.value for name, point in case.points.items()} if case else {}
    varying = [load for load in loads if len(load.history.times) > 1]
    functions = {load.function: load.history for load in varying}
    view = best_view(corners) if view is None else View(*view)
    ends = [_arrows(model, load, loads) for load in loads]
    box = bounds(model.nodes, *ends)
    height = max(0.5 + 0.72 * WIDTH * view.aspect(box), 2.0)
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    widths, heights = (3.4, 1.0) if functions else (1.0,), (height - 1.7, 3.4, height - 1.7)
    grid = figure.add_gridspec(3, len(widths), width_ratios=widths, height_ratios=heights)
    space = Space(figure.add_subplot(grid[:, 0]), view, box)
    space.elements(corners[None], facecolor="0.92", edge="0.4", line=0.4)
    for load, arrows in zip(loads, ends):
        for tail, tip in arrows:
            space.arrow(tail, tip)
        _name_load(space, load, arrows[len(arrows) // 2], model.nodes)
    for name, point in points.items():
        space.dot(point, BLUE)
        space.text(point, name, (8.0, -8.0), color=BLUE, weight="bold")
    if functions:
        _draw_functions(figure.add_subplot(grid[1, 1]), functions,
                        dict.fromkeys(load.label for load in varying))
    return figure, _mesh_table(model, loads, points, functions)


@checked
@styled
def sequence(recording: Recording, times: Annotated[tuple, _times] = None, scale: float = 1.0,
             view: Angles = None):
    """Deformed shells at several instants, coloured by strain energy density.

    Figs. 6, 9, 13, 17.  A shell that travels is drawn along its way, in one space; one that stays
    where it is, frame beside frame, all with the same axes.

    Args:
        recording: ``Recording``.
        times: [s], in statics load factors; the nearest frames are taken.  Default: 8 evenly.
        scale: factor of the displacements.
        view: as of ``mesh_and_loads``.

    Returns:
        (Figure, DataFrame): columns time, element, corner, x, y, z, strain_energy_density [J/m^2].

    Raises:
        InputError: a time outside the recorded ones.
    """
    if times is None:
        frames = np.unique(np.linspace(0, len(recording.times) - 1, FRAMES).round().astype(int))
    else:
        frames = recording.frames_at(times)
    corners = recording.positions(scale)[frames][:, recording.quads]
    density, times = recording.energy_density[frames], recording.times[frames]
    view = best_view(corners.reshape(-1, 4, 3)) if view is None else View(*view)
    centres = corners.mean(axis=(1, 2))
    travels = np.ptp(centres, axis=0).max() > MOVED * np.ptp(recording.nodes, axis=0).max()
    drawn = (corners, density, density_scale(density),
             [instant(recording, time) for time in times], view)
    figure = (_way(*drawn, _outline(recording.quads)) if travels and len(frames) > 1
              else _frames(*drawn))
    n, n_elem = corners.shape[:2]
    x, y, z = corners.reshape(-1, 3).T
    return figure, pd.DataFrame({
        "factor" if recording.static else "time": np.repeat(times, 4 * n_elem),
        "element": np.tile(np.repeat(np.arange(n_elem), 4), n),
        "corner": np.tile(np.arange(4), n * n_elem), "x": x, "y": y, "z": z,
        "strain_energy_density": np.repeat(density.ravel(), 4)})


def _outline(quads):
    """(n, 3): element and two of its corners, of each side that it shares with no other."""
    ends = np.sort(element_edges(quads), axis=1)
    _, first, count = np.unique(ends, axis=0, return_index=True, return_counts=True)
    elements, corners = np.divmod(first[count == 1], 4)
    return np.column_stack([elements, corners, (corners + 1) % 4])


def instant(recording, time):
    """What is written beside a frame."""
    return f"λ = {time:.4g}" if recording.static else f"{time:.4g} s"


def _way(corners, density, scale, captions, view, outline):
    """All frames in one space, each with its outline."""
    box = bounds(corners)
    figure = Figure(figsize=(WIDTH, 0.5 + 0.75 * WIDTH * view.aspect(box)), layout="constrained")
    space = Space(figure.add_subplot(), view, box)
    space.elements(corners, array=density, norm=scale.norm, cmap=scale.cmap, edge="face",
                   line=0.15)
    space.lines(corners[:, outline[:, 0, None], outline[:, 1:]])
    points = corners.reshape(len(corners), -1, 3)
    named = range(0, len(captions), -(-len(captions) // MOST_NAMED))
    for k in named:
        seen, others = view(points[k]), cKDTree(view(np.delete(points, k, axis=0)).reshape(-1, 2))
        free = np.argmax(others.query(seen)[0])
        way = seen[free] - seen.mean(axis=0)
        space.text(points[k][free], captions[k], 9.0 * way / np.linalg.norm(way), size=7.0)
    density_bar(figure, scale, density, space.axes, shrink=0.7, aspect=25)
    return figure


def _frames(corners, density, scale, captions, view):
    """A panel for each frame, all of one scale."""
    columns, box = min(4, len(corners)), bounds(corners)
    rows = -(-len(corners) // columns)
    height = 0.7 + rows * (0.25 + WIDTH / columns * view.aspect(box))
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for panel in panels[len(captions):]:
        panel.remove()
    for k, caption in enumerate(captions):
        space = Space(panels[k], view, box, ruled=False)
        space.elements(corners[k:k + 1], array=density[k:k + 1], norm=scale.norm, cmap=scale.cmap,
                       line=0.12)
        panels[k].set_title(caption)
    space.scale_bar()
    density_bar(figure, scale, density, list(panels[:len(captions)]), location="bottom",
                shrink=0.5, aspect=35)
    return figure


def _nodal_loads(model):
    """The forces of a model, those with one function of time together."""
    found = {}
    for load in getattr(model, "loads", ()):
        if isinstance(load, NodalLoad):
            found.setdefault(load.history, []).append(load)
    names = [f"f{k}" for k in range(1, len(found) + 1)] if len(found) > 1 else ["f"]
    return [Drawn("", [load.node for load in loads],
                  np.array([load.force for load in loads]) * _peak(history), name, history,
                  f"{name}(t) [–]")
            for name, (history, loads) in zip(names, found.items())]


def _case_loads(model, case):
    """The loads of a case by their names."""
    drawn = []
    for load in case.loads:
        definition = case.histories[load.history]
        history = definition.function()
        unit = definition.peak.unit if definition.peak else definition.unit
        nodes = [one.node for one in load.nodal(model.nodes, model.quads, history)]
        force = np.array(load.force.value) * _peak(history)
        drawn.append(Drawn(load.name, nodes, np.tile(force, (len(nodes), 1)), load.history,
                           history, f"{load.history}(t) [{unit or '–'}]"))
    return drawn


def _peak(history):
    """The value of largest size of a time function."""
    return max(history.values, key=abs)


def _arrows(model, load, loads):
    """(n, 2, 3) tails and tips of the arrows of a load, which touch their nodes from that side
    where they are farther from the mesh and its middle."""
    largest = max(np.linalg.norm(one.forces, axis=1).max() for one in loads)
    arrows = ARROW * model.size / (largest or 1.0) * load.forces
    at, mesh = model.nodes[load.nodes], cKDTree(model.nodes)
    before, after = (np.mean(mesh.query(ends)[0] + OUTWARD * np.linalg.norm(
        ends - mesh.data.mean(axis=0), axis=1)) for ends in (at - arrows, at + arrows))
    tails = at - arrows if before > after * (1.0 + 1e-9) else at
    return np.stack([tails, tails + arrows], axis=1)


def _name_load(space, load, arrow, nodes):
    """The load's name beyond that end of its middle arrow which is not at a node."""
    at = nodes[load.nodes[len(load.nodes) // 2]]
    free = arrow[np.argmax(np.linalg.norm(arrow - at, axis=1))]
    way = space.view(free - at)
    space.text(free, load.name, 8.0 * way / (np.linalg.norm(way) or 1.0), color=VERMILLION)


def _draw_functions(axes, functions, labels):
    for (name, history), (colour, dashes) in zip(functions.items(), CURVES):
        axes.plot(history.times, history.values, color=colour, linestyle=dashes,
                  label=f"{mathtext(name)}(t)")
    axes.set(xlabel="time [s]", ylabel=", ".join(map(mathtext, labels)))
    if len(functions) > 1:
        axes.legend()


def _mesh_table(model, loads, points, functions):
    """The table of ``mesh_and_loads``."""
    x, y, z = model.nodes[model.quads.ravel()].T
    parts = [pd.DataFrame({"item": "element", "name": np.repeat(np.arange(len(model.quads)), 4),
                           "x": x, "y": y, "z": z})]
    for load in loads:
        at, forces = model.nodes[load.nodes].T, load.forces.T
        parts.append(pd.DataFrame({"item": "load", "name": load.name,
                                   **dict(zip(("x", "y", "z", "fx", "fy", "fz"), (*at, *forces))),
                                   "function": load.function}))
    for name, (x, y, z) in points.items():
        parts.append(pd.DataFrame({"item": "point", "name": [name], "x": x, "y": y, "z": z}))
    for name, history in functions.items():
        parts.append(pd.DataFrame({"item": "function", "name": name, "time": history.times,
                                   "value": history.values}))
    return pd.concat(parts, ignore_index=True)
