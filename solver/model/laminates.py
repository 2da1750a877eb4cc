"""Sections of layers: laminates, their stiffness, their heat, and where they lie.

A ``Laminate`` is homogenized once, in its own axes: x is the material direction of a ``Section``,
angles of plies run from it about the normal.  z is the height above the surface of the nodes:

    n = A eps + B chi - n_T     m = B eps + D chi - m_T     q = S gamma

    (A, B, D) = int (1, z, z^2) Q dz     (n_T, m_T) = int (1, z) Q alpha dT dz

with the plane-stress elasticity Q of each ply (Jones 1999, chapters 2 and 4).
"""

from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from ..checks import distinct, existing, floats, instance, number, plain_array, positive, vector
from ..errors import InputError
from ..fields import put
from .constants import Law, in_surface, isotropic

UNCOUPLED = 1e-12
"""Part of A h below which a coupling B is rounding, and a section is none that couples."""

THREE_POINTS = np.polynomial.legendre.leggauss(3)
"""Exact for the square of a quadratic function."""


@dataclass(frozen=True)
class Strength:
    """Stresses at which a layer fails, all positive.

    Attributes:
        Xt: tension along the fibres [Pa].
        Xc: compression along them [Pa].
        Yt: tension across them [Pa].
        Yc: compression across them [Pa].
        S: shear in the plane [Pa].
    """

    Xt: float
    Xc: float
    Yt: float
    Yc: float
    S: float

    def __post_init__(self):
        put(self, **{field.name: positive(f"strength: {field.name}", getattr(self, field.name),
                                          "Pa") for field in fields(self)})

    def tsai_wu(self, stress):
        """Index of Tsai and Wu, 1 at failure; of stresses (..., 3) in material axes [Pa].

        ``F_1 s_1 + F_2 s_2 + F_11 s_1^2 + F_22 s_2^2 + F_66 s_12^2 + 2 F_12 s_1 s_2`` with
        ``F_12 = -sqrt(F_11 F_22)/2`` (Tsai and Wu 1971; F_12 by Tsai and Hahn 1980).
        """
        s1, s2, s12 = np.moveaxis(stress, -1, 0)
        F11, F22 = 1.0 / (self.Xt * self.Xc), 1.0 / (self.Yt * self.Yc)
        return ((1.0 / self.Xt - 1.0 / self.Xc) * s1 + (1.0 / self.Yt - 1.0 / self.Yc) * s2
                + F11 * s1**2 + F22 * s2**2 + (s12 / self.S) ** 2 - np.sqrt(F11 * F22) * s1 * s2)

    def largest(self, stress):
        """Index of maximum stress, the largest ratio of a component to its strength, 1 at failure;
        of stresses (..., 3) in material axes [Pa]."""
        s1, s2, s12 = np.moveaxis(stress, -1, 0)
        return np.max([s1 / self.Xt, -s1 / self.Xc, s2 / self.Yt, -s2 / self.Yc,
                       np.abs(s12) / self.S], axis=0)


@dataclass(frozen=True)
class Lamina:
    """An orthotropic material in plane stress, 1 along the fibres, 2 across them, 3 the normal.

    Attributes:
        E1: Young's modulus along 1 [Pa].
        E2: Young's modulus along 2 [Pa].
        nu12: strain along 2 over that along 1, reversed, of a stress along 1.
        G12: shear modulus in the plane [Pa].
        G13: transverse shear modulus [Pa].
        G23: transverse shear modulus [Pa].
        density: rho [kg/m^3].
        alpha1: thermal expansion along 1 [1/K].
        alpha2: thermal expansion along 2 [1/K].
        strength: ``Strength``; None where nothing is asked of it.
    """

    E1: float
    E2: float
    nu12: float
    G12: float
    G13: float
    G23: float
    density: float
    alpha1: float = 0.0
    alpha2: float = 0.0
    strength: Strength = None

    def __post_init__(self):
        for name in ("E1", "E2", "G12", "G13", "G23", "density"):
            unit = "kg/m^3" if name == "density" else "Pa"
            put(self, **{name: positive(f"lamina: {name}", getattr(self, name), unit)})
        for name in ("nu12", "alpha1", "alpha2"):
            put(self, **{name: number(f"lamina: {name}", getattr(self, name))})
        if self.nu12**2 * self.E2 >= self.E1:
            raise InputError(f"lamina: nu12 must be below sqrt(E1/E2) = "
                             f"{np.sqrt(self.E1 / self.E2):g} in magnitude, is {self.nu12:g}")
        if self.strength is not None:
            instance("lamina: strength", self.strength, Strength)

    @classmethod
    def isotropic(cls, youngs, poisson, density, alpha=0.0, strength=None):
        """The same in all directions.

        Args:
            youngs: E [Pa].
            poisson: nu, in (-1, 0.5).
            density: rho [kg/m^3].
            alpha: thermal expansion [1/K].
            strength: ``Strength``, or None.

        Raises:
            InputError: as of ``Lamina``.
        """
        poisson = number("lamina: poisson", poisson)
        if not -1.0 < poisson < 0.5:
            raise InputError(f"lamina: poisson must lie in (-1, 0.5), is {poisson:g}")
        G = 0.5 * positive("lamina: youngs", youngs, "Pa") / (1.0 + poisson)
        return cls(youngs, youngs, poisson, G, G, G, density, alpha, alpha, strength)

    @property
    def stiffness(self):
        """(3, 3) Q of plane stress, sigma = Q eps, in axes 1, 2 [Pa]."""
        compliance = np.array([[1.0 / self.E1, -self.nu12 / self.E1, 0.0],
                               [-self.nu12 / self.E1, 1.0 / self.E2, 0.0],
                               [0.0, 0.0, 1.0 / self.G12]])
        return np.linalg.inv(compliance)


