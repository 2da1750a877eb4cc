"""Eigenfrequencies, effective masses and linear buckling against closed forms."""

from dataclasses import replace

import numpy as np

from corovec import (
    Centrifugal,
    Configuration,
    Model,
    NodalLoad,
    Pressure,
    Settings,
    Support,
    arc_length,
    buckling,
    cylinder,
    foundation,
    line_load,
    load_control,
    modes,
    simulate,
)
from corovec.solver.model.mesh import node_at

from ..case import Case, Row, at_least, small
from ..models import rectangle
from ..shells import CLAMPED

BEAM = {"youngs": 1.2e8, "poisson": 0.0, "thickness": 0.05}
"""E h^2 / 12 = 2.5e4 [m^4/s^2] at unit density: of all strips here."""

FACTORS = (1.87510407, 4.69409113, 7.85475744, 10.99554073)
"""Roots of cos a cosh a = -1."""


def nodes_where(mesh, condition):
    """Numbers of the nodes for which a condition of (x, y, z) holds."""
    return tuple(int(i) for i in np.flatnonzero(condition(*mesh.nodes.T)))


def clamped_strip(length, elements, width=0.5, **options):
    """Strip along X from x = 0, clamped there, its width about y = 0."""
    strip = rectangle(length, width, (elements, 1), **BEAM)
    root = nodes_where(strip, lambda x, y, z: x == 0.0)
    return replace(strip, nodes=strip.nodes - (0.0, 0.5 * width, 0.0), **{
        "supports": [Support(root, CLAMPED)], **options})


def along(result, component):
    """Frequencies [rad/s] of the modes whose nodes move along a component for the most part."""
    sizes = np.abs(result.displacement).max(axis=1)
    return result.omega[sizes.argmax(axis=1) == component]


def turning(result, component):
    """Of these, those that do not twist about X."""
    straight = np.abs(result.directors).max(axis=1)
    kept = (np.abs(result.displacement).max(axis=1).argmax(axis=1) == component) & (
        straight[:, 1] < straight[:, 0])
    return result.omega[kept]


def run_cantilever():
    """Bending across the strip; that in its plane and torsion lie between."""
    for elements in (40, 80):
        found = turning(modes(clamped_strip(10.0, elements), 12), 2)
        for k, factor in enumerate(FACTORS):
            exact = factor**2 * np.sqrt(2.5e4) / 100.0
            tolerance = 0.1 * (factor / elements) ** 2 * 4.0
            yield Row(f"{elements} x 1: bending {k + 1} [rad/s]", found[k], exact, "analytic",
                      tolerance, "linear elements: of the order (beta L_e)^2 / 12 to / 3, "
                      "beta = factor / L; shear and rotary inertia are 1e-4 of it")


def supported_square(n, h=0.01, loads=(), **options):
    """Unit square, simply supported (w = 0 on the rim), held in its plane."""
    plate = rectangle(1.0, 1.0, (n, n), youngs=1e7, thickness=h, density=1.0)
    rim = nodes_where(plate, lambda x, y, z: (x % 1.0 == 0.0) | (y % 1.0 == 0.0))
    left, right = (node_at(plate.nodes, (at, 0.5, 0.0)) for at in (0.0, 1.0))
    supports = [Support(rim, ("z",)), Support((left,), ("x", "y")), Support((right,), ("y",))]
    return replace(plate, supports=supports, loads=loads, **options)


def run_square_frequencies():
    D, exact = 1e7 * 1e-6 / 12.0 / 0.91, []
    for wave in (2.0, 5.0, 5.0, 8.0):
        exact.append(wave * np.pi**2 * np.sqrt(D / 0.01))
    for n, tolerance in ((16, 0.02), (24, 0.01)):
        found = modes(supported_square(n), 4).omega
        for k, name in enumerate(("1,1", "1,2", "2,1", "2,2")):
            yield Row(f"{n} x {n}: mode ({name}) [rad/s]", found[k], exact[k], "analytic",
                      tolerance, "of second order in the element length, (pi m / n)^2 / 12 of each "
                      "half wave m; free twist of the normals along the rim takes 1e-3")


