"""The model: a mesh with thickness, material, loads, supports and initial velocities.

A frozen dataclass of read-only float64 arrays, entity axis first, checked when it is made.
SI units throughout.
"""

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product

import numpy as np

from ..checks import (
    TINY,
    choice,
    existing,
    floats,
    instance,
    integers,
    number,
    plain_array,
    shown,
    single,
)
from ..errors import InputError
from ..fields import put
from ..kernels.arguments import Elements
from ..kernels.lanes import zeros
from ..names import listed
from ..signatures import Vector, checked
from .attached import (
    ATTACHED,
    Damping,
    GroundSpring,
    PointMass,
    add_masses,
    check_attached,
)
from .bodies import GROUND, RigidBody, check_bodies, with_bodies
from .constants import (
    MEMBRANE_FIELDS,
    SHEAR_FIELDS,
    element_constants,
    recovery,
    side_by_side,
)
from .cyclic import Cyclic, Pairs, find_pairs
from .directors import (
    FOLD_ANGLE,
    LEAST_SPREAD,
    Directors,
    find_directors,
    find_folds,
    vertex_normals,
)
from .inertia import mass_properties
from .joints import (
    JOINTS,
    Turning,
    check_axes,
    check_joints,
    check_velocities,
    classes_of,
    names_of,
    supports_of,
)
from .laminates import Section, directions_of, law_of, members_of
from .linkages import LINKED, RigidLink, Tie, check_linked
from .loads import (
    COMPONENTS,
    Centrifugal,
    Drive,
    Gravity,
    NodalLoad,
    NodalMoment,
    Pressure,
    Support,
)
from .mechanism import mechanism, plural
from .mesh import check_mesh, node_numbers
from .meshes import Mesh
from .nonconservative import Drag, FollowerForce, UserForce

LOADS = (NodalLoad, NodalMoment, Pressure, Gravity, Centrifugal, FollowerForce, Drag, UserForce)

ALIKE = 1e-9
"""Differences of unit vectors that are none."""

STEEPEST_COMPONENT = 0.75
"""Largest square of a single normal component that a support may hold: beyond, what is left of the
normal is too short to be a dependent component wherever it turns."""


