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
    NodalLoad,
    NodalMoment,
    Pressure,
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


def rolling_plate():
    """A plate on a symmetry plane, a roller edge, with a corner that is pulled and twisted."""
    plate = rectangle(2.0, 1.0, (6, 3))
    corner = nodes_at(plate, x=2.0, y=1.0)[0]
    return replace(plate, supports=[Support(nodes_at(plate, x=0.0), ("x", "px")),
                                    Support(nodes_at(plate, y=0.0), ("y", "z"))],
                   loads=[NodalLoad(corner, (0.0, 3e3, 4e3), PULSE),
                          NodalMoment(corner, (1e2, 2e2, 0.0), PULSE)])


def test_supports_turned_with_the_plate():
    """All of it turned by 30 degrees about some axis: linear, and large displacements."""
    plate = rolling_plate()
    plate = replace(plate, loads=[replace(load, history=TimeFunction((0, 1), (0, 1)))
                                  for load in plate.loads])
    other = turned(plate, ANY)
    one, two = solve_linear(plate), solve_linear(other)
    size = np.abs(one.displacement).max()
    assert np.abs(two.displacement - one.displacement @ ANY.T).max() < 1e-9 * size
    assert np.allclose(two.reactions, one.reactions @ ANY.T, atol=1e-6)
    one, two = (load_control(model, [0.5, 1.0], StaticSettings(tolerance=1e-20))
                for model in (plate, other))
    u = one.displacements[-1]
    assert np.abs(u).max() > 0.1
    assert np.abs(two.displacements[-1] - u @ ANY.T).max() < 1e-10
