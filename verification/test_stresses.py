"""Stresses: values, the element's own fields, axes, means at nodes, files; mass properties."""

import json
from dataclasses import replace

import h5py
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from corovec import (
    InputError,
    Model,
    NodalMoment,
    Pressure,
    ResultFileError,
    Settings,
    StaticSettings,
    Support,
    arc_length,
    line_load,
    load_control,
    read,
    simulate,
    solve_linear,
    stresses,
    surface_load,
)
from corovec.solver.model.constants import MEMBRANE_FIELDS
from corovec.solver.results.stresses import Configuration, measures
from corovec.verification.geometry import cylinder, surface
from corovec.verification.helpers import corovec, make_system, vtk_frames
from corovec.verification.models import (
    cross_code_plate,
    folded,
    rectangle,
    spinning,
    warped_patch,
)
from corovec.verification.shells import CLAMPED, SYMMETRY, plate, roof, strip
from corovec.verification.suites.patch import BENDING, MEMBRANE, NODES, QUADS
from corovec.verification.suites.patch import state as constant_state

H, E, NU = 0.01, 1e6, 0.25


@pytest.mark.parametrize("membrane", MEMBRANE_FIELDS)
@pytest.mark.parametrize("make", [warped_patch, lambda rng, **options: folded(**options)])
def test_measures_are_those_of_the_step(make, membrane):
    """A moved shell, junctions included: as the kernels have them, to rounding (strains of 0.1)."""
    rng = np.random.default_rng(7)
    model = make(rng, membrane=membrane)
    system = make_system(model)
    state = system.initial_state()
    state.x[:] += rng.uniform(-0.05, 0.05, state.x.shape)
    state.variables[:] += rng.uniform(-0.1, 0.1, state.variables.shape)
    place = system.observe(state)
    e, b = measures(model, system.displacement(state), place.start.p)
    assert np.allclose(e, place.start.e, rtol=1e-11, atol=1e-13 * np.abs(e).max())
    assert np.allclose(b, place.start.b, rtol=1e-11, atol=1e-14)


@pytest.mark.parametrize("membrane", MEMBRANE_FIELDS)
@pytest.mark.parametrize("kind, values", [*(("membrane", v) for v in MEMBRANE.values()),
                                          *(("bending", v) for v in BENDING.values())])
def test_constant_states(membrane, kind, values):
    """Forces and moments of constant strains on distorted elements, in the axes of the patch, and
    the strain energy that they make, which is that of the element."""
    model = Model(NODES, QUADS, H, E, NU, 1.0, membrane=membrane)
    u, dr = constant_state(kind, values, NODES)
    found = stresses(model, Configuration(u, dr, linear=True), axes=(1.0, 0.0, 0.0))
    D = E / (1 - NU**2) * np.array([[1, NU, 0], [NU, 1, 0], [0, 0, 0.5 * (1 - NU)]])
    if kind == "membrane":
        a, b, c, d = values
        strain = np.array([a, d, b + c])
        exact_n, exact_m = H * D @ strain, np.zeros(3)
    else:
        a, b, c = values
        strain = -np.array([a, b, 2.0 * c])
        exact_n, exact_m = np.zeros(3), H**3 / 12.0 * D @ strain
    assert np.allclose(found.n, exact_n, atol=1e-9 * H * E)
    assert np.allclose(found.m, exact_m, atol=1e-9 * H**3 * E)
    areas = np.array([0.5 * np.cross(NODES[q[2]] - NODES[q[0]], NODES[q[3]] - NODES[q[1]])[2]
                      for q in QUADS])
    energy = 0.5 * areas @ (np.einsum("ea,ab,eb->e", found.n, np.linalg.inv(H * D), found.n)
                            + np.einsum("ea,ab,eb->e", found.m,
                                        np.linalg.inv(H**3 / 12.0 * D), found.m))
    e, b = (1e30 * v.imag for v in measures(model, 1e-30j * u, model.normals + 1e-30j * dr))
    k_b = np.moveaxis(model.elements.k_b, -1, 1).reshape(-1, 11, 11)[:len(QUADS)]
    own = 0.5 * np.sum(e**2) + 0.5 * np.einsum("ei,eij,ej", b, k_b, b)
    if kind == "membrane":  # curvature also shears, where deflections are bilinear
        assert energy == pytest.approx(own, rel=1e-9)
    nodal = found.nodal()
    assert np.allclose(nodal.n, exact_n, atol=1e-9 * H * E)
    assert np.allclose(nodal.axes[:, 0], (1.0, 0.0, 0.0))