@dataclass(frozen=True)
class Ply:
    """A layer of a laminate.

    Attributes:
        lamina: ``Lamina``.
        thickness: [m].
        angle: of its fibres to the material direction of the section, about the normal [degrees].
    """

    lamina: Lamina
    thickness: float
    angle: float = 0.0

    def __post_init__(self):
        instance("ply: lamina", self.lamina, Lamina)
        put(self, thickness=positive("ply: thickness", self.thickness, "m"),
            angle=number("ply: angle", self.angle, "degrees"))

    @property
    def to_fibres(self):
        """(3, 3) strains (xx, yy, 2 xy) in axes 1, 2 of those in the axes of the section."""
        return strain_axes(np.array([np.cos(np.radians(self.angle)),
                                     np.sin(np.radians(self.angle))]))

    @property
    def stiffness(self):
        """(3, 3) Q in the axes of the section [Pa]."""
        return self.to_fibres.T @ self.lamina.stiffness @ self.to_fibres

    @property
    def shear(self):
        """(2, 2) transverse shear moduli in the axes of the section [Pa]."""
        c, s = np.cos(np.radians(self.angle)), np.sin(np.radians(self.angle))
        R = np.array([[c, s], [-s, c]])
        return R.T @ np.diag([self.lamina.G13, self.lamina.G23]) @ R

    @property
    def expansion(self):
        """(3,) strains of a degree in the axes of the section [1/K]."""
        along = np.array([self.lamina.alpha1, self.lamina.alpha2, 0.0])
        return np.linalg.solve(self.to_fibres, along)


