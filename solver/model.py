"""The model: a mesh with thickness, material, loads, supports and initial velocities.

Everything is a frozen dataclass of float64 arrays, entity axis first, checked when it is made.
SI units throughout.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from .element import (
    CORNERS,
    MEMBRANE_FIELDS,
    SHEAR_FIELDS,
    Elements,
    element_constants,
    jacobians,
    shape_functions,
)
from .errors import InputError

COMPONENTS = ("x", "y", "z", "px", "py", "pz")
"""What a support can fix: displacement components, and components of the normal."""

MIN_JACOBIAN = 1e-6
"""Smallest vertex Jacobian relative to the element's largest below which a quad is degenerate."""

COINCIDENT = 1e-9
"""Nodes closer than this fraction of the model's size are duplicates."""


@dataclass(frozen=True)
class TimeFunction:
    """Piecewise linear f(t) through the points (times, values); constant beyond both ends."""

    times: tuple
    values: tuple

    def __post_init__(self):
        times = tuple(float(t) for t in self.times)
        values = tuple(float(v) for v in self.values)
        if len(times) != len(values) or not times:
            raise InputError(f"time function: {len(times)} times but {len(values)} values")
        if not np.all(np.isfinite(times)) or not np.all(np.isfinite(values)):
            raise InputError("time function: times and values must be finite")
        if np.any(np.diff(times) <= 0.0):
            raise InputError(f"time function: times {times} must increase")
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "values", values)

    def __call__(self, time):
        return float(np.interp(time, self.times, self.values))

    @property
    def end(self):
        """Time from which the function is zero for good; infinity if it never is."""
        return self.times[-1] if self.values[-1] == 0.0 else np.inf


CONSTANT = TimeFunction((0.0,), (1.0,))


@dataclass(frozen=True)
class NodalLoad:
    """Dead force ``force * history(t)`` [N] at one node."""

    node: int
    force: tuple
    history: TimeFunction = CONSTANT


@dataclass(frozen=True)
class NodalMoment:
    """Moment ``moment * history(t)`` [N m] about fixed axes at one node.

    It turns the normal: ``f_n = A1^T (M x p)``.  Its part along the normal does nothing (there is
    no drilling stiffness).
    """

    node: int
    moment: tuple
    history: TimeFunction = CONSTANT


@dataclass(frozen=True)
class Pressure:
    """Follower pressure ``pressure * history(t)`` [Pa] along the current normal of some elements.

    ``elements`` None means all.
    """

    pressure: float
    elements: tuple = None
    history: TimeFunction = CONSTANT


@dataclass(frozen=True)
class Support:
    """Fixed or, in statics, prescribed components of some nodes.

    ``components`` is any of ``x y z`` (displacement) and ``px py pz`` (mid-surface normal).  An
    edge is clamped by ``("x", "y", "z", "px", "py", "pz")``, a symmetry plane x = const needs
    ``("x", "px")``.  Two fixed components of a unit normal fix the third: two or three are the
    same.  ``displacement * history(t)`` [m] is prescribed to the displacement components.
    """

    nodes: tuple
    components: tuple
    displacement: float = 0.0
    history: TimeFunction = CONSTANT