def test_constant_shear():
    """w = x: q_xz = 5/6 G h, with the parabola 3/2 q/h at the middle, which von Mises counts."""
    model = Model(NODES, QUADS, H, E, NU, 1.0)
    u, dr = np.zeros((2, 8, 3))
    u[:, 2] = 1e-3 * NODES[:, 0]
    found = stresses(model, Configuration(u, dr, linear=True), axes=(1.0, 0.0, 0.0))
    q = 5.0 / 6.0 * 0.5 * E / (1.0 + NU) * H * 1e-3
    assert np.allclose(found.q, (q, 0.0), atol=1e-10 * q)
    assert np.allclose(found.shear[:, 0], 1.5 * q / H)
    assert np.allclose(found.von_mises, (0.0, np.sqrt(3.0) * 1.5 * q / H, 0.0), atol=1e-9 * q / H)


def test_cantilever():
    """A force P over the width b = 2 at the tip: m = P (L - x)/b, q = P/b, P L/b at the root by the
    supports and by extrapolation; linear and, slightly bent, nonlinear."""
    P, L, b = 3.0, 10.0, 2.0
    mesh = surface(lambda x, y: (x, y, 0.0 * x), (20, 2), (0.0, L), (0.0, b))
    tip, root = (mesh.where(mesh.nodes[:, 0] == x) for x in (L, 0.0))
    model = plate(mesh, 0.1, 1.2e6, 0.0, line_load(mesh.nodes, tip, (0.0, 0.0, P / b)),
                  [Support(root, CLAMPED)])
    linear, x = solve_linear(model), mesh.nodes[mesh.quads].mean(axis=1)[:, 0]
    found = stresses(model, linear.state, axes=(1.0, 0.0, 0.0))
    assert np.allclose(found.m[:, 0], -P * (L - x) / b, rtol=1e-8)
    assert np.allclose(found.q[:, 0], P / b, rtol=1e-8)
    assert np.allclose(found.n, 0.0, atol=1e-8)
    assert linear.reaction_moments[:, 1].sum() == pytest.approx(P * L, rel=1e-9)
    assert 1.5 * found.m[0, 0] - 0.5 * found.m[1, 0] == pytest.approx(-P * L / b, rel=1e-8)
    # upwards at the tip: the bottom of the root is pulled
    assert np.allclose(found.bottom[:, 0], 6.0 * P * (L - x) / b / 0.01, rtol=1e-8)
    values, directions = found.principal()
    assert np.allclose(values[:, 2], np.stack([found.bottom[:, 0], 0.0 * x], axis=1), atol=1e-4)
    assert np.allclose(np.abs(directions[:, 2, 0]), 1.0)
    small = replace(model, loads=line_load(mesh.nodes, tip, (0.0, 0.0, 1e-3 * P / b)))
    path = load_control(small, [1.0])
    bent = stresses(small, path.states[-1], axes=(1.0, 0.0, 0.0))
    assert np.allclose(bent.m[:, 0], -1e-3 * P * (L - x) / b, rtol=1e-3)


def test_cylinder_under_pressure():
    """n = p R round it, on a mesh that follows it to second order, and moments that go with the
    square of the elements."""
    errors = []
    for n in (4, 8):
        mesh = cylinder(2.0, (0.0, np.pi / 2.0), (0.0, 1.0), (n, 2))
        angle, x = mesh.parameters.T
        supports = [Support(mesh.where((x == 0.0) | (x == 1.0)), ("x", "px")),
                    Support(mesh.where(angle == 0.0), SYMMETRY["y"]),
                    Support(mesh.where(angle == np.pi / 2.0), SYMMETRY["z"])]
        model = plate(mesh, 0.02, 1e9, 0.0, [Pressure(-50.0)], supports)
        found = stresses(model, solve_linear(model).state, axes=(1.0, 0.0, 0.0))
        errors.append(np.abs(found.n[:, 1] / 100.0 - 1.0).max())
        assert np.allclose(found.n[:, [0, 2]], 0.0, atol=1e-6)
        mises = stresses(model, solve_linear(model).state).nodal().von_mises[:, 1]
        assert np.allclose(mises, 100.0 / 0.02, rtol=1.001 * errors[-1])
    assert errors[0] < 0.02 and errors[1] < 0.3 * errors[0]


