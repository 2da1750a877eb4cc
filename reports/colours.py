"""What colours elements: the strain energy density of a recording, or one of its stresses."""

from typing import Annotated, NamedTuple

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from corovec.solver.checks import choice
from corovec.solver.errors import InputError

from .style import COLOURS, SIGNED

PEAKS = 0.995
"""Part of the values below the end of the colours, so that a single peak does not darken all."""

ENERGY, VON_MISES = "strain_energy_density", "von_mises"

RESULTANTS = {"n": ("membrane_force", "force", "N/m", ("xx", "yy", "xy")),
              "m": ("moment", "moment", "N", ("xx", "yy", "xy")),
              "q": ("shear_force", "shear force", "N/m", ("xz", "yz"))}
"""Of each letter its field of a recording, its name, its unit, and its components."""

COMPONENTS = {f"{letter}_{end}": (field, k, f"{name} {letter}_{end} [{unit}]")
              for letter, (field, name, unit, ends) in RESULTANTS.items()
              for k, end in enumerate(ends)}
"""``{name: (field of a recording, its column, label)}``."""

NAMES = (ENERGY, VON_MISES, *COMPONENTS)

Color = Annotated[str, lambda name, value: choice(name, value, NAMES)]


class Coloured(NamedTuple):
    """Values of elements.

    Attributes:
        name: one of ``NAMES``.
        values: (n_frames, n_elem).
        label: what they are, with their unit.
    """

    name: str
    values: np.ndarray
    label: str

    def at(self, frames):
        """Those of some frames."""
        return self._replace(values=self.values[frames])

    @property
    def scale(self):
        """Their colours."""
        return colour_scale(self.values, self.name in COMPONENTS)

    def bar(self, figure, scale, axes, **place):
        """Draw the colour bar of their ``scale``."""
        below, beyond = self.values.min() < scale.norm.vmin, self.values.max() > scale.norm.vmax
        extend = {(0, 0): "neither", (1, 0): "min", (0, 1): "max", (1, 1): "both"}[below, beyond]
        bar = figure.colorbar(scale, ax=axes, extend=extend, label=self.label, **place)
        bar.outline.set_linewidth(0.5)


def coloured(recording, name=ENERGY):
    """``Coloured`` of a recording: by strain energy density, by the largest von Mises stress over
    the thickness, or by a force or moment per length in the axes of the elements.

    Raises:
        InputError: no such name, or stresses were not recorded.
    """
    if choice("color", name, NAMES) == ENERGY:
        return Coloured(name, recording.energy_density, "strain energy density [J/m²]")
    if "von_mises" not in recording.contents:
        raise InputError(f"color {name}: {recording.name} has no stresses, run it with --stresses "
                         "(Settings(stresses=True))")
    if name == VON_MISES:
        values = recording.contents["von_mises"].max(axis=2)
        return Coloured(name, values, "largest von Mises stress [Pa]")
    field, column, label = COMPONENTS[name]
    return Coloured(name, recording.contents[field][..., column], label)


def colour_scale(values, signed=False):
    """Colours from zero, or from minus the largest of those that are ``signed``, to where ``PEAKS``
    of the values end."""
    sizes = np.abs(values)
    top = float(np.quantile(sizes, PEAKS)) or float(sizes.max()) or 1.0
    return ScalarMappable(Normalize(-top if signed else 0.0, top), SIGNED if signed else COLOURS)
