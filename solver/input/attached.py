"""What is attached to the shell of a model file: masses, springs, foundations, damping."""

from pydantic import Field, model_validator

from ..errors import InputError
from ..model.attached import Damping, GroundSpring, PointMass, Spring, foundation
from ..model.mesh import node_at
from .places import Placed, elements_of
from .values import Line, Name, NotNegative, Numbers, Positive, Strict, in_unit

Three = tuple[NotNegative, NotNegative, NotNegative]
Two = tuple[NotNegative, NotNegative]
NONE = Field(0.0, validate_default=True)


class MassAt(Placed):
    """A rigid mass at a node, or at each of several.

    Attributes:
        mass: of each [kg].
        inertia: of each about axes across the normal of the shell [kg m^2].
    """

    mass: in_unit("kg", NotNegative)
    inertia: in_unit("kg m^2", NotNegative) = NONE

    def made(self, mesh):
        """``PointMass`` es on a ``Mesh``.

        Raises:
            InputError: its place is not there.
        """
        return [PointMass(node, self.mass.value, self.inertia.value) for node in self.numbers(mesh)]


class SpringBetween(Strict):
    """A spring and a damper between two nodes, along the line between them.

    Attributes:
        between: the points at which they are [m].
        stiffness: of the spring [N/m].
        length: at which it is slack; without it that of the start [m].
        damping: of the damper [N s/m].
        spring_extensions: of the table of a spring, counted from ``length``, rising [m].
        spring_forces: there [N].
        damper_rates: of the table of a damper, rising [m/s].
        damper_forces: there [N].
    """

    between: in_unit("m", Line)
    stiffness: in_unit("N/m", NotNegative) = NONE
    length: in_unit("m", Positive) | None = None
    damping: in_unit("N s/m", NotNegative) = NONE
    spring_extensions: in_unit("m", Numbers) | None = None
    spring_forces: in_unit("N", Numbers) | None = None
    damper_rates: in_unit("m/s", Numbers) | None = None
    damper_forces: in_unit("N", Numbers) | None = None

    def made(self, mesh):
        """``Spring`` on a ``Mesh``, a list of one.

        Raises:
            InputError: its ends are not there, or one; it has no force, or a table that is none.
        """
        ends = (node_at(mesh.nodes, point) for point in self.between.value)
        given = {name: getattr(self, name) for name in type(self).model_fields}
        return [Spring(*ends, **{name: entry.value for name, entry in given.items()
                                 if entry is not None and name != "between"})]


class SpringToGround(Placed):
    """A spring between a node and the ground, or one at each of several nodes.

    Attributes:
        stiffness: against displacements along x, y and z, of each [N/m].
        turning: against turning the normal away from where it was, of each [N m/rad].
    """

    stiffness: in_unit("N/m", Three) = Field((0.0, 0.0, 0.0), validate_default=True)
    turning: in_unit("N m/rad", NotNegative) = NONE

    @model_validator(mode="after")
    def _some(self):
        if not any((*self.stiffness.value, self.turning.value)):
            raise ValueError("a stiffness or turning is needed")
        return self

    def made(self, mesh):
        """``GroundSpring`` s on a ``Mesh``.

        Raises:
            InputError: its place is not there.
        """
        return [GroundSpring(node, self.stiffness.value, self.turning.value)
                for node in self.numbers(mesh)]


class Foundation(Strict):
    """An elastic (Winkler) foundation under elements.

    Attributes:
        surface: the elements of a group, by name, or ``all``.
        stiffness: against displacements along x, y and z, per initial area [N/m^3].
    """

    surface: Name
    stiffness: in_unit("N/m^3", Three)

    def made(self, mesh):
        """``GroundSpring`` s on a ``Mesh``.

        Raises:
            InputError: there is no such group.
        """
        return foundation(mesh.nodes, mesh.quads[elements_of(mesh, self.surface)],
                          self.stiffness.value)


class Damped(Strict):
    """Damping of the shell after Rayleigh, by its two factors, or by ratios at two frequencies.

    Attributes:
        mass: factor of the mass; half of it over w is the ratio of a mode of w [1/s].
        stiffness: factor of the stiffness; half of it times w is the ratio of a mode of w [s].
        ratios: instead, two ratios to critical damping [-].
        frequencies: at which these are [Hz].
    """

    mass: in_unit("1/s", NotNegative) | None = None
    stiffness: in_unit("s", NotNegative) | None = None
    ratios: in_unit("", Two) | None = None
    frequencies: in_unit("Hz", tuple[Positive, Positive]) | None = None

    @model_validator(mode="after")
    def _possible(self):
        factors, ratios = (self.mass or self.stiffness), (self.ratios or self.frequencies)
        if not factors and not ratios or factors and ratios:
            raise ValueError("mass and stiffness, or ratios and frequencies are needed")
        if ratios and not (self.ratios and self.frequencies):
            raise ValueError(f"{'frequencies' if self.ratios else 'ratios'} are missing")
        try:
            self.made()
        except InputError as error:
            raise ValueError(str(error).removeprefix("damping: ")) from None
        return self

    def made(self):
        """``Damping``."""
        if self.ratios:
            (z_1, z_2), (f_1, f_2) = self.ratios.value, self.frequencies.value
            return Damping.of_ratios(z_1, f_1, z_2, f_2)
        return Damping(*(given.value if given else 0.0 for given in (self.mass, self.stiffness)))