@dataclass(frozen=True)
class Laminate:
    """Plies on one another.

    Attributes:
        plies: ``Ply`` s from the bottom to the top, where the normal points.
        offset: height of its middle above the surface of the nodes [m].
    """

    plies: tuple
    offset: float = 0.0

    def __post_init__(self):
        if isinstance(self.plies, Ply) or not np.iterable(self.plies):
            raise InputError("laminate: plies must be a list of Ply")
        plies = tuple(instance(f"laminate: plies[{k}]", ply, Ply)
                      for k, ply in enumerate(self.plies))
        if not plies:
            raise InputError("laminate: plies must not be empty")
        put(self, plies=plies, offset=number("laminate: offset", self.offset, "m"))

    @property
    def thickness(self):
        """h [m]."""
        return sum(ply.thickness for ply in self.plies)

    @property
    def youngs(self):
        """The largest A_ii/h, a scale [Pa]."""
        return np.diag(self.ABD)[:3].max() / self.thickness

    @property
    def poisson(self):
        """0, no property of a laminate."""
        return 0.0

    @cached_property
    def heights(self):
        """(n_plies + 1,) heights z of the faces of the plies [m]."""
        z = np.cumsum([0.0, *(ply.thickness for ply in self.plies)])
        return z - 0.5 * z[-1] + self.offset

    @cached_property
    def ABD(self):
        """(6, 6) of ``(n, m) = ABD (eps, chi)``, in the axes of the section [N/m, N, N m]."""
        A, B, D = np.einsum("kp,pij->kij", self._moments, [ply.stiffness for ply in self.plies])
        if np.abs(B).max() < UNCOUPLED * np.abs(A).max() * self.thickness:
            B = np.zeros((3, 3))
        return np.block([[A, B], [B, D]])

    @cached_property
    def shear(self):
        """(2, 2) S of ``q = S gamma``, that stores the energy of the shear stresses which balance
        the bending stresses [N/m].

        ``m_xx,x = q_x`` and ``m_yy,y = q_y`` are taken for two cylindrical bendings without change
        of n.  Equilibrium of the plies, ``tau,z = -div sigma``, gives ``tau = f(z) q``, and
        ``S^-1 = int f^T G^-1 f dz`` (Rolfes and Rohwer 1997).  5/6 G h of one material.
        """
        strains = np.linalg.inv(self.ABD)[:, 3:]
        membrane, curvature = strains[:3], strains[3:]
        compliance, f = np.zeros((2, 2)), np.zeros((2, 2))
        for ply, low, high in zip(self.plies, self.heights, self.heights[1:]):
            constant, linear = (_slopes(ply.stiffness @ part) for part in (membrane, curvature))
            for point, weight in zip(*THREE_POINTS):
                z = 0.5 * (low + high + point * (high - low))
                at = f - (z - low) * (constant + 0.5 * (z + low) * linear)
                compliance += (0.5 * (high - low) * weight
                               * at.T @ np.linalg.solve(ply.shear, at))
            f = f - (high - low) * (constant + 0.5 * (high + low) * linear)
        return np.linalg.inv(compliance)

    @property
    def density(self):
        """Mass over volume [kg/m^3]."""
        return self._inertia[0] / self.thickness

    @property
    def arm(self):
        """Height of the mass centre above the surface of the nodes [m]."""
        arm = self._inertia[1] / self._inertia[0]
        return 0.0 if abs(arm) < UNCOUPLED * self.thickness else arm

    def heat(self, temperature, gradient):
        """(6,) forces and moments n_T, m_T [N/m, N] of a change of temperature
        ``temperature + gradient z`` [K, K/m] that is held back."""
        m0, m1, m2 = self._moments
        stress = np.array([ply.stiffness @ ply.expansion for ply in self.plies])
        return np.concatenate([(temperature * m0 + gradient * m1) @ stress,
                               (temperature * m1 + gradient * m2) @ stress])

    @property
    def _moments(self):
        """(3, n_plies) ``int (1, z, z^2) dz`` of the plies."""
        z = self.heights
        return np.array([np.diff(z**k) / k for k in (1, 2, 3)])

    @property
    def _inertia(self):
        """(3,) ``int rho (1, z, z^2) dz``."""
        return self._moments @ [ply.lamina.density for ply in self.plies]


@dataclass(frozen=True)
class Section:
    """A laminate on some elements of a model.

    Attributes:
        laminate: ``Laminate``.
        elements: numbers of the elements; None for all.
        direction: material direction (x, y, z), projected on each initial element, from where on it
            turns with it; or (n, 3) one for each of the elements, in their order.
        temperature: change of temperature at the surface of the nodes [K].
        gradient: its change over the height [K/m].
    """

    laminate: Laminate
    elements: tuple = None
    direction: tuple = (1.0, 0.0, 0.0)
    temperature: float = 0.0
    gradient: float = 0.0

    def __post_init__(self):
        instance("section: laminate", self.laminate, Laminate)
        if self.elements is not None:
            put(self, elements=distinct("section: elements", self.elements))
        if np.ndim(plain_array("section: direction", self.direction, "3")) == 2:
            rows = floats("section: direction", self.direction, (None, 3))
            put(self, direction=tuple(map(tuple, rows.tolist())))
        else:
            put(self, direction=vector("section: direction", self.direction))
        put(self, temperature=number("section: temperature", self.temperature, "K"),
            gradient=number("section: gradient", self.gradient, "K/m"))

    @property
    def heated(self):
        """Whether there is a change of temperature."""
        return self.temperature != 0.0 or self.gradient != 0.0

    def times(self, part):
        """The same with a ``part`` of its change of temperature."""
        return replace(self, temperature=part * self.temperature, gradient=part * self.gradient)

    def along(self, corners, elements):
        """Material direction in the initial axes x, y of its elements: unit vectors (n, 2).

        Args:
            corners: (n, 4, 3) of its elements [m].
            elements: their numbers.

        Raises:
            InputError: a direction that stands on an element.
        """
        directions = np.array(self.direction)
        if directions.ndim == 2 and len(directions) != len(elements):
            raise InputError(f"direction: {len(directions)} given, one an element of the section "
                             f"({len(elements)}) needed")
        seen, steep = in_surface(corners, np.broadcast_to(directions, (len(elements), 3)))
        if steep.any():
            raise InputError(f"direction is none in the surface of element "
                             f"{elements[np.argmax(steep)]}: it stands on it or is zero")
        return seen

    def law(self, along):
        """``Law`` of elements with the material direction ``along`` (n, 2)."""
        laminate, T = self.laminate, strain_axes(along)
        h, ABD, heat = laminate.thickness, laminate.ABD, laminate.heat(self.temperature,
                                                                       self.gradient)
        A, B, D = (T.swapaxes(1, 2) @ part @ T for part in (ABD[:3, :3], ABD[:3, 3:], ABD[3:, 3:]))
        n_T, m_T = (heat[part] @ T for part in (slice(3), slice(3, 6)))
        coupling = np.linalg.solve(A, B)
        bending = D - B @ coupling
        strain = np.linalg.solve(A, n_T[:, :, None])
        curvature = np.linalg.solve(bending, m_T[:, :, None] - B @ strain)
        c, s = along.T
        R = np.stack([np.stack([c, s], axis=1), np.stack([-s, c], axis=1)], axis=1)
        modulus = 0.5 * np.trace(laminate.shear)
        shear = R.swapaxes(1, 2) @ (laminate.shear / modulus) @ R
        mass, _, inertia = laminate._inertia
        full = np.ones(len(along))
        return Law(h * full, A / h, 12.0 / h**3 * bending, modulus * full, shear,
                   inertia / mass * full, coupling, strain[:, :, 0], curvature[:, :, 0],
                   laminate.arm * full)