@dataclass(frozen=True, eq=False)
class Model:
    """A shell with everything that acts on it.

    Attributes:
        nodes: (n_nodes, 3) initial coordinates [m].
        quads: (n_elem, 4) node numbers, counter-clockwise about the normal.
        thickness: h [m], a number or (n_elem,).  It and the material may be left out where
            ``sections`` have all elements; elements of a section get those of its laminate, E as a
            scale only: the largest A_ii/h, with nu = 0.
        youngs: Young's modulus E [Pa], a number or (n_elem,).
        poisson: Poisson's ratio nu, a number or (n_elem,).
        density: rho [kg/m^3], a number or (n_elem,).
        loads: ``NodalLoad`` s, ``NodalMoment`` s, ``Pressure`` s, ``Gravity``, ``Centrifugal``,
            ``FollowerForce`` s, ``Drag`` and ``UserForce`` s; see ``model.loads`` for line and
            surface loads.
        supports: ``Support`` s and ``Drive`` s; none for a free-flying shell.
        attached: ``PointMass`` es, ``Spring`` s and ``GroundSpring`` s.
        joints: ``Hinge`` s and ``Spherical`` joints of plates that have nodes of their own there,
            and joints with multipliers between bodies, nodes and the ground, see
            ``model.linkages``.
            What a support holds of a joined node it holds of those that move with it: ``supports``
            has that too.
        damping: ``Damping``; None for none.
        sections: ``Section`` s, laminates instead of one material; they take ``membrane="stress"``.
        bodies: ``RigidBody`` s; their centres are the last of ``nodes``.
        cyclic: ``Cyclic``, if the shell is one sector of many; None for a whole one.
        normals: (n_directors, 3) initial unit normals, or (n_elem, 4, 3) those of every element
            at its vertices, of which a director has the mean; left out, the mean of the element
            normals at each node, Eqs. (13), (14).  On the rim and on symmetry planes of a curved
            shell that mean is one-sided: give the exact ones there.  A smooth shell has one
            director a node; a junction has one for each plate that meets there, in the order of
            ``directors``.
        velocity: (n_nodes, 3) initial dx/dt [m/s].
        normal_velocity: (n_directors, 3) initial dp/dt [1/s], tangential to the normals.
        membrane: assumed membrane field: ``stress`` (Pian-Sumihara), ``strain``, or
            ``compatible`` (none: locks; for comparison).
        shear: transverse shear field: ``mitc4`` or ``compatible`` (locks; for comparison).
        fold_angle: neighbours whose normals differ by this angle [degrees] or more belong to
            different plates, which meet at a junction.
        patches: (n_elem,) numbers of the plates, instead of finding them by the angle.
        directors: ``Directors``, found when the model is made.
        pairs: ``Pairs`` of nodes on the edges of a sector; None of a whole shell.

    Raises:
        InputError: for anything that cannot be a shell, naming it.
    """

    nodes: np.ndarray
    quads: np.ndarray
    thickness: object = None
    youngs: object = None
    poisson: object = None
    density: object = None
    loads: tuple = ()
    supports: tuple = ()
    normals: np.ndarray = None
    velocity: np.ndarray = None
    normal_velocity: np.ndarray = None
    membrane: str = "stress"
    shear: str = "mitc4"
    fold_angle: float = FOLD_ANGLE
    patches: np.ndarray = None
    attached: tuple = ()
    damping: Damping = None
    sections: tuple = ()
    cyclic: Cyclic = None
    joints: tuple = ()
    bodies: tuple = ()
    directors: Directors = field(init=False)
    pairs: Pairs | None = field(init=False, default=None)

    def __post_init__(self):
        nodes = floats("nodes", self.nodes, (None, 3))
        quads = node_numbers(self.quads, len(nodes))
        put(self, nodes=nodes, quads=quads, joints=_items("joints", self.joints, JOINTS + LINKED),
            bodies=_items("bodies", self.bodies, (RigidBody,)))
        check_joints(self.joints, nodes, quads)
        check_bodies(self.bodies, nodes, quads)
        for name, joint in zip(names_of(self.joints), self.joints):
            if isinstance(joint, LINKED):
                check_linked(name, joint, nodes, [body.name for body in self.bodies], self.joined)
        tied = [[*joint.nodes, *joint.line] for joint in self.joints if isinstance(joint, Tie)]
        linked = [node for body in self.bodies for node in body.nodes]
        linked += [end for joint in self.joints if isinstance(joint, LINKED)
                   for end in joint.ends if not isinstance(end, str)]
        check_mesh(nodes, quads, self.joined + tied, len(self.bodies), linked)
        put(self, sections=_items("sections", self.sections, (Section,)))
        for name, unit in (("thickness", "m"), ("youngs", "Pa"), ("density", "kg/m^3")):
            values = self._property(name)
            _require(values >= TINY, values, f"{name} must be positive [{unit}], at least {TINY:g}")
            put(self, **{name: values})
        if self.cyclic is not None:
            instance("cyclic", self.cyclic, Cyclic)
        poisson = self._property("poisson")
        _require((poisson > -1.0) & (poisson < 0.5), poisson, "poisson must lie in (-1, 0.5)")
        put(self, poisson=poisson, directors=self._find_directors())
        put(self, normals=self.directors.normals)
        for name, shape in (("velocity", nodes.shape), ("normal_velocity", self.normals.shape)):
            given = getattr(self, name)
            values = floats(name, np.zeros(shape) if given is None else given, shape)
            put(self, **{name: values})
        choice("membrane", self.membrane, MEMBRANE_FIELDS)
        choice("shear", self.shear, SHEAR_FIELDS)
        if self.sections and self.membrane != "stress":
            raise InputError(f"sections take the membrane field stress, not {self.membrane}")
        put(self, loads=_items("loads", self.loads, LOADS),
            supports=self._supports(self.supports),
            attached=_items("attached", self.attached, ATTACHED))
        links = [joint.ends for joint in self.linked if isinstance(joint, RigidLink)]
        check_attached(self.attached, len(nodes), self.directors.first, [*self.joined, *links],
                       [(body.name, (*body.nodes, node))
                        for body, (node, _) in zip(self.bodies, self.body_masses)])
        check_axes(self.joints, nodes, self.directors)
        check_velocities(self.joints, self.velocity)
        if self.damping is not None:
            instance("damping", self.damping, Damping)
        if self.bodies:
            self._check_beside_bodies()
        self._check_loads()
        self._check_supports()
        self._check_normal_velocity()
        directions_of(self.sections, self.members, nodes[quads])
        if self.pairs:
            self._check_sector()

    @classmethod
    def of(cls, mesh, thickness=None, youngs=None, poisson=None, density=None, *, sections=(),
           **options):
        """A model of a ``Mesh``: its nodes, quads and exact normals.

        Args:
            mesh: ``Mesh``.
            thickness, youngs, poisson, density: as of ``Model``, or by groups of elements,
                ``{group: value}``.
            sections: as of ``Model``, or ``{group: Section}``.
            options: as of ``Model``.

        Raises:
            InputError: as of ``Model``, or of ``Mesh.per_element``.
        """
        instance("mesh", mesh, Mesh)
        values = (mesh.per_element(value) if isinstance(value, Mapping) else value
                  for value in (thickness, youngs, poisson, density))
        if isinstance(sections, Mapping):
            sections = [replace(instance(f"section of group {shown(group)}", section, Section),
                                elements=mesh.groups[group].tolist())
                        for group, section in sections.items()]
        bodies = _items("bodies", options.get("bodies", ()), (RigidBody,))
        nodes = np.concatenate([mesh.nodes, *([body.centre] for body in bodies)])
        return cls(nodes, mesh.quads, *values, sections=sections,
                   **{"normals": mesh.normals, **options})

    def _property(self, name):
        """A property (n_elem,), that of the laminate where there is a section."""
        given, n = getattr(self, name), len(self.quads)
        if given is not None and not self.sections:
            return _per_element(name, given, n)
        values = np.full(n, np.nan) if given is None else np.array(_per_element(name, given, n))
        for section, elements in zip(self.sections, self.members):
            values[elements] = getattr(section.laminate, name)
        missing = np.isnan(values)
        if missing.any():
            where = f": element {np.argmax(missing)} is in no section" if self.sections else ""
            raise InputError(f"{name} is missing{where}")
        return floats(name, values, (n,))

    def under(self, loads, supports, joints=None):
        """The same model under other loads and supports, with the directors and element constants
        of this one, and with ``joints`` that differ by their functions of time alone.

        Raises:
            InputError: as of ``Model``, for these.
        """
        made = copy(self)
        put(made, loads=_items("loads", loads, LOADS), elements=self.elements,
            supports=self._supports(supports),
            joints=self.joints if joints is None else tuple(joints))
        for cached in ("_held", "oblique", "kept"):
            vars(made).pop(cached, None)
        made._check_loads()
        made._check_supports()
        if made.pairs:
            made._check_sector()
        return made

    def _supports(self, given):
        """Supports, checked for their type and where they are, with those that joints imply."""
        supports = _items("supports", given, (Support, Drive))
        for k, support in enumerate(supports):
            existing(f"support {k}: node", support.nodes, len(self.nodes))
        return supports_of(supports, self.joined)

    @cached_property
    def joined(self):
        """Lists of nodes that move together."""
        return classes_of(self.joints, len(self.nodes))

    def __setstate__(self, state):
        """Arrays come writable out of a pickle: read-only again, which is also the type for which
        the kernels are compiled."""
        vars(self).update(state)
        for array in state.values():
            if isinstance(array, np.ndarray):
                array.setflags(write=False)

    def _find_directors(self):
        """Directors by Eqs. (13), (14), or with the normals given, checked."""
        fold_angle = number("fold_angle", self.fold_angle, "degrees")
        if not 0.0 < fold_angle <= 90.0:
            raise InputError(f"fold_angle must lie in (0, 90] [degrees], is {fold_angle:g}")
        if self.patches is not None:
            patches = np.array(integers("patches", self.patches))
            if len(patches) != len(self.quads):
                raise InputError(f"patches: {len(patches)} given, one an element "
                                 f"({len(self.quads)}) needed")
            put(self, patches=patches)
        found = find_directors(self.nodes, self.quads, fold_angle, self.patches)
        if self.cyclic:
            found = self._joined(found)
        found = with_bodies(found, self.bodies)
        mean = floats("normals", found.normals, found.normals.shape)
        if self.normals is None:
            return found._replace(normals=mean)
        normals = floats("normals", self._nodal(found), mean.shape)
        length = np.linalg.norm(normals, axis=1)
        if np.any(np.abs(length - 1.0) > 1e-9):
            k = int(np.argmax(np.abs(length - 1.0)))
            raise InputError(f"normals[{k}] has length {length[k]:g}, must be 1")
        _check_aligned(np.einsum("ij,ij->i", normals, mean))
        for i in np.flatnonzero(np.diff(found.first) > 1):
            one, two = normals[found.first[i]:found.first[i] + 2]
            if np.linalg.norm(np.cross(one, two)) < LEAST_SPREAD:
                raise InputError(f"normals: the plates that meet at node {i} are given the same")
        if self.pairs:
            normals = self.pairs.summed(normals, self.pairs.directors)
            length = np.linalg.norm(normals, axis=1)
        return found._replace(normals=floats("normals", normals / length[:, None], normals.shape))

    def _joined(self, found):
        """The directors ``found`` of a sector, with its neighbours' elements in the means."""
        put(self, pairs=find_pairs(self.cyclic, self.nodes, self.quads, found, self.fold_angle))
        total = np.zeros(found.normals.shape)
        np.add.at(total, found.vertices, vertex_normals(self.nodes, self.quads))
        total = self.pairs.summed(total, self.pairs.directors)
        return found._replace(normals=total / np.linalg.norm(total, axis=1, keepdims=True))

    def _nodal(self, found):
        """The normals given, those at vertices as means at the directors ``found``."""
        if np.ndim(plain_array("normals", self.normals, "n, 3")) != 3:
            return self.normals
        given = floats("normals", self.normals, (len(self.quads), 4, 3))
        total = np.zeros(found.normals.shape)
        np.add.at(total, found.vertices, given)
        if self.bodies:
            total[-3 * len(self.bodies):] = found.normals[-3 * len(self.bodies):]
        length = np.linalg.norm(total, axis=1, keepdims=True)
        return total / np.where(length > 0.0, length, 1.0)

    def _check_normal_velocity(self):
        """dp/dt is tangential, and at a junction that of a rigid motion of all its directors."""
        p, p_dot = self.normals, self.normal_velocity
        small = 1e-9 * (1.0 + np.abs(p_dot).max())
        tilt = np.abs(np.einsum("ij,ij->i", p_dot, p))
        first = self.directors.first
        if np.any(tilt > small):
            node = np.searchsorted(first, np.argmax(tilt), side="right") - 1
            raise InputError(f"normal_velocity of node {node} is not tangential to its normal")
        for i in np.flatnonzero(np.diff(first) > 1):
            members = slice(first[i], first[i + 1])
            # the angles between its directors do not change
            change = p[members] @ p_dot[members].T
            if np.abs(change + change.T).max() > small:
                raise InputError(f"normal_velocity of node {i}: the plates of a junction turn "
                                 "together")

    @cached_property
    def elements(self):
        """Constants of all elements, ``Elements``."""
        return self._elements(self.law)

    def partly_heated(self, part):
        """``Elements`` with a ``part`` of the changes of temperature."""
        return self._elements(self._law([section.times(part) for section in self.sections]))

    def _elements(self, law):
        """``Elements`` of a ``Law``."""
        constants = element_constants(
            self.nodes[self.quads], self.normals[self.directors.vertices], law, self.density,
            membrane=self.membrane, shear=self.shear)
        masses = constants["mass"], constants["rotary"]
        add_masses(self.quads, self.attached, *masses)
        constants["inertia"] = np.stack(masses, axis=1)
        for name in constants.keys() - {"mass", "rotary", "eccentric"}:
            constants[name] = side_by_side(constants[name])
        constants.setdefault("eccentric", np.zeros((0, 4, 4)))
        if "coupling" not in constants:
            constants["coupling"] = zeros((0, constants["l"].shape[1], 8))
        return Elements(nodes=self.quads, directors=self.directors.vertices, **constants)

    @cached_property
    def recovery(self):
        """Operators of the stress resultants at the centres of all elements, ``Recovery``."""
        return recovery(self.nodes[self.quads], self.law, membrane=self.membrane, shear=self.shear)

    @cached_property
    def law(self):
        """Elasticity of all elements, ``constants.Law``."""
        return self._law(self.sections)

    def _law(self, sections):
        """``Law`` of all elements with these sections."""
        return law_of(self.thickness, self.youngs, self.poisson, self.nodes[self.quads], sections,
                      self.members)

    @cached_property
    def members(self):
        """Numbers (n,) of the elements of each section."""
        return members_of(self.sections, len(self.quads))

    @property
    def heated(self):
        """Whether a section has a change of temperature, so that the initial shape has stress."""
        return self.law.strain is not None

    @cached_property
    def mass_properties(self):
        """``MassProperties`` of the initial shell."""
        return mass_properties(self.elements, self.nodes, self.normals, self.bodies)

    @property
    def mass(self):
        """Mass [kg]."""
        return self.mass_properties.mass

    @property
    def centre(self):
        """(3,) centre of mass [m]."""
        return self.mass_properties.centre

    @property
    def inertia(self):
        """(3, 3) inertia about the centre of mass, rotary inertia included [kg m^2]."""
        return self.mass_properties.inertia

    @property
    def nodal_mass(self):
        """(n_nodes,) lumped masses [kg]: the sums of the rows of the consistent mass."""
        mass = np.zeros(len(self.nodes))
        np.add.at(mass, self.quads, self.elements.mass.sum(axis=2))
        for node, own in self.body_masses:
            mass[node] += own
        return mass

    @property
    def body_masses(self):
        """``(node, mass)`` [kg] of every rigid body."""
        first = len(self.nodes) - len(self.bodies)
        return [(first + k, body.mass) for k, body in enumerate(self.bodies)]

    @property
    def fixed(self):
        """(n_nodes, 6) True where a support fixes a component of ``COMPONENTS``."""
        mask = np.zeros((len(self.nodes), 6), dtype=bool)
        for support in self.supports:
            columns = [COMPONENTS.index(component) for component in support.components]
            mask[np.ix_(list(support.nodes), columns)] = True
        for node, (displacement, normal) in self._held.items():
            mask[node, :3] = _along_axes(displacement)
            mask[node, 3:] = _along_axes(normal) | (len(normal) > 1)
        return mask

    @cached_property
    def oblique(self):
        """``{node: (of its displacement (k, 3), of its normal (l, 3))}``: orthonormal directions
        that supports hold, where one has axes of its own and leaves something free, and of all
        nodes on the edges of a sector, where what is held on one edge is held on both."""
        edges = {*self.pairs.masters, *self.pairs.slaves} if self.pairs else ()
        return {node: held for node, held in self._held.items()
                if node in edges or len(held[0]) < 3 or len(held[1]) < 2}

    @cached_property
    def _held(self):
        """The same with the clamped nodes."""
        edges = [*self.pairs.masters, *self.pairs.slaves] if self.pairs else []
        nodes = {node for support in self.supports if not _global(support)
                 for node in support.nodes}.union(edges)
        rows = {node: ([], []) for node in nodes}
        for support in self.supports if nodes else ():
            for node, component in product(nodes.intersection(support.nodes), support.components):
                kind, k = divmod(COMPONENTS.index(component), 3)
                rows[node][kind].append(support.directions[k])
        for m, s in zip(self.pairs.masters, self.pairs.slaves) if self.pairs else ():
            R = self.pairs.rotation
            for kind in range(2):
                rows[m][kind].extend(row @ R for row in rows[s][kind])
                rows[s][kind][:] = [R @ row for row in rows[m][kind]]
        return {node: tuple(map(_basis, both)) for node, both in rows.items()}

    @cached_property
    def kept(self):
        """(n_nodes, 3) unit vector along which supports hold the normal, where this is one; zero
        elsewhere."""
        held = self.fixed[:, 3:]
        kept = np.where((held.sum(axis=1) == 1)[:, None], held, 0.0)
        for node, (_, normal) in self.oblique.items():
            kept[node] = normal[0] if len(normal) == 1 else 0.0
        return kept

    @property
    def grounded(self):
        """Whether supports, ground springs, joints to the ground or other sectors hold the shell,
        so that its momenta may change."""
        return bool(self.supports or self.cyclic) or any(
            isinstance(item, GroundSpring) for item in self.attached) or any(
            GROUND in joint.ends for joint in self.linked)

    @property
    def mechanism(self):
        """Its joints and bodies as plain values, see ``mechanism``."""
        return mechanism(self)

    @property
    def linked(self):
        """Joints that take multipliers."""
        return [joint for joint in self.joints if isinstance(joint, LINKED)]

    @property
    def unloaded_at(self):
        """Time from which no load acts any more and no motor, servo or drive of a joint moves it
        [s]; infinity if some never ends."""
        joints = [joint for joint in self.joints if isinstance(joint, Turning)]
        return max((*(load.history.end for load in self.loads),
                    *(joint.history.end for joint in joints if joint.torque),
                    *(joint.turning.settled for joint in joints
                      if joint.stiffness or joint.spring_angles),
                    *(joint.driving.settled for joint in joints if getattr(joint, "angle", None))),
                   default=0.0)

    @cached_property
    def folds(self):
        """How the edges between elements were decided, ``Folds``."""
        return find_folds(self.nodes, self.quads, self.fold_angle, self.patches)

    def __repr__(self):
        extent = " x ".join(f"{size:.4g}" for size in np.ptp(self.nodes, axis=0))
        counts = [(self.quads, "element"), (self.nodes, "node"), (self.loads, "load"),
                  (self.supports, "support"), *([(self.joints, "joint")] if self.joints else [])]
        told = ", ".join(plural(len(items), what) for items, what in counts)
        return f"Model({told}, {extent} m)"

    @property
    def size(self):
        """Largest extent of the initial mesh [m]."""
        return float(np.ptp(self.nodes, axis=0).max())

    def _check_loads(self):
        for k, load in enumerate(self.loads):
            if isinstance(load, Pressure | Drag):
                existing(f"load {k}: element", load.elements or (), len(self.quads))
            elif isinstance(load, Gravity | Centrifugal):
                for number, section in enumerate(self.sections):
                    if section.laminate.arm:
                        kind = type(load).__name__.lower()
                        raise InputError(f"load {k}: {kind} does not know the moment of sections["
                                         f"{number}], whose mass is centred "
                                         f"{section.laminate.arm:g} m above the nodes")
            elif isinstance(load, UserForce):
                load.check(self.nodes, self.velocity, self.normals)
            else:
                existing(f"load {k}: node", (load.node,), len(self.nodes))
                if isinstance(load, FollowerForce):
                    self._check_follower(k, load)

    def _check_follower(self, k, load):
        """A force along the normal of a smooth node, or a vector that turns with a junction."""
        plates = self.directors.first[load.node + 1] - self.directors.first[load.node]
        if load.along_normal and plates > 1:
            raise InputError(f"load {k}: node {load.node} has {plates} directors and no one normal "
                             "that a force could follow: give the force at the start, three "
                             "numbers")
        if not load.along_normal and plates == 1:
            raise InputError(f"load {k}: node {load.node} is smooth, it does not turn about its "
                             "normal: give a number, the force along the normal")

    def _check_beside_bodies(self):
        """What acts on elements alone is refused where bodies have a part of the mass."""
        if self.damping is not None and self.damping.mass > 0.0:
            raise InputError("damping: mass acts on the shell alone, a model with rigid bodies "
                             "takes stiffness")
        for k, load in enumerate(self.loads):
            if isinstance(load, Centrifugal):
                raise InputError(f"load {k}: centrifugal forces act on the shell alone, the model "
                                 "has rigid bodies")
        for k, item in enumerate(self.attached):
            if item.node >= len(self.nodes) - len(self.bodies) and isinstance(item, PointMass):
                raise InputError(f"attached[{k}]: node {item.node} is that of a rigid body: give "
                                 "the body this mass")

    def _check_supports(self):
        motions, axes = {}, {}
        for k, support in enumerate(self.supports):
            if isinstance(support, Drive):
                motion = replace(support, nodes=(0,))
            else:
                motion = (support.displacement, support.history) if support.displacement else None
            for node, component in product(support.nodes, support.components):
                first, other = motions.setdefault((node, component), (k, motion))
                if motion != other:
                    raise InputError(f"node {node}: supports {first} and {k} give {component} "
                                     "different displacements or histories")
        for (node, _), (k, motion) in motions.items():
            first, moves = axes.setdefault(node, (k, False))
            axes[node] = first, moves or motion is not None
        for k, support in enumerate(self.supports):
            for node in support.nodes:
                first, moves = axes[node]
                if moves and not np.array_equal(support.directions,
                                                self.supports[first].directions):
                    raise InputError(f"node {node}: supports {first} and {k} have different axes, "
                                     "so that no displacement can be prescribed there")
        first = self.directors.first
        along = np.einsum("ij,ij->i", self.normals[first[:-1]], self.kept)
        steep = (along**2 > STEEPEST_COMPONENT) & (np.diff(first) == 1)
        if np.any(steep):
            node = int(np.argmax(steep))
            axis = self.kept[node]
            c = np.argmax(axis)
            told, name = (("xyz"[c], COMPONENTS[3 + c]) if axis[c] == 1.0 else
                          (f"({axis[0]:.3g}, {axis[1]:.3g}, {axis[2]:.3g})", "this component"))
            raise InputError(f"node {node}: its normal is nearly along {told}, so that a support "
                             f"of {name} alone fixes it: support px, py, pz")

    def _check_sector(self):
        """Initial velocities, and supports that move, are those of a sector."""
        pairs, cyclic = self.pairs, self.cyclic
        edges = {*pairs.masters, *pairs.slaves}
        for group in self.joined:
            if edges.intersection(group):
                raise InputError(f"cyclic: node {min(edges.intersection(group))} on an edge of the "
                                 "sector is joined")
        for name, of in (("velocity", None), ("normal_velocity", pairs.directors)):
            if pairs.differ(getattr(self, name), of):
                raise InputError(f"cyclic: {name} differs on the two edges of the sector")
        for k, support in enumerate(self.supports):
            if isinstance(support, Drive):
                turns = any(support.rotation)
                vectors = [support.translation, support.rotation, turns * cyclic.arms(
                    [support.about])[0]]
                off = [np.abs(pairs.rotation @ v - v).max() for v in np.array(vectors)]
                if max(off) > 1e-9 * (1.0 + np.abs(vectors).max()):
                    raise InputError(f"cyclic: support {k} does not move along and about the axis")


