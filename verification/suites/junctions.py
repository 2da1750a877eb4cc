"""Junctions: plates that meet at an angle, with three rotational variables at the shared nodes."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from corovec import (
    Mesh,
    Model,
    Newton,
    NodalLoad,
    Settings,
    Support,
    block,
    join,
    simulate,
    solve_linear,
)

from ..case import Case, Row, at_least, small
from ..helpers import (
    THIN,
    central_differences,
    free_part,
    full_matrix,
    make_system,
    static_system,
    stiffness,
)
from ..models import spinning


def star(angles, divisions=(2, 2), length=1.0, width=1.0, **options):
    """Plates that leave the Y axis at some angles [degrees] from X towards Z."""
    parts = [block([(0, 0, 0), (length * c, 0, length * s), (length * c, width, length * s),
                    (0, width, 0)], divisions)
             for c, s in ((np.cos(a), np.sin(a)) for a in np.radians(angles))]
    mesh = join(parts)
    return Model(mesh.nodes, mesh.quads, **{"thickness": 0.1, "youngs": 1e4, "poisson": 0.3,
                                            "density": 1.0, **options})


STARS = {"fold of 90 degrees": (0, 90), "fold of 60 degrees": (0, 120), "T": (0, 90, 180),
         "Y": (0, 120, 240), "cross": (0, 90, 180, 270), "five plates": (0, 50, 120, 200, 290)}


# ------------------------------------------------------------------ patch test

def folded_patch():
    """Two distorted plates of 3 x 3 elements that meet at a right angle on the Y axis."""
    rng = np.random.default_rng(2)
    parts = []
    for corners in (((0, 0, 0), (0.12, 0, 0), (0.12, 0.24, 0), (0, 0.24, 0)),
                    ((0, 0, 0), (0, 0.24, 0), (0, 0.24, 0.12), (0, 0, 0.12))):
        part = block(corners, (3, 3))
        nodes = part.nodes
        inside = (nodes[:, 1] > 1e-9) & (nodes[:, 1] < 0.24 - 1e-9) & (nodes.max(axis=1) > 0)
        side = np.maximum(nodes[:, 0], nodes[:, 2])
        inside &= (side > 1e-9) & (side < 0.12 - 1e-9)
        moves = rng.uniform(-0.012, 0.012, nodes.shape) * inside[:, None]
        moves[:, 0 if np.ptp(nodes[:, 0]) == 0 else 2] = 0.0
        parts.append(Mesh(nodes + moves, part.quads))
    mesh = join(parts)
    return mesh.nodes, mesh.quads


def folded_state(nodes, kind, poisson):
    """Displacements and rotation vectors (n, 3) of a constant state of both plates."""
    x, y, z = nodes.T
    u, phi = np.zeros((len(nodes), 3)), np.zeros((len(nodes), 3))
    if kind == "stretch along the fold":
        u[:] = np.column_stack([-poisson * x, y, -poisson * z])
    else:
        # one moment about Y through both plates, nu = 0: the rotation about Y grows from -x to z
        u[:, 2] = 0.5 * x * x
        u[:, 0] = 0.5 * z * z
        phi[:, 1] = z - x
    return u, phi


def folded_error(kind, poisson, inclined):
    """Largest interior error of a state, relative to its largest value; all inside is free."""
    nodes, quads = folded_patch()
    u, phi = folded_state(nodes, kind, poisson)
    turn = np.eye(3)
    if inclined:
        turn = Rotation.from_euler("xyz", (25, 40, 10), degrees=True).as_matrix()
    model = Model(nodes @ turn.T, quads, 1e-3, 1e6, poisson, 1.0)
    u, phi = u @ turn.T, phi @ turn.T
    system = make_system(model)
    state = system.initial_state()
    A1_all = system.observe(state).start.A1
    n, start = system.numbering.n_dof, system.numbering.start
    K, exact, free = stiffness(system, state), np.zeros(n), np.zeros(n, dtype=bool)
    rim = np.isclose(nodes[:, 1] % 0.24, 0.0) | np.isclose(np.maximum(nodes[:, 0], nodes[:, 2]),
                                                           0.12)
    first = model.directors.first
    for i in range(len(nodes)):
        n_rot = system.numbering.n_rot[i]
        rates = np.concatenate([np.cross(phi[i], model.normals[d])
                                for d in range(first[i], first[i + 1])])
        A1 = np.concatenate([A1_all[d][:, :n_rot] for d in range(first[i], first[i + 1])])
        exact[start[i]:start[i] + 3] = u[i]
        exact[start[i] + 3:start[i] + 3 + n_rot] = np.linalg.lstsq(A1, rates)[0]
        free[start[i]:start[i] + 3 + n_rot] = not rim[i]
    found = free_part(K, exact, free)
    return np.abs(found - exact).max() / np.abs(exact).max()


def run_patch():
    return [small(f"{kind}, {place}", folded_error(kind, poisson, place == "inclined"), 1e-10,
                  THIN)
            for kind, poisson in (("stretch along the fold", 0.3), ("bending across the fold", 0.0))
            for place in ("as it is", "inclined")]


# ------------------------------------------------------------------ frame

def run_frame():
    """A column on the middle of a beam clamped at both ends, pushed sideways at its head.

    The beam's halves turn with 4 E I/L each: head displacement H a^3/(3 E I) + H a^2 L/(8 E I)
    + H L/(2 E A), and the shear of Timoshenko's beam.
    """
    half, height, width, thickness, youngs = 1.0, 1.5, 0.2, 0.02, 1e9
    n = 32
    parts = [block([(-half, 0, 0), (0, 0, 0), (0, width, 0), (-half, width, 0)], (n, 1)),
             block([(0, 0, 0), (half, 0, 0), (half, width, 0), (0, width, 0)], (n, 1)),
             block([(0, 0, 0), (0, width, 0), (0, width, height), (0, 0, height)], (1, n))]
    mesh = join(parts)
    nodes, quads = mesh.nodes, mesh.quads
    ends = np.flatnonzero(np.isclose(np.abs(nodes[:, 0]), half))
    head = np.flatnonzero(np.isclose(nodes[:, 2], height))
    model = Model(nodes, quads, thickness, youngs, 0.0, 1.0,
                  loads=[NodalLoad(int(i), (0.5, 0, 0)) for i in head],
                  supports=[Support(tuple(ends), ("x", "y", "z", "px", "py", "pz"))])
    u, _ = solve_linear(model)
    middle = np.flatnonzero((nodes[:, 0] == 0.0) & (nodes[:, 2] == 0.0))
    EI, EA = youngs * width * thickness**3 / 12.0, youngs * width * thickness
    GA = 5.0 / 6.0 * 0.5 * EA
    # the ends of a clamped beam of length 2 L under a moment M in the middle carry V = 3 M/(4 L)
    beam = height**2 * half / (8.0 * EI) + (0.75 * height / half) ** 2 * 2.0 * half / GA
    exact = height**3 / (3.0 * EI) + beam + half / (2.0 * EA) + height / GA
    why = "32 linear elements a member: (1/32)^2 = 1e-3"
    return [Row("head of the column", u[head, 0].mean() / exact, 1.0, "analytic", 1e-3, why),
            Row("foot of the column: sway", u[middle, 0].mean() * 2.0 * EA / half, 1.0, "analytic",
                1e-3, why),
            small("foot of the column: settlement", u[middle, 2].mean() / exact, 1e-9,
                  "antisymmetry")]


# ------------------------------------------------------------------ kernel and dynamics

def run_tangent():
    rows, rng = [], np.random.default_rng(4)
    for name, angles in STARS.items():
        plain = star(angles, (1, 1))
        moved = plain.nodes + rng.uniform(-0.05, 0.05, plain.nodes.shape)
        moved[:, [0, 2]] *= (np.hypot(plain.nodes[:, 0], plain.nodes[:, 2]) > 0)[:, None]
        model = replace(plain, nodes=moved @ Rotation.random(rng=rng).as_matrix().T, normals=None)
        system = make_system(model)
        state, n = system.initial_state(), system.numbering.n_dof
        delta = rng.uniform(-0.05, 0.05, n)
        static_system(system, state, delta)
        K = full_matrix(system)
        numeric = -central_differences(
            lambda d, s=system, at=state: static_system(s, at, d, False), delta, 1e-6)
        rows.append(small(f"{name}: K against differences of f", np.abs(numeric - K).max(), 2e-8,
                          "rounding over the step, eps |f| / 1e-6, with a margin of 10",
                          scale=np.abs(K).max()))
        values = np.abs(np.linalg.eigvalsh(stiffness(system, system.initial_state())))
        rows.append(Row(f"{name}: zero modes", int(np.sum(values < 1e-10 * values.max())), 6,
                        "analytic", 0.0, "six rigid motions"))
    return rows


def run_flight():
    rows = []
    for name in ("T", "Y"):
        model = spinning(star(STARS[name]), (3.0, 2.0, 1.0))
        errors = []
        for dt in (1e-2, 5e-3):
            drift = simulate(model, Settings(dt=dt, end_time=4.0,
                                             newton=Newton(tolerance=1e-10))).drift
            errors.append(drift.energy)
        rows += [small(f"{name}: linear momentum", drift.linear_momentum, 1e-11, "rounding"),
                 small(f"{name}: angular momentum, dt = 0.005", drift.angular_momentum, 1e-6,
                       "second order in dt"),
                 Row(f"{name}: order of the energy drift in dt", np.log2(errors[0] / errors[1]),
                     2.0, "analytic", 0.4, "second order", scale=1.0),
                 at_least(f"{name}: one sum over nodes, Eq. (50) as printed",
                          drift.angular_momentum_printed, 1e-3, "must fail")]
    return rows


CASES = (
    Case("folded-patch", "junctions", "constant states go through a fold", "own",
         "two distorted plates 0.12 x 0.24 at a right angle, h = 0.001, E = 1e6", run_patch),
    Case("t-frame", "junctions", "a T-frame is a frame of beams", "Timoshenko's beam",
         "beam of length 2 clamped at both ends, column of height 1.5 on its middle, 0.2 wide, "
         "0.02 thick, nu = 0", run_frame),
    Case("junction-tangent", "junctions", "K is the derivative of f at any junction", "own",
         "two to five plates at one line, distorted, finitely moved", run_tangent),
    Case("junction-flight", "junctions", "junctions conserve as smooth shells do", "own",
         "T and Y of plates 1 x 1 x 0.1, E = 1e4, spinning with 3.7 rad/s", run_flight),
)
