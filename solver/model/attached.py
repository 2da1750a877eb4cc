"""What is attached to the nodes of a shell: point masses, springs, an elastic foundation."""

from dataclasses import dataclass, fields

import numpy as np

from ..checks import TINY, floats, integer, not_negative, positive, vector
from ..errors import InputError
from ..fields import put
from .loads import shares_of_area
from .tables import check_tables


@dataclass(frozen=True)
class PointMass:
    """A rigid mass [kg] at a node; ``inertia`` [kg m^2] about axes across the shell's normal.

    It adds ``1/2 m |v|^2 + 1/2 J |dp/dt|^2`` to the kinetic energy.  A smooth node has no rotation
    about its normal, and so no rotary inertia about it.
    """

    node: int
    mass: float
    inertia: float = 0.0

    def __post_init__(self):
        put(self, node=integer("point mass: node", self.node))
        put(self, mass=not_negative(f"point mass at node {self.node}: mass", self.mass, "kg"),
            inertia=not_negative(f"point mass at node {self.node}: inertia", self.inertia,
                                 "kg m^2"))


@dataclass(frozen=True)
class Spring:
    """A spring and a damper between two nodes, along the line between them.

    Of a length l they pull by ``k (l - L) + c dl/dt``.  Either may be a table instead, or besides:
    forces that pull at extensions ``l - L`` and at rates; linear between its points, constant
    beyond both ends.

    Attributes:
        node: one end.
        other: the other end.
        stiffness: k [N/m].
        length: L, at which the spring is slack [m]; left out, that of the start.
        damping: c [N s/m].
        spring_extensions: of the table of a spring, rising [m].
        spring_forces: there [N].
        damper_rates: of the table of a damper, rising [m/s].
        damper_forces: there, zero at rest and never with the motion [N].
    """

    node: int
    other: int
    stiffness: float = 0.0
    length: float = None
    damping: float = 0.0
    spring_extensions: tuple = ()
    spring_forces: tuple = ()
    damper_rates: tuple = ()
    damper_forces: tuple = ()

    def __post_init__(self):
        put(self, node=integer("spring: node", self.node),
            other=integer("spring: other", self.other))
        if self.node == self.other:
            raise InputError(f"spring: both ends are node {self.node}")
        what = f"spring at node {self.node}"
        put(self, stiffness=not_negative(f"{what}: stiffness", self.stiffness, "N/m"),
            damping=not_negative(f"{what}: damping", self.damping, "N s/m"))
        if self.length is not None:
            put(self, length=positive(f"{what}: length", self.length, "m"))
        check_tables(what, self, ("spring_extensions", "spring_forces"),
                     ("damper_rates", "damper_forces"), ("m/s", "N"))
        if not (self.stiffness or self.damping or self.spring_forces or self.damper_forces):
            raise InputError(f"{what}: a stiffness, a damping or a table is needed")

    @property
    def steepest(self):
        """Largest stiffness, that of a table included [N/m]."""
        slopes = np.diff(self.spring_forces) / np.diff(self.spring_extensions)
        return self.stiffness + float(np.abs(slopes).max(initial=0.0))


@dataclass(frozen=True)
class GroundSpring:
    """A spring between a node and the ground: ``1/2 u . (k u) + k_t (1 - p . p_0)``.

    ``stiffness`` (k_x, k_y, k_z) [N/m] against displacements along fixed axes, ``turning`` k_t
    [N m/rad] against turning the normal away from its initial direction (1 - cos of the angle).
    """

    node: int
    stiffness: tuple = (0.0, 0.0, 0.0)
    turning: float = 0.0

    def __post_init__(self):
        put(self, node=integer("ground spring: node", self.node))
        name = f"ground spring at node {self.node}"
        put(self, stiffness=vector(f"{name}: stiffness", self.stiffness, "N/m"),
            turning=not_negative(f"{name}: turning", self.turning, "N m/rad"))
        if min(self.stiffness) < 0.0:
            raise InputError(f"{name}: stiffness must not be negative, is {self.stiffness}")


ATTACHED = (PointMass, Spring, GroundSpring)


def foundation(nodes, quads, stiffness):
    """``GroundSpring`` s of an elastic (Winkler) foundation under the elements ``quads``.

    ``k_i = k int N_i dA`` of the initial area.

    Args:
        nodes: (n_nodes, 3) of the mesh [m].
        quads: (n, 4) elements that lie on it.
        stiffness: (k_x, k_y, k_z) per area [N/m^3].

    Raises:
        InputError: ``quads`` are not elements on ``nodes``, or the stiffness is no vector.
    """
    nodes = floats("foundation: nodes", nodes, (None, 3))
    k = np.array(vector("foundation: stiffness", stiffness, "N/m^3"))
    return [GroundSpring(i, tuple(share * k))
            for i, share in shares_of_area(nodes, quads)]