def run_square_buckling():
    D = 1e7 * 1e-6 / 12.0 / 0.91
    for n, tolerance in ((16, 0.02), (24, 0.02)):
        plate = supported_square(n)
        left, right = (sorted(nodes_where(plate, lambda x, y, z, at=at: x == at),
                              key=lambda i: plate.nodes[i, 1]) for at in (0.0, 1.0))
        loads = [*line_load(plate.nodes, left, (1.0, 0.0, 0.0)),
                 *line_load(plate.nodes, right, (-1.0, 0.0, 0.0))]
        plate = replace(plate, loads=loads)
        found = buckling(plate, 2)
        yield Row(f"{n} x {n}: k of N = k pi^2 D / b^2", found.factors[0] / (np.pi**2 * D), 4.0,
                  "analytic", tolerance, "mesh error of second order", scale=1.0)
        if n == 16:
            half = load_control(plate, [0.5 * found.factors[0]])
            yield small("about the state at half that load: the same factor",
                        buckling(plate, 1, half).factors[0] / found.factors[0] - 1.0, 1e-3,
                        "the plate before buckling is strained by N/(E h) = 7e-5")
            ratio = modes(plate, 1, half).eigenvalues[0] / modes(plate, 1).eigenvalues[0]
            yield Row("omega^2 at half that load / without", ratio, 0.5, "analytic", 1e-3,
                      "1 - N / N_cr, of the same shape; strain as above", scale=1.0)


def run_cylinder():
    """A quarter between planes of symmetry, also at its ends: the stress before buckling is
    uniform, and the length is that of whole half waves.  One end is pushed in as a whole: a rim
    whose nodes may move along the axis alone buckles at about half the load."""
    R, h, E, nu = 1.0, 0.0025, 1e7, 0.3
    classical = E * h**2 / (R * np.sqrt(3.0 * (1.0 - nu**2)))
    half_wave = np.pi * np.sqrt(R * h) / (12.0 * (1.0 - nu**2)) ** 0.25
    for per_wave, tolerance in ((6, 0.02), (8, 0.01)):
        mesh = cylinder(R, 4.0 * half_wave, (4 * per_wave, 4 * per_wave), angle=90.0)
        end = mesh.nodes[:, 2].max()
        rims = [nodes_where(mesh, lambda x, y, z, at=at: z == at) for at in (0.0, end)]
        sides = [nodes_where(mesh, lambda *at, c=c: np.abs(at[c]) < 1e-9) for c in (0, 1)]
        supports = [Support(rims[0], ("z", "pz")), Support(rims[1], ("pz",)),
                    Support(rims[1], ("z",), displacement=-end * classical / (E * h)),
                    *(Support(side, (c, "p" + c)) for side, c in zip(sides, "xy"))]
        shell = Model.of(mesh, h, E, nu, 1.0, supports=supports)
        yield Row(f"{4 * per_wave} x {4 * per_wave} on a quarter, {per_wave} elements a half "
                  "wave: N_cr / classical", buckling(shell).factors[0], 1.0, "analytic", tolerance,
                  "mesh error of second order, 1.1 % at 6 elements a half wave; long waves round "
                  "the shell, of which the classical theory is too stiff, are 1e-3 at R = 400 h",
                  scale=1.0)


