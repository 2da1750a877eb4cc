"""Whether a model is held: statics needs supports against every rigid motion."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..errors import InputError


def check_held(model):
    """Every connected part of the shell must be held against its six rigid motions."""
    n_nodes, quads, fixed = len(model.nodes), model.quads, model.fixed
    links = coo_array((np.ones(quads.size), (np.repeat(quads[:, 0], 4), quads.ravel())),
                      shape=(n_nodes, n_nodes))
    n_parts, part = connected_components(links, directed=False)
    for k in range(n_parts):
        inside = part == k
        rows = _held_motions(model, fixed, np.flatnonzero(inside))
        free = 6 - np.linalg.matrix_rank(rows, tol=1e-9) if len(rows) else 6
        if free:
            which = "the shell" if n_parts == 1 else f"the part with node {np.argmax(inside)}"
            motions = "1 rigid motion" if free == 1 else f"{free} rigid motions"
            raise InputError(f"the supports leave {motions} of {which} free")


def _held_motions(model, fixed, nodes):
    """What the six rigid motions do to the held components of some nodes, (n_held, 6); at a
    junction to those of all its normals."""
    first, centre = model.directors.first, model.nodes[nodes].mean(axis=0)
    rows = [np.zeros((0, 6))]
    for i in nodes[fixed[nodes].any(axis=1)]:
        arm = (model.nodes[i] - centre) / model.size
        rows.append(np.column_stack([np.eye(3), -_spin(arm)])[fixed[i, :3]])
        for p in model.normals[first[i]:first[i + 1]]:
            rows.append(np.column_stack([np.zeros((3, 3)), -_spin(p)])[fixed[i, 3:]])
    return np.concatenate(rows)


def _spin(v):
    """The matrix [v]x with ``[v]x a = v x a``."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
