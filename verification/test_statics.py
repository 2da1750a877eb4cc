"""Statics: loads and their stiffness, load control, arc length, prescribed displacements."""

from dataclasses import replace

import numpy as np
import pytest

from corovec import (
    InputError,
    Model,
    NodalLoad,
    NodalMoment,
    Pressure,
    Settings,
    StaticSettings,
    StepError,
    Support,
    TimeFunction,
    arc_length,
    block,
    join,
    line_load,
    line_moment,
    load_control,
    simulate,
    solve_linear,
    surface_load,
)
from corovec.solver.kernels.arguments import STATIC
from corovec.solver.model.mesh import node_at
from corovec.solver.system.system import System
from corovec.verification.helpers import assemble, central_differences, full_matrix, make_system
from corovec.verification.models import rectangle, warped_patch
from corovec.verification.shells import CLAMPED


def cantilever(length, n, loads, **options):
    """Strip along X, clamped at x = 0; ``loads(nodes, tip nodes)``."""
    plate = rectangle(length, 1.0, n, **options)
    root = tuple(int(i) for i in np.flatnonzero(plate.nodes[:, 0] < 1e-9))
    tip = [int(i) for i in np.flatnonzero(plate.nodes[:, 0] > length - 1e-9)]
    return Model(plate.nodes, plate.quads, plate.thickness, plate.youngs, plate.poisson, 1.0,
                 loads=loads(plate.nodes, tip), supports=[Support(root, CLAMPED)]), tip


BEAM = {"thickness": 0.1, "youngs": 1.2e6, "poisson": 0.0}


def test_linear_solution_of_a_cantilever():
    """Tip deflection PL^3/3EI + shear, and extension PL/EA, of a slender strip."""
    model, tip = cantilever(10.0, (40, 1), lambda X, t: line_load(X, t, (2.0, 0.0, 3.0)), **BEAM)
    displacement, change = solve_linear(model)
    EI, EA, GA = 100.0, 1.2e5, 5.0 / 6.0 * 0.6e6 * 0.1
    # 40 linear elements: the mean curvature is exact at mid-element, error 1/(4 n^2)
    assert np.allclose(displacement[tip, 2], 3.0 * (1000.0 / 3.0 / EI + 10.0 / GA), rtol=2e-4)
    assert np.allclose(displacement[tip, 0], 2.0 * 10.0 / EA, rtol=1e-10)
    assert np.allclose(change[tip, 0], -3.0 * 100.0 / 2.0 / EI, rtol=2e-4)


def test_roll_up_to_a_full_circle_in_ten_steps():
    """End moment 2 pi EI / L: the tip returns to the root (converges to it with the mesh)."""
    ends, moment = [], (0.0, -50.0 * np.pi / 3.0, 0.0)
    for n in (24, 48):
        model, tip = cantilever(12.0, (n, 1), lambda X, t: line_moment(X, t, moment), **BEAM)
        result = load_control(model, np.linspace(0.1, 1.0, 10))
        assert np.all(result.steps == 1) and result.iterations.max() <= 8
        ends.append(result.displacement[-1, tip[0]])
    error = [np.linalg.norm(end - (-12.0, 0.0, 0.0)) for end in ends]
    assert error[1] < 0.02 * 12.0 and error[0] / error[1] > 3.0


def test_symmetric_part_of_the_stiffness_of_moments():
    """K of a moment load against finite differences: what is missing is skew, along the normal (a
    couple on the elements around the node) and across it."""
    rng = np.random.default_rng(0)
    base = warped_patch(rng)
    for along in (False, True):
        node = 5
        p = base.normals[node]
        moment = p * 1e5 if along else np.cross(p, (0.3, -0.5, 0.8)) * 1e5
        model = Model(base.nodes, base.quads, 0.1, 1e6, 0.3, 1.0,
                      loads=[NodalMoment(node, tuple(moment))])
        system = make_system(model)
        state, n = system.initial_state(), system.numbering.n_dof

        def residual(delta, system=system, state=state):
            return assemble(system, state, STATIC, delta, 1.0)

        residual(np.zeros(n))
        K = full_matrix(system)
        J = -central_differences(residual, np.zeros(n), 1e-6)
        assert np.abs(0.5 * (J + J.T) - K).max() < 1e-7 * np.abs(K).max()
        assert np.abs(J - K).max() > 1e-3 * np.abs(K).max()


