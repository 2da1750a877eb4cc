"""Whether a model is held: statics needs supports against every rigid motion."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..errors import InputError
from ..model.attached import GroundSpring, Spring

HELD = 1e-9
"""Smallest singular value of what the supports hold of unit motions, the shell's size being 1."""


def check_held(model):
    """Every connected part of the shell must be held against its six rigid motions."""
    n_nodes, quads, fixed = len(model.nodes), model.quads, model.fixed
    links = coo_array((np.ones(quads.size), (np.repeat(quads[:, 0], 4), quads.ravel())),
                      shape=(n_nodes, n_nodes))
    n_parts, part = connected_components(links, directed=False)
    fixed = fixed | _sprung(model)
    joined = {part[node] for item in model.attached if isinstance(item, Spring)
              and part[item.node] != part[item.other] for node in (item.node, item.other)}
    for k in set(range(n_parts)) - joined:  # a mechanism on springs is found by its pivots
        inside = part == k
        _, sizes, motions = np.linalg.svd(_held_motions(model, fixed, np.flatnonzero(inside)))
        free = motions[np.count_nonzero(sizes > HELD):]
        if len(free):
            which = "the shell" if n_parts == 1 else f"the part with node {np.argmax(inside)}"
            motions = "1 rigid motion" if len(free) == 1 else f"{len(free)} rigid motions"
            raise InputError(f"the supports leave {motions} of {which} free, {_told(free)}: hold "
                             "it by a Support, as in supports=[Support(nodes, components)]")


def _sprung(model):
    """(n_nodes, 6) components that springs to the ground hold."""
    held = np.zeros((len(model.nodes), 6), dtype=bool)
    for item in model.attached:
        if isinstance(item, GroundSpring):
            held[item.node, :3] |= np.array(item.stiffness) > 0.0
            held[item.node, 3:] |= item.turning > 0.0
    return held


def _told(free):
    """The rigid motions (n, 6) of a space, in words."""
    _, sizes, mixed = np.linalg.svd(free[:, 3:].T)
    turning = np.count_nonzero(sizes > HELD)
    turns, shifts = mixed[:turning] @ free[:, 3:], mixed[turning:] @ free[:, :3]
    told = (("translation along", shifts), ("rotation about an axis along", turns))
    return " and ".join(f"{what} {_directions(vectors)}" for what, vectors in told if len(vectors))


def _directions(vectors):
    """The directions that some independent vectors span, by axes where they are axes."""
    _, _, unit = np.linalg.svd(vectors, full_matrices=False)
    axes = np.flatnonzero(np.linalg.norm(unit, axis=0) > 1.0 - HELD)
    if len(axes) == len(unit):
        return ", ".join("xyz"[axis] for axis in axes)
    rounded = np.round(unit, 3) + 0.0
    return ", ".join(f"({', '.join(f'{c:g}' for c in vector)})" for vector in rounded)


def _held_motions(model, fixed, nodes):
    """What the six rigid motions do to the held components of some nodes, (n_held, 6); at a
    junction to those of all its normals."""
    first, centre = model.directors.first, model.nodes[nodes].mean(axis=0)
    rows, axes = [np.zeros((0, 6))], np.eye(3)

    def motion(i):
        return np.column_stack([axes, -_spin((model.nodes[i] - centre) / model.size)])

    for i in nodes[fixed[nodes].any(axis=1) | np.isin(nodes, list(model.oblique))]:
        oblique = model.oblique.get(i, (axes[:0], axes[:0]))
        rows.append(np.concatenate([axes[fixed[i, :3]], oblique[0]]) @ motion(i))
        held = np.concatenate([axes[fixed[i, 3:]], oblique[1]])
        for p in model.normals[first[i]:first[i + 1]]:
            rows.append(held @ np.column_stack([np.zeros((3, 3)), -_spin(p)]))
    if model.pairs:
        R, masters, slaves, _ = model.pairs
        rows.extend(R @ motion(m) - motion(s) for m, s in zip(masters, slaves) if m in nodes)
    return np.concatenate(rows)


def _spin(v):
    """The matrix [v]x with ``[v]x a = v x a``."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
