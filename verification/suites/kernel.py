"""The element by itself: derivatives, symmetry, invariance, mass, zero modes, numbering and shape;
and the iteration matrix of a time step."""

import numpy as np
from scipy.spatial.transform import Rotation

from corovec import Model, NodalLoad, Support, solve_linear
from corovec.solver.dynamics.newton import StepRecord
from corovec.solver.dynamics.scheme import Scheme
from corovec.solver.dynamics.settings import Newton
from corovec.solver.dynamics.stepping import Stepper
from corovec.solver.system.system import System

from ..case import Case, Row, at_least, small
from ..element_oracle import DERIVATIVES, E, constants, evaluate, oracle
from ..geometry import surface
from ..helpers import assemble, central_differences, full_matrix, make_system, relative, stiffness
from ..jacobian import newton, step_jacobian
from ..models import random_quad, random_state, rectangle, spinning, warped_patch
from ..shells import CLAMPED, twisted_strip

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


ELEMENTS = {"distorted": (0.25, 0.0), "warped": (0.0, 0.2), "distorted and warped": (0.25, 0.2)}
SEEDS = range(4)


def run_derivatives():
    """Worst of four random elements, each finitely rotated and strained by 20 %."""
    rows = []
    for name, shape in ELEMENTS.items():
        for membrane in ("stress", "strain"):
            errors = np.zeros((len(SEEDS), 3))
            for seed in SEEDS:
                rng = np.random.default_rng(seed)
                initial = random_quad(rng, *shape)
                x, p = random_state(rng, *initial)
                W, f, K = evaluate(constants(*initial, membrane), x, p)
                jet = oracle(x, p, *initial, membrane)
                errors[seed] = (abs(W / jet.value - 1.0), relative(f, jet.gradient),
                                relative(K, jet.hessian))
            rows += [small(f"{name}, membrane {membrane}: {what}", error, DERIVATIVES,
                           "both exact to rounding; the entries of K span four orders")
                     for what, error in zip(("W", "f = dW/dq", "K = d2W/dq2"), errors.max(axis=0))]
    rows.append(at_least("the last with compatible membrane strains: K",
                         relative(evaluate(constants(*initial, "compatible"), x, p)[2],
                                  jet.hessian), 1e-3, "another element"))
    return rows


def run_symmetry():
    """Finite differences know nothing of symmetry; worst of four random elements."""
    errors = np.zeros((len(SEEDS), 4))
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        initial = random_quad(rng)
        x, p = random_state(rng, *initial)
        c = constants(*initial)
        K = evaluate(c, x, p)[2]

        def force(q, c=c):
            q = q.reshape(4, 6)
            return evaluate(c, q[:, :3].copy(), q[:, 3:].copy())[1]

        def force_on_spins(change, c=c, x=x, p=p):
            change = change.reshape(4, 6)
            turned = Rotation.from_rotvec(change[:, 3:]).apply(p)
            f = evaluate(c, x + change[:, :3], turned)[1].reshape(4, 6)
            return np.hstack([f[:, :3], np.cross(turned, f[:, 3:])]).ravel()

        J = central_differences(force, np.hstack([x, p]).ravel(), 1e-5)
        spins = central_differences(force_on_spins, np.zeros(24), 1e-5)
        errors[seed] = relative(K, K.T), relative(J, J.T), relative(J, K), relative(spins, spins.T)
    worst = errors.max(axis=0)
    differences = "truncation and rounding of central differences, each about 1e-9"
    return [small("K - K^T as assembled", worst[0], 1e-13, "rounding"),
            small("J - J^T, J from finite differences of f", worst[1], 1e-7, differences),
            small("J - K", worst[2], 1e-7, differences),
            at_least("J - J^T with spins for rotational variables", errors[:, 3].min(), 1e-3,
                     "rotations that are no vectors: unsymmetric away from equilibrium")]


