"""Modes and buckling: matrices by finite differences, states, wrong input; stability of paths."""

from dataclasses import replace

import numpy as np
import pytest

from corovec import (
    AccuracyWarning,
    Centrifugal,
    Configuration,
    Hinge,
    InputError,
    Model,
    NodalLoad,
    Pressure,
    ResultFileError,
    Settings,
    StabilityWarning,
    StepError,
    Steps,
    Support,
    TimeFunction,
    arc_length,
    block,
    buckling,
    cut,
    load_control,
    modes,
    read,
    simulate,
)
from corovec.solver.kernels.arguments import STATIC
from corovec.solver.modes.eigen import first_vector, lowest, most_negative
from corovec.solver.modes.matrices import (
    coriolis,
    mass,
    rates_of_places,
    sparse_system,
    stiffness,
)
from corovec.solver.system.linear import diagonal_lu
from corovec.solver.system.loads import unloaded
from corovec.verification.helpers import assemble, central_differences, full_matrix, make_system
from corovec.verification.models import folded, rectangle, warped_patch
from corovec.verification.shells import CLAMPED

SHELLS = {"smooth": lambda: warped_patch(np.random.default_rng(3)), "folded": folded}


def strip(loads=(0.0, 0.0, 0.0), **options):
    """Strip of 4 x 0.5 x 0.05 along X, clamped at x = 0, forces at its tip; and the tip's nodes."""
    plate = rectangle(4.0, 0.5, (8, 1), thickness=0.05, youngs=1e7, **options)
    root, tip = (tuple(np.flatnonzero(plate.nodes[:, 0] == at).tolist()) for at in (0.0, 4.0))
    return replace(plate, supports=[Support(root, CLAMPED)],
                   loads=[NodalLoad(i, loads) for i in tip if any(loads)]), tip


def column():
    """The strip under a thrust, and Euler's load of it."""
    euler = np.pi**2 * 1e7 * 0.5 * 0.05**3 / 12.0 / 64.0
    return strip((-0.5 * euler, 0.0, 0.0), poisson=0.0)[0]


@pytest.mark.parametrize("shell", SHELLS)
def test_centrifugal_stiffness_is_the_derivative_of_the_force(shell):
    """At a state with strains and turned normals, with charts that are not along them."""
    model = replace(SHELLS[shell](), loads=[Centrifugal((3.0, -2.0, 1.0), about=(0.1, 0.2, 0.3))])
    system, bare = make_system(model), make_system(replace(model, loads=()))
    state = system.initial_state()
    at = 0.05 * np.random.default_rng(1).standard_normal(system.numbering.n_dof)

    def force(delta):
        return assemble(system, state, STATIC, delta, 0.0) - assemble(bare, state, STATIC, delta)

    def matrix(of, time):
        assemble(of, state, STATIC, at, time)
        return full_matrix(of)

    K = matrix(system, 0.0) - matrix(bare, None)
    found = -central_differences(lambda d: force(at + d), np.zeros(len(at)), 1e-5)
    # the difference of two matrices 1e5 times as large, and the error of the step squared
    assert np.abs(K - found).max() < 1e-6 * np.abs(found).max()
    assert np.abs(K - K.T).max() < 1e-9 * np.abs(K).max()


@pytest.mark.parametrize("shell", SHELLS)
def test_mass_is_the_second_derivative_of_the_kinetic_energy(shell):
    """T = 1/2 v M v of the observation, and of J: v are rates of the unknowns."""
    model = SHELLS[shell]()
    system = sparse_system(model)
    state = system.initial_state()
    M = mass(system, state, system.observe(state))
    rng = np.random.default_rng(2)
    for _ in range(3):
        state.velocity[:] = rng.standard_normal(len(state.velocity))
        place = system.observe(state)
        expected = 0.5 * state.velocity @ (M @ state.velocity)
        assert place.observed.kinetic == pytest.approx(expected, rel=1e-12)
        rates = (rates_of_places(system, place) @ state.velocity).reshape(-1, 3)
        assert np.allclose(rates[len(model.nodes):], place.start.p_dot, rtol=0.0, atol=1e-12)


