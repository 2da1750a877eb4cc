"""The paper's benchmarks as data: meshes, loads, provenance, calibration, bad files."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from corovec import InputError, ResultFileError
from corovec.benchmarks import FOLDER, case_names, load_case
from corovec.convergence import calibration, cli
from corovec.convergence.calibration import calibrate, energy_after_unloading, find_factor
from corovec.solver.input.files import calibrated_text, read_model
from corovec.solver.input.model_file import Calibration
from corovec.solver.model.mesh import line_nodes
from corovec.verification.helpers import corovec

NODES = {"l-plate": 48, "ruler": 31 * 5, "hemisphere": 1088, "plates": 507}
"""Of the coarsest mesh; printed for hemisphere and plates."""

FOUND = Calibration(elements=120, printed="246.57", table="Table 3", dt=1e-5, residual=1e-7,
                    dt_change=1e-5)


@pytest.mark.parametrize("name", NODES)
def test_meshes(name):
    """Node and element numbers; every named point and loaded place is on the mesh."""
    case = load_case(name)
    mesh = case.mesh(case.sizes[0])
    assert (len(mesh.nodes), len(mesh.quads)) == (NODES[name], case.sizes[0])
    assert len(case.mesh(case.sizes[1]).quads) == case.sizes[1]
    assert case.loads_on(mesh)
    for point in case.points.values():
        assert np.linalg.norm(mesh.nodes - point.value, axis=1).min() < 1e-12 * np.ptp(mesh.nodes)


def test_medium_ruler_has_the_printed_number_of_nodes():
    assert len(load_case("ruler").mesh(480).nodes) == 549


@pytest.mark.parametrize("name", NODES)
def test_every_parameter_has_a_provenance(name):
    """Each of the five words; values except meshes name their source."""
    rows = load_case(name).provenance()
    assert {row[3] for row in rows} <= {"printed", "derived", "assumed", "selected", "calibrated"}
    assert all(row[4] for row in rows if not row[0].startswith("mesh"))
    given = " ".join(row[0] for row in rows)
    for parameter in ("thickness", "youngs", "poisson", "density", "geometry", "(t)", "paper's dt"):
        assert parameter in given


def test_what_printed_energies_chose_is_selected():
    """The L-plate's outline and peak, by a search; the hemisphere's load, a round number kept; the
    plates' size and layout, and which of their edges are loaded."""
    for name, chosen in (("l-plate", {"geometry", "f(t)"}), ("hemisphere", {"peak of f(t)"}),
                         ("plates", {"geometry", *(f"P{k} acts along" for k in range(1, 5))})):
        rows = load_case(name).provenance()
        assert {row[0] for row in rows if row[3] == "selected"} == chosen


def resultant(name, elements):
    """Force and moment about the origin of the loads at the peak of their function of time."""
    case = load_case(name)
    mesh = case.mesh(elements)
    loads = case.loads_on(mesh)
    forces = np.array([np.multiply(load.force, max(load.history.values)) for load in loads])
    points = mesh.nodes[[load.node for load in loads]]
    return forces.sum(axis=0), np.cross(points, forces).sum(axis=0)


@pytest.mark.parametrize("elements", [120, 480])
def test_resultant_of_line_loads_on_the_ruler(elements):
    """q L on both lines; the edge is lever 0, the width's middle 0.03 m.  Rounding only."""
    q_l = load_case("ruler").histories["p"].peak.value * 0.06
    force, moment = resultant("ruler", elements)
    np.testing.assert_allclose(force, (q_l, 0.0, q_l), rtol=1e-12)
    np.testing.assert_allclose(moment, (0.03 * q_l, 0.0, -0.03 * q_l), rtol=1e-12, atol=1e-9)


def test_resultant_of_line_loads_on_the_plates():
    """Printed vectors times the lengths 3, 3, 3, 4 m and the printed peak 0.25."""
    vectors = np.array([(2, 0, 2), (-2, -4, -2), (10, 6, -1), (-1, 1, 1)])
    expected = 0.25 * np.array([3.0, 3.0, 3.0, 4.0]) @ vectors
    np.testing.assert_allclose(resultant("plates", 1728)[0], expected, rtol=1e-12)


