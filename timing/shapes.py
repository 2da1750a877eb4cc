"""Models of the growth study that are no benchmarks: free shells of steel, hit once, in any size.

Each has about square elements and no support; a time step is a thirtieth of the period of its first
mode.
"""

from functools import cache

import numpy as np

from corovec import Model, NodalLoad, TimeFunction, cylinder, modes
from corovec.verification.models import box, rectangle

STEEL = {"thickness": 0.01, "youngs": 2.1e11, "poisson": 0.3, "density": 7800.0}

STEPS = 30
"""Time steps a period of the first mode."""

COARSE = 200
"""Elements of the mesh that tells the first mode, at least."""

RIGID = 1e-3
"""Part of the highest frequency looked at below which a mode is a rigid motion."""


def _plate(elements, **options):
    """A square plate of side 1 m."""
    n = round(np.sqrt(elements))
    return rectangle(1.0, 1.0, (n, n), **STEEL, **options)


def _ring(elements, **options):
    """A ring of radius 1 m, pi/4 m wide."""
    n = round(np.sqrt(elements / 8))
    mesh = cylinder(1.0, 0.25 * np.pi, (8 * n, n))
    return Model(mesh.nodes, mesh.quads, normals=mesh.normals, **STEEL, **options)


def _box(elements, **options):
    """A closed cube of edge 1 m."""
    return box((1.0, 1.0, 1.0), round(np.sqrt(elements / 6)), **STEEL, **options)


SHAPES = {"plate": _plate, "ring": _ring, "box": _box}


def model(shape, elements):
    """``Model`` of one of ``SHAPES`` with about so many elements, its first node hit for ten steps.
    """
    pulse = TimeFunction((0.0, 10.0 * time_step(shape)), (1.0, 0.0))
    return SHAPES[shape](elements, loads=[NodalLoad(0, (100.0, 200.0, 1000.0), pulse)])


@cache
def time_step(shape):
    """A thirtieth of the period of the first mode [s], by a coarse mesh."""
    found = modes(SHAPES[shape](COARSE), 8).frequencies
    return float(1.0 / (STEPS * found[found > RIGID * found[-1]][0]))