def test_coriolis_forces_do_no_work_and_have_the_moment_of_a_turning_frame():
    """G is skew; a body that moves by v has the force 2 m omega x v on it."""
    model, omega, v = SHELLS["folded"](), np.array([0.3, 1.0, -2.0]), np.array([1.0, 2.0, 3.0])
    system = sparse_system(model)
    place = system.observe(system.initial_state())
    G = coriolis(system, place, omega)
    assert abs(G + G.T).max() < 1e-12 * abs(G).max()
    shift = np.zeros(system.numbering.n_dof)
    shift[system.translations] = v
    force = (G @ shift)[system.translations].sum(axis=0)
    assert np.allclose(force, 2.0 * model.mass * np.cross(omega, v), rtol=1e-12)


def test_a_spinning_equilibrium_is_the_steady_motion_of_dynamics():
    """A free strip that starts with the shape and the rates of its equilibrium in the frame that
    turns keeps its energies; from the unstrained shape the strain energy swings."""
    omega = (0.0, 0.0, 20.0)
    plate = rectangle(4.0, 0.5, (8, 1), thickness=0.05, youngs=1e5)
    centre = np.array([2.0, 0.25, 0.0])
    middle, end = (tuple(np.flatnonzero(plate.nodes[:, 0] == at).tolist()) for at in (2.0, 4.0))
    held = replace(plate, nodes=plate.nodes - centre, loads=[Centrifugal(omega)], supports=[
        Support(middle, ("x", "z", "py")), Support(middle[:1], ("y", )), Support(end[:1], ("z",))])
    still = load_control(held, [1.0]).states[-1]
    free = replace(held, loads=(), supports=())

    def swing(u, p):
        x = free.nodes + u
        x = x - x.mean(axis=0)
        start = Configuration(x - free.nodes, p, False, np.cross(omega, x), np.cross(omega, p))
        run = simulate(free, Settings(dt=2e-3, end_time=0.1), start=start)
        return np.ptp(run.history["strain_energy"]), run.history["kinetic_energy"][0]

    moved, kinetic = swing(still.displacement, still.directors)
    from_rest, _ = swing(0.0 * still.displacement, free.normals)
    # the strip stretches by 1.5 %; what held its middle has hardly strained it
    assert moved < 0.02 * from_rest and from_rest > 1e-3 * kinetic


def test_supports_bear_what_is_flung():
    """Reactions of a spinning blade are those of its mass at its centre, ``-m Q x_c``."""
    model, _ = strip()
    omega = np.array([0.0, 0.0, 20.0])
    model = replace(model, loads=[Centrifugal(omega)])
    state = load_control(model, [1.0])
    centre = modes(model, 1, state).centre
    flung = model.mass * np.cross(np.cross(omega, centre), omega)
    assert np.allclose(state.reactions[-1].sum(axis=0), -flung, rtol=1e-9, atol=1e-9)


def test_effective_masses_of_a_state():
    """Rigid modes of a free shell have its mass and inertia, junctions included."""
    model = folded()
    found = modes(model, 6)
    assert np.abs(found.eigenvalues).max() < 1e-6 * modes(model, 7).eigenvalues[6]
    total = found.effective_mass.sum(axis=0)
    assert np.allclose(total, [*[model.mass] * 3, *np.diag(model.inertia)], rtol=1e-9)
    assert np.allclose(found.inertia, model.inertia) and np.allclose(found.centre, model.centre)


