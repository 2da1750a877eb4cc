"""Loads of a model at one time: dead ones as vectors, followers as items of the system.

An item adds its forces and its matrix at an iterate, on cells of nodes of its own.
"""

from typing import NamedTuple

import numpy as np

from ..kernels import pressure
from ..kernels.arguments import Loads
from ..model.loads import CONSTANT, NodalMoment, Pressure


class Iterate(NamedTuple):
    """Where forces are taken: an increment ``delta`` from ``state`` with the factors ``step``."""

    state: object
    step: object
    delta: np.ndarray


class DeadLoads:
    """Nodal forces and moments about fixed axes, by their functions of time."""

    def __init__(self, model, numbering):
        self._forces, self._moments = {}, {}
        self._shapes = numbering.n_dof, (len(model.nodes), 3)
        for load in model.loads:
            if isinstance(load, NodalMoment):
                pattern = self._moments.setdefault(load.history, np.zeros(self._shapes[1]))
                pattern[load.node] += load.moment
            elif not isinstance(load, Pressure):
                pattern = self._forces.setdefault(load.history, np.zeros(self._shapes[0]))
                first = numbering.start[load.node]
                pattern[first:first + 3] += load.force

    def at(self, value):
        """``arguments.Loads`` with ``value(history)`` for each function of time."""
        return Loads(_total(self._forces, value, self._shapes[0]),
                     _total(self._moments, value, self._shapes[1]))

    @property
    def any_moment(self):
        return bool(self._moments)


class FollowerPressure:
    """Pressures along the current normals of elements.

    Attributes:
        cells: (n, 4) nodes of the elements that bear one.
    """

    def __init__(self, model):
        n_elem = len(model.quads)
        patterns = {}
        for load in model.loads:
            if isinstance(load, Pressure):
                elements = slice(None) if load.elements is None else list(load.elements)
                patterns.setdefault(load.history, np.zeros(n_elem))[elements] += load.pressure
        loaded = np.flatnonzero(np.any([p != 0.0 for p in patterns.values()], axis=0))
        self.cells = np.ascontiguousarray(model.quads[loaded])
        self._patterns = {history: p[loaded] for history, p in patterns.items()}
        self._pressures = np.zeros(len(loaded))

    def set(self, value):
        """Take the pressures with ``value(history)`` for each function of time."""
        self._pressures = _total(self._patterns, value, len(self.cells))

    def add_forces(self, dofs, iterate, forces):
        """Add the forces at an iterate to ``forces`` (n_dof,) [N]."""
        pressure.add_pressure_forces(
            dofs.nodes, self.cells, self._pressures, iterate.state.motion, iterate.delta,
            1.0 - iterate.step.alpha_f, forces)

    def add_matrix(self, dofs, iterate, storage, values, skew):
        """Add their stiffness to the symmetric part and, if there is one, to the skew part."""
        pressure.add_pressure_stiffness(
            dofs, storage, self.cells, self._pressures, iterate.state.motion, iterate.delta,
            iterate.step, values, skew)


def items(model):
    """Items of the loads of a model; today ``FollowerPressure``, if there is any."""
    if any(isinstance(load, Pressure) and load.pressure for load in model.loads):
        return [FollowerPressure(model)]
    return []


def at_time(time):
    """Value of a function of time, for ``set`` and ``at``."""
    return lambda history: history(time)


def at_factor(factor):
    """The same for a static load factor: a constant load is multiplied by it, any other taken at
    it."""
    return lambda history: factor if history == CONSTANT else history(factor)


def _total(patterns, value, shape):
    total = np.zeros(shape)
    for history, pattern in patterns.items():
        factor = value(history)
        if factor != 0.0:
            total += factor * pattern
    return total