def add_masses(quads, attached, mass, rotary):
    """Add the point masses to those of elements (n_elem, 4, 4), on the corner of an element beside
    each node."""
    for item in attached:
        if isinstance(item, PointMass):
            element, corner = np.argwhere(quads == item.node)[0]
            mass[element, corner, corner] += item.mass
            rotary[element, corner, corner] += item.inertia


def check_attached(attached, n_nodes, first, joined, bodies):
    """Check nodes; ``first``: of ``Directors``; ``joined``: lists of nodes that move together
    or stay as far apart; ``bodies``: (name, nodes) of each rigid one.

    Raises:
        InputError: a node that does not exist, a spring between nodes that a joint holds together
            or one body carries, or a rotary inertia or turning spring at a junction, where plates
            with several normals meet.
    """
    for k, item in enumerate(attached):
        names = [field.name for field in fields(item) if field.name in ("node", "other")]
        for name in names:
            node = getattr(item, name)
            if not 0 <= node < n_nodes:
                raise InputError(f"attached[{k}]: {name} {node} does not exist, there are "
                                 f"{n_nodes} nodes")
        if isinstance(item, Spring):
            _check_spring(f"attached[{k}]", {item.node, item.other}, joined, bodies)
        several = first[item.node + 1] - first[item.node] > 1
        if several and (getattr(item, "inertia", 0.0) > 0.0 or getattr(item, "turning", 0.0) > 0.0):
            raise InputError(f"attached[{k}]: several plates meet at node {item.node}, a rotary "
                             "inertia or a turning spring needs a node with one normal")


def _check_spring(what, ends, joined, bodies):
    """Nothing holds both ends, by which it would always be as long."""
    between = f"nodes {min(ends)} and {max(ends)}"
    if any(ends <= set(group) for group in joined):
        raise InputError(f"{what}: a joint holds {between} as far apart as they are, a spring "
                         "between them does nothing (a hinge has a stiffness against turning)")
    for name, nodes in bodies:
        if ends <= set(nodes):
            raise InputError(f"{what}: body {name} carries {between}, a spring between them "
                             "does nothing")


@dataclass(frozen=True)
class Damping:
    """Damping of the shell, after Rayleigh: ``2 zeta = mass / w + stiffness w`` of a mode of w.

    The stiffness part is viscous in the co-rotated strains, ``s = D (e + stiffness de/dt)``: rigid
    motion is free of it, momenta stay; springs and foundations have none.  The mass part acts on
    translations, on ``v - v_rigid`` of a free shell, the rigid motion with its momenta, and on v of
    one with supports or ground springs, or of a sector.

    Attributes:
        mass: [1/s].
        stiffness: [s].
    """

    mass: float = 0.0
    stiffness: float = 0.0

    def __post_init__(self):
        put(self, mass=not_negative("damping: mass", self.mass, "1/s"),
            stiffness=not_negative("damping: stiffness", self.stiffness, "s"))

    @classmethod
    def of_ratios(cls, ratio_1, frequency_1, ratio_2, frequency_2):
        """That with two damping ratios at two frequencies [Hz].

        ``stiffness = 2 (z_2 w_2 - z_1 w_1)/(w_2^2 - w_1^2)``, ``mass = 2 z_1 w_1 - stiffness
        w_1^2``.

        Raises:
            InputError: a ratio is negative, the frequencies are equal or not positive, or the
                ratios lie so far apart that a part would be negative.
        """
        z_1, z_2 = (not_negative(f"damping: ratio_{k}", z) for k, z in ((1, ratio_1),
                                                                        (2, ratio_2)))
        w_1, w_2 = (2.0 * np.pi * positive(f"damping: frequency_{k}", f, "Hz")
                    for k, f in ((1, frequency_1), (2, frequency_2)))
        if abs(w_2 - w_1) <= TINY * w_2:
            raise InputError(f"damping: both frequencies are {frequency_1:g} Hz")
        stiffness = 2.0 * (z_2 * w_2 - z_1 * w_1) / (w_2**2 - w_1**2)
        mass = 2.0 * z_1 * w_1 - stiffness * w_1**2
        if min(mass, stiffness) < -1e-12 * max(abs(mass), abs(stiffness)):
            raise InputError(
                f"damping: ratios {z_1:g} at {frequency_1:g} Hz and {z_2:g} at {frequency_2:g} Hz "
                f"need mass {mass:.3g} 1/s and stiffness {stiffness:.3g} s; neither may be "
                "negative")
        return cls(max(mass, 0.0), max(stiffness, 0.0))
