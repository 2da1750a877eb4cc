"""Laminates: what couples stretch and bending, heat, plates of layers, conservation."""

from dataclasses import replace

import numpy as np

from corovec import (
    Lamina,
    Laminate,
    Model,
    NodalLoad,
    Ply,
    Scheme,
    Section,
    Settings,
    Support,
    TimeFunction,
    block,
    line_load,
    load_control,
    simulate,
    solve_linear,
    stresses,
)

from ..case import Case, Row, at_least, small
from ..element_oracle import constants, evaluate
from ..helpers import central_differences, relative
from ..models import random_quad, random_state, spinning
from ..shells import CLAMPED

CARBON = Lamina(140e9, 10e9, 0.3, 5e9, 5e9, 3e9, 1600.0, -0.5e-6, 30e-6)
ROUNDING = "rounding, amplified by the ratio of membrane to bending stiffness"
BY_HAND = "a constant state: exact on distorted elements"


def plate(length, width, divisions, section, *, distorted=0.0, **options):
    """A rectangle from the origin with one section, inner nodes moved at random."""
    mesh = block([(0, 0, 0), (length, 0, 0), (length, width, 0), (0, width, 0)], divisions)
    nodes = mesh.nodes.copy()
    inner = np.setdiff1d(np.arange(len(nodes)), np.ravel(mesh.boundary()))
    nodes[inner, :2] += np.random.default_rng(0).uniform(-distorted, distorted, (len(inner), 2))
    return Model(nodes, mesh.quads, sections=[section], **options)


def at(model, x=None, y=None):
    """Numbers of the nodes at x, y or both."""
    places = [np.isclose(model.nodes[:, c], value) for c, value in enumerate((x, y))
              if value is not None]
    return np.flatnonzero(np.all(places, axis=0))


def free(model, length, width):
    """``model`` on supports that hold six rigid motions and nothing else."""
    origin, right, upper = (at(model, *corner) for corner in ((0, 0), (length, 0), (0, width)))
    return replace(model, supports=[Support(origin, ("x", "y", "z")), Support(right, ("y", "z")),
                                    Support(upper, ("z",))])


def pulled(model, length, force):
    """``model`` under a force per width at both ends [N/m]."""
    ends = [line_load(model.nodes, at(model, x), (sign * force, 0.0, 0.0))
            for x, sign in ((length, 1.0), (0.0, -1.0))]
    return replace(model, loads=[*ends[0], *ends[1]])


def run_derivatives():
    """Worst of four random elements, finitely rotated and strained, of a laminate without any
    symmetry that is offset, and heated."""
    rows = []
    laminate = Laminate([Ply(CARBON, 0.01, 0.0), Ply(CARBON, 0.02, 30.0), Ply(CARBON, 0.005, 70.0)],
                        offset=0.01)
    for name, heat in (("coupled", (0.0, 0.0)), ("coupled and heated", (1e3, 2e4))):
        errors = np.zeros((4, 2))
        for seed in range(4):
            rng = np.random.default_rng(seed)
            initial = random_quad(rng)
            x, p = random_state(rng, *initial)
            law = Section(laminate, None, (1, 0, 0), *heat).law(np.array([[0.6, 0.8]]))
            c = constants(*initial, law=law)

            def of(q, what, c=c):
                q = q.reshape(4, 6)
                return evaluate(c, q[:, :3].copy(), q[:, 3:].copy())[what]

            q, (_, f, K) = np.hstack([x, p]).ravel(), evaluate(c, x, p)
            W_q = central_differences(lambda q: np.array([of(q, 0)]), q, 1e-6)[0]
            errors[seed] = relative(f, W_q), relative(K, central_differences(
                lambda q: of(q, 1), q, 1e-6))
        rows += [small(f"{name}: {what}", error, 1e-7,
                       "truncation and rounding of central differences, each about 1e-9")
                 for what, error in zip(("f = dW/dq", "K = df/dq"), errors.max(axis=0))]
    return rows


