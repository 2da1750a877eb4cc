"""Constraints with multipliers, solved for together with the increment of a step.

With ``g(q_1) = 0`` and forces ``-G_m^T l`` along midpoint gradients a step conserves energy and
momenta, but nothing keeps the rates ``G v`` at zero: they alternate and grow (measured on a rigid
link: 0.2 m/s of 4 within 10 s).  Therefore the rates at both ends of a step get an impulse each,

    v_0' = v_0 + M^-1 G_0^T L_0^-T n,   v_1 = v_1' - M^-1 G_1^T L_1^-T n,   L L^T = G M^-1 G^T,

with the same n at both ends, chosen so that ``G_1 v_1 = 0``.  As ``G_0 v_0 = 0`` the first adds
``n . n / 2`` to the energy and the second takes it away, exactly; both have no resultant and no
moment.  The scheme stays symmetric in time and of second order.
"""

import numpy as np
from scipy.sparse import coo_array, csr_array, eye_array
from scipy.sparse.linalg import splu

from ..kernels import multipliers
from ..kernels.arguments import DONE
from ..kernels.calls import Call
from .damping import consistent_mass
from .failure import NotConverged
from .step_links import StepLinks


class Multipliers(StepLinks):
    """The constraints of a model in the exact scheme."""

    def __init__(self, system):
        coordinates = system.coordinates
        super().__init__(system, coordinates.initial_frames)
        self._begin, self._end = Call(multipliers.begin), Call(multipliers.end)
        self._constrain = Call(multipliers.constrain)
        if self:
            self._inverse, self._held_back = inverse_mass(system, self.dofs)
            self._mobile = np.ascontiguousarray(self._inverse[self.dofs])
            G = self._set_values(coordinates.initial_frames)
            self._check(self._mobility(G[:self._hard]))

    def begin(self, state, start=None):
        """Start a step from a ``state``: no forces yet."""
        self._begin(self._links, self._mobile, state.motion, self._work)
        self._rates_0 = self._G_0[self._m:] @ state.velocity[self.dofs]
        self._work.drive[:] = np.inf

    def add_forces(self, iterate, driven, slacks, motors, work, forces):
        """Add the forces of the constraints, and of the impulses, at an iterate to ``forces``
        (n_dof,).

        Args:
            iterate: ``Iterate``.
            driven: ``Rates``.
            slacks: (n,) angles at which springs are slack at the end [rad].
            motors: (n,) moments of motors [N m].
            work: ``SpinWork`` of it.
            forces: added to.

        Raises:
            NotConverged: a joint turns by a right angle or more in the step, or joints hold the
                same twice.
        """
        state, step, delta = iterate[:3]
        self._rate, self._at = step.rate_delta, (state.motion, work)
        lost = self._constrain(self._links, self._mobile, state.motion, work, delta, self._rate,
                               driven.after, self._work, forces)
        if lost != DONE:
            raise NotConverged("a joint turns too far, or joints hold the same twice")
        self._miss_angles(state, step, driven, slacks, motors)

    def parts(self):
        """(n_local,) sums of the magnitudes of all forces of constraints in the last iterate."""
        return np.abs(self._G_m).T @ np.abs(self.forces)

    def _acting(self, rows):
        """Forces (n_local,) of some rows, and the part of the step after which they act."""
        return zip(self._forces_of(rows), (0.5, 0.0, 1.0))

    def _place_of(self, i, part):
        """(3,) of node i after a part of the step [m]."""
        motion, work = self._at
        return motion.x[i] + motion.x_low[i] + part * work.dx[i]

    def _torque(self, i, f, part):
        """(3,) moment on node i of forces that act after a part of the step."""
        motion, work = self._at
        at, n, before = self._local[i] + 3, self._n_rot[i], motion.chart[i]
        axes = before + part * (work.frames[i] - before)
        if n == 2:
            axes = np.stack([axes[1], -axes[0]]) / (axes[2] @ axes[2])
        elif part == 0.5:
            axes = before
        return f[at:at + n] @ axes

    def _end_at(self, state):
        """Take the gradients at the end of a step from its ``state``."""
        self._end(self._links, state.motion, self._work)

    def _pushed(self, last, first=0.0):
        """(n_dof,) rates by impulses (n_local,) at the end, and the start."""
        return self._inverse @ (first + last)


def inverse_mass(system, dofs, turning=True):
    """Columns of the inverse mass at some unknowns, (n_dof, n_local), of what supports leave free,
    and by what impulses at these supports hold the others, ``1 - M M^-1``, a sparse one; turns have
    the lumped inertia of the exact scheme, or with ``turning=False`` none."""
    model, numbering, coordinates = system.model, system.numbering, system.coordinates
    start = numbering.start
    bodies, body_masses = np.array(model.body_masses).reshape(-1, 2).T
    bodies, mass = bodies.astype(np.int64), consistent_mass(model).tocoo()
    i, j, own = (np.concatenate(parts) for parts in (
        (mass.coords[0], bodies), (mass.coords[1], bodies), (mass.data, body_masses)))
    rows = [start[i] + c for c in range(3)]
    columns = [start[j] + c for c in range(3)]
    values = [own] * 3
    of_turns = _inertia_of_turns if turning else _no_inertia
    for row, column, value in of_turns(system):
        rows.append(row)
        columns.append(column)
        values.append(value)
    M = coo_array((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
                  shape=(numbering.n_dof,) * 2).tocsc()
    T = coordinates.basis()
    reduced = splu((T.T @ M @ T).tocsc())
    found = T @ reduced.solve(T.T[:, dofs].toarray())
    if not turning:
        found[:, ~np.isin(dofs, numbering.translations)] = 0.0
    of_supports = csr_array(eye_array(numbering.n_dof) - T @ T.T)
    of_supports.eliminate_zeros()
    rows = np.flatnonzero(np.diff(of_supports.indptr))
    own = of_supports[rows]
    held = coo_array(own[:, dofs].toarray() - (own @ M) @ found)
    return found, csr_array((held.data, (rows[held.coords[0]], held.coords[1])), found.shape)


def _inertia_of_turns(system):
    """Rows, columns and values of it."""
    model, numbering, coordinates = system.model, system.numbering, system.coordinates
    start, n_rot, first = numbering.start, numbering.n_rot, model.directors.first
    b = coordinates.nodes.body
    J = np.add.reduceat(coordinates.inertia[:, None, None] * (
        np.eye(3) - b[:, :, None] * b[:, None, :]), first[:-1])
    for n, axes in ((2, np.array([[0, 1, 0], [-1, 0, 0]])), (3, np.eye(3))):  # see ``spins.basis``
        at = np.flatnonzero(n_rot == n)
        dofs_of = start[at][:, None] + 3 + np.arange(n)
        yield (np.repeat(dofs_of, n, axis=1).ravel(), np.tile(dofs_of, (1, n)).ravel(),
               (axes @ J[at] @ axes.T).ravel())


def _no_inertia(system):
    """The same of one, where places alone are asked for."""
    turning = np.setdiff1d(np.arange(system.numbering.n_dof), system.translations)
    yield turning, turning, np.ones(len(turning))
