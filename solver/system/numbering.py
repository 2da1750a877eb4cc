"""Numbering of the degrees of freedom, in a node order that keeps the band narrow."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, reverse_cuthill_mckee, shortest_path


@dataclass(frozen=True)
class Numbering:
    """Where the unknowns of each node stand.

    Attributes:
        quads: (n_elem, 4) connectivity.
        start: (n_nodes,) first dof of each node: x, y, z, then its rotational variables.
        n_rot: (n_nodes,) how many rotational variables a node has.
        first_neighbour: (n_nodes,) lowest ``start`` among a node and its neighbours.
        n_dof: number of dofs, fixed ones included.
    """

    quads: np.ndarray
    start: np.ndarray
    n_rot: np.ndarray
    first_neighbour: np.ndarray
    n_dof: int

    @property
    def node_of_dof(self):
        """(n_dof,) node that each dof belongs to."""
        order = np.argsort(self.start)
        return np.repeat(order, 3 + self.n_rot[order])


def number_dofs(quads, n_rot):
    """Number the dofs in the best node order found; ``n_rot`` (n_nodes,) rotational variables."""
    candidates = [_number(quads, n_rot, order) for order in node_orders(quads, len(n_rot))]
    return min(candidates, key=_factorization_work)


def node_orders(quads, n_nodes):
    """Candidate node orders: reverse Cuthill-McKee from a peripheral node, and Cuthill-McKee from
    the whole rim of nodes farthest from it (a strip is then numbered row by row), both ways."""
    rows = np.repeat(quads, 4, axis=1).ravel()
    columns = np.tile(quads, (1, 4)).ravel()
    graph = csr_array((np.ones(rows.size), (rows, columns)), shape=(n_nodes, n_nodes))
    yield reverse_cuthill_mckee(graph, symmetric_mode=True)
    far = 0
    for _ in range(2):
        far = breadth_first_order(graph, far, return_predecessors=False)[-1]
    distance = shortest_path(graph, unweighted=True, indices=far)
    rim = np.flatnonzero(distance == distance[np.isfinite(distance)].max())
    rim = rim[reverse_cuthill_mckee(graph[rim][:, rim], symmetric_mode=True)]
    order = _cuthill_mckee(graph, rim)
    yield order
    yield order[::-1]


def _cuthill_mckee(graph, start):
    """Breadth-first order from the nodes ``start``; new neighbours of a node by their degree."""
    pointer, neighbours = graph.indptr, graph.indices
    degree = np.diff(pointer)
    seen = np.zeros(graph.shape[0], dtype=bool)
    seen[start] = True
    order = list(start)
    reached = 0
    while len(order) < len(seen):
        if reached == len(order):
            rest = np.flatnonzero(~seen)
            order.append(rest[np.argmin(degree[rest])])
            seen[order[-1]] = True
        node = order[reached]
        reached += 1
        new = neighbours[pointer[node]:pointer[node + 1]]
        new = new[~seen[new]]
        seen[new] = True
        order.extend(new[np.argsort(degree[new], kind="stable")])
    return np.array(order)


def _number(quads, n_rot, order):
    start = np.empty(len(n_rot), dtype=np.int64)
    sizes = 3 + n_rot[order]
    start[order] = np.cumsum(sizes) - sizes
    first_neighbour = start.copy()
    np.minimum.at(first_neighbour, quads, start[quads].min(axis=1)[:, None])
    return Numbering(quads, start, n_rot, first_neighbour, int(sizes.sum()))


def _factorization_work(numbering):
    """Sum of the squared row lengths of the skyline: the multiplications of a factorization."""
    return np.sum((numbering.start - numbering.first_neighbour + 3.0 + numbering.n_rot) ** 2)
