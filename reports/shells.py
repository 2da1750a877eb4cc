"""Figures of the undeformed shell: its mesh with loads, and all that a model file makes of it."""

from typing import Annotated, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.colors import ListedColormap, Normalize, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.offsetbox import AnchoredOffsetbox, DrawingArea, HPacker, TextArea, VPacker
from matplotlib.patches import Rectangle
from scipy.spatial import cKDTree

from corovec.solver.checks import shown
from corovec.solver.errors import InputError
from corovec.solver.input.model_file import ModelFile
from corovec.solver.model.attached import GroundSpring, PointMass, Spring
from corovec.solver.model.directors import fold_edges
from corovec.solver.model.loads import COMPONENTS, Drive
from corovec.solver.model.model import Model
from corovec.solver.names import LONGEST_NAME, mathtext, shortened
from corovec.solver.signatures import checked

from . import arrows
from .arrows import LONGEST
from .space import Angles, Space, View, best_view, bounds, hidden, zigzag
from .style import BLACK, BLUE, CURVES, GREEN, ORANGE, PURPLE, SKY, VERMILLION, WIDTH, styled
from .symbols import KEYS, LOOKS, Drawing, symbols_of

ROW, WORDS = 0.19, {"size": 7.0}
"""Height of a row of the key [inches], and its letters."""

PLAIN = "0.92"
"""Colour of elements."""

TINTS = (SKY, GREEN, "#F0E442", PURPLE, VERMILLION, "0.45", BLUE, ORANGE)
"""Colours of groups of elements, paler."""

PALE = 0.6
"""How much white is in them."""

NORMALS, SHORT = 10, 0.07
"""Most normals that are drawn, and their length relative to the size of the mesh."""

SPRING = PURPLE
"""Colour of springs."""

MOST_MARKS = 150
"""Nodes of a kind that are marked, at most."""

MARKS = {COMPONENTS: "s", COMPONENTS[:3]: "^"}
"""Markers of nodes that are clamped and pinned; others have ``OTHERS`` in turn."""

OTHERS = "Dv<>Pph8"

HELD = {COMPONENTS: "clamped", COMPONENTS[:3]: "pinned"}

DRIVEN, MASS, TO_GROUND = "X", "o", r"$\wr$"
"""Markers of nodes that are moved, of point masses, of springs to the ground."""


class Marks(NamedTuple):
    """Nodes of a kind: what is there, in words, and how it looks.

    Attributes:
        nodes: their numbers.
        name: which components are held, or what is attached.
        marker: of matplotlib.
        item: ``support``, or that of what is attached, in the table.
        colour: of the marker.
    """

    nodes: np.ndarray
    name: str
    marker: str
    item: str = "support"
    colour: str = GREEN

    @property
    def words(self):
        """What the key says."""
        return f"held: {self.name}" if self.item == "support" else self.name


def _shell(name, model):
    """Anything with nodes and quads."""
    if isinstance(model, type) or not (hasattr(model, "nodes") and hasattr(model, "quads")):
        raise InputError(f"{name} must be a Model or a Recording, is {shown(model)}")
    return model


@checked
@styled
def mesh_and_loads(model: Annotated[object, _shell], case: ModelFile = None, view: Angles = None):
    """The undeformed mesh with its loads at their largest, and their functions of time.

    Figs. 2, 7, 10, 14.  An arrow pushes or pulls at the node that it touches; forces, forces per
    length and others have each a scale, told by an arrow of round size.  Joints and rigid bodies
    have symbols, see ``symbols``.  What lies behind the shell is hollow and dashed.

    Args:
        model: ``Model``, or anything else with ``nodes`` and ``quads``.
        case: ``Case`` of the model, for the names of its loads and points; line
            loads are then forces per length [N/m], the same at all nodes of the line.
        view: (elevation, azimuth) [degrees]; default: where most is seen.

    Returns:
        (Figure, DataFrame): rows ``item`` = element (its corners x, y, z), load (x, y, z of its
        node, the drawn force fx, fy, fz and its unit), point, function (``time``, ``value``), a
        kind of joint, body, cuboid or arm of a body, ground (x, y, z of its mark, or of both ends
        of a line of its symbol).
    """
    drawn = arrows.of_model(model) if case is None else arrows.of_case(model, case)
    scene = _Scene(model, drawn, _points(case), view, bool(drawn))
    scene.space.elements(model.nodes[model.quads][None], facecolor=PLAIN, edge="0.4", line=0.4)
    scene.arrows()
    scene.symbols()
    for marks in _held(model):
        scene.marks(marks._replace(marker="s"))
    scene.functions()
    scene.key(scene.scale_rows() + scene.symbol_rows() + scene.hollow_row())
    scene.names()
    return scene.figure, scene.table()


