"""What acts on a shell: nodal loads, pressure, gravity, supports; line and surface loads.

Everything is plain data (ints, floats, tuples), checked when made; what depends on a mesh is
checked by ``Model``.
"""

from dataclasses import dataclass

import numpy as np

from ..checks import (
    choice,
    distinct,
    existing,
    floats,
    integer,
    integers,
    number,
    shown,
    vector,
)
from ..errors import InputError
from ..fields import put
from .constants import GAUSS, area_factors, shape_functions
from .histories import CONSTANT, FunctionOfTime
from .mesh import check_connectivity, few_enough, node_numbers, not_joined, passed

COMPONENTS = ("x", "y", "z", "px", "py", "pz")
"""What a support can fix: displacement components, and components of the normal."""

RIGHT_ANGLE = 1e-6
"""Largest cosine of the angle between two axes of a support."""


@dataclass(frozen=True)
class NodalLoad:
    """Dead force ``force * history(t)`` [N] at one node."""

    node: int
    force: tuple
    history: FunctionOfTime = CONSTANT

    def __post_init__(self):
        put(self, node=integer("load: node", self.node), history=history_of(self.history))
        put(self, force=vector(f"load at node {self.node}: force", self.force, "N"))


@dataclass(frozen=True)
class NodalMoment:
    """Moment ``moment * history(t)`` [N m] about fixed axes at one node.

    It turns the normal: ``f_n = A1^T (M x p)``.  A smooth node has no rotation about its normal:
    the part of M along it is carried by a couple of forces on each element around the node, which
    has exactly this moment (``kernels.couples``).  At a clamped node a moment does nothing.
    """

    node: int
    moment: tuple
    history: FunctionOfTime = CONSTANT

    def __post_init__(self):
        put(self, node=integer("load: node", self.node), history=history_of(self.history))
        put(self, moment=vector(f"load at node {self.node}: moment", self.moment, "N m"))


@dataclass(frozen=True)
class Pressure:
    """Follower pressure ``pressure * history(t)`` [Pa] along the current normal of some elements.

    ``elements`` None means all.
    """

    pressure: float
    elements: tuple = None
    history: FunctionOfTime = CONSTANT

    def __post_init__(self):
        put(self, pressure=number("pressure", self.pressure, "Pa"),
            history=history_of(self.history))
        if self.elements is not None:
            put(self, elements=distinct("pressure: elements", self.elements))


@dataclass(frozen=True)
class Gravity:
    """Weight: the acceleration ``acceleration * history(t)`` [m/s^2] of everything that has mass.

    Its forces are those of the consistent mass, ``f_i = sum_j m_ij g``: a free shell falls rigidly.
    """

    acceleration: tuple
    history: FunctionOfTime = CONSTANT

    def __post_init__(self):
        put(self, history=history_of(self.history), acceleration=vector(
            "gravity: acceleration", self.acceleration, "m/s^2"))


@dataclass(frozen=True)
class Centrifugal:
    """Centrifugal forces of a frame that turns at ``omega`` [rad/s] about the point ``about`` [m].

    ``f = omega x (x x omega)`` times the mass, rotary inertia of the directors included; they
    follow the shell.  ``history`` multiplies the forces, so a load factor of 1/4 is half the
    speed.  Statics finds the equilibrium in that frame, ``modes`` the vibrations about it.
    Reaction moments leave out its couples on held normals, of the order h^2/12.
    """

    omega: tuple
    about: tuple = (0.0, 0.0, 0.0)
    history: FunctionOfTime = CONSTANT

    def __post_init__(self):
        put(self, history=history_of(self.history),
            omega=vector("centrifugal: omega", self.omega, "rad/s"),
            about=vector("centrifugal: about", self.about, "m"))


