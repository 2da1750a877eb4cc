"""Figures in space: the mesh with its loads, and the deformed shell at several instants."""

from typing import Annotated, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.offsetbox import AnchoredOffsetbox, AuxTransformBox, HPacker, TextArea, VPacker
from matplotlib.patches import FancyArrowPatch
from scipy.spatial import cKDTree

from corovec.solver.checks import numbers, shown
from corovec.solver.errors import InputError
from corovec.solver.input.model_file import ModelFile
from corovec.solver.model.histories import CONSTANT, FunctionOfTime
from corovec.solver.model.loads import NodalLoad
from corovec.solver.names import mathtext
from corovec.solver.signatures import checked

from .recording import Recording
from .space import (
    ARROW,
    DENSITY,
    Space,
    View,
    best_view,
    bounds,
    density_bar,
    density_scale,
    hidden,
)
from .style import BLUE, CURVES, GREEN, VERMILLION, WIDTH, styled

LONGEST = 0.22
"""Longest arrow of each unit of force relative to the size of the mesh."""

PARTS = 24
"""Parts of an arrow that are hidden behind the shell or not."""

OUTWARD = 0.2
"""Weight of the distance from the middle of the mesh beside that from its nodes."""

MOVED = 0.5
"""A shell that travels this multiple of its size has its way drawn above its frames."""

HIGHEST = 0.45
"""Largest height of the picture of a way relative to its width."""

MOST_NAMED = 11
"""Instants along a way that have their times beside them, at most."""

COLUMNS = {12: 4, 20: 5}
"""Most frames, and in how many columns they stand; of more, in ``MOST_COLUMNS``."""

MOST_COLUMNS = 7

FRAMES = 8
"""Instants of a sequence, if none are asked for."""


