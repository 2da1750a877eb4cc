"""Supports with axes of their own, symmetry planes in any direction, sectors of cyclic shells."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from corovec import (
    Centrifugal,
    Cyclic,
    Drive,
    Gravity,
    InputError,
    Model,
    Newton,
    NodalLoad,
    NodalMoment,
    Pressure,
    ResultFileError,
    Scheme,
    Settings,
    StaticSettings,
    Support,
    TimeFunction,
    arc_length,
    buckling,
    cylinder,
    load_control,
    modes,
    rigid_velocity,
    simulate,
    solve_linear,
    sphere_segment,
    symmetry_plane,
)
from corovec.solver.model.histories import CONSTANT
from corovec.verification.models import rectangle
from corovec.verification.shells import CLAMPED

ANY = Rotation.from_rotvec(np.radians(30.0) * np.array([1.0, 2.0, -2.0]) / 3.0).as_matrix()
ABOUT_Z = Rotation.from_euler("z", 30.0, degrees=True).as_matrix()
EXACT = Settings(dt=2e-3, end_time=0.1, newton=Newton(tolerance=1e-20))
"""Iterations end at rounding errors, so that two models can be compared."""

PULSE = TimeFunction((0.0, 0.02, 0.04), (0.0, 1.0, 0.0))
STEADY = TimeFunction((0.0, 1.0), (0.0, 1.0))


def nodes_at(model, **place):
    """Numbers of the nodes with these coordinates."""
    inside = np.ones(len(model.nodes), dtype=bool)
    for axis, value in place.items():
        inside &= np.abs(model.nodes[:, "xyz".index(axis)] - value) < 1e-9
    return np.flatnonzero(inside).tolist()


def turned(model, Q, motion=0.0):
    """The same model turned by Q, its supports with axes of their own."""
    loads = [replace(load, force=Q @ load.force) if isinstance(load, NodalLoad) else
             replace(load, moment=Q @ load.moment) for load in model.loads]
    supports = [replace(support, axes=Q.T) for support in model.supports]
    return replace(model, nodes=model.nodes @ Q.T, normals=model.normals @ Q.T, loads=loads,
                   supports=supports, velocity=model.velocity @ Q.T)


def rolling_plate(history=STEADY):
    """A plate on two symmetry planes, clamped where they meet, with a corner that is pulled and
    twisted, and another one on a roller."""
    plate = rectangle(2.0, 1.0, (6, 3))
    corner, other = nodes_at(plate, x=2.0, y=1.0)[0], nodes_at(plate, x=2.0, y=0.0)
    return replace(plate, supports=[Support(nodes_at(plate, x=0.0), ("x", "px")),
                                    Support(nodes_at(plate, y=0.0), ("y", "py")),
                                    Support(other, ("z",))],
                   loads=[NodalLoad(corner, (0.0, 10.0, 60.0), history),
                          NodalMoment(corner, (3.0, 2.0, 0.0), history)])


def test_supports_turned_with_the_plate():
    """All of it turned by 30 degrees about some axis: linear, and large displacements."""
    plate = rolling_plate()
    other = turned(plate, ANY)
    one, two = solve_linear(plate), solve_linear(other)
    size = np.abs(one.displacement).max()
    assert np.abs(two.displacement - one.displacement @ ANY.T).max() < 1e-10 * size
    assert np.allclose(two.reactions, one.reactions @ ANY.T, atol=1e-8)
    one, two = (load_control(model, [0.5, 1.0], StaticSettings(tolerance=1e-20))
                for model in (plate, other))
    u = one.displacement[-1]
    assert np.abs(u).max() > 0.2
    assert np.abs(two.displacement[-1] - u @ ANY.T).max() < 1e-10
    assert np.allclose(two.reactions[-1], one.reactions[-1] @ ANY.T, atol=1e-7)
    assert two.balances.max() < 1e-12
    # axes the other way round hold something else
    wrong = replace(other, supports=[replace(s, axes=ANY) for s in plate.supports])
    assert np.abs(solve_linear(wrong).displacement - solve_linear(other).displacement).max() > (
        0.01 * size)


@pytest.mark.parametrize("axes", ["nodal", "global"])
def test_motion_turned_with_the_plate(axes):
    """Turned about its normal, so that its charts are the same from the start.  Axes of an oblique
    support follow the node all the same, which is another discretization of second order."""
    near = 1e-10 if axes == "nodal" else 1e-5
    settings = replace(EXACT, scheme=Scheme(axes=axes))
    plate = rolling_plate(PULSE)
    one, two = (simulate(model, settings) for model in (plate, turned(plate, ABOUT_Z)))
    u = one.displacement
    assert np.abs(u).max() > 0.1
    assert np.abs(two.displacement - u @ ABOUT_Z.T).max() < near
    off = two.history["reaction"] - one.history["reaction"] @ ABOUT_Z.T
    assert np.abs(off).max() < 100.0 * near * np.abs(one.history["reaction"]).max()
    assert np.all(two.history["switches"] <= one.history["switches"])


def test_roller_on_an_inclined_plane():
    """A weight P on a frictionless plane at an angle a is carried by P / cos a, at right angles to
    it, and pushes the guide by P tan a; the roller stays on its plane."""
    angle, force = np.radians(25.0), 0.5
    plane = np.array([np.sin(angle), 0.0, np.cos(angle)])
    strip = rectangle(2.0, 0.2, (8, 1))
    ends = nodes_at(strip, x=0.0), nodes_at(strip, x=2.0)
    axes = plane, (0.0, 1.0, 0.0), np.cross(plane, (0.0, 1.0, 0.0))
    strip = replace(strip, loads=[NodalLoad(node, (0.0, 0.0, -force)) for node in ends[1]],
                    supports=[Support(ends[0], ("x", "y", "px")),
                              Support(ends[1], ("x",), axes=axes)])
    path = load_control(strip, [1.0])
    on_plane = path.reactions[-1][ends[1]]
    assert np.abs(on_plane - 1.0 / np.cos(angle) * force * plane).max() < 1e-9
    assert np.isclose(path.reactions[-1][ends[0], 0].sum(), -2.0 * force * np.tan(angle))
    u = path.displacement[-1][ends[1]]
    assert np.abs(u @ plane).max() < 1e-15 and np.linalg.norm(u, axis=1).min() > 1e-5
    assert path.balances.max() < 1e-9
    linear = solve_linear(strip)
    assert np.abs(linear.reactions[ends[1]] - force / np.cos(angle) * plane).max() < 1e-12


def test_prescribed_along_an_oblique_axis():
    """The edge of a plate is pushed 30 degrees off the global axes, in statics and in motion."""
    rise = TimeFunction((0.0, 0.1), (0.0, 1.0))
    plate = rectangle(2.0, 1.0, (6, 3))
    edges = nodes_at(plate, x=0.0), nodes_at(plate, x=2.0)
    plate = replace(plate, supports=[Support(edges[0], CLAMPED), Support(edges[1], ("y",)),
                                     Support(edges[1], ("z",), 0.3, rise)])
    other = turned(plate, ANY)
    one, two = (load_control(model, [0.05, 0.1], StaticSettings(tolerance=1e-20))
                for model in (plate, other))
    assert np.allclose(one.displacement[-1, edges[1], 2], 0.3)
    assert np.abs(two.displacement[-1] - one.displacement[-1] @ ANY.T).max() < 1e-10
    assert np.allclose(two.reactions[-1], one.reactions[-1] @ ANY.T, atol=1e-6)
    aside = replace(plate, supports=[plate.supports[0], Support(edges[1], ("z",)),
                                     Support(edges[1], ("y",), 0.02, rise)])
    for model in (plate, aside):
        one, two = (simulate(m, EXACT) for m in (model, turned(model, ABOUT_Z)))
        assert np.abs(two.displacement - one.displacement @ ABOUT_Z.T).max() < 1e-10
        assert np.allclose(two.history["support_work"], one.history["support_work"], rtol=1e-9)
        assert two.history["support_work"][-1] > 0.0


@pytest.mark.parametrize("Q", [np.eye(3), ABOUT_Z])
def test_half_a_plate(Q):
    """Cut at a symmetry plane, along the global axes and oblique."""
    def plate(length, divisions, supports):
        whole = rectangle(length, 1.0, (divisions, 2))
        return turned(replace(whole, supports=supports(whole), loads=[
            NodalLoad(node, (0.0, 0.0, 30.0), PULSE) for node in nodes_at(whole, x=0.5)]
            + [NodalLoad(node, (0.0, 0.0, 30.0), PULSE) for node in nodes_at(whole, x=1.5)]), Q)

    def ends(*places):
        return lambda model: [Support(sum((nodes_at(model, x=x) for x in places), []), CLAMPED)]
    whole = plate(2.0, 8, ends(0.0, 2.0))
    half = plate(1.0, 4, ends(0.0))
    middle = np.flatnonzero(np.abs(half.nodes @ Q[:, 0] - 1.0) < 1e-9).tolist()
    half = replace(half, supports=[*half.supports, symmetry_plane(middle, 3.0 * Q[:, 0])])
    same = [int(np.argmin(np.linalg.norm(whole.nodes - x, axis=1))) for x in half.nodes]
    one, two = simulate(whole, EXACT), simulate(half, EXACT)
    assert np.abs(one.displacement).max() > 0.01
    assert np.abs(two.displacement - one.displacement[same]).max() < 1e-10
    assert np.isclose(2.0 * two.history["strain_energy"][-1], one.history["strain_energy"][-1])
    free = replace(half, supports=half.supports[:1])
    assert np.abs(simulate(free, EXACT).displacement - two.displacement).max() > 1e-3


@pytest.mark.parametrize("Q", [np.eye(3), ABOUT_Z, ANY])
def test_symmetry_plane_through_a_fold(Q):
    """Half of an angle section, whose junction may turn about the plane's normal only."""
    def angle(widths):
        nodes = [(min(0.5 * k - 1.0, 0.0), y, max(0.5 * k - 1.0, 0.0))
                 for k in range(5) for y in widths]
        n = len(widths)
        quads = [(n * i + j, n * i + n + j, n * i + n + 1 + j, n * i + 1 + j)
                 for i in range(4) for j in range(n - 1)]
        loads = [NodalLoad(4 * n + j, (20.0, 0.0, 5.0), PULSE) for j in range(n)]
        model = Model(np.array(nodes), np.array(quads), 0.05, 1e6, 0.25, 10.0)
        clamped = nodes_at(model, x=-1.0)
        return model, loads, clamped

    model, loads, clamped = angle([0.0, 0.5, 1.0, 1.5, 2.0])
    whole = turned(replace(model, loads=loads, supports=[Support(clamped, CLAMPED)]), Q)
    model, loads, clamped = angle([0.0, 0.5, 1.0])
    middle = nodes_at(model, y=1.0)
    half = [*loads[:-1], replace(loads[-1], force=(10.0, 0.0, 2.5))]
    half = turned(replace(model, loads=half, supports=[
        Support(clamped, CLAMPED), Support(middle, ("y", "py"))]), Q)
    assert np.any(np.diff(half.directors.first) > 1)
    same = [int(np.argmin(np.linalg.norm(whole.nodes - x, axis=1))) for x in half.nodes]
    settings = StaticSettings(tolerance=1e-20)
    steady = TimeFunction((0.0, 1.0), (0.0, 1.0))
    one, two = (load_control(replace(m, loads=[replace(load, history=steady) for load in m.loads]),
                             [0.5, 1.0], settings) for m in (whole, half))
    assert np.abs(one.displacement).max() > 0.1
    assert np.abs(two.displacement[-1] - one.displacement[-1][same]).max() < 1e-10
    assert two.balances.max() < 1e-11
    one, two = simulate(whole, EXACT), simulate(half, EXACT)
    # the charts of the junctions are others, of the same order in dt
    assert np.abs(two.displacement - one.displacement[same]).max() < (
        1e-4 * np.abs(one.displacement).max())
    assert np.abs(two.normals @ Q[:, 1])[middle].max() < 1e-12