def run_constant_states():
    """Nothing but end forces: stretch, twist and heat of a free plate."""
    force, length, width, h = 1e3, 2.0, 1.0, 1e-3
    across = Laminate([Ply(CARBON, h, 90.0)])
    model = pulled(free(plate(length, width, (4, 3), Section(across), distorted=0.1), length,
                        width), length, force)
    tip = at(model, length, 0.0)[0]
    yield Row("strip of fibres across: stretch", solve_linear(model).displacement[tip, 0],
              force * length / (CARBON.E2 * h), "analytic", 1e-9, BY_HAND)

    twisting = Laminate([Ply(CARBON, h, 45.0), Ply(CARBON, h, -45.0)])
    model = pulled(free(plate(length, width, (4, 3), Section(twisting), distorted=0.1), length,
                        width), length, force)
    linear = solve_linear(model)
    # by hand: B_16 = B_26 alone couple, and m_xy = 0 takes kappa_xy out of n
    Q = Q_bar(45.0)
    A, B, D = 2.0 * h * Q[:2, :2], -h**2 * Q[0, 2], 2.0 / 3.0 * h**3 * Q[2, 2]
    strain = np.linalg.solve(A - B**2 / D, [force, 0.0])  # B^2/D in each of the four entries
    twist = -B / D * strain.sum()
    corner = at(model, length, width)[0]
    yield Row("[45/-45] under tension: twist", linear.displacement[corner, 2],
              -0.5 * twist * length * width, "analytic", 1e-9, BY_HAND)
    yield Row("[45/-45] under tension: stretch", linear.displacement[corner, 0],
              strain[0] * length, "analytic", 1e-9, BY_HAND)
    found = stresses(model, linear.state, axes=(1.0, 0.0, 0.0))
    yield small("[45/-45] under tension: m", np.abs(found.m).max(), 1e-9, ROUNDING,
                scale=force * h)

    metal = Lamina.isotropic(70e9, 0.3, 2700.0, 23e-6)
    for name, offset in (("plate", 0.0), ("offset plate", 0.02)):
        section = Section(Laminate([Ply(metal, 0.01)], offset), temperature=50.0)
        model = plate(length, width, (4, 3), section, distorted=0.1)
        held = replace(model, supports=[Support(range(len(model.nodes)), CLAMPED)])
        found, exact = stresses(held, solve_linear(held).state), -70e9 * 23e-6 * 50 * 0.01 / 0.7
        yield Row(f"held heated {name}: n_xx", found.n[:, 0].max(), exact, "analytic", 1e-9,
                  "E alpha dT h / (1 - nu)")
        yield small(f"held heated {name}: m_xx - n_xx e",
                    np.abs(found.m[:, 0] - offset * exact).max(), 1e-9, ROUNDING,
                    scale=abs(exact) * 0.01)
        loose = free(model, length, width)
        path, tip = load_control(loose, [1.0]), at(loose, length, 0.0)[0]
        yield Row(f"loose heated {name}: stretch", path.displacement[-1][tip, 0],
                  23e-6 * 50 * length, "analytic", 1e-9, "no stress")
        yield small(f"loose heated {name}: n", np.abs(stresses(loose, path.states[-1]).n).max(),
                    1e-9, ROUNDING, scale=abs(exact))


def Q_bar(angle):
    """Q of ``CARBON`` turned by an angle, by the fourth powers of Jones, Eq. (2.85)."""
    (Q11, Q12, _), (_, Q22, _), (_, _, Q66) = CARBON.stiffness
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    both, mixed = s**2 * c**2, Q12 + 2.0 * Q66
    xx = Q11 * c**4 + 2.0 * mixed * both + Q22 * s**4
    yy = Q11 * s**4 + 2.0 * mixed * both + Q22 * c**4
    xy = (Q11 + Q22 - 4.0 * Q66) * both + Q12 * (s**4 + c**4)
    ss = (Q11 + Q22 - 2.0 * Q12 - 2.0 * Q66) * both + Q66 * (s**4 + c**4)
    xs = (Q11 - Q12 - 2.0 * Q66) * s * c**3 + (Q12 - Q22 + 2.0 * Q66) * s**3 * c
    ys = (Q11 - Q12 - 2.0 * Q66) * s**3 * c + (Q12 - Q22 + 2.0 * Q66) * s * c**3
    return np.array([[xx, xy, xs], [xy, yy, ys], [xs, ys, ss]])