def square(n, held):
    """Moments times 1/(p a^2) of a square plate under uniform pressure, a/h = 1000, nu = 0.3, a
    quarter of n x n elements: (at the centre, at the middle of an edge), and q there times 1/(p a).
    """
    mesh = surface(lambda x, y: (x, y, 0.0 * x), (n, n), (0.0, 0.5), (0.0, 0.5))
    x, y = mesh.parameters.T
    supports = [Support(mesh.where(x == 0.0), SYMMETRY["x"]),
                Support(mesh.where(y == 0.0), SYMMETRY["y"]), *held(mesh, x, y)]
    model = plate(mesh, 1e-3, 1e9, 0.3, surface_load(mesh.nodes, mesh.quads, (0.0, 0.0, 1.0)),
                  supports)
    found = stresses(model, solve_linear(model).state, axes=(1.0, 0.0, 0.0))
    edge = n - 1  # beside the middle of the edge x = a/2
    return found.m[0, 0], 1.5 * found.m[edge, 0] - 0.5 * found.m[edge - 1, 0], found.q[edge, 0]


def test_square_plates_against_timoshenko():
    """Timoshenko and Woinowsky-Krieger, Theory of plates and shells, 1959: Table 35, clamped,
    0.0231 and -0.0513; Table 8, simply supported, 0.0479 and 0.338.

    Values are of the elements beside the places: within 1/64 of the side.  A load along +z pulls at
    the top in the middle, m > 0.
    """
    def clamped(mesh, x, y):
        return [Support(mesh.where((x == 0.5) | (y == 0.5)), CLAMPED)]

    def hinged(mesh, x, y):
        return [Support(mesh.where(x == 0.5), ("z", "py")),
                Support(mesh.where(y == 0.5), ("z", "px"))]

    centre, edge, _ = square(16, clamped)
    coarse = square(8, clamped)
    assert centre == pytest.approx(0.0231, abs=3e-4)
    assert edge == pytest.approx(-0.0513, abs=6e-4)
    assert abs(edge + 0.0513) < 0.5 * abs(coarse[1] + 0.0513)
    centre, _, q = square(16, hinged)
    assert centre == pytest.approx(0.0479, abs=2e-4)
    assert q == pytest.approx(-0.338, abs=0.02)  # at the centre of the last element


def kirsch(n):
    """(largest error of the stresses, hoop stress at the top of the hole) of a plate under tension
    1 along x with a hole of radius 1, displacements of Kirsch's solution held at radius 4."""
    mesh = surface(lambda s, r: (r * np.cos(s), r * np.sin(s), 0.0 * s), (n, n),
                   (np.pi / 2.0, 0.0), (4.0, 1.0))
    theta, r = mesh.parameters.T
    mu, kappa = 0.5 / 1.3, (3.0 - 0.3) / 1.3

    def exact(i):
        t, a = theta[i], r[i]
        return np.array([
            a * (kappa + 1) * np.cos(t) + 2 / a * ((1 + kappa) * np.cos(t) + np.cos(3 * t))
            - 2 / a**3 * np.cos(3 * t),
            a * (kappa - 3) * np.sin(t) + 2 / a * ((1 - kappa) * np.sin(t) + np.sin(3 * t))
            - 2 / a**3 * np.sin(3 * t)]) / (8.0 * mu)

    every = tuple(range(len(mesh.nodes)))
    supports = [Support(every, ("z", "px", "py", "pz")),
                Support(mesh.where(theta == 0.0), ("y",)),
                Support(mesh.where(theta == np.pi / 2.0), ("x",))]
    for i in mesh.where(r == 4.0):
        for c, d in zip("xy", exact(i)):
            if abs(d) > 1e-12:
                supports.append(Support((i,), (c,), displacement=1e-6 * d))
    model = plate(mesh, 1.0, 1.0, 0.3, [], supports)
    found = stresses(model, solve_linear(model).state, axes=(1.0, 0.0, 0.0))
    x, y, _ = mesh.nodes[mesh.quads].mean(axis=1).T
    a, t = np.hypot(x, y), np.arctan2(y, x)
    s_xx = 1 - (1.5 * np.cos(2 * t) + np.cos(4 * t)) / a**2 + 1.5 * np.cos(4 * t) / a**4
    error = np.abs(1e6 * found.middle[:, 0] - s_xx).max()
    column = found.middle[:, 0].reshape(n, n)[:, 0]  # beside the y axis, inwards
    return error, 1e6 * (1.5 * column[-1] - 0.5 * column[-2])