MATERIAL = {"thickness": 0.02, "youngs": 1e7, "poisson": 0.3, "density": 1000.0}


def annulus(mesh):
    """A mesh of a sphere's segment, made flat."""
    return replace(mesh, nodes=mesh.nodes * (1.0, 1.0, 0.0),
                   normals=np.tile((0.0, 0.0, 1.0), (len(mesh.quads), 4, 1)))


def tub(mesh):
    """A mesh of a cylinder of height 1, its upper half made a flat flange: a fold goes round."""
    arms = mesh.nodes * (1.0, 1.0, 0.0)
    above = np.maximum(mesh.nodes[:, 2:] - 0.5, 0.0)
    return replace(mesh, nodes=arms * (1.0 + above) + (0.0, 0.0, 1.0) * (
        mesh.nodes[:, 2:] - above), normals=None)


MESHES = {
    "annulus": lambda n, angle: annulus(sphere_segment(1.0, (20.0, 70.0), (n, 4), angle=angle)),
    "cylinder": lambda n, angle: cylinder(1.0, 1.0, (n, 4), angle=angle),
    "dome": lambda n, angle: sphere_segment(1.0, (20.0, 70.0), (n, 4), angle=angle),
    "tub": lambda n, angle: tub(cylinder(1.0, 1.0, (n, 4), angle=angle)),
}
"""Shells of n elements round an angle, the upper rim with the last nodes."""