def run_ring():
    """A quarter of a ring between planes of symmetry, pressed from outside."""
    h, E = 0.02, 1e7
    for elements, tolerance in ((12, 0.02), (24, 0.005)):
        mesh = cylinder(1.0, 0.2, (elements, 1), angle=90.0)
        sides = [nodes_where(mesh, lambda *at, c=c: np.abs(at[c]) < 1e-9) for c in (0, 1)]
        supports = [Support(range(len(mesh.nodes)), ("z", "pz")),
                    *(Support(side, (c, "p" + c)) for side, c in zip(sides, "xy"))]
        ring = Model.of(mesh, h, E, 0.0, 1.0, supports=supports,
                        loads=[Pressure(-E * h**3 / 12.0)])
        yield Row(f"{elements} on a quarter: p_cr R^3 / (E I)", buckling(ring).factors[0], 3.0,
                  "analytic", tolerance, "mesh error of second order; forces that keep their "
                  "direction would have 4: the stiffness of the pressure counts")


def run_column():
    """A cantilever under a thrust at its tip, E I = 2.5e4 h b: Euler's load, and the elastica."""
    load = np.pi**2 * 2.5e4 * 0.05 * 0.5 / 400.0
    strip = clamped_strip(10.0, 20)
    tip = nodes_where(strip, lambda x, y, z: x == 10.0)
    strip = replace(strip, loads=[NodalLoad(i, (-0.5 * load, 0.0, 0.0)) for i in tip])
    yield Row("20 x 1: buckling load / Euler's", buckling(strip).factors[0], 1.0, "analytic", 2e-3,
              "(pi / 2 / 20)^2 / 12 and less: 1e-3 of mesh error", scale=1.0)
    path = arc_length(strip, 1e-4, lambda factor, u: np.abs(u[tip[0], 2]) > 4.22, switch=True)
    pivots = path.negative_pivots
    yield Row("negative pivots beyond the load", pivots.max(), 1, "analytic", 0.0, "one shape")
    yield Row("negative pivots on the branch", pivots[-1], 0, "analytic", 0.0, "it is stable")
    w = np.abs(path.displacement[:, tip[0], 2])
    for deflection, reference in ((2.20, 1.015), (4.22, 1.063)):
        after = int(np.argmax(w > 0.0))
        yield Row(f"load / Euler's at a deflection of {deflection / 10:g} L",
                  np.interp(deflection, w[after:], path.factors[after:]), reference, "recalled",
                  3e-3, "elastica, alpha = 20 and 40 degrees (Timoshenko and Gere 1961), three "
                  "decimals; mesh error as above", scale=1.0)


def run_tension():
    """A strip held at both ends, without bending moments there, under tension."""
    strip = rectangle(10.0, 0.5, (40, 1), **BEAM)
    left, right = (nodes_where(strip, lambda x, y, z, at=at: x == at) for at in (0.0, 10.0))
    supports = [Support(left, ("x", "y", "z", "py")), Support(right, ("y", "z", "py"))]
    for ratio in (1.0, 25.0):
        N = ratio * np.pi**2 * 2.5e4 * 0.05 * 0.5 / 100.0
        pulled = replace(strip, supports=supports,
                         loads=[NodalLoad(i, (0.5 * N, 0.0, 0.0)) for i in right])
        found = modes(pulled, 8, load_control(pulled, [1.0]))
        for k, omega in enumerate(turning(found, 2)[:3], start=1):
            exact = (k * np.pi / 10.0) ** 2 * np.sqrt(2.5e4) * np.sqrt(1.0 + ratio / k**2)
            yield Row(f"N = {ratio:g} N_Euler: mode {k} [rad/s]", omega, exact, "analytic",
                      2e-3 * k**2, "mesh error (k pi / 40)^2 / 12 to / 6; strain of N 5e-4 k^-2")


def run_spinning_blade():
    """Flapping: Omega and the frequency in units of sqrt(E I / m L^4)."""
    unit = np.sqrt(2.5e4) / 100.0
    published = {1.0: (3.6816, 22.1810), 2.0: (4.1373, 22.6149), 6.0: (7.3604, 26.8091),
                 12.0: (13.1702, 37.6031)}
    for speed, references in published.items():
        blade = clamped_strip(10.0, 40, loads=[Centrifugal((0.0, 0.0, speed * unit))])
        found = turning(modes(blade, 6, load_control(blade, [1.0])), 2) / unit
        for k, reference in enumerate(references):
            yield Row(f"Omega = {speed:g}: flapping {k + 1}", found[k], reference, "recalled",
                      3e-3, "mesh error of 40 linear elements, 1.5e-3 of the second frequency")
    without = clamped_strip(10.0, 40, loads=[Centrifugal((0.0, 0.0, 12.0 * unit))])
    still = turning(modes(without, 6), 2)[0] / unit
    yield at_least("without the stress of the spin, error at Omega = 12", 1.0 - still / 13.1702,
                   0.7, "3.516 instead of 13.17")


