"""Joints with multipliers and rigid bodies in equilibrium, in small motions about it and where a
motion begins there, against shells that need none, hand statics and bodies on springs."""


from dataclasses import replace

import numpy as np
import pytest
from pandas import read_csv
from scipy.linalg import eigvalsh
from scipy.spatial.transform import Rotation

from corovec import (
    Ball,
    Cylindrical,
    Expression,
    Gravity,
    GroundSpring,
    Hinge,
    InputError,
    Model,
    NodalLoad,
    PointMass,
    Prismatic,
    Revolute,
    RigidBody,
    RigidLink,
    Settings,
    Spherical,
    Support,
    Tie,
    Universal,
    arc_length,
    block,
    buckling,
    cut,
    join,
    load_control,
    modes,
    read,
    simulate,
    solve_linear,
)
from corovec.solver.kernels.arguments import STATIC
from corovec.solver.statics.equilibrium import Equilibrium
from corovec.solver.statics.settings import DEFAULT
from corovec.solver.system.failure import NotConverged
from corovec.solver.system.joints import angle_derivatives
from corovec.solver.system.loads import at_factor
from corovec.solver.system.still_links import StillLinks
from corovec.verification.helpers import in_process
from corovec.verification.suites.exact import EXACT

ALL = ("x", "y", "z", "px", "py", "pz")
G = 9.81
WEIGHT = [Gravity((0.0, 0.0, -G))]


def strip(x, n=4):
    """A strip 1 m wide from x to x + 1."""
    return block(np.array([[x, 0, 0], [x + 1, 0, 0], [x + 1, 1, 0], [x, 1, 0]], float), (n, 4))


def two_strips(joints, gap=0.0, **options):
    """Two clamped strips side by side, or one behind the other, with nodes of their own where they
    meet, under a load at the far corner."""
    one, two = strip(0.0), strip(1.0 + gap)
    mesh = join([one, two], apart=True)
    x, quads = mesh.nodes, mesh.quads
    return shell(x, quads, joints=joints, **options)


def shell(x, quads, load=40.0, both=False, **options):
    end = x[:, 0].max()
    clamped = np.flatnonzero((x[:, 0] < 1e-9) | (both & (x[:, 0] > end - 1e-9)))
    place = np.array([0.75 * end if both else end, 1.0, 0.0])
    corner = int(np.argmin(np.linalg.norm(x - place, axis=1)))
    return Model(x, quads, 0.02, 2e8, 0.3, 1000.0, supports=[Support(clamped.tolist(), ALL)],
                 loads=[NodalLoad(corner, (0.0, 0.0, load))], **options)


def seam():
    """Nodes of the one strip and of the other where they meet."""
    one, two = strip(0.0).nodes, strip(1.0).nodes
    line = np.flatnonzero(np.abs(one[:, 0] - 1.0) < 1e-9)
    nodes = np.flatnonzero(np.abs(two[:, 0] - 1.0) < 1e-9) + len(one)
    return nodes.tolist(), line.tolist()


# ------------------------------------------------------------------ against shells without them

def welded():
    nodes, line = seam()
    whole = block(np.array([[0.0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]]), (8, 4))
    tied = two_strips([Tie(nodes, line)])
    return tied, shell(whole.nodes, whole.quads)


def tip(result):
    return np.linalg.norm(np.reshape(result.displacement, (-1, 3)), axis=1).max()


@pytest.mark.parametrize("solve", [solve_linear, lambda model: load_control(model, [1.0])],
                         ids=["linear", "large"])
def test_tie_is_a_weld(solve):
    """Strips with matching nodes that are tied move as one mesh does; hinged they would not."""
    tied, whole = welded()
    one, other = solve(tied), solve(whole)
    u, v = tip(one), tip(other)
    assert v > 0.3 and abs(u - v) < 1e-8 * v
    nodes, line = seam()
    loose = two_strips([Spherical(pair) for pair in zip(nodes, line)], both=True)
    firm = two_strips([Tie(nodes, line)], both=True)
    assert tip(solve(loose)) > 1.01 * tip(solve(firm))


def test_balls_to_the_ground_are_supports():
    """Nodes on balls to the ground are supported, with the same forces."""
    mesh = block(np.array([[0.0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]]), (8, 4))
    x = mesh.nodes
    far = np.flatnonzero(x[:, 0] > 2 - 1e-9).tolist()
    load = NodalLoad(int(np.argmin(np.linalg.norm(x - [1.5, 1, 0], axis=1))), (0, 0, 40.0))
    clamp = Support(np.flatnonzero(x[:, 0] < 1e-9).tolist(), ALL)
    given = (x, mesh.quads, 0.02, 2e8, 0.3, 1000.0)
    pinned = Support(far, ("x", "y", "z"))
    held = load_control(Model(*given, loads=[load], supports=[clamp, pinned]), [1.0])
    balls = load_control(Model(*given, loads=[load], supports=[clamp], joints=[
        Ball("ground", i) for i in far]), [1.0])
    np.testing.assert_allclose(balls.displacement, held.displacement, atol=1e-9 * tip(held))
    size = np.abs(held.reactions).max()
    assert size > 10.0
    np.testing.assert_allclose(balls.joint_forces[0], held.reactions[0, far], atol=1e-6 * size)
    loose = load_control(Model(*given, loads=[load], supports=[clamp], joints=[
        Ball("ground", far[0])]), [1.0])
    assert tip(loose) > 1.05 * tip(held)


