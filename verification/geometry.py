"""Meshes of the standard shell benchmarks, with exact normals."""

from typing import NamedTuple

import numpy as np


class Surface(NamedTuple):
    """A structured mesh: nodes (n, 3), quads, exact unit normals, parameters (n, 2)."""

    nodes: np.ndarray
    quads: np.ndarray
    normals: np.ndarray
    parameters: np.ndarray

    def where(self, condition):
        """Node numbers where ``condition`` (of nodes or parameters) holds."""
        return tuple(int(i) for i in np.flatnonzero(condition))

    def nearest(self, point):
        """Number of the node nearest to ``point``."""
        return int(np.argmin(np.linalg.norm(self.nodes - np.asarray(point, dtype=float), axis=1)))


def surface(shape, divisions, first, second, exact_normals=True):
    """Structured mesh of ``shape(s, t) -> (x, y, z)`` over the ranges ``first`` and ``second``.

    Normals are along d/ds x d/dt, by central differences of the map (exact to 1e-9).
    """
    n, m = divisions
    s, t = np.meshgrid(np.linspace(*first, n + 1), np.linspace(*second, m + 1))
    s, t = s.ravel(), t.ravel()
    nodes = np.column_stack(np.broadcast_arrays(*shape(s, t)))
    corner = np.array([(n + 1) * j + i for j in range(m) for i in range(n)])
    quads = np.column_stack([corner, corner + 1, corner + n + 2, corner + n + 1])
    return Surface(nodes, quads, _normals(shape, s, t, first, second) if exact_normals else None,
                   np.column_stack([s, t]))


def _normals(shape, s, t, first, second):
    step_s, step_t = 1e-5 * (first[1] - first[0]), 1e-5 * (second[1] - second[0])
    points = [np.column_stack(np.broadcast_arrays(*shape(s + a * step_s, t + b * step_t)))
              for a, b in ((1, 0), (-1, 0), (0, 1), (0, -1))]
    normals = np.cross(points[0] - points[1], points[2] - points[3])
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def cylinder(radius, angles, length, divisions):
    """Part of a cylinder about X: angle from Z towards Y [rad] first, then x in ``length``."""
    return surface(lambda a, x: (x, radius * np.sin(a), radius * np.cos(a)), divisions, angles,
                   length)


def hemisphere_quarter(radius, hole_degrees, n):
    """Quarter hemisphere about Z, from the equator to the hole: azimuth first, then elevation."""
    top = np.pi / 2.0 - np.radians(hole_degrees)
    return surface(lambda a, b: (radius * np.cos(a) * np.cos(b), radius * np.sin(a) * np.cos(b),
                                 radius * np.sin(b)), (n, n), (0.0, np.pi / 2.0), (0.0, top))
