"""Patch tests, linearised about the stress-free patch: constant states are met to rounding.

MacNeal and Harder's patch of five distorted elements, flat, inclined in space, and after a finite
rigid rotation of 120 degrees.  Boundary values are prescribed, interior nodes are free.
"""

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from corovec import Mesh, Model, Support, load_control

from ..case import Case, Row, small
from ..helpers import THIN, free_part, make_system, stiffness

NODES = np.array([(0, 0, 0), (0.24, 0, 0), (0.24, 0.12, 0), (0, 0.12, 0), (0.04, 0.02, 0),
                  (0.18, 0.03, 0), (0.16, 0.08, 0), (0.08, 0.08, 0)], dtype=float)
QUADS = np.array([(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (4, 5, 6, 7)])
BOUNDARY, INTERIOR = np.arange(4), np.arange(4, 8)

TRIANGLES = """*NODE
{}
*ELEMENT, TYPE=S4
{}
*ELEMENT, TYPE=S3
4, 4, 1, 5\n5, 4, 5, 8\n6, 5, 6, 7\n7, 5, 7, 8
""".format("\n".join(f"{k}, {x!r}, {y!r}, {z!r}" for k, (x, y, z) in enumerate(NODES.tolist(), 1)),
           "\n".join(f"{k}, {', '.join(map(str, QUADS[k - 1] + 1))}" for k in (1, 2, 3)))
"""The same patch with two of its elements divided into triangles each, as a mesh file."""

MEMBRANE = {"stretch along x": (1, 0, 0, 0), "stretch along y": (0, 0, 0, 1),
            "in-plane shear": (0, 1, 1, 0)}
BENDING = {"bending about y": (1, 0, 0), "bending about x": (0, 1, 0), "twist": (0, 0, 1)}


def state(kind, values, nodes):
    """Displacements and changes of the normals (n, 3) of a constant state, in patch axes."""
    x, y = nodes[:, 0], nodes[:, 1]
    u, r = np.zeros(nodes.shape), np.zeros(nodes.shape)
    if kind == "membrane":
        a, b, c, d = values
        u[:, 0], u[:, 1] = a * x + b * y, c * x + d * y
    elif kind == "bending":
        a, b, c = values
        u[:, 2] = 0.5 * a * x * x + 0.5 * b * y * y + c * x * y
        r[:, 0], r[:, 1] = -(a * x + c * y), -(b * y + c * x)
    else:
        u[:, 2] = values[0] * x + values[1] * y
    return u, r


def patch_error(kind, values, placement, thickness=1e-3, patch=(NODES, QUADS, INTERIOR),
                **options):
    """Largest interior error of a state, relative to its largest value."""
    nodes, quads, interior = patch
    turn = np.eye(3)
    if placement == "inclined":
        turn = Rotation.from_euler("xyz", (25, 40, 10), degrees=True).as_matrix()
    model = Model(nodes @ turn.T, quads, thickness, 1e6, 0.25, 1.0, **options)
    system = make_system(model)
    moved = system.initial_state()
    if placement.startswith("rotated"):
        turn = Rotation.from_rotvec(np.radians(120.0) * np.ones(3) / np.sqrt(3.0)).as_matrix()
        turned = Model(nodes @ turn.T, quads, thickness, 1e6, 0.25, 1.0)
        there = make_system(turned).initial_state()
        moved = replace(moved, motion=moved.motion._replace(x=there.x, variables=there.variables,
                                                            chart=there.chart))
    n, start = system.numbering.n_dof, system.numbering.start
    K = stiffness(system, moved)
    u, r = (field @ turn.T for field in state(kind, values, nodes))
    exact = np.zeros(n)
    for i in range(len(nodes)):
        exact[start[i]:start[i] + 3] = u[i]
        exact[start[i] + 3:start[i] + 5] = moved.chart[i, :2] @ r[i]
    free = np.zeros(n, dtype=bool)
    for i in interior:
        # constant shear: all rotations are prescribed, only the deflection is left free
        free[start[i]:start[i] + (3 if kind == "shear" else 5)] = True
    found = free_part(K, exact, free)
    return np.abs(found - exact).max() / np.abs(exact).max()


def run_linear(patch=(NODES, QUADS, INTERIOR), bound=1e-10):
    rows = []
    states = ([("membrane", name, values) for name, values in MEMBRANE.items()]
              + [("bending", name, values) for name, values in BENDING.items()]
              + [("shear", "transverse shear", (1.0, -0.7))])
    for placement in ("flat", "inclined", "rotated by 120 degrees"):
        rows += [small(f"{name}, {placement}", patch_error(kind, values, placement, patch=patch),
                       bound, THIN) for kind, name, values in states]
    return rows


def run_divided():
    """Quads and triangles that ``Mesh.read`` divides into 24 quads."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "patch.inp"
        path.write_text(TRIANGLES)
        mesh = Mesh.read(path, all_quads=True)
    inside = np.setdiff1d(np.arange(len(mesh.nodes)), mesh.boundary())
    return run_linear((mesh.nodes, mesh.quads, inside), 1e-9)  # elements of half the size


def finite_error(strain):
    """Interior error of a stretched patch at finite strain, relative to the stretch."""
    supports = [Support(tuple(range(8)), ("z", "px", "py", "pz"))]
    for i in BOUNDARY:
        supports.append(Support((i,), ("x",), strain * NODES[i, 0] + 1e-300))
        supports.append(Support((i,), ("y",), 0.5 * strain * NODES[i, 0] + 1e-300))
    model = Model(NODES, QUADS, 1e-3, 1e6, 0.25, 1.0, supports=supports)
    u = load_control(model, [1.0]).displacement[-1]
    exact = np.column_stack([strain * NODES[:, 0], 0.5 * strain * NODES[:, 0], np.zeros(8)])
    return np.abs(u - exact).max() / (strain * 0.24)


def run_finite():
    errors = [finite_error(strain) for strain in (1e-4, 1e-3, 1e-2)]
    rows = [small(f"stretch {strain:g}: error relative to the stretch", error, 2.0 * strain,
                  "local strains are small-strain measures: the error is of their order")
            for strain, error in zip((1e-4, 1e-3, 1e-2), errors)]
    rows.append(Row("order in the strain", np.log10(errors[2] / errors[1]), 1.0, "analytic", 0.1,
                    "first order", scale=1.0))
    return rows


CASES = (
    Case("patch", "patch", "constant membrane, bending, twist and shear states are exact",
         "MacNeal and Harder 1985, patch of five elements",
         "0.24 x 0.12, h = 0.001, E = 1e6, nu = 0.25", run_linear),
    Case("patch-divided", "patch", "constant states are exact where triangles were divided",
         "own", "as patch, two elements as triangles, divided into 24 quads", run_divided),
    Case("patch-finite", "patch", "at finite strain the patch errs by the order of the strain",
         "own", "as patch, stretched and sheared", run_finite),
)