def test_modes_are_orthonormal_and_all_of_them_can_be_had():
    """v^T M v = 1; Lanczos and LAPACK agree."""
    model, _ = strip()
    few, every = modes(model, 6), modes(model, 80)
    assert len(every) == 80 and np.all(np.diff(every.eigenvalues) >= 0.0)
    assert np.allclose(few.eigenvalues, every.eigenvalues[:6], rtol=1e-6)
    assert np.allclose(few.strain_energy.sum(axis=1), 0.5 * few.eigenvalues, rtol=1e-9)
    assert list(few.frame().columns[:2]) == ["frequency", "omega"] and "Hz" in repr(few)
    with pytest.raises(InputError, match="n must be 80 at most with 80 free unknowns, is 81"):
        modes(model, 81)


def test_a_state_beyond_buckling_has_a_mode_that_grows():
    """As many eigenvalues are negative as pivots; where the next one is, is not lost."""
    model = column()
    factor = buckling(model).factors[0]
    with pytest.warns(StabilityWarning, match="1 negative pivots"):
        path = load_control(model, [0.9 * factor, 2.0 * factor])
    assert path.negative_pivots.tolist() == [0, 1]
    assert path.frame()["negative_pivots"].tolist() == [0, 1]
    found = modes(model, 3, path)
    assert np.count_nonzero(found.eigenvalues < 0.0) == 1 and found.omega[0] < 0.0
    with pytest.raises(StepError, match="unstable: its tangent has 1 negative"):
        buckling(model, 1, path)


def arch(rise):
    """A shallow hinged arch under a load at its top, and a node there."""
    arch = rectangle(4.0, 0.5, (12, 1), thickness=0.05, youngs=1e7, poisson=0.0)
    nodes = arch.nodes.copy()
    nodes[:, 2] = rise * np.sin(np.pi * nodes[:, 0] / 4.0)
    ends = tuple(np.flatnonzero((nodes[:, 0] == 0.0) | (nodes[:, 0] == 4.0)).tolist())
    top = np.flatnonzero(nodes[:, 0] == 2.0).tolist()
    every = tuple(range(len(nodes)))
    supports = [Support(ends, ("x", "z", "py")), Support(every, ("y", ))]
    return replace(arch, nodes=nodes, normals=None, velocity=None, normal_velocity=None,
                   supports=supports, loads=[NodalLoad(i, (0.0, 0.0, -100.0)) for i in top]), top[0]


def test_a_limit_point_is_no_bifurcation(tmp_path):
    """An arch as high as it is thick snaps through: the number of negative pivots changes where the
    load turns round, without a warning.  A higher one leaves its symmetry before that."""
    file, (low, top) = tmp_path / "arch.h5", arch(0.05)
    path = arc_length(low, 0.02, lambda factor, u: u[top, 2] < -0.11, output=file)
    turns = np.diff(np.sign(np.diff(path.factors))) != 0
    assert turns.sum() == 2 and path.negative_pivots.max() == 1 and path.negative_pivots[-1] == 0
    assert read(file)["history"]["negative_pivots"].tolist() == path.negative_pivots.tolist()
    with pytest.warns(StabilityWarning, match="bifurcation lies before load factor 0.036"):
        arc_length(arch(0.07)[0], 0.02, lambda factor, u: u[top, 2] < -0.08)


def test_switching_goes_on_where_a_run_stopped(tmp_path):
    """A path resumed on the branch is that of one run."""
    model, file = column(), tmp_path / "column.h5"
    tip = int(np.argmax(model.nodes[:, 0]))

    def until(deflection):
        return lambda factor, u: abs(u[tip, 2]) > deflection

    whole = arc_length(model, 2e-4, until(0.4), switch=True)
    arc_length(model, 2e-4, until(0.1), switch=True, output=file)
    resumed = arc_length(model, 2e-4, until(0.4), switch=True, output=file, resume=True)
    assert np.array_equal(whole.factors, resumed.factors)
    assert whole.negative_pivots.max() == 1 and whole.negative_pivots[-1] == 0
    with pytest.raises(ResultFileError, match="switch is True there and False here"):
        arc_length(model, 2e-4, until(0.5), output=file, resume=True)