def run_hinged_blade():
    """A stiff plate, hinged at its root: it flaps with ``Omega sqrt((I_z - I_x) / I_y)``, by
    Euler's equations; Omega but for the thickness."""
    L, b, h, omega = 1.0, 0.4, 0.2, 10.0
    blade = rectangle(L, b, (8, 4), thickness=h, youngs=1e10, poisson=0.0, density=1.0)
    blade = replace(blade, nodes=blade.nodes - (0.0, 0.5 * b, 0.0))
    root = Support(nodes_where(blade, lambda x, y, z: x == 0.0), ("x", "y", "z"))
    tip = Support((node_at(blade.nodes, (L, 0.0, 0.0)),), ("z",))
    held = replace(blade, supports=[root, tip], loads=[Centrifugal((0.0, 0.0, omega))])
    state = load_control(held, [1.0]).states[-1]
    found = modes(replace(held, supports=[root]), 1, state).omega[0]
    exact = np.sqrt((L**2 / 3.0 - h**2 / 12.0) / (L**2 / 3.0 + h**2 / 12.0))
    yield Row("flapping / Omega, h = L / 5", found / omega, exact, "analytic", 1e-4,
              "rho Omega^2 L^2 / E = 1e-8, bending of a thick plate a little more", scale=1.0)
    yield at_least("without the rotary terms of the normals, error", 1.0 - exact, 5e-3,
                   "h^2 / (2 L^2)")


def run_whirling():
    """A round shaft that spins below its first frequency: seen from it, omega_0 -+ Omega."""
    mesh = cylinder(0.1, 4.0, (12, 24))
    root = nodes_where(mesh, lambda x, y, z: z == 0.0)
    shaft = Model.of(mesh, 0.01, 1e9, 0.0, 1.0, supports=[Support(root, CLAMPED)])
    still = modes(shaft, 2).omega
    omega = 0.3 * still[0]
    spun = replace(shaft, loads=[Centrifugal((0.0, 0.0, omega))])
    found = modes(spun, 2, load_control(spun, [1.0])).omega
    for name, value, exact in (("backward", found[0], still[0] - omega),
                               ("forward", found[1], still[0] + omega)):
        yield Row(f"{name} whirl, Omega = 0.3 omega_0 [rad/s]", value, exact, "analytic", 2e-3,
                  "exact for a slender shaft; rotary inertia of the section is (R / L)^2 = 6e-4")
    yield at_least("without Coriolis forces, error of the backward one",
                   np.sqrt(1.0 - 0.3**2) / 0.7 - 1.0, 0.3, "omega_0^2 - Omega^2, twice")


