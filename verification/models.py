"""Models shared by the suites."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from corovec import Model, NodalLoad, TimeFunction, block, join, rigid_velocity
from corovec.solver.model.mesh import node_at

MATERIAL = {"thickness": 0.1, "youngs": 1e6, "poisson": 0.3, "density": 1.0}
FORCES = ((-3.0, 0.0, 1.0), (0.0, 3.0, 0.0), (0.0, 0.0, -1.0), (3.0, 0.0, 0.0), (0.0, 0.0, 1.0),
          (-3.0, 0.0, 0.0))


def rectangle(length, width, divisions, **options):
    """Flat rectangular plate with one corner at the origin."""
    plate = block([(0.0, 0.0, 0.0), (length, 0.0, 0.0), (length, width, 0.0), (0.0, width, 0.0)],
                  divisions)
    return Model(plate.nodes, plate.quads, **{**MATERIAL, **options})


def spinning(model, omega, velocity=(0.0, 0.0, 0.0), about=(0.0, 0.0, 0.0)):
    """``model`` with the initial velocities of a rigid motion."""
    v, w = rigid_velocity(model, velocity, omega, about)
    return replace(model, velocity=v, normal_velocity=w)


def cross_code_plate(refinement, **options):
    """The L-plate of ``reference_cases.md`` that four other codes have run: outline (0,0), (7,0),
    (7,2), (2,2), (2,10), (0,10), P1..P6 on these corners in this order, peak 5."""
    parts = (((0, 0), (2, 2)), ((2, 0), (7, 2)), ((0, 2), (2, 10)))
    blocks = [block([(x0, y0, 0), (x1, y0, 0), (x1, y1, 0), (x0, y1, 0)],
                    ((x1 - x0) * refinement, (y1 - y0) * refinement))
              for (x0, y0), (x1, y1) in parts]
    mesh = join(blocks)
    pulse = TimeFunction((0.0, 0.5, 1.0), (0.0, 5.0, 0.0))
    corners = ((0, 0, 0), (7, 0, 0), (7, 2, 0), (2, 2, 0), (2, 10, 0), (0, 10, 0))
    loads = [NodalLoad(node_at(mesh.nodes, c), f, pulse)
             for c, f in zip(corners, FORCES, strict=True)]
    return Model(mesh.nodes, mesh.quads, loads=loads, **{**MATERIAL, **options})


def random_quad(rng, distortion=0.25, warp=0.2):
    """A distorted, warped, rigidly rotated quadrilateral (4, 3) and tilted unit normals (4, 3)."""
    flat = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
    corners = flat + rng.uniform(-distortion, distortion, (4, 3)) * (1.0, 1.0, 0.0)
    corners[:, 2] += rng.uniform(-warp, warp, 4)
    normals = np.array([0.0, 0.0, 1.0]) + rng.uniform(-0.2, 0.2, (4, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    turn = Rotation.random(rng=rng).as_matrix()
    return corners @ turn.T + rng.uniform(-5.0, 5.0, 3), normals @ turn.T


def random_state(rng, corners, normals, amplitude=0.2):
    """A finitely rotated and strained configuration (x, p) of a quadrilateral."""
    turn = Rotation.random(rng=rng).as_matrix()
    x = (corners + rng.uniform(-amplitude, amplitude, (4, 3))) @ turn.T + rng.uniform(-9, 9, 3)
    p = normals + rng.uniform(-amplitude, amplitude, (4, 3))
    return x, (p / np.linalg.norm(p, axis=1, keepdims=True)) @ turn.T


def warped_patch(rng, divisions=(3, 2), **options):
    """A small distorted, doubly curved, rigidly rotated shell."""
    model = rectangle(3.0, 2.0, divisions)
    nodes = model.nodes + rng.uniform(-0.15, 0.15, model.nodes.shape)
    nodes[:, 2] += 0.1 * nodes[:, 0] ** 2 - 0.08 * nodes[:, 0] * nodes[:, 1]
    turn = Rotation.random(rng=rng).as_matrix()
    return Model(nodes @ turn.T, model.quads, **{**MATERIAL, **options})


def folded(**options):
    """A plate along -X and one along +Z that meet at the Y axis, 2 x 2 elements each."""
    nodes, quads = [], []
    for k in range(5):
        nodes += [(min(0.5 * k - 1.0, 0.0), y, max(0.5 * k - 1.0, 0.0)) for y in (0.0, 0.5, 1.0)]
    quads = [(3 * i + j, 3 * i + 3 + j, 3 * i + 4 + j, 3 * i + 1 + j)
             for i in range(4) for j in range(2)]
    return Model(np.array(nodes), np.array(quads), 0.01, 1e6, 0.25, 1.0, **options)


def box(size, divisions, **options):
    """A closed box with a corner at the origin, walls of (n, n) elements, normals outwards; three
    of them meet at each corner."""
    a, b, c = size
    walls = (((0, 0, 0), (0, b, 0), (a, b, 0), (a, 0, 0)),
             ((0, 0, c), (a, 0, c), (a, b, c), (0, b, c)),
             ((0, 0, 0), (a, 0, 0), (a, 0, c), (0, 0, c)),
             ((0, b, 0), (0, b, c), (a, b, c), (a, b, 0)),
             ((0, 0, 0), (0, 0, c), (0, b, c), (0, b, 0)),
             ((a, 0, 0), (a, b, 0), (a, b, c), (a, 0, c)))
    mesh = join([block(corners, (divisions, divisions)) for corners in walls])
    return Model(mesh.nodes, mesh.quads, **{**MATERIAL, **options})
