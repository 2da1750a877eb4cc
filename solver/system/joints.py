"""Hinges with springs, dampers, stops, latches and motors, as items of the system."""

import math
from typing import NamedTuple

import numpy as np

from ..kernels import hinges
from ..kernels.arguments import DONE
from ..kernels.calls import Call
from ..model.joints import Hinge, shares_of_edge
from .failure import NotConverged
from .state import blank_state


class Turned(NamedTuple):
    """What hinges did in a step.

    Attributes:
        work: of their motors and servos [J].
        lost: what their dampers took [J].
    """

    work: float
    lost: float


class Hinges:
    """All places, two nodes each, at which a hinge has a moment.

    Attributes:
        cells: (n, 2) nodes, of ``nodes`` and of ``others``.
        joints: (n,) number of the hinge of each place.
    """

    def __init__(self, model):
        cells, edges, constants, joints, shares = [], [], [], [], []
        for number, joint in enumerate(model.joints):
            if not (isinstance(joint, Hinge) and joint.acts):
                continue
            line, last = np.array(joint.nodes), len(joint.nodes) - 1
            share = shares_of_edge(model.nodes[line])
            for k in range(len(line)):
                cells.append((joint.nodes[k], joint.others[k]))
                edges.append((line[max(k - 1, 0)], line[min(k + 1, last)]))
                constants.append(_constants(joint, share[k]))
                joints.append(number)
                shares.append(share[k])
        self.cells = np.array(cells, dtype=np.int64).reshape(-1, 2)
        self.joints, self._given = np.array(joints, dtype=np.int64), model.joints
        self._edges = np.array(edges, dtype=np.int64).reshape(-1, 2)
        self._constants = np.array(constants).reshape(-1, 9)
        self._shares = np.array(shares)
        self._directors = model.directors.first[self.cells]
        self._on_rotations, self._found = np.zeros((len(cells), 5)), np.zeros(len(cells))
        self._energy = Call(hinges.energy)
        self._add_forces = Call(hinges.add_hinge_forces)
        self._add_stiffness = Call(hinges.add_hinge_stiffness)
        self._angles = Call(hinges.angles)
        start = blank_state(model.nodes, 0)
        self._initial = self._measured(start, model.normals).copy()

    def __bool__(self):
        return len(self.cells) > 0

    def motors(self, value):
        """Moments (n,) of motors [N m] with ``value(history)`` for each function of time."""
        return self._shares * self._each(lambda joint: joint.torque and (
            joint.torque * value(joint.history)))

    def slacks(self, value):
        """Angles (n,) at which springs are slack [rad], the same."""
        return self._each(lambda joint: joint.rest and joint.rest * value(joint.turning))

    def _each(self, of):
        values = {number: of(self._given[number]) for number in np.unique(self.joints).tolist()}
        return np.array([values[number] for number in self.joints.tolist()], dtype=float)

    def follow(self, state, p):
        """Angles of a ``state`` with the normals p, each within half a turn of its last one."""
        found = self._measured(state, p) - self._initial
        last = state.hinges[:, hinges.ANGLE]
        last[:] = found + 2.0 * np.pi * np.round((last - found) / (2.0 * np.pi))

    def latch(self, state):
        """Latches hold from where their hinge has been at their angle."""
        lock, angle = self._constants[:, hinges.LOCK], state.hinges[:, hinges.ANGLE]
        state.hinges[np.sign(lock) * angle >= np.abs(lock), hinges.LOCKED] = 1.0

    def energy(self, state):
        """Energy of springs, stops and latches [J]."""
        return self._energy(self._constants, state.hinges)

    def add_forces(self, dofs, iterate, start, end, motors, slacks, forces):
        """Add the forces at an iterate to ``forces`` (n_dof,); ``start`` and ``end``: normals
        (n_directors, 3) there.

        Raises:
            NotConverged: plates fold by a right angle or more in the step.
        """
        lost = self._add_forces(
            dofs.nodes, self._edges, self._directors, self.cells, self._constants,
            iterate.state.hinges, motors, slacks, iterate.state.motion, iterate.delta,
            iterate.step, start, end, iterate.A1, forces, self._on_rotations)
        if lost != DONE:
            raise NotConverged(f"the hinge at node {lost} turns too far")

    def add_matrix(self, dofs, storage, values, skew):
        """Add their stiffness in the iterate whose forces were added last."""
        self._add_stiffness(dofs, storage, self.cells, self._on_rotations, values, skew)

    def linear(self, dofs, motion):
        """Changes (n_dof,) of the forces of springs by a small ``motion`` (n_dof,) from the state
        whose forces were added last."""
        at = (dofs.nodes.start[self.cells][:, :, None] + np.array((3, 4))).reshape(-1, 4)
        g, change = self._on_rotations[:, :4], np.zeros_like(motion)
        turned = self._constants[:, hinges.K] * np.sum(g * motion[at], axis=1)
        np.subtract.at(change, at, turned[:, None] * g)
        return change

    def turned(self, before, state, motors, dt):
        """``Turned`` in a step of length dt [s] between two states."""
        k, slack = self._constants[:, hinges.K], hinges.SLACK
        change = state.hinges[:, hinges.ANGLE] - before.hinges[:, hinges.ANGLE]
        moved = state.hinges[:, slack] - before.hinges[:, slack]
        pull = 0.5 * k * (state.hinges[:, hinges.ANGLE] + before.hinges[:, hinges.ANGLE]
                          - state.hinges[:, slack] - before.hinges[:, slack])
        damping = self._damping(before)
        return Turned(float(motors @ change - pull @ moved), float(damping @ change**2) / dt)

    def _damping(self, state):
        """(n,) of dampers and of latches that hold [N m s/rad]."""
        own = self._constants
        return own[:, hinges.DAMPING] + state.hinges[:, hinges.LOCKED] * own[:, hinges.LOCK_DAMPING]

    def angle(self, number, state, place):
        """Mean angle [rad] and rate [rad/s] of the hinge ``number``."""
        at = self.joints == number
        a, b = self._directors[at].T
        i, j = self._edges[at].T
        edge = state.x[j] - state.x[i]
        edge /= np.linalg.norm(edge, axis=1, keepdims=True)
        p, rate = place.start.p, place.start.p_dot
        spin = np.cross(p[b], rate[b]) - np.cross(p[a], rate[a])
        share = self._shares[at]
        return (float(share @ state.hinges[at, hinges.ANGLE]),
                float(share @ np.sum(spin * edge, axis=1)))

    def _measured(self, state, p):
        """Angles (n,) of normals, in (-pi, pi]."""
        self._angles(self._edges, self._directors, state.motion, p, self._found)
        return self._found


def _constants(joint, share):
    """The constants of one place of a hinge, to which a ``share`` of its edge belongs."""
    least, most = joint.stops or (-math.inf, math.inf)
    lock = math.inf if joint.lock is None else joint.lock
    return [share * joint.stiffness, joint.rest, share * joint.damping, least, most,
            share * joint.stop_stiffness, lock, share * joint.lock_stiffness,
            share * joint.lock_damping]