def test_hole_against_kirsch():
    """Stresses at element centres to second order, and three times the tension at the hole."""
    coarse, fine = kirsch(16), kirsch(32)
    assert fine[0] < 0.35 * coarse[0]
    assert fine[1] == pytest.approx(3.0, abs=0.07)
    assert abs(fine[1] - 3.0) < 0.5 * abs(coarse[1] - 3.0)


def test_rigid_motion_changes_nothing():
    """Turned and moved 200 m: the same in local axes and in axes that were chosen before, the
    directions turned; exact to the rounding of the positions."""
    rng = np.random.default_rng(3)
    model = warped_patch(rng)
    u, p = rng.uniform(-0.01, 0.01, model.nodes.shape), model.normals
    turn = Rotation.random(rng=rng).as_matrix()
    moved = (model.nodes + u) @ turn.T + (200.0, 0.0, 0.0) - model.nodes
    for axes in (None, (1.0, 2.0, 3.0)):
        one = stresses(model, Configuration(u, p), axes)
        other = stresses(model, Configuration(moved, p @ turn.T), axes)
        for name in ("n", "m", "q"):
            assert np.allclose(getattr(other, name), getattr(one, name), rtol=1e-8, atol=1e-7), name
        assert np.allclose(other.axes, one.axes @ turn.T)
        assert np.allclose(other.nodal().von_mises, one.nodal().von_mises, rtol=1e-8)


def test_axes_of_neighbours():
    """Quads that begin at another corner have other local axes; chosen ones agree, and neither von
    Mises nor principal stresses change."""
    model = rectangle(2.0, 1.0, (2, 1))
    turned = replace(model, quads=np.array([model.quads[0], np.roll(model.quads[1], 1)]),
                     normals=None)
    u = model.nodes * (1e-3, 0.0, 0.0)
    local = stresses(turned, Configuration(u, model.normals, linear=False))
    assert local.n[1, 1] == pytest.approx(local.n[0, 0])
    chosen = stresses(turned, Configuration(u, model.normals), axes=(1.0, 0.0, 0.0))
    assert np.allclose(chosen.n[1], chosen.n[0])
    assert np.allclose(chosen.von_mises, local.von_mises)
    assert np.allclose(chosen.principal()[0], local.principal()[0])
    assert np.allclose(local.nodal().von_mises[:, 0], local.von_mises[0, 0])


def test_plates_of_a_fold_are_not_mixed():
    """Only the plate along X is stretched: at the fold one director has all, the other none."""
    model = folded()
    u = model.nodes * (1e-3, 0.0, 0.0)
    nodal = stresses(model, Configuration(u, np.zeros_like(model.normals), linear=True)).nodal()
    i = 6  # on the fold
    first, last = model.directors.first[i:i + 2]
    assert last - first == 2
    exact = E * 1e-3 / (1.0 - NU**2) * np.sqrt(1.0 - NU + NU**2)
    assert np.allclose(sorted(nodal.von_mises[first:last, 1]), (0.0, exact), atol=1e-9 * exact)


def test_a_direction_for_each_element():
    """Each has the components of that direction for all; a lid across it has one of its own."""
    model = rectangle(2.0, 1.0, (2, 1))
    state = Configuration(1e-3 * model.nodes * (1.0, 0.0, 0.0), model.normals)
    rows = np.array([(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)])
    found = stresses(model, state, rows)
    for k, row in enumerate(rows):
        assert np.array_equal(found.n[k], stresses(model, state, row).n[k])
        assert np.allclose(found.axes[k, 0], row)
    with pytest.raises(InputError, match=r"axes \(0, 0, 1\) are no direction .* of element 1"):
        stresses(model, state, [(1.0, 0.0, 0.0), (0.0, 0.0, 1.0)])
    with pytest.raises(InputError, match=r"axes: shape \(3, 3\) given, \(2, 3\) needed"):
        stresses(model, state, np.eye(3))