def whole_and_sector(shape, history, normals=True):
    """The whole shell and a sector of 30 degrees of it, loads on one node of every sector inside of
    it, on its edges and everywhere; nodes of the whole one that are those of the sector."""
    turns = [Rotation.from_euler("z", 30.0 * k, degrees=True).as_matrix() for k in range(12)]
    models, inner = [], {"annulus": 1.0}.get(shape, 0.0)
    for n, angle, copies, options in ((24, 360.0, turns, {}),
                                      (2, 30.0, turns[:1], {"cyclic": Cyclic(12)})):
        mesh = MESHES[shape](n, angle)
        model = Model.of(mesh, **MATERIAL, **(options if normals else {**options, "normals": None}))
        where = model.nodes[:, 2] + inner * np.hypot(*model.nodes[:, :2].T)
        loads = [Gravity((0.0, 0.0, -9.81), history), Pressure(300.0, None, history)]
        node = model.nodes[len(model.nodes) - (2 if angle == 30.0 else 23)]
        edge = model.nodes[len(model.nodes) - (3 if angle == 30.0 else 24)]
        for R in copies:
            at, on = (int(np.argmin(np.linalg.norm(model.nodes - R @ x, axis=1)))
                      for x in (node, edge))
            loads += [NodalLoad(at, R @ (2.0, 1.0, 0.5), history),
                      NodalMoment(at, R @ (0.1, 0.1, 0.2), history),
                      NodalLoad(on, R @ (-1.0, 0.5, 0.5), history),
                      NodalMoment(on, R @ (-0.1, 0.1, 0.1), history)]
        rim = np.flatnonzero(where < where.min() + 1e-9).tolist()
        models.append(replace(model, loads=loads, supports=[Support(rim, CLAMPED)],
                              **({} if normals else {"normals": None})))
    whole, sector = models
    same = [int(np.argmin(np.linalg.norm(whole.nodes - x, axis=1))) for x in sector.nodes]
    return whole, sector, same


