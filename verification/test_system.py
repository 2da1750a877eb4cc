"""The assembled system in rotational variables: K, mass, momenta (Eqs. 37-52, 62-65)."""

import numpy as np
import pytest
from scipy.sparse import csr_array, triu
from scipy.spatial.transform import Rotation

from corovec import Model
from corovec.solver.dynamics.scheme import Scheme
from corovec.solver.kernels.arguments import MASS_ONLY
from corovec.solver.kernels.charts import first_derivatives, second_derivatives
from corovec.solver.system.system import System
from corovec.verification import reference_element
from corovec.verification.helpers import (
    SOLVERS,
    assemble,
    central_differences,
    full_matrix,
    make_system,
    static_system,
)
from corovec.verification.models import rectangle, spinning, warped_patch


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("solver", SOLVERS)
def test_global_tangent_against_finite_differences(seed, solver):
    """K in rotational variables is the derivative of f = dW/dU, in every solver's storage."""
    rng = np.random.default_rng(seed)
    system = make_system(warped_patch(rng), solver)
    state = system.initial_state()
    delta = rng.uniform(-0.05, 0.05, system.numbering.n_dof)
    static_system(system, state, delta)
    K = full_matrix(system)
    K_fd = -central_differences(lambda d: static_system(system, state, d, False), delta, 1e-6)
    scale = np.abs(K).max()
    # rounding eps |f| / step ~ 1e-10 and truncation ~ step^2 of the largest entry, with margin 10
    assert np.abs(K_fd - K).max() < 2e-8 * scale
    assert np.abs(K_fd - K_fd.T).max() < 2e-8 * scale


def test_storages_hold_the_same_matrix():
    """All four storages receive the same entries."""
    rng = np.random.default_rng(5)
    model = warped_patch(rng)
    delta, matrices = None, []
    for solver in SOLVERS:
        system = make_system(model, solver)
        state = system.initial_state()
        delta = rng.uniform(-0.05, 0.05, system.numbering.n_dof) if delta is None else delta
        static_system(system, state, delta)
        matrices.append(full_matrix(system))
    for matrix in matrices[1:]:
        assert np.array_equal(matrix, matrices[0])


def test_mass_matrix_is_the_metric_of_kinetic_energy():
    """1/2 U_dot^T M U_dot with the assembled M (Eqs. 39-41) equals the kinetic energy."""
    rng = np.random.default_rng(3)
    plate = warped_patch(rng)
    normal_velocity = rng.normal(size=plate.nodes.shape)
    normal_velocity -= (np.einsum("ij,ij->i", normal_velocity, plate.normals)[:, None]
                        * plate.normals)
    model = Model(plate.nodes, plate.quads, 0.1, 1e6, 0.3, 2.0,
                  velocity=rng.normal(size=plate.nodes.shape), normal_velocity=normal_velocity)
    system = make_system(model)
    state = system.initial_state()
    kinetic = system.observe(state).observed.kinetic
    assemble(system, state, MASS_ONLY, np.zeros(system.numbering.n_dof))
    M = full_matrix(system)
    assert np.isclose(0.5 * state.velocity @ M @ state.velocity, kinetic, rtol=1e-13)
    assert np.linalg.eigvalsh(M)[0] > 0.0


def test_initial_acceleration_includes_the_convective_term():
    """A stress-free plate set spinning: M Ü + F_m = 0 at t = 0, so p'' = A1 n'' + A2 has nothing
    tangential but is -|p'|^2 p; on a chart where A1^T A2 is not zero, n'' must cancel it."""
    # E = 1: rounding of F_int, eps E h, is small beside the rotary inertia that it is divided by
    rng = np.random.default_rng(6)
    plate, omega = rectangle(3.0, 2.0, (3, 2)), np.array([5.0, 8.0, -3.0])
    turn = Rotation.random(rng=rng).as_matrix()
    base = Model(plate.nodes @ turn.T, plate.quads, 0.1, 1.0, 0.3, 1.0)
    model = spinning(base, omega)
    system = System(model)
    state = system.initial_state()
    start = system.numbering.start
    assert np.abs(state.acceleration[start[:, None] + np.arange(3)]).max() < 1e-8
    for i, triad in enumerate(state.chart):
        p, p_dot = model.normals[i], model.normal_velocity[i]
        A1 = np.zeros((3, 3))
        first_derivatives(p, triad, A1)
        nn, nm, mm = second_derivatives(p, triad)
        p_ddot = A1[:, :2] @ state.acceleration[start[i] + 3:start[i] + 5]
        n_dot = triad[:2] @ p_dot
        p_ddot += n_dot @ [[nn, nm], [nm, mm]] @ n_dot * triad[2]
        assert np.allclose(p_ddot, -(p_dot @ p_dot) * p, atol=1e-8)
    assert np.abs(state.acceleration).max() > 0.05


