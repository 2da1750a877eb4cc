"""Cutting a mesh along a line of edges, so that a joint may hold the two sides together."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..errors import InputError
from ..signatures import Vector, checked
from .mesh import beside_line, edge_keys, element_edges, line_nodes, node_at
from .meshes import Mesh

SAME = 1e-6
"""How far apart nodes at one place may be, and nodes of a line beside it, in sizes of the mesh."""


class Cut(NamedTuple):
    """A mesh that is open along a line.

    Attributes:
        mesh: ``Mesh``, the new nodes after those that were there.
        nodes: those of the line, from its start to its end, of the elements on its left.
        others: new nodes at the same places, of the elements on its right.
    """

    mesh: Mesh
    nodes: tuple
    others: tuple


@checked
def cut(mesh: Mesh, start: Vector, end: Vector):
    """Open a mesh along the straight line of element edges from ``start`` to ``end`` [m].

    Elements on the right of the line, seen against their normals, get nodes of their own there.
    An end of the line inside a plate stays whole.  A ``Hinge`` of the nodes and the others makes
    the plates fold about the line.  Where two plates already have an edge each along the line, the
    mesh stays as it is.

    Args:
        mesh: ``Mesh``.
        start: (x, y, z) of the first node [m].
        end: of the last one.

    Returns:
        ``Cut``.

    Raises:
        InputError: no such line, or an edge of it without an element on either side.
    """
    sides = _sides(mesh, start, end)
    if len(sides) == 2:
        return Cut(mesh, *sides)
    if len(sides) > 2:
        raise InputError(f"cut: {len(sides)} plates have edges between these points, a hinge folds "
                         "two")
    line = line_nodes(mesh.nodes, mesh.quads, start, end)
    edges = element_edges(mesh.quads)
    owner = np.repeat(np.arange(len(mesh.quads)), 4)
    left, right = _beside(edges, owner, line), _beside(edges, owner, line[::-1])[::-1]
    whole = edge_keys(np.stack([line[:-1], line[1:]], axis=1))
    quads, nodes, others = np.array(mesh.quads), [], []
    for k, i in enumerate(line):
        here = slice(max(k - 1, 0), k + 1)
        fans = _fans(edges, owner, i, whole)
        away = {fans[element] for element in right[here]}
        if away & {fans[element] for element in left[here]}:
            continue  # the line ends inside a plate
        new = len(mesh.nodes) + len(others)
        moved = [element for element, fan in fans.items() if fan in away]
        quads[moved] = np.where(quads[moved] == i, new, quads[moved])
        nodes.append(int(i))
        others.append(new)
    opened = np.concatenate([mesh.nodes, mesh.nodes[nodes]])
    made = Mesh(opened, quads, dict(mesh.groups), dict(mesh.node_sets), dict(mesh.lines),
                mesh.normals)
    return Cut(made, tuple(nodes), tuple(others))


def apart(mesh, point):
    """The mesh with nodes of their own for the plates that touch at a point [m] only, and these
    nodes, two or more.

    Raises:
        InputError: no node there, or one plate.
    """
    gaps = np.linalg.norm(mesh.nodes - mesh.nodes[node_at(mesh.nodes, point)], axis=1)
    here = np.flatnonzero(gaps <= SAME * np.ptp(mesh.nodes, axis=0).max())
    if len(here) > 1:
        return mesh, tuple(here.tolist())
    edges, owner = element_edges(mesh.quads), np.repeat(np.arange(len(mesh.quads)), 4)
    fans = _fans(edges, owner, here[0], np.zeros(0, dtype=np.int64))
    quads, numbers = np.array(mesh.quads), sorted(set(fans.values()))
    if len(numbers) == 1:
        raise InputError(f"one plate only is at {list(map(float, point))}, a spherical joint holds "
                         "two or more that touch there")
    nodes = [int(here[0]), *range(len(mesh.nodes), len(mesh.nodes) + len(numbers) - 1)]
    for number, node in zip(numbers, nodes):
        moved = [element for element, fan in fans.items() if fan == number]
        quads[moved] = np.where(quads[moved] == here[0], node, quads[moved])
    more = np.repeat(mesh.nodes[here], len(nodes) - 1, axis=0)
    return replace(mesh, nodes=np.concatenate([mesh.nodes, more]), quads=quads), tuple(nodes)


def _sides(mesh, start, end):
    """Edges of plates along a straight line, each a tuple of nodes from its start to its end; the
    one with elements on its left first."""
    start, end = (mesh.nodes[node_at(mesh.nodes, point)] for point in (start, end))
    if np.array_equal(start, end):
        return []
    along, off, length = beside_line(mesh.nodes, start, end)
    small = SAME * np.ptp(mesh.nodes, axis=0).max()
    on = (off <= small) & (along >= -small) & (along <= length + small)
    edges = element_edges(mesh.quads)
    edges = edges[on[edges].all(axis=1)]
    links = coo_array((np.ones(len(edges)), edges.T), shape=(len(mesh.nodes),) * 2)
    _, chain = connected_components(links, directed=False)
    found = []
    for number in np.unique(chain[edges]):
        nodes = np.flatnonzero(chain == number)
        nodes = nodes[np.argsort(along[nodes])]
        one, other = edges[chain[edges[:, 0]] == number][0]
        found.append((along[one] > along[other], tuple(nodes.tolist())))
    return [nodes for _, nodes in sorted(found)]


def _beside(edges, owner, line):
    """(n - 1,) elements that have the edges of a line in its direction: those on its left."""
    found = []
    for i, j in zip(line[:-1], line[1:]):
        at = np.flatnonzero((edges[:, 0] == i) & (edges[:, 1] == j))
        if len(at) != 1:
            raise InputError(f"cut: the edge between nodes {min(i, j)} and {max(i, j)} needs one "
                             f"element on either side, one side has {len(at)}")
        found.append(owner[at[0]])
    return np.array(found)


def _fans(edges, owner, i, whole):
    """``{element: number}`` of the elements around node i, alike for those that edges join which
    are none of the line's, ``whole``."""
    at = np.flatnonzero(np.any(edges == i, axis=1))
    keys, elements = edge_keys(edges[at]), np.unique(owner[at])
    rank = np.searchsorted(elements, owner[at])
    inner = ~np.isin(keys, whole)
    _, of = np.unique(keys[inner], return_inverse=True)
    n = len(elements)
    links = coo_array((np.ones(inner.sum()), (rank[inner], n + of)),
                      shape=(n + inner.sum(),) * 2)
    _, fan = connected_components(links, directed=False)
    return dict(zip(elements.tolist(), fan[:n].tolist()))
