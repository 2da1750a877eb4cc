"""Joints between the nodes of plates: edges that fold about a hinge, corners that turn freely.

Nodes that are joined move together; the normals of the plates stay their own.  What a hinge has
besides, a spring, a damper, stops, a latch, a motor, turns the plates against each other by their
angle, see ``kernels.hinges``.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..checks import distinct, existing, not_negative, number, numbers, positive, text
from ..errors import InputError
from ..fields import put
from .histories import CONSTANT, FunctionOfTime
from .loads import Support, history_of
from .tables import check_tables

STRAIGHT = 1e-6
"""How far a node of a hinge may lie beside its axis, in lengths of the hinge."""

PLACE = 1e-6
"""How far apart joined nodes may lie, in the spacing of the hinge or sizes of the shell."""

NEAR = 1e-6
"""Change of angle [rad] by which a spring given as a table shows whether it holds."""

PARALLEL = 0.1
"""Largest cosine between the axis of a hinge and the normals of its plates."""


@dataclass(frozen=True)
class Spherical:
    """Nodes at one place that move together, while the plates there turn freely.

    Attributes:
        nodes: two or more, of different plates.
        name: by which results and messages know it; left out, ``joint`` and its number.
    """

    nodes: tuple
    name: str = ""

    def __post_init__(self):
        nodes = distinct("spherical joint: nodes", self.nodes)
        if len(nodes) < 2:
            raise InputError(f"spherical joint: two nodes or more are needed, {len(nodes)} given")
        put(self, nodes=nodes, name=name_of("spherical joint: name", self.name))

    @property
    def tied(self):
        """(n, 2) nodes that move together."""
        return np.stack([np.full(len(self.nodes) - 1, self.nodes[0]), self.nodes[1:]], axis=1)


@dataclass(frozen=True, kw_only=True)
class Turning:
    """What turns two bodies against each other by an angle, which is zero at t = 0.

    The moment that turns it further is

        ``M = torque h(t) - stiffness (angle - rest g(t)) - damping d angle/dt - stops - latch``.

    A spring or a damper may be a table instead, or besides: moments that hold back at angles,
    counted from ``rest g(t)``, and at rates; linear between its points, constant beyond both ends.

    A stop is a spring of ``stop_stiffness`` beyond its angle.  A latch is a stop at the angle
    ``lock`` that also holds back, once the joint has been there: it then is a spring of
    ``lock_stiffness`` about that angle, with ``lock_damping``.

    Attributes:
        stiffness: [N m/rad].
        rest: angle at which the spring is slack [rad].
        turning: ``FunctionOfTime`` g that multiplies ``rest``: the spring is a servo then.
        spring_angles: of the table of a spring, rising [rad].
        spring_moments: there [N m].
        damping: [N m s/rad].
        damper_rates: of the table of a damper, rising [rad/s].
        damper_moments: there, zero at rest and never with the motion [N m].
        stops: the smallest and the largest angle [rad]; None for none.
        stop_stiffness: [N m/rad].
        lock: angle of the latch [rad]; None for none.
        lock_stiffness: [N m/rad].
        lock_damping: [N m s/rad].
        torque: of a motor [N m].
        history: ``FunctionOfTime`` h of the motor.
        name: by which results and messages know it; left out, ``joint`` and its number.
    """

    stiffness: float = 0.0
    rest: float = 0.0
    turning: FunctionOfTime = CONSTANT
    spring_angles: tuple = ()
    spring_moments: tuple = ()
    damping: float = 0.0
    damper_rates: tuple = ()
    damper_moments: tuple = ()
    stops: tuple = None
    stop_stiffness: float = 0.0
    lock: float = None
    lock_stiffness: float = 0.0
    lock_damping: float = 0.0
    torque: float = 0.0
    history: FunctionOfTime = CONSTANT
    name: str = ""

    def _check_turning(self, what):
        for name, unit in (("stiffness", "N m/rad"), ("damping", "N m s/rad"),
                           ("stop_stiffness", "N m/rad"), ("lock_stiffness", "N m/rad"),
                           ("lock_damping", "N m s/rad")):
            put(self, **{name: not_negative(f"{what}: {name}", getattr(self, name), unit)})
        put(self, rest=number(f"{what}: rest", self.rest, "rad"),
            torque=number(f"{what}: torque", self.torque, "N m"),
            **{name: history_of(getattr(self, name), f"{what}: {name}")
               for name in ("history", "turning")})
        check_tables(what, self, ("spring_angles", "spring_moments"),
                     ("damper_rates", "damper_moments"), ("rad/s", "N m"))
        if self.stops is not None:
            stops = numbers(f"{what}: stops", self.stops)
            if len(stops) != 2 or not stops[0] < stops[1] or not stops[0] <= 0.0 <= stops[1]:
                raise InputError(f"{what}: stops must be two angles, the smaller first, with the "
                                 f"initial angle 0 between them, are {stops}")
            put(self, stops=stops)
            positive(f"{what}: stop_stiffness", self.stop_stiffness, "N m/rad")
        if self.lock is not None:
            put(self, lock=number(f"{what}: lock", self.lock, "rad"))
            if self.lock == 0.0:
                raise InputError(f"{what}: lock must not be the initial angle 0: that is no joint")
            positive(f"{what}: lock_stiffness", self.lock_stiffness, "N m/rad")

    @property
    def acts(self):
        """Whether it has a moment."""
        return bool(self.stiffness or self.damping or self.stops or self.torque
                    or self.spring_angles or self.damper_rates or self.lock is not None)

    @property
    def springs_back(self):
        """Whether a spring, of a table too, holds it where it is at first."""
        before, after = np.interp((-self.rest - NEAR, -self.rest + NEAR),
                                  self.spring_angles or (0.0,), self.spring_moments or (0.0,))
        return bool(self.stiffness > 0.0 or after > before)


@dataclass(frozen=True)
class Hinge(Turning):
    """Two straight edges that move together, while the plates fold about them.

    The angle is that by which the plate of ``others`` has turned against the plate of ``nodes``,
    right-handed about the axis from the first of ``nodes`` to the last [rad]; its moment, of the
    attributes of ``corovec.solver.model.joints.Turning``, is shared by the nodes in proportion to
    the length of the edge that is theirs.

    Attributes:
        nodes: of the one plate, along the edge.
        others: of the other, at the same places, in the same order.
    """

    nodes: tuple
    others: tuple

    ends = ()

    def __post_init__(self):
        put(self, name=name_of("hinge: name", self.name))
        what = f"hinge {self.name}".rstrip()
        for side in ("nodes", "others"):
            put(self, **{side: distinct(f"{what}: {side}", getattr(self, side))})
        if len(self.nodes) != len(self.others):
            raise InputError(f"{what}: {len(self.nodes)} nodes but {len(self.others)} others")
        if len(self.nodes) < 2:
            raise InputError(f"{what}: an edge has two nodes or more, {len(self.nodes)} given (a "
                             "single one is a Spherical joint)")
        self._check_turning(what)

    @property
    def tied(self):
        """(n, 2) nodes that move together."""
        return np.stack([self.nodes, self.others], axis=1)

    @property
    def places(self):
        """Number of places, two nodes each, at which it has a moment."""
        return len(self.nodes) * self.acts


JOINTS = (Spherical, Hinge)


def names_of(joints):
    """Name of each joint."""
    return [joint.name or f"joint {k}" for k, joint in enumerate(joints)]


def classes_of(joints, n_nodes):
    """Sorted lists of nodes that move together, by the first of each."""
    pairs = np.concatenate([np.zeros((0, 2), dtype=np.int64), *(joint.tied for joint in joints)])
    links = coo_array((np.ones(len(pairs)), pairs.T), shape=(n_nodes, n_nodes))
    _, group = connected_components(links, directed=False)
    found = {}
    for node in np.unique(pairs).tolist():
        found.setdefault(group[node], []).append(node)
    return sorted(found.values())


def places_of(joints):
    """Number of places at which joints have moments."""
    return sum(joint.places for joint in joints if isinstance(joint, Turning))


def check_joints(joints, nodes, quads):
    """Check nodes and places.

    Raises:
        InputError: names and nodes that do not exist or repeat, nodes that are not at one place or
            belong to one element, an edge that is no straight line.
    """
    if not joints:
        return
    names = names_of(joints)
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"two joints are named '{name}'")
    size = np.ptp(nodes, axis=0).max()
    group = np.arange(len(nodes))
    for name, joint in zip(names, joints):
        pairs = joint.tied
        if not len(pairs):
            continue
        existing(f"{name}: node", pairs.ravel().tolist(), len(nodes))
        if pairs.max() > quads.max():
            raise InputError(f"{name}: node {pairs.max()} is that of a rigid body, which takes a "
                             "Ball or a Revolute")
        same = pairs[:, 0] == pairs[:, 1]
        if np.any(same):
            raise InputError(f"{name}: node {pairs[np.argmax(same), 0]} is joined to itself; each "
                             "plate needs nodes of its own there (corovec.cut makes them)")
        gaps = np.linalg.norm(nodes[pairs[:, 1]] - nodes[pairs[:, 0]], axis=1)
        k = int(np.argmax(gaps))
        if gaps[k] > PLACE * size:
            raise InputError(f"{name}: nodes {pairs[k, 0]} and {pairs[k, 1]} are {gaps[k]:.3g} m "
                             "apart, joined nodes must be at the same place")
        if isinstance(joint, Hinge):
            _check_edge(name, nodes[list(joint.nodes)])
    for members in classes_of(joints, len(nodes)):
        group[members] = members[0]
    ordered = np.sort(group[quads], axis=1)
    several = np.flatnonzero(np.any(ordered[:, 1:] == ordered[:, :-1], axis=1))
    if len(several):
        raise InputError(f"joints: element {several[0]}, nodes {quads[several[0]].tolist()}, has "
                         "two nodes that move together")


def check_axes(joints, nodes, directors):
    """A hinge turns the normals of its plates: none of them is along its axis, and each node has
    one.

    Raises:
        InputError: naming the node.
    """
    first = directors.first
    for name, joint in zip(names_of(joints), joints):
        if not isinstance(joint, Hinge) or not joint.acts:
            continue
        x = nodes[list(joint.nodes)]
        axis = (x[-1] - x[0]) / np.linalg.norm(x[-1] - x[0])
        for i in (*joint.nodes, *joint.others):
            if first[i + 1] - first[i] > 1:
                raise InputError(f"{name}: several plates meet at node {i}; a hinge with a moment "
                                 "needs nodes with one normal")
            if abs(directors.normals[first[i]] @ axis) > PARALLEL:
                raise InputError(f"{name}: the normal of node {i} is not at right angles to the "
                                 "axis of the hinge")


def check_velocities(joints, velocity):
    """Joined nodes start with one velocity.

    Raises:
        InputError: naming them.
    """
    small = 1e-12 * (1.0 + np.abs(velocity).max())
    for name, joint in zip(names_of(joints), joints):
        for one, other in joint.tied:
            if np.abs(velocity[one] - velocity[other]).max() > small:
                raise InputError(f"{name}: nodes {one} and {other} start with different "
                                 f"velocities, {velocity[one].tolist()} and "
                                 f"{velocity[other].tolist()}")


def supports_of(supports, classes):
    """Supports, and those that they imply: what holds a node holds those that move with it.

    Raises:
        InputError: a ``Drive`` holds a joined node.
    """
    made = list(supports)
    for k, support in enumerate(supports):
        for group in classes:
            held = set(group).intersection(support.nodes)
            others = tuple(i for i in group if i not in held)
            if not held or not others:
                continue
            if not isinstance(support, Support):
                raise InputError(f"support {k}: a Drive moves node {min(held)}, which is joined; "
                                 "hold its plate elsewhere, or turn it by its hinge")
            components = tuple(c for c in support.components if c in ("x", "y", "z"))
            implied = components and Support(others, components, support.displacement,
                                             support.history, support.axes)
            if implied and implied not in made:
                made.append(implied)
    return tuple(made)


def shares_of_edge(x):
    """(n,) parts of a line of places (n, 3) that belong to each, in sum 1."""
    lengths = np.linalg.norm(np.diff(x, axis=0), axis=1)
    shares = 0.5 * (np.r_[lengths, 0.0] + np.r_[0.0, lengths])
    return shares / shares.sum()


def name_of(what, value):
    """A name, or none."""
    return value if isinstance(value, str) and not value else text(what, value)


def _check_edge(name, x):
    """The nodes of a hinge lie on a straight line, one behind the other."""
    axis = x[-1] - x[0]
    length = np.linalg.norm(axis)
    if length == 0.0:
        raise InputError(f"{name}: its edge begins and ends at one place")
    off = np.linalg.norm(np.cross(x - x[0], axis / length), axis=1)
    k = int(np.argmax(off))
    if off[k] > STRAIGHT * length:
        raise InputError(f"{name}: its edge is not straight: place {k} of it lies {off[k]:.3g} m "
                         "beside the line from its first node to its last")
    if np.any(np.diff(x @ axis) <= 0.0):
        raise InputError(f"{name}: its nodes must follow each other along the edge")