def test_two_plates_stand_on_one():
    """Two junction lines of 7 nodes along Y on which three elements meet at every edge.

    Every plate has its own normal at each of its nodes: as many as the plates have nodes apart.
    """
    mesh = load_case("plates").mesh(432)
    nodes, quads = mesh.nodes, mesh.quads
    edges = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    sides, uses = np.unique(edges, axis=0, return_counts=True)
    junction = np.unique(sides[uses > 2])
    assert set(uses) == {1, 2, 3} and len(junction) == 14
    np.testing.assert_array_equal(np.unique(nodes[junction, 0]), (3.5, 10.5))
    np.testing.assert_array_equal(nodes[junction, 2], 0.0)
    assert len(load_case("plates").model(432).normals) == 29 * 7 + 21 * 7 + 19 * 9
    sizes = nodes[sides[:, 1]] - nodes[sides[:, 0]]
    np.testing.assert_allclose(np.linalg.norm(sizes, axis=1), 0.5, rtol=1e-12)


def nodal(mesh):
    """Nodes, quads and exact normals at the nodes of a mesh."""
    normals = np.empty_like(mesh.nodes)
    normals[mesh.quads] = mesh.normals
    return mesh.nodes, mesh.quads, normals


def test_hemisphere_is_closed_and_its_normals_are_exact():
    """Free edges are equator and rim of the hole only; normals radial, facets outward."""
    nodes, quads, normals = nodal(load_case("hemisphere").mesh(1024))
    np.testing.assert_allclose(nodes, 10.0 * normals, rtol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=1e-15)
    diagonals = nodes[quads[:, 2]] - nodes[quads[:, 0]], nodes[quads[:, 3]] - nodes[quads[:, 1]]
    assert np.einsum("ij,ij->i", np.cross(*diagonals), nodes[quads].mean(axis=1)).min() > 0.0
    edges = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    sides, uses = np.unique(edges, axis=0, return_counts=True)
    heights = nodes[sides[uses == 1], 2]
    assert len(heights) == 2 * 64
    rim = 10.0 * np.cos(np.radians(18.0))
    assert np.all((np.abs(heights) < 1e-14) | (np.abs(heights - rim) < 1e-14))


def test_hemisphere_is_symmetric():
    """x = 0 and y = 0 are mesh lines, reflections map the mesh on itself, loads balance."""
    case = load_case("hemisphere")
    nodes, quads, normals = nodal(case.mesh(1024))
    for axis in (0, 1):
        assert np.sum(np.abs(nodes[:, axis]) < 1e-12) == 2 * 17
        mirrored = nodes * np.where(np.arange(3) == axis, -1.0, 1.0)
        gaps = np.linalg.norm(mirrored[:, None] - nodes, axis=2).min(axis=1)
        assert gaps.max() < 1e-12
    model = case.model(1024)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    np.testing.assert_allclose(model.normals, normals / lengths, rtol=0.0, atol=3e-16)
    force, moment = resultant("hemisphere", 1024)
    peak = case.histories["f"].peak.value
    assert np.abs(force).max() == 0.0 and np.abs(moment).max() < 1e-12 * peak * 10.0
    outward = [float(np.dot(load.force, model.nodes[load.node])) for load in model.loads]
    np.testing.assert_allclose(outward, (10.0, -10.0, 10.0, -10.0), rtol=1e-15)