def test_torque_about_the_normal_of_a_tip():
    """A smooth node has no rotation about its normal: the couple on the elements around it bends a
    strip in its plane, u_y = M L^2/(2 E I), and does nothing else."""
    E, torque = 1.2e6, 10.0
    model, tip = cantilever(10.0, (40, 2), lambda X, t: [NodalMoment(t[1], (0.0, 0.0, torque))],
                            **BEAM)
    assert model.nodes[tip[1], 1] == 0.5
    displacement, change = solve_linear(model)
    exact = torque * 10.0**2 / (2.0 * E * 0.1 / 12.0)
    assert displacement[tip[1], 1] == pytest.approx(exact, rel=1e-3)
    assert np.abs(displacement[:, 2]).max() < 1e-12 * exact and np.abs(change).max() < 1e-12
    result = load_control(model, (0.5, 1.0))
    assert result.iterations.max() <= 4
    assert result.displacement[-1, tip[1], 1] == pytest.approx(exact, rel=2e-3)


def test_pressure_and_its_stiffness():
    """Follower pressure: resultant p A n of a flat plate; K has the symmetric part exactly."""
    plate = rectangle(3.0, 2.0, (4, 3))
    system = make_system(Model(plate.nodes, plate.quads, 0.1, 1e6, 0.3, 1.0,
                               loads=[Pressure(7.0)]))
    state, n = system.initial_state(), system.numbering.n_dof
    assemble(system, state, STATIC, np.zeros(n), 1.0)
    start = system.numbering.start
    force = system.residual.applied[start[:, None] + np.arange(3)].sum(axis=0)
    assert np.allclose(force, (0.0, 0.0, 42.0), atol=1e-12)
    rng = np.random.default_rng(3)
    base = warped_patch(rng)
    model = Model(base.nodes, base.quads, 0.1, 1e6, 0.3, 1.0, loads=[Pressure(3e5)])
    system = make_system(model)
    state, n = system.initial_state(), system.numbering.n_dof

    def residual(delta):
        return assemble(system, state, STATIC, delta, 1.0)

    residual(np.zeros(n))
    K = full_matrix(system)
    J = -central_differences(residual, np.zeros(n), 1e-6)
    scale = np.abs(K).max()
    assert np.abs(0.5 * (J + J.T) - K).max() < 1e-7 * scale
    assert np.abs(J - J.T).max() > 1e-4 * scale


@pytest.mark.parametrize("fold", [False, True], ids=["smooth", "junctions"])
def test_full_tangent_of_loads_that_follow(fold):
    """With its skew part the matrix is the derivative of the residual: pressure on some elements,
    moments along and across a normal, at smooth nodes and at junctions."""
    rng = np.random.default_rng(4)
    base = warped_patch(rng)
    patches = np.arange(len(base.quads)) % 3 // 2 if fold else None
    nodes = base.nodes.copy()
    loads = [Pressure(3e5, elements=(0, 3, 4)), Pressure(-1e5),
             *(NodalMoment(i, tuple(rng.uniform(-1e5, 1e5, 3))) for i in (1, 5, 6))]
    if fold:
        sheet = rectangle(3.0, 2.0, (3, 2)).nodes
        nodes[:, 2] += 2.0 * np.abs(sheet[:, 0] - 2.0)
    model = Model(nodes, base.quads, 0.1, 1e6, 0.3, 1.0, loads=loads, patches=patches,
                  supports=[Support((0,), ("x", "y", "z", "px", "py", "pz"))])
    assert (np.diff(model.directors.first).max() > 1) == fold
    system = System(model, full_tangent=True)
    state, n = system.initial_state(), system.numbering.n_dof
    delta = rng.uniform(-0.02, 0.02, n)
    delta[system.dofs.fixed] = 0.0

    def residual(at):
        return assemble(system, state, STATIC, at, 1.0)

    residual(delta)
    free = ~system.dofs.fixed
    K = system.solver.matrix().toarray()[np.ix_(free, free)]
    J = -central_differences(residual, delta, 1e-6)[np.ix_(free, free)]
    assert np.abs(J - K).max() < 1e-7 * np.abs(K).max()
    assert np.abs(K - K.T).max() > 1e-3 * np.abs(K).max()
    right = rng.normal(size=n)
    system.solver.factor()
    solution = system.solver.solve(right)
    assert np.allclose(system.solver.matrix() @ solution, right, atol=1e-9 * np.abs(right).max())