@checked
@styled
def whole_model(model: Model, case: ModelFile, view: Angles = None):
    """All that a model file makes of a mesh: what ``corovec check`` draws.

    Besides ``mesh_and_loads``: a colour for each group of elements, normals, folds, what each
    support holds, prescribed displacements and rotations, point masses, springs, elements whose
    stresses are recorded, and the velocity and spin at the start.  Of many arrows a few are drawn,
    spread over what they act on.

    Args:
        model: ``Model`` of the case.
        case: ``ModelFile``.
        view: (elevation, azimuth) [degrees]; default: where most is seen.

    Returns:
        (Figure, DataFrame): rows as of ``mesh_and_loads``, and ``item`` = group (its ``name`` and
        element), normal (x, y, z and nx, ny, nz), fold and spring (x, y, z of either end), support
        (its node and the components held), mass and ground spring (its node).
    """
    mesh, corners = case.mesh(len(model.quads)), model.nodes[model.quads]
    drawn = arrows.thinned((*arrows.of_case(model, case), *arrows.of_motion(model, case),
                            *arrows.of_supports(model, case)), LONGEST * model.size)
    number, groups = _groups(mesh)
    colours = _tints(groups)
    folds = fold_edges(model.nodes, model.quads, model.fold_angle, model.patches)
    at, normals = _normals(corners, arrows.on_surfaces(drawn))
    marked = [*_held(model), *_attached(model)]
    springs = _springs(model)
    scene = _Scene(model, drawn, {**_points(case), **_probed(model, case)}, view, True,
                   np.stack([at, at + normals * SHORT * model.size], axis=1),
                   1 + len(groups) * (len(groups) > 1) + bool(len(folds)) + bool(len(springs))
                   + len(marked))
    scene.space.elements(corners[None], edge="0.4", line=0.4, array=number[None],
                         cmap=ListedColormap(colours), norm=Normalize(-0.5, len(colours) - 0.5))
    scene.lines(folds, BLACK)
    scene.symbols()
    scene.normals(at, normals)
    scene.springs(springs)
    scene.arrows()
    for marks in marked:
        scene.marks(marks)
    scene.functions()
    rows = [_row(_patch(colour), shortened(name)) for name, colour in zip(groups, colours)]
    scene.key(scene.scale_rows() + (rows if len(groups) > 1 else []) + [
        _row(_line("0.35", 0.8, ">"), "normal of the elements"),
        *([_row(_line(BLACK, 1.6), "fold")] if len(folds) else []),
        *([_row(_zigzag(), "spring")] if len(springs) else []),
        *(_row(_line(marks.colour, 0.0, marks.marker), marks.words) for marks in marked)
    ] + scene.symbol_rows() + scene.hollow_row())
    scene.names()
    lines = {"fold": folds, "spring": springs}
    return scene.figure, pd.concat([scene.table(), *_more(model, mesh, lines, at, normals, marked)],
                                   ignore_index=True)


