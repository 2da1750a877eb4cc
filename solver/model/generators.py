"""Meshes of simple shapes: blocks, cylinders, spheres and segments of them, with exact normals."""

from typing import Annotated

import numpy as np

from ..checks import count, floats, integers, number, numbers
from ..errors import InputError
from ..signatures import Count, Positive, checked
from .constants import CORNERS
from .mesh import check_shapes, few_enough
from .meshes import Mesh, join

FEWEST_ROUND = 9
"""Elements round a full circle: fewer meet at 45 degrees or more, at folds."""

FEWEST_ACROSS = 3
"""Elements along an edge of the cube that makes a sphere: fewer meet at folds."""


def divisions_of(name, values):
    """Two counts whose product is no more than ``MOST_ELEMENTS``."""
    items = integers(name, values)
    if len(items) != 2:
        raise InputError(f"{name} must be two counts, are {len(items)}")
    n, m = (count(f"{name}[{k}]", item) for k, item in enumerate(items))
    few_enough(n * m)
    return n, m


def corners_of(name, values):
    """Four corners (4, 3) in order round a convex block [m]."""
    corners = floats(name, values, (4, 3))
    try:
        check_shapes(corners, np.arange(4)[None])
    except InputError:
        raise InputError(f"{name} must go round a convex block, their sides cross or fold: give "
                         "them in the order of an element's nodes") from None
    return corners


def _polar_angles(name, values):
    items = numbers(name, values)
    if len(items) != 2 or not 0.0 < items[0] < items[1] < 180.0:
        raise InputError(f"{name} must be two angles that increase within 0 and 180 [degrees]")
    return items


def _turn(name, value):
    angle = number(name, value, "degrees")
    if not 0.0 < angle <= 360.0:
        raise InputError(f"{name} must lie in (0, 360] [degrees], is {angle:g}")
    return angle


Divisions = Annotated[tuple, divisions_of]
Corners = Annotated[np.ndarray, corners_of]
PolarAngles = Annotated[tuple, _polar_angles]
Turn = Annotated[float, _turn]


@checked
def block(corners: Corners, divisions: Divisions):
    """``Mesh`` of one block: (n+1)(m+1) nodes, n m elements.

    Args:
        corners: (4, 3), in the order of an element's nodes [m].
        divisions: (n, m) elements along the sides 1-2 and 2-3.

    Raises:
        InputError: an argument of another kind, or more than ``MOST_ELEMENTS``.
    """
    n, m = divisions
    j, i = np.divmod(np.arange((n + 1) * (m + 1)), n + 1)
    n_xi = 1.0 + np.outer(2.0 * i / n - 1.0, CORNERS[:, 0])
    n_eta = 1.0 + np.outer(2.0 * j / m - 1.0, CORNERS[:, 1])
    nodes, d_xi, d_eta = ((0.25 * shape)[:, None] @ corners for shape in (
        n_xi * n_eta, CORNERS[:, 0] * n_eta, n_xi * CORNERS[:, 1]))
    normals = np.cross(d_xi[:, 0], d_eta[:, 0])
    return _grid(nodes[:, 0], normals / np.linalg.norm(normals, axis=1, keepdims=True), n, m)


@checked
def cylinder(radius: Positive, length: Positive, divisions: Divisions, angle: Turn = 360.0):
    """``Mesh`` of a circular cylinder about Z from z = 0 to ``length``, normals outward.

    Azimuth runs from +X towards +Y over ``angle``, then nodes go up.

    Args:
        radius: [m].
        length: [m].
        divisions: (n, m) elements round and along.
        angle: that it spans [degrees]; 360 closes it.

    Raises:
        InputError: an argument of another kind, more than ``MOST_ELEMENTS``, or so few that the
            elements meet at folds.
    """
    n, m = divisions
    _smooth(divisions, (_round(angle), 1), "cylinder")
    z, azimuth = np.meshgrid(np.linspace(0.0, length, m + 1), _azimuths(n, angle), indexing="ij")
    normals = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros_like(z)], axis=2)
    nodes = radius * normals + z[:, :, None] * (0.0, 0.0, 1.0)
    return _grid(nodes.reshape(-1, 3), normals.reshape(-1, 3), n, m, closed=angle == 360.0)


