"""Models of the growth study that are no benchmarks: free shells of steel, hit once, in any size.

Each has about square elements and no support; a time step is a thirtieth of the period of its first
mode.
"""

from functools import cache

import numpy as np

from corovec import Model, NodalLoad, TimeFunction, block, cylinder, join, modes

STEEL = {"youngs": 2.1e11, "poisson": 0.3, "density": 7800.0}

STEPS = 30
"""Time steps a period of the first mode."""

COARSE = 200
"""Elements of the mesh that tells the first mode, at least."""

RIGID = 1e-3
"""Part of the highest frequency looked at below which a mode is a rigid motion."""


def plate(elements):
    """Square plate of side 1 m, 10 mm thick."""
    n = round(np.sqrt(elements))
    return block([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], (n, n)), 0.01


def ring(elements):
    """Ring of radius 1 m, pi/4 m wide, 10 mm thick."""
    n = round(np.sqrt(elements / 8))
    return cylinder(1.0, 0.25 * np.pi, (8 * n, n)), 0.01


def box(elements):
    """Closed cube of edge 1 m, 10 mm thick."""
    n = round(np.sqrt(elements / 6))
    corners = np.array([(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    faces = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6))
    return join([block(corners[list(face)], (n, n)) for face in faces]), 0.01


SHAPES = {"plate": plate, "ring": ring, "box": box}


def model(shape, elements):
    """``Model`` of about so many elements, its first node hit for ten steps."""
    mesh, thickness = SHAPES[shape](elements)
    pulse = TimeFunction((0.0, 10.0 * time_step(shape)), (1.0, 0.0))
    return Model(mesh.nodes, mesh.quads, normals=mesh.normals, thickness=thickness,
                 loads=[NodalLoad(0, (100.0, 200.0, 1000.0), pulse)], **STEEL)


@cache
def time_step(shape):
    """A thirtieth of the period of the first mode [s], by a coarse mesh."""
    mesh, thickness = SHAPES[shape](COARSE)
    found = modes(Model(mesh.nodes, mesh.quads, normals=mesh.normals, thickness=thickness, **STEEL),
                  8).frequencies
    return float(1.0 / (STEPS * found[found > RIGID * found[-1]][0]))