def run_rigid_motion():
    """Random elements turned by any angle and moved; worst of four."""
    errors, zero_modes, linear = np.zeros((len(SEEDS), 7)), [], []
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        corners, normals = random_quad(rng)
        c, turn = constants(corners, normals), Rotation.random(rng=rng).as_matrix()
        x, p = corners @ turn.T + rng.uniform(-9.0, 9.0, 3), normals @ turn.T
        # two directions tangential to each normal: the normals stay of unit length
        A = np.zeros((4, 3, 3))
        for i in range(4):
            A[i, :, :2] = np.linalg.svd(p[i][None])[2][1:].T
        W, f, K = evaluate(c, x, p, A, (2, 2, 2, 2))
        keep = [6 * i + k for i in range(4) for k in range(5)]
        values = np.linalg.eigvalsh(K[np.ix_(keep, keep)])
        zero_modes.append(int(np.sum(np.abs(values) < 1e-12 * values[-1])))
        moved = np.hstack([x - corners, p - normals]).ravel()
        linear.append(0.5 * moved @ evaluate(c, corners, normals)[2] @ moved / E)

        x, p = random_state(rng, corners, normals)
        strained, blocks = evaluate(c, x, p), np.kron(np.eye(8), turn)
        turned = evaluate(c, x @ turn.T + 3.0, p @ turn.T)
        nodal = strained[1].reshape(4, 6)
        size = np.abs(nodal).max()
        moment = np.cross(x, nodal[:, :3]).sum(axis=0) + np.cross(p, nodal[:, 3:]).sum(axis=0)
        errors[seed] = (W / E, np.abs(f).max() / E, abs(turned[0] / strained[0] - 1.0),
                        relative(turned[1], blocks @ strained[1]),
                        relative(turned[2], blocks @ strained[2] @ blocks.T),
                        np.abs(nodal[:, :3].sum(axis=0)).max() / size,
                        np.abs(moment).max() / (size * np.abs(x).max()))
    names = {"moved free of stress: W / E": 1e-26, "moved free of stress: f / E": 1e-12,
             "strained, then moved: W": 1e-12, "strained, then moved: f": 1e-12,
             "strained, then moved: K": 1e-12, "strained: sum of the forces": 1e-15,
             "strained: sum of the moments": 1e-13}
    rows = [small(name, error, bound, "rounding")
            for (name, bound), error in zip(names.items(), errors.max(axis=0))]
    rows += [Row(f"moved free of stress: zero modes, {what} of four", count, 6, "analytic", 0.0,
                 "six rigid motions")
             for what, count in (("fewest", min(zero_modes)), ("most", max(zero_modes)))]
    rows.append(at_least("moved free of stress: W / E in linear theory", min(linear), 1e-3,
                         "strains linear in displacements see a rotation"))
    return rows


def run_momenta():
    """A rigid plate in motion; its normals carry h^2/12, and bilinear fields integrate exactly."""
    rows = []
    a, b, h, rho = 3.0, 2.0, 0.4, 1.7
    v, omega, centre = np.array([0.3, -1.1, 0.7]), np.array([0.9, -0.4, 1.3]), np.array([1.5, 1, 0])
    mass = rho * h * a * b
    # normals along Z see omega_x and omega_y only: no rotary inertia about Z
    spin = mass / 12.0 * np.array([b * b + h * h, a * a + h * h, a * a + b * b]) * omega
    kinetic, J = 0.5 * (mass * v @ v + omega @ spin), np.cross(centre, mass * v) + spin
    for n, m in ((1, 1), (5, 3)):
        plate = rectangle(a, b, (n, m), thickness=h, density=rho)
        system = System(spinning(plate, omega, v, about=centre))
        instant = system.observe(system.initial_state()).observed
        for name, error in (("mass", system.nodal_mass.sum() / mass - 1.0),
                            ("kinetic energy", instant.kinetic / kinetic - 1.0),
                            ("linear momentum", relative(instant.linear_momentum, mass * v)),
                            ("angular momentum", relative(instant.angular_momentum, J))):
            rows.append(small(f"{n} x {m}: {name}", error, 1e-13, "rounding"))
        rows.append(at_least(f"{n} x {m}: angular momentum as printed",
                             relative(instant.angular_momentum_printed, J), 1e-2,
                             "Eq. (50) lumps the mass at the nodes"))
    return rows