@pytest.mark.parametrize("normals", [True, False])
@pytest.mark.parametrize("shape", MESHES)
def test_sector_in_equilibrium(shape, normals):
    """Twelve sectors are the whole: displacements, energies, reactions; and the balance of one."""
    whole, sector, same = whole_and_sector(shape, STEADY, normals)
    assert np.abs(whole.normals[whole.directors.first[same]]
                  - sector.normals[sector.directors.first[:-1]]).max() < 1e-12
    assert np.any(np.diff(sector.directors.first) > 1) == (shape == "tub")
    one, two = solve_linear(whole), solve_linear(sector)
    u = one.displacement
    assert np.abs(two.displacement - u[same]).max() < 1e-10 * np.abs(u).max()
    settings = StaticSettings(tolerance=1e-20)
    one, two = (load_control(model, [0.5, 1.0], settings) for model in (whole, sector))
    u = one.displacement[-1]
    assert np.abs(u).max() > 1e-4
    assert np.abs(two.displacement[-1] - u[same]).max() < 1e-10 * np.abs(u).max()
    assert np.allclose(12.0 * two.strain_energy, one.strain_energy, rtol=1e-10)
    assert np.allclose(12.0 * two.reactions.sum(axis=1)[:, 2], one.reactions.sum(axis=1)[:, 2])
    assert two.balances.max() < 1e-10
    held = sector.supports[0].nodes
    edges = {*sector.pairs.masters, *sector.pairs.slaves}
    inside = [node for node in held if node not in edges]
    whole_inside = [same[node] for node in inside]
    assert np.allclose(two.reactions[-1][inside], one.reactions[-1][whole_inside], atol=1e-8)
    # what neighbours do to one edge is what this sector does to the other
    R, masters, slaves, _ = sector.pairs
    free = [k for k, node in enumerate(masters) if node not in held]
    off = two.reactions[-1][slaves[free]] + two.reactions[-1][masters[free]] @ R.T
    assert np.abs(off).max() < 1e-8 * np.abs(two.reactions[-1]).max()
    assert np.abs(two.reactions[-1][masters[free]]).max() > 0.1