def directions_of(sections, members, corners):
    """Material directions (n, 2) of the elements of each of the sections, as of ``Section.along``.

    Raises:
        InputError: as of that, with the number of the section.
    """
    found = []
    for k, (section, elements) in enumerate(zip(sections, members)):
        try:
            found.append(section.along(corners[elements], elements))
        except InputError as error:
            raise InputError(f"sections[{k}]: {error}") from None
    return found


def law_of(thickness, youngs, poisson, corners, sections, members):
    """``Law`` of all elements.

    Args:
        thickness, youngs, poisson: (n_elem,) of those without a section [m], [Pa], [-].
        corners: (n_elem, 4, 3) [m].
        sections: ``Section`` s.
        members: numbers of the elements of each.
    """
    law = isotropic(thickness, youngs, poisson)
    if not sections:
        return law
    n = len(thickness)
    zeros = {"coupling": np.zeros((n, 3, 3)), "strain": np.zeros((n, 3)),
             "curvature": np.zeros((n, 3)), "arm": np.zeros(n)}
    whole = Law(*(np.array(values) for values in law[:6]), **zeros)
    directions = directions_of(sections, members, corners)
    for section, elements, along in zip(sections, members, directions):
        for values, of_section in zip(whole, section.law(along)):
            values[elements] = of_section
    whole = whole._replace(**{name: None for name in ("coupling", "arm")
                              if not getattr(whole, name).any()})
    if not any(section.heated for section in sections):
        whole = whole._replace(strain=None, curvature=None)
    return whole


def members_of(sections, n_elem):
    """Numbers of the elements of each of the sections.

    Raises:
        InputError: an element that does not exist, or that is in two sections.
    """
    members, taken = [], np.full(n_elem, -1)
    for k, section in enumerate(sections):
        elements = np.arange(n_elem) if section.elements is None else np.array(
            existing(f"sections[{k}]: element", section.elements, n_elem))
        if np.any(taken[elements] >= 0):
            element = elements[np.argmax(taken[elements] >= 0)]
            raise InputError(f"element {element} is in sections {taken[element]} and {k}")
        taken[elements] = k
        members.append(elements)
    return members


def strain_axes(along):
    """(..., 3, 3) strains (xx, yy, 2 xy) in axes whose x is ``along`` (..., 2); its transpose takes
    stresses back."""
    c, s = np.moveaxis(along, -1, 0)
    return np.stack([np.stack([c * c, s * s, c * s], axis=-1),
                     np.stack([s * s, c * c, -c * s], axis=-1),
                     np.stack([-2.0 * c * s, 2.0 * c * s, c * c - s * s], axis=-1)], axis=-2)


def _slopes(stress):
    """Divergence (2, 2) of stresses whose columns (3, 3) are those of m_xx, m_yy, m_xy, by the
    shear forces ``m_xx,x`` and ``m_yy,y``."""
    return np.array([[stress[0, 0], stress[2, 1]], [stress[2, 0], stress[1, 1]]])
