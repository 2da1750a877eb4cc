"""What a motion consists of at one instant, and what follows from it."""

from dataclasses import dataclass

import numpy as np

from ..kernels.arguments import Motion, Observation, Start

TOTALS = ("external_work", "support_work", "dissipated", "peak", "missed", "part")
"""Sums of a ``State`` since t = 0, and the length of a part that comes next."""


@dataclass
class State:
    """Everything that one instant of the motion consists of.

    Attributes:
        motion: ``arguments.Motion``; its arrays are also attributes of the state, to be changed in
            place.
        external_work: work of the loads since t = 0 [J].
        support_work: work of the supports that move [J].
        dissipated: energy that damping took [J].
        peak: largest energy of the shell or work of its loads so far [J].
        missed: energy since t = 0 that is not work of the loads [J].
        lags: (n_elem, 1) by how much the dissipation of ``exact`` moves the mean of an element's
            strains towards the end of the step; none of other schemes.
        means: (2, n_nodes, 3) mean velocities of the last two parts of adaptive steps [m/s].
        spans: (2,) their lengths [s].
        part: length of the part that comes next [s]; zero: not known.
        hinges: (n, 3) of every place of a hinge with a moment, see ``kernels.hinges``.
    """

    motion: Motion
    lags: np.ndarray
    means: np.ndarray
    spans: np.ndarray
    hinges: np.ndarray
    external_work: float = 0.0
    support_work: float = 0.0
    dissipated: float = 0.0
    peak: float = 0.0
    missed: float = 0.0
    part: float = 0.0

    x = property(lambda self: self.motion.x)
    x_low = property(lambda self: self.motion.x_low)
    variables = property(lambda self: self.motion.variables)
    chart = property(lambda self: self.motion.chart)
    velocity = property(lambda self: self.motion.velocity)
    acceleration = property(lambda self: self.motion.acceleration)

    @property
    def _arrays(self):
        return *self.motion, self.lags, self.means, self.spans, self.hinges

    def pack(self, out=None):
        """All numbers of the state as one float64 vector, a new one or ``out``."""
        return np.concatenate([*(array.ravel() for array in self._arrays),
                               [getattr(self, name) for name in TOTALS]], out=out)

    def unpack(self, packed):
        """Take over the numbers of ``pack``."""
        at = 0
        for array in self._arrays:
            array[...] = packed[at:at + array.size].reshape(array.shape)
            at += array.size
        for name, value in zip(TOTALS, packed[at:], strict=True):
            setattr(self, name, float(value))

    def take(self, other):
        """Become as another state of the same model."""
        for own, given in zip(self._arrays, other._arrays):
            np.copyto(own, given)
        for name in TOTALS:
            setattr(self, name, getattr(other, name))


@dataclass
class Place:
    """What follows from a state: where a step starts from.

    Attributes:
        start: ``arguments.Start``, normals, local variables, measures.
        observed: ``arguments.Observation``, energies and momenta.
    """

    start: Start
    observed: Observation | None = None


def blank_state(nodes, n_dof, n_lags=0, n_hinges=0):
    """Nodes at their initial places, axes along the global ones, everything else zero."""
    return State(Motion(nodes.copy(), np.zeros_like(nodes), np.zeros_like(nodes),
                        np.tile(np.eye(3), (len(nodes), 1, 1)), np.zeros(n_dof), np.zeros(n_dof)),
                 np.zeros((n_lags, 1)), np.zeros((2, *nodes.shape)), np.zeros(2),
                 np.zeros((n_hinges, 3)))


def blank_place(elements, n_directors):
    """A ``Place`` of zeros, to be filled."""
    n_elem, n_s = len(elements.nodes), elements.l.shape[1]
    return Place(Start(np.zeros((n_directors, 3)), np.zeros((n_directors, 3, 3)),
                       np.zeros((n_directors, 3)), np.zeros((n_elem, 3, 3)),
                       np.zeros((n_elem, 11)), np.zeros((n_elem, n_s)), np.zeros(n_elem)))