def test_a_small_body_is_a_mass():
    """A body at a node of the middle of an edge, that turns about y alone, weighs as a mass there
    does; its weight is not forgotten."""
    mesh = block(np.array([[0.0, -0.5, 0], [2, -0.5, 0], [2, 0.5, 0], [0, 0.5, 0]]), (6, 2))
    x = mesh.nodes
    clamped = np.flatnonzero(x[:, 0] < 1e-9).tolist()
    middle = int(np.argmin(np.linalg.norm(x - [2.0, 0, 0], axis=1)))

    def moved(mass, **options):
        body = options.get("bodies")
        supports = [Support(clamped, ALL), *([Support([len(x)], ("py",))] if body else ())]
        model = Model.of(mesh, 0.02, 2e8, 0.3, 1000.0, supports=supports, loads=WEIGHT, **options)
        return load_control(model, [1.0]).displacement[-1][:len(x)]

    def body(mass):
        return moved(mass, bodies=[RigidBody("m", mass, (1e-9,) * 3, x[middle], [middle])])

    mass = moved(3.0, attached=[PointMass(middle, 3.0)])
    np.testing.assert_allclose(body(3.0), mass, atol=1e-9 * np.abs(mass).max())
    assert np.abs(body(2.0) - mass).max() > 1e-3 * np.abs(mass).max()


# ------------------------------------------------------------------ hand statics

def small(**options):
    """A plate far away, which is clamped at one edge, and ``options``."""
    mesh = block(np.array([[50.0, 0, 0], [51, 0, 0], [51, 1, 0], [50, 1, 0]]), (2, 1))
    clamped = np.flatnonzero(mesh.nodes[:, 0] < 50.1).tolist()
    return Model.of(mesh, 0.1, 1e6, 0.3, 1e-4, supports=[Support(clamped, ALL)], **options)


def arch(loads=WEIGHT, **more):
    """A three-hinged arch of two bodies, as many constraints as unknowns."""
    bodies = [RigidBody("left", 2.0, (0.1, 0.1, 0.1), (0.5, 0.0, 0.5)),
              RigidBody("right", 5.0, (0.1, 0.1, 0.1), (1.5, 0.0, 0.5))]
    joints = [Revolute("ground", "left", (0, 0, 0), (0, 1, 0), name="foot"),
              Ball("left", "right", (1, 0, 1), name="top"),
              Cylindrical("ground", "right", (2, 0, 0), (0, 1, 0), name="other foot")]
    return small(bodies=bodies, joints=joints, loads=loads, **more)