@pytest.mark.parametrize("state, axes, told", [
    (np.zeros((12, 3)), None, "state must be a Configuration"),
    (Configuration(np.zeros((5, 3)), np.zeros((6, 3))), None,
     r"state.displacement: shape \(5, 3\)"),
    (Configuration(np.zeros((6, 3)), np.zeros((5, 3))), None, r"state.directors: shape \(5, 3\)"),
    (Configuration(np.zeros((6, 3)), np.ones((6, 3))), (0.0, 0.0, 1.0),
     r"axes \(0, 0, 1\) are no direction in the surface of element 0"),
    (Configuration(np.zeros((6, 3)), np.ones((6, 3))), (0.0, 0.0, 0.0), r"axes \(0, 0, 0\)"),
    (Configuration(np.zeros((6, 3)), np.ones((6, 3))), "x", "axes must be three numbers"),
    (Configuration(np.zeros((6, 3)), np.ones((6, 3)), "no"), None, "state.linear must be True or"),
    (Configuration(-rectangle(2.0, 1.0, (2, 1)).nodes, np.ones((6, 3))), None,
     "state: element 0 has no stresses")])
def test_wrong_arguments(state, axes, told):
    with pytest.raises(InputError, match=told):
        stresses(rectangle(2.0, 1.0, (2, 1)), state, axes)


# ------------------------------------------------------------------ files

def recorded(contents, k):
    """Stresses of frame ``k`` of a file."""
    return {name: contents[name][k] for name in ("membrane_force", "moment", "shear_force",
                                                 "von_mises", "nodal_von_mises")}


def assert_recorded(model, contents, k, state):
    found, first = stresses(model, state), model.directors.first[:-1]
    exact = (found.n, found.m, found.q, found.von_mises, found.nodal().von_mises[first])
    for (name, values), wanted in zip(recorded(contents, k).items(), exact):
        # positions without their rounding errors: strains of 1e-16 beside those of 1e-10
        assert np.allclose(values, wanted, rtol=1e-6, atol=1e-5 * np.abs(wanted).max()), name


def test_run_records_stresses(tmp_path):
    """Of every frame, as of the last state; ``director`` of a frame gives them again."""
    path, model = tmp_path / "run.vtkhdf", folded(velocity=None)
    model = spinning(model, (0.3, 0.2, 0.0))
    settings = Settings(dt=0.01, end_time=0.2, frame_every=5, stresses=True)
    result = simulate(model, settings, output=path)
    contents = read(path)
    assert contents["director"].shape == (5, len(model.normals), 3)
    assert contents["membrane_force"].shape == (5, 8, 3) and not contents["moment"][0].any()
    assert_recorded(model, contents, -1, result.state)
    assert_recorded(model, contents, 2, Configuration(contents["displacement"][2],
                                                      contents["director"][2]))
    assert "von_mises" not in read_plain(tmp_path, model)
    with pytest.raises(ResultFileError, match="stresses is True there and False here"):
        simulate(model, replace(settings, stresses=False), output=path, resume=True)


def read_plain(tmp_path, model):
    simulate(model, Settings(dt=0.01, end_time=0.05), output=tmp_path / "plain.h5")
    return read(tmp_path / "plain.h5")


def test_static_path_records_stresses(tmp_path):
    """Rows of a file that is resumed have all directors too, also at junctions, and as it grows."""
    path = tmp_path / "path.h5"
    root = [i for i, x in enumerate(folded().nodes) if x[0] == -1.0]
    model = folded(supports=[Support(root, CLAMPED)], loads=[NodalMoment(14, (0.0, 1e-5, 0.0))])
    settings = StaticSettings(stresses=True)
    result = load_control(model, [0.5, 1.0], settings, output=path)
    contents = read(path)
    for k in (0, 1):
        assert_recorded(model, contents, k + 1, result.states[k])
    again = load_control(model, [0.5, 1.0], settings, output=path, resume=True)
    for one, other in zip(result.states, again.states):
        assert np.array_equal(one.directors, other.directors)
    assert np.array_equal(again.reaction_moments, result.reaction_moments)
    shallow, path = roof(2, 12.7), tmp_path / "arc.h5"
    followed = arc_length(shallow, 1.0, lambda factor, u: u[0, 2] < -2.0, settings, output=path)
    assert_recorded(shallow, read(path), -1, followed.states[-1])