def test_normals_are_the_mean_of_unit_normals():
    """Eq. (14): unit normals are averaged, whatever the areas: a ridge of a small and a large
    element bisects their angle."""
    slope = np.radians(30.0)
    nodes = np.array([(0, 0, 0), (0.1, 0, 0), (0.1, 1, 0), (0, 1, 0),
                      (0.1 + 5 * np.cos(slope), 0, -5 * np.sin(slope)),
                      (0.1 + 5 * np.cos(slope), 1, -5 * np.sin(slope))])
    model = Model(nodes, np.array([(0, 1, 2, 3), (1, 4, 5, 2)]), 0.1, 1e6, 0.3, 1.0)
    assert np.allclose(model.normals[1], (np.sin(slope / 2), 0.0, np.cos(slope / 2)))
    assert np.allclose(model.normals[4], (np.sin(slope), 0.0, np.cos(slope)))


def test_material_may_vary_by_element():
    """Thickness, E, nu and rho by element: strain and kinetic energy are those of the elements."""
    rng = np.random.default_rng(11)
    base = warped_patch(rng)
    n = len(base.quads)
    h, E, nu, rho = (rng.uniform(*r, n) for r in ((0.05, 0.2), (1e5, 1e6), (0.0, 0.4), (1, 9)))
    model = Model(base.nodes, base.quads, h, E, nu, rho,
                  velocity=np.tile((2.0, 0.0, 0.0), (len(base.nodes), 1)))
    system = System(model)
    state = system.initial_state()
    state.x[:] += rng.uniform(-0.02, 0.02, state.x.shape)
    place = system.observe(state)
    energies = [reference_element.energy(state.x[q], place.start.p[q], model.nodes[q],
                                         model.normals[q], h[k], E[k], nu[k])
                for k, q in enumerate(model.quads)]
    assert np.allclose(place.start.energy, energies, rtol=1e-11)
    assert np.isclose(place.observed.kinetic, 2.0 * system.elements.mass.sum(), rtol=1e-13)


def test_observe_matches_the_oracle_of_strain_energy():
    """Sum of element energies equals the strain energy reported, and is that of the reference."""
    rng = np.random.default_rng(8)
    model = warped_patch(rng)
    system = make_system(model)
    state = system.initial_state()
    delta = rng.uniform(-0.05, 0.05, system.numbering.n_dof)
    system.coordinates.accept(state, Scheme().end(0.1), delta)
    place = system.observe(state)
    total = sum(reference_element.energy(state.x[q], place.start.p[q], model.nodes[q],
                                         model.normals[q], 0.1, 1e6, 0.3) for q in model.quads)
    assert np.isclose(place.observed.strain, total, rtol=1e-12)
    assert np.isclose(place.start.energy.sum(), place.observed.strain, rtol=1e-14)


def test_sparse_pattern_covers_exactly_the_coupled_nodes():
    """SuperLU's pattern is the node graph of the mesh, nothing more."""
    system = make_system(warped_patch(np.random.default_rng(1)), "superlu")
    numbering = system.numbering
    n_nodes = len(numbering.start)
    rows, columns = np.repeat(numbering.cells[0], 4, axis=1), np.tile(numbering.cells[0], (1, 4))
    graph = csr_array((np.ones(rows.size), (rows.ravel(), columns.ravel())),
                      shape=(n_nodes, n_nodes))
    graph.sum_duplicates()
    matrix = system.solver.matrix()
    assert matrix.nnz == 25 * graph.nnz
    assert triu(matrix).nnz == len(system.solver.values)


def test_a_state_is_changed_in_place_only():
    """An array put beside the motion would not be seen by kernels and checkpoints."""
    state = System(rectangle(1.0, 1.0, (1, 1))).initial_state()
    with pytest.raises(AttributeError):
        state.velocity = np.zeros_like(state.velocity)
    packed = state.pack()
    state.velocity[:] = 2.0
    assert np.array_equal(state.motion.velocity, state.velocity)
    state.unpack(packed)
    assert np.all(state.velocity == 0.0)


def test_increments_may_be_strided():
    """What kernels take without looking is made contiguous before."""
    system = System(warped_patch(np.random.default_rng(2)))
    n, step = system.numbering.n_dof, Scheme().midpoint(0.1)
    wide = np.random.default_rng(3).uniform(-0.01, 0.01, (n, 2))
    strided, plain = wide[:, 0], wide[:, 0].copy()
    assert not strided.flags.c_contiguous
    forces, ends = [], []
    for delta in (plain, strided):
        state = system.initial_state()
        place = system.observe(state)
        forces.append(assemble(system, state, step, delta))
        assert system.inside(state, place, step, delta)
        system.coordinates.accept(state, Scheme().end(0.1), delta)
        ends.append(state.pack())
    assert np.array_equal(*forces) and np.array_equal(*ends)
