"""Time integration: accuracy, spectral radius, frequencies, rigid-body motion, conservation."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

from corovec import Model, Newton, Scheme, Settings, rigid_velocity, simulate
from corovec.benchmarks import load_case
from corovec.solver.kernels.arguments import MASS_ONLY

from ..case import Case, Row, small
from ..helpers import make_system, stiffness
from ..models import cross_code_plate, rectangle, spinning


def run_order():
    """A free plate, spinning and bending: error at 0.4 s against steps many times smaller.

    The initial velocity is Kirchhoff's, so that no oscillation of the normals is excited that the
    steps cannot resolve.
    """
    rows = []
    plate = rectangle(2.0, 1.0, (4, 2), youngs=100.0)
    velocity, normal_velocity = rigid_velocity(plate, (1, 0, 0), (1.0, 2.0, 0.5), (1.0, 0.5, 0.0))
    phase = np.pi * plate.nodes[:, 0] / 2.0
    velocity = velocity + np.outer(np.cos(phase), (0.0, 0.0, 0.2))
    normal_velocity = normal_velocity + np.outer(np.sin(phase), (0.1 * np.pi, 0.0, 0.0))
    model = Model(plate.nodes, plate.quads, 0.1, 100.0, 0.3, 1.0, velocity=velocity,
                  normal_velocity=normal_velocity)
    for rho in (1.0, 0.8, 0.5):
        ends = [simulate(model, Settings(dt=dt, end_time=0.4, scheme=Scheme(rho_inf=rho),
                                         newton=Newton(tolerance=1e-12))).displacement
                for dt in (2e-3, 1e-3, 1.25e-4)]
        errors = [np.abs(end - ends[-1]).max() for end in ends[:2]]
        rows.append(Row(f"rho_inf = {rho}: observed order", np.log2(errors[0] / errors[1]), 2.0,
                        "converged", 0.15, "second order; reference with dt = 1.25e-4", scale=1.0))
    return rows


def spectral_radius(rho, frequency_dt):
    """Largest |eigenvalue| of one step of a linear oscillator with given omega dt."""
    s = Scheme(rho_inf=rho)
    _, _, c_d, c_v, c_a, *_ = s.midpoint(1.0)
    end, stiffness, columns = np.array(s.end(1.0)).reshape(2, 3), frequency_dt**2, []
    for u, v, a in np.eye(3):
        d = (c_v * v + c_a * a - stiffness * u) / (c_d + stiffness * (1.0 - s.alpha_f))
        columns.append([u + d, *(end @ (d, v, a))])
    return np.abs(np.linalg.eigvals(np.array(columns).T)).max()


def run_spectral_radius():
    rows = []
    for rho in (0.0, 0.5, 0.8, 1.0):
        rows.append(Row(f"rho_inf = {rho}: omega dt = 1e4", spectral_radius(rho, 1e4), rho,
                        "analytic", 5e-3, "a double, defective eigenvalue: approached slowly",
                        scale=1.0))
        rows.append(Row(f"rho_inf = {rho}: omega dt = 0.01", spectral_radius(rho, 0.01), 1.0,
                        "analytic", 1e-5, "low frequencies are kept", scale=1.0))
    return rows


def frequencies(n, clamped, thickness=0.01):
    """Lowest omega a^2 sqrt(rho h / D) of a unit square plate."""
    plate = rectangle(1.0, 1.0, (n, n), thickness=thickness, youngs=1.0)
    system = make_system(plate)
    state, start = system.initial_state(), system.numbering.start
    K, M = stiffness(system, state), stiffness(system, state, MASS_ONLY)
    x, y = plate.nodes[:, 0], plate.nodes[:, 1]
    rim = (x == 0) | (x == x.max()) | (y == 0) | (y == y.max())
    keep = [start[i] + c for i in range(len(x)) if not (clamped and rim[i]) for c in (2, 3, 4)]
    values = eigh(K[np.ix_(keep, keep)], M[np.ix_(keep, keep)], eigvals_only=True,
                  subset_by_index=[0, 8])
    D = thickness**3 / 12.0 / (1.0 - 0.3**2)
    return np.sign(values) * np.sqrt(np.abs(values) * thickness / D)


def run_frequencies():
    why = "20 x 20 elements: the error falls with h^2"
    clamped, free = frequencies(20, True), frequencies(20, False)
    rows = [Row(f"clamped, mode {k + 1}", clamped[k], value, "recalled", 0.02, why)
            for k, value in enumerate((35.99, 73.41, 73.41, 108.27))]
    rows += [Row(f"free, mode {k + 1}", free[3 + k], value, "recalled", 0.02, why)
             for k, value in enumerate((13.489, 19.789, 24.432, 35.024, 35.024))]
    rows.append(small("free: rigid modes", np.abs(free[:3]).max(), 1e-3,
                      "rounding of K over the lowest mode"))
    return rows


def run_euler():
    """A stiff plate spinning about its intermediate axis flips over and over (Dzhanibekov)."""
    a, b, h = 2.0, 1.0, 0.1
    omega = np.array([0.02, 2.0, 0.02])
    plate = rectangle(a, b, (2, 1), thickness=h, youngs=1e7)
    centre = np.array([a / 2, b / 2, 0.0])
    model = spinning(plate, omega, about=centre)
    mass = a * b * h
    rotary = mass * h * h / 12.0
    inertia = np.array([mass * b * b / 12 + rotary, mass * a * a / 12 + rotary,
                        mass * (a * a + b * b) / 12])

    def euler(t, y):
        R, w = y[:9].reshape(3, 3), y[9:]
        skew = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
        return np.r_[(R @ skew).ravel(), np.cross(inertia * w, w) / inertia]

    end = 20.0
    exact = solve_ivp(euler, (0, end), np.r_[np.eye(3).ravel(), omega], rtol=1e-11, atol=1e-12,
                      t_eval=np.linspace(0, end, 2001))
    errors = []
    for dt in (1e-2, 5e-3):
        result = simulate(model, Settings(dt=dt, end_time=end))
        R = exact.y[:9, -1].reshape(3, 3)
        x = centre + (plate.nodes - centre) @ R.T
        errors.append(np.abs(plate.nodes + result.displacement - x).max())
    flips = int(np.sum(np.diff(np.sign(exact.y[10])) != 0))
    return [small(f"positions after 20 s and {flips} flips, dt = 0.005", errors[1], 2e-3,
                  "second order in dt: 0.01 rad a step, squared, over six turns, grown by the "
                  "instability of the intermediate axis", scale=a),
            Row("order in dt", np.log2(errors[0] / errors[1]), 2.0, "analytic", 0.3, "second order",
                scale=1.0)]


def run_conservation():
    rows = []
    for name, model in (("L-plate, 30 elements", load_case("l-plate").model(30)),
                        ("cross-code plate, 30 elements", cross_code_plate(1))):
        drift = simulate(model, Settings(dt=1e-3, end_time=3.0)).drift
        rows += [small(f"{name}, 2 s of free flight: energy", drift.energy, 3e-7, "second order in "
                       "dt; dt = 1e-3"),
                 small(f"{name}: linear momentum", drift.linear_momentum, 1e-11, "rounding"),
                 small(f"{name}: angular momentum", drift.angular_momentum, 1e-8, "second order")]
    return rows


CASES = (
    Case("order-in-time", "dynamics", "second order of accuracy in time", "own",
         "free plate 2 x 1 x 0.1, E = 100: all its frequencies are resolved", run_order),
    Case("spectral-radius", "dynamics", "rho_inf is the spectral radius at infinity",
         "Chung and Hulbert 1993", "linear oscillator", run_spectral_radius),
    Case("plate-frequencies", "dynamics", "mass and stiffness together", "Leissa 1969 and 1973, "
         "square plates, nu = 0.3", "unit square, h = 0.01, clamped and free", run_frequencies),
    Case("rigid-body", "dynamics", "a stiff plate obeys Euler's equations, flips included",
         "Euler's equations integrated to 1e-11", "2 x 1 x 0.1, E = 1e7", run_euler),
    Case("conservation", "dynamics", "energy and momenta of free-flying plates", "own; the cross-"
         "code plate of four other codes", "L-plates, dt = 1e-3", run_conservation),
)