class Drawn(NamedTuple):
    """A load: forces (n, 3) at their largest with their unit, N/m for a line load of a case; its
    function of time with the label of its axis."""

    name: str
    nodes: list
    forces: np.ndarray
    unit: str
    function: str
    history: FunctionOfTime
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

    Figs. 2, 7, 10, 14.  An arrow pushes or pulls at the node that it touches; forces and forces per
    length have each a scale, told by an arrow of round size.  What lies behind the shell is
    hollow and dashed.

    Args:
        model: ``Model``, whose moments and pressures are not drawn, or anything else
            with ``nodes`` and ``quads``.
        case: ``Case`` of the model, for the names of its loads and points; line
            loads are then forces per length [N/m], the same at all nodes of the line.
        view: (elevation, azimuth) [degrees]; default: where most is seen.

    Returns:
        (Figure, DataFrame): rows ``item`` = element (its corners x, y, z), load (x, y, z of its
        node, the drawn force fx, fy, fz and its unit), point, or function (``time``, ``value``).
    """
    corners = model.nodes[model.quads]
    loads = _nodal_loads(model) if case is None else _case_loads(model, case)
    points = {name: point.value for name, point in case.points.items()} if case else {}
    varying = [load for load in loads if load.history.settled > 0.0]
    functions = {load.function: load.history for load in varying}
    view = best_view(corners) if view is None else View(*view)
    scales = _scales(model, loads)
    ends = [_arrows(model, load, scales) for load in loads]
    box = bounds(model.nodes, *ends)
    beside = 0.3 + 0.2 * len(scales)
    height = max(0.5 + 0.72 * WIDTH * view.aspect(box), 1.9 + beside)
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    spare = max(0.01, 0.5 * (height - 1.9 - beside))
    grid = figure.add_gridspec(4, 1 + bool(loads), width_ratios=(3.4, 1.0)[:1 + bool(loads)],
                               height_ratios=(spare, 1.7, beside, spare))
    space = Space(figure.add_subplot(grid[:, 0]), view, box)
    space.elements(corners[None], facecolor="0.92", edge="0.4", line=0.4)
    covered = [np.reshape(hidden(view, _middles(arrows), corners), (-1, PARTS)) for arrows in ends]
    for arrows, each in zip(ends, covered):
        for (tail, tip), parts in zip(arrows, each):
            space.arrow(tail, tip, parts)
    behind = dict(zip(points, hidden(view, list(points.values()), corners)))
    for name, point in points.items():
        space.dot(point, BLUE, behind[name])
    held = model.nodes[sorted({node for support in getattr(model, "supports", ())
                               for node in support.nodes})]
    for point, covered_ in zip(held, hidden(view, held, corners)):
        space.dot(point, GREEN, covered_, size=3.0, marker="s")
    if functions:
        _draw_functions(figure.add_subplot(grid[1, 1]), functions,
                        dict.fromkeys(load.label for load in varying))
    if loads:
        _draw_scales(figure.add_subplot(grid[2, 1]), space, scales, LONGEST * model.size,
                     any(map(np.any, covered)) or any(behind.values()))
    space.names([*_load_names(space, loads, ends, model.nodes), *(
        (point, name, (1.0, -1.0), {"color": BLUE, "weight": "bold"})
        for name, point in points.items())],
        [(model.nodes, 0.5), *((_middles(arrows), 10.0) for arrows in ends),
         *((point, 20.0) for point in points.values())])
    return figure, _mesh_table(model, loads, points, functions)


@checked
@styled
def sequence(recording: Recording, times: Annotated[tuple, _times] = None, scale: float = 1.0,
             view: Angles = None):
    """Deformed shells at several instants, coloured by strain energy density.

    Figs. 6, 9, 13, 17.  Frame beside frame, all with the same axes.  Those of a shell that travels
    are each about its centre, the mean over the initial area, which is the mass centre of an even
    shell; above them is the way of the centre, with the shell where it stands clear of others.

    Args:
        recording: ``Recording``.
        times: [s], in statics load factors; the nearest frames are taken.  Default: 8 evenly.
        scale: factor of the displacements.
        view: as of ``mesh_and_loads``.

    Returns:
        (Figure, DataFrame): columns time, element, corner, x, y, z, strain_energy_density [J/m^2],
        and centre_x, centre_y, centre_z of a shell that travels.

    Raises:
        InputError: a time outside the recorded ones.
    """
    if times is None:
        frames = np.unique(np.linspace(0, len(recording.times) - 1, FRAMES).round().astype(int))
    else:
        frames = recording.frames_at(times)
    corners = recording.positions(scale)[frames][:, recording.quads]
    density, times = recording.energy_density[frames], recording.times[frames]
    centres = np.average(corners.mean(axis=2), axis=1, weights=recording.areas)
    travels = np.ptp(centres, axis=0).max() > MOVED * np.ptp(recording.nodes, axis=0).max()
    framed = corners - centres[:, None, None] if travels else corners
    view = best_view(framed.reshape(-1, 4, 3)) if view is None else View(*view)
    captions = [instant(recording, time) for time in times]
    way = (corners, centres) if travels and len(frames) > 1 else None
    figure = side_by_side(framed, density, captions, view, way)
    n, n_elem = corners.shape[:2]
    x, y, z = corners.reshape(-1, 3).T
    return figure, pd.DataFrame({
        "factor" if recording.static else "time": np.repeat(times, 4 * n_elem),
        "element": np.tile(np.repeat(np.arange(n_elem), 4), n),
        "corner": np.tile(np.arange(4), n * n_elem), "x": x, "y": y, "z": z,
        "strain_energy_density": np.repeat(density.ravel(), 4),
        **({f"centre_{c}": np.repeat(centres[:, k], 4 * n_elem) for k, c in enumerate("xyz")}
           if travels else {})})


def instant(recording, time):
    """What is written beside a frame."""
    return f"λ = {time:.4g}" if recording.static else f"{time:.4g} s"


def side_by_side(corners, density, captions, view, way=None, label=DENSITY):
    """A panel for each frame (n, n_elem, 4, 3), all of one scale, below the ``way`` (corners and
    centres on it) if there is one."""
    most = next((columns for n, columns in COLUMNS.items() if len(corners) <= n), MOST_COLUMNS)
    columns, scale = min(most, len(corners)), density_scale(density)
    seen = view(corners).reshape(-1, 2)
    (left, low), (right, high) = seen.min(axis=0), seen.max(axis=0)
    heights = [0.25 + 0.95 * WIDTH / columns * (high - low) / (right - left)] * -(
        -len(corners) // columns)
    if way:
        heights.insert(0, 0.3 + WIDTH * min(HIGHEST, 0.8 * view.aspect(bounds(way[0]))))
    figure = Figure(figsize=(WIDTH, 0.65 + sum(heights)), layout="constrained")
    grid = figure.add_gridspec(len(heights), columns, height_ratios=heights)
    panels = [figure.add_subplot(grid[bool(way) + k // columns, k % columns])
              for k in range(len(corners))]
    looks = {"norm": scale.norm, "cmap": scale.cmap, "edge": (0.0, 0.0, 0.0, 0.45), "line": 0.15}
    for k, caption in enumerate(captions):
        space = Space(panels[k], view, bounds(corners), ruled=False)
        space.elements(corners[k:k + 1], array=density[k:k + 1], **looks)
        panels[k].set(xlim=(left, right), ylim=(low, high))
        panels[k].set_title(caption, size=7.5, pad=3.0)
    space.scale_bar()
    density_bar(figure, scale, density, panels, label, location="bottom", shrink=0.5, aspect=35)
    if way:
        _draw_way(figure.add_subplot(grid[0, :]), *way, density, captions, view, looks)
    return figure


def _draw_way(axes, corners, centres, density, captions, view, looks):
    """The line of the centres, a dot for each instant, and the shell where it stands clear."""
    space = Space(axes, view, bounds(corners))
    seen = view(corners.reshape(len(corners), -1, 3))
    shells, size = _clear(seen), np.ptp(seen, axis=1).max() / np.ptp(seen, axis=(0, 1)).max()
    space.elements(corners[shells], array=density[shells],
                   **{**looks, "edge": (0.0, 0.0, 0.0, min(0.45, 2.0 * size))})
    line, dots = {"linewidth": 0.5, "zorder": 1.5}, {"marker": ".", "markersize": 3.0, "zorder": 4}
    for looks in (line, {"linestyle": "", "markeredgewidth": 0.0, **dots}):
        axes.plot(*view(centres).T, color="0.1", clip_on=False, **looks)
    named = range(0, len(captions), -(-len(captions) // MOST_NAMED))
    space.names([(centres[k], captions[k], (1.0, -1.0), {"size": 7.0}) for k in named],
                [(corners[shells].mean(axis=2), 0.5)])


def _clear(seen):
    """Numbers of the shells ``seen`` on the screen (n, n_points, 2) whose boxes are apart: the
    first, the last, and of the others each that is clear of those before."""
    low, high = seen.min(axis=1), seen.max(axis=1)
    kept = []
    for k in (0, *range(len(seen) - 1, 0, -1)):
        if all(np.any((low[k] > high[one]) | (high[k] < low[one])) for one in kept):
            kept.append(k)
    return sorted(kept)


def _nodal_loads(model):
    """The forces of a model, those with one function of time together."""
    found = {}
    for load in getattr(model, "loads", ()):
        if isinstance(load, NodalLoad):
            found.setdefault(load.history, []).append(load)
    names = [f"f{k}" for k in range(1, len(found) + 1)] if len(found) > 1 else ["f"]
    return [Drawn("", [load.node for load in loads],
                  np.array([load.force for load in loads]) * _peak(history), "N", name, history,
                  f"{name}(t) [–]")
            for name, (history, loads) in zip(names, found.items())]


def _case_loads(model, case):
    """The loads of a case by their names."""
    drawn, mesh = [], case.mesh(len(model.quads))
    for load in case.loads:
        if not load.force:
            continue
        definition = case.histories.get(load.history)
        history = definition.function() if definition else CONSTANT
        unit = definition and (definition.peak.unit if definition.peak else definition.unit)
        nodes = [one.node for one in load.made(mesh)]
        force = np.array(load.force.value) * _peak(history)
        drawn.append(Drawn(load.name, nodes, np.tile(force, (len(nodes), 1)), load.unit,
                           load.history, history, f"{load.history}(t) [{unit or '–'}]"))
    return drawn


def _peak(history):
    """The value of largest size of a time function."""
    return float(max(history.curve()[1], key=abs))


def _scales(model, loads):
    """``{unit: length of an arrow [m] per size of a force}``, the longest of each unit alike."""
    largest = {}
    for load in loads:
        size = np.linalg.norm(load.forces, axis=1).max()
        largest[load.unit] = max(size, largest.get(load.unit, 0.0))
    return {unit: LONGEST * model.size / size for unit, size in largest.items() if size > 0.0}


def _arrows(model, load, scales):
    """(n, 2, 3) tails and tips of the arrows of a load, which touch their nodes from that side
    where they are farther from the mesh and its middle."""
    arrows = scales.get(load.unit, 0.0) * load.forces
    at, mesh = model.nodes[load.nodes], cKDTree(model.nodes)
    before, after = (np.mean(mesh.query(ends)[0] + OUTWARD * np.linalg.norm(
        ends - mesh.data.mean(axis=0), axis=1)) for ends in (at - arrows, at + arrows))
    tails = at - arrows if before > after * (1.0 + 1e-9) else at
    return np.stack([tails, tails + arrows], axis=1)


def _middles(arrows):
    """(n, PARTS, 3) middles of the equal parts of arrows (n, 2, 3)."""
    part = (np.arange(PARTS)[:, None] + 0.5) / PARTS
    return arrows[:, :1] + part * (arrows[:, 1:] - arrows[:, :1])


def _load_names(space, loads, ends, nodes):
    """What ``Space.names`` takes of loads: a name lies beyond that end of the middle arrow which is
    not at a node."""
    for load, arrows in zip(loads, ends):
        arrow, at = arrows[len(arrows) // 2], nodes[load.nodes[len(load.nodes) // 2]]
        free = arrow[np.argmax(np.linalg.norm(arrow - at, axis=1))]
        if load.name:
            yield free, load.name, space.view(free - at), {"color": VERMILLION}


def _round(size):
    """The largest of 1, 2, 5, 10, ... that is not above ``size``."""
    power = 10.0 ** np.floor(np.log10(size))
    return max(step for step in (1.0, 2.0, 5.0) if step * power <= size * (1.0 + 1e-9)) * power


def _draw_scales(axes, space, scales, longest, behind):
    """An arrow of round size for each unit, as long as it is in ``space`` square to the eye, next
    to the ``longest`` [m], and what hollow means if anything lies ``behind`` the shell."""
    axes.axis("off")
    words = {"size": 7.0}
    rows = [TextArea("at the largest, to scale:", textprops=words)] if scales else []
    for unit, scale in scales.items():
        size = _round(longest / scale)
        arrow = AuxTransformBox(space.axes.transData)
        arrow.add_artist(FancyArrowPatch((0.0, 0.0), (size * scale, 0.0), color=VERMILLION,
                                         **ARROW))
        rows.append(HPacker(children=[arrow, TextArea(f"{size:g} {unit}", textprops=words)],
                            pad=0.0, sep=4.0, align="center"))
    if behind:
        rows.append(TextArea("hollow, dashed: behind the shell", textprops=words))
    axes.add_artist(AnchoredOffsetbox("upper center", child=VPacker(
        children=rows, pad=0.0, sep=3.0, align="center"), frameon=False, pad=0.0, borderpad=0.0,
        bbox_to_anchor=(0.5, 1.0), bbox_transform=axes.transAxes))


def _draw_functions(axes, functions, labels):
    for (name, history), (colour, dashes) in zip(functions.items(), CURVES):
        axes.plot(*history.curve(), color=colour, linestyle=dashes,
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
                                   "unit": load.unit, "function": load.function}))
    for name, (x, y, z) in points.items():
        parts.append(pd.DataFrame({"item": "point", "name": [name], "x": x, "y": y, "z": z}))
    for name, history in functions.items():
        parts.append(pd.DataFrame({"item": "function", "name": name,
                                   **dict(zip(("time", "value"), history.curve()))}))
    return pd.concat(parts, ignore_index=True)
