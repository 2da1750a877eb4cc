"""Directors of a mesh: one normal a node, several where plates meet at a junction."""

from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..errors import InputError
from .constants import CORNERS, shape_functions
from .mesh import element_edges

LARGEST_DEVIATION = 40.0
"""Largest angle [degrees] between a nodal normal and the normals of the elements it averages."""

FOLD_ANGLE = 45.0
"""Neighbours whose normals differ by this angle [degrees] or more meet at a fold, a junction."""

LEAST_SPREAD = 0.02
"""Sine of the least angle (1 degree) between two plates of a junction: the nodal frame needs it."""


class Directors(NamedTuple):
    """Mid-surface normals of a mesh: one a node, several where plates meet at a junction.

    Attributes:
        normals: (n_directors, 3) unit vectors, node after node.
        first: (n_nodes + 1,) those of node i are ``first[i] .. first[i + 1] - 1``.
        vertices: (n_elem, 4) director of every vertex.
    """

    normals: np.ndarray
    first: np.ndarray
    vertices: np.ndarray


def find_directors(nodes, quads, fold_angle=FOLD_ANGLE, patches=None):
    """Directors of all nodes: means of the unit element normals of a patch, Eqs. (13), (14).

    Around a node the elements fall into patches: neighbours across an edge belong together where
    their normals there differ by less than ``fold_angle`` [degrees], or where their numbers in
    ``patches`` (n_elem,) are the same.  A node with several patches is a junction.

    Raises:
        InputError: normals cancel or differ too much within a patch, all plates of a junction are
            coplanar, or an element is inverted against a neighbour of its patch.
    """
    normals = np.stack([_vertex_normals(nodes[quads], corner) for corner in CORNERS], axis=1)
    links = np.array(list(_smooth_links(quads, normals, fold_angle, patches)),
                     dtype=np.int64).reshape(-1, 2)
    graph = coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(quads.size,) * 2)
    count, group = connected_components(graph, directed=False)
    node = np.empty(count, dtype=np.int64)
    node[group] = quads.ravel()
    order = np.argsort(node, kind="stable")
    rank = np.empty(count, dtype=np.int64)
    rank[order] = np.arange(count)
    node, vertices = node[order], rank[group].reshape(quads.shape)
    total = np.zeros((count, 3))
    np.add.at(total, vertices, normals)
    length = np.linalg.norm(total, axis=1)
    if np.any(length < 1e-6):
        raise InputError(f"node {node[np.argmin(length)]}: the normals of its elements cancel")
    mean = total / length[:, None]
    cosine = np.einsum("eic,eic->ei", normals, mean[vertices])
    angle = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
    if angle.max() > LARGEST_DEVIATION:
        element, vertex = np.unravel_index(np.argmax(angle), angle.shape)
        raise InputError(f"node {quads[element, vertex]}: the normal of element {element} is "
                         f"{angle.max():.0f} degrees from the mean of its patch there, at most "
                         f"{LARGEST_DEVIATION:g} make a smooth shell: refine the mesh")
    first = np.searchsorted(node, np.arange(len(nodes) + 1))
    return _spread(Directors(mean, first, vertices))


def _smooth_links(quads, normals, fold_angle, patches):
    """Pairs of vertices (4 element + corner) that share a node and a patch across an edge.

    At a junction, plates on either side that go on smoothly but have opposite normals count as two.
    """
    edges = element_edges(quads)
    ordered = np.sort(edges, axis=1)
    order = np.lexsort((ordered[:, 1], ordered[:, 0]))
    new = np.any(np.diff(ordered[order], axis=0) != 0, axis=1)
    limit = np.cos(np.radians(fold_angle))
    flat = normals.reshape(-1, 3)
    for uses in np.split(order, np.flatnonzero(new) + 1):
        for k, one in enumerate(uses):
            for other in uses[k + 1:]:
                # vertices of both elements at either end of the edge
                ends = [one, one - one % 4 + (one + 1) % 4]
                there = [other - other % 4 + (other + 1) % 4, other]
                same_way = bool(edges[one, 0] == edges[other, 0])
                if same_way:
                    there = there[::-1]
                cosine = min(flat[a] @ flat[b] * (-1.0 if same_way else 1.0)
                             for a, b in zip(ends, there))
                elements = one // 4, other // 4
                smooth = (cosine > limit if patches is None
                          else patches[elements[0]] == patches[elements[1]])
                if smooth and same_way and len(uses) == 2:
                    raise InputError(
                        f"element {elements[1]} is inverted against its neighbour {elements[0]}: "
                        f"both run from node {edges[one, 0]} to node {edges[one, 1]}")
                if smooth and not same_way:
                    yield from zip(ends, there)


def _spread(directors):
    """The same directors, those of a junction ordered so that its first two are least parallel.

    Raises:
        InputError: the plates of a junction are coplanar.
    """
    normals, first, vertices = directors
    swapped = np.arange(len(normals))
    for i in np.flatnonzero(np.diff(first) > 1):
        members = np.arange(first[i], first[i + 1])
        pairs = list(combinations(members, 2))
        sizes = [np.linalg.norm(np.cross(normals[a], normals[b])) for a, b in pairs]
        best = int(np.argmax(sizes))
        if sizes[best] < LEAST_SPREAD:
            raise InputError(f"node {i}: the {len(members)} plates that meet there are coplanar, "
                             "no junction: let them share an edge, in one patch")
        swapped[members] = [*pairs[best], *(m for m in members if m not in pairs[best])]
    back = np.argsort(swapped)
    return Directors(normals[swapped], first, back[vertices])


def _vertex_normals(corners, corner):
    """Unit normals (n_elem, 3) of the bilinear surfaces at one corner, Eq. (13)."""
    _, natural = shape_functions(corner)
    d_xi, d_eta = np.einsum("ai,eic->aec", natural, corners)
    normal = np.cross(d_xi, d_eta)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)
