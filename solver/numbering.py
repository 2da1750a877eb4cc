"""Numbering of the degrees of freedom, in a node order that keeps the band narrow."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee


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


def number_dofs(quads, n_nodes):
    """Number the dofs of a smooth shell along the reverse Cuthill-McKee order of its nodes."""
    rows = np.repeat(quads, 4, axis=1).ravel()
    columns = np.tile(quads, (1, 4)).ravel()
    graph = csr_array((np.ones(rows.size), (rows, columns)), shape=(n_nodes, n_nodes))
    order = reverse_cuthill_mckee(graph, symmetric_mode=True)
    n_rot = np.full(n_nodes, 2, dtype=np.int64)
    start = np.empty(n_nodes, dtype=np.int64)
    sizes = 3 + n_rot[order]
    start[order] = np.cumsum(sizes) - sizes
    first_neighbour = start.copy()
    np.minimum.at(first_neighbour, quads, start[quads].min(axis=1)[:, None])
    return Numbering(quads, start, n_rot, first_neighbour, int(sizes.sum()))