@checked
def rigid_velocity(model: Model, velocity: Vector, omega: Vector,
                   about: Vector = (0.0, 0.0, 0.0)):
    """Initial velocities of a rigid motion: ``(dx/dt, dp/dt)`` for ``Model``.

    ``dx/dt = v + omega x (X - about)``, ``dp/dt = omega x p``.

    Args:
        model: ``Model``.
        velocity: v of the point ``about`` [m/s].
        omega: [rad/s].
        about: (x, y, z) [m].

    Returns:
        ``velocity`` (n_nodes, 3) [m/s] and ``normal_velocity`` (n_directors, 3) [1/s].

    Raises:
        InputError: no ``Model``, or not three numbers.
    """
    return velocity + np.cross(omega, model.nodes - about), np.cross(omega, model.normals)


def _global(support):
    """Whether the components of a support are along the global axes."""
    return np.array_equal(support.directions, np.eye(3))


def _basis(rows):
    """Orthonormal directions (k, 3) that span the same as unit vectors: the first where they are
    all alike."""
    if not rows:
        return np.zeros((0, 3))
    _, sizes, basis = np.linalg.svd(np.array(rows))
    rank = np.count_nonzero(sizes > ALIKE)
    return {1: np.array(rows[:1]), 2: basis[:2], 3: np.eye(3)}[rank]


