"""Meshes: blocks joined where their nodes coincide, sphere segments; checks of any mesh."""

from typing import Annotated

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ..checks import TINY, count, floats, integers, numbers, plain_array
from ..errors import InputError
from ..signatures import Nodes, Positive, Vector, checked
from .constants import jacobians, shape_functions

MERGE = 1e-9
"""Nodes closer than this fraction of the size of the elements there are one node."""

ROUNDING = 16.0 * np.finfo(float).eps
"""Places closer than this fraction of their coordinates are not told apart."""

HANGING = 1e-6
"""A node this near to an edge, in its lengths, lies on it."""

MOST_ELEMENTS = 1_000_000
"""Elements of a mesh: beyond, a model alone takes minutes and a matrix does not fit in memory."""

FEWEST_ROUND = 9
"""Elements round a sphere: fewer meet at 45 degrees or more, at folds."""

MIN_JACOBIAN = 1e-6
"""Smallest vertex Jacobian relative to the element's largest below which a quad is degenerate."""


def divisions_of(name, values):
    """Two counts whose product is no more than ``MOST_ELEMENTS``."""
    items = integers(name, values)
    if len(items) != 2:
        raise InputError(f"{name} must be two counts, are {len(items)}")
    n, m = (count(f"{name}[{k}]", item) for k, item in enumerate(items))
    few_enough(n * m)
    return n, m


def few_enough(elements):
    """Raise ``InputError`` for a mesh that is too large to be made."""
    if elements > MOST_ELEMENTS:
        raise InputError(f"a mesh of {elements:.7g} elements is too large, at most "
                         f"{MOST_ELEMENTS} are possible")


Divisions = Annotated[tuple, divisions_of]


def corners_of(name, values):
    """Four corners (4, 3) in order round a convex block [m]."""
    corners = floats(name, values, (4, 3))
    try:
        check_shapes(corners, np.arange(4)[None])
    except InputError:
        raise InputError(f"{name} must go round a convex block, their sides cross or fold: give "
                         "them in the order of an element's nodes") from None
    return corners


Corners = Annotated[np.ndarray, corners_of]


def _polar_angles(name, values):
    items = numbers(name, values)
    if len(items) != 2 or not 0.0 < items[0] < items[1] < 180.0:
        raise InputError(f"{name} must be two angles that increase within 0 and 180 [degrees]")
    return items


@checked
def block(corners: Corners, divisions: Divisions):
    """Nodes ((n+1)(m+1), 3) and quads (n m, 4) of one block.

    Args:
        corners: (4, 3), in the order of an element's nodes [m].
        divisions: (n, m) elements along the sides 1-2 and 2-3.

    Raises:
        InputError: an argument of another kind, or more than ``MOST_ELEMENTS``.
    """
    n, m = divisions
    nodes = np.array([shape_functions((2.0 * i / n - 1.0, 2.0 * j / m - 1.0))[0] @ corners
                      for j in range(m + 1) for i in range(n + 1)])
    first = np.array([j * (n + 1) + i for j in range(m) for i in range(n)])
    return nodes, np.stack([first, first + 1, first + n + 2, first + n + 1], axis=1)


@checked
def sphere_segment(radius: Positive, polar_angles: Annotated[tuple, _polar_angles],
                   divisions: Divisions):
    """Nodes, quads and exact normals of a sphere about Z between two parallels, closed in azimuth.

    Azimuth runs from +X towards +Y, then from the lower parallel up, so that normals are outward.

    Args:
        radius: [m].
        polar_angles: of the upper and the lower parallel, from +Z [degrees].
        divisions: (n, m) elements round and along the meridian.

    Returns:
        nodes (n (m+1), 3), quads (n m, 4), outward unit normals (n (m+1), 3).

    Raises:
        InputError: an argument of another kind, more than ``MOST_ELEMENTS``, or so few that the
            elements meet at folds.
    """
    n, m = divisions
    fewest = int((polar_angles[1] - polar_angles[0]) / 45.0) + 1
    if n < FEWEST_ROUND or m < fewest:
        raise InputError(f"divisions ({n}, {m}) are no smooth sphere, its elements would meet at "
                         f"folds: take at least ({FEWEST_ROUND}, {fewest})")
    polar, azimuth = np.meshgrid(np.radians(np.linspace(polar_angles[1], polar_angles[0], m + 1)),
                                 np.linspace(0.0, 2.0 * np.pi, n, endpoint=False), indexing="ij")
    normals = np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth),
                        np.cos(polar)], axis=2).reshape(-1, 3)
    j, i = np.divmod(np.arange(n * m), n)
    right = (i + 1) % n
    quads = np.stack([n * j + i, n * j + right, n * (j + 1) + right, n * (j + 1) + i], axis=1)
    return radius * normals, quads, normals


def _mesh(name, given):
    """A pair of nodes and quads."""
    try:
        nodes, quads = given
    except (TypeError, ValueError):
        raise InputError(f"{name} must be a pair (nodes, quads)") from None
    nodes = floats(f"{name}: nodes", nodes, (None, 3))
    return nodes, node_numbers(quads, len(nodes))