def test_vtk_reads_stresses_and_time(tmp_path):
    """ParaView's reader, by the ending .vtkhdf, has every field of every frame at its time."""
    path, model = tmp_path / "run.vtkhdf", cross_code_plate(1)
    simulate(model, Settings(dt=0.01, end_time=0.3, frame_every=10, stresses=True), output=path)
    contents = read(path)
    for k, (time, _, arrays) in enumerate(vtk_frames(path, [0.0, 0.1, 0.2, 0.3])):
        assert time == pytest.approx(0.1 * k)
        for name, values in recorded(contents, k).items():
            assert np.array_equal(arrays[name], values), name


def test_description_must_agree_with_the_fields(tmp_path):
    from corovec.verification.fuzz.files import signed
    path = tmp_path / "run.h5"
    simulate(cross_code_plate(1), Settings(dt=0.01, end_time=0.1, stresses=True), output=path)

    def change(file):
        text = json.loads(bytes(file.attrs["description"]))
        text["settings"]["stresses"] = False
        file.attrs["description"] = np.bytes_(json.dumps(text))

    signed(path, change)
    with pytest.raises(ResultFileError, match="description.settings.stresses is False, the dat"):
        read(path)


def test_changed_stress_is_damage(tmp_path):
    path = tmp_path / "run.h5"
    simulate(cross_code_plate(1), Settings(dt=0.01, end_time=0.1, stresses=True), output=path)
    with h5py.File(path, "r+") as file:
        file["frames/von_mises"][30, 1] += 1.0
    with pytest.raises(ResultFileError, match="frame 1, or the history up to it, has changed"):
        read(path)


@pytest.mark.slow
def test_command_line(tmp_path):
    """--stresses records them; info tells mass, centre and inertia of the L-plate, 30 m^2."""
    path = tmp_path / "run.vtkhdf"
    run = corovec("run", "l-plate", "--elements", "30", "--dt", "1e-2", "--end-time", "0.2",
                  "--stresses", "--output", str(path))
    assert run.returncode == 0, run.stderr
    assert read(path)["von_mises"].shape == (21, 30, 3)
    told = json.loads(corovec("info", str(path), "--json").stdout)
    assert told["stresses"] is True
    assert told["body"]["mass"] == pytest.approx(3.0)
    assert told["body"]["centre"] == pytest.approx([11.0 / 3.0, 29.0 / 6.0, 0.0])
    plain = corovec("info", str(path)).stdout
    assert "body                   mass 3, centre (3.66667, 4.83333, 0), inertia ((" in plain


# ------------------------------------------------------------------ mass properties

def test_mass_properties_of_a_plate():
    """m (b^2 + h^2)/12 and so on, exactly, also where it is turned."""
    a, b, h = 3.0, 2.0, 0.4
    model = rectangle(a, b, (3, 2), thickness=h, density=5.0)
    m = 5.0 * a * b * h
    exact = m / 12.0 * np.diag([b**2 + h**2, a**2 + h**2, a**2 + b**2])
    assert model.mass == pytest.approx(m, rel=1e-14)
    assert np.allclose(model.centre, (1.5, 1.0, 0.0))
    assert np.allclose(model.inertia, exact, rtol=1e-13)
    turn = Rotation.from_rotvec((0.3, -1.0, 2.0)).as_matrix()
    turned = replace(model, nodes=model.nodes @ turn.T + (9.0, 0.0, 1.0), normals=None)
    assert np.allclose(turned.inertia, turn @ exact @ turn.T, rtol=1e-12)


def test_inertia_is_that_of_the_motion():
    """Angular momentum and energy of a spin about the centre, as every run observes them."""
    omega = np.array([0.3, -0.5, 0.8])
    model = warped_patch(np.random.default_rng(1))
    system = make_system(spinning(model, omega, about=model.centre))
    observed = system.observe(system.initial_state()).observed
    assert np.allclose(observed.angular_momentum, model.inertia @ omega, rtol=1e-12)
    assert observed.kinetic == pytest.approx(0.5 * omega @ model.inertia @ omega, rel=1e-12)
    assert np.allclose(observed.linear_momentum, 0.0, atol=1e-14)


def test_strip_shows_itself():
    model, _ = strip(10.0, 4, lambda X, tip: line_load(X, tip, (0.0, 0.0, 4.0)))
    linear = solve_linear(model)
    assert repr(linear).startswith("<LinearResult: 10 nodes, ")
    assert repr(stresses(model, linear.state)).startswith("<Stresses: 4 elements, von Mises ")