@pytest.mark.parametrize("load, tip_at", [
    (Pressure(1.5), (-0.456, 8.092)), (Pressure(3.0), (-4.325, 3.331)), ("moment", None)],
    ids=["p = 1.5", "p = 3", "moment"])
def test_loads_that_follow_converge_fast(load, tip_at):
    """A strip of E I = 100 N m^2 and length 10 m, clamped, under a pressure or an end moment across
    its edge, in few iterations: half of the load stiffness makes them linear.  Positions of the tip
    under pressure are those of an elastica; the mesh of 80 elements is within 5e-3 m."""
    model, tip = cantilever(10.0, (80, 1), lambda X, t: line_moment(X, t, (20.0, -20.0, 0.0)),
                            **BEAM)
    if tip_at:
        model = replace(model, loads=[load])
    result = load_control(model, np.linspace(0.1, 1.0, 10))
    assert np.all(result.steps == 1) and result.iterations.max() <= 12
    if tip_at:
        end = model.nodes[tip[0]] + result.displacement[-1, tip[0]]
        assert np.allclose(end[[0, 2]], tip_at, atol=0.02)


def test_arc_length_under_pressure_passes_a_limit_point():
    """A shallow cap, hinged at its rim: the work of the pressure, int p dV by trapezoids over the
    rows, is the strain energy, before and behind the largest pressure."""
    mesh = block([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], (8, 8))
    nodes, quads = mesh.nodes.copy(), mesh.quads
    nodes[:, 2] = 0.1 * (1.0 - nodes[:, 0] ** 2) * (1.0 - nodes[:, 1] ** 2)
    rim = np.flatnonzero(np.isclose(np.abs(nodes[:, :2]).max(axis=1), 1.0))
    crown = int(np.argmax(nodes[:, 2]))
    model = Model(nodes, quads, 0.02, 1e7, 0.3, 1.0, loads=[Pressure(-1000.0)],
                  supports=[Support(tuple(rim), ("x", "y", "z"))])
    path = arc_length(model, 0.02, lambda factor, u: u[crown, 2] < -0.015, max_steps=60)
    largest = int(np.argmax(path.factors))
    assert 3 < largest < len(path.factors) - 2
    assert path.factors[-1] < 0.8 * path.factors[largest]
    corners = (nodes + path.displacement)[:, quads]
    areas = 0.5 * np.cross(corners[:, :, 2] - corners[:, :, 0], corners[:, :, 3] - corners[:, :, 1])
    volume = np.einsum("keic,kec->k", corners, areas) / 12.0
    work = np.r_[0.0, np.cumsum(-1000.0 * 0.5 * (path.factors[1:] + path.factors[:-1])
                                * np.diff(volume))]
    assert np.abs(work - path.strain_energy).max() < 0.01 * path.strain_energy.max()


def test_pressures_that_cancel():
    """Nothing follows the shell then, and the skyline runs."""
    model, tip = cantilever(2.0, (4, 1), lambda X, t: line_load(X, t, (0, 0, 4.0)), **BEAM)
    both = replace(model, loads=[*model.loads, Pressure(1.0), Pressure(-1.0)])
    expected, found = (load_control(m, [1.0]) for m in (model, both))
    assert np.array_equal(found.displacement, expected.displacement)
    assert found.solver == "skyline"


def test_linear_solution_is_linear_in_loads_that_follow():
    """K(0) is that of the unloaded shell: pressures do not stiffen it."""
    model, tip = cantilever(2.0, (4, 1), lambda X, t: [Pressure(1.0)], **BEAM)
    one, _ = solve_linear(model)
    ten, _ = solve_linear(replace(model, loads=[Pressure(10.0)]))
    assert np.abs(ten - 10.0 * one).max() < 1e-9 * np.abs(ten).max()


def test_loads_from_lines_and_surfaces():
    """Consistent nodal forces: resultants and first moments of the distributed loads."""
    plate = rectangle(3.0, 2.0, (5, 4))
    loads = surface_load(plate.nodes, plate.quads, (0.0, 1.0, -2.0))
    forces = np.array([load.force for load in loads])
    where = plate.nodes[[load.node for load in loads]]
    assert np.allclose(forces.sum(axis=0), (0.0, 6.0, -12.0))
    assert np.allclose((where * forces[:, 2:]).sum(axis=0), (-18.0, -12.0, 0.0))
    edge = [int(i) for i in np.flatnonzero(plate.nodes[:, 0] == 0.0)]
    loads = line_load(plate.nodes, edge, (3.0, 0.0, 0.0))
    assert np.isclose(sum(load.force[0] for load in loads), 6.0)
    assert np.isclose(loads[0].force[0], 0.75)
    moments = line_moment(plate.nodes, edge, (0.0, 5.0, 0.0))
    assert np.isclose(sum(load.moment[1] for load in moments), 10.0)