def run_spinning_ring():
    """A ring on an elastic foundation that spins with it, in its plane: ``c Omega -+ sqrt(omega_0^2
    + k / m + d Omega^2)``, ``c = 2 n / (n^2 + 1)``, ``d = (n (n^2 - 1) / (n^2 + 1))^2`` (Bryan
    without a foundation, whose springs are the same in all directions); n = 1 is rigid.

    Statics in a frame that turns needs the foundation, stiffer than the softening: k / m > Omega^2.
    """
    R, b, h, youngs, density, n = 1.0, 0.1, 0.02, 1e7, 1000.0, 2
    bending = np.sqrt(36.0 / 5.0 * youngs * h**2 / 12.0 / density) / R**2
    omega = 0.3 * bending
    mesh = cylinder(R, b, (96, 1))
    held = foundation(mesh.nodes, mesh.quads, (1.5 * omega**2 * density * h,) * 3)
    ring = Model.of(mesh, h, youngs, 0.0, density, attached=held,
                    loads=[Centrifugal((0.0, 0.0, omega))])
    found = np.abs(modes(ring, 9, load_control(ring, [1.0])).omega)
    c, d = 2.0 * n / (n**2 + 1.0), (n * (n**2 - 1.0) / (n**2 + 1.0)) ** 2
    rigid, oval = np.sqrt(1.5) * omega, np.sqrt(bending**2 + (1.5 + d) * omega**2)
    for name, exact, kind, tolerance, reason in (
            ("whirl backward", rigid - omega, "analytic", 1e-3, "rigid"),
            ("whirl forward", rigid + omega, "analytic", 1e-3, "rigid"),
            ("oval backward", oval - c * omega, "recalled", 3e-3, "96 chords for the circle"),
            ("oval forward", oval + c * omega, "recalled", 3e-3, "96 chords for the circle")):
        nearest = found[np.abs(found - exact).argmin()]
        yield Row(f"{name}, Omega = 0.3 omega_0 [rad/s]", nearest, exact, kind, tolerance, reason)
    yield at_least("without Coriolis forces, error of the oval, backward",
                   np.sqrt(oval**2 - (c * omega) ** 2) / (oval - c * omega) - 1.0, 0.2,
                   "both at sqrt(omega^2 - c^2 Omega^2)")


def run_free_plate():
    """A plate that nothing holds, and effective masses of all modes of small meshes."""
    plate = rectangle(2.0, 1.0, (8, 4), youngs=1e7, thickness=0.02)
    found = modes(plate, 9)
    yield small("largest of six zero eigenvalues / the first elastic one",
                np.abs(found.eigenvalues[:6]).max() / found.eigenvalues[6], 1e-8,
                "rounding of K: eps by the largest eigenvalue of M^-1 K, 1e9 times the elastic one")
    body = np.r_[np.full(3, plate.mass), np.diag(plate.inertia)]
    yield small("effective masses and inertias of six zero modes / those of the plate",
                np.abs(found.effective_mass[:6].sum(axis=0) / body - 1.0).max(), 1e-6,
                "zero modes are found as exactly as they are zero")
    yield small("those of the elastic ones", np.abs(found.effective_mass[6:] / body).max(), 1e-12,
                "their momenta are zero")
    for elements, tolerance in ((5, 0.4), (20, 0.1)):
        strip = clamped_strip(10.0, elements)
        every = modes(strip, 10 * elements)
        body = np.r_[np.full(3, every.mass), np.diag(every.inertia)]
        share = every.effective_mass.sum(axis=0)[:3] / body[:3]
        yield small(f"clamped strip {elements} x 1: part of the mass in no mode",
                    1.0 - share.min(), tolerance, "what the clamped nodes hold, of the order of "
                    "the element length over L")


def run_simulated():
    """The free oscillation of a clamped strip that starts with the rates of a mode."""
    strip = clamped_strip(2.0, 8)
    tip = nodes_where(strip, lambda x, y, z: x == 2.0)
    for name, force in (("straight", 0.0), ("bent by a third of its length", 40.0)):
        loaded = replace(strip, loads=[NodalLoad(i, (0.0, 0.0, force)) for i in tip])
        state = load_control(loaded, [1.0]) if force else None
        found = modes(loaded, 1, state)
        omega, shape, rates = found.omega[0], found.displacement[0], found.directors[0]
        speed = 1e-4 * omega / np.abs(shape).max()
        start = Configuration(found.base, loaded.normals if state is None else state.directors[-1],
                              False, speed * shape, speed * rates)
        dt = 2.0 * np.pi / omega / 200.0
        run = simulate(loaded if force else strip, Settings(dt=dt, end_time=1200 * dt), start=start,
                       probes={"tip": tip[0]})
        u = run.history["tip_u"][:, np.abs(shape[tip[0]]).argmax()]
        yield Row(f"{name}: simulated / of the mode", frequency(u - u[0], dt) / omega, 1.0,
                  "analytic", 1e-5 + 1.0 / 12.0 * (2.0 * np.pi / 200.0) ** 2, "the trapezoidal "
                  "rule at 200 steps a period loses (omega dt)^2 / 12 = 8e-5", scale=1.0)


