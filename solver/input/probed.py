"""Probes of stress, of energy and of joints of a model file."""

from pydantic import model_validator

from ..dynamics.probes import EnergyProbe, JointProbe, StressProbe
from .places import elements_of
from .values import Name, Point, Strict, in_unit, only_one


class Probed(Strict):
    """Stresses of an element, the strain energy of a group, or what a joint does, at every step of
    a motion.

    Attributes:
        stress: a point; the element is that whose initial centre is nearest [m].
        axes: direction of x of its stresses, projected on the element; without it, as the nodes of
            the element have it [-].
        energy: the elements of a group, by name, or ``all``.
        joint: by name: angle, forces and energies.
    """

    stress: in_unit("m", Point) | None = None
    axes: in_unit("", Point) | None = None
    energy: Name | None = None
    joint: Name | None = None

    @model_validator(mode="after")
    def _one_kind(self):
        kind = only_one(self, ("stress", "energy", "joint"))
        if kind != "stress" and self.axes:
            raise ValueError(f"axes belong to stress, this has {kind}")
        return self

    def made(self, mesh):
        """``StressProbe``, ``EnergyProbe`` or ``JointProbe`` on a ``Mesh``.

        Raises:
            InputError: there is no such group.
        """
        if self.stress:
            return StressProbe(self.stress.value, self.axes and self.axes.value)
        if self.joint:
            return JointProbe(self.joint)
        return EnergyProbe(elements_of(mesh, self.energy).tolist())