def test_prescribed_displacement_gives_the_force_back():
    """Pushing the tip by the displacement that a load made needs that load as reaction."""
    model, tip = cantilever(10.0, (8, 1), lambda X, t: line_load(X, t, (0, 0, 4.0)), **BEAM)
    loaded = load_control(model, [0.5, 1.0])
    w = float(loaded.displacement[-1, tip[0], 2])
    pushed = Model(model.nodes, model.quads, 0.1, 1.2e6, 0.0, 1.0, supports=[
        *model.supports, Support(tuple(tip), ("z",), displacement=w)])
    result = load_control(pushed, [0.5, 1.0])
    assert np.isclose(result.reactions[-1][tip, 2].sum(), 4.0, rtol=1e-9)
    assert np.allclose(result.displacement[-1], loaded.displacement[-1], atol=1e-8)
    assert np.allclose(result.displacement[0, tip, 2], 0.5 * w)


def test_displacement_prescribed_twice_is_applied_once():
    """Two edges that share a corner may both move it, in the same way."""
    model, tip = cantilever(4.0, (2, 1), lambda X, t: [], **BEAM)
    whole, halves = [tuple(tip)], [tuple(tip), (tip[0],)]
    ends = [load_control(Model(model.nodes, model.quads, 0.1, 1.2e6, 0.0, 1.0, supports=[
        *model.supports, *(Support(nodes, ("z",), displacement=0.1) for nodes in groups)]),
        [1.0]).displacement[-1] for groups in (whole, halves)]
    assert np.array_equal(ends[0], ends[1]) and np.allclose(ends[0][tip, 2], 0.1)


@pytest.mark.filterwarnings("ignore:no load does anything")
@pytest.mark.parametrize("loads", [
    [], [NodalLoad(2, (0.0, 0.0, 0.0))], [NodalLoad(0, (0.0, 0.0, 3.0))],
], ids=["no load", "a zero load", "a load on a support"])
def test_arc_length_without_a_load_is_told(loads):
    model, _ = cantilever(4.0, (2, 1), lambda X, t: loads, **BEAM)
    with pytest.raises(InputError, match="needs a load that is not zero where no support holds"):
        arc_length(model, 1.0, lambda factor, u: True)


def test_load_factor_divides_where_it_must():
    """One huge step is taken all the same; the record says how many steps it took."""
    model, tip = cantilever(10.0, (16, 1), lambda X, t: line_load(X, t, (0, 0, 40.0)), **BEAM)
    settings = StaticSettings(max_iterations=6)
    result = load_control(model, [1.0], settings)
    assert result.steps[0] > 1
    fine = load_control(model, np.linspace(0.05, 1.0, 20))
    assert np.allclose(result.displacement[-1, tip], fine.displacement[-1, tip], atol=1e-7)


def test_arc_length_passes_a_limit_point():
    """A shallow roof snaps through: the load falls and rises again, and each point is in
    equilibrium under load control too."""
    model, apex = roof(4)
    result = arc_length(model, 2.0, until=lambda factor, u: u[apex, 2] < -26.0)
    w = -result.displacement[:, apex, 2]
    assert np.all(np.diff(w) > 0.0)
    falling = np.flatnonzero(np.diff(result.factors) < 0.0)
    assert len(falling) and result.factors[-1] > result.factors[falling[-1]]
    assert result.indefinite > 0
    k = falling[0] // 2
    level = load_control(model, [float(result.factors[k])])
    assert np.allclose(level.displacement[-1], result.displacement[k], atol=1e-6)
    with pytest.raises(StepError, match="no equilibrium found beyond load factor"):
        load_control(model, [0.5, 0.9], StaticSettings(max_divisions=6))