def _along_axes(basis):
    """(3,) whether the global axes are among what a basis (k, 3) spans."""
    return np.sum(basis**2, axis=0) > 1.0 - ALIKE


def _per_element(name, values, n_elem):
    if single(values):
        values = np.full(n_elem, number(name, values))
    return floats(name, values, (n_elem,))


def _require(good, values, message):
    if not np.all(good):
        k = int(np.argmin(good))
        raise InputError(f"{message}, is {values[k]:g} at element {k}")


def _check_aligned(cosines):
    """Raise ``InputError`` for given normals that are far from those of the elements."""
    opposite, far = np.flatnonzero(cosines <= -0.5), np.flatnonzero(np.abs(cosines) < 0.5)
    told = []
    if len(opposite):
        told.append(f"normals {listed(opposite)} are opposite to the mean normals of their "
                    "elements: turn their sign, or all elements (quads[:, ::-1])")
    if len(far):
        told.append(f"normals {listed(far)} are more than 60 degrees from the mean normals of "
                    "their elements")
    if told:
        raise InputError("; ".join(told))


def _items(name, given, kinds):
    """A tuple of loads or supports, checked for their type."""
    if isinstance(given, kinds) or not np.iterable(given):
        raise InputError(f"{name} must be a list, is {shown(given)}")
    items = tuple(given)
    for k, item in enumerate(items):
        if not isinstance(item, kinds):
            known = ", ".join(kind.__name__ for kind in kinds)
            raise InputError(f"{name}[{k}] must be one of {known}, is {shown(item)}")
    return items
