"""Structured meshes: four-sided blocks divided evenly and joined where their nodes coincide."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from .element import shape_functions
from .errors import InputError

MERGE = 1e-9
"""Nodes closer than this fraction of the mesh's size are one node."""


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