@dataclass(frozen=True)
class Model:
    """A shell with everything that acts on it.

    Attributes:
        nodes: (n_nodes, 3) initial coordinates [m].
        quads: (n_elem, 4) node numbers, counter-clockwise about the normal.
        thickness, youngs, poisson, density: h [m], E [Pa], nu, rho [kg/m^3]; numbers or (n_elem,).
        loads: :class:`NodalLoad` s, :class:`NodalMoment` s and :class:`Pressure` s; see
            :mod:`solver.loads` for line and surface loads.
        supports: :class:`Support` s; none for a free-flying shell.
        normals: (n_nodes, 3) initial unit normals; left out, the mean of the element normals at
            each node, Eqs. (13), (14).  On the rim and on symmetry planes of a curved shell that
            mean is one-sided: give the exact ones there.
        velocity: (n_nodes, 3) initial dx/dt [m/s].
        normal_velocity: (n_nodes, 3) initial dp/dt [1/s], tangential to the normals.
        membrane: assumed membrane field: ``stress`` (Pian-Sumihara), ``strain``, or
            ``compatible`` (none: locks; for comparison).
        shear: transverse shear field: ``mitc4`` or ``compatible`` (locks; for comparison).

    Raises:
        InputError: for anything that cannot be a shell, naming it.
    """

    nodes: np.ndarray
    quads: np.ndarray
    thickness: object
    youngs: object
    poisson: object
    density: object
    loads: tuple = ()
    supports: tuple = ()
    normals: np.ndarray = None
    velocity: np.ndarray = None
    normal_velocity: np.ndarray = None
    membrane: str = "stress"
    shear: str = "mitc4"
    name: str = field(default="model", compare=False)

    def __post_init__(self):
        nodes = _floats("nodes", self.nodes, (None, 3))
        quads = _node_numbers(self.quads, len(nodes))
        _set(self, nodes=nodes, quads=quads, loads=tuple(self.loads),
             supports=tuple(self.supports))
        _check_connectivity(quads)
        _check_nodes(nodes, quads)
        _check_shapes(nodes, quads)
        n_elem = len(quads)
        for name, unit in (("thickness", "m"), ("youngs", "Pa"), ("density", "kg/m^3")):
            values = _per_element(name, getattr(self, name), n_elem)
            _require(values > 0.0, values, f"{name} must be positive [{unit}]")
            _set(self, **{name: values})
        poisson = _per_element("poisson", self.poisson, n_elem)
        _require((poisson > -1.0) & (poisson < 0.5), poisson, "poisson must lie in (-1, 0.5)")
        _set(self, poisson=poisson)
        _set(self, normals=self._given_normals())
        for name in ("velocity", "normal_velocity"):
            given = getattr(self, name)
            values = np.zeros_like(nodes) if given is None else _floats(name, given, nodes.shape)
            _set(self, **{name: values})
        _choice("membrane", self.membrane, MEMBRANE_FIELDS)
        _choice("shear", self.shear, SHEAR_FIELDS)
        self._check_loads()
        self._check_supports()
        tilt = np.abs(np.einsum("ij,ij->i", self.normal_velocity, self.normals))
        if np.any(tilt > 1e-9 * (1.0 + np.abs(self.normal_velocity).max())):
            raise InputError(f"normal_velocity of node {int(np.argmax(tilt))} is not tangential "
                             "to its normal")

    def _given_normals(self):
        """The normals given, checked, or the mean of the element normals, Eqs. (13), (14)."""
        mean = self._mean_normals()
        if self.normals is None:
            return mean
        normals = _floats("normals", self.normals, self.nodes.shape)
        length = np.linalg.norm(normals, axis=1)
        if np.any(np.abs(length - 1.0) > 1e-9):
            k = int(np.argmax(np.abs(length - 1.0)))
            raise InputError(f"normals[{k}] has length {length[k]:g}, must be 1")
        aligned = np.einsum("ij,ij->i", normals, mean)
        if np.any(aligned < 0.5):
            k = int(np.argmin(aligned))
            raise InputError(f"normals[{k}] is more than 60 degrees from the mean normal of its "
                             "elements")
        return normals / length[:, None]

    def _mean_normals(self):
        corners = self.nodes[self.quads]
        total = np.zeros_like(self.nodes)
        for i, corner in enumerate(CORNERS):
            _, natural = shape_functions(corner)
            d_xi, d_eta = np.einsum("ai,eic->aec", natural, corners)
            normal = np.cross(d_xi, d_eta)
            np.add.at(total, self.quads[:, i],
                      normal / np.linalg.norm(normal, axis=1, keepdims=True))
        length = np.linalg.norm(total, axis=1)
        if np.any(length < 1e-6):
            raise InputError(f"node {int(np.argmin(length))}: the normals of its elements cancel")
        return total / length[:, None]

    @cached_property
    def elements(self):
        """Constants of all elements, :class:`solver.element.Elements`."""
        constants = element_constants(
            self.nodes[self.quads], self.normals[self.quads], self.thickness, self.youngs,
            self.poisson, self.density, membrane=self.membrane, shear=self.shear)
        return Elements(nodes=self.quads, directors=self.quads, **constants)

    @property
    def fixed(self):
        """(n_nodes, 6) True where a support fixes a component of ``COMPONENTS``."""
        mask = np.zeros((len(self.nodes), 6), dtype=bool)
        for support in self.supports:
            columns = [COMPONENTS.index(component) for component in support.components]
            mask[np.ix_(list(support.nodes), columns)] = True
        return mask

    @property
    def unloaded_at(self):
        """Time from which no load acts any more [s]; infinity if some load never ends."""
        return max((load.history.end for load in self.loads), default=0.0)

    @property
    def size(self):
        """Largest extent of the initial mesh [m]."""
        return float(np.ptp(self.nodes, axis=0).max())

    def _check_loads(self):
        for k, load in enumerate(self.loads):
            if isinstance(load, Pressure):
                self._check_pressure(k, load)
                continue
            if not 0 <= load.node < len(self.nodes):
                raise InputError(f"load {k}: node {load.node} does not exist "
                                 f"(0 to {len(self.nodes) - 1})")
            name, unit = ("moment", "N m") if isinstance(load, NodalMoment) else ("force", "N")
            if not _is_finite_vector(getattr(load, name)):
                raise InputError(f"load {k} at node {load.node}: {name} {getattr(load, name)} must "
                                 f"be three finite numbers [{unit}]")

    def _check_pressure(self, k, load):
        if not np.isfinite(load.pressure):
            raise InputError(f"load {k}: pressure {load.pressure} must be finite [Pa]")
        for element in load.elements or ():
            if not 0 <= element < len(self.quads):
                raise InputError(f"load {k}: element {element} does not exist "
                                 f"(0 to {len(self.quads) - 1})")

    def _check_supports(self):
        for k, support in enumerate(self.supports):
            for node in support.nodes:
                if not 0 <= node < len(self.nodes):
                    raise InputError(f"support {k}: node {node} does not exist "
                                     f"(0 to {len(self.nodes) - 1})")
            for component in support.components:
                _choice(f"support {k}: component", component, COMPONENTS)
            if not np.isfinite(support.displacement):
                raise InputError(f"support {k}: displacement {support.displacement} must be finite "
                                 "[m]")
            if support.displacement != 0.0 and not set(support.components) <= set("xyz"):
                raise InputError(f"support {k}: a displacement can be prescribed to x, y and z "
                                 f"only, not to {', '.join(support.components)}")


