"""Laminates of a model file: materials, layers, where they lie."""

from pydantic import model_validator

from ..model.laminates import Lamina, Laminate, Ply, Section, Strength
from .values import Name, Number, Point, Positive, Strict


class Limits(Strict):
    """Stresses at which a material fails, all positive.

    Attributes:
        Xt: tension along the fibres [Pa].
        Xc: compression along them [Pa].
        Yt: tension across them [Pa].
        Yc: compression across them [Pa].
        S: shear in the plane [Pa].
    """

    Xt: Positive
    Xc: Positive
    Yt: Positive
    Yc: Positive
    S: Positive


class Material(Strict):
    """A material of layers, 1 along its fibres; isotropic by E1, nu12 and density alone.

    Attributes:
        E1: Young's modulus along the fibres [Pa].
        E2: across them; that along them without it [Pa].
        nu12: Poisson's ratio of a stress along the fibres [-].
        G12: shear modulus in the plane; E1 / (2 (1 + nu12)) without it [Pa].
        G13: transverse shear modulus; G12 without it [Pa].
        G23: transverse shear modulus; G12 without it [Pa].
        density: of the material [kg/m^3].
        alpha1: thermal expansion along the fibres [1/K].
        alpha2: across them; that along them without it [1/K].
        strength: stresses at which it fails.
    """

    E1: Positive
    E2: Positive | None = None
    nu12: Number
    G12: Positive | None = None
    G13: Positive | None = None
    G23: Positive | None = None
    density: Positive
    alpha1: Number = 0.0
    alpha2: Number | None = None
    strength: Limits | None = None

    @model_validator(mode="after")
    def _possible(self):
        self.made()
        return self

    def made(self):
        """``Lamina``."""
        def given(value, otherwise):
            return otherwise if value is None else value

        if self.nu12 <= -1.0:
            raise ValueError(f"nu12 must be above -1, is {self.nu12:g}")
        G12 = given(self.G12, 0.5 * self.E1 / (1.0 + self.nu12))
        return Lamina(
            self.E1, given(self.E2, self.E1), self.nu12, G12, given(self.G13, G12),
            given(self.G23, G12), self.density, self.alpha1, given(self.alpha2, self.alpha1),
            self.strength and Strength(**self.strength.model_dump()))


class Layer(Strict):
    """A layer of a laminate.

    Attributes:
        material: its name.
        thickness: of the layer [m].
        angle: of the fibres to the material direction, about the normal [degrees].
    """

    material: Name
    thickness: Positive
    angle: Number = 0.0


class Layers(Strict):
    """A laminate.

    Attributes:
        plies: layers from the bottom to the top, where the normal points.
        offset: height of its middle above the surface of the nodes [m].
    """

    plies: list[Layer]
    offset: Number = 0.0

    def made(self, materials):
        """``Laminate`` of ``{name: Material}``."""
        return Laminate([Ply(materials[ply.material].made(), ply.thickness, ply.angle)
                         for ply in self.plies], self.offset)


class SectionOf(Strict):
    """Where a laminate lies, and its change of temperature.

    Attributes:
        laminate: its name.
        group: of elements; all without it.
        direction: material direction, projected on each element.
        temperature: change of temperature at the surface of the nodes [K].
        gradient: its change over the height [K/m].
    """

    laminate: Name
    group: Name | None = None
    direction: Point = (1.0, 0.0, 0.0)
    temperature: Number = 0.0
    gradient: Number = 0.0

    def made(self, mesh, laminate):
        """``Section`` on a mesh."""
        elements = None if self.group is None else mesh.groups[self.group].tolist()
        return Section(laminate, elements, self.direction, self.temperature, self.gradient)
