"""Rigid bodies: mass and inertia without elements, at reference nodes of their own."""

from dataclasses import dataclass, replace

import numpy as np

from ..checks import TINY, distinct, existing, integers, positive, text, vector
from ..errors import InputError
from ..fields import put
from .directors import Directors
from .loads import axes_of


@dataclass(frozen=True)
class RigidBody:
    """A rigid body; the nodes that it carries move and turn with it.

    Its reference node stands at the end of the nodes of a ``Model``, the first of the first body
    (``Model.of`` adds them), and belongs to no element.  Its three directors are its principal
    axes, so that ``rigid_velocity`` and results know it like a junction.

    Attributes:
        name: by which joints know it.
        mass: [kg].
        inertia: its three principal moments about the centre of mass [kg m^2].
        centre: (x, y, z) of mass [m].
        nodes: of the shell, that it carries.
        axes: (3, 3) principal axes in rows, orthogonal and of any length; along the global ones
            without it.

    Raises:
        InputError: mass or moments that no body has.
    """

    name: str
    mass: float
    inertia: tuple
    centre: tuple
    nodes: tuple = ()
    axes: tuple = None

    def __post_init__(self):
        put(self, name=text("body: name", self.name))
        what = f"body {self.name}"
        if self.name == GROUND:
            raise InputError(f"body: no body can be named '{GROUND}'")
        put(self, mass=positive(f"{what}: mass", self.mass, "kg"),
            centre=vector(f"{what}: centre", self.centre, "m"),
            inertia=vector(f"{what}: inertia", self.inertia, "kg m^2"))
        carried = integers(f"{what}: nodes", self.nodes)
        put(self, nodes=carried and distinct(f"{what}: nodes", carried))
        if min(self.spread) < -1e-9 * max(self.inertia) or min(self.inertia) < TINY:
            raise InputError(f"{what}: moments of inertia {self.inertia} belong to no body: each "
                             "must be positive and at most the sum of the other two")
        put(self, axes=axes_of(f"{what}: axes", self.axes))

    @property
    def spread(self):
        """(3,) ``int x_k^2 dm`` along its axes [kg m^2]: ``J = sum_k spread_k (1 - p_k p_k^T)``."""
        return np.array([0.5 * (sum(self.inertia) - 2.0 * one) for one in self.inertia])

    @property
    def directions(self):
        """(3, 3) its principal axes in rows, unit vectors."""
        return np.eye(3) if self.axes is None else np.array(self.axes)


GROUND = "ground"
"""What joints call the ground."""


def check_bodies(bodies, nodes, quads):
    """Check names and places.

    Raises:
        InputError: a name twice, a reference node that is not where its body is, or that elements
            have, a node carried by two.
    """
    first, carried = len(nodes) - len(bodies), {}
    for k, body in enumerate(bodies):
        if [other.name for other in bodies].count(body.name) > 1:
            raise InputError(f"two bodies are named '{body.name}'")
        existing(f"body {body.name}: node", body.nodes, first)
        gap = np.linalg.norm(nodes[first + k] - body.centre)
        if gap > 1e-9 * (1.0 + np.abs(body.centre).max()):
            raise InputError(f"body {body.name}: node {first + k} must be its centre "
                             f"{list(body.centre)}, is at {nodes[first + k].tolist()} (the last "
                             "nodes are those of bodies; Model.of adds them)")
        for node in body.nodes:
            if node in carried:
                raise InputError(f"body {body.name}: {carried[node]} carries node {node} as well")
            carried[node] = body.name
    if bodies and quads.max() >= first:
        raise InputError(f"bodies: the last {len(bodies)} nodes are theirs, elements have node "
                         f"{quads.max()}")


def with_bodies(found, bodies):
    """``Directors`` found for the nodes of elements, with the axes of bodies."""
    if not bodies:
        return found
    axes = np.concatenate([body.directions for body in bodies])
    n, own = len(found.normals), 3 * np.arange(1, len(bodies) + 1)
    shell = found.first[:len(found.first) - len(bodies)]
    return Directors(np.concatenate([found.normals, axes]), np.concatenate([shell, n + own]),
                     found.vertices)


def own_nodes(model):
    """``{name: number of its node}`` of the bodies of a model."""
    return {body.name: node for body, (node, _) in zip(model.bodies, model.body_masses)}


def moved(bodies, nodes, normals):
    """Bodies where ``nodes`` and ``normals`` of a state are."""
    first, axes = len(nodes) - len(bodies), normals[len(normals) - 3 * len(bodies):]
    return [replace(body, centre=nodes[first + k], axes=axes[3 * k:3 * k + 3])
            for k, body in enumerate(bodies)]


def spreads(bodies, n_directors):
    """(n_directors,) ``RigidBody.spread`` at the directors of bodies, zero elsewhere."""
    found = np.zeros(n_directors)
    if bodies:
        found[-3 * len(bodies):] = np.concatenate([body.spread for body in bodies])
    return found
