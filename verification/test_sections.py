"""Laminates and sections: stiffness by hand, input, layers, files."""

from dataclasses import replace

import numpy as np
import pytest

from corovec import (
    Gravity,
    InputError,
    Lamina,
    Laminate,
    Model,
    Ply,
    Section,
    Settings,
    Strength,
    StressProbe,
    Support,
    layer_stresses,
    line_load,
    load_control,
    read,
    read_model,
    run_model,
    simulate,
    solve_linear,
    stresses,
)
from corovec.solver.kernels.arguments import STATIC
from corovec.verification.helpers import (
    assemble,
    central_differences,
    make_system,
    relative,
    stiffness,
)
from corovec.verification.models import folded, rectangle, spinning
from corovec.verification.shells import CLAMPED
from corovec.verification.suites.sections import CARBON, Q_bar, at, bimetal, free, plate, pulled

STRENGTH = Strength(1500e6, 1200e6, 50e6, 200e6, 70e6)
H = 1e-3


def test_cross_ply_by_hand():
    """[0/90] of two plies h: A = h (Q0 + Q90), B = h^2/2 (Q90 - Q0), D = h^3/3 (Q0 + Q90)."""
    Q = CARBON.stiffness
    nu21 = CARBON.nu12 * CARBON.E2 / CARBON.E1
    assert Q[0, 0] == pytest.approx(CARBON.E1 / (1.0 - CARBON.nu12 * nu21))
    assert Q[0, 1] == pytest.approx(CARBON.nu12 * Q[1, 1]) and Q[2, 2] == pytest.approx(CARBON.G12)
    turned = Q[[1, 0, 2]][:, [1, 0, 2]]
    ABD = Laminate([Ply(CARBON, H), Ply(CARBON, H, 90.0)]).ABD
    np.testing.assert_allclose(ABD[:3, :3], H * (Q + turned), rtol=1e-12, atol=1e-3)
    np.testing.assert_allclose(ABD[:3, 3:], 0.5 * H**2 * (turned - Q), rtol=1e-12, atol=1e-6)
    np.testing.assert_allclose(ABD[3:, 3:], H**3 / 3.0 * (Q + turned), rtol=1e-12, atol=1e-9)


def test_angle_ply_by_hand():
    """[45/-45]: A_16 = 0, and B has nothing but B_16 = B_26 = -h^2 Q_16(45)."""
    ABD, Q = Laminate([Ply(CARBON, H, 45.0), Ply(CARBON, H, -45.0)]).ABD, Q_bar(45.0)
    np.testing.assert_allclose(ABD[:2, :2], 2.0 * H * Q[:2, :2], rtol=1e-12)
    np.testing.assert_allclose(ABD[:2, 2], 0.0, atol=1e-9 * ABD[0, 0])
    expected = np.zeros((3, 3))
    expected[:2, 2] = expected[2, :2] = -H**2 * Q[:2, 2]
    np.testing.assert_allclose(ABD[:3, 3:], expected, atol=1e-12 * H * ABD[0, 0])
    assert Q[0, 2] == pytest.approx(0.25 * (CARBON.stiffness[0, 0] - CARBON.stiffness[1, 1]))


def test_transverse_shear():
    """5/6 G h of one material wherever it lies; a soft core between stiff faces bears all of it."""
    metal = Lamina.isotropic(70e9, 0.3, 2700.0)
    for plies in ([Ply(metal, 0.1)], [Ply(metal, 0.02), Ply(metal, 0.08, 30.0)]):
        np.testing.assert_allclose(Laminate(plies, offset=0.3).shear,
                                   5.0 / 6.0 * metal.G12 * 0.1 * np.eye(2), atol=1e-3)
    core = Lamina.isotropic(70e3, 0.3, 50.0)
    sandwich = Laminate([Ply(metal, 1e-4), Ply(core, 0.02), Ply(metal, 1e-4)])
    # tau is constant in the core, q / d between the middles of the faces
    assert sandwich.shear[0, 0] == pytest.approx(core.G12 * 0.0201**2 / 0.02, rel=1e-3)


def test_one_ply_is_the_plain_plate():
    """To rounding: constants, recovery, mass; in any direction, and split into layers."""
    plain = rectangle(2.0, 1.0, (3, 2))
    metal = Lamina.isotropic(1e6, 0.3, 1.0)
    for plies in ([Ply(metal, 0.1, 20.0)], [Ply(metal, 0.03), Ply(metal, 0.07, 70.0)]):
        model = Model(plain.nodes, plain.quads,
                      sections=[Section(Laminate(plies), direction=(1.0, 2.0, 0.0))])
        assert len(model.elements.coupling) == 0 and not model.heated
        for name in ("y0", "r0", "l", "Q", "k_b", "mass", "rotary"):
            ours, theirs = getattr(model.elements, name), getattr(plain.elements, name)
            np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-11 * np.abs(theirs).max())
        for ours, theirs in zip(model.recovery[:3], plain.recovery[:3]):
            np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-11 * np.abs(theirs).max())