def test_a_path_over_a_bifurcation_warns():
    model = column()
    factor = buckling(model).factors[0]
    with pytest.warns(StabilityWarning, match="switch=True follows the other branch"):
        arc_length(model, 1e-3, lambda reached, u: reached > 1.2 * factor)


def test_loads_that_follow_the_shell():
    """The stiffness of a pressure is symmetric where the rim is held; else that is told."""
    plate = rectangle(1.0, 1.0, (4, 4), thickness=0.01, youngs=1e7)
    x, y, _ = plate.nodes.T
    rim = tuple(np.flatnonzero((x % 1.0 == 0.0) | (y % 1.0 == 0.0)).tolist())
    clamped = replace(plate, supports=[Support(rim, CLAMPED)], loads=[Pressure(100.0)])
    assert modes(clamped, 1, load_control(clamped, [1.0])).omega > 1.2 * modes(clamped, 1).omega
    left = tuple(np.flatnonzero(x == 0.0).tolist())
    free = replace(clamped, supports=[Support(left, CLAMPED)], loads=[Pressure(0.1)])
    state = load_control(free, [1.0])
    with pytest.warns(AccuracyWarning, match="is not symmetric"):
        modes(free, 1, state)


def test_a_state_that_is_no_equilibrium_is_told():
    model, _ = strip((0.0, 0.0, 1.0))
    state = load_control(model, [1.0])
    with pytest.warns(AccuracyWarning, match="no equilibrium: forces balance to"):
        modes(model, 1, state.states[-1], factor=2.0)


def test_the_initial_shell_bears_no_load():
    """Whatever their functions of time are at t = 0."""
    model, tip = strip()
    sudden = Steps((0.0, 1.0), (1.0, 0.0))
    loaded = replace(model, loads=[NodalLoad(tip[0], (0.0, 0.0, 5.0), sudden),
                                   Centrifugal((0.0, 0.0, 5.0), history=sudden)])
    assert np.array_equal(modes(loaded, 2).eigenvalues, modes(model, 2).eigenvalues)


def test_shapes_for_paraview(tmp_path):
    """Every mode is a field of the nodes in a .vtu file."""
    import meshio
    model, _ = strip()
    found, path = modes(model, 2), tmp_path / "modes.vtu"
    found.write(path)
    mesh = meshio.read(path)
    assert np.array_equal(mesh.cells_dict["quad"], model.quads)
    assert [name.partition(":")[0] for name in mesh.point_data] == ["mode 1", "mode 2"]
    assert np.array_equal(mesh.point_data[found.names()[1]], found.displacement[1])
    with pytest.raises(ResultFileError, match="exists"):
        found.write(path)
    with pytest.raises(InputError, match=r"\.vtu"):
        found.write(tmp_path / "modes.h5")


def test_wrong_input_is_told():
    """Before anything is computed."""
    model, tip = strip((0.0, 0.0, 1.0))
    with pytest.raises(InputError, match="factor is the load factor of a state"):
        modes(model, 1, factor=1.0)
    with pytest.raises(InputError, match="state must be a StaticResult or one of its states"):
        modes(model, 1, 3.0)
    with pytest.raises(InputError, match=r"state.displacement"):
        modes(model, 1, Configuration(np.zeros((3, 3)), model.normals))
    with pytest.raises(InputError, match="n must be"):
        modes(model, 0)
    varying = NodalLoad(tip[0], (1.0, 0.0, 0.0), TimeFunction((0.0, 1.0), (0.0, 1.0)))
    with pytest.raises(InputError, match="buckling needs loads .* without a history"):
        buckling(replace(model, loads=[varying]))
    with pytest.raises(InputError, match="buckling needs a load that is not zero"):
        buckling(replace(model, loads=()))
    spun = replace(model, loads=[Centrifugal((0.0, 0.0, 1.0))])
    with pytest.raises(InputError, match="load 0: centrifugal forces are those of a frame"):
        simulate(spun, Settings(dt=0.1, end_time=1.0))
    twice = replace(model, loads=[Centrifugal((0.0, 0.0, 1.0))] * 2)
    with pytest.raises(InputError, match="2 centrifugal loads are there"):
        modes(twice, 1, Configuration(np.zeros_like(model.nodes), model.normals))


