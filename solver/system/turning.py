"""Moments of springs, servos, dampers, stops, latches and motors in joints, by their angles."""

import math
from typing import NamedTuple

import numpy as np

from ..kernels import hinges
from ..kernels.calls import Call
from ..model.joints import Hinge, Turning, shares_of_edge
from .tables import columns_of, stacked


class Turned(NamedTuple):
    """What joints did in a step.

    Attributes:
        work: (n,) of their motors and servos at every place [J].
        lost: (n,) what their dampers took there [J].
    """

    work: np.ndarray
    lost: np.ndarray


class Turnings:
    """All places at which joints have moments: the nodes of the edges of hinges, each with a share
    of its edge, then other joints.

    Attributes:
        joints: (n,) number of the joint of each place.
        hinges: how many belong to hinges, the first ones.
        numbers: of the joints that have places, ascending.
    """

    def __init__(self, model):
        numbers = {kind: [k for k, joint in enumerate(model.joints) if isinstance(joint, Turning)
                          and joint.places and isinstance(joint, Hinge) == kind]
                   for kind in (True, False)}
        shares = [shares_of_edge(model.nodes[list(model.joints[k].nodes)]) for k in numbers[True]]
        self._given = model.joints
        self.joints = np.array([*(k for k, share in zip(numbers[True], shares) for _ in share),
                                *numbers[False]], dtype=np.int64)
        self.hinges = sum(map(len, shares))
        self._shares = np.concatenate([*shares, np.ones(len(numbers[False]))])
        rows = [_constants(model.joints[k], share) for k, share in zip(self.joints, self._shares)]
        self.constants = stacked(rows, hinges.TABLES)
        self._energy, self._done = Call(hinges.energy), Call(hinges.done)
        self.numbers, first, self._place_of, count = np.unique(
            self.joints, return_index=True, return_inverse=True, return_counts=True)
        self._spans = [slice(k, k + n) for k, n in zip(first.tolist(), count.tolist())]

    def __bool__(self):
        return len(self.joints) > 0

    def motors(self, value):
        """Moments (n,) of motors [N m] with ``value(history)`` for each function of time."""
        return self._shares * self._each(lambda joint: joint.torque and (
            joint.torque * value(joint.history)))

    def slacks(self, value):
        """Angles (n,) at which springs are slack [rad], the same."""
        return self._each(lambda joint: joint.rest and joint.rest * value(joint.turning))

    def _each(self, of):
        values = [of(self._given[number]) for number in self.numbers]
        return np.array(values, dtype=float)[self._place_of]

    def latch(self, state):
        """Latches hold from where their joint has been at their angle."""
        lock, angle = self.constants[:, hinges.LOCK], state.hinges[:, hinges.ANGLE]
        state.hinges[np.sign(lock) * angle >= np.abs(lock), hinges.LOCKED] = 1.0

    def energy(self, state):
        """Energy of springs, stops and latches [J]."""
        return self._energy(self.constants, state.hinges)

    def turned(self, before, state, motors, dt):
        """``Turned`` in a step of length dt [s] between two states."""
        change = state.hinges[:, hinges.ANGLE] - before.hinges[:, hinges.ANGLE]
        moved = state.hinges[:, hinges.SLACK] - before.hinges[:, hinges.SLACK]
        found = np.empty((len(change), 2))
        self._done(self.constants, before.hinges, state.hinges, dt, found)
        return Turned(motors * change - found[:, 0] * moved, found[:, 1])

    def by_joint(self, values):
        """Sums (n_joints,) of values (n,) at places."""
        return np.bincount(self.joints, values, len(self._given))

    def energies(self, state):
        """Energy of springs, stops and latches of each of ``numbers`` [J]."""
        return [self._energy(self.constants[at], state.hinges[at]) for at in self._spans]


def nearest(angles, last):
    """``angles`` (n,) by whole turns nearest to the ``last`` ones [rad]."""
    return angles + 2.0 * np.pi * np.round((last - angles) / (2.0 * np.pi))


def _constants(joint, share):
    """The constants of one place of a joint, to which a ``share`` of it belongs."""
    least, most = joint.stops or (-math.inf, math.inf)
    lock = math.inf if joint.lock is None else joint.lock
    tables = [(joint.spring_angles, joint.spring_moments),
              (joint.damper_rates, joint.damper_moments)]
    return [share * joint.stiffness, joint.rest, share * joint.damping, least, most,
            share * joint.stop_stiffness, lock, share * joint.lock_stiffness,
            share * joint.lock_damping, *columns_of(tables, share)]