def rigid_velocity(model, velocity, omega, about=(0.0, 0.0, 0.0)):
    """Initial velocities of a rigid motion: ``(dx/dt, dp/dt)`` for :class:`Model`.

    ``dx/dt = v + omega x (X - about)``, ``dp/dt = omega x p``; v [m/s], omega [rad/s].
    """
    omega = np.asarray(omega, dtype=float)
    arms = model.nodes - np.asarray(about, dtype=float)
    return np.asarray(velocity, dtype=float) + np.cross(omega, arms), np.cross(omega, model.normals)


def _set(model, **values):
    for name, value in values.items():
        object.__setattr__(model, name, value)


def _floats(name, values, shape):
    try:
        array = np.array(values, dtype=np.float64, order="C")
    except (TypeError, ValueError):
        raise InputError(f"{name}: not an array of numbers") from None
    wanted = tuple(size if want is None else want for want, size in zip(shape, array.shape))
    if array.ndim != len(shape) or array.shape != wanted or not array.size:
        needed = ", ".join("n" if size is None else str(size) for size in shape)
        raise InputError(f"{name}: shape {array.shape} given, ({needed}) needed")
    bad = np.argwhere(~np.isfinite(array))
    if len(bad):
        where = ", ".join(str(int(i)) for i in bad[0])
        raise InputError(f"{name}[{where}] is {array[tuple(bad[0])]}, must be finite")
    return array


def _is_finite_vector(values):
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        return False
    return array.shape == (3,) and bool(np.all(np.isfinite(array)))


