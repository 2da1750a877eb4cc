"""One element from the solver's kernels, and its derivatives from the independent element."""

import numpy as np

from corovec.solver.kernels import element as kernel
from corovec.solver.kernels.tangent import TangentWork, tangent
from corovec.solver.model.constants import element_constants, isotropic

from . import reference_element
from .jets import Jet

H, E, NU = 0.13, 210.0, 0.3
DERIVATIVES = 1e-11
"""Relative: the oracle is exact to rounding, and the entries of K span four orders."""


def constants(corners, normals, membrane="stress", law=None):
    """Constants of one element of the material (H, E, NU), or of a ``Law``, by name."""
    one = np.ones(1)
    law = law or isotropic(H * one, E * one, NU * one)
    arrays = element_constants(corners[None], normals[None], law, one, membrane=membrane,
                               shear="mitc4")
    return {"coupling": np.zeros((0, 8)), **{name: array[0] for name, array in arrays.items()}}


def evaluate(c, x, p, A=None, n_rot=(3, 3, 3, 3)):
    """Energy, force (24,) and tangent (24, 24) in director coordinates from the kernels."""
    y = np.ascontiguousarray(x[1:] - x[0])
    A = np.tile(np.eye(3), (4, 1, 1)) if A is None else A
    n_s = len(c["l"])
    R, t, b, e = np.empty((3, 3)), np.empty((3, 3)), np.empty(11), np.empty(n_s)
    B, f, g = np.empty((n_s, 9)), np.empty((3, 3)), np.empty((4, 2))
    yl, r, f_x, f_p = np.empty((3, 3)), np.empty((4, 3)), np.empty((4, 3)), np.empty((4, 3))
    ke = np.zeros((24, 24))
    diagonals = kernel.frame(y, R)
    kernel.local_variables(R, y, p, c["y0"], c["r0"], t, b)
    kernel.membrane_strains(c["l"], c["Q"], t, e)
    kernel.couple_measures(c["coupling"], b, 1.0, e)
    kernel.local_forces(c["l"], c["Q"], c["k_b"], t, b, e, B, f, g)
    kernel.couple_forces(c["coupling"], e, g)
    kernel.rotated_positions(R, y, p, yl, r)
    kernel.global_forces(R, diagonals, yl, r, f, g, f_x, f_p)
    work = TangentWork(*(np.empty(shape) for shape in (
        (9, 9), (11, 3), (9, 3), (4, 3, 3), (3, 3), (6, 6), (9, 3), (9, 3), (4, 3, 3), (3, 3),
        (11, 11), (9, 8))))
    tangent(R, diagonals, yl, r, f, g, B, e, c["Q"], c["k_b"], c["coupling"], A, np.array(n_rot),
            work, ke)
    ke = np.tril(ke) + np.tril(ke, -1).T
    return kernel.strain_energy(e, c["k_b"], b), np.hstack([f_x, f_p]).ravel(), ke


def oracle(x, p, corners, normals, membrane="stress"):
    """Energy of the independent element with its derivatives, a ``Jet``."""
    q = Jet.variables(np.hstack([x, p]).ravel()).reshape(4, 6)
    return reference_element.energy(q[:, :3], q[:, 3:], corners, normals, H, E, NU, membrane)