@checked
def join(blocks: list[Annotated[tuple, _mesh]]):
    """One mesh (nodes, quads) of several, coincident nodes merged, in order of first appearance.

    Args:
        blocks: pairs of nodes (n, 3) [m] and quads (m, 4), as of ``block``.

    Raises:
        InputError: no blocks, or something else.
    """
    if not blocks:
        raise InputError("blocks must not be empty")
    counts = np.cumsum([0] + [len(nodes) for nodes, _ in blocks])
    nodes = np.concatenate([nodes for nodes, _ in blocks])
    quads = np.concatenate([quads + shift for (_, quads), shift in zip(blocks, counts)])
    near = _near(nodes, quads)
    pairs = cKDTree(nodes).query_pairs(near.max(), output_type="ndarray")
    gaps = np.linalg.norm(nodes[pairs[:, 0]] - nodes[pairs[:, 1]], axis=1)
    pairs = pairs[gaps <= near[pairs].max(axis=1)]
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(nodes),) * 2)
    _, group = connected_components(links, directed=False)
    _, first, group = np.unique(group, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return nodes[first[order]], rank[group][quads]


@checked
def node_at(nodes: Nodes, point: Vector):
    """Number of the node of ``nodes`` (n, 3) at ``point`` (x, y, z) [m].

    Raises:
        InputError: no node there; the message names the nearest.
    """
    distance = np.linalg.norm(nodes - point, axis=1)
    nearest = int(np.argmin(distance))
    spacing = np.sort(np.linalg.norm(nodes - nodes[nearest], axis=1))[1:2].sum()
    if distance[nearest] > MERGE * spacing + ROUNDING * np.abs(point).max():
        raise InputError(f"no node at {list(map(float, point))}; the nearest, node {nearest}, "
                         f"is at {nodes[nearest].tolist()}")
    return nearest


@checked
def line_nodes(nodes: Nodes, quads, start: Vector, end: Vector):
    """Numbers of the nodes on the mesh line straight from ``start`` to ``end`` [m], in order.

    Args:
        nodes: (n, 3) [m].
        quads: (m, 4) node numbers.
        start: (x, y, z) of the first node [m].
        end: of the last one.

    Raises:
        InputError: no node at either end, or no straight line of element edges between them.
    """
    quads = node_numbers(quads, len(nodes))
    first, last = node_at(nodes, start), node_at(nodes, end)
    chord = nodes[last] - nodes[first]
    length = np.linalg.norm(chord)
    if first == last:
        raise InputError(f"a line from node {first} to itself")
    along = (nodes - nodes[first]) @ chord / length
    off = np.linalg.norm(nodes - nodes[first] - along[:, None] * chord / length, axis=1)
    near = MERGE * length + ROUNDING * np.abs(nodes[[first, last]]).max()
    on = np.flatnonzero((off <= near) & (along >= -near) & (along <= length + near))
    line = on[np.argsort(along[on])]
    lack = not_joined(quads, line)
    if lack is not None:
        raise InputError(f"no mesh line from {nodes[first].tolist()} to {nodes[last].tolist()}: "
                         f"no element edge joins nodes {lack[0]} and {lack[1]}")
    return line


def not_joined(quads, line):
    """The first two consecutive nodes of ``line`` that no element edge joins, or None."""
    joined = set(map(tuple, np.sort(element_edges(quads), axis=1).tolist()))
    pairs = ((int(i), int(j)) for i, j in zip(line[:-1], line[1:]))
    return next((pair for pair in pairs if (min(pair), max(pair)) not in joined), None)


def vector_areas(corners):
    """Area times normal (n_elem, 3) [m^2] of quads (n_elem, 4, 3): half the product of the
    diagonals, for a warped quad the area of its projection along that normal."""
    return 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])


def node_numbers(quads, n_nodes):
    """``quads`` as a read-only array (n_elem, 4) of numbers of nodes below ``n_nodes``."""
    array = plain_array("quads", quads, "n, 4")
    if array.ndim != 2 or array.shape[1] != 4 or not len(array):
        raise InputError(f"quads: shape {array.shape} given, (n, 4) needed")
    if not np.issubdtype(array.dtype, np.integer):
        raise InputError(f"quads: node numbers must be integers, not {array.dtype}")
    bad = np.argwhere((array < 0) | (array >= n_nodes))
    if len(bad):
        element, vertex = bad[0]
        raise InputError(f"element {element}: node {array[element, vertex]} does not exist "
                         f"(0 to {n_nodes - 1})")
    array = np.array(array, dtype=np.int64, order="C")
    array.setflags(write=False)
    return array


def check_mesh(nodes, quads):
    """Raise ``InputError`` for anything that cannot be the mesh of a shell."""
    few_enough(len(quads))
    check_connectivity(quads)
    _check_nodes(nodes, quads)
    check_shapes(nodes, quads)
    _check_edges(nodes, quads)