@pytest.mark.parametrize("shape", MESHES)
def test_sector_in_motion(shape):
    """The same of a motion.  Charts of the whole shell start along global axes, not turned with its
    sectors: equal but for what that changes, of the second order in dt; of a flat one nothing."""
    near = 1e-10 if shape == "annulus" else 1e-6
    whole, sector, same = whole_and_sector(shape, PULSE)
    settings = replace(EXACT, end_time=0.06)
    one, two = simulate(whole, settings), simulate(sector, settings)
    u = one.displacement
    assert np.abs(u).max() > 1e-4
    assert np.abs(two.displacement - u[same]).max() < near * np.abs(u).max()
    for name in ("kinetic_energy", "strain_energy", "external_work"):
        assert np.allclose(12.0 * two.history[name], one.history[name],
                           atol=near * one.history[name].max())
    assert two.balance.forces < 1e-9
    R, masters, slaves, _ = sector.pairs
    assert np.abs(two.displacement[slaves] - two.displacement[masters] @ R.T).max() < 1e-14


def test_sector_that_flies_and_spins():
    """A sector of a free cylinder turns about its axis and moves along it, as the whole one."""
    def flying(n, angle, **options):
        model = Model.of(MESHES["cylinder"](n, angle), **MATERIAL, **options)
        v, rate = rigid_velocity(model, (0.0, 0.0, 0.5), (0.0, 0.0, 10.0))
        return replace(model, velocity=v, normal_velocity=rate,
                       loads=[Pressure(500.0, None, PULSE)])

    whole, sector = flying(24, 360.0), flying(2, 30.0, cyclic=Cyclic(12))
    same = [int(np.argmin(np.linalg.norm(whole.nodes - x, axis=1))) for x in sector.nodes]
    settings = Settings(dt=1e-3, end_time=0.2)
    one, two = simulate(whole, settings), simulate(sector, settings)
    assert np.abs(one.displacement).max() > 1.5
    assert np.abs(two.displacement - one.displacement[same]).max() < 1e-3
    assert np.isclose(12.0 * two.history["kinetic_energy"][-1],
                      one.history["kinetic_energy"][-1], rtol=1e-4)
    assert np.isclose(two.displacement[:, 2].mean(), 0.1, rtol=1e-9)


