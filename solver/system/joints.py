"""Hinges with springs, dampers, stops, latches and motors, as items of the system; what joints
hold."""

import math
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array

from ..kernels import hinges
from ..kernels.arguments import DONE
from ..kernels.calls import Call
from ..model.joints import Hinge, shares_of_edge
from .failure import NotConverged
from .state import blank_state


class Turned(NamedTuple):
    """What hinges did in a step.

    Attributes:
        work: (n,) of their motors and servos at every place [J].
        lost: (n,) what their dampers took there [J].
    """

    work: np.ndarray
    lost: np.ndarray


class Angle:
    """The angle of a hinge of a model, whether it has a moment or not."""

    def __init__(self, model, hinge):
        """``hinge``: ``Hinge``."""
        line, cells = np.array(hinge.nodes), hinge.tied
        self._edges, self._share = _edges(line), shares_of_edge(model.nodes[line])
        self._directors = model.directors.first[cells]
        self._angles, self._found = Call(hinges.angles), np.zeros(len(cells))
        self._initial = 0.0
        self._initial = self._measured(blank_state(model.nodes, 0), model.normals).copy()

    def __call__(self, state, p, last):
        """The mean angle [rad] at a state with normals p, within half a turn of the ``last``."""
        found = self._measured(state, p)
        return float(self._share @ (found + 2.0 * np.pi * np.round((last - found)
                                                                   / (2.0 * np.pi))))

    def _measured(self, state, p):
        self._angles(self._edges, self._directors, state.motion, p, self._found)
        return self._found - self._initial


class JointForces:
    """Forces by which each joint holds the first of its plates, of those on joined nodes."""

    def __init__(self, model, joined):
        """``joined``: nodes in the order of the forces."""
        at = {node: k for k, node in enumerate(joined.tolist())}
        group_of = {node: k for k, group in enumerate(model.joined) for node in group}
        pairs = [[] for _ in model.joined]
        for number, joint in enumerate(model.joints):
            for one, other in joint.tied.tolist():
                pairs[group_of[one]].append((number, one, other))
        rows, columns, values = [], [], []
        for group, tied in zip(model.joined, pairs):
            places = {node: k for k, node in enumerate(group)}
            A = np.zeros((len(group), len(tied)))
            for k, (_, one, other) in enumerate(tied):
                A[places[one], k], A[places[other], k] = 1.0, -1.0
            # of a loop of joints at one place, the least forces that there are
            for (number, *_), row in zip(tied, np.linalg.pinv(A)):
                rows += [number] * len(group)
                columns += [at[node] for node in group]
                values += row.tolist()
        self._of_joints = coo_array((values, (rows, columns)),
                                    shape=(len(model.joints), len(joined))).tocsr()

    def __call__(self, forces):
        """(n_joints, 3) of forces (n_joined, 3) on the nodes [N]."""
        return self._of_joints @ forces


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
            line = np.array(joint.nodes)
            share = shares_of_edge(model.nodes[line])
            edges.extend(_edges(line))
            for k in range(len(line)):
                cells.append((joint.nodes[k], joint.others[k]))
                constants.append(_constants(joint, share[k]))
                joints.append(number)
                shares.append(share[k])
        self.cells = np.array(cells, dtype=np.int64).reshape(-1, 2)
        self.joints, self._given = np.array(joints, dtype=np.int64), model.joints
        self._edges = np.array(edges, dtype=np.int64).reshape(-1, 2)
        self._constants = np.array(constants).reshape(-1, 9)
        self._shares = np.array(shares)
        self._directors = model.directors.first[self.cells]
        self._on_rotations, self._found = np.zeros((len(cells), 6)), np.zeros(len(cells))
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
        return Turned(motors * change - pull * moved, self._damping(before) * change**2 / dt)

    def by_joint(self, values, n_joints):
        """Sums (n_joints,) of values (n,) at places."""
        return np.bincount(self.joints, values, n_joints)

    @property
    def moments(self):
        """(n,) that turn the hinges on, motors among them, of the forces that were added last
        [N m]."""
        return self._on_rotations[:, 5]

    def energy_of(self, number, state):
        """Energy of springs, stops and latches of the hinge ``number`` [J]."""
        at = self.joints == number
        return self._energy(self._constants[at], state.hinges[at])

    def _damping(self, state):
        """(n,) of dampers and of latches that hold [N m s/rad]."""
        own = self._constants
        return own[:, hinges.DAMPING] + state.hinges[:, hinges.LOCKED] * own[:, hinges.LOCK_DAMPING]

    def _measured(self, state, p):
        """Angles (n,) of normals, in (-pi, pi]."""
        self._angles(self._edges, self._directors, state.motion, p, self._found)
        return self._found


def _edges(line):
    """(n, 2) nodes at both ends of the edge around each node of a line."""
    return np.stack([np.r_[line[0], line[:-1]], np.r_[line[1:], line[-1]]], axis=1)


def _constants(joint, share):
    """The constants of one place of a hinge, to which a ``share`` of its edge belongs."""
    least, most = joint.stops or (-math.inf, math.inf)
    lock = math.inf if joint.lock is None else joint.lock
    return [share * joint.stiffness, joint.rest, share * joint.damping, least, most,
            share * joint.stop_stiffness, lock, share * joint.lock_stiffness,
            share * joint.lock_damping]
