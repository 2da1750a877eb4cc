"""Numbering of the degrees of freedom, in a node order that keeps the band narrow."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, reverse_cuthill_mckee, shortest_path


@dataclass(frozen=True)
class Numbering:
    """Where the unknowns of each node stand.

    Attributes:
        cells: tuple of (n, k) node numbers: what acts between k nodes, the elements first.
        start: (n_nodes,) first dof of each node: x, y, z, then its rotational variables.
        n_rot: (n_nodes,) how many rotational variables a node has.
        first_neighbour: (n_nodes,) lowest ``start`` among a node and its neighbours.
        n_dof: number of dofs, fixed ones included.
    """

    cells: tuple
    start: np.ndarray
    n_rot: np.ndarray
    first_neighbour: np.ndarray
    n_dof: int

    @property
    def translations(self):
        """(n_nodes, 3) dofs of the displacements of each node."""
        return self.start[:, None] + np.arange(3)

    @property
    def node_of_dof(self):
        """(n_dof,) node that each dof belongs to."""
        order = np.argsort(self.start)
        return np.repeat(order, 3 + self.n_rot[order])


def number_dofs(cells, n_rot):
    """Number the dofs in the best node order found.

    Args:
        cells: see ``Numbering``.
        n_rot: (n_nodes,) rotational variables.
    """
    candidates = [_number(cells, n_rot, order) for order in node_orders(cells, len(n_rot))]
    return min(candidates, key=_factorization_work)


def node_orders(cells, n_nodes):
    """Candidate node orders: reverse Cuthill-McKee from a peripheral node, and Cuthill-McKee from
    the whole rim of nodes farthest from it (a strip is then numbered row by row), both ways."""
    rows, columns = node_pairs(cells)
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


def node_pairs(cells):
    """Nodes i and j, in two arrays, of all pairs that act on each other."""
    rows = [np.repeat(cell, cell.shape[1], axis=1).ravel() for cell in cells]
    columns = [np.tile(cell, (1, cell.shape[1])).ravel() for cell in cells]
    return np.concatenate(rows), np.concatenate(columns)


def _cuthill_mckee(graph, start):
    """Breadth-first order from the nodes ``start``; new neighbours of a node by their degree."""
    pointer, neighbours = graph.indptr, graph.indices
    degree = np.diff(pointer)
    seen = np.zeros(graph.shape[0], dtype=bool)
    seen[start] = True
    parts, level, count = [start], start, len(start)
    while count < len(seen):
        lengths = degree[level]
        if not len(level):
            rest = np.flatnonzero(~seen)
            level = rest[[np.argmin(degree[rest])]]
        else:
            begin = pointer[level] - np.r_[0, np.cumsum(lengths)[:-1]]
            new = neighbours[np.repeat(begin, lengths) + np.arange(lengths.sum())]
            first = np.repeat(np.arange(len(level)), lengths)
            fresh = np.flatnonzero(~seen[new])
            new, first = new[fresh], first[fresh]
            _, once = np.unique(new, return_index=True)  # of the first node that it neighbours
            once.sort()
            new, first = new[once], first[once]
            level = new[np.lexsort((degree[new], first))]
        seen[level] = True
        parts.append(level)
        count += len(level)
    return np.concatenate(parts)


def _number(cells, n_rot, order):
    start = np.empty(len(n_rot), dtype=np.int64)
    sizes = 3 + n_rot[order]
    start[order] = np.cumsum(sizes) - sizes
    first_neighbour = start.copy()
    for cell in cells:
        np.minimum.at(first_neighbour, cell, start[cell].min(axis=1)[:, None])
    return Numbering(tuple(cells), start, n_rot, first_neighbour, int(sizes.sum()))


def _factorization_work(numbering):
    """Sum of the squared row lengths of the skyline: the multiplications of a factorization."""
    return np.sum((numbering.start - numbering.first_neighbour + 3.0 + numbering.n_rot) ** 2)