def test_modes_of_a_sector():
    """Those of the whole shell that all sectors have alike, with what an oblique plane leaves."""
    whole, sector, _ = whole_and_sector("dome", STEADY)
    every, alike = modes(replace(whole, loads=()), 40), modes(replace(sector, loads=()), 3)
    off = np.abs(every.frequencies[:, None] / alike.frequencies - 1.0).min(axis=0)
    assert off[0] < 1e-9
    R, masters, slaves, _ = sector.pairs
    u = alike.displacement[0]
    assert np.abs(u[slaves] - u[masters] @ R.T).max() < 1e-12 * np.abs(u).max()
    plate = rolling_plate()
    one, two = modes(plate, 5), modes(turned(plate, ANY), 5)
    assert np.allclose(one.frequencies, two.frequencies, rtol=1e-9)


@pytest.mark.slow
def test_spinning_sector():
    """Centrifugal forces of a disk, and the mode of its equilibrium that all sectors have alike."""
    found = []
    for n, angle, options in ((24, 360.0, {}), (2, 30.0, {"cyclic": Cyclic(12)})):
        model = Model.of(MESHES["annulus"](n, angle), **MATERIAL, **options,
                         loads=[Centrifugal((0.0, 0.0, 20.0))])
        inner = np.flatnonzero(np.hypot(*model.nodes[:, :2].T) < 0.35).tolist()
        model = replace(model, supports=[Support(inner, CLAMPED)])
        path = load_control(model, [1.0], StaticSettings(tolerance=1e-20))
        found.append((model, path, modes(model, 8 if angle == 360.0 else 1, path)))
    (whole, one, every), (sector, two, alike) = found
    same = [int(np.argmin(np.linalg.norm(whole.nodes - x, axis=1))) for x in sector.nodes]
    u = one.displacement[-1]
    assert np.abs(u).max() > 1e-3
    assert np.abs(two.displacement[-1] - u[same]).max() < 1e-10 * np.abs(u).max()
    assert np.abs(every.frequencies / alike.frequencies - 1.0).min() < 1e-8


def test_buckling_and_arc_length_on_oblique_supports():
    """A column between oblique rollers has the critical load of the one along the axes."""
    strip = rectangle(2.0, 0.1, (12, 1))
    ends = nodes_at(strip, x=0.0), nodes_at(strip, x=2.0)
    strip = replace(strip, supports=[Support(ends[0], CLAMPED), Support(ends[1], ("y",))],
                    loads=[NodalLoad(node, (-1.0, 0.0, 1e-4)) for node in ends[1]])
    other = turned(strip, ANY)
    one, two = buckling(strip), buckling(other)
    assert np.allclose(two.factors, one.factors, rtol=1e-9)
    plate = rolling_plate(CONSTANT)
    paths = [arc_length(model, 0.2, lambda factor, u: factor > 1.0)
             for model in (plate, turned(plate, ANY))]
    assert np.allclose(paths[0].factors, paths[1].factors, rtol=1e-6)


def test_driven_sector():
    """Both rims of a sector, one turned about the axis and lifted: as the whole."""
    rise = TimeFunction((0.0, 1.0), (0.0, 1.0))
    paths = []
    for shape in ("cylinder", "tub"):
        for n, angle, options in ((24, 360.0, {}), (2, 30.0, {"cyclic": Cyclic(12)})):
            model = Model.of(MESHES[shape](n, angle), **MATERIAL, **options)
            rows = len(model.nodes) // 5
            model = replace(model, supports=[
                Support(range(rows), CLAMPED),
                Drive(range(4 * rows, 5 * rows), (0.0, 0.0, 0.05), (0.0, 0.0, 0.1), history=rise)])
            paths.append((model, load_control(model, [0.5, 1.0])))
        (whole, one), (sector, two) = paths[-2:]
        same = [int(np.argmin(np.linalg.norm(whole.nodes - x, axis=1))) for x in sector.nodes]
        u = one.displacement[-1]
        assert np.abs(two.displacement[-1] - u[same]).max() < 1e-6 * np.abs(u).max()
        assert np.isclose(12.0 * two.reaction_moment[-1, 2], one.reaction_moment[-1, 2], rtol=1e-6)