def test_three_hinged_arch():
    left, right = 2.0 * G, 5.0 * G
    V = (1.5 * left + 0.5 * right) / 2.0
    H = V - 0.5 * left
    wanted = [(H, 0, V), (H, 0, V - left), (-H, 0, left + right - V)]
    for result in (load_control(arch(), [1.0]), solve_linear(arch())):
        forces = result.joint_forces.reshape(-1, 3, 3)[-1]
        np.testing.assert_allclose(forces, wanted, atol=1e-9)
        assert np.max(result.balance) < 1e-12
    result = load_control(arch(), [1.0])
    np.testing.assert_allclose(result.reactions.sum(axis=(0, 1)), (0, 0, 1e-5 * G), atol=1e-9)
    for of in (result, solve_linear(arch())):
        np.testing.assert_allclose(np.squeeze(of.reaction), -result.load[-1], atol=1e-9)
        np.testing.assert_allclose(np.squeeze(of.reaction_moment), -result.load_moment[-1],
                                   rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(result.load[-1], (0.0, 0.0, -left - right - 1e-5 * G), rtol=1e-12)
    np.testing.assert_allclose(result.reaction_moment[-1],
                               -result.load_moment[-1], rtol=1e-9, atol=1e-9)


def beam(joint, force):
    body = RigidBody("beam", 1.0, (0.1, 0.1, 0.1), (1.0, 0.0, 0.0))
    return small(bodies=[body], joints=[joint], loads=[NodalLoad(6, force)])


def test_revolute_with_a_spring():
    """The moment ``k (phi - rest)`` carries a force at an arm that turns: 1 rad and more."""
    k, rest, F = 5.0, 0.2, 9.0
    model = beam(Revolute("ground", "beam", (0, 0, 0), (0, -1, 0), stiffness=k, rest=rest,
                          name="root"), (0.0, 0.0, F))
    result = load_control(model, [0.5, 1.0])
    angle = result.joint_angles[-1, 0]
    assert 1.0 < angle < 1.5 and abs(k * (angle - rest) - F * np.cos(angle)) < 1e-9 * F
    assert result.joint_moments[-1, 0] == pytest.approx(-F * np.cos(angle), rel=1e-9)
    np.testing.assert_allclose(result.joint_forces[-1, 0], (0.0, 0.0, -F), atol=1e-9)
    linear = solve_linear(model)
    assert linear.displacement[6, 2] == pytest.approx(rest + F / k, rel=1e-12)
    assert linear.joint_moments[0] == pytest.approx(-F, rel=1e-12)


def test_stops():
    """A stop takes what is beyond it, with the spring."""
    stopped = Revolute("ground", "beam", (0, 0, 0), (0, -1, 0), stiffness=2.0,
                       stops=(-0.1, 0.3), stop_stiffness=100.0)
    result = load_control(beam(stopped, (0.0, 0.0, 9.0)), [1.0])
    angle = result.joint_angles[-1, 0]
    assert 100.0 * (angle - 0.3) + 2.0 * angle == pytest.approx(9.0 * np.cos(angle), rel=1e-9)


@pytest.mark.parametrize("driving, wanted", [({}, (0.4, 0.8)),
                                             ({"driving": Expression("t**2")}, (0.2, 0.8))])
def test_drives_follow_the_load_factor(driving, wanted):
    model = beam(Revolute("ground", "beam", (0, 0, 0), (0, -1, 0), 0.8, **driving), (0, 0, 2.0))
    result = load_control(model, [0.5, 1.0])
    np.testing.assert_allclose(result.joint_angles[:, 0], wanted, atol=1e-12)
    np.testing.assert_allclose(result.joint_moments[:, 0],
                               [-f * 2.0 * np.cos(angle) for f, angle in zip((0.5, 1.0), wanted)],
                               rtol=1e-9)
    with pytest.raises(InputError, match="arc length cannot drive joints"):
        arc_length(model, 0.1, lambda factor, u: True)


def test_a_clamped_node_tells_the_moment_of_its_joint():
    """A body that a revolute joint holds at a clamped node of a shell, next to weightless: the
    support carries both."""
    mesh = strip(0.0)
    node = 4
    at = mesh.nodes[node] + [0.3, 0.0, 0.1]
    body = RigidBody("arm", 2.0, (0.1, 0.1, 0.1), at)
    joint = Revolute(node, "arm", None, (0, 0, 1))
    model = Model.of(mesh, 0.02, 2e8, 0.3, 1e-6, bodies=[body], joints=[
        joint, RigidLink("ground", "arm", at + [0.0, 1.0, 0.0], at)], loads=WEIGHT,
        supports=[Support([0, node], ALL)])
    result = load_control(model, [1.0])
    assert max(result.balance) < 1e-9
    np.testing.assert_allclose(result.reaction_moments[-1][node][1], -0.3 * 2.0 * G, rtol=1e-6)


# ------------------------------------------------------------------ convergence

def wing():
    """A strip with a heavy body at its end, bent by 1 m and more."""
    mesh = strip(0.0, 6)
    end = np.flatnonzero(mesh.nodes[:, 0] > 1 - 1e-9).tolist()
    body = RigidBody("tip", 40.0, (1.0, 1.0, 1.0), (1.5, 0.5, 0.3), end)
    clamped = np.flatnonzero(mesh.nodes[:, 0] < 1e-9).tolist()
    return Model.of(mesh, 0.02, 2e8, 0.3, 1000.0, bodies=[body], loads=[Gravity((0.0, 0, -3.0))],
                    supports=[Support(clamped, ALL)])


def test_convergence_is_quadratic(monkeypatch):
    """The second derivative of constraints is part of the tangent: without it many more
    iterations are needed than there are."""
    result = load_control(wing(), [1.0])
    works = np.array(result.works)
    assert tip(result) > 0.3 and works[-1] < 1e-9 * works[-2]
    whole = StillLinks.second

    def without(self, nodes, iterate):
        forces, self.forces = self.forces, 0.0 * self.forces
        found = whole(self, nodes, iterate)
        self.forces = forces
        return found

    monkeypatch.setattr(StillLinks, "second", without)
    with pytest.raises(NotConverged, match="it converges, slowly"):
        Equilibrium(wing(), DEFAULT).equilibrate(1.0)


def test_second_derivative():
    """The matrix is the derivative of the forces, of what constraints leave free."""
    mesh = strip(0.0, 3)
    x = mesh.nodes
    bodies = [RigidBody(name, 1.0, (0.1,) * 3, (1.3, 1.0, z)) for name, z in (("b", .2), ("c", .6))]
    corner, other = (int(np.argmin(np.linalg.norm(x - [1, y, 0], axis=1))) for y in (1, 0))
    clamped = np.flatnonzero(x[:, 0] < 1e-9).tolist()
    joints = [Universal(corner, "b", None, (0, 0, 1), (0, 1, 0)),
              RigidLink(other, "b", None, (1.5, 0.3, 0.4)),
              RigidLink("ground", "b", (1.9, 1.5, 0.0), (1.4, 1.1, 0.3)),
              Revolute("b", "c", (1.2, 0.9, 0.0), (0.2, 1.0, 0.1), stiffness=60.0)]
    model = Model.of(mesh, 0.02, 2e8, 0.3, 1000.0, bodies=bodies, joints=joints, loads=[
        NodalLoad(len(x) + 1, (1.0, 0.5, -6.0)), NodalLoad(corner, (0, 0, -6.0))],
        supports=[Support(clamped, ALL)])
    equilibrium = Equilibrium(model, DEFAULT)
    system, state = equilibrium.system, equilibrium.state
    equilibrium.equilibrate(1.0)
    equilibrium.lean(1.0)
    equilibrium.assemble(1.0)
    system.factorize()
    basis = system.solver._T
    motion = basis @ np.random.default_rng(1).standard_normal(basis.shape[1])
    motion /= np.abs(motion).max()
    assert np.abs(system.linked.forces).max() > 1.0
    K, step, found = basis.T @ system.solver.times(motion), 1e-5, []
    for sign in (-step, step):
        backup = state.pack()
        system.coordinates.correct(state, equilibrium.place.start, sign * motion)
        equilibrium.assemble(1.0, tangent=False)
        found.append(basis.T @ system.residual.unmasked)
        state.unpack(backup)
        equilibrium.assemble(1.0, tangent=False)
    change = (found[0] - found[1]) / (2.0 * step)
    np.testing.assert_allclose(change, K, atol=1e-6 * np.abs(K).max())


# ------------------------------------------------------------------ small motions, stability

def column(load=1.0, aside=0.0):
    """A body that stands on a revolute joint with a spring, under a load."""
    body = RigidBody("b", 2.0, (0.3, 0.4, 0.5), (1.0, 0.0, 0.7))
    return small(bodies=[body], loads=[NodalLoad(6, (aside, 0.0, -load))], joints=[
        Revolute("ground", "b", (1.0, 0.0, 0.0), (0, 1, 0), stiffness=5.0)])


def test_modes_of_a_body():
    """``omega^2 = (k - F L) / (I + m L^2)``, also in the state under a load."""
    inertia = 0.4 + 2.0 * 0.49
    assert modes(column(), 1).omega[0] == pytest.approx(np.sqrt(5.0 / inertia), rel=1e-9)
    state = load_control(column(), [1.0])
    assert modes(column(), 1, state).omega[0] == pytest.approx(np.sqrt((5.0 - 0.7) / inertia),
                                                               rel=1e-9)
    found = modes(column(), 1)
    np.testing.assert_allclose(found.effective_mass[0, 0], (2.0 * 0.7)**2 / inertia, rtol=1e-9)


def test_modes_of_hinged_plates_under_a_load():
    """Two stiff plates of 8 kg that hang from a support with a spring, pulled aside: angles and
    frequencies of a double pendulum.  The moment of the hinge counts by the second derivatives of
    its angle, without which the first frequency is 3 % off."""
    turning, k, pull, m, h = 20.0, 30.0, 20.0, 8.0, 0.02
    upper, lower = (block([(0, 0, z), (0, 0, z - 1), (0, 0.4, z - 1), (0, 0.4, z)], (1, 1))
                    for z in (0.0, -1.0))
    mesh, nodes, others = cut(join([upper, lower]), (0, 0, -1), (0, 0.4, -1))
    top, foot = mesh.nodes_at(z=0.0), mesh.nodes_at(z=-2.0)
    model = Model.of(mesh, h, 2e13, 0.3, 1000.0, joints=[Hinge(nodes, others, stiffness=k)],
                     supports=[Support(top, ("x", "y", "z", "py"))],
                     attached=[GroundSpring(i, (0, 0, 0), turning / 2.0) for i in top],
                     loads=[NodalLoad(i, (pull / 2.0, 0.0, 0.0)) for i in foot])
    result = load_control(model, [0.5, 1.0])
    x = (mesh.nodes + result.states[-1].displacement)[[top[0], nodes[0], foot[0]]]
    a, b = (np.arctan2(d[0], -d[2]) for d in np.diff(x, axis=0))
    moments = pull * np.cos([a, b]) - turning * np.array([np.sin(a), 0.0])
    np.testing.assert_allclose(moments, k * np.array([a - b, b - a]), atol=1e-4)
    assert 0.9 < a < b
    coupled = np.cos(a - b) / 2
    M = m * np.array([[4 / 3 + h**2 / 12, coupled], [coupled, 1 / 3 + h**2 / 12]])
    K = np.diag(pull * np.sin([a, b]) + [turning * np.cos(a), 0.0])
    K += k * np.array([[1, -1], [-1, 1]])
    wanted = np.sqrt(eigvalsh(K, M))
    np.testing.assert_allclose(modes(model, 2, result).omega, wanted, rtol=1e-5)


def test_second_derivatives_of_an_angle():
    """Against differences, of plates that a hinge has bent aside."""
    z, step = np.random.default_rng(1).normal(size=9), 1e-6

    def phi(z):
        e, a, b = z.reshape(3, 3)
        return np.arctan2(e @ np.cross(a, b) / np.linalg.norm(e), a @ b)

    def slope(function, i):
        return (function(z + step * i) - function(z - step * i)) / (2.0 * step)

    gradient, hessian = angle_derivatives(*z.reshape(3, 3))
    np.testing.assert_allclose(gradient, [slope(phi, i) for i in np.eye(9)], atol=1e-8)
    np.testing.assert_allclose(
        hessian, [slope(lambda z: angle_derivatives(*z.reshape(3, 3))[0], i) for i in np.eye(9)],
        atol=1e-8)


def test_buckling_of_a_column():
    """``F L = k``; beyond it the path bends aside, ``F L sin(phi) = k phi``."""
    assert buckling(column(), 1).factors[0] == pytest.approx(5.0 / 0.7, rel=1e-9)
    path = load_control(column(), [5.0])
    assert path.negative_pivots[-1] == 0
    aside = 1e-3
    path = arc_length(column(aside=aside), 0.1, lambda factor, u: factor > 12.0)
    phi, F = path.joint_angles[:, 0], path.factors
    np.testing.assert_allclose(F * 0.7 * (np.sin(phi) + aside * np.cos(phi)), 5.0 * phi, atol=1e-8)
    assert phi[-1] > 1.0 and np.all(path.negative_pivots[1:] == 0)


def angle_frame(stiffness=None):
    """A column with a beam at its head, welded or on a hinge with a spring; a load at the tip."""
    column = block([(0, 0, 0), (0, 0.2, 0), (0, 0.2, 1), (0, 0, 1)], (1, 6))
    beam = block([(0, 0, 1), (0, 0.2, 1), (1, 0.2, 1), (1, 0, 1)], (1, 6))
    mesh, joints = join([column, beam]), []
    if stiffness:
        mesh, *sides = cut(mesh, (0, 0, 1), (0, 0.2, 1))
        joints = [Hinge(*sides, stiffness=stiffness)]
    return Model.of(mesh, 0.01, 1e9, 0.0, 1000.0, joints=joints, fold_angle=45.0,
                    supports=[Support(mesh.nodes_at(z=0.0), ALL)],
                    loads=[NodalLoad(i, (0.0, 0.0, -1.0)) for i in mesh.nodes_at(x=1.0)])


def test_a_stiff_hinge_that_is_loaded_is_a_weld():
    """Buckling factors about the initial shape and a loaded state, modes there and the path; where
    the moments of hinges were not in the tangents, the second factor was 148 instead of 53."""
    weld, hinge = angle_frame(), angle_frame(1e5)
    np.testing.assert_allclose(buckling(hinge, 3).factors, buckling(weld, 3).factors, rtol=1e-6)
    paths = [load_control(model, (0.5, 1.0)) for model in (weld, hinge)]
    welded, hinged = (modes(model, 3, path).omega for model, path in zip((weld, hinge), paths))
    np.testing.assert_allclose(hinged, welded, rtol=2e-4)
    welded, hinged = (buckling(model, 2, path).factors for model, path in zip((weld, hinge), paths))
    np.testing.assert_allclose(hinged, welded, rtol=2e-4)


@pytest.mark.parametrize("angle", [0.5, 2.5])
def test_a_drive_turns_what_is_not_loaded(angle):
    """A plate on a hub moves as a rigid body, though all works of the iteration are rounding: that
    was taken for a solution without a digit."""
    mesh = block([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], (4, 4))
    hub = RigidBody("hub", 2.0, (0.3, 0.4, 0.5), (-0.1, 0.5, 0.0), mesh.nodes_at(x=0.0))
    model = Model.of(mesh, 0.02, 2e8, 0.3, 1000.0, bodies=[hub], joints=[
        Revolute("ground", "hub", (-0.1, 0.5, 0.0), (0, 0, 1), angle=angle)])
    path = load_control(model, (0.5, 1.0))
    arms = mesh.nodes - (-0.1, 0.5, 0.0)
    turned = Rotation.from_rotvec((0.0, 0.0, angle)).apply(arms)
    np.testing.assert_allclose(path.displacement[-1][:len(arms)], turned - arms, atol=1e-9)
    assert path.strain_energy[-1] < 1e-15


def test_a_hinge_is_slack_where_it_rests():
    """``rest`` turns a free plate by that angle, in a linear step too, where nothing was seen of
    it; no moment is left, and no warning is given."""
    mesh = block([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], (4, 2))
    mesh, *sides = cut(mesh, (1, 0, 0), (1, 1, 0))
    model = Model.of(mesh, 0.02, 2e8, 0.3, 1000.0, joints=[Hinge(*sides, stiffness=5.0, rest=0.6)],
                     supports=[Support(mesh.nodes_at(x=0.0), ALL)])
    tip = mesh.nodes_at(x=2.0)
    linear, path = solve_linear(model), load_control(model, (0.5, 1.0))
    np.testing.assert_allclose(linear.displacement[tip, 2], -0.6, rtol=1e-9)
    np.testing.assert_allclose(path.displacement[-1][tip, 2], -np.sin(0.6), rtol=1e-9)
    np.testing.assert_allclose(path.joint_angles[:, 0], (0.3, 0.6), rtol=1e-9)
    assert abs(linear.joint_moments[0]) < 1e-9 and np.abs(path.joint_moments).max() < 1e-9


def test_linear_moments_of_hinges():
    """``M = P L`` of a load at the tip."""
    mesh = block([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], (4, 2))
    mesh, *sides = cut(mesh, (1, 0, 0), (1, 1, 0))
    model = Model.of(mesh, 0.02, 2e8, 0.3, 1000.0, joints=[Hinge(*sides, stiffness=5.0)],
                     supports=[Support(mesh.nodes_at(x=0.0), ALL)],
                     loads=[NodalLoad(i, (0.0, 0.0, 2.0)) for i in mesh.nodes_at(x=2.0)])
    assert abs(solve_linear(model).joint_moments[0]) == pytest.approx(6.0, rel=1e-9)


def test_the_tangent_of_a_loaded_hinge():
    """Against differences of the residual, in a state where it is bent."""
    equilibrium = Equilibrium(angle_frame(2.0), DEFAULT)
    system = equilibrium.system
    equilibrium.equilibrate(0.5)
    equilibrium.equilibrate(1.0)
    equilibrium.assemble(1.0)
    assert abs(equilibrium.state.hinges[0, 0]) > 0.3
    T, step = system.basis(), 1e-6
    K = T.T @ system.solver.matrix() @ T
    for v in np.random.default_rng(3).normal(size=(3, T.shape[1])):
        way = T @ v / np.abs(T @ v).max()
        ends = []
        for sign in (1.0, -1.0):
            system.assemble(equilibrium.state, equilibrium.place, STATIC, sign * step * way,
                            system.loads_by(at_factor(1.0)), tangent=False)
            ends.append(T.T @ system.residual.balance)
        wanted = (ends[1] - ends[0]) / (2.0 * step)
        found = K @ v / np.abs(T @ v).max()
        assert np.abs(found - wanted).max() < 1e-6 * np.abs(wanted).max()


def test_free_bodies_have_zero_modes():
    """Two plates on a ball joint: six rigid motions and three of the joint."""
    one, two = strip(0.0, 1), strip(1.5, 1)
    mesh = join([one, two], apart=True)
    x, quads = mesh.nodes, mesh.quads
    bodies = [RigidBody("a", 2.0, (0.1,) * 3, (1.1, 0.4, 0), np.flatnonzero(
        np.abs(x[:, 0] - 1.0) < 1e-9).tolist()), RigidBody("b", 2.0, (0.1,) * 3, (1.4, 0.4, 0),
        np.flatnonzero(np.abs(x[:, 0] - 1.5) < 1e-9).tolist())]
    model = Model(np.r_[x, [body.centre for body in bodies]], quads, 0.02, 2e8, 0.3, 1000.0,
                  bodies=bodies, joints=[Ball("a", "b", (1.25, 0.5, 0.0))])
    omega = modes(model, 11).omega
    assert np.abs(omega[:9]).max() < 1e-4 * omega[9]


# ------------------------------------------------------------------ mechanisms

@pytest.mark.parametrize("joint, message", [
    (Ball("ground", "b", (1, 0, 0), name="pin"),
     "3 rigid motions of body b free, rotation about an axis along x, y, z: .* more than pin"),
    (Prismatic("ground", "b", (1, 0, 0), (0, 0, 1)),
     "1 rigid motion of body b free, translation along z: hold"),
    (Revolute("ground", "b", (1, 0, 0), (0, 1, 0), damping=1.0),
     "1 rigid motion of body b free, rotation about an axis along y: hold"),
])
def test_mechanisms_are_named(joint, message):
    body = RigidBody("b", 1.0, (0.1,) * 3, (1.0, 0.0, 0.7))
    with pytest.raises(InputError, match=message):
        load_control(small(bodies=[body], joints=[joint], loads=WEIGHT), [1.0])


def test_a_body_alone_is_a_mechanism():
    body = RigidBody("b", 1.0, (0.1,) * 3, (1.0, 0.0, 0.7))
    with pytest.raises(InputError, match="6 rigid motions of body b free"):
        load_control(small(bodies=[body], loads=WEIGHT), [1.0])


def test_redundant_constraints_are_named():
    body = RigidBody("b", 1.0, (0.1,) * 3, (1.0, 0.0, 0.7))
    joints = [Revolute("ground", "b", (1, 0, 0), (0, 1, 0), name="front", stiffness=1.0),
              Revolute("ground", "b", (1, 1, 0), (0, 1, 0), name="back")]
    with pytest.raises(InputError, match="back, front: 5 of their constraints follow"):
        load_control(small(bodies=[body], joints=joints, loads=WEIGHT), [1.0])


# ------------------------------------------------------------------ paths that go on

def test_a_motion_begins_in_equilibrium():
    """A wing that hangs under its body stays where statics has brought it."""
    model = wing()
    state = load_control(model, [1.0]).states[-1]
    result = simulate(model, Settings(dt=0.02, end_time=0.1, scheme=EXACT), start=state)
    np.testing.assert_allclose(result.displacement, state.displacement, atol=1e-7)


@pytest.mark.parametrize(("model", "factors"), [
    (lambda: column(aside=0.3), [1.0, 2.0, 3.0]),
    (lambda: beam(Revolute("ground", "beam", (0, 0, 0), (0, -1, 0), 9.0), (0.0, 0.0, 2.0)),
     [0.25, 0.5, 0.75, 1.0])], ids=["spring", "beyond half a turn"])
def test_resumed(model, factors, tmp_path):
    """A path that is continued from its file has the rows of one that ran through."""
    model, file = model(), tmp_path / "path.h5"
    whole = load_control(model, factors)
    with pytest.raises(KeyboardInterrupt):
        load_control(model, factors, output=file, progress=_stop_at(factors[-2]))
    resumed = load_control(model, factors, output=file, resume=True)
    for name in ("displacement", "joint_forces", "joint_moments", "joint_couples", "joint_angles"):
        np.testing.assert_allclose(getattr(resumed, name), getattr(whole, name), rtol=1e-9,
                                   atol=1e-9)
    _of_file(file, resumed)


def test_files_of_paths_tell_of_joints(tmp_path, monkeypatch):
    """Of one that grows beyond what it had room for, too; and as tables."""
    monkeypatch.setattr("corovec.solver.statics.arc_length.ROOM", 2)
    path = arc_length(column(aside=1e-3), 0.05, lambda factor, u: factor > 7.5,
                      output=tmp_path / "path.h5")
    assert len(path.factors) > 5
    _of_file(tmp_path / "path.h5", path)
    frame = path.frame()
    np.testing.assert_array_equal(frame["joints.force_0_z"], path.joint_forces[:, 0, 2])
    np.testing.assert_array_equal(frame["joints.angle_0"], path.joint_angles[:, 0])
    table = tmp_path / "path.csv"
    in_process("info", str(tmp_path / "path.h5"), "--csv", str(table))
    written = read_csv(table)
    np.testing.assert_allclose(written["joints.angle_0"][-len(frame):], frame["joints.angle_0"])
    np.testing.assert_allclose(written["reaction_z"][-len(frame):], path.reaction[:, 2])
    told = in_process("info", str(tmp_path / "path.h5"), "--energy").stderr
    assert "is a static path, which has no energies by item" in told


def _of_file(file, result):
    history = read(file)["history"]
    history = history[len(history) - len(result.factors):]
    for column, values in (
            ("joints.force", result.joint_forces), ("joints.moment", result.joint_moments),
            ("joints.couple", result.joint_couples), ("joints.angle", result.joint_angles),
            ("places.angle", result.hinges[..., 0]), ("places.latched", result.hinges[..., 1])):
        np.testing.assert_array_equal(history[column], values)


def _stop_at(at):
    def stop(factor, last):
        if factor >= at:
            raise KeyboardInterrupt
    return stop


@pytest.mark.parametrize("solve", [solve_linear, lambda model: load_control(model, [0.5, 1.0])],
                         ids=["linear", "large"])
def test_supports_that_move_carry_bodies(solve):
    """A strip whose edge is lifted takes its body along; a rod to the ground bends it."""
    mesh = strip(0.0)
    edge, end = (np.flatnonzero(np.abs(mesh.nodes[:, 0] - x) < 1e-9).tolist() for x in (0.0, 1.0))
    body = RigidBody("tip", 2.0, (0.1, 0.1, 0.1), (1.2, 0.5, 0.0), end)
    supports = [Support(edge, ("x", "y", "px", "py", "pz")), Support(edge, ("z",), 0.1)]

    def lifted(*joints):
        model = Model.of(mesh, 0.02, 2e8, 0.3, 1000.0, bodies=[body], supports=supports,
                         joints=joints)
        result = solve(model)
        moved = result.displacement.reshape(-1, len(model.nodes), 3)[-1]
        return moved, result.joint_forces.reshape(-1, 3)

    moved, _ = lifted()
    np.testing.assert_allclose(moved, np.tile([0.0, 0.0, 0.1], (len(moved), 1)), atol=1e-9)
    moved, forces = lifted(RigidLink("ground", "tip", (1.2, 0.5, -9.0), (1.2, 0.5, 0.0)))
    assert abs(moved[-1, 2]) < 1e-3 and moved[0, 2] == pytest.approx(0.1, rel=1e-12)
    assert forces[-1, 2] < -1.0


# ------------------------------------------------------------------ joints that turn further

def servo():
    """A plate on a body that a spring turns by 1.5 turns against the ground."""
    mesh = strip(0.5, 2)
    edge = np.flatnonzero(mesh.nodes[:, 0] < 0.5 + 1e-9).tolist()
    body = RigidBody("b", 10.0, (1.0, 1.0, 1.5), (0.0, 0.5, 0.0), edge)
    joint = Revolute("ground", "b", (0, 0.5, 0), (0, 1, 0), stiffness=40.0, rest=9.0)
    return Model.of(mesh, 0.02, 2e8, 0.3, 1000.0, bodies=[body], joints=[joint])


def folded():
    """The same of a hinge."""
    mesh, *sides = cut(block([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], (4, 2)),
                       (1, 0, 0), (1, 1, 0))
    return Model.of(mesh, 0.02, 2e8, 0.3, 1000.0,
                    supports=[Support(mesh.nodes_at(x=0.0).tolist(), ALL)],
                    joints=[Hinge(*sides, stiffness=40.0, rest=9.0)])


FACTORS = np.linspace(0.1, 1.0, 10)


@pytest.mark.filterwarnings("ignore::corovec.AccuracyWarning")  # nothing acts: all is rounding
@pytest.mark.parametrize("made", [servo, folded])
def test_turns_beyond_half_a_turn(made, tmp_path):
    """A spring that is slack all the way stores nothing, also in a path that goes on and in a
    motion that begins there."""
    model, file = made(), tmp_path / "path.h5"
    whole = load_control(model, FACTORS)
    try:
        load_control(model, FACTORS, output=file, progress=_stop_at(0.9))
    except KeyboardInterrupt:
        pass
    for path in whole, load_control(model, FACTORS, output=file, resume=True):
        np.testing.assert_allclose(path.joint_angles[:, 0], 9.0 * FACTORS, rtol=1e-9)
        assert np.abs(path.joint_moments).max() < 1e-9
        assert np.abs(path.strain_energy).max() < 1e-12
    motion = simulate(model, Settings(dt=0.01, end_time=0.02, scheme=EXACT), start=whole.states[-1])
    assert np.abs(motion.total_energy).max() < 1e-12


@pytest.mark.slow
def test_a_motion_goes_on_with_angles_and_latches():
    """A motion in two parts is that in one: springs are wound as far, latches hold."""
    model = servo()
    joint = replace(model.joints[0], lock=4.0, lock_stiffness=300.0, lock_damping=5.0)
    model = replace(model, thickness=0.1, joints=[joint])
    one, two = (simulate(model, Settings(dt=0.05, end_time=end, scheme=EXACT)) for end in (2, 3))
    assert one.hinges[0, 0] > np.pi and one.hinges[0, 1] == 1.0
    other = simulate(model, Settings(dt=0.05, end_time=1, scheme=EXACT), start=one.state)
    np.testing.assert_allclose(other.total_energy, two.total_energy[40:], rtol=1e-9)
    np.testing.assert_allclose(other.hinges, two.hinges, rtol=1e-8)
    with pytest.raises(InputError, match="start.hinges: angles at 3 places of joints, the model"):
        simulate(model, Settings(dt=0.05, end_time=1, scheme=EXACT),
                 start=one.state._replace(hinges=np.zeros((3, 2))))