@checked
def sphere_segment(radius: Positive, polar_angles: PolarAngles, divisions: Divisions,
                   angle: Turn = 360.0):
    """``Mesh`` of a sphere about Z between two parallels, normals outward.

    Azimuth runs from +X towards +Y over ``angle``, then nodes go from the lower parallel up.

    Args:
        radius: [m].
        polar_angles: of the upper and the lower parallel, from +Z [degrees].
        divisions: (n, m) elements round and along the meridian.
        angle: that it spans [degrees]; 360 closes it.

    Raises:
        InputError: an argument of another kind, more than ``MOST_ELEMENTS``, or so few that the
            elements meet at folds.
    """
    n, m = divisions
    along = int((polar_angles[1] - polar_angles[0]) / 45.0) + 1
    _smooth(divisions, (_round(angle), along), "sphere")
    polar, azimuth = np.meshgrid(np.radians(np.linspace(polar_angles[1], polar_angles[0], m + 1)),
                                 _azimuths(n, angle), indexing="ij")
    normals = np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth),
                        np.cos(polar)], axis=2).reshape(-1, 3)
    return _grid(radius * normals, normals, n, m, closed=angle == 360.0)


@checked
def sphere(radius: Positive, divisions: Count):
    """``Mesh`` of a whole sphere about the origin, normals outward: a cube blown up.

    Args:
        radius: [m].
        divisions: n elements along an edge of the cube, 6 n^2 in all.

    Raises:
        InputError: an argument of another kind, more than ``MOST_ELEMENTS``, or fewer than 3.
    """
    few_enough(6 * divisions**2)
    _smooth((divisions,), (FEWEST_ACROSS,), "sphere")
    at = np.tan(0.25 * np.pi * np.linspace(-1.0, 1.0, divisions + 1))  # edges of equal angles
    v, u = np.meshgrid(at, at, indexing="ij")
    face = np.stack([u, v, np.ones_like(u)], axis=2).reshape(-1, 3)
    axes = np.eye(3)
    parts = []
    for k in range(3):
        for turn in (axes[[k - 2, k - 1, k]], -axes[[k - 1, k - 2, k]]):  # each of determinant 1
            normals = face @ turn
            normals /= np.linalg.norm(normals, axis=1, keepdims=True)
            parts.append(_grid(radius * normals, normals, divisions, divisions))
    return join(parts)


def _azimuths(n, angle):
    """(n + 1,) azimuths [rad], or (n,) of a closed circle."""
    return np.linspace(0.0, np.radians(angle), n + (angle < 360.0), endpoint=angle < 360.0)


def _round(angle):
    """Fewest elements over ``angle`` [degrees] that meet at no fold."""
    return FEWEST_ROUND if angle == 360.0 else int(angle / 45.0) + 1


def _smooth(divisions, fewest, shape):
    """Raise ``InputError`` for so few ``divisions`` that elements meet at folds."""
    if any(given < least for given, least in zip(divisions, fewest)):
        shown, least = (f"({', '.join(map(str, counts))})" for counts in (divisions, fewest))
        raise InputError(f"divisions {shown} are no smooth {shape}, its elements would meet at "
                         f"folds: take at least {least}")


def _grid(nodes, normals, n, m, closed=False):
    """``Mesh`` of n by m elements on nodes in rows, of n + 1 each, or n where rows are closed."""
    row = n if closed else n + 1
    j, i = np.divmod(np.arange(n * m), n)
    right = (i + 1) % row
    quads = np.stack([row * j + i, row * j + right, row * (j + 1) + right, row * (j + 1) + i],
                     axis=1)
    return Mesh(nodes, quads, normals=normals[quads])
