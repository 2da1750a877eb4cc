"""Joints and rigid bodies of a model as plain values: what result files and summaries tell of them.

What moves with a node is told by the node, the numbers of its directors and what these are at
first, and a vector in the initial configuration, see ``carried``.
"""

import numpy as np

from .bodies import GROUND, own_nodes
from .joints import Hinge, Spherical, names_of
from .linkages import Cylindrical, Prismatic, Revolute, RigidLink, Tie, Universal

KINDS = {Hinge: "hinge", Spherical: "spherical joint", Tie: "tie"}
"""Of joints that do not tell theirs."""

AXES = {Revolute: ("axis",), Cylindrical: ("axis",), Prismatic: ("axis",),
        Universal: ("axis", "other_axis")}
"""Axes that joints have; the first moves with ``one``, the second with ``other``."""


def kind_of(joint):
    """What a joint is called."""
    return KINDS.get(type(joint)) or joint.kind


def mechanism(model):
    """``joints`` and ``bodies`` of a model, lists of dictionaries without arrays.

    A joint has its ``name``, ``kind`` and what it joins: ``nodes`` that lie along it (of a hinge, a
    tie, a spherical joint), or ``points`` and ``axes`` that its ends carry, and the numbers of
    their nodes, ``ends`` (None: the ground).  A body has its ``name``, ``mass`` [kg], ``inertia``
    [kg m^2], ``axes``, the ``nodes`` that it carries and its own, ``at``, and the ``first`` number
    of its directors, which are its axes.
    """
    node_of = own_nodes(model)
    bodies = [{"name": body.name, "mass": body.mass, "inertia": list(body.inertia),
               "axes": body.directions.tolist(), "nodes": list(body.nodes),
               "at": node, "first": int(model.directors.first[node])}
              for body, node in zip(model.bodies, node_of.values())]
    return {"joints": [_joint(model, name, joint, node_of)
                       for name, joint in zip(names_of(model.joints), model.joints)],
            "bodies": bodies}


def summary(told):
    """What summaries say of a ``mechanism``: ``joints``, their kinds by their names, and
    ``bodies``, the mass [kg] and the number of carried nodes of each; None where there are none."""
    return {
        "joints": {joint["name"]: joint["kind"] for joint in told.get("joints", ())} or None,
        "bodies": {body["name"]: {"mass": body["mass"], "nodes": len(body["nodes"])}
                   for body in told.get("bodies", ())} or None}


def plural(number, kind):
    """How many there are of a kind, in words."""
    if number == 1:
        return f"1 {kind}"
    return f"{number} {kind[:-1]}ies" if kind.endswith("y") else f"{number} {kind}s"


def words_of_joints(kinds, most=8):
    """In words, of ``{name: kind}``: how many there are of a kind, and the names of few."""
    names = {}
    for name, kind in kinds.items():
        names.setdefault(kind, []).append(name)
    return ", ".join(plural(len(own), kind) + (f" ({', '.join(own)})" if len(own) <= most else "")
                     for kind, own in names.items())


def words_of_bodies(bodies, most=8):
    """In words, of ``{name: {mass, nodes}}``: of many the number and the mass."""
    if len(bodies) > most:
        total = sum(body["mass"] for body in bodies.values())
        return f"{len(bodies)} rigid bodies, {total:g} kg"
    return ", ".join(f"{name} {body['mass']:g} kg" + (
        f" with {plural(body['nodes'], 'node')}" if body["nodes"] else "")
        for name, body in bodies.items())


def _joint(model, name, joint, node_of):
    told = {"name": name, "kind": kind_of(joint)}
    if isinstance(joint, (Hinge, Spherical, Tie)):
        nodes = joint.nodes[:1] if isinstance(joint, Spherical) else joint.nodes
        return {**told, "nodes": list(nodes)}
    ends = [None if end == GROUND else node_of.get(end, end) for end in joint.ends]
    if isinstance(joint, RigidLink):  # a node is its own point
        places = [model.nodes[node] if node is not None and (given is None or node == end) else
                  given for end, node, given in zip(joint.ends, ends, (joint.at, joint.to))]
    else:
        places = [joint.place(model.nodes)]
    return {**told, "ends": ends,
            "points": [carried(model, end, place, turned=False)
                       for end, place in zip(ends, places)],
            "axes": [carried(model, end, getattr(joint, axis), turned=True)
                     for end, axis in zip(ends, AXES.get(type(joint), ()))]}


def carried(model, end, vector, turned=False):
    """A place, or a direction that is ``turned`` only, that a node takes along; ``end``: its
    number, None of the ground.

    Returns:
        dict: ``node``, ``vector`` (from the node, where it is a place), ``first`` number of its
        directors, and these in the initial configuration.
    """
    vector = np.asarray(vector, dtype=float)
    if end is None:
        return {"node": None, "vector": vector.tolist()}
    first, last = model.directors.first[end:end + 2].tolist()
    return {"node": end, "vector": (vector if turned else vector - model.nodes[end]).tolist(),
            "first": first, "directors": model.normals[first:last].tolist()}


def moved(carried, positions, directors):
    """(n_frames, 3) where what is carried is in each frame, see ``carried``.

    Args:
        carried: its dictionary; one that has ``turned`` is a direction.
        positions: (n_frames, n_nodes, 3) of nodes [m].
        directors: (n_frames, n_directors, 3).
    """
    vector, node = np.asarray(carried["vector"], dtype=float), carried["node"]
    if node is None:
        return np.broadcast_to(vector, (len(positions), 3))
    arm = np.broadcast_to(vector, (len(positions), 3))
    if np.any(vector) and "first" in carried:
        at, initial = carried["first"], np.array(carried["directors"])
        arm = np.einsum("fij,j->fi", turns(initial, directors[:, at:at + len(initial)]), vector)
    return arm if carried.get("turned") else positions[:, node] + arm


def turns(initial, present):
    """(n_frames, 3, 3) rotations that take ``initial`` directors (n, 3) to the ``present`` ones
    (n_frames, n, 3): of several the nearest one, of a single one the shortest."""
    if len(initial) > 1:
        u, _, v = np.linalg.svd(np.einsum("fni,nj->fij", present, initial))
        u[:, :, 2] *= np.linalg.det(u @ v)[:, None]
        return u @ v
    n, p = initial[0], present[:, 0]
    c, w = p @ n, np.cross(n, p)
    cross = np.zeros((len(p), 3, 3))
    for a, b, k in ((2, 1, 0), (0, 2, 1), (1, 0, 2)):
        cross[:, a, b], cross[:, b, a] = w[:, k], -w[:, k]
    return np.eye(3) + cross + cross @ cross / np.maximum(1.0 + c, 1e-9)[:, None, None]