def test_plain_models_have_none_of_it():
    model = folded()
    assert model.elements.coupling.shape == (0, 5, 8, 8) and model.recovery.C is None
    assert model.law.strain is None


def test_sections_beside_plain_elements():
    """A section on some elements, the others as they are; replace keeps it."""
    plain = rectangle(2.0, 1.0, (2, 1))
    model = replace(plain, sections=[Section(Laminate([Ply(CARBON, 2e-3)]), elements=[1])])
    again = replace(model, supports=[])
    assert again.thickness.tolist() == [0.1, 2e-3] and again.density.tolist() == [1.0, 1600.0]
    np.testing.assert_array_equal(model.elements.k_b[..., 0], plain.elements.k_b[..., 0])


def test_directions_follow_vectors_and_fields():
    """Fibres along a vector that is projected on a folded plate, or along one for each element."""
    shell, laminate = folded(), Laminate([Ply(CARBON, 0.01)])
    along = Model(shell.nodes, shell.quads, sections=[Section(laminate, direction=(1, 0, 1))])
    field = [(1.0, 0.0, 0.0)] * 4 + [(0.0, 0.0, 1.0)] * 4
    each = Model(shell.nodes, shell.quads, sections=[Section(laminate, direction=field)])
    np.testing.assert_allclose(along.elements.l, each.elements.l, rtol=1e-12,
                               atol=1e-12 * np.abs(each.elements.l).max())
    across = Model(shell.nodes, shell.quads, sections=[Section(laminate, direction=(0, 1, 0))])
    assert np.abs(across.elements.l - each.elements.l).max() > 0.1 * np.abs(each.elements.l).max()


def test_matrix_at_a_junction():
    """Static tangent, and a mass that outweighs it, of a coupled, offset and heated fold."""
    shell = folded()
    laminate = Laminate([Ply(CARBON, 0.004), Ply(CARBON, 0.006, 40.0)], offset=0.01)
    model = Model(shell.nodes, shell.quads,
                  sections=[Section(laminate, direction=(1, 2, 1), temperature=30.0)])
    system = make_system(model)
    state, n_dof = system.initial_state(), system.numbering.n_dof
    for factors in (STATIC, STATIC._replace(delta=1e12, mass=1e12)):
        K = stiffness(system, state, factors)
        J = central_differences(lambda delta, factors=factors: -assemble(
            system, state, factors, delta, tangent=False), np.zeros(n_dof), 1e-6)
        assert relative(J, K) < 1e-6  # truncation and rounding of central differences


def test_layers_of_a_stretched_laminate():
    """[0/90/0] under n_xx: plies share it by their stiffness, and carry it together."""
    laminate = Laminate([Ply(replace(CARBON, strength=STRENGTH), H, angle) for angle in (0, 90, 0)])
    model = pulled(free(plate(2.0, 1.0, (2, 2), Section(laminate)), 2.0, 1.0), 2.0, 1e3)
    found = layer_stresses(model, solve_linear(model).state)
    strain = np.linalg.solve(laminate.ABD[:3, :3], [1e3, 0.0, 0.0])
    np.testing.assert_allclose(found.stress[:, 0], np.broadcast_to(CARBON.stiffness @ strain,
                                                                   (4, 2, 3)), rtol=1e-8, atol=1e-3)
    total = H * (2.0 * found.stress[0, 0, 0, 0] + found.stress[0, 1, 0, 1])
    assert total == pytest.approx(1e3, rel=1e-9)
    s1, s2, s12 = found.stress[0, 1, 0]
    assert found.largest[0, 1, 0] == pytest.approx(max(s2 / 50e6, -s1 / 1200e6, abs(s12) / 70e6))
    assert found.tsai_wu.shape == (4, 3, 2) and "4 elements, 3 plies" in repr(found)