def run_offset():
    """A force F in the surface of the nodes, e below the middle of a cantilever."""
    length, h, e, E, force = 4.0, 0.05, 0.02, 1e9, 1e3
    model = plate(length, 1.0, (8, 2), Section(Laminate([Ply(Lamina.isotropic(E, 0.0, 1.0), h)],
                                                        offset=e)))
    model = replace(model, supports=[Support(at(model, 0.0), CLAMPED)],
                    loads=line_load(model.nodes, at(model, length), (force, 0.0, 0.0)))
    linear, bending = solve_linear(model), E * h**3 / 12.0
    found, tip = stresses(model, linear.state), at(model, length, 0.0)[0]
    yield Row("tip deflection", linear.displacement[tip, 2], force * e * length**2 / (2 * bending),
              "analytic", 1e-9, "bending by the moment F e is a constant state")
    yield Row("tip stretch", linear.displacement[tip, 0],
              force * length * (1.0 / (E * h) + e**2 / bending), "analytic", 1e-9,
              "the surface of the nodes is stretched by bending as well")
    yield Row("n_xx", found.n[:, 0].max(), force, "analytic", 1e-9, "F")
    yield small("m_xx about the surface of the nodes", np.abs(found.m).max(), 1e-9, ROUNDING,
                scale=force * e)


def bimetal(poisson=0.0, across=True):
    """Two metals of 4 and 6 mm; without expansion ``across`` a strip rolls up without stress.

    Returns:
        (``Laminate``, Timoshenko's curvature of a degree [1/(m K)]).
    """
    (t1, t2), (E1, E2), (a1, a2) = (0.004, 0.006), (200e9, 70e9), (12e-6, 24e-6)
    plies = []
    for t, E, a in ((t1, E1, a1), (t2, E2, a2)):
        lamina = Lamina.isotropic(E, poisson, 1.0, a)
        plies.append(Ply(lamina if across else replace(lamina, alpha2=0.0), t))
    m, n = t1 / t2, E1 / E2
    return Laminate(plies), (6.0 * (a2 - a1) * (1.0 + m) ** 2 / (
        (t1 + t2) * (3.0 * (1.0 + m) ** 2 + (1.0 + m * n) * (m**2 + 1.0 / (m * n)))))


def run_bimetal():
    length, width = 2.0, 0.2
    for poisson in (0.0, 0.3):
        laminate, curvature = bimetal(poisson)
        model = free(plate(length, width, (10, 2), Section(laminate, temperature=30.0)), length,
                     width)
        middle = at(model, 0.5 * length, 0.0)[0]
        linear = solve_linear(model)
        yield Row(f"nu = {poisson}: rise of the middle", linear.displacement[middle, 2],
                  30.0 * curvature * length**2 / 8.0, "analytic", 1e-9,
                  "the side that grows more is the outer one; a constant state")
        yield small(f"nu = {poisson}: n and m of the sections", max(
            np.abs(of).max() / size for of, size in (
                (stresses(model, linear.state).n, 5e5), (stresses(model, linear.state).m, 5e3))),
            1e-9, ROUNDING)
    laminate, curvature = bimetal(across=False)
    model = plate(length, width, (40, 1), Section(laminate, temperature=1000.0))
    model = replace(model, supports=[Support(at(model, 0.0), CLAMPED)])
    stretch, *_, = np.linalg.solve(laminate.ABD, laminate.heat(1000.0, 0.0))
    turn = 1000.0 * curvature * length
    tip = load_control(model, [1.0]).displacement[-1][at(model, length, 0.0)[0]]
    why = "40 chords of an arc of 206 degrees: each is (turn/40)^2/24 = 3.4e-4 shorter"
    yield Row("rolled up: tip, x", tip[0] / length,
              (1.0 + stretch) * np.sin(turn) / turn - 1.0, "analytic", 5e-4, why, scale=1.0)
    yield Row("rolled up: tip, z", tip[2] / length,
              -(1.0 + stretch) * (1.0 - np.cos(turn)) / turn, "analytic", 5e-4, why, scale=1.0)


PLATE = Lamina(25.0, 1.0, 0.25, 0.5, 0.5, 0.2, 1.0)
"""The material of Pagano's plates, E2 = 1."""


def cross_ply(angles, ratio):
    """``Laminate`` of equal layers, 1/ratio thick."""
    return Laminate([Ply(PLATE, 1.0 / ratio / len(angles), angle) for angle in angles])


