"""Stresses of the layers of a section, and how near they are to failure."""

from dataclasses import dataclass

import numpy as np

from ..checks import existing
from ..model.laminates import Section
from ..model.model import Model
from ..signatures import checked
from .stresses import Configuration, stresses, turned


@dataclass(frozen=True, eq=False, repr=False)
class LayerStresses:
    """Stresses at the centres of the elements of a section, at the bottom and the top of each ply.

    Attributes:
        section: ``Section``.
        elements: (n,) numbers of its elements.
        stress: (n, n_plies, 2, 3) along the fibres, across them, and shear: 1, 2, 12 [Pa].
    """

    section: Section
    elements: np.ndarray
    stress: np.ndarray

    def __repr__(self):
        return f"<LayerStresses: {len(self.elements)} elements, {self.stress.shape[1]} plies>"

    @property
    def tsai_wu(self):
        """(n, n_plies, 2) index of Tsai and Wu, 1 at failure; nan of plies without strength."""
        return self._index("tsai_wu")

    @property
    def largest(self):
        """(n, n_plies, 2) index of maximum stress, 1 at failure; nan of plies without strength."""
        return self._index("largest")

    def _index(self, criterion):
        found = np.full(self.stress.shape[:3], np.nan)
        for k, ply in enumerate(self.section.laminate.plies):
            if ply.lamina.strength is not None:
                found[:, k] = getattr(ply.lamina.strength, criterion)(self.stress[:, k])
        return found


@checked
def layer_stresses(model: Model, state: Configuration, section: int = 0):
    """Stresses of the plies of a section, in the axes of their fibres.

    ``sigma = Q (eps + z chi - alpha dT(z))`` with the strains that the forces n and m of
    ``stresses`` make, ``(eps, chi) = ABD^-1 (n + n_T, m + m_T)``.

    Args:
        model: ``Model`` with sections.
        state: as of ``stresses``.
        section: its number in ``model.sections``.

    Returns:
        ``LayerStresses``.

    Raises:
        InputError: no such section, or as of ``stresses``.
    """
    existing("section", (section,), len(model.sections))
    given, elements = model.sections[section], model.members[section]
    laminate, found = given.laminate, stresses(model, state)
    along = given.along(model.nodes[model.quads[elements]], elements)
    forces = np.concatenate([turned(found.n[elements], along), turned(found.m[elements], along)],
                            axis=1)
    strains = np.linalg.solve(
        laminate.ABD, (forces + laminate.heat(given.temperature, given.gradient)).T).T
    stress = np.empty((len(elements), len(laminate.plies), 2, 3))
    for k, ply in enumerate(laminate.plies):
        for side, z in enumerate(laminate.heights[k:k + 2]):
            free = (given.temperature + given.gradient * z) * ply.expansion
            elastic = strains[:, :3] + z * strains[:, 3:] - free
            stress[:, k, side] = elastic @ ply.to_fibres.T @ ply.lamina.stiffness
    return LayerStresses(given, elements, stress)