def test_layers_of_a_bent_offset_plate():
    """One material, e above the nodes: sigma = 12 M (z - e) / h^3 + F/h, whatever the surface."""
    h, e, force = 0.05, 0.02, 1e3
    model = plate(4.0, 1.0, (8, 2), Section(Laminate(
        [Ply(Lamina.isotropic(1e9, 0.0, 1.0), 0.5 * h)] * 2, offset=e)))
    model = replace(model, supports=[Support(at(model, 0.0), CLAMPED)],
                    loads=line_load(model.nodes, at(model, 4.0), (force, 0.0, 0.0)))
    found = layer_stresses(model, solve_linear(model).state)
    moment = -force * e
    expected = [[force / h + 6.0 * moment / h**2 * side for side in pair]
                for pair in ((-1.0, 0.0), (0.0, 1.0))]
    np.testing.assert_allclose(found.stress[..., 0], np.broadcast_to(expected, (16, 2, 2)),
                               rtol=1e-6)
    assert np.isnan(found.tsai_wu).all()


def test_layers_of_a_heated_strip():
    """Bimetal: stresses of the layers balance, n = m = 0, and jump where they meet."""
    laminate, _ = bimetal()
    model = free(plate(2.0, 0.2, (4, 1), Section(laminate, temperature=30.0)), 2.0, 0.2)
    stress = layer_stresses(model, solve_linear(model).state).stress[0, :, :, 0]
    widths = np.array([0.004, 0.006])
    assert widths @ stress.mean(axis=1) == pytest.approx(0.0, abs=1e-6 * np.abs(stress).max())
    assert stress[0, 1] > 0.0 > stress[1, 0]  # what grows less is pulled where they meet


@pytest.mark.parametrize(("stress", "index"), [
    ((1500e6, 0, 0), 1.0), ((-1200e6, 0, 0), 1.0), ((0, 50e6, 0), 1.0), ((0, -200e6, 0), 1.0),
    ((0, 0, 70e6), 1.0), ((0, 0, -35e6), 0.25)])
def test_tsai_wu_at_the_strengths(stress, index):
    assert STRENGTH.tsai_wu(np.array(stress, dtype=float)) == pytest.approx(index)


def test_largest_stress():
    stress = np.array([(750e6, 0.0, 0.0), (0.0, -100e6, 63e6), (-600e6, 40e6, 0.0)])
    np.testing.assert_allclose(STRENGTH.largest(stress), (0.5, 0.9, 0.8))


def test_probe_and_frames_agree_with_stresses(tmp_path):
    """Moments of a coupled section in every way that gives them."""
    laminate = Laminate([Ply(CARBON, 2e-3, 0.0), Ply(CARBON, 2e-3, 50.0)])
    model = plate(1.0, 0.5, (2, 1), Section(laminate, temperature=20.0))
    model = spinning(model, (0.0, 0.0, 3.0))
    output = tmp_path / "run.h5"
    result = simulate(model, Settings(dt=1e-4, end_time=1e-3, stresses=True), output=output,
                      probes={"one": StressProbe(0)})
    found = stresses(model, result.state)
    np.testing.assert_allclose(result.probes["one"]["membrane_force"][-1], found.n[0], rtol=1e-6)
    np.testing.assert_allclose(result.probes["one"]["moment"][-1], found.m[0], rtol=1e-6)
    np.testing.assert_allclose(read(output)["von_mises"][-1], found.von_mises, rtol=1e-6)


def test_heat_resumes(tmp_path):
    """A path of a heated strip that was stopped goes on from its last row."""
    laminate, _ = bimetal()
    model = plate(2.0, 0.2, (6, 1), Section(laminate, temperature=100.0))
    model = replace(model, supports=[Support(at(model, 0.0), CLAMPED)],
                    loads=line_load(model.nodes, at(model, 2.0), (0.0, 0.0, 50.0)))
    whole = load_control(model, [0.5, 1.0], output=tmp_path / "a.h5")

    def stop(factor, last):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        load_control(model, [0.5, 1.0], progress=stop, output=tmp_path / "b.h5")
    again = load_control(model, [0.5, 1.0], output=tmp_path / "b.h5", resume=True)
    np.testing.assert_array_equal(again.displacement[-1], whole.displacement[-1])
    hot = read(tmp_path / "a.h5")["displacement"][0]
    assert hot[at(model, 2.0)[0], 2] < -0.1  # the row of zero load is the heated shape


PLIES = [Ply(CARBON, H)]


