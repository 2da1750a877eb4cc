"""What a motion consists of at one instant, and what follows from it."""

from dataclasses import dataclass

import numpy as np

from ..kernels.arguments import Motion, Observation, Start


@dataclass
class State:
    """Everything that one instant of the motion consists of.

    Attributes:
        motion: ``arguments.Motion``; its arrays are also attributes of the state, to be changed in
            place.
        external_work: work of the loads since t = 0 [J].
        peak: largest energy of the shell or work of its loads so far [J].
        missed: energy since t = 0 that is not work of the loads [J].
    """

    motion: Motion
    external_work: float = 0.0
    peak: float = 0.0
    missed: float = 0.0

    x = property(lambda self: self.motion.x)
    x_low = property(lambda self: self.motion.x_low)
    variables = property(lambda self: self.motion.variables)
    chart = property(lambda self: self.motion.chart)
    velocity = property(lambda self: self.motion.velocity)
    acceleration = property(lambda self: self.motion.acceleration)

    def pack(self):
        """All numbers of the state as one float64 vector."""
        return np.concatenate([*(array.ravel() for array in self.motion),
                               [self.external_work, self.peak, self.missed]])

    def unpack(self, packed):
        """Take over the numbers of ``pack``."""
        at = 0
        for array in self.motion:
            array[...] = packed[at:at + array.size].reshape(array.shape)
            at += array.size
        self.external_work, self.peak, self.missed = (float(value) for value in packed[at:])

    def take(self, other):
        """Become as another state of the same model."""
        for own, given in zip(self.motion, other.motion):
            np.copyto(own, given)
        self.external_work = other.external_work
        self.peak, self.missed = other.peak, other.missed


@dataclass
class Place:
    """What follows from a state: where a step starts from.

    Attributes:
        start: ``arguments.Start``, normals, local variables, measures.
        observed: ``arguments.Observation``, energies and momenta.
    """

    start: Start
    observed: Observation | None = None


def blank_state(nodes, n_dof):
    """Nodes at their initial places, axes along the global ones, everything else zero."""
    return State(Motion(nodes.copy(), np.zeros_like(nodes), np.zeros_like(nodes),
                        np.tile(np.eye(3), (len(nodes), 1, 1)), np.zeros(n_dof), np.zeros(n_dof)))


def blank_place(elements, n_directors):
    """A ``Place`` of zeros, to be filled."""
    n_elem, n_s = len(elements.nodes), elements.l.shape[1]
    return Place(Start(np.zeros((n_directors, 3)), np.zeros((n_directors, 3, 3)),
                       np.zeros((n_directors, 3)), np.zeros((n_elem, 3, 3)),
                       np.zeros((n_elem, 11)), np.zeros((n_elem, n_s)), np.zeros(n_elem)))