@dataclass(frozen=True)
class Support:
    """Fixed or prescribed components of some nodes.

    ``components`` is any of ``x y z`` (displacement) and ``px py pz`` (mid-surface normal).  An
    edge is clamped by ``("x", "y", "z", "px", "py", "pz")``, a symmetry plane x = const needs
    ``("x", "px")``.  Two fixed components of a unit normal fix the third: two or three are the
    same.  A junction with one fixed component turns about that axis only, so that a symmetry plane
    may cut folds.  ``displacement * history(t)`` [m] is prescribed to the displacement components.

    Components are those along the rows of ``axes`` (3, 3), orthogonal and of any length; along the
    global axes without it.
    """

    nodes: tuple
    components: tuple
    displacement: float = 0.0
    history: FunctionOfTime = CONSTANT
    axes: tuple = None

    def __post_init__(self):
        given = self.components
        given = given if isinstance(given, str) or not np.iterable(given) else tuple(given)
        if not isinstance(given, tuple) or not given:
            raise InputError(f"support: components must be a list of {', '.join(COMPONENTS)}, is "
                             f"{shown(given)}")
        components = tuple(choice("support: component", c, COMPONENTS) for c in given)
        put(self, nodes=distinct("support: nodes", self.nodes), components=components,
            displacement=number("support: displacement", self.displacement, "m"),
            history=history_of(self.history),
            axes=axes_of("support: axes", self.axes))
        if self.displacement != 0.0 and not set(components) <= set("xyz"):
            raise InputError("support: a displacement can be prescribed to x, y and z only, not "
                             f"to {', '.join(components)}")

    @property
    def directions(self):
        """(3, 3) unit vectors that the components are along, in rows."""
        return np.eye(3) if self.axes is None else np.array(self.axes)


def symmetry_plane(nodes, normal):
    """``Support`` of nodes on a symmetry plane with this ``normal`` (3,), of any length.

    Their displacements stay in the plane, as do the normals of the shell, ``p . n = const``.

    Raises:
        InputError: as of ``Support``.
    """
    n = np.array(vector("symmetry plane: normal", normal))
    if not np.any(n):
        raise InputError("symmetry plane: normal must not be zero")
    other = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
    return Support(nodes, ("x", "px"), axes=(n, other, np.cross(n, other)))


@dataclass(frozen=True)
class Drive:
    """Clamped nodes that move as a rigid body, given as a function of time.

    ``x = about + R (X - about) + translation h(t)``, ``p = R p_0`` with the rotation R by
    ``rotation g(t)`` [rad], a vector along its axis; h is ``history``, g ``turning``, which is
    ``history`` where it is left out.  In a motion both are zero at its start.
    """

    nodes: tuple
    translation: tuple = (0.0, 0.0, 0.0)
    rotation: tuple = (0.0, 0.0, 0.0)
    about: tuple = (0.0, 0.0, 0.0)
    history: FunctionOfTime = CONSTANT
    turning: FunctionOfTime = None

    def __post_init__(self):
        put(self, nodes=distinct("drive: nodes", self.nodes), history=history_of(self.history))
        put(self, turning=history_of(self.history if self.turning is None else self.turning))
        for name, unit in (("translation", "m"), ("rotation", "rad"), ("about", "m")):
            put(self, **{name: vector(f"drive: {name}", getattr(self, name), unit)})

    @property
    def components(self):
        """All, as of a clamped edge."""
        return COMPONENTS

    @property
    def directions(self):
        """(3, 3) unit vectors that the components are along, in rows: the global axes."""
        return np.eye(3)


def line_load(nodes, line, force, history=CONSTANT, quads=None):
    """Dead force per length [N/m] along the element edges between consecutive nodes of ``line``.

    ``f_i = q int N_i dL`` with the linear shape functions of an edge: half of q L to either end.

    Args:
        nodes: (n_nodes, 3) of the mesh [m].
        line: numbers of nodes, one after the other.
        force: per length [N/m].
        history: ``FunctionOfTime``.
        quads: (n_elem, 4) of the mesh; given, the line must run along its edges.

    Raises:
        InputError: ``line`` is not a sequence of nodes, passes over one, or leaves the edges of
            ``quads``; the force is not a vector.
    """
    force = np.array(vector("line load: force", force, "N/m"))
    return [NodalLoad(i, share * force, history)
            for i, share in _line_shares("line load", nodes, line, quads).items()]


