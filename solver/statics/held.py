"""Whether a model is held: statics needs supports against every rigid motion."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..errors import InputError
from ..model.attached import GroundSpring, Spring
from ..model.joints import Hinge

HELD = 1e-9
"""Smallest singular value of what the supports hold of unit motions, the shell's size being 1."""

MOST_TOLD = 3
"""Parts of a mechanism that a message tells of."""

MOST_PARTS = 200
"""Parts that joints connect, up to which their motions are looked at together: a mechanism of more
is found by its pivots."""


def check_held(model, linked=None):
    """Every part of the shell, and every body, must be held against its six rigid motions, by
    supports and by joints with others that are; ``linked``: ``StillLinks``, if there are any."""
    n_nodes, quads, fixed = len(model.nodes), model.quads, model.fixed
    links = coo_array((np.ones(quads.size), (np.repeat(quads[:, 0], 4), quads.ravel())),
                      shape=(n_nodes, n_nodes))
    n_parts, part = connected_components(links, directed=False)
    fixed = fixed | _sprung(model)
    joined = {part[node] for item in model.attached if isinstance(item, Spring)
              and part[item.node] != part[item.other] for node in (item.node, item.other)}
    for group in _groups(model, part, n_parts, linked):
        # a mechanism on springs is found by its pivots
        if not joined.intersection(group) and len(group) <= MOST_PARTS:
            _check_group(model, fixed, part, group, linked)


def _groups(model, part, n_parts, linked):
    """Arrays of parts that joints connect."""
    pairs = [np.zeros((0, 2), dtype=int), *(part[joint.tied] for joint in model.joints)]
    pairs += [part[[nodes[:-1], nodes[1:]]].T for nodes in (linked.sides() if linked else ())]
    pairs = np.concatenate(pairs)
    links = coo_array((np.ones(len(pairs)), pairs.T), shape=(n_parts, n_parts))
    n_groups, group = connected_components(links, directed=False)
    return [np.flatnonzero(group == k) for k in range(n_groups)]


def _check_group(model, fixed, part, group, linked):
    """Parts that joints connect, or a single one."""
    column = {k: slice(6 * n, 6 * n + 6) for n, k in enumerate(group.tolist())}
    nodes = {k: np.flatnonzero(part == k) for k in column}
    centres = {k: model.nodes[inside].mean(axis=0) for k, inside in nodes.items()}
    rows = [np.zeros((0, 6 * len(group)))]
    for k, inside in nodes.items():
        held = _held_motions(model, fixed, inside, centres[k])
        rows.append(np.zeros((len(held), 6 * len(group))))
        rows[-1][:, column[k]] = held
    for joint in model.joints:
        if len(joint.tied) and part[joint.tied[0, 0]] in column:
            rows.append(_joined_motions(model, joint, part, column, centres))
    if linked:
        rows.append(_linked_motions(model, linked, part, column, centres))
    _, sizes, motions = np.linalg.svd(np.concatenate(rows))
    free = motions[np.count_nonzero(sizes > HELD):]
    if not len(free):
        return
    counted = "1 rigid motion" if len(free) == 1 else f"{len(free)} rigid motions"
    if len(group) == 1:
        which = "the shell" if part.max() == 0 else _name(model, nodes[group[0]])
        raise InputError(f"the supports leave {counted} of {which} free, {_told(free)}: hold "
                         "it by a Support, as in supports=[Support(nodes, components)]"
                         f"{_others(linked, nodes[group[0]])}")
    moving, of = [], []
    for k, at in column.items():
        _, sizes, own = np.linalg.svd(free[:, at])
        if np.any(sizes > HELD):
            moving.append(f"of {_name(model, nodes[k])} {_told(own[:sum(sizes > HELD)])}")
            of.extend(nodes[k].tolist())
    more = f"; and of {len(moving) - MOST_TOLD} parts more" if len(moving) > MOST_TOLD else ""
    raise InputError(f"supports and joints leave {counted} free: {'; '.join(moving[:MOST_TOLD])}"
                     f"{more}: {_advice(linked, of)}")


def _advice(linked, moving):
    """What to do, with the joints of nodes that move."""
    others = _others(linked, moving)
    kinds = "a Hinge or Revolute" if others else "a Hinge"
    return f"hold them by a Support, or {kinds} by its stiffness{others}"


def _others(linked, moving):
    """Which joints let nodes move, as an end of a sentence."""
    joints = linked.joints_of(moving) if linked else []
    more = " and others" if len(joints) > MOST_TOLD else ""
    if not joints:
        return ""
    return f", or take joints that hold more than {', '.join(joints[:MOST_TOLD])}{more}"


def _name(model, nodes):
    """A part, by a node or as a body."""
    body = nodes[0] - (len(model.nodes) - len(model.bodies))
    return f"body {model.bodies[body].name}" if body >= 0 else f"the part with node {nodes[0]}"


def _linked_motions(model, linked, part, column, centres):
    """What joints with multipliers, and springs in them, hold of the motions of their parts."""
    rows = linked.holds()
    found = np.zeros((len(rows), 6 * len(column)))
    for i, on_place, on_turn in linked.at_nodes(rows):
        if part[i] not in column:
            continue
        arm = (model.nodes[i] - centres[part[i]]) / model.size
        found[:, column[part[i]]] += np.hstack(
            [on_place, np.cross(arm, on_place) + on_turn / model.size])
    sizes = np.linalg.norm(found, axis=1, keepdims=True)
    return found[sizes[:, 0] > 0.0] / sizes[sizes[:, 0] > 0.0]


def _joined_motions(model, joint, part, column, centres):
    """What a joint holds of the motions of its parts: shared places, and of a hinge with a spring
    that about its axis."""
    def motion(i):
        found = np.zeros((3, 6 * len(column)))
        k = part[i]
        found[:, column[k]] = np.column_stack(
            [np.eye(3), -_spin((model.nodes[i] - centres[k]) / model.size)])
        return found

    rows = [motion(one) - motion(other) for one, other in joint.tied]
    if isinstance(joint, Hinge) and joint.springs_back:
        one, other = (column[part[i]] for i in joint.tied[0])
        axis = model.nodes[joint.nodes[-1]] - model.nodes[joint.nodes[0]]
        row = np.zeros((1, 6 * len(column)))
        row[0, other][3:] += axis / np.linalg.norm(axis)
        row[0, one][3:] -= axis / np.linalg.norm(axis)
        rows.append(row)
    return np.concatenate(rows)


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


def _held_motions(model, fixed, nodes, centre):
    """What the six rigid motions about a centre do to the held components of some nodes,
    (n_held, 6); at a junction to those of all its normals."""
    first = model.directors.first
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