class _Scene:
    """A model in space on the left; functions of time and a key on the right.

    Attributes:
        figure, space: what is drawn on.
        covered: whether anything lies behind the shell.
    """

    def __init__(self, model, drawn, points, view, beside, further=(), rows=0):
        self.model, self.drawn, self.points = model, drawn, points
        self._corners = model.nodes[model.quads]
        self._symbols = symbols_of(model)
        self._places = self._symbols.at_first
        self._varying = [one for one in drawn if one.function and one.history.settled > 0.0]
        view = best_view(self._corners) if view is None else View(*view)
        self.scales = arrows.scales(model, drawn)
        self.ends = [arrows.ends(model, one, self.scales, view.eye) for one in drawn]
        self.covered = False
        box = bounds(model.nodes, *self.ends, further, self._places)
        rows, beside = rows + len(self._symbols.totals), beside or bool(self._symbols)
        key = 0.3 + ROW * (len(self.scales) + rows)
        above = 1.7 if self._varying or not rows else 0.01
        height = max(0.5 + 0.72 * WIDTH * view.aspect(box), above + 0.2 + key)
        spare = max(0.01, 0.5 * (height - above - 0.2 - key))
        self.figure = Figure(figsize=(WIDTH, height), layout="constrained")
        self._grid = self.figure.add_gridspec(
            4, 1 + beside, width_ratios=(3.4, 1.0)[:1 + beside],
            height_ratios=(spare, above, key, spare))
        self.space = Space(self.figure.add_subplot(self._grid[:, 0]), view, box)

    def _hidden(self, points):
        """Whether points are behind the shell."""
        found = hidden(self.space.view, points, self._corners)
        self.covered |= bool(np.any(found))
        return found

    def arrows(self):
        """The arrows of all that acts, and the points."""
        for one, ends in zip(self.drawn, self.ends):
            covered = np.reshape(self._hidden(arrows.middles(ends)), (-1, arrows.PARTS))
            for (tail, tip), parts in zip(ends, covered):
                self.space.arrow(tail, tip, parts, one.look.colour, one.look.heads)
        places = list(self.points.values())
        for point, covered in zip(places, self._hidden(places)):
            self.space.dot(point, BLUE, covered)

    def normals(self, at, normals):
        """Normals at points."""
        tips = at + normals * SHORT * self.model.size
        for tail, tip, covered in zip(at, tips, self._hidden(tips)):
            self.space.arrow(tail, tip, (covered,), "0.35", linewidth=0.7, mutation_scale=5.0)

    def lines(self, edges, colour):
        """Edges between plates."""
        places = self.model.nodes[edges]
        covered = self._hidden(places.mean(axis=1))
        for ends, behind in zip(places, covered):
            self.space.axes.plot(*self.space.view(ends).T, color="0.5" if behind else colour,
                                 linewidth=0.7 if behind else 1.6, zorder=3, clip_on=False,
                                 linestyle=(0, (2, 1.5)) if behind else "-")

    def symbols(self):
        """Joints and rigid bodies."""
        Drawing(self.space, self._symbols, self._places, self._hidden)

    def symbol_rows(self):
        """How joints and rigid bodies look, and how many there are."""
        return [_row(_symbol(*KEYS[kind]), words) for kind, words in self._symbols.totals.items()]

    def springs(self, ends):
        """Springs between nodes (n, 2)."""
        places = self.model.nodes[ends]
        for (tail, tip), behind in zip(places, self._hidden(places.mean(axis=1))):
            self.space.zigzag(tail, tip, behind, SPRING)

    def marks(self, marks):
        """Nodes that are held, or have something attached."""
        places = self.model.nodes[marks.nodes]
        places = places[arrows.spread(places, MOST_MARKS)]
        for point, covered in zip(places, hidden(self.space.view, places, self._corners)):
            self.space.dot(point, marks.colour, covered, marker=marks.marker,
                           size=5.5 if marks.marker == TO_GROUND else 3.0)

    def functions(self):
        """The functions of time, if loads have any."""
        if not self._varying:
            return
        axes = self.figure.add_subplot(self._grid[1, 1])
        functions = {one.function: one.history for one in self._varying}
        labels = list(dict.fromkeys(one.label for one in self._varying))
        units = dict.fromkeys(label[label.rindex("["):] for label in labels)
        for (name, history), (colour, dashes) in zip(functions.items(), CURVES):
            axes.plot(*history.curve(), color=colour, linestyle=dashes,
                      label=f"{mathtext(shortened(name))}(t)")
        if len(functions) > len(CURVES):
            axes.plot([], [], " ", label=f"{len(functions) - len(CURVES)} others")
        axes.set(xlabel="time [s]", ylabel=", ".join(map(mathtext, (
            labels if len("".join(labels)) <= LONGEST_NAME else units))))
        if len(functions) > 1:
            axes.legend()

    def scale_rows(self):
        """An arrow of round size for each unit, as long as it is in space square to the eye."""
        rows = [TextArea("at the largest, to scale:", textprops=WORDS)] if self.scales else []
        for unit, scale in self.scales.items():
            longest = arrows.LOOKS[arrows.SIZES[unit]].reach * LONGEST * self.model.size
            size = arrows.rounded(longest / scale)
            rows.append(_row(arrows.sample(self.space, unit, size * scale),
                             f"{arrows.SIZES[unit]} {size:g} {unit.replace('^2', '²')}"))
        return rows

    def hollow_row(self):
        """What hollow means, if anything lies behind the shell."""
        return [TextArea("hollow, dashed: behind the shell", textprops=WORDS)] * self.covered

    def key(self, rows):
        """Rows that tell what is what."""
        if not rows:
            return
        axes = self.figure.add_subplot(self._grid[2, 1])
        axes.axis("off")
        axes.add_artist(AnchoredOffsetbox("upper center", child=VPacker(
            children=rows, pad=0.0, sep=3.0, align="left"), frameon=False, pad=0.0, borderpad=0.0,
            bbox_to_anchor=(0.5, 1.0), bbox_transform=axes.transAxes))

    def names(self):
        """The names of what acts and of points, clear of all else."""
        own = {"color": "0.15", "size": 7.0}
        named = [*arrows.names(self.space, self.drawn, self.ends), *(
            (self._places[k], name, (1.0, 1.0), own) for k, name in self._symbols.names.items()), *(
            (point, name, (1.0, -1.0), {"color": BLUE, "weight": "bold"})
            for name, point in self.points.items())]
        self.space.names(
            [(point, shortened(name), *rest) for point, name, *rest in named],
            [(self.model.nodes, 0.5), *((arrows.middles(ends), 10.0) for ends in self.ends),
             *((self._places[list(mark.points)], 100.0) for mark in self._symbols.marks),
             *((point, 200.0) for point in self.points.values())])

    def table(self):
        """The table of ``mesh_and_loads``."""
        x, y, z = self.model.nodes[self.model.quads.ravel()].T
        parts = [pd.DataFrame({"item": "element", "x": x, "y": y, "z": z,
                               "name": np.repeat(np.arange(len(self.model.quads)), 4)})]
        for one in self.drawn:
            parts.append(_rows("load", one.name, one.at, **dict(zip(("fx", "fy", "fz"),
                                                                   one.vectors.T)),
                               unit=one.unit, function=one.function))
        for name, point in self.points.items():
            parts.append(_rows("point", name, [point]))
        for symbol in (*self._symbols.lines, *self._symbols.marks):
            parts.append(_rows(symbol.item, symbol.name, self._places[list(symbol.points)]))
        for one in {one.function: one for one in self._varying}.values():
            parts.append(pd.DataFrame({"item": "function", "name": one.function, **dict(zip(
                ("time", "value"), one.history.curve()))}))
        return pd.concat(parts, ignore_index=True)