def roof(n, thickness=12.7):
    """Quarter of a hinged cylindrical roof under a central force (Sze, Liu, Lo 2004, 3.8)."""
    angle, x = np.meshgrid(np.linspace(0.0, 0.1, n + 1), np.linspace(0.0, 254.0, n + 1))
    nodes = np.column_stack([x.ravel(), 2540.0 * np.sin(angle.ravel()),
                             2540.0 * (np.cos(angle.ravel()) - 1.0)])
    first = np.array([(n + 1) * j + i for j in range(n) for i in range(n)])
    quads = np.column_stack([first, first + n + 1, first + n + 2, first + 1])
    at = {name: tuple(int(i) for i in np.flatnonzero(mask)) for name, mask in (
        ("x", nodes[:, 0] == 0.0), ("y", nodes[:, 1] == 0.0),
        ("hinge", angle.ravel() == 0.1))}
    supports = [Support(at["x"], ("x", "px")), Support(at["y"], ("y", "py")),
                Support(at["hinge"], ("x", "y", "z"))]
    return Model(nodes, quads, thickness, 3102.75, 0.3, 1.0, supports=supports,
                 loads=[NodalLoad(0, (0.0, 0.0, -750.0))]), 0


def test_skyline_and_dense_agree_in_statics():
    model, tip = cantilever(10.0, (8, 1), lambda X, t: line_load(X, t, (0, 0, 4.0)), **BEAM)
    tips = [load_control(model, [1.0], StaticSettings(solver=solver)).displacement[-1, tip]
            for solver in ("auto", "skyline", "dense")]
    assert np.allclose(tips[0], tips[1], atol=1e-9) and np.allclose(tips[0], tips[2], atol=1e-9)


def test_moments_and_pressure_in_dynamics_balance_their_work():
    """A plate driven by a moment pulse and a pressure pulse: energy equals their work."""
    plate = rectangle(2.0, 1.0, (4, 2), thickness=0.05)
    pulse = TimeFunction((0.0, 0.05, 0.1), (0.0, 1.0, 0.0))
    loads = [NodalMoment(3, (0.5, 1.0, 0.0), pulse), Pressure(30.0, None, pulse)]
    model = Model(plate.nodes, plate.quads, 0.05, 1e6, 0.3, 100.0, loads=loads)
    result = simulate(model, Settings(dt=5e-4, end_time=0.2))
    gap = result.total_energy - result.history["external_work"]
    assert result.total_energy[-1] > 0.1
    assert np.abs(gap).max() < 1e-4 * result.total_energy[-1]


@pytest.mark.parametrize("action, message", [
    (lambda m: load_control(m, [0.5, 0.2]), "factors.*(numbers that ascend|needed)"),
    (lambda m: load_control(m, []), "factors.*(numbers that ascend|needed)"),
    (lambda m: load_control(m, [-1.0]), "factors.*(numbers that ascend|needed)"),
    (lambda m: arc_length(m, 0.0, lambda f, u: True), "length must be positive"),
    (lambda m: arc_length(m, 1.0, None), "until must be a function"),
    (lambda m: arc_length(m, 1.0, 5), "until must be a function"),
    (lambda m: arc_length(m, 1.0, max, max_steps=1.5), "max_steps must be an integer, is 1.5"),
    (lambda m: arc_length(m, 1.0, max, max_steps=0), "max_steps must be at least 1, is 0"),
    (lambda m: arc_length(m, 1.0, max, wanted=0), "wanted must be at least 1, is 0"),
    (lambda m: StaticSettings(tolerance=2.0), "tolerance must lie in"),
    (lambda m: StaticSettings(max_iterations=1), "max_iterations must be at least 2"),
    (lambda m: load_control(m, [1.0], StaticSettings(solver="lu")), "solver 'lu' is unknown"),
])
def test_wrong_use_is_told(action, message):
    model, _ = cantilever(4.0, (2, 1), lambda X, t: line_load(X, t, (0, 0, 1.0)), **BEAM)
    with pytest.raises(InputError, match=message):
        action(model)


def test_a_bracket_held_at_one_node_of_its_fold_is_held():
    """Two plates that meet at an angle: both normals of a clamped junction node are held."""
    wide, tall = (block([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], (2, 2)),
                  block([(0, 0, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1)], (2, 2)))
    mesh = join([wide, tall])
    nodes, quads = mesh.nodes, mesh.quads
    corner = node_at(nodes, (0.0, 0.5, 0.0))
    model = Model(nodes, quads, 0.1, 1e6, 0.3, 1.0, loads=[NodalLoad(8, (0.0, 0.0, 1.0))],
                  supports=[Support((corner,), CLAMPED)])
    assert np.diff(model.directors.first)[corner] == 2
    displacement, _ = solve_linear(model)
    assert np.abs(displacement).max() > 0.0 and np.all(displacement[corner] == 0.0)
    smooth = Model(nodes[:9], quads[:4], 0.1, 1e6, 0.3, 1.0, loads=[NodalLoad(8, (0.0, 0.0, 1.0))],
                   supports=[Support((0,), CLAMPED)])
    with pytest.raises(InputError, match="leave 1 rigid motion of the shell free"):
        solve_linear(smooth)


