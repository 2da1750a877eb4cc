"""Meshes: blocks joined where their nodes coincide, sphere segments; checks of any mesh."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ..checks import TINY, plain_array
from ..errors import InputError
from .constants import jacobians, shape_functions

MERGE = 1e-9
"""Nodes closer than this fraction of the mesh's size are one node."""

MIN_JACOBIAN = 1e-6
"""Smallest vertex Jacobian relative to the element's largest below which a quad is degenerate."""


def block(corners, divisions):
    """Nodes ((n+1)(m+1), 3) and quads (n m, 4) of one block.

    Args:
        corners: (4, 3), in the order of an element's nodes [m].
        divisions: (n, m) elements along the sides 1-2 and 2-3.
    """
    n, m = divisions
    corners = np.asarray(corners, dtype=float)
    nodes = np.array([shape_functions((2.0 * i / n - 1.0, 2.0 * j / m - 1.0))[0] @ corners
                      for j in range(m + 1) for i in range(n + 1)])
    first = np.array([j * (n + 1) + i for j in range(m) for i in range(n)])
    return nodes, np.stack([first, first + 1, first + n + 2, first + n + 1], axis=1)


def sphere_segment(radius, polar_angles, divisions):
    """Nodes, quads and exact normals of a sphere about Z between two parallels, closed in azimuth.

    Azimuth runs from +X towards +Y, then from the lower parallel up, so that normals are outward.

    Args:
        radius: [m].
        polar_angles: of the upper and the lower parallel, from +Z [degrees].
        divisions: (n, m) elements round and along the meridian.

    Returns:
        nodes (n (m+1), 3), quads (n m, 4), outward unit normals (n (m+1), 3).
    """
    n, m = divisions
    polar, azimuth = np.meshgrid(np.radians(np.linspace(polar_angles[1], polar_angles[0], m + 1)),
                                 np.linspace(0.0, 2.0 * np.pi, n, endpoint=False), indexing="ij")
    normals = np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth),
                        np.cos(polar)], axis=2).reshape(-1, 3)
    j, i = np.divmod(np.arange(n * m), n)
    right = (i + 1) % n
    quads = np.stack([n * j + i, n * j + right, n * (j + 1) + right, n * (j + 1) + i], axis=1)
    return radius * normals, quads, normals


def join(blocks):
    """One mesh (nodes, quads) of several, coincident nodes merged, in order of first appearance."""
    counts = np.cumsum([0] + [len(nodes) for nodes, _ in blocks])
    nodes = np.concatenate([nodes for nodes, _ in blocks])
    quads = np.concatenate([quads + shift for (_, quads), shift in zip(blocks, counts)])
    pairs = cKDTree(nodes).query_pairs(MERGE * np.ptp(nodes, axis=0).max(), output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(nodes),) * 2)
    _, group = connected_components(links, directed=False)
    _, first, group = np.unique(group, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return nodes[first[order]], rank[group][quads]


def node_at(nodes, point):
    """Number of the node at ``point``.

    Raises:
        InputError: no node there; the message names the nearest.
    """
    distance = np.linalg.norm(nodes - np.asarray(point, dtype=float), axis=1)
    nearest = int(np.argmin(distance))
    if distance[nearest] > MERGE * np.ptp(nodes, axis=0).max():
        raise InputError(f"no node at {list(map(float, point))}; the nearest, node {nearest}, "
                         f"is at {nodes[nearest].tolist()}")
    return nearest


def line_nodes(nodes, quads, start, end):
    """Numbers of the nodes on the mesh line straight from ``start`` to ``end`` [m], in order.

    Raises:
        InputError: no node at either end, or no straight line of element edges between them.
    """
    first, last = node_at(nodes, start), node_at(nodes, end)
    chord = nodes[last] - nodes[first]
    length = np.linalg.norm(chord)
    if first == last:
        raise InputError(f"a line from node {first} to itself")
    along = (nodes - nodes[first]) @ chord / length
    off = np.linalg.norm(nodes - nodes[first] - along[:, None] * chord / length, axis=1)
    near = MERGE * np.ptp(nodes, axis=0).max()
    on = np.flatnonzero((off <= near) & (along >= -near) & (along <= length + near))
    line = on[np.argsort(along[on])]
    edges = np.sort(element_edges(quads), axis=1)
    joined = set(map(tuple, edges.tolist()))
    for i, j in zip(line[:-1].tolist(), line[1:].tolist()):
        if (min(i, j), max(i, j)) not in joined:
            raise InputError(f"no mesh line from {nodes[first].tolist()} to "
                             f"{nodes[last].tolist()}: no element edge joins nodes {i} and {j}")
    return line


def vector_areas(corners):
    """Area times normal (n_elem, 3) [m^2] of quads (n_elem, 4, 3): half the product of the
    diagonals, for a warped quad the area of its projection along that normal."""
    return 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])


def node_numbers(quads, n_nodes):
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
    check_connectivity(quads)
    _check_nodes(nodes, quads)
    _check_shapes(nodes, quads)


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
    pairs = cKDTree(nodes).query_pairs(MERGE * size, output_type="ndarray")
    if len(pairs):
        first, second = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))[0]]
        raise InputError(f"nodes {first} and {second} are at the same place "
                         f"{nodes[first].tolist()}")


def check_connectivity(quads):
    """Raise ``InputError`` for a repeated node or element."""
    for k, quad in enumerate(quads):
        if len(set(quad.tolist())) < 4:
            raise InputError(f"element {k}: nodes {quad.tolist()} repeat, a quad needs four")
    ordered = np.sort(quads, axis=1)
    _, first, inverse = np.unique(ordered, axis=0, return_index=True, return_inverse=True)
    duplicate = np.flatnonzero(first[inverse.ravel()] != np.arange(len(quads)))
    if len(duplicate):
        k = int(duplicate[0])
        raise InputError(f"element {k} duplicates element {int(first[inverse.ravel()[k]])}: nodes "
                         f"{quads[k].tolist()}")


def _check_shapes(nodes, quads):
    """No degenerate, inverted or non-convex element."""
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
