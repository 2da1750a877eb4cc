"""A mesh as arrays: its edges and areas, which of its nodes are where; checks of any mesh."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ..checks import TINY, plain_array
from ..errors import InputError
from ..signatures import Nodes, Vector, checked
from .constants import jacobians

MERGE = 1e-9
"""Nodes closer than this fraction of the size of the elements there are one node."""

ROUNDING = 16.0 * np.finfo(float).eps
"""Places closer than this fraction of their coordinates are not told apart."""

HANGING = 1e-6
"""A node this near to an edge, in its lengths, lies on it."""

MOST_ELEMENTS = 1_000_000
"""Elements of a mesh: beyond, a model alone takes minutes and a matrix does not fit in memory."""

MIN_JACOBIAN = 1e-6
"""Smallest vertex Jacobian relative to the element's largest below which a quad is degenerate."""


def few_enough(elements):
    """Raise ``InputError`` for a mesh that is too large to be made."""
    if elements > MOST_ELEMENTS:
        raise InputError(f"a mesh of {elements:.7g} elements is too large, at most "
                         f"{MOST_ELEMENTS} are possible")


def coincident(nodes, faces, tolerance=None):
    """Which nodes are at one place, with ``faces`` (n_faces, 4) on them.

    Args:
        nodes: (n, 3) [m].
        faces: (n_faces, 4) node numbers; their size tells places apart.
        tolerance: largest distance of nodes at one place [m], instead.

    Returns:
        numbers (n_kept,) of the first node at each place, in order, and the rank (n,) of every
        node among them.
    """
    near = _near(nodes, faces) if tolerance is None else np.full(len(nodes), tolerance)
    pairs = cKDTree(nodes).query_pairs(near.max(), output_type="ndarray")
    gaps = np.linalg.norm(nodes[pairs[:, 0]] - nodes[pairs[:, 1]], axis=1)
    pairs = pairs[gaps <= near[pairs].max(axis=1)]
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(nodes),) * 2)
    _, group = connected_components(links, directed=False)
    _, first, group = np.unique(group, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return first[order], rank[group]


@checked
def node_at(nodes: Nodes, point: Vector):
    """Number of the node of ``nodes`` (n, 3) at ``point`` (x, y, z) [m].

    Raises:
        InputError: no node there; the message names the nearest.
    """
    distance = np.linalg.norm(nodes - point, axis=1)
    nearest = int(np.argmin(distance))
    gaps = np.linalg.norm(nodes - nodes[nearest], axis=1)
    spacing = gaps[gaps > 0.0].min() if np.any(gaps) else 0.0
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
    if first == last:
        raise InputError(f"a line from node {first} to itself")
    along, off, length = beside_line(nodes, nodes[first], nodes[last])
    near = MERGE * length + ROUNDING * np.abs(nodes[[first, last]]).max()
    on = np.flatnonzero((off <= near) & (along >= -near) & (along <= length + near))
    line = on[np.argsort(along[on])]
    lack = not_joined(quads, line)
    if lack is not None:
        raise InputError(f"no mesh line from {nodes[first].tolist()} to {nodes[last].tolist()}: "
                         f"no element edge joins nodes {lack[0]} and {lack[1]}")
    return line


def beside_line(nodes, start, end):
    """How far along the line from ``start`` to ``end`` nodes (n, 3) are, and how far beside it,
    (n,) each, and its length [m]."""
    chord = end - start
    length = np.linalg.norm(chord)
    along = (nodes - start) @ chord / length
    return along, np.linalg.norm(nodes - start - along[:, None] * chord / length, axis=1), length


def not_joined(quads, line):
    """The first two consecutive nodes of ``line`` that no element edge joins, or None."""
    pairs = np.stack([line[:-1], line[1:]], axis=1)
    lacking = np.flatnonzero(~np.isin(edge_keys(pairs), edge_keys(element_edges(quads))))
    return tuple(map(int, pairs[lacking[0]])) if len(lacking) else None


def edge_keys(edges):
    """(n,) one number for each of ``edges`` (n, 2), the same in both directions."""
    low, high = np.sort(edges, axis=1).T
    return low * 2**32 + high


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


def check_mesh(nodes, quads, joined=(), free=0, linked=()):
    """Raise ``InputError`` for anything that cannot be the mesh of a shell; ``joined``: lists of
    nodes that may be at one place; ``free``: how many nodes at the end may belong to no element,
    and be anywhere; ``linked``: nodes that bodies carry or that joints with multipliers hold, which
    may be at one place too."""
    nodes = nodes[:len(nodes) - free]
    few_enough(len(quads))
    check_connectivity(quads)
    _check_nodes(nodes, quads, joined, linked)
    check_shapes(nodes, quads)
    _check_edges(nodes, quads, joined)


def element_edges(quads):
    """(4 n_elem, 2) edges of all elements, from each node to the next."""
    return np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)