def _per_element(name, values, n_elem):
    array = np.asarray(values)
    if array.ndim == 0:
        array = np.full(n_elem, values)
    return _floats(name, array, (n_elem,))


def _require(good, values, message):
    if not np.all(good):
        k = int(np.argmin(good))
        raise InputError(f"{message}, is {values[k]:g} at element {k}")


def _choice(name, value, choices):
    if value not in choices:
        raise InputError(f"{name} '{value}' is unknown, must be one of: {', '.join(choices)}")


def _node_numbers(quads, n_nodes):
    array = np.asarray(quads)
    if array.ndim != 2 or array.shape[1] != 4 or not len(array):
        raise InputError(f"quads: shape {array.shape} given, (n, 4) needed")
    if not np.issubdtype(array.dtype, np.integer):
        raise InputError(f"quads: node numbers must be integers, not {array.dtype}")
    array = np.ascontiguousarray(array, dtype=np.int64)
    bad = np.argwhere((array < 0) | (array >= n_nodes))
    if len(bad):
        element, vertex = bad[0]
        raise InputError(f"element {element}: node {array[element, vertex]} does not exist "
                         f"(0 to {n_nodes - 1})")
    return array


def _check_nodes(nodes, quads):
    """No free-floating node, no two nodes at one place."""
    used = np.zeros(len(nodes), dtype=bool)
    used[quads] = True
    if not np.all(used):
        raise InputError(f"node {int(np.argmin(used))} belongs to no element")
    size = np.ptp(nodes, axis=0).max()
    pairs = cKDTree(nodes).query_pairs(COINCIDENT * size, output_type="ndarray")
    if len(pairs):
        first, second = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))[0]]
        raise InputError(f"nodes {first} and {second} are at the same place "
                         f"{nodes[first].tolist()}")


def _check_connectivity(quads):
    """No repeated node or element; neighbours have one orientation."""
    for k, quad in enumerate(quads):
        if len(set(quad.tolist())) < 4:
            raise InputError(f"element {k}: nodes {quad.tolist()} repeat, a quad needs four")
    ordered = np.sort(quads, axis=1)
    _, first, inverse = np.unique(ordered, axis=0, return_index=True, return_inverse=True)
    duplicate = np.flatnonzero(first[inverse.ravel()] != np.arange(len(quads)))
    if len(duplicate):
        k = int(duplicate[0])
        raise InputError(f"element {k} duplicates element {int(first[inverse.ravel()[k]])}: nodes "
                         f"{quads[k].tolist()}")
    _check_orientation(quads)


def _check_shapes(nodes, quads):
    """No degenerate, inverted or non-convex element."""
    corners = nodes[quads]
    diagonals = np.stack([corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]], axis=1)
    lengths = np.linalg.norm(diagonals, axis=2)
    area = np.linalg.norm(np.cross(diagonals[:, 0], diagonals[:, 1]), axis=1)
    flat = area <= MIN_JACOBIAN * lengths.max(axis=1) ** 2
    if np.any(flat):
        k = int(np.argmax(flat))
        raise InputError(f"element {k}: degenerate or twisted, the diagonals of its nodes "
                         f"{quads[k].tolist()} are parallel")
    determinants = jacobians(corners)
    bad = determinants.min(axis=1) <= MIN_JACOBIAN * determinants.max(axis=1)
    if np.any(bad):
        k = int(np.argmax(bad))
        vertex = int(np.argmin(determinants[k]))
        raise InputError(f"element {k}: degenerate, inverted or not convex at its node "
                         f"{quads[k, vertex]} (nodes {quads[k].tolist()})")


def _check_orientation(quads):
    """Two elements must run through a shared edge in opposite directions."""
    edges = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
    _, first, counts = np.unique(edges, axis=0, return_index=True, return_counts=True)
    if np.any(counts > 1):
        edge = edges[first[np.argmax(counts > 1)]]
        owners = np.flatnonzero((edges == edge).all(axis=1)) // 4
        raise InputError(f"element {owners[1]} is inverted against its neighbour {owners[0]}: both "
                         f"run from node {edge[0]} to node {edge[1]}")