def frequency(u, dt):
    """Of an oscillation about zero, by its first and its last upward crossing [rad/s]."""
    up = np.flatnonzero((u[:-1] <= 0.0) & (u[1:] > 0.0))
    times = dt * (up + u[up] / (u[up] - u[up + 1]))
    return 2.0 * np.pi * (len(up) - 1) / (times[-1] - times[0])


CASES = (
    Case("cantilever-modes", "vibration", "bending frequencies of a slender cantilever",
         "Euler and Bernoulli; roots of cos a cosh a = -1", "L = 10, b = 0.5, h = 0.05, nu = 0",
         run_cantilever),
    Case("square-modes", "vibration", "frequencies of a simply supported square plate",
         "Navier: (m^2 + n^2) pi^2 sqrt(D / rho h) / b^2", "unit square, h = 0.01, nu = 0.3, w = 0 "
         "on the rim", run_square_frequencies),
    Case("free-modes", "vibration", "zero modes of a free plate; effective masses sum up to the "
         "mass", "own", "2 x 1 x 0.02, free; strip 10 x 0.5, clamped", run_free_plate),
    Case("tension-modes", "vibration", "frequencies of a strip under tension",
         "a beam between string and Euler: omega^2 (1 + N / (k^2 N_Euler))",
         "L = 10, b = 0.5, h = 0.05, nu = 0", run_tension),
    Case("simulated-modes", "vibration", "a small oscillation in time has the frequency of the "
         "mode, also about a bent equilibrium", "own, simulate", "strip 2 x 0.5 x 0.05, clamped",
         run_simulated),
    Case("spinning-blade", "vibration", "flapping frequencies of a cantilever that spins",
         "Wright, Smith, Thresher and Wang 1982, hub radius 0", "L = 10, b = 0.5, h = 0.05, nu = 0",
         run_spinning_blade),
    Case("hinged-blade", "vibration", "a stiff hinged blade flaps once a turn",
         "Euler's equations", "1 x 0.4 x 0.2, E = 1e10, Omega = 10", run_hinged_blade),
    Case("whirling", "vibration", "Coriolis forces: whirling of a round shaft",
         "Euler and Bernoulli in a frame that turns", "R = 0.1, L = 4, h = 0.01, E = 1e9, 12 x 24",
         run_whirling),
    Case("spinning-ring", "vibration", "a spinning ring: modes that travel forward and backward",
         "Bryan 1890; rigid on a foundation", "R = 1, b = 0.1, h = 0.02, E = 1e7, 96 x 1",
         run_spinning_ring),
    Case("square-buckling", "buckling", "buckling of a simply supported square plate under thrust",
         "Navier: k = 4", "unit square, h = 0.01, nu = 0.3", run_square_buckling),
    Case("cylinder-buckling", "buckling", "axial buckling of a cylinder",
         "classical: E h^2 / (R sqrt(3 (1 - nu^2)))", "R = 1, h = 1 / 400, nu = 0.3, four half "
         "waves between planes of symmetry", run_cylinder),
    Case("ring-buckling", "buckling", "a ring under outer pressure, which follows it",
         "Levy 1884: 3 E I / R^3", "R = 1, h = 0.02, nu = 0", run_ring),
    Case("column", "buckling", "Euler's column, and its path beyond by switching branches",
         "Euler; elastica", "cantilever 10 x 0.5 x 0.05, nu = 0, thrust at the tip", run_column),
)
