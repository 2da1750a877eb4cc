"""Motion of supports: where they hold the shell at a time, as increments of the held unknowns."""

import numpy as np
from scipy.spatial.transform import Rotation

from ..errors import InputError
from ..kernels.junctions import nodal_frame
from ..model.loads import Drive
from .loads import unloaded

STILL = 1e-12
"""Increments below this part of the shell's size, or this angle [rad], are none."""

INSTANT = 1e-4
"""Part of a step over which rates are differences."""


class Driven:
    """What moves the supports of a model.

    Attributes:
        moving: whether anything does.
    """

    def __init__(self, model, numbering, coordinates):
        self._X, self._size = model.nodes, model.size
        self._normals, self._first = model.normals, model.directors.first
        self._coordinates, self._numbering = coordinates, numbering
        self._translations = numbering.translations
        self._shifts, self._drives = {}, []
        for support in model.supports:
            if isinstance(support, Drive):
                self._drives.append(support)
            elif support.displacement != 0.0:
                pattern = self._shifts.setdefault(support.history, np.zeros(self._X.shape))
                at = list(support.nodes)
                for component in support.components:
                    direction = support.directions["xyz".index(component)]
                    held = np.outer(pattern[at] @ direction, direction)
                    pattern[at] += support.displacement * direction - held
        self.moving = bool(self._shifts or self._drives)
        self._moved = np.zeros(self._X.shape, dtype=bool)
        for pattern in self._shifts.values():
            self._moved |= pattern != 0.0
        for drive in self._drives:
            self._moved[list(drive.nodes)] = True
        if coordinates.constraints:  # the others of these nodes move with one of their components
            oblique = coordinates.constraints.nodes
            self._moved[oblique] = self._moved[oblique].any(axis=1)[:, None]
        if model.pairs and any(map(model.pairs.differ, self._shifts.values())):
            raise InputError("cyclic: displacements are prescribed differently on the two edges of "
                             "the sector")

    def increment(self, state, value):
        """Increments (n_dof,) that take the supports from ``state`` to where they are for
        ``value(history)``, zero at free unknowns; None where nothing moves them."""
        if not self.moving:
            return None
        increment = np.zeros(self._numbering.n_dof)
        increment[self._translations] = self._displacements(state, value)
        for drive in self._drives:
            turn = self._turn(drive, value)
            for i in drive.nodes:
                at = self._numbering.start[i] + 3
                increment[at:at + self._numbering.n_rot[i]] = self._coordinates.increment_to(
                    state, i, turn)
        return increment

    def correction(self, state, start, value):
        """The same as a static correction, by which normals turn along great circles; None where
        what is left of it is none."""
        if not self.moving:
            return None
        correction = np.zeros(self._numbering.n_dof)
        u = self._displacements(state, value)
        correction[self._translations] = np.where(np.abs(u) > STILL * self._size, u, 0.0)
        for drive in self._drives:
            turn = self._turn(drive, value)
            for i in drive.nodes:
                d, spin = self._first[i], None
                arc = _arc(start.p[d], turn.apply(self._normals[d].copy()))
                if self._numbering.n_rot[i] == 3:
                    first = Rotation.from_matrix(self._coordinates.frames[i].T)
                    arc = spin = (turn * first * _frame(state, i).inv()).as_rotvec()
                if np.linalg.norm(arc) > STILL:
                    self._turn_node(correction, state, start, i, arc, spin)
        return correction if np.any(correction) else None

    def _turn_node(self, correction, state, start, i, arc, spin):
        """Changes of the variables of a node, into ``correction``: those that move its normal by
        ``arc`` (3,), or turn a junction by ``spin`` (3,)."""
        at, n_rot = self._numbering.start[i] + 3, self._numbering.n_rot[i]
        if n_rot == 2:
            A = start.A1[self._first[i], :, :2]
            correction[at:at + 2] = np.linalg.lstsq(A, arc, rcond=None)[0]
        else:
            correction[at:at + 3] = _variable_rates(state.chart[i], _frame(state, i), spin)

    def linear(self, state, start, value, now=unloaded):
        """The same of small motions, (n_dof,): ``u = t + r x (x - about - t h)``, ``dp = r x p``;
        ``now(history)``: h of the ``state``."""
        correction = np.zeros(self._numbering.n_dof)
        u = sum((value(history) * pattern for history, pattern in self._shifts.items()),
                np.zeros(self._X.shape))
        for drive in self._drives:
            at, spin = list(drive.nodes), value(drive.turning) * np.array(drive.rotation)
            shift = np.array(drive.translation)
            arms = state.x[at] + state.x_low[at] - drive.about - now(drive.history) * shift
            u[at] = value(drive.history) * shift + np.cross(spin, arms)
            for i in at:
                self._turn_node(correction, state, start, i,
                                np.cross(spin, start.p[self._first[i]]), spin)
        correction[self._translations] = u
        return correction

    def set_rates(self, state, at, time, dt):
        """Velocities of the driven unknowns at a ``time`` [s], by differences over a small part of
        ``dt`` [s]; ``at(time)`` gives ``value``."""
        if self.moving:
            rates = slope(lambda t: self.increment(state, at(t)), time, INSTANT * dt)
            state.velocity[:] = self._coordinates.free(state.velocity) + rates

    def check(self, state, value):
        """Raise ``InputError`` where the supports of ``value(history)`` are not where ``state``
        is."""
        if self.moving:
            off = np.abs(self.increment(state, value))
            worst = int(np.argmax(off))
            if off[worst] > 1e-9 * max(self._size, 1.0):
                node = self._numbering.node_of_dof[worst]
                raise InputError(f"node {node}: its support is not where the shell is at t = 0, by "
                                 f"{off[worst]:.3g}: its history must start there")

    def _displacements(self, state, value):
        """(n_nodes, 3) from ``state`` to where supports hold translations; zero elsewhere [m]."""
        goal = self._X.copy()
        for history, pattern in self._shifts.items():
            goal += value(history) * pattern
        for drive in self._drives:
            at = list(drive.nodes)
            goal[at] = (drive.about + self._turn(drive, value).apply(self._X[at] - drive.about)
                        + value(drive.history) * np.array(drive.translation))
        u = np.zeros(self._numbering.n_dof)
        u[self._translations] = np.where(self._moved, (goal - state.x) - state.x_low, 0.0)
        return (u - self._coordinates.free(u))[self._translations]

    @staticmethod
    def _turn(drive, value):
        return Rotation.from_rotvec(value(drive.turning) * np.array(drive.rotation))


def slope(of, time, h):
    """Derivative of ``of(time)`` by a central difference over h, at t = 0 one towards later times
    of the same order."""
    weights = {-1: -1.0, 1: 1.0} if time > h else {0: -3.0, 1: 4.0, 2: -1.0}
    return sum(weight * of(time + k * h) for k, weight in weights.items()) / (2.0 * h)


def _arc(p, goal):
    """Tangent (3,) at p of the great circle to ``goal``, as long as the angle [rad]."""
    across = goal - (p @ goal) * p
    length = np.linalg.norm(across)
    return across * (np.arctan2(length, p @ goal) / length) if length > 0.0 else across


def _frame(state, i):
    """Rotation of a junction's nodal frame from the global axes."""
    n, m, k = state.variables[i]
    e = np.empty((3, 3))
    nodal_frame(n, m, k, state.chart[i], e)
    return Rotation.from_matrix(e.T)


def _variable_rates(triad, frame, spin):
    """``dn = spin . (e_y x t_1)`` and so on."""
    _, e_y, e_z = frame.as_matrix().T
    return np.array([spin @ np.cross(e_y, triad[0]), spin @ np.cross(e_y, triad[1]),
                     spin @ np.cross(e_z, triad[0])])