@pytest.mark.parametrize(("make", "message"), [
    (lambda: replace(CARBON, E2=-1.0), r"lamina: E2 must be positive \[Pa\]"),
    (lambda: replace(CARBON, nu12=4.0), r"lamina: nu12 must be below sqrt\(E1/E2\) = 3.74"),
    (lambda: Lamina.isotropic(1e9, 0.5, 1.0), r"lamina: poisson must lie in \(-1, 0.5\)"),
    (lambda: Strength(1.0, 1.0, 1.0, 0.0, 1.0), r"strength: Yc must be positive \[Pa\]"),
    (lambda: Ply(CARBON, 0.0), r"ply: thickness must be positive \[m\]"),
    (lambda: Ply("carbon", H), "ply: lamina must be a Lamina, is 'carbon'"),
    (lambda: Laminate([]), "laminate: plies must not be empty"),
    (lambda: Laminate(Ply(CARBON, H)), "laminate: plies must be a list of Ply"),
    (lambda: Section(PLIES), "section: laminate must be a Laminate"),
    (lambda: shell(), "thickness is missing"),
    (lambda: shell(Section(Laminate(PLIES), elements=[0])),
     "thickness is missing: element 1 is in no section"),
    (lambda: shell(Section(Laminate(PLIES), elements=[0, 7])), r"sections\[0\]: element 7 does"),
    (lambda: shell(Section(Laminate(PLIES)), Section(Laminate(PLIES), elements=[1])),
     "element 1 is in sections 0 and 1"),
    (lambda: shell(Section(Laminate(PLIES), direction=(0, 0, 1))),
     r"sections\[0\]: direction is none in the surface of element 0"),
    (lambda: shell(Section(Laminate(PLIES), direction=[(1, 0, 0)])),
     r"sections\[0\]: direction: 1 given, one an element of the section \(2\) needed"),
    (lambda: shell(Section(Laminate(PLIES)), membrane="strain"),
     "sections take the membrane field stress, not strain"),
    (lambda: layer_stresses(rectangle(2.0, 1.0, (2, 1)), None), "state must be a Configuration"),
    (lambda: shell(Section(Laminate(PLIES, offset=1e-4)), loads=[Gravity((0.0, 0.0, -9.81))]),
     r"load 0: gravity does not know the moment of sections\[0\], .* 0.0001 m above the nodes")])
def test_wrong_input(make, message):
    with pytest.raises(InputError, match=message):
        make()


def shell(*sections, **options):
    """Two elements with these sections."""
    flat = rectangle(2.0, 1.0, (2, 1))
    return Model(flat.nodes, flat.quads, sections=sections, **options)


FILE = """
name = "strip"
supports = [{ fix = "clamped", where = { x = 0.0 } }]
steps = [{ kind = "static", increments = 1 }]

[[geometry.blocks]]
corners = [[0, 0, 0], [2, 0, 0], [2, 0.2, 0], [0, 0.2, 0]]
divisions = [10, 2]
group = "strip"

[materials.steel]
E1 = 200e9
nu12 = 0.0
density = 1.0
alpha1 = 12e-6
alpha2 = 0.0

[materials.aluminium]
E1 = 70e9
nu12 = 0.0
density = 1.0
alpha1 = 24e-6
alpha2 = 0.0

[laminates.bimetal]
plies = [{ material = "steel", thickness = 0.004 }, { material = "aluminium", thickness = 0.006 }]

[[sections]]
laminate = "bimetal"
group = "strip"
temperature = 30.0
"""


def test_model_file(tmp_path):
    path = tmp_path / "strip.toml"
    path.write_text(FILE)
    definition = read_model(path)
    run = run_model(definition)
    laminate, curvature = bimetal(across=False)
    model = definition.model(20)
    assert model.sections[0].laminate == laminate
    tip = run.static.displacement[-1][at(model, 2.0)[0], 2]
    # kappa L^2 / 2, less a part of (kappa L)^2 / 12
    assert tip == pytest.approx(-30.0 * curvature * 2.0, rel=3e-3)


@pytest.mark.parametrize(("old", "new", "message"), [
    ('material = "steel"', 'material = "wood"',
     r"laminates.bimetal.plies\[0\].material: 'wood' is not among steel, aluminium"),
    ('laminate = "bimetal"', 'laminate = "skin"', r"sections\[0\].laminate: 'skin' is not among"),
    ('group = "strip"\ntemp', 'group = "flange"\ntemp', r"sections\[0\].group: .*flange"),
    ("E1 = 70e9", "E1 = -70e9", "materials.aluminium.E1: must be positive"),
    ('group = "strip"\ntemp', 'direction = [0, 0, 1]\ntemp', "direction is none in the surface"),
    ("steps = [", "groups = { strip = { density = 2.0 } }\nsteps = [", "parameters: is missing")])
def test_wrong_files(tmp_path, old, new, message):
    path = tmp_path / "strip.toml"
    assert old in FILE
    path.write_text(FILE.replace(old, new))
    with pytest.raises(InputError, match=message):
        read_model(path)
