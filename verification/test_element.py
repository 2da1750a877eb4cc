"""The element's local stiffness and its averaged strains (Eqs. 16, 17, 68-70).

The element as a whole is verified by the cases of the suite ``kernel``.
"""

import numpy as np
import pytest
from numba import njit

from corovec.solver.kernels import element as kernel
from corovec.solver.kernels.lanes import WIDTH, lanes, zeros
from corovec.verification import reference_element
from corovec.verification.element_oracle import DERIVATIVES, NU, E, H, constants
from corovec.verification.helpers import relative
from corovec.verification.jets import Jet
from corovec.verification.models import random_quad


@pytest.mark.parametrize("seed", range(4))
def test_local_stiffness_against_oracle(seed):
    """k_T of Eqs. (17), (69) and f_int of (16), (68) in the 17 local variables."""
    rng = np.random.default_rng(seed)
    corners, normals = random_quad(rng)
    c = constants(corners, normals, "stress")
    values = rng.uniform(-0.2, 0.2, 17)
    q = Jet.variables(values)
    t_jet = np.vstack([np.zeros((1, 3)), q[:9].reshape(3, 3)])
    local = np.vstack([np.zeros(3), c["y0"]])
    jet = reference_element.local_energy(t_jet, q[9:].reshape(4, 2), local, H, E, NU)
    t, b, e = values[:9].reshape(3, 3), np.r_[values[2:9:3], values[9:]], np.empty(5)
    B, f, g = np.empty((5, 9)), np.empty((3, 3)), np.empty((4, 2))
    kernel.membrane_strains(c["l"], c["Q"], t, e)
    kernel.local_forces(c["l"], c["Q"], c["k_b"], t, b, e, B, f, g)
    assert relative(np.r_[f.ravel(), g.ravel()], jet.gradient) < DERIVATIVES
    k = np.zeros((17, 17))
    k[:9, :9] = B.T @ B
    w = [2, 5, 8]
    k[np.ix_(w, w)] += np.einsum("s,sij->ij", e, c["Q"])
    bending = [*w, *range(9, 17)]
    k[np.ix_(bending, bending)] += c["k_b"]
    assert relative(k, jet.hessian) < DERIVATIVES
    assert relative(c["k_b"], c["k_b"].T) < 1e-13


@pytest.mark.parametrize("seed", range(4))
def test_averaged_strain_operator_is_exact(seed):
    """Eq. (70): e(t_1) - e(t_0) = B((t_0 + t_1)/2) (t_1 - t_0) for finite changes, because e is
    quadratic; with stresses averaged, not taken at the midpoint, the work is the energy."""
    rng = np.random.default_rng(seed)
    corners, normals = random_quad(rng)
    c = constants(corners, normals, "stress")
    t_0, t_1 = rng.uniform(-0.5, 0.5, (2, 3, 3))
    e_0, e_1, e_mid = np.empty(5), np.empty(5), np.empty(5)
    for t, e in ((t_0, e_0), (t_1, e_1), (0.5 * (t_0 + t_1), e_mid)):
        kernel.membrane_strains(c["l"], c["Q"], t, e)
    B, f, g = np.empty((5, 9)), np.empty((3, 3)), np.empty((4, 2))
    kernel.local_forces(c["l"], c["Q"], c["k_b"], 0.5 * (t_0 + t_1), np.zeros(11),
                        0.5 * (e_0 + e_1), B, f, g)
    change = (t_1 - t_0).ravel()
    assert np.allclose(B @ change, e_1 - e_0, rtol=1e-12, atol=1e-13 * np.abs(e_1).max())
    energy = 0.5 * (e_1 @ e_1 - e_0 @ e_0)
    assert np.isclose(f.ravel() @ change, energy, rtol=1e-12)
    assert abs((B.T @ e_mid) @ change - energy) > 1e-3 * abs(energy)


@njit
def _strains_side_by_side(y, p, y0, r0, l, Q, R, t, b, e):
    kernel.frame(lanes(y), lanes(R))
    kernel.local_variables(lanes(R), lanes(y), lanes(p), lanes(y0), lanes(r0), lanes(t), lanes(b))
    kernel.membrane_strains(lanes(l), lanes(Q), lanes(t), lanes(e))


def test_lanes_compute_what_one_element_does_to_the_last_bit():
    """Vector instructions round every lane as a single number, and nothing is reassociated."""
    rng = np.random.default_rng(5)
    given = [rng.normal(size=(*shape, WIDTH))
             for shape in ((3, 3), (4, 3), (3, 3), (4, 2), (5, 3, 3), (5, 3, 3))]
    shapes = ((3, 3), (3, 3), (11,), (5,))
    together = [zeros(shape) for shape in shapes]
    _strains_side_by_side(*given, *together)
    for v in range(WIDTH):
        y, p, y0, r0, l, Q = (np.ascontiguousarray(array[..., v]) for array in given)
        R, t, b, e = (np.empty(shape) for shape in shapes)
        kernel.frame(y, R)
        kernel.local_variables(R, y, p, y0, r0, t, b)
        kernel.membrane_strains(l, Q, t, e)
        for alone, beside in zip((R, t, b, e), together):
            assert np.array_equal(alone, beside[..., v])