def element_edges(quads):
    """(4 n_elem, 2) edges of all elements, from each node to the next."""
    return np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)


def _check_nodes(nodes, quads):
    """No free-floating node, no two nodes at one place."""
    used = np.zeros(len(nodes), dtype=bool)
    used[quads] = True
    if not np.all(used):
        raise InputError(f"node {int(np.argmin(used))} belongs to no element")
    size = np.ptp(nodes, axis=0).max()
    if size < TINY:
        raise InputError(f"nodes: the mesh is {size:g} m large, must be {TINY:g} m at least")
    distance, nearest = cKDTree(nodes).query(nodes, k=2)
    numbers = np.arange(len(nodes))
    other = np.where(nearest[:, 0] == numbers, nearest[:, 1], nearest[:, 0])
    near = _near(nodes, quads)
    same = np.flatnonzero(distance[:, 1] <= np.maximum(near, near[other]))
    if len(same):
        first, second = sorted((int(same[0]), int(other[same[0]])))
        raise InputError(f"nodes {first} and {second} are at the same place "
                         f"{nodes[first].tolist()}")


def _near(nodes, quads):
    """(n_nodes,) distance below which another node is at the same place [m]: a fraction of the
    longest diagonal of the elements there."""
    corners = nodes[quads]
    diagonals = np.linalg.norm(corners[:, 2:] - corners[:, :2], axis=2).max(axis=1)
    size = np.zeros(len(nodes))
    np.maximum.at(size, quads.ravel(), np.repeat(diagonals, 4))
    return MERGE * size + ROUNDING * np.abs(nodes).max(axis=1)


def _check_edges(nodes, quads):
    """No node on an edge of an element whose node it is not: the edge would open there."""
    edges = element_edges(quads)
    start, along = nodes[edges[:, 0]], nodes[edges[:, 1]] - nodes[edges[:, 0]]
    length, tree = np.linalg.norm(along, axis=1), cKDTree(nodes)
    middle = start + 0.5 * along
    # where a node is nearer to the middle than the ends are
    crowded = np.flatnonzero(tree.query(middle)[0] < 0.499999 * length)
    for k, found in zip(crowded, tree.query_ball_point(middle[crowded], 0.501 * length[crowded])):
        hanging = np.array(found)[passed(nodes[found], *(found.index(i) for i in edges[k]))]
        if len(hanging):
            raise InputError(f"node {hanging[0]} lies on the edge of element {k // 4} between its "
                             f"nodes {edges[k, 0]} and {edges[k, 1]} and is none of its nodes: "
                             "divide the element there")


def passed(nodes, first, last):
    """Numbers of the nodes that are on the line between two others."""
    chord = nodes[last] - nodes[first]
    arms, length = nodes - nodes[first], np.linalg.norm(chord)
    along, off = arms @ chord, np.linalg.norm(np.cross(arms, chord), axis=1)
    on = (off <= HANGING * length**2) & (along > 0.0) & (along < length**2)
    on[[first, last]] = False
    return np.flatnonzero(on)


def check_connectivity(quads):
    """Raise ``InputError`` for a repeated node or element."""
    ordered = np.sort(quads, axis=1)
    repeated = np.any(ordered[:, 1:] == ordered[:, :-1], axis=1)
    if np.any(repeated):
        k = int(np.argmax(repeated))
        raise InputError(f"element {k}: nodes {quads[k].tolist()} repeat, a quad needs four")
    _, first, inverse = np.unique(ordered, axis=0, return_index=True, return_inverse=True)
    duplicate = np.flatnonzero(first[inverse.ravel()] != np.arange(len(quads)))
    if len(duplicate):
        k = int(duplicate[0])
        raise InputError(f"element {k} duplicates element {int(first[inverse.ravel()[k]])}: nodes "
                         f"{quads[k].tolist()}")


def check_shapes(nodes, quads):
    """Raise ``InputError`` for a degenerate, twisted or non-convex element."""
    corners = nodes[quads]
    diagonals = np.stack([corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]], axis=1)
    lengths = np.linalg.norm(diagonals, axis=2)
    area = np.linalg.norm(np.cross(diagonals[:, 0], diagonals[:, 1]), axis=1)
    flat = area <= MIN_JACOBIAN * lengths.max(axis=1) ** 2
    if np.any(flat):
        k = int(np.argmax(flat))
        raise InputError(f"element {k}: degenerate or twisted, the diagonals of its nodes "
                         f"{quads[k].tolist()} are parallel")
    determinants = jacobians(corners)
    bad = determinants.min(axis=1) <= MIN_JACOBIAN * determinants.max(axis=1)
    if np.any(bad):
        k = int(np.argmax(bad))
        vertex = int(np.argmin(determinants[k]))
        raise InputError(f"element {k}: degenerate, inverted or not convex at its node "
                         f"{quads[k, vertex]} (nodes {quads[k].tolist()})")
