"""Meshes with names: groups of elements, sets of nodes, lines of edges; what is selected by place.

``Mesh`` is what generators make and files hold; ``Model.of`` takes one.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from ..checks import floats, number, plain_array, positive, shown, single, text
from ..errors import InputError, MeshWarning, warn
from ..names import listed
from ..signatures import File, Positive, Vector, checked
from . import mesh_files
from .directors import orient
from .mesh import (
    HANGING,
    boundary,
    check_mesh,
    coincident,
    line_nodes,
    node_numbers,
)


class Named(dict):
    """Arrays by name; a name that is not there is an ``InputError`` that tells those that are."""

    def __init__(self, kind, items):
        super().__init__(items)
        self.kind = kind

    def __missing__(self, name):
        known = f"must be one of: {', '.join(map(str, self))}" if self else "there is none"
        raise InputError(f"{self.kind} {shown(name)} is unknown, {known}")


def _merge(name, value):
    """True, False or a tolerance."""
    return bool(value) if isinstance(value, bool | np.bool_) else positive(name, value, "m")


def _range(name, value):
    """A coordinate or two, as (low, high)."""
    pair = (value, value) if single(value) else value
    if not np.iterable(pair) or isinstance(pair, str | bytes | Mapping) or len(tuple(pair)) != 2:
        raise InputError(f"{name} must be a coordinate or a pair (low, high), is {shown(value)}")
    return tuple(number(name, item, "m") for item in pair)


Merge = Annotated[bool | float, _merge]
Range = Annotated[float | tuple, _range]


@dataclass(frozen=True, eq=False, repr=False)
class Mesh:
    """Nodes and elements with names.

    Attributes:
        nodes: (n_nodes, 3) coordinates [m].
        quads: (n_elem, 4) node numbers, counter-clockwise about the normal.
        groups: ``{name: element numbers}``, each (n,), ascending.
        node_sets: ``{name: node numbers}``, each (n,), ascending; the nodes of ``lines`` are sets
            too.
        lines: ``{name: edges}``, each (n, 2) node numbers; see ``chain``.
        normals: (n_elem, 4, 3) exact unit normals at the vertices of the elements, or None.

    Raises:
        InputError: arrays of another shape, numbers of nodes or elements that do not exist.
    """

    nodes: np.ndarray
    quads: np.ndarray
    groups: dict = None
    node_sets: dict = None
    lines: dict = None
    normals: np.ndarray = None

    def __post_init__(self):
        nodes = floats("nodes", self.nodes, (None, 3))
        quads = node_numbers(self.quads, len(nodes))
        lines = _named("line", self.lines, len(nodes), "node", 2)
        sets = _named("node set", self.node_sets, len(nodes), "node")
        for name, edges in lines.items():
            sets[name] = _frozen(np.union1d(sets.get(name, edges[:0, 0]), edges))
        values = {"nodes": nodes, "quads": quads, "node_sets": sets, "lines": lines,
                  "groups": _named("group", self.groups, len(quads), "element")}
        if self.normals is not None:
            values["normals"] = floats("normals", self.normals, (len(quads), 4, 3))
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def __repr__(self):
        told = [f"{len(self.quads)} elements", f"{len(self.nodes)} nodes"]
        told += [f"{what}: {', '.join(names)}" for what, names in (
            ("groups", self.groups), ("node sets", self.node_sets), ("lines", self.lines)) if names]
        return f"Mesh({'; '.join(told)})"

    @classmethod
    @checked
    def read(cls, path: File, merge: Merge = False, reduce: bool = False, all_quads: bool = False,
             apart: bool = False):
        """The mesh in a file, read by meshio, oriented and checked.

        ``.msh`` (Gmsh 2.2 and 4.1), ``.inp`` (Abaqus), ``.bdf`` (Nastran), ``.vtu``, ``.vtk``,
        ``.xdmf``, ``.med``, ``.mesh``, ``.stl``, ``.obj``.  Physical groups and sets arrive by
        name: those of faces as ``groups``, of points and curves as ``node_sets``, of curves as
        ``lines`` as well; numbers of properties as groups ``"1"``, ``"2"`` ...  Nodes of no face
        are left out and elements turned that run against the first of their part; a
        ``MeshWarning`` says how many.  Nodes and elements are numbered from 0, in the order of the
        file.

        Args:
            path: of the file; its suffix tells the format.
            merge: makes nodes at one place one, True, or those within so many m.
            reduce: takes the corners of elements of second order.
            all_quads: divides triangles into three quads and, so that all edges fit, each quad into
                four; new nodes are at the middle of edges and elements, on the facets of a curved
                surface.
            apart: nodes may be at one place, of plates that joints will hold together.

        Raises:
            InputError: no such file, it cannot be read, or what it holds is no mesh of a shell,
                each with the remedy.
        """
        found, notes = mesh_files.read(path, merge, reduce, all_quads)
        try:
            mesh, turned = cls(**found)._oriented()
            check_mesh(mesh.nodes, mesh.quads, [np.arange(len(mesh.nodes))] if apart else ())
        except InputError as error:
            raise InputError(f"{path}: {error}") from None
        if turned:
            notes.append(f"{turned} of {len(mesh.quads)} elements turned to the side of the first")
        if notes:
            warn(f"{path}: {'; '.join(notes)}", MeshWarning)
        return mesh

    @checked
    def write(self, path: File, overwrite: bool = False):
        """Write a file of the format that its suffix tells, with groups, node sets and lines.

        ``.msh`` (Gmsh 2.2), ``.inp``, ``.vtu``, ``.vtk`` (spaces in names become ``_``), ``.xdmf``,
        ``.med``; a ``.bdf`` keeps the numbers of the groups alone.  Normals are not written.

        Raises:
            InputError: another format, a file that is there already, or cannot be written.
        """
        mesh_files.write(path, self, overwrite)

    def oriented(self):
        """The same mesh with those elements turned that run against the first one of their part.

        Raises:
            InputError: as of ``orient``.
        """
        return self._oriented()[0]

    def _oriented(self):
        """The mesh oriented, and the number of elements that were turned."""
        quads, normals = orient(self.nodes, self.quads), self.normals
        turned = np.any(quads != self.quads, axis=1)
        if normals is not None:
            normals = np.where(turned[:, None, None], -normals[:, ::-1], normals)
        return replace(self, quads=quads, normals=normals), int(turned.sum())

    @checked
    def named(self, name: str):
        """The same mesh with all elements in the group ``name`` as well."""
        return replace(self, groups={**self.groups, name: np.arange(len(self.quads))})

    @checked
    def nodes_at(self, x: Range = None, y: Range = None, z: Range = None,
                 tolerance: Positive = None):
        """Numbers of the nodes at given coordinates: ``nodes_at(x=0.0)``, ``nodes_at(z=(0, 2))``.

        Args:
            x, y, z: a coordinate or a pair (low, high) [m]; all of them by default.
            tolerance: how far off a node may be [m]; by default 1e-6 of the mesh's extent.

        Raises:
            InputError: there is none.
        """
        inside = np.flatnonzero(self._inside(x, y, z, tolerance))
        if not len(inside):
            raise InputError(f"no nodes at {_box(x, y, z)}; the mesh reaches from "
                             f"{self.nodes.min(axis=0).tolist()} to "
                             f"{self.nodes.max(axis=0).tolist()}")
        return inside

    @checked
    def elements_at(self, x: Range = None, y: Range = None, z: Range = None,
                    tolerance: Positive = None):
        """Numbers of the elements whose nodes are all at given coordinates, as ``nodes_at``."""
        inside = self._inside(x, y, z, tolerance)[self.quads].all(axis=1)
        if not inside.any():
            raise InputError(f"no whole elements at {_box(x, y, z)}")
        return np.flatnonzero(inside)

    def _inside(self, x, y, z, tolerance):
        """(n_nodes,) which nodes are at the given coordinates."""
        near = HANGING * np.ptp(self.nodes, axis=0).max() if tolerance is None else tolerance
        bounds = np.array([(-np.inf, np.inf) if given is None else given for given in (x, y, z)])
        return np.all((self.nodes >= bounds[:, 0] - near) & (self.nodes <= bounds[:, 1] + near),
                      axis=1)

    def boundary(self):
        """(n, 2) edges of one element only, from each node to the next round that element."""
        return boundary(self.quads)

    @checked
    def line(self, start: Vector, end: Vector):
        """Numbers of the nodes on the mesh line straight from ``start`` to ``end`` [m], in order.

        Raises:
            InputError: no node at either end, or no straight line of element edges between them.
        """
        return line_nodes(self.nodes, self.quads, start, end)

    @checked
    def chain(self, name: str):
        """Numbers of the nodes along ``lines[name]``, in order; the first is the last of a loop.

        Raises:
            InputError: no such line, or it branches or has several pieces.
        """
        edges = self.lines[name]
        nodes, ends, uses = np.unique(edges, return_inverse=True, return_counts=True)
        if uses.max() > 2:
            raise InputError(f"line {shown(name)} branches at node {nodes[np.argmax(uses)]}")
        around = [[] for _ in nodes]
        for one, other in ends.reshape(-1, 2).tolist():
            around[one].append(other)
            around[other].append(one)
        at = ends.reshape(-1, 2)[0, 0] if uses.min() == 2 else int(np.argmin(uses))
        way, left = [int(at)], None
        while len(way) <= len(edges):
            ahead = [node for node in around[way[-1]] if node != left]
            if not ahead:
                break
            left = way[-1]
            way.append(ahead[0])
        if len(way) <= len(edges):
            raise InputError(f"line {shown(name)} has several pieces")
        return nodes[way]

    @checked
    def per_element(self, values, default: float = None):
        """(n_elem,) a value for every element, of values by group or at nodes.

        Args:
            values: ``{group: value}``, or (n_nodes,) values, whose mean an element has.
            default: value of the elements that are in none of the groups.

        Raises:
            InputError: an unknown group, elements in none, or in two with different values.
        """
        if not isinstance(values, Mapping):
            return floats("values", values, (len(self.nodes),))[self.quads].mean(axis=1)
        result, given = np.zeros(len(self.quads)), np.full(len(self.quads), "", dtype=object)
        for name, value in values.items():
            elements, value = self.groups[name], number(f"value of group {shown(name)}", value)
            clash = elements[(given[elements] != "") & (result[elements] != value)]
            if len(clash):
                raise InputError(f"elements {listed(clash)} are in the groups "
                                 f"{shown(given[clash[0]])} and {shown(name)}, whose values differ")
            result[elements], given[elements] = value, name
        rest = given == ""
        if default is None and rest.any():
            raise InputError(f"elements {listed(np.flatnonzero(rest))} are in none of the groups "
                             f"{', '.join(map(str, values))}: give a default")
        result[rest] = 0.0 if default is None else default
        return result


@checked
def join(meshes: list[Mesh], tolerance: Positive = None, apart: bool = False):
    """One ``Mesh`` of several, nodes at one place made one, in order of first appearance.

    Groups, node sets and lines of one name become one.  Exact normals are kept where all have them.

    Args:
        meshes: ``Mesh`` es.
        tolerance: largest distance of nodes at one place [m]; by default 1e-9 of the size of the
            elements there.
        apart: every mesh keeps its own nodes, of plates that joints will hold together.

    Raises:
        InputError: no meshes, or something else.
    """
    if not meshes:
        raise InputError("meshes must not be empty")
    n, m = (np.cumsum([0] + [len(getattr(mesh, name)) for mesh in meshes])
            for name in ("nodes", "quads"))
    nodes = np.concatenate([mesh.nodes for mesh in meshes])
    quads = np.concatenate([mesh.quads + shift for mesh, shift in zip(meshes, n)])
    kept = rank = np.arange(len(nodes))
    if not apart:
        kept, rank = coincident(nodes, quads, tolerance)
    normals = None
    if all(mesh.normals is not None for mesh in meshes):
        normals = np.concatenate([mesh.normals for mesh in meshes])
    return Mesh(nodes[kept], rank[quads], normals=normals,
                groups=_united(meshes, "groups", m, np.arange(m[-1])),
                node_sets=_united(meshes, "node_sets", n, rank),
                lines=_united(meshes, "lines", n, rank))


def _united(meshes, kind, shifts, new):
    """``{name: numbers}`` of all meshes, shifted, then renumbered by ``new``."""
    found = {}
    for mesh, shift in zip(meshes, shifts):
        for name, numbers in getattr(mesh, kind).items():
            found.setdefault(name, []).append(new[numbers + shift])
    return {name: np.concatenate(parts) for name, parts in found.items()}


def _named(kind, given, size, what, width=None):
    """``Named`` arrays of numbers of nodes or elements below ``size``, (n,) each, or (n, width)."""
    if not isinstance(given, Mapping | None):
        raise InputError(f"{kind}s must be a dict of arrays by name, is {shown(given)}")
    return Named(kind, {text(f"{kind}: name", name): _numbers(f"{kind} {shown(name)}", values, size,
                                                              what, width)
                        for name, values in (given or {}).items()})


def _numbers(name, values, size, what, width):
    needed = "n" if width is None else f"n, {width}"
    array = plain_array(name, values, needed)
    if not array.size:
        array = np.zeros((0,) if width is None else (0, width), dtype=np.int64)
    if array.ndim != (width is None) + 2 * (width is not None) or (width and
                                                                    array.shape[1] != width):
        raise InputError(f"{name}: shape {array.shape} given, ({needed}) needed")
    if not np.issubdtype(array.dtype, np.integer):
        raise InputError(f"{name}: {what} numbers must be integers, not {array.dtype}")
    bad = array[(array < 0) | (array >= size)]
    if len(bad):
        raise InputError(f"{name}: {what} {bad[0]} does not exist (0 to {size - 1})")
    return _frozen(np.unique(array) if width is None else array)


def _frozen(array):
    """A read-only copy of numbers."""
    array = np.array(array, dtype=np.int64, order="C")
    array.setflags(write=False)
    return array


def _box(x, y, z):
    """The coordinates that were asked for, as text."""
    told = [f"{name} = {given[0]:g}" if given[0] == given[1] else
            f"{name} from {given[0]:g} to {given[1]:g}"
            for name, given in zip("xyz", (x, y, z)) if given is not None]
    return ", ".join(told) or "any coordinates"
