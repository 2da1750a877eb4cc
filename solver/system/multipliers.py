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
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

from ..kernels import multipliers
from ..kernels.calls import Call
from .damping import consistent_mass
from .failure import NotConverged
from .step_links import StepLinks

SMALL = 1e-8
"""Sine of a change of angle below which its ratio to the sine is one."""


class Multipliers(StepLinks):
    """The constraints of a model in the exact scheme."""

    def __init__(self, system):
        coordinates = system.coordinates
        super().__init__(system, coordinates.initial_frames)
        self._turns = np.zeros_like(self._no_turns)
        self._turn, self._spread = Call(multipliers.turns), Call(multipliers.spread)
        if self:
            self._inverse = inverse_mass(system, self.dofs)
            self._inverse_here = self._inverse[self.dofs]
            G = self._set_values(coordinates.initial_frames)
            self._check(self._mobility(G[:self._hard]))

    def _mean_weights(self):
        """Factors of dc and ds by which the change of each angle in a step is exact, and the
        change: see ``kernels.hinges``."""
        (c_0, s_0), (c_1, s_1) = self._products(self._u[0]), self._products(self._u[1])
        sine, cosine = c_0 * s_1 - s_0 * c_1, c_0 * c_1 + s_0 * s_1
        if np.any(cosine <= 0.0):
            raise NotConverged("a joint turns too far")
        change = np.arctan2(sine, cosine)
        ratio = np.divide(change, sine, where=np.abs(sine) > SMALL, out=1.0 / cosine)
        return -0.5 * ratio * (s_0 + s_1), 0.5 * ratio * (c_0 + c_1), change

    def _mobility(self, G):
        """``G M^-1 G^T``"""
        return G @ self._inverse_here @ G.T

    def begin(self, state, start=None):
        """Start a step from a ``state``: no forces yet."""
        u, d = self._u[0], self._d[0]
        self._place(self._terms, state.x, state.x_low, np.zeros_like(state.x), state.chart, u, d)
        G = self._rows(state.chart, u, d, *self._weights(u))
        self._leave(state, G[:self._hard], self._inverse_here)

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
            NotConverged: a joint turns by a right angle or more in the step.
        """
        state, step, delta = iterate[:3]
        u, d = self._u, self._d
        self._turn(self._nodes, self._local, self._n_rot, state.chart, delta[self.dofs],
                   self._turns)
        self._place(self._terms, state.x, state.x_low, work.dx, work.frames, u[1], d[1])
        *mean, change = self._mean_weights()
        self._G_m = self._rows(state.chart, 0.5 * (u[0] + u[1]), 0.5 * (d[0] + d[1]), *mean)
        self._D = self._rows(state.chart, u[1], d[1], *self._weights(u[1]), self._turns)
        self._miss(state, change, step, driven, slacks, motors)
        rates = 2.0 * step.rate_delta * delta[self.dofs] - state.velocity[self.dofs]
        self._n[:] = self._rates_end(self._rows_end(work.frames), rates, driven)
        at = self._nodes
        self._rate = step.rate_delta
        self._at = (state.x[at] + state.x_low[at], work.dx[at].copy(),
                    state.chart[at], work.frames[at])
        spread = np.zeros(len(self.dofs))
        self._spread(self._nodes, self._local, self._n_rot, state.chart, work.frames,
                     step.rate_delta, self._impulse @ self._n, spread)
        forces[self.dofs] += spread - self._G_m.T @ self.forces

    def parts(self):
        """(n_local,) sums of the magnitudes of all forces of constraints in the last iterate."""
        return np.abs(self._G_m).T @ np.abs(self.forces)

    def _rows_end(self, frames):
        """Gradients (hard, n_local) at the end of the step."""
        u, d = self._u[1], self._d[1]
        return self._rows(frames, u, d, *self._weights(u))[:self._hard]

    def _acting(self, rows):
        """Forces (n_local,) of some rows, and the part of the step after which they act."""
        return zip(self._forces_of(rows), (0.5, 0.0, 1.0))

    def _place_of(self, i, part):
        """(3,) of node i after a part of the step [m]."""
        x, dx, _, _ = self._at
        j = np.searchsorted(self._nodes, i)
        return x[j] + part * dx[j]

    def _torque(self, i, f, part):
        """(3,) moment on node i of forces that act after a part of the step."""
        *_, before, after = self._at
        j, at, n = np.searchsorted(self._nodes, i), self._local[i] + 3, self._n_rot[i]
        axes = before[j] + part * (after[j] - before[j])
        if n == 2:
            axes = np.stack([axes[1], -axes[0]]) / (axes[2] @ axes[2])
        elif part == 0.5:
            axes = before[j]
        return f[at:at + n] @ axes

    def _rows_at(self, state):
        """Gradients (hard, n_local) at a ``state``."""
        self._place(self._terms, state.x, state.x_low, np.zeros_like(state.x), state.chart,
                    self._u[1], self._d[1])
        return self._rows_end(state.chart)

    def _pushed(self, last, first=0.0):
        """(n_dof,) rates by impulses (n_local,) at the end, and the start."""
        return self._inverse @ (first + last)


def inverse_mass(system, dofs, turning=True):
    """(n_dof, n_local) columns of the inverse mass at some unknowns, of what supports leave free;
    turns have the lumped inertia of the exact scheme, or with ``turning=False`` none."""
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
    return found


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
