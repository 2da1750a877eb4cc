"""Every example runs, draws its picture, and prints a number that is known from elsewhere."""

import importlib.util
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import iv, jv, kv, yv

HERE = Path(__file__).parent


def load(name):
    spec = importlib.util.spec_from_file_location(f"example_{name}", HERE / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


pictures = load("pictures")


def numbers(text):
    return [float(number) for number in re.findall(r"-?\d+\.?\d*(?:e[-+]\d+)?", text)]


def free_plate(text):
    """The impulse of the pulse, 200 N * 0.2 s / 2."""
    momentum, drift = numbers(text)[0], numbers(text)[-1]
    assert momentum == pytest.approx(20.0, abs=1e-8)
    assert drift < 1e-4


def roll_up(text):
    """A circle of the strip's length; the mesh of 32 elements is 0.5 % off."""
    gap, diameter = re.search(r"within ([\d.]+) m.*\ndiameter ([\d.]+) m", text).groups()
    assert float(gap) < 0.01 * 12.0
    assert float(diameter) == pytest.approx(12.0 / np.pi, rel=6e-3)


def snap_through(text):
    """Sze, Liu and Lo (2004), tabulated: 0.7421 and 0.1729 of 3000 N; theirs is another mesh."""
    limit, least = (float(re.search(rf"{word} ([\d.]+) N", text)[1])
                    for word in ("limit load", "afterwards"))
    assert limit == pytest.approx(0.7421 * 3000.0, rel=0.02)
    assert least == pytest.approx(0.1729 * 3000.0, rel=0.02)


def t_junction(text):
    """Rigid plates of 2 kg each in closed form, rotary inertia h^2/12 included."""
    mass, h = 2.0, 0.02
    centre, v, w = np.array([0.0, 1.0 / 6.0, 0.5]), np.array([0.5, 0.0, 0.0]), [0.3, 0.0, 2.0]
    angular = np.zeros(3)
    for side, normal in (((-1, 0, 0), (0, 1, 0)), ((1, 0, 0), (0, 1, 0)), ((0, 1, 0), (1, 0, 0))):
        a, b = np.array(side, dtype=float), np.array([0.0, 0.0, 1.0])
        second = mass * ((np.outer(a, a) + np.outer(b, b)) / 3.0
                         + (np.outer(a, b) + np.outer(b, a)) / 4.0
                         + h**2 / 12.0 * np.outer(normal, normal))
        angular += (mass * np.cross((a + b) / 2.0, v - np.cross(w, centre))
                    + np.trace(second) * np.array(w) - second @ w)
    linear, about_origin = (numbers(found) for found in re.findall(r"\[(.*?)\]", text))
    assert linear == pytest.approx([3.0 * mass * 0.5, 0.0, 0.0], abs=1e-8)
    assert about_origin == pytest.approx(angular.tolist(), abs=2e-6)


def panel(text):
    """Kirchhoff's ring plate, clamped outside and free inside; 40 chords for the rim and 20 for the
    hole make it 0.4 % smaller."""
    a, b, h, nu, pressure = 0.5, 0.1, 0.01, 0.33, 1000.0
    stiffness = 70e9 * h**3 / 12.0 / (1.0 - nu**2)
    # w, w', w'', (laplacian w)' of r^4/64 and of the solutions without load
    parts = [lambda r: (r**4 / 64.0, r**3 / 16.0, 3.0 * r**2 / 16.0, r / 2.0),
             lambda r: (1.0, 0.0, 0.0, 0.0), lambda r: (np.log(r), 1.0 / r, -1.0 / r**2, 0.0),
             lambda r: (r**2, 2.0 * r, 2.0, 0.0),
             lambda r: (r**2 * np.log(r), 2.0 * r * np.log(r) + r, 2.0 * np.log(r) + 3.0, 4.0 / r)]
    outer, inner = (np.array([part(r) for part in parts]).T for r in (a, b))
    known = np.array([outer[0], outer[1], inner[2] + nu / b * inner[1], inner[3]])
    factors = np.append(1.0, np.linalg.solve(known[:, 1:], -known[:, 0])) * pressure / stiffness

    def clamped_and_free(k):
        """Zero at the frequencies of J0, Y0, I0, K0, as the plate without load above."""
        rows = []
        for r in (a, b):
            z = k * r
            w = np.array([jv(0, z), yv(0, z), iv(0, z), kv(0, z)])
            slope = k * np.array([-jv(1, z), -yv(1, z), iv(1, z), -kv(1, z)])
            laplacian = k**2 * np.array([-1.0, -1.0, 1.0, 1.0])
            rows.append((w, slope, laplacian * w - (1.0 - nu) / r * slope, laplacian * slope))
        return np.linalg.det([rows[0][0], rows[0][1], rows[1][2], rows[1][3]])

    k = brentq(clamped_and_free, 2.5 / a, 4.0 / a)
    hertz = k**2 * np.sqrt(stiffness / (2700.0 * h)) / (2.0 * np.pi)
    held, rise, _, measured = numbers(text)
    assert held == pytest.approx(pressure * np.pi * (a**2 - b**2), rel=5e-3)
    assert rise == pytest.approx(1e6 * (inner[0] @ factors), rel=1e-2)
    assert measured == pytest.approx(hertz, rel=1e-2)


def flapping(text):
    """Drag of a rigid plate that turns about its root, ``rho C b L^4/8 int |w|^3 dt``; what ten
    elements and a first mode of 33 Hz take is 2 %.  The drive does what drag takes and the wing
    has."""
    t = np.linspace(0.0, 2.0, 20001)
    angle = 0.5 * (1.0 - np.exp(-25.0 * t * t)) * np.sin(4.0 * np.pi * t)
    cubes = np.abs(np.gradient(angle, t))**3
    rigid = 1.225 * 2.0 * 0.2 * 0.5**4 / 8.0 * np.sum(0.5 * (cubes[1:] + cubes[:-1]) * np.diff(t))
    flexible, stiff = (numbers(line) for line in text.strip().splitlines())
    assert stiff[1] == pytest.approx(rigid, rel=0.02)
    assert flexible[1] > 1.5 * rigid
    for done, taken, has, left in (flexible, stiff):
        assert done == pytest.approx(taken + has, abs=2e-5) and left < 1e-10 * done


def satellite(text):
    """Euler's equations of two rigid plates of 3 kg each, rotary inertia h^2/12 included."""
    mass, h, fold = 3.0, 0.02, np.pi / 3.0
    long, second = np.array([0.0, 1.5, 0.0]), np.zeros((3, 3))
    sides = np.array([(-1.0, 0.0, 0.0), (np.cos(fold), 0.0, np.sin(fold))])
    for a in sides:
        arm, normal = (a - sides.mean(axis=0)) / 2.0, np.cross(a, long) / 1.5
        second += mass * (np.outer(arm, arm) + (np.outer(a, a) + np.outer(long, long)
                                                + h**2 * np.outer(normal, normal)) / 12.0)
    inertia = np.linalg.eigvalsh(np.trace(second) * np.eye(3) - second)
    euler = solve_ivp(lambda t, w: np.cross(inertia * w, w) / inertia, (0.0, 60.0),
                      (0.0, 2.0, 0.02), rtol=1e-10, atol=1e-12, events=lambda t, w: w[1])
    moments, flips = (numbers(found) for found in re.findall(r"\[(.*?)\]", text))
    linear, angular, energy = numbers(text)[-3:]
    assert moments == pytest.approx(inertia.tolist(), abs=1e-4)  # digits printed
    assert flips == pytest.approx(euler.t_events[0].tolist(), abs=0.025)  # a step
    assert linear < 1e-13
    assert angular < 1e-7  # of second order in dt times h
    assert energy < 1e-5


def box(text):
    """Forces balance to the digits printed; moments lose what n varies by across an element."""
    lines = text.splitlines()
    assert len(lines) == 3
    for x, axial, shear, moment, *by_hand in map(numbers, lines):
        assert by_hand == pytest.approx([2000.0, -500.0, 500.0 * (1.2 - x)])
        assert (axial, shear) == pytest.approx(by_hand[:2], abs=2e-6)
        assert moment == pytest.approx(by_hand[2], rel=1e-2)


def fifty(text):
    """Of a beam's tip: F L^3/(3 E I) under a sudden force in the mean, and its first frequency.

    Means and peaks are those of four periods, in which other modes take part."""
    *table, deflection, frequency = text.splitlines()
    h, force, tip, hertz = np.array([line.split() for line in table[1:]], dtype=float).T
    assert numbers(deflection)[-2:] == pytest.approx([-3.0, 1.0], abs=5e-3)
    assert numbers(frequency)[-2:] == pytest.approx([1.0, 0.0], abs=5e-3)
    assert tip == pytest.approx(force / (3.0 * 1e8 * 0.1 * h**3 / 12.0), rel=2e-2)
    assert hertz == pytest.approx(1.875104**2 / (2.0 * np.pi) * h * np.sqrt(1e8 / 12e3), rel=2e-2)


def postbuckling(text):
    """k = 4 of Kirchhoff's plate, 0.8 % above it on this mesh; afterwards 0.408 of the stiffness,
    as the initial slope of a plate whose sides may wave in its plane is quoted, and less later."""
    k, stiffness, _ = (float(number) for number in re.findall(r"\d+\.\d+", text))
    assert k == pytest.approx(4.0, rel=1e-2)
    assert stiffness == pytest.approx(0.408, rel=4e-2)


def campbell(text):
    """Wright, Smith, Thresher and Wang (1982), as it is quoted: a uniform blade without a hub."""
    known = {0.0: 3.5160, 2.0: 4.1373, 4.0: 5.5850, 6.0: 7.3604, 8.0: 9.2568, 10.0: 11.2023,
             12.0: 13.1702}
    found = dict(map(numbers, text.splitlines()[1:]))
    assert found == pytest.approx(known, rel=3e-4)  # of the mesh


def shaken(text):
    """A Timoshenko beam with the lid at its tip, after Rayleigh: its first frequency, and what its
    mode alone does at the top.  Cowper (1966) has the shear of a thin square tube.

    The shell's mode differs by what its sheets bend, Rayleigh's frequency is above the resonance,
    and after 15 periods exp(-15 pi / 10) = 0.9 % is left of the beginning."""
    a, h, length, youngs, nu, rho = 0.2, 0.005, 1.5, 70e9, 0.33, 2700.0
    bending = youngs * 2.0 / 3.0 * a**3 * h
    shearing = youngs / (2.0 + 2.0 * nu) * 20.0 * (1.0 + nu) / (48.0 + 39.0 * nu) * 4.0 * a * h
    w, lid = rho * 4.0 * a * h, rho * a**2 * h
    x = np.linspace(0.0, length, 2001)
    u = ((w * x**2 * (6.0 * length**2 - 4.0 * length * x + x**2) / 24.0
          + lid * x**2 * (3.0 * length - x) / 6.0) / bending
         + (w * (length * x - x**2 / 2.0) + lid * x) / shearing)
    once, twice = (np.trapezoid(w * u**k, x) + lid * u[-1]**k for k in (1, 2))
    hertz, moved, one_mode, work, lost, balance = numbers(text)
    assert hertz == pytest.approx(np.sqrt(once / twice) / (2.0 * np.pi), rel=1e-2)
    assert one_mode == pytest.approx(u[-1] * once / twice / (2.0 * 0.05), rel=2e-2)
    assert moved == pytest.approx(u[-1] * once / twice / (2.0 * 0.05), rel=4e-2)
    assert 0.7 * work < lost < work  # the rest swings
    assert balance < 1e-6


def wing(text):
    """A beam of the laminate's compliance, free to bend across: its plies are those of one angle.
    The clamped root keeps the chord from turning, 1.5 chords of the span (0.94 here, 0.85 and 0.98
    of it at a tenth and a hundredth); the gust lasts 0.4 s, about a period."""
    c, s = np.cos(np.radians(20.0)), np.sin(np.radians(20.0))
    E1, E2, nu12, G12, h, span, q = 130e9, 9e9, 0.3, 5e9, 0.008, 3.0, 20.0
    s11 = c**4 / E1 + (1.0 / G12 - 2.0 * nu12 / E1) * s**2 * c**2 + s**4 / E2
    s16 = ((2.0 / E1 + 2.0 * nu12 / E1 - 1.0 / G12) * s * c**3
           - (2.0 / E2 + 2.0 * nu12 / E1 - 1.0 / G12) * s**3 * c)
    tip, twist, factor, balance = numbers(text)
    assert tip == pytest.approx(12.0 / h**3 * s11 * q * span**4 / 8.0, rel=7e-2)
    assert np.radians(twist) == pytest.approx(12.0 / h**3 * s16 / 2.0 * q * span**3 / 6.0, rel=7e-2)
    assert 1.5 < factor < 2.2 and balance < 1e-6


def solar_array(text):
    """What the springs have, by hand; nothing but what latches take is lost, through six of them;
    it is as long as its seven plates, less what latched hinges still swing."""
    stored = 0.25 * np.sum(np.radians([85.0, *5 * [170.0]])**2)
    first, lost, missed = numbers(text[text.index("the springs had"):])[:3]
    assert first == pytest.approx(stored, abs=1e-4) and 0.0 < lost < stored
    assert missed < 1e-10
    assert max(numbers(text[text.index("momenta stay within"):])[:2]) < 1e-10
    assert numbers(text)[-1] == pytest.approx(np.hypot(7.0, 1.0), abs=0.05)
    opened = [float(angle) for angle in re.findall(r"at the end (\S+) degrees", text)]
    assert opened == pytest.approx([85.0, -170.0, 170.0, -170.0, 170.0, -170.0], abs=5.0)


def chain(text):
    """50 rigid rods, each hinged to the one before: Lagrange's equations in their angles."""
    n, length = 50, 0.1
    below = np.minimum.outer(*2 * [n - np.arange(n)]) - 0.5  # masses at or below two rods, in rods
    below[np.diag_indices(n)] += -0.5 + 1.0 / 3.0 + (0.005 / length)**2 / 12.0
    weights = (n - np.arange(n) - 0.5) * 9.81 / length

    def rates(_, y):
        a, w = y[:n], y[n:]
        apart = a[:, None] - a
        return np.r_[w, np.linalg.solve(below * np.cos(apart), -(
            below * np.sin(apart)) @ w**2 - weights * np.sin(a))]

    start = np.r_[np.full(n, np.pi / 2.0), np.zeros(n)]
    a = solve_ivp(rates, (0.0, 1.0), start, "DOP853", rtol=1e-10, atol=1e-10).y[:n, -1]
    x, z = re.search(r"x = (\S+) m, z = (\S+) m", text).groups()
    assert float(x) == pytest.approx(length * np.sin(a).sum(), abs=2e-3)
    assert float(z) == pytest.approx(-length * np.cos(a).sum(), abs=2e-3)
    assert numbers(text)[-1] < 1e-10


def four_bar(text):
    """Geometrically exact beams by Exudyn; what 32 elements and steps of 5 ms differ by."""
    bent, off, moment, missed = numbers(text[text.index("bends by"):])[:4]
    assert bent == pytest.approx(11.8, abs=0.1) and off < 0.2
    assert moment == pytest.approx(2.18, abs=0.01) and missed < 0.01
    assert numbers(text)[-1] < 1e-10


def double_pendulum(text):
    """The same; the lower strip is bent where it swings through."""
    joint, tip = numbers(text[text.index("within"):])[:2]
    assert joint < 1.0 and tip < 1.5  # of 250 and 500 mm
    assert 0.22 < numbers(text)[-2] < 0.23 and numbers(text)[-1] < 1e-10


CHECKS = (box, campbell, chain, double_pendulum, fifty, flapping, four_bar, free_plate, panel,
          postbuckling, roll_up, satellite, shaken, snap_through, solar_array, t_junction, wing)


SHORT = (free_plate, snap_through)


@pytest.mark.parametrize("check", [pytest.param(check, id=check.__name__, marks=[
    *([] if check in SHORT else [pytest.mark.slow])]) for check in CHECKS])
def test_example(check, tmp_path):
    picture = tmp_path / f"{check.__name__}.png"
    check(pictures.run(check.__name__, picture))
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert [path.name for path in tmp_path.iterdir()] == [picture.name]


def curves(name, n, dt):
    """Columns that an example has beside those of Exudyn, with n elements and steps of dt [s]."""
    source = (HERE / f"{name}.py").read_text(encoding="utf-8")
    source, found = re.subn("N, DT(.*?) = [0-9.]+, [0-9.]+", rf"N, DT\1 = {n}, {dt}", source)
    assert found == 1
    own = {"__file__": str(HERE / f"{name}.py")}
    exec(source[:source.index("\nfig, ")], own)
    return np.column_stack([np.reshape(own[name], (201, -1)) for name in (
        ("off", "moment") if name == "four_bar" else ("ends",))])


@pytest.mark.slow
@pytest.mark.parametrize(("name", "n", "dt", "most"), [
    ("four_bar", 64, 0.0025, (1e-5, 2e-3)), ("double_pendulum", 64, 0.000625, 4 * (1.2e-4,))])
def test_limits_are_those_of_exudyn(name, n, dt, most):
    """Extrapolated in elements and steps, of second order in both, they are Exudyn's curves [m],
    [N m], within what is extrapolated by."""
    best, coarse, slow = (curves(name, *sizes)[1:-1] for sizes in (
        (n, dt), (n // 2, dt), (n, 2.0 * dt)))
    known = np.loadtxt(HERE / f"{name}.csv", delimiter=",")[1:-1, 1:]
    by = [(best - other) / 3.0 for other in (coarse, slow)]
    off, *bounds = (np.abs(found).max(axis=0) for found in (best + sum(by) - known, *by))
    assert np.all(off < most) and np.all(off < sum(bounds))


def test_all_are_checked_and_use_public_names():
    scripts = {path.stem for path in HERE.glob("*.py")} - {"pictures", "test_examples"}
    assert scripts == set(pictures.EXAMPLES)
    for name in scripts:
        source = (HERE / f"{name}.py").read_text(encoding="utf-8")
        modules = set(re.findall(r"(?:from|import) (corovec[\w.]*)", source))
        assert modules <= {"corovec", "corovec.convergence"}
        assert 15 <= len([line for line in source.splitlines() if line.strip()]) <= 45