def navier(laminate):
    """Central deflection of a simply supported cross-ply unit square under sin(pi x) sin(pi y).

    ``(u, v, w, dr_x, dr_y) = (U cos sin, V sin cos, W sin sin, X cos sin, Y sin cos)`` meet the
    equations of first-order shear theory and the supports v = w = dr_y = 0 on x = const.
    """
    k = np.pi
    strain = np.zeros((6, 5))
    for row, u, v in ((0, 0, 1), (3, 3, 4)):
        strain[row, u] = strain[row + 1, v] = -k
        strain[row + 2, u] = strain[row + 2, v] = k
    shear = np.array([[0.0, 0.0, k, 1.0, 0.0], [0.0, 0.0, k, 0.0, 1.0]])
    K = strain.T @ laminate.ABD @ strain + shear.T @ laminate.shear @ shear
    return np.linalg.solve(K, [0.0, 0.0, 1.0, 0.0, 0.0])[2]


def deflection(laminate, n):
    """The same with n x n elements on a quarter."""
    model = plate(0.5, 0.5, (n, n), Section(laminate))
    x, y, _ = model.nodes.T
    pressure = np.sin(np.pi * x) * np.sin(np.pi * y)
    mass, forces = model.elements.mass / (laminate.density * laminate.thickness), np.zeros(len(x))
    np.add.at(forces, model.quads, np.einsum("eij,ej->ei", mass, pressure[model.quads]))
    supports = [Support(at(model, 0.0), ("y", "z", "py")), Support(at(model, 0.5), ("x", "px")),
                Support(at(model, None, 0.0), ("x", "z", "px")),
                Support(at(model, None, 0.5), ("y", "py"))]
    loads = [NodalLoad(i, (0.0, 0.0, force)) for i, force in enumerate(forces)]
    model = replace(model, supports=supports, loads=loads)
    return solve_linear(model).displacement[at(model, 0.5, 0.5)[0], 2]


def run_cross_ply():
    for name, angles in (("[0/90/90/0]", (0, 90, 90, 0)), ("[0/90]", (0, 90))):
        for ratio in (10, 100):
            laminate = cross_ply(angles, ratio)
            exact = navier(laminate)
            for n, tolerance in ((4, 0.05), (8, 0.0125)):
                yield Row(f"{name}, a/h = {ratio}, {n} x {n}: deflection over Navier's",
                          deflection(laminate, n) / exact, 1.0, "analytic", tolerance,
                          "second order: four times as near with half the size")
    for ratio, elastic in ((10, 0.743), (100, 0.4347)):
        yield Row(f"[0/90/90/0], a/h = {ratio}: Navier with this shear stiffness, 100 w E2 h^3/a^4",
                  100.0 * navier(cross_ply((0, 90, 90, 0), ratio)) / ratio**3, elastic, "recalled",
                  0.01, "three-dimensional elasticity; normals stay straight here")
    plain = cross_ply((0, 90, 90, 0), 10)
    G = sum(ply.thickness * ply.shear for ply in plain.plies)
    plain.__dict__["shear"] = 5.0 / 6.0 * G
    yield Row("the same with 5/6 of the mean shear modulus, a/h = 10",
              100.0 * navier(plain) / 1e3, 0.6627, "recalled", 1e-4,
              "first-order theory with 5/6: 11 % too stiff beside elasticity")