def exact_newton(model, dt, rule):
    """Iterations of the first time step with the Jacobian in place of the symmetric matrix."""
    system = make_system(model)
    return len(newton(system, system.initial_state(), dt, rule, step_jacobian)[1])


def run_step_tangent():
    """Eqs. (62)-(65) are the derivative of the residual only where both ends of a step coincide."""
    rng = np.random.default_rng(2)
    patch = warped_patch(rng)
    system = make_system(patch)
    state, step = system.initial_state(), Scheme().midpoint(0.05)
    direction = rng.uniform(-1.0, 1.0, system.numbering.n_dof)
    rows, gaps = [], []
    for size, prototype in ((1e-4, 3e-5), (1e-2, 5e-3), (5e-2, 4e-2)):
        J = step_jacobian(system, state, step, size * direction)
        assemble(system, state, step, size * direction)
        gaps.append(relative(J, full_matrix(system)))
        rows.append(Row(f"increment {size:g}: decimal logarithm of |J - K| / |K|",
                        np.log10(gaps[-1]), np.log10(prototype), "other code", 0.5,
                        "another shell and direction: the order of magnitude, half a decade",
                        scale=1.0))
    rows.append(Row("order of the gap in the increment, 1e-4 to 1e-2",
                    np.log10(gaps[1] / gaps[0]) / 2.0, 1.0, "analytic", 0.05, "first order",
                    scale=1.0))
    rows.append(at_least("increment 0.05: |J - J^T| / |J|", relative(J.T, J), 1e-3,
                         "the Jacobian of a step is not symmetric"))
    model = spinning(patch, (2.5, -1.5, 4.0), about=patch.nodes.mean(axis=0))
    rule = Newton("full", tolerance=1e-12, min_iterations=1, max_iterations=40)
    for dt, more in ((1e-4, 1), (1e-3, 1), (1e-2, 3)):
        system, record = System(model), StepRecord()
        state = system.initial_state()
        Stepper(system, Scheme(), rule).advance(state, system.observe(state), 0.0, dt, record)
        rows.append(Row(f"dt = {dt:g}: iterations to cc = 1e-12, symmetric K and Jacobian",
                        record.iterations, exact_newton(model, dt, rule), "converged", more,
                        f"linear convergence at the rate of the gap: {more} more at most",
                        scale=1.0))
    return rows


def element_eigenvalues(corners, thickness=0.1):
    """Eigenvalues of the 20 x 20 stiffness of one element, ascending."""
    nodes = np.array(corners, dtype=float)
    model = Model(nodes, np.array([(0, 1, 2, 3)]), thickness, 1e6, 0.3, 1.0)
    system = make_system(model)
    return np.linalg.eigvalsh(stiffness(system, system.initial_state()))


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
    for degrees in (30.0, 90.0, 180.0):
        tips = []
        for n in (12, 48):
            model, tip = twisted_strip((n, n // 6), 0.05, (0.0, 1.0, 1.0), degrees)
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
    Case("element-derivatives", "kernel", "f and K are the exact derivatives of the energy",
         "independent element, automatic differentiation", "random elements, finitely rotated and "
         "strained", run_derivatives),
    Case("tangent-symmetry", "kernel", "K is a symmetric Hessian; with spins it would not be",
         "own; Eq. (63)", "random elements, finitely rotated and strained", run_symmetry),
    Case("rigid-motion", "kernel", "rigid motion makes no force; forces are in equilibrium", "own",
         "random elements, any rotation", run_rigid_motion),
    Case("rigid-momenta", "kernel", "mass, kinetic energy and momenta of a rigid plate",
         "closed forms; Eqs. (40), (46)-(50)", "3 x 2 x 0.4, density 1.7", run_momenta),
    Case("step-tangent", "kernel", "what the symmetric iteration matrix of a time step leaves out, "
         "and what that costs", "own prototype; finite differences", "distorted, curved patch of "
         "6 elements, free; spinning at 5 rad/s", run_step_tangent),
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
