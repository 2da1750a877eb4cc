"""The element by itself: zero modes, numbering of its nodes, aspect ratio and warping."""

import numpy as np

from solver import Model, NodalLoad, Support, solve_linear
from solver.statics import STATIC
from verification.case import Case, Row, small
from verification.geometry import surface
from verification.helpers import full_matrix, make_system, no_loads
from verification.suites.linear import CLAMPED

SHAPES = {
    "square": ((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)),
    "aspect 10": ((-10, -1, 0), (10, -1, 0), (10, 1, 0), (-10, 1, 0)),
    "aspect 100": ((-100, -1, 0), (100, -1, 0), (100, 1, 0), (-100, 1, 0)),
    "trapezoid": ((-1, -1, 0), (1, -1, 0), (0.4, 1, 0), (-0.4, 1, 0)),
    "rhombus of 30 degrees": ((0, 0, 0), (1, 0, 0), (1.866, 0.5, 0), (0.866, 0.5, 0)),
    "nearly triangular": ((-1, -1, 0), (1, -1, 0), (1, 1, 0), (0.05, 0.1, 0)),
    "warped by 20 %": ((-1, -1, 0.2), (1, -1, -0.2), (1, 1, 0.2), (-1, 1, -0.2)),
    "warped and distorted": ((-1, -1.2, 0.3), (1.1, -0.8, -0.1), (0.7, 1, 0.2), (-0.9, 0.6, 0)),
}


def element_eigenvalues(corners, thickness=0.1):
    """Eigenvalues of the 20 x 20 stiffness of one element, ascending."""
    nodes = np.array(corners, dtype=float)
    model = Model(nodes, np.array([(0, 1, 2, 3)]), thickness, 1e6, 0.3, 1.0)
    system = make_system(model)
    n = system.numbering.n_dof
    system.assemble(system.initial_state(), STATIC, False, np.zeros(n), no_loads(system))
    return np.linalg.eigvalsh(full_matrix(system))


def run_eigenvalues():
    rows = []
    for name, corners in SHAPES.items():
        values = element_eigenvalues(corners)
        zero = int(np.sum(np.abs(values) < 1e-10 * values[-1]))
        rows.append(Row(f"{name}: zero modes", zero, 6, "analytic", 0.0, "six rigid motions"))
        rows.append(small(f"{name}: negative part of the spectrum", max(0.0, -values[0]), 1e-10,
                          "rounding", scale=values[-1]))
    return rows


def run_numbering():
    rows = []
    for name in ("trapezoid", "warped and distorted"):
        corners = SHAPES[name]
        base = element_eigenvalues(corners)
        for shift in (1, 2, 3):
            rolled = element_eigenvalues(corners[shift:] + corners[:shift])
            rows.append(small(f"{name}, first node {shift + 1}: eigenvalues",
                              np.abs(rolled - base).max(), 1e-12, "the frame of Eq. (3) turns by "
                              "90 degrees with the numbering, the element does not see it",
                              scale=base[-1]))
        flipped = element_eigenvalues(corners[::-1])
        rows.append(small(f"{name}, turned over: eigenvalues", np.abs(flipped - base).max(), 1e-12,
                          "the same with the opposite normal", scale=base[-1]))
    return rows


def run_aspect():
    """In-plane bending of a two-element cantilever is exact for every aspect ratio."""
    rows = []
    for aspect in (1.0, 10.0, 100.0):
        length = 2.0 * aspect
        mesh = surface(lambda x, y: (x, y, 0.0 * x), (2, 1), (0.0, length), (0.0, 1.0))
        root, tip = mesh.where(mesh.nodes[:, 0] == 0.0), mesh.where(mesh.nodes[:, 0] == length)
        supports = [Support(root, ("x",)), Support((0,), CLAMPED), Support(root, CLAMPED[2:]),
                    Support(tuple(range(len(mesh.nodes))), ("z",))]
        loads = [NodalLoad(tip[0], (-1.0, 0, 0)), NodalLoad(tip[1], (1.0, 0, 0))]
        model = Model(mesh.nodes, mesh.quads, 0.1, 1e6, 0.3, 1.0, loads=loads, supports=supports)
        u, _ = solve_linear(model)
        exact = -0.5 * length**2 / (1e6 * 0.1 / 12.0)
        rows.append(Row(f"aspect {aspect:g}: tip deflection under a pure moment",
                        u[list(tip), 1].mean() / exact, 1.0, "analytic", 1e-6,
                        "five stress modes bend exactly; rounding grows with the aspect ratio"))
    return rows


def run_warping():
    rows = []
    from verification.suites.linear import plate
    for degrees in (30.0, 90.0, 180.0):
        tips = []
        for n in (12, 48):
            turn = np.radians(degrees) / 12.0
            mesh = surface(lambda x, s, turn=turn: (x, s * np.cos(turn * x), s * np.sin(turn * x)),
                           (n, n // 6), (0.0, 12.0), (-0.55, 0.55))
            root, tip = mesh.where(mesh.nodes[:, 0] == 0.0), mesh.nearest((12.0, 0.0, 0.0))
            model = plate(mesh, 0.05, 29e6, 0.22, [NodalLoad(tip, (0.0, 1.0, 1.0))],
                          [Support(root, CLAMPED)])
            u, _ = solve_linear(model)
            tips.append(np.linalg.norm(u[tip]))
        rows.append(Row(f"strip twisted by {degrees:g} degrees: 12 x 2 against 48 x 8",
                        tips[0], tips[1], "converged", 0.05, "mesh error of a coarse mesh"))
    return rows


def run_thick_beam():
    """A cantilever half as thick as long: bending and shear of Timoshenko's beam, nu = 0."""
    length, width, thickness, youngs = 1.0, 1.0, 0.5, 1e6
    mesh = surface(lambda x, y: (x, y, 0.0 * x), (40, 1), (0.0, length), (0.0, width))
    root, tip = mesh.where(mesh.nodes[:, 0] == 0.0), mesh.where(mesh.nodes[:, 0] == length)
    model = Model(mesh.nodes, mesh.quads, thickness, youngs, 0.0, 1.0,
                  loads=[NodalLoad(i, (0.0, 0.0, 0.5)) for i in tip],
                  supports=[Support(root, CLAMPED)])
    u, _ = solve_linear(model)
    bending = length**3 / (3.0 * youngs * width * thickness**3 / 12.0)
    shear = length / (5.0 / 6.0 * 0.5 * youngs * width * thickness)
    why = "40 linear elements: (1/40)^2 = 6e-4; the shear is a third of the deflection"
    return [Row("tip deflection over Timoshenko's", u[tip[0], 2] / (bending + shear), 1.0,
                "analytic", 1e-3, why)]


CASES = (
    Case("element-spectrum", "kernel", "six zero modes and no spurious one for any shape", "own",
         "one element, h = 0.1, E = 1e6, nu = 0.3", run_eigenvalues),
    Case("numbering", "kernel", "the numbering of the nodes does not matter", "own; Eq. (3)",
         "one element", run_numbering),
    Case("aspect-ratio", "kernel", "in-plane bending at any aspect ratio", "beam theory",
         "two elements, h = 0.1, E = 1e6, nu = 0.3", run_aspect),
    Case("thick-beam", "kernel", "shear stiffness of a thick cantilever", "Timoshenko's beam",
         "1 x 1 x 0.5, E = 1e6, nu = 0, end shear", run_thick_beam),
    Case("warping", "kernel", "warped elements neither lock nor soften", "own converged",
         "twisted strip 12 x 1.1 x 0.05, E = 29e6, nu = 0.22", run_warping),
)