def run_offset_flight():
    """A free plate at its place and the same beside its nodes, which are moved to meet it."""
    metal, e, omega = Lamina.isotropic(70e9, 0.3, 2700.0), 0.03, (3.0, -2.0, 5.0)

    def motion(offset, dt=5e-4):
        model = plate(1.0, 0.6, (4, 3), Section(Laminate([Ply(metal, 0.01)], offset)))
        model = replace(model, nodes=model.nodes - (0.0, 0.0, offset))
        model = spinning(model, omega, (1.0, 2.0, 3.0))
        return model, simulate(model, Settings(dt=dt, end_time=0.2))

    (plain, at_place), (moved, beside) = motion(0.0), motion(e)
    there, here = at_place.displacement, beside.displacement + e * (
        beside.state.directors - moved.normals)
    rounding = "x and p are bilinear, so that x + e p is: the same motion"
    yield Row("mass centre, z", moved.centre[2], 0.0, "analytic", 1e-12, rounding, scale=e)
    yield small("inertia", relative(moved.inertia, plain.inertia), 1e-12, rounding)
    for name in ("kinetic_energy", "linear_momentum", "angular_momentum"):
        yield small(f"{name.replace('_', ' ')} at the start", relative(
            beside.history[name][0], at_place.history[name][0]), 1e-12, rounding)
    yield small("motion of the middle of the plate", relative(here, there), 1e-7,
                "steps of 5e-4, of second order")
    longer = motion(e, 1e-3)[1].drift
    for name in ("energy", "linear_momentum", "angular_momentum"):
        drift = getattr(beside.drift, name)
        yield small(f"{name.replace('_', ' ')}, drift", drift, 1e-7, "steps of 5e-4; normals are "
                    "no linear functions of their variables, nor is c dp/dt")
        yield Row(f"{name.replace('_', ' ')}, order of the drift in dt",
                  np.log2(getattr(longer, name) / drift), 2.0, "analytic", 0.1,
                  "second order; 1e-3 and 5e-4", scale=1.0)


def run_conservation():
    """Drifts of a spinning plate without supports after a blow."""
    laminate = Laminate([Ply(CARBON, 2e-3, angle) for angle in (0.0, 45.0, 90.0)])
    blow = [NodalLoad(0, (0.0, 0.0, 100.0), TimeFunction((0.0, 0.01, 0.02), (0.0, 1.0, 0.0)))]
    for name, heat, bound in (("unsymmetric", 0.0, 1e-8), ("and heated at once", 40.0, 3e-5)):
        model = plate(1.0, 0.6, (5, 3), Section(laminate, temperature=heat), distorted=0.02)
        model = replace(spinning(model, (3.0, -2.0, 5.0), (1.0, 2.0, 3.0)), loads=blow)

        def drift(dt, model=model, **scheme):
            return simulate(model, Settings(dt=dt, end_time=0.2, scheme=Scheme(**scheme))).drift

        fine = drift(5e-4)
        yield small(f"{name}: energy", fine.energy, bound, "steps of 5e-4; heat that comes at once "
                    "excites vibrations that they do not resolve" if heat else "steps of 5e-4")
        yield small(f"{name}: linear momentum", fine.linear_momentum, 1e-13, "rounding")
        yield small(f"{name}: angular momentum", fine.angular_momentum, 1e-7, "steps of 5e-4")
        if not heat:
            yield at_least(f"{name}: energy by the trapezoidal rule",
                           drift(5e-4, name="newmark").energy, 100.0 * bound,
                           "a scheme that does not conserve")
            yield Row(f"{name}: order of the drift in dt",
                      np.log2(drift(1e-3).energy / fine.energy), 2.0, "analytic", 0.2,
                      "second order; 1e-3 and 5e-4", scale=1.0)


CASES = (
    Case("section-derivatives", "sections", "f and K of coupled and heated sections are "
         "derivatives of the energy", "own; finite differences", "random elements, finitely "
         "rotated and strained", run_derivatives),
    Case("section-states", "sections", "constant states of laminates and of heat", "Jones, "
         "Mechanics of Composite Materials (1999), Eqs. (2.85), (4.22)", "2 x 1, distorted "
         "elements", run_constant_states),
    Case("section-offset", "sections", "an offset plate bends under a force in its plane",
         "beam theory", "4 x 1 x 0.05, e = 0.02, E = 1e9", run_offset),
    Case("bimetal", "sections", "curvature of a heated strip of two metals, small and rolled up",
         "Timoshenko (1925)", "2 x 0.2 x 0.01", run_bimetal),
    Case("cross-ply", "sections", "deflection of simply supported plates of layers", "Navier's "
         "solution; Pagano and Hatfield (1972) as quoted by Reddy, Mechanics of Laminated "
         "Composite Plates (2004)", "unit square, E1/E2 = 25", run_cross_ply),
    Case("section-offset-flight", "sections", "mass beside the nodes moves as it does at its place",
         "own", "1 x 0.6 x 0.01, e = 0.03, E = 70e9", run_offset_flight),
    Case("section-conservation", "sections", "free flight of an unsymmetric laminate conserves",
         "own", "1 x 0.6 x 0.006, [0/45/90]", run_conservation),
)
