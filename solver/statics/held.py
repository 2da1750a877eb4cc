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
        held = fixed[inside]
        x = (model.nodes[inside] - model.nodes[inside].mean(axis=0)) / model.size
        p = model.normals[model.directors.first[:-1]][inside]
        motions = np.zeros((len(x), 6, 6))
        motions[:, :3, :3] = np.eye(3)
        for axis, omega in enumerate(np.eye(3)):
            motions[:, :3, 3 + axis] = np.cross(omega, x)
            motions[:, 3:, 3 + axis] = np.cross(omega, p)
        free = 6 - np.linalg.matrix_rank(motions[held], tol=1e-9) if held.any() else 6
        if free:
            which = "the shell" if n_parts == 1 else f"the part with node {np.argmax(inside)}"
            motions = "1 rigid motion" if free == 1 else f"{free} rigid motions"
            raise InputError(f"the supports leave {motions} of {which} free")