def boundary(quads):
    """(n, 2) edges of one element only, from each node to the next round that element."""
    edges = element_edges(quads)
    _, first, uses = np.unique(edge_keys(edges), return_index=True, return_counts=True)
    return edges[np.sort(first[uses == 1])]


def _check_nodes(nodes, quads, joined, linked):
    """No free-floating node, no two nodes at one place but joined or linked ones."""
    used = np.zeros(len(nodes), dtype=bool)
    used[quads] = True
    if not np.all(used):
        raise InputError(f"node {int(np.argmin(used))} belongs to no element")
    size = np.ptp(nodes, axis=0).max()
    if size < TINY:
        raise InputError(f"nodes: the mesh is {size:g} m large, must be {TINY:g} m at least")
    group = np.arange(len(nodes))
    for members in joined:
        group[members] = members[0]
    near = _near(nodes, quads)
    pairs = cKDTree(nodes).query_pairs(near.max(), output_type="ndarray")
    held = np.isin(pairs, linked).all(axis=1)
    pairs = pairs[(group[pairs[:, 0]] != group[pairs[:, 1]]) & ~held]
    gaps = np.linalg.norm(nodes[pairs[:, 0]] - nodes[pairs[:, 1]], axis=1)
    same = pairs[gaps <= near[pairs].max(axis=1)]
    if len(same):
        first, second = sorted(map(int, same[np.lexsort(same.T[::-1])][0]))
        raise InputError(f"nodes {first} and {second} are at the same place "
                         f"{nodes[first].tolist()} (corovec.join makes them one, a joint lets the "
                         "plates turn)")


def _near(nodes, quads):
    """(n_nodes,) distance below which another node is at the same place [m]: a fraction of the
    longest diagonal of the elements there."""
    corners = nodes[quads]
    diagonals = np.linalg.norm(corners[:, 2:] - corners[:, :2], axis=2).max(axis=1)
    size = np.zeros(len(nodes))
    np.maximum.at(size, quads.ravel(), np.repeat(diagonals, 4))
    return MERGE * size + ROUNDING * np.abs(nodes).max(axis=1)


def _check_edges(nodes, quads, joined):
    """No node on an edge of an element whose node it is not, but of one that it is tied to: the
    edge would open there."""
    edges = element_edges(quads)
    start, along = nodes[edges[:, 0]], nodes[edges[:, 1]] - nodes[edges[:, 0]]
    length, tree = np.linalg.norm(along, axis=1), cKDTree(nodes)
    middle = start + 0.5 * along
    # where a node is nearer to the middle than the ends are
    crowded = np.flatnonzero(tree.query(middle)[0] < 0.499999 * length)
    for k, found in zip(crowded, tree.query_ball_point(middle[crowded], 0.501 * length[crowded])):
        hanging = np.array(found)[passed(nodes[found], *(found.index(i) for i in edges[k]))]
        one = {*edges[k].tolist(), *hanging[:1].tolist()}
        if len(hanging) and not any(one <= set(members) for members in joined):
            raise InputError(f"node {hanging[0]} lies on the edge of element {k // 4} between its "
                             f"nodes {edges[k, 0]} and {edges[k, 1]} and is none of its nodes: "
                             "divide the element there")


def passed(nodes, first, last):
    """Numbers of the nodes that are on the line between two others."""
    chord = nodes[last] - nodes[first]
    arms, length = nodes - nodes[first], np.linalg.norm(chord)
    along, off = arms @ chord, np.linalg.norm(np.cross(arms, chord), axis=1)
    on = (off <= HANGING * length**2) & (np.abs(along / length**2 - 0.5) < 0.5 - HANGING)
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