def test_line_nodes():
    mesh = load_case("ruler").mesh(120)
    nodes, quads = mesh.nodes, mesh.quads
    line = line_nodes(nodes, quads, (0.3, 0.06, 0.0), (0.0, 0.06, 0.0))
    np.testing.assert_allclose(nodes[line, 0], np.linspace(0.3, 0.0, 31), atol=1e-15)
    with pytest.raises(InputError, match="no mesh line .* no element edge joins nodes 0 and"):
        line_nodes(nodes, quads, (0.0, 0.0, 0.0), (0.3, 0.06, 0.0))
    with pytest.raises(InputError, match="no node at"):
        line_nodes(nodes, quads, (0.0, 0.0, 0.0), (0.0, 0.05, 0.0))
    with pytest.raises(InputError, match="a line from node 0 to itself"):
        line_nodes(nodes, quads, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def broken(tmp_path, *changes, name="ruler"):
    text = (FOLDER / f"{name}.toml").read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    path = tmp_path / "broken.toml"
    path.write_text(text)
    return path


def test_bad_file_gives_all_errors_at_once(tmp_path):
    path = broken(
        tmp_path, ("thickness = { value = 0.002", "thickness = { value = -0.002"),
        ("poisson = { value = 0.0,", 'poisson = { value = "none",'),
        ("density = {", "densty = {"), ('history = "p"', 'history = "g"'),
        ("times = [0.0, 0.002", "times = [0.0, 0.02"), ("dt = 1e-5", "dt = 0.0"),
        ("divisions = [30, 4]", "divisions = [30, 0]"))
    with pytest.raises(InputError) as error:
        read_model(path)
    for message in ("parameters.thickness.value: must be positive",
                    "parameters.poisson.value: must be a number, is 'none'",
                    "parameters.density: is missing",
                    "parameters.densty: is unknown, did you mean 'density'?",
                    "histories.p: TimeFunction: times (0.0, 0.02, 0.004)",
                    "defaults.dt: must be positive",
                    "geometry.blocks[0].divisions[1]: must be at least 1, is 0"):
        assert message in str(error.value)


@pytest.mark.parametrize("change, message", [
    (('history = "p"', 'history = "g"'), r"loads\[\d\].history: 'g' is not among p"),
    (("elements = 480", "elements = 481"), r"meshes\[1\]: refinement 2 has 480 elements, not 481"),
    (("elements = 120\ndt", "elements = 121\ndt"), "defaults.elements: no mesh of 121 elements"),
    (("line = {", "at = { value = [0.0, 0.0, 0.0], unit = \"m\", provenance = \"assumed\", "
                  "source = \"\" }\nline = {"), r"loads\[0\]: one place is needed, at and line"),
    (("values = [0.0, 1.0, 0.0]", "values = [0.0, 1.0]"),
     "histories.p: TimeFunction: 3 times but 2 values"),
])
def test_contradictions_in_a_file(tmp_path, change, message):
    with pytest.raises(InputError, match=message):
        read_model(broken(tmp_path, change))


def test_hemisphere_needs_one_kind_of_geometry(tmp_path):
    path = broken(tmp_path, ("[geometry.sphere]", "[other]"), name="hemisphere")
    with pytest.raises(InputError, match="other: is unknown|geometry: one of file, blocks, sphere"):
        read_model(path)


@pytest.mark.parametrize("name, change, message", [
    ("ruler", ("[[0.15, 0.0, 0.0], [0.15,", "[[0.155, 0.0, 0.0], [0.15,"),
     r"loads\[\d\].line: no node at .0.155, 0.0"),
    ("hemisphere", ("A = { value = [10.0", "A = { value = [11.0"), "points.A: no node at .11.0"),
    ("hemisphere", ("[18.0, 90.0]", "[90.0, 18.0]"),
     "geometry.sphere.polar_angles: the upper parallel comes first"),
    ("ruler", ("thickness = { value = 0.002", "thickness = { value = true"),
     "parameters.thickness.value: must be a number"),
    ("ruler", ("thickness = { value = 0.002", 'thickness = { value = "0.002"'),
     "parameters.thickness.value: must be a number"),
    ("ruler", ('thickness = { value = 0.002, unit = "m"', 'thickness = { value = 2, unit = "mm"'),
     "parameters.thickness: in 'mm', must be in 'm'"),
    ("ruler", ('unit = "m"\nprovenance', 'unit = "mm"\nprovenance'), "geometry: blocks in 'mm'"),
    ("ruler", ('42313.984198017424, unit = "N/m"', '42313.984198017424, unit = "N"'),
     r"loads\[\d\]: force .* peak in 'N': one must be in 'N/m'"),
    ("ruler", ('dt = { value = 5e-6, unit = "s"', 'dt = { value = 5, unit = "ms"'),
     "paper.dt: in 'ms', must be in 's'"),
    ("ruler", ("refinement = 2", "refinement = true"),
     r"meshes\[1\].refinement: must be an integer, is True"),
])
def test_impossible_values_in_a_file(tmp_path, name, change, message):
    with pytest.raises(InputError, match=message):
        read_model(broken(tmp_path, change, name=name))


def test_the_ruler_is_calibrated():
    """Its peak, and how it was found, are part of the model file; the source says the same."""
    case = load_case("ruler")
    peak = case.histories["p"].peak
    assert (peak.value, peak.unit, peak.provenance) == (42313.984198017424, "N/m", "calibrated")
    assert peak.source == case.calibration.source and "246.58" in peak.source
    assert case.calibration.elements == 480
    assert all(load_case(name).calibration is None for name in NODES if name != "ruler")


def test_calibrated_peak_replaces_the_assumed_one(tmp_path):
    """In a copy of the model file, which keeps its comments and everything else."""
    path = tmp_path / "hemisphere.toml"
    old = FOLDER / "hemisphere.toml"
    path.write_text(calibrated_text(old, 2.0, FOUND))
    case, before = read_model(path), read_model(old)
    assert case.calibration == FOUND
    (row,) = [row for row in case.provenance() if row[0] == "peak of f(t)"]
    assert row[1:4] == (2.0, "N", "calibrated") and "246.57" in row[4]
    assert case.model(1024).loads[0].history.values == (0.0, 2.0, 0.0)
    assert [row for row in case.provenance() if row[0] != "peak of f(t)"] == [
        row for row in before.provenance() if row[0] != "peak of f(t)"]
    assert path.read_text().startswith(old.read_text().partition("\n")[0])
    twice = calibrated_text(path, 3.0, FOUND)
    assert twice == path.read_text().replace("value = 2.0", "value = 3.0")


def test_calibration_without_a_calibrated_peak(tmp_path):
    path = broken(tmp_path, ('provenance = "calibrated"', 'provenance = "assumed"'))
    with pytest.raises(InputError, match="calibration: no history has a peak that is calibrated"):
        read_model(path)
    path = broken(tmp_path, ("dt = 2e-05", "dt = 0.0"), ("elements = 480\nprinted", "printed"))
    with pytest.raises(InputError, match="calibration.elements: is missing; "
                                         "calibration.dt: must be positive"):
        read_model(path)


def test_find_factor():
    """Exact for a power law; a hopeless target says so."""
    factor, energy = find_factor(lambda factor: 3.0 * factor**1.7, 3.0 * 1.2**1.7)
    assert factor == pytest.approx(1.2, rel=1e-6) and energy == pytest.approx(3.0 * 1.2**1.7)
    with pytest.raises(InputError, match="no load factor gives 5 J within 10 runs"):
        find_factor(lambda factor: 1.0 + 1e-3 * np.tanh(np.log(factor)), 5.0)


def test_calibration_finds_a_known_factor(monkeypatch):
    """The energy of 1.1 times the L-plate's loads, taken as printed, gives the factor 1.1 back.

    dt = 0.01 s keeps the energy to 1e-4; 1e-6 of the energy is less of the factor (E ~ factor^1.7).
    """
    target = energy_after_unloading(load_case("l-plate").model(30, 1.1), 0.01)
    text = repr(target)
    monkeypatch.setattr(calibration, "printed_results", lambda case: {
        "table": "Table 0", "elements": [30], "energy": [text]})
    factor, found = calibrate("l-plate", 30, dt=0.01)
    assert factor == pytest.approx(1.1, rel=1e-6)
    assert abs(found.residual) <= 1e-6 and found.printed == text
    with pytest.raises(InputError, match="dt 0.02 s is too long: at half the step the energy"):
        calibrate("l-plate", 30, dt=0.02)
    with pytest.raises(InputError, match="Table 0 has no energy of 120 elements"):
        calibrate("l-plate", 120)


def test_calibrate_command(tmp_path, monkeypatch):
    """Writes a model file with what was found; loads that leave nothing free are shown only."""
    def call(*arguments):
        return CliRunner().invoke(cli.calibrate, arguments)

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(calibration, "calibrate", lambda *_, **__: (0.5, FOUND))
    shown = call("ruler", "--elements", "120")
    assert shown.exit_code == 0 and "no check any more" in shown.output
    written = read_model(tmp_path / "ruler-calibrated.toml")
    assert written.calibration == FOUND
    assert written.histories["p"].peak.value == 0.5 * load_case("ruler").histories["p"].peak.value
    again = call("ruler", "--elements", "120")
    assert isinstance(again.exception, ResultFileError) and "exists" in str(again.exception)
    assert call("ruler", "--elements", "120", "--overwrite").exit_code == 0
    assert call("ruler", "--elements", "120", "--output", "own.toml").exit_code == 0
    assert (tmp_path / "own.toml").read_text() == (tmp_path / "ruler-calibrated.toml").read_text()
    run = corovec("run", str(tmp_path / "own.toml"), "--end-time", "1e-4", "--json")
    assert json.loads(run.stdout)["case"] == "own.toml"
    other = FOUND.model_copy(update={"elements": 30})
    monkeypatch.setattr(calibration, "calibrate", lambda *_, **__: (2.0, other))
    shown = call("l-plate", "--elements", "30")
    assert "Not written" in shown.output
    assert sorted(path.name for path in tmp_path.iterdir()) == ["own.toml", "ruler-calibrated.toml"]


def test_list_shows_all_cases():
    listing = corovec("list").stdout
    assert set(case_names()) >= set(NODES)
    for name in case_names():
        assert f"{load_case(name).title}" in listing
    for text in ("[printed]", "[derived]", "[assumed]", "[calibrated]", "acts along"):
        assert text in listing