def _probed(model, case):
    """``{name: centre}`` of the elements whose stresses a model file records."""
    centres = model.nodes[model.quads].mean(axis=1)
    return {name: centres[np.linalg.norm(centres - probe.stress.value, axis=1).argmin()]
            for name, probe in case.probes.items() if probe.stress}


def _points(case):
    """``{name: place}`` of the points of a model file."""
    return {name: point.value for name, point in case.points.items()} if case else {}


def _rows(item, name, at, **more):
    """Rows of a table with places (n, 3)."""
    return pd.DataFrame({"item": item, "name": name, **dict(zip("xyz", np.transpose(at))), **more})


def _more(model, mesh, lines, at, normals, marked):
    """The rows of ``whole_model`` that are not in ``mesh_and_loads``."""
    for name, elements in mesh.groups.items():
        yield _rows("group", name, mesh.nodes[mesh.quads[elements]].mean(axis=1), element=elements)
    yield _rows("normal", "", at, **dict(zip(("nx", "ny", "nz"), normals.T)))
    for item, ends in lines.items():
        if len(ends):
            yield _rows(item, np.repeat(np.arange(len(ends)), 2), model.nodes[ends.ravel()])
    for marks in marked:
        yield _rows(marks.item, marks.name, model.nodes[marks.nodes])


def _groups(mesh):
    """(n_elem,) which colour an element has, and the names of these: of its group, or of all groups
    that it is in."""
    inside = np.array([np.isin(np.arange(len(mesh.quads)), members)
                       for members in mesh.groups.values()], dtype=bool).reshape(
                           len(mesh.groups), len(mesh.quads))
    kinds, number = np.unique(inside.T, axis=0, return_inverse=True)
    names = [" and ".join(np.array(list(mesh.groups), dtype=object)[kind]) or "in no group"
             for kind in kinds]
    order = sorted(range(len(names)), key=lambda k: (-kinds[k].sum() == 0, *~kinds[k]))
    if len(order) > len(TINTS):
        names = [*(names[k] for k in order[:len(TINTS) - 1]), "in other groups"]
    else:
        names = [names[k] for k in order]
    rank = np.minimum(np.argsort(order), len(names) - 1)
    return rank[number.ravel()], names


def _tints(groups):
    """A colour for each name of ``_groups``."""
    if len(groups) == 1:
        return [PLAIN]
    tints = [PALE + (1.0 - PALE) * np.array(to_rgb(colour)) for colour in TINTS[:len(groups)]]
    return [PLAIN if name == "in no group" else colour for name, colour in zip(groups, tints)]