def test_sector_goes_on(tmp_path):
    """A run that was ended is resumed to the same numbers."""
    _, sector, _ = whole_and_sector("tub", PULSE)
    long = Settings(dt=2e-3, end_time=0.04, frame_every=10)
    whole = simulate(sector, long, output=tmp_path / "whole.h5")
    class Stop(Exception):
        pass

    def stop(step, n_steps, row):
        if step == 15:
            raise Stop

    with pytest.raises(Stop):
        simulate(sector, long, output=tmp_path / "part.h5", progress=stop)
    rest = simulate(sector, long, output=tmp_path / "part.h5", resume=True)
    assert np.array_equal(rest.displacement, whole.displacement)
    other = replace(sector, cyclic=Cyclic(12, about=(0.0, 0.0, 1.0)))
    with pytest.raises(ResultFileError, match="other"):
        simulate(other, long, output=tmp_path / "part.h5", resume=True)


def sector_of(shape, **options):
    return Model.of(MESHES[shape](2, 30.0), **MATERIAL, **{"cyclic": Cyclic(12), **options})


@pytest.mark.parametrize("make, told", [
    (lambda: Support((0,), ("x",), axes=((1, 0, 0), (1, 1, 0), (0, 0, 1))), "orthogonal vectors"),
    (lambda: Support((0,), ("x",), axes=((1, 0, 0), (0, 0, 0), (0, 0, 1))), "orthogonal vectors"),
    (lambda: Support((0,), ("x",), axes=(1, 0, 0)), "support: axes"),
    (lambda: symmetry_plane((0,), (0.0, 0.0, 0.0)), "normal must not be zero"),
    (lambda: replace(rectangle(1.0, 1.0, (2, 2)), supports=[
        symmetry_plane((4,), (0.1, 0.0, 1.0))]), r"node 4: its normal is nearly along \(0.0995"),
    (lambda: replace(rectangle(1.0, 1.0, (2, 2)), supports=[
        Support((4,), ("z",), 0.1), symmetry_plane((4,), (1.0, 1.0, 0.0))]), "different axes"),
    (lambda: replace(rectangle(1.0, 1.0, (2, 2)), supports=[
        Support((4,), ("x",), 0.1, axes=ANY), Support((4,), ("x",), axes=ANY)]), "different displ"),
    (lambda: Cyclic(1), "must be 2 or more"),
    (lambda: Cyclic(3, (0.0, 0.0, 0.0)), "axis must not be zero"),
    (lambda: sector_of("dome", cyclic=Cyclic(11)), "no node is where another one is turned"),
    (lambda: sector_of("dome", cyclic=3), "cyclic must be"),
    (lambda: Model.of(MESHES["dome"](24, 360.0), **MATERIAL, cyclic=Cyclic(12)), "both sides of"),
    (lambda: replace(rectangle(1.0, 1.0, (2, 2)), cyclic=Cyclic(4)), "node 0 is on the axis"),
    (lambda: replace(rectangle(1.0, 1.0, (3, 2)), cyclic=Cyclic(4, about=(-1.0, -1.0, 0.0))),
     "no node is"),
    (lambda: sector_of("dome", velocity=np.ones((15, 3))), "velocity differs on the two edges"),
    (lambda: sector_of("dome", supports=[Drive((0,), (1.0, 0.0, 0.0))]), "does not move along"),
])
def test_wrong(make, told):
    with pytest.raises(InputError, match=told):
        make()


def test_unlike_edges_of_a_sector():
    """Edges that are divided differently, a rigid motion that is left, one edge that moves."""
    mesh = MESHES["annulus"](4, 90.0)
    model = Model(mesh.nodes, mesh.quads, **MATERIAL)
    nodes = mesh.nodes.copy()
    nodes[4 + 5] *= 1.1
    with pytest.raises(InputError, match="edges differs at nodes"):
        replace(model, nodes=nodes, normals=None, cyclic=Cyclic(4))
    sector = sector_of("dome", loads=[Pressure(1.0)])
    with pytest.raises(InputError, match="translation along z and rotation about an axis along z"):
        load_control(sector, [1.0])
    held = replace(sector, supports=[Support((0, 1), CLAMPED), Support((12,), ("z",), 0.1)])
    with pytest.raises(InputError, match="differently on the two edges"):
        load_control(held, [1.0])
