"""Items of the loads without a potential; see ``system.loads`` for what an item is."""

import numpy as np

from ..kernels import drag, follower
from ..model.nonconservative import Drag, FollowerForce, UserForce
from .failure import NotConverged


class FollowerForces:
    """Forces that turn with nodes.

    Attributes:
        cells: (n, 1) nodes.
    """

    def __init__(self, model):
        loads = [load for load in model.loads if isinstance(load, FollowerForce)]
        self.cells = np.array([load.node for load in loads], dtype=np.int64).reshape(-1, 1)
        self._histories = [load.history for load in loads]
        first = model.directors.first
        self._components = np.array([
            components(load, model.normals[first[load.node]:first[load.node + 1]])
            for load in loads]).reshape(-1, 3)

    def at(self, value):
        """Components (n, 3) [N] with ``value(history)`` for each function of time."""
        return self._components * [[value(history)] for history in self._histories]

    def add_forces(self, dofs, iterate, components, forces):
        """Add the forces at an iterate to ``forces`` (n_dof,) [N]."""
        follower.add_follower_forces(dofs.nodes, self.cells, components, iterate.p, forces)

    def add_matrix(self, dofs, iterate, components, storage, values, skew):
        """Add their stiffness to the symmetric part and, if there is one, to the skew part."""
        follower.add_follower_stiffness(dofs, storage, self.cells, components, iterate.step,
                                        iterate.p, iterate.A1, values, skew)


def components(load, normals):
    """(3,) components of a ``FollowerForce`` at a node with these ``normals`` (n, 3)."""
    if load.along_normal:
        return np.array([load.force, 0.0, 0.0])
    t_3 = np.cross(normals[0], normals[1])
    t_3 /= np.linalg.norm(t_3)
    return np.stack([normals[0], np.cross(t_3, normals[0]), t_3]) @ load.force


class DragForces:
    """Drag of media on elements.

    Attributes:
        cells: (n, 4) nodes of the elements of one load after the other.
    """

    def __init__(self, model):
        loads = [load for load in model.loads if isinstance(load, Drag)]
        quads = [model.quads if load.elements is None else model.quads[list(load.elements)]
                 for load in loads]
        self.cells = np.concatenate([model.quads[:0], *quads])
        self._sizes = [len(on) for on in quads]
        self._histories = [load.history for load in loads]
        self._strengths = np.repeat([0.5 * load.density * load.coefficient for load in loads],
                                    self._sizes)
        self._media = np.repeat(np.array([load.velocity for load in loads]).reshape(-1, 3),
                                self._sizes, axis=0)

    def at(self, value):
        """Strengths (n,) [kg/m^3] with ``value(history)`` for each function of time."""
        return self._strengths * np.repeat([value(history) for history in self._histories],
                                           self._sizes)

    def add_forces(self, dofs, iterate, strengths, forces):
        """Add the forces at an iterate to ``forces`` (n_dof,) [N]."""
        drag.add_drag_forces(dofs.nodes, self.cells, strengths, self._media, iterate.state.motion,
                             iterate.delta, iterate.step, forces)

    def add_matrix(self, dofs, iterate, strengths, storage, values, skew):
        """Add their derivative to the symmetric part and, if there is one, to the skew part."""
        drag.add_drag_matrix(dofs, storage, self.cells, strengths, self._media,
                             iterate.state.motion, iterate.delta, iterate.step, values, skew)


class UserForces:
    """Forces of functions of the user; the matrix does not know of them.

    Attributes:
        cells: (1, 4) nodes of an element, to which nothing is added.
    """

    def __init__(self, model):
        self._loads = [load for load in model.loads if isinstance(load, UserForce)]
        self.cells = model.quads[:1 if self._loads else 0]

    def at(self, value):
        """``(factor, time)`` of each: ``value(history)`` and that of the time itself."""
        return [(value(load.history), value(_clock)) for load in self._loads]

    def add_forces(self, dofs, iterate, factors, forces):
        """Add the forces at an iterate to ``forces`` (n_dof,) [N].

        Raises:
            NotConverged: a force is not finite.
        """
        state, step, delta = iterate.state, iterate.step, iterate.delta
        at = dofs.nodes.start[:, None] + np.arange(3)
        x = state.x + (state.x_low + (1.0 - step.alpha_f) * delta[at])
        v = iterate.rates[at]
        for load, (factor, time) in zip(self._loads, factors, strict=True):
            if factor == 0.0:
                continue
            given = load.forces(time, x, v, iterate.p)
            if not np.all(np.isfinite(given)):
                raise NotConverged(f"{load.name} is not finite at t = {time:.9g} s")
            forces[at] += factor * given

    def add_matrix(self, dofs, iterate, factors, storage, values, skew):
        """Add nothing."""


def _clock(time):
    """The function of time that is the time."""
    return time
