"""Meshes: blocks divided evenly and joined where their nodes coincide; checks of any mesh."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from .checks import TINY, plain_array
from .element import CORNERS, jacobians, shape_functions
from .errors import InputError

MERGE = 1e-9
"""Nodes closer than this fraction of the mesh's size are one node."""

MIN_JACOBIAN = 1e-6
"""Smallest vertex Jacobian relative to the element's largest below which a quad is degenerate."""

LARGEST_FOLD = 40.0
"""Largest angle [degrees] between a nodal normal and the normals of the elements it averages."""


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
    """Raise ``InputError`` for anything that is not the mesh of one or more smooth shells."""
    check_connectivity(quads)
    _check_nodes(nodes, quads)
    _check_shapes(nodes, quads)


def mean_normals(nodes, quads):
    """Nodal normals (n_nodes, 3), the mean of the unit element normals, Eqs. (13), (14).

    Raises:
        InputError: they cancel, or a node lies on a fold (junctions of several plates are not
            smooth and need more rotational variables).
    """
    corners = nodes[quads]
    normals = np.stack([_vertex_normals(corners, corner) for corner in CORNERS], axis=1)
    total = np.zeros_like(nodes)
    np.add.at(total, quads, normals)
    length = np.linalg.norm(total, axis=1)
    if np.any(length < 1e-6):
        raise InputError(f"node {int(np.argmin(length))}: the normals of its elements cancel")
    mean = total / length[:, None]
    angle = np.degrees(np.arccos(np.clip(np.einsum("eic,eic->ei", normals, mean[quads]), -1, 1)))
    if angle.max() > LARGEST_FOLD:
        element, vertex = np.unravel_index(np.argmax(angle), angle.shape)
        raise InputError(f"node {quads[element, vertex]}: the normal of element {element} is "
                         f"{angle.max():.0f} degrees from the mean there, at most "
                         f"{LARGEST_FOLD:g} make a smooth shell: refine the mesh; folds and "
                         "junctions are not supported")
    return mean


def _vertex_normals(corners, corner):
    """Unit normals (n_elem, 3) of the bilinear surfaces at one corner, Eq. (13)."""
    _, natural = shape_functions(corner)
    d_xi, d_eta = np.einsum("ai,eic->aec", natural, corners)
    normal = np.cross(d_xi, d_eta)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


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
    """Raise ``InputError`` for a repeated node or element, or neighbours of two orientations."""
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
    _check_orientation(quads)


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


def _check_orientation(quads):
    """Two elements must run through a shared edge in opposite directions."""
    edges = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
    _, first, counts = np.unique(edges, axis=0, return_index=True, return_counts=True)
    sides, uses = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    if np.any(uses > 2):
        edge = sides[np.argmax(uses)]
        raise InputError(f"the edge between nodes {edge[0]} and {edge[1]} belongs to "
                         f"{uses.max()} elements: junctions are not supported")
    if np.any(counts > 1):
        edge = edges[first[np.argmax(counts > 1)]]
        owners = np.flatnonzero((edges == edge).all(axis=1)) // 4
        raise InputError(f"element {owners[1]} is inverted against its neighbour {owners[0]}: both "
                         f"run from node {edge[0]} to node {edge[1]}")
