"""Drag of a medium on elements: forces against their velocity along their normals, quadratic.

``F = -s |w| w a / |a|^2`` of an element, a quarter at each node, with its vector area
``a = 1/2 (x_3 - x_1) x (x_4 - x_2)``, ``w = a . (v - u)``, v the mean of the velocities of its
nodes, u that of the medium, s half the density times the coefficient: ``-s A |v_n| v_n n``.  All is
taken at the generalized midpoint; where the velocity there is dx/dt the work ``F . dx`` in a medium
at rest is ``-s dt |w|^3 / |a|^2``.

Its derivative by the velocities is symmetric and positive, ``2 s |w| a a^T / |a|^2``; that by the
positions is not symmetric.
"""

from typing import NamedTuple

import numpy as np

from .jit import internal, kernel
from .pressure import relative_positions
from .storage import add_cell
from .vectors import cross, dot


class Plate(NamedTuple):
    """An element in a medium.

    Attributes:
        y: (3, 3) nodes 2..4 relative to node 1 [m].
        one: (3,) first diagonal [m].
        two: (3,) second diagonal [m].
        area: (3,) vector area a [m^2].
        v: (3,) velocity relative to the medium [m/s].
    """

    y: np.ndarray
    one: np.ndarray
    two: np.ndarray
    area: np.ndarray
    v: np.ndarray


@internal
def _plate():
    return Plate(np.empty((3, 3)), np.empty(3), np.empty(3), np.empty(3), np.empty(3))


@internal
def _place(quad, nodes, motion, delta, step, medium, plate):
    """The plate of an element at the generalized midpoint."""
    relative_positions(quad, nodes, motion, delta, 1.0 - step.alpha_f, plate.y)
    for c in range(3):
        plate.one[c] = plate.y[1, c]
        plate.two[c] = plate.y[2, c] - plate.y[0, c]
        plate.v[c] = -medium[c]
        for i in range(4):
            at = nodes.start[quad[i]] + c
            plate.v[c] += 0.25 * (step.rate_delta * delta[at]
                                  - step.rate_velocity * motion.velocity[at]
                                  - step.rate_acceleration * motion.acceleration[at])
    cross(plate.one, plate.two, plate.area)
    for c in range(3):
        plate.area[c] *= 0.5


@kernel
def add_drag_forces(nodes, quads, strengths, media, motion, delta, step, forces):
    """Add the forces on quads (n, 4) of ``strengths`` s (n,) [kg/m^3], in media of velocities
    (n, 3) [m/s], to ``forces`` (n_dof,)."""
    plate = _plate()
    for k in range(quads.shape[0]):
        _place(quads[k], nodes, motion, delta, step, media[k], plate)
        square, w = dot(plate.area, plate.area), dot(plate.area, plate.v)
        if square == 0.0:
            continue
        size = -0.25 * strengths[k] * abs(w) * w / square
        for i in range(4):
            for c in range(3):
                forces[nodes.start[quads[k, i]] + c] += size * plate.area[c]


@kernel
def add_drag_matrix(dofs, storage, quads, strengths, media, motion, delta, step, values, skew):
    """Add ``-dF/d(delta)`` to the symmetric part of a matrix, and to the skew part if it has one.

    ``dF = -s/|a|^2 (2 |w| a (a . dv + v . da) + |w| w (da - 2 a (a . da)/|a|^2))``
    """
    plate, k_d = _plate(), np.empty((4, 3, 4, 3))
    e, da = np.zeros(3), np.empty(3)
    for k in range(quads.shape[0]):
        _place(quads[k], dofs.nodes, motion, delta, step, media[k], plate)
        square, w = dot(plate.area, plate.area), dot(plate.area, plate.v)
        if square == 0.0:
            continue
        size = 0.25 * strengths[k] * abs(w) / square
        for j in range(4):
            for c in range(3):
                e[c] = step.stiffness if j > 1 else -step.stiffness
                if j == 0 or j == 2:
                    cross(e, plate.two, da)
                else:
                    cross(plate.one, e, da)
                e[c] = 0.0
                along, rate = 0.0, 0.25 * step.rate_delta * plate.area[c]
                for r in range(3):
                    da[r] *= 0.5
                    along += plate.area[r] * da[r] / square
                    rate += plate.v[r] * da[r]
                for r in range(3):
                    entry = size * (2.0 * plate.area[r] * rate
                                    + w * (da[r] - 2.0 * along * plate.area[r]))
                    for i in range(4):
                        k_d[i, r, j, c] = entry
        add_cell(dofs, storage, quads[k], (3, 3, 3, 3), k, k_d, values, skew)