def _normals(corners, taken):
    """(n, 3) centres of some elements that are spread over the shell, over its directions, and away
    from what is ``taken``, and their normals."""
    centres, normals = arrows.middle(corners)
    size = np.ptp(centres, axis=0).max() or 1.0
    near = cKDTree(centres).query(taken)[1] if len(taken) else []
    places = np.hstack([centres / size, 0.5 * normals])
    some = arrows.spread(places, NORMALS, places[near])
    return centres[some], normals[some]


def _held(model):
    """``Marks`` of the nodes that supports hold, by what is held and whether they move, and of the
    edges of a sector."""
    if not (getattr(model, "supports", ()) or getattr(model, "cyclic", None)):
        return []
    driven = np.zeros((len(model.nodes), 1), dtype=bool)
    for support in model.supports:
        driven[list(support.nodes)] |= isinstance(support, Drive)
    kinds, number = np.unique(np.hstack([model.fixed, driven]), axis=0, return_inverse=True)
    others, found = iter(OTHERS * len(kinds)), []
    for k, (*kind, moved) in reversed(list(enumerate(kinds))):
        held = tuple(np.array(COMPONENTS)[kind].tolist())
        if held:
            name = (HELD.get(held) or ", ".join(held)) + (", moved" if moved else "")
            found.append(Marks(np.flatnonzero(number.ravel() == k), name,
                               DRIVEN if moved else MARKS.get(held) or next(others)))
    edges = np.concatenate(model.pairs[1:3]) if model.pairs else []
    oblique = [i for i, held in model.oblique.items() if sum(map(len, held)) and i not in edges]
    for nodes, words in ((oblique, "held obliquely"), (edges, "edges of the sector")):
        if len(nodes):
            found.append(Marks(np.array(nodes), words, next(others)))
    return found


def _attached(model):
    """``Marks`` of the nodes with point masses and with springs to the ground."""
    masses = [item for item in model.attached if isinstance(item, PointMass)]
    if masses:
        total = sum(item.mass for item in masses)
        yield Marks(np.unique([item.node for item in masses]), f"point masses, {total:g} kg", MASS,
                    "mass", BLACK)
    held = [item.node for item in model.attached if isinstance(item, GroundSpring)]
    if held:
        yield Marks(np.unique(held), "springs to the ground", TO_GROUND, "ground spring", SPRING)


def _springs(model):
    """(n, 2) nodes at the ends of springs."""
    return np.array([(item.node, item.other) for item in model.attached
                     if isinstance(item, Spring)], dtype=int).reshape(-1, 2)


def _row(picture, words):
    """A row of the key."""
    return HPacker(children=[picture, TextArea(words, textprops=WORDS)], pad=0.0, sep=4.0,
                   align="center")


def _patch(colour):
    area = DrawingArea(14.0, 7.0)
    area.add_artist(Rectangle((0.0, 0.0), 14.0, 7.0, facecolor=colour, edgecolor="0.4",
                              linewidth=0.4))
    return area


def _zigzag():
    area = DrawingArea(14.0, 7.0)
    area.add_artist(Line2D(*zigzag((0.0, 3.5), (14.0, 3.5), 2.0).T, color=SPRING, linewidth=0.9))
    return area


def _symbol(line, mark):
    """A line and a mark of ``LOOKS``, one of which may be none."""
    area = DrawingArea(14.0, 7.0)
    if line:
        look = LOOKS[line]
        area.add_artist(Line2D((0.0, 14.0), (3.5, 3.5), color=look.colour, linewidth=look.width))
    if mark:
        look = LOOKS[mark]
        foot = mark == "foot"
        area.add_artist(Line2D(
            (7.0,), (7.0 if foot else 3.5,), color=look.colour, linestyle="", marker=look.marker,
            markersize=8.0 if foot else 0.9 * look.width, markeredgewidth=0.8,
            markerfacecolor="none" if foot else "white" if look.hollow else look.colour))
    return area


def _line(colour, width, marker=""):
    """A line, a marker, or a line that ends in a marker."""
    area = DrawingArea(14.0, 7.0)
    if width:
        area.add_artist(Line2D((0.0, 14.0), (3.5, 3.5), color=colour, linewidth=width))
    area.add_artist(Line2D((12.0 if width else 7.0,), (3.5,), color=colour, linestyle="",
                           marker=marker, markersize=4.0 if width else 3.5))
    return area