def test_weight_is_mass_times_g():
    """A warped sheet falls freely under its weight: -g t^2/2 everywhere, without strain; its mass
    is rho h times its true area, that of a corner lifted by half a side 1.7 % above the projected
    one."""
    nodes, quads = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0.5), (0, 1, 0)]), [(0, 1, 2, 3)]
    fine = np.linspace(-1.0, 1.0, 401)[1::2]
    xi, eta = np.meshgrid(fine, fine)
    area = np.mean(np.sqrt(1.0 + (0.25 * (1.0 + eta)) ** 2 + (0.25 * (1.0 + xi)) ** 2))
    g, rho, h = 9.81, 2.0, 0.1
    model = Model(nodes, quads, h, 1e6, 0.3, rho,
                  loads=surface_load(nodes, quads, (0.0, 0.0, -g * rho * h)))
    mass = model.elements.mass.sum()
    assert np.isclose(mass, rho * h * area, rtol=1e-4)
    assert np.isclose(sum(load.force[2] for load in model.loads), -mass * g, rtol=1e-14)
    result = simulate(model, Settings(dt=0.01, end_time=1.0))
    assert np.abs(result.displacement - (0.0, 0.0, -0.5 * g)).max() < 1e-10
    assert result.history["strain_energy"].max() < 1e-20


def test_free_shell_in_statics_is_told():
    """Without supports the tangent is singular: a message, not noise."""
    plate = rectangle(2.0, 1.0, (2, 1))
    model = Model(plate.nodes, plate.quads, 0.1, 1e6, 0.3, 1.0,
                  loads=[NodalLoad(0, (0.0, 0.0, 1.0))])
    for solve in (solve_linear, lambda m: load_control(m, [1.0])):
        with pytest.raises(InputError, match="leave 6 rigid motions of the shell free, "
                           "translation along x, y, z and rotation about an axis along x, y, z: "
                           "hold it by a Support"):
            solve(model)
    hinged = Model(plate.nodes, plate.quads, 0.1, 1e6, 0.3, 1.0,
                   supports=[Support((0, 3), ("x", "y", "z"))])
    with pytest.raises(InputError, match="leave 1 rigid motion of the shell free, "
                       "rotation about an axis along y: hold"):
        solve_linear(hinged)


@pytest.mark.parametrize("supports, motions", [
    ([Support((0,), ("x", "y", "z"))], "3 rigid motions .* free, rotation .* along x, y, z:"),
    ([Support((0, 2, 3), ("z",))],
     "3 rigid motions .* free, translation along x, y and rotation about an axis along z:"),
    ([Support((0, 3), ("x", "y", "z")), Support((2,), ("z",))], None),
    ([Support((0, 5), ("x", "y", "z"))], r"1 rigid .* along \(-?0.894, -?0.447, 0\):"),
])
def test_free_motions_are_named(supports, motions):
    plate = rectangle(2.0, 1.0, (2, 1))
    model = Model(plate.nodes, plate.quads, 0.1, 1e6, 0.3, 1.0, supports=supports)
    if motions is None:
        solve_linear(model)
        return
    with pytest.raises(InputError, match=motions):
        solve_linear(model)


def test_what_cannot_prescribe_displacements():
    """A path along the arc, and a motion whose supports are elsewhere at its start."""
    model, tip = cantilever(4.0, (2, 1), lambda X, t: [], **BEAM)
    pushed = Model(model.nodes, model.quads, 0.1, 1.2e6, 0.0, 1.0, supports=[
        *model.supports, Support(tuple(tip), ("z",), displacement=0.1)])
    with pytest.raises(InputError, match="must start there"):
        simulate(pushed, Settings(dt=0.1, end_time=0.1))
    with pytest.raises(InputError, match="cannot prescribe displacements"):
        arc_length(pushed, 1.0, lambda f, u: True)