def line_moment(nodes, line, moment, history=CONSTANT, quads=None):
    """Moment per length [N m/m] about fixed axes along the edges of ``line``; as ``line_load``."""
    moment = np.array(vector("line moment: moment", moment, "N m/m"))
    return [NodalMoment(i, share * moment, history)
            for i, share in _line_shares("line moment", nodes, line, quads).items()]


def surface_load(nodes, quads, force, history=CONSTANT):
    """Dead force per initial area [N/m^2] on the elements ``quads``: ``f_i = q int N_i dA``.

    Raises:
        InputError: ``quads`` are not elements on ``nodes``, or the force is not a vector.
    """
    nodes = floats("surface load: nodes", nodes, (None, 3))
    force = np.array(vector("surface load: force", force, "N/m^2"))
    return [NodalLoad(i, share * force, history)
            for i, share in shares_of_area(nodes, quads)]


def shares_of_area(nodes, quads):
    """(node, its share ``int N_i dA`` [m^2]) of elements ``quads`` on ``nodes``."""
    quads = node_numbers(quads, len(nodes))
    few_enough(len(quads))
    check_connectivity(quads)
    shares = np.zeros(len(nodes))
    for point in GAUSS:
        shape, _ = shape_functions(point)
        area = area_factors(nodes[quads], point)
        for i in range(4):
            np.add.at(shares, quads[:, i], shape[i] * area)
    loaded = np.unique(quads)
    return list(zip(loaded.tolist(), shares[loaded].tolist()))


def axes_of(name, axes):
    """Rows of orthogonal axes, as unit vectors; None for the global ones."""
    if axes is None:
        return None
    rows = floats(name, axes, (3, 3))
    lengths = np.linalg.norm(rows, axis=1, keepdims=True)
    unit = rows / np.where(lengths > 0.0, lengths, 1.0)
    off = np.abs(unit @ unit.T - np.eye(3)).max()
    if off > RIGHT_ANGLE:
        raise InputError(f"{name} must be three orthogonal vectors, are off by {off:.2g}")
    if np.array_equal(unit, np.eye(3)):
        return None
    left, _, right = np.linalg.svd(unit)  # orthogonal to rounding: the nearest that are
    return tuple(map(tuple, (left @ right).tolist()))


def history_of(history, name="history"):
    """A ``FunctionOfTime``."""
    if not isinstance(history, FunctionOfTime):
        raise InputError(f"{name} must be a TimeFunction, Steps, Harmonic or Expression, is "
                         f"{shown(history)}")
    return history


def _line_shares(what, nodes, line, quads):
    """Length that belongs to each node of a polyline of element edges [m]."""
    nodes = floats(f"{what}: nodes", nodes, (None, 3))
    line = existing(f"{what}: node", integers(f"{what}: line", line), len(nodes))
    if len(line) < 2:
        raise InputError(f"{what}: line must have two nodes or more, has {len(line)}")
    lack = None if quads is None else not_joined(node_numbers(quads, len(nodes)), line)
    if lack is not None and lack[0] != lack[1]:
        raise InputError(f"{what}: no element edge joins nodes {lack[0]} and {lack[1]}")
    shares = dict.fromkeys(line, 0.0)
    for i, j in zip(line[:-1], line[1:]):
        if i == j:
            raise InputError(f"{what}: node {i} follows itself in the line")
        length = np.linalg.norm(nodes[j] - nodes[i])
        between = passed(nodes, i, j)
        if len(between):
            raise InputError(f"{what}: node {between[0]} is between nodes {i} and {j}, which no "
                             "element edge joins then")
        shares[i] += 0.5 * length
        shares[j] += 0.5 * length
    return shares
