"""The discrete Jacobian of one element from the solver's kernels, and local variables written down
from the paper to compare it with."""

import numpy as np
from scipy.spatial.transform import Rotation

from corovec.solver.kernels import discrete

from . import reference_element
from .models import random_quad

STRAIN, TURN = 0.3, 1.0
"""Strains of a random step's ends, and the angle between them [rad]."""


def random_step(rng):
    """An initial element (X, P), warped and distorted, and both ends (x, p) of a step of it; the
    ends are strained by up to ``STRAIN``, each its own way, and turned by ``TURN``."""
    X, P = random_quad(rng)
    axis = rng.normal(size=3)
    first = Rotation.random(rng=rng)
    turn = Rotation.from_rotvec(TURN * axis / np.linalg.norm(axis))
    ends = []
    for R in (first, turn * first):
        x, p = (a + rng.uniform(-STRAIN, STRAIN, (4, 3)) for a in (X, P))
        p = p / np.linalg.norm(p, axis=1, keepdims=True)
        ends.append(tuple(np.ascontiguousarray(R.apply(a)) for a in (x, p)))
    return (X, P), *ends


def local_variables(x, p, X, P):
    """(17,) displacements of nodes 2 to 4 and changes of the normals, from the printed equations,
    in the order of the rows of ``jacobian``."""
    t, rotation = reference_element.local_variables(x, p, X, P)
    return np.concatenate([t[1:].ravel(), rotation[:, :2].ravel()])


def invariants():
    """``discrete.Invariants`` of one element, to be filled."""
    return discrete.Invariants(*(np.empty(shape) for shape in ((7, 2), (7, 2), (2, 3), (3,),
                                                               (9,))))


def measured(x, p):
    """``discrete.Invariants`` of an element."""
    found = invariants()
    discrete.measure(np.ascontiguousarray(x[1:] - x[0]), p, found)
    return found


def jacobian(start, end, ends=None):
    """``T_bar`` (17, 24) of a step, its columns x and p of each node; ``ends``: invariants to take
    instead of those of both ends (wrong variants).

    Args:
        start, end: (x, p) of both ends.
    """
    (x_0, p_0), (x_1, p_1) = start, end
    y_0, y_1, p = x_0[1:] - x_0[0], x_1[1:] - x_1[0], 0.5 * (p_0 + p_1)
    work = discrete.ForceWork(*(np.empty(shape) for shape in (
        (2, 3), (2, 3), (2, 3), (3, 3), (3, 3), (3, 3), (3,))))
    before, after = ends or (measured(*start), measured(*end))
    T, f_x, f_p = np.empty((17, 4, 6)), np.empty((4, 3)), np.empty((4, 3))
    for row, force in enumerate(np.eye(17)):
        discrete.force(before, after, 0.5 * (y_0 + y_1), y_1 - y_0, p, force[:9].reshape(3, 3),
                       force[9:].reshape(4, 2), work, f_x, f_p)
        T[row] = np.hstack([f_x, f_p])
    return T.reshape(17, 24)


def increment(start, end):
    """(24,) change of x and p of each node."""
    return np.hstack([b - a for a, b in zip(start, end)]).ravel()


def unbalanced(T, start, end):
    """Sums of the forces and of their moments about the middle of a step, the largest of all rows
    relative to the largest entry of T."""
    x, p = (0.5 * (a + b) for a, b in zip(start, end))
    forces = T.reshape(17, 4, 6)
    moments = np.cross(x - x[0], forces[:, :, :3]) + np.cross(p, forces[:, :, 3:])
    return (np.abs(forces[:, :, :3].sum(axis=1)).max() / np.abs(T).max(),
            np.abs(moments.sum(axis=1)).max() / np.abs(T).max())
