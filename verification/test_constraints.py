"""Supports with axes of their own, symmetry planes in any direction, sectors of cyclic shells."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from corovec import (
    Cyclic,
    Drive,
    Gravity,
    InputError,
    Model,
    Newton,
    NodalLoad,
    NodalMoment,
    Pressure,
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
from corovec.verification.models import folded, rectangle
from corovec.verification.shells import CLAMPED

ANY = Rotation.from_rotvec(np.radians(30.0) * np.array([1.0, 2.0, -2.0]) / 3.0).as_matrix()
ABOUT_Z = Rotation.from_euler("z", 30.0, degrees=True).as_matrix()
EXACT = Settings(dt=2e-3, end_time=0.1, newton=Newton(tolerance=1e-20))
"""Iterations end at rounding errors, so that two models can be compared."""

PULSE = TimeFunction((0.0, 0.02, 0.04), (0.0, 1.0, 0.0))


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


def rolling_plate(history=TimeFunction((0.0, 1.0), (0.0, 1.0))):
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
    strip = replace(strip, loads=[NodalLoad(node, (0.0, 0.0, -force)) for node in ends[1]], supports=[
        Support(ends[0], ("x", "y", "px")),
        Support(ends[1], ("x",), axes=(plane, (0.0, 1.0, 0.0), np.cross(plane, (0.0, 1.0, 0.0))))])
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
    plate = replace(plate, supports=[
        Support(edges[0], CLAMPED), Support(edges[1], ("z",), 0.3, rise), Support(edges[1], ("y",))])
    other = turned(plate, ANY)
    one, two = (load_control(model, [0.05, 0.1], StaticSettings(tolerance=1e-20))
                for model in (plate, other))
    assert np.allclose(one.displacement[-1, edges[1], 2], 0.3)
    assert np.abs(two.displacement[-1] - one.displacement[-1] @ ANY.T).max() < 1e-10
    assert np.allclose(two.reactions[-1], one.reactions[-1] @ ANY.T, atol=1e-6)
    flat = turned(plate, ABOUT_Z)  # the displacement is along z there, the roller oblique
    tilted = turned(replace(plate, supports=[plate.supports[0], Support(edges[1], ("y",), 0.02, rise),
                                             Support(edges[1], ("z",))]), ABOUT_Z)
    for model, aligned in ((flat, plate), (tilted, replace(plate, supports=[
            plate.supports[0], Support(edges[1], ("y",), 0.02, rise),
            Support(edges[1], ("z",))]))):
        one, two = (simulate(m, EXACT) for m in (aligned, model))
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
