"""The element against an independent derivative oracle, and its invariances (Eqs. 1-17, 45, 63)."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from solver.element import element_constants
from solver.kernels import element as kernel
from verification import reference_element
from verification.jets import Jet
from verification.models import random_quad, random_state

H, E, NU = 0.13, 210.0, 0.3
DERIVATIVES = 1e-11
"""Relative: the oracle is exact to rounding, and the entries of K span four orders."""


def constants(corners, normals, membrane):
    one = np.ones(1)
    arrays = element_constants(corners[None], normals[None], H * one, E * one, NU * one, one,
                               membrane=membrane, shear="mitc4")
    return {name: array[0] for name, array in arrays.items()}


def evaluate(c, x, p, A=None, n_rot=(3, 3, 3, 3)):
    """Energy, force (24,) and tangent (24, 24) in director coordinates from the kernels."""
    y = np.ascontiguousarray(x[1:] - x[0])
    A = np.tile(np.eye(3), (4, 1, 1)) if A is None else A
    n_s = len(c["l"])
    R, t, b, e = np.empty((3, 3)), np.empty((3, 3)), np.empty(11), np.empty(n_s)
    B, f, g = np.empty((n_s, 9)), np.empty((3, 3)), np.empty((4, 2))
    yl, r, f_x, f_p = np.empty((3, 3)), np.empty((4, 3)), np.empty((4, 3)), np.empty((4, 3))
    ke = np.zeros((24, 24))
    lengths = kernel.frame(y, R)
    kernel.local_variables(R, y, p, c["y0"], c["r0"], t, b)
    kernel.membrane_strains(c["l"], c["Q"], t, e)
    kernel.local_forces(c["l"], c["Q"], c["k_b"], t, b, e, B, f, g)
    kernel.rotated_positions(R, y, p, yl, r)
    kernel.global_forces(R, *lengths, yl, r, f, g, f_x, f_p)
    kernel.tangent(R, *lengths, yl, r, f, g, B, e, c["Q"], c["k_b"], A, np.array(n_rot),
                   kernel.workspace(), ke)
    return kernel.strain_energy(e, c["k_b"], b), np.hstack([f_x, f_p]).ravel(), ke


def oracle(x, p, corners, normals, membrane):
    q = Jet.variables(np.hstack([x, p]).ravel()).reshape(4, 6)
    return reference_element.energy(q[:, :3], q[:, 3:], corners, normals, H, E, NU, membrane)


def relative(ours, reference):
    return np.abs(ours - reference).max() / np.abs(reference).max()


@pytest.mark.parametrize("membrane", ["stress", "strain"])
@pytest.mark.parametrize("seed", range(8))
def test_energy_force_and_tangent_against_oracle(seed, membrane):
    """W, f = dW/dq and K = d2W/dq2 on distorted, warped, finitely rotated, strained elements."""
    rng = np.random.default_rng(seed)
    corners, normals = random_quad(rng)
    x, p = random_state(rng, corners, normals)
    W, f, K = evaluate(constants(corners, normals, membrane), x, p)
    jet = oracle(x, p, corners, normals, membrane)
    assert abs(W / jet.value - 1.0) < DERIVATIVES
    assert relative(f, jet.gradient) < DERIVATIVES
    assert relative(K, jet.hessian) < DERIVATIVES


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


@pytest.mark.parametrize("seed", range(4))
def test_symmetry(seed):
    """K of Eq. (63) is symmetric: finite differences of the force, which know nothing of symmetry,
    give it from either side; the assembled array is symmetric to 1e-13."""
    rng = np.random.default_rng(seed)
    corners, normals = random_quad(rng)
    x, p = random_state(rng, corners, normals)
    c = constants(corners, normals, "stress")
    q0, step, K_fd = np.hstack([x, p]).ravel(), 1e-5, np.empty((24, 24))
    for k in range(24):
        ends = []
        for sign in (1.0, -1.0):
            q = q0.copy()
            q[k] += sign * step
            q = q.reshape(4, 6)
            ends.append(evaluate(c, q[:, :3].copy(), q[:, 3:].copy())[1])
        K_fd[:, k] = (ends[0] - ends[1]) / (2.0 * step)
    K = evaluate(c, x, p)[2]
    # central differences: truncation step^2 f''' ~ 1e-9, rounding eps |f| / step ~ 1e-10
    assert relative(K_fd, K_fd.T) < 1e-7
    assert relative(K_fd, K) < 1e-7
    assert relative(K, K.T) < 1e-13


@pytest.mark.parametrize("seed", range(6))
def test_rigid_motion(seed):
    """A rigidly moved stress-free element has no force and, with unit normals, six zero modes."""
    rng = np.random.default_rng(seed)
    corners, normals = random_quad(rng)
    turn = Rotation.random(rng=rng).as_matrix()
    x, p = corners @ turn.T + rng.uniform(-9, 9, 3), normals @ turn.T
    # two directions tangential to each normal: the normals stay of unit length
    A = np.zeros((4, 3, 3))
    for i in range(4):
        A[i, :, :2] = np.linalg.svd(p[i][None])[2][1:].T
    W, f, K = evaluate(constants(corners, normals, "stress"), x, p, A, (2, 2, 2, 2))
    keep = [6 * i + k for i in range(4) for k in range(5)]
    values = np.linalg.eigvalsh(K[np.ix_(keep, keep)])
    assert W < 1e-26 * E
    assert np.abs(f).max() < 1e-12 * E
    assert np.abs(values[:6]).max() < 1e-12 * values[-1]
    # next comes a bending mode, of order h^2 below the largest
    assert values[6] > 1e-4 * values[-1]


@pytest.mark.parametrize("seed", range(4))
def test_frame_indifference(seed):
    """A superposed rigid motion leaves W alone and rotates f and K."""
    rng = np.random.default_rng(seed)
    corners, normals = random_quad(rng)
    x, p = random_state(rng, corners, normals)
    c = constants(corners, normals, "stress")
    turn = Rotation.random(rng=rng).as_matrix()
    W, f, K = evaluate(c, x, p)
    W_r, f_r, K_r = evaluate(c, x @ turn.T + 3.0, p @ turn.T)
    blocks = np.kron(np.eye(8), turn)
    assert abs(W_r / W - 1.0) < 1e-12
    assert relative(f_r, blocks @ f) < 1e-12
    assert relative(K_r, blocks @ K @ blocks.T) < 1e-12


def test_forces_in_equilibrium():
    """Internal forces and couples of one element balance: sum f_x = 0, sum x f_x + p f_p = 0."""
    rng = np.random.default_rng(1)
    corners, normals = random_quad(rng)
    x, p = random_state(rng, corners, normals)
    _, f, _ = evaluate(constants(corners, normals, "stress"), x, p)
    f = f.reshape(4, 6)
    moment = np.cross(x, f[:, :3]).sum(axis=0) + np.cross(p, f[:, 3:]).sum(axis=0)
    size = np.abs(f).max()
    assert np.abs(f[:, :3].sum(axis=0)).max() < 1e-15 * size
    assert np.abs(moment).max() < 1e-13 * size * np.abs(x).max()