def test_lowest_moves_its_shift():
    """Eigenvalues far below the first shift are found all the same."""
    from scipy.sparse import diags
    values = np.r_[-1e4, np.arange(1.0, 60.0)]
    found, _ = lowest(diags(values, format="csc"), diags(np.ones(60), format="csc"), 3, 1e-3)
    assert np.allclose(found, (-1e4, 1.0, 2.0))


def test_what_is_not_negative_is_not_critical():
    """A geometric stiffness that stiffens, and rounding beside it."""
    from scipy.sparse import diags
    unit = diags(np.ones(60), format="csc")
    for values, found in ((np.arange(60.0), []), (np.r_[-1e-12, np.arange(59.0)], []),
                          (np.r_[-2.0, np.arange(59.0)], [-2.0])):
        assert np.allclose(most_negative(diags(values, format="csc"), unit, 2, np.copy)[0], found)


def test_free_dofs_are_those_of_no_support():
    model, _ = strip()
    system = sparse_system(model)
    assert system.basis().shape[1] == 80 == np.count_nonzero(~system.dofs.fixed)


def test_frequencies_of_thin_shells():
    """The factorization without exchanges is that of a positive definite matrix, in which nothing
    grows.  One step of iterative refinement would do harm: residuals of the same precision are
    rounding alone here, and a frequency of the free plate moves by 2e-3."""
    thick, thin = (modes(rectangle(2.0, 1.0, (16, 8), thickness=h, youngs=2e11), 12).omega[6:] / h
                   for h in (3e-3, 1e-4))
    assert np.abs(thin / thick - 1.0).max() < 2e-4  # (h/L)^2 of the thick one: 6e-5
    system = sparse_system(rectangle(2.0, 1.0, (16, 8), thickness=1e-4, youngs=2e11))
    state = system.initial_state()
    place = system.observe(state)
    M = mass(system, state, place)
    K = stiffness(system, state, place, system.loads_by(unloaded))
    A = K + M  # of eigenvalues 1 and more
    factor, negative = diagonal_lu(A)
    b = first_vector(A)
    x = factor.solve(b)
    assert negative == 0 and np.abs(factor.U.data).max() <= np.abs(A.data).max() * (1.0 + 1e-12)
    assert np.abs(A @ x - b).max() < 1e-15 * np.abs(A.data).max() * np.abs(x).max()


def test_a_stiff_hinge_has_the_modes_of_the_plate_without_it():
    """Its stiffness is none of the mass, and one of no stiffness lets the plate turn freely."""
    mesh = block([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], (8, 2))
    opened, *sides = cut(mesh, (1, 0, 0), (1, 1, 0))

    def frequencies(mesh, joints=()):
        held = Support(mesh.nodes_at(x=0.0), ("x", "y", "z", "px", "py", "pz"))
        return modes(Model.of(mesh, 0.02, 1e8, 0.3, 300.0, joints=joints, supports=[held]),
                     4).frequencies

    whole = frequencies(mesh)
    # bending moments along the hinge are spread by its length, not by the element's own shape
    stiff = frequencies(opened, [Hinge(*sides, stiffness=1e8)])
    np.testing.assert_allclose(stiff, whole, rtol=1e-3)
    soft = frequencies(opened, [Hinge(*sides, stiffness=50.0)])
    assert 0.5 * whole[0] < soft[0] < 0.95 * whole[0]
    assert abs(frequencies(opened, [Hinge(*sides)])[0]) < 1e-4
