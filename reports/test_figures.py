"""What is drawn is what was recorded, and the table beside a figure is what is drawn."""

import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch
from matplotlib.text import Text

from corovec import InputError, ResultFileError, TimeFunction, total_energy
from corovec.benchmarks import load_case
from corovec.reports import arrows, curves
from corovec.reports.figures import (
    Curve,
    convergence,
    displacements,
    energies,
    mesh_and_loads,
    momenta,
    save,
    sequence,
    total_energies,
)
from corovec.reports.recording import Recording
from corovec.reports.space import Space, View, bounds, hidden
from corovec.solver.model.loads import NodalLoad
from corovec.verification.models import cross_code_plate

COMPONENTS = [f"{name}_{c}" for name in ("linear_momentum", "angular_momentum",
                                         "angular_momentum_printed") for c in "xyz"]


def lines(axes):
    """(x, y) of the curves of a panel."""
    return [np.transpose(line.get_data()) for line in axes.lines]


def polygons(axes):
    return next(item for item in axes.collections if isinstance(item, PolyCollection))


def test_energies_are_the_history(recordings):
    history = recordings[0].history
    figure, data = energies(history, unloaded_at=1.0)
    drawn = lines(figure.axes[0])
    for line, column in zip(drawn, ("total_energy", "external_work", "kinetic_energy",
                                    "strain_energy")):
        assert np.array_equal(line[:, 0], history["time"])
        assert np.array_equal(line[:, 1], data[column])
    assert np.array_equal(data["kinetic_energy"], history["kinetic_energy"])
    assert np.array_equal(data["total_energy"], total_energy(history))
    assert len(drawn) == 4 and figure.axes[0].get_xlim() == (0.0, history["time"][-1])


def greys(lines):
    """Brightness of curves in a grey print, from 0 to 1."""
    return [np.dot((0.30, 0.59, 0.11), to_rgb(line.get_color())) for line in lines]


def test_curves_that_coincide_are_told_apart_in_grey(recordings):
    """Each is seen beside the narrower and darker ones upon it."""
    history = recordings[0].history
    for lower, upper in (
            energies(history)[0].axes[0].lines[:2],
            displacements(recordings, {"S": (10.0, 7.0, 0.0)})[0].axes[0].lines,
            total_energies(recordings)[0].axes[0].lines,
            *np.reshape(momenta(history)[0].axes[1].lines, (3, 2))):
        assert lower.get_linewidth() > upper.get_linewidth() + 1.0
        assert np.diff(greys([upper, lower])) > 0.2
    x, y, z = momenta(history)[0].axes[0].lines
    assert x.get_linewidth() > y.get_linewidth() > z.get_linewidth()
    assert np.all(np.diff(greys([z, y, x])) > 0.2)


def swinging(history, periods):
    """A history like ``history`` whose energies swing so often."""
    long = np.resize(history, 2001)
    long["time"] = np.linspace(0.0, 1.2, 2001)
    long["kinetic_energy"] = 1.0 + np.sin(2.0 * np.pi * periods * long["time"] / 1.2)
    return long


def test_last_of_many_swings_are_enlarged(recordings):
    history = recordings[0].history
    whole, window = energies(swinging(history, 60))[0].axes
    assert whole.get_xlim() == (0.0, 1.2) and len(whole.lines) == len(window.lines) == 4
    assert window.get_xlim() == pytest.approx((1.2 * (1.0 - 6.75 / 60), 1.2), abs=0.01)
    assert whole.lines[2].get_linewidth() < window.lines[2].get_linewidth()
    assert len(energies(swinging(history, 30))[0].axes) == 1

    contents = dict(recordings[0].contents, history=swinging(history, 60))
    contents["frame_steps"] = np.arange(0, 2001, 5)
    contents["displacement"] = np.sin(100.0 * np.pi * np.linspace(0.0, 1.0, 401))[
        :, None, None] * np.ones((1, *recordings[0].nodes.shape))
    figure, data = displacements([Recording("long", contents)], {"O": (0.0, 0.0, 0.0)}, {"O": "xz"})
    assert [axes.get_xlim()[0] > 1.0 for axes in figure.axes] == [False, True, False, True]
    assert len(data) == 2 * 401


def test_energies_until_an_end(recordings):
    history = recordings[0].history
    assert energies(history, end=0.5)[1]["time"].max() == pytest.approx(0.5)
    for wrong in (2.0, 0.0):
        with pytest.raises(InputError, match="ends at 1.2 s"):
            energies(history, end=wrong)


def test_long_histories_are_thinned_evenly_and_keep_their_end(recordings, monkeypatch):
    monkeypatch.setattr(curves, "MOST_ROWS", 20)
    time = energies(recordings[0].history)[1]["time"].to_numpy()
    assert np.array_equal(time, recordings[0].history["time"][::4])
    monkeypatch.setattr(curves, "MOST_ROWS", 9)
    time = energies(recordings[0].history)[1]["time"].to_numpy()
    assert len(time) <= 10 and time[-1] == recordings[0].history["time"][-1]


def test_momenta_have_both_definitions(recordings):
    history = recordings[0].history
    figure, data = momenta(history, unloaded_at=1.0)
    for name in COMPONENTS:
        assert np.array_equal(data[name], history[name[:-2]][:, "xyz".index(name[-1])])
    upper, middle, lower = (lines(axes) for axes in figure.axes)
    difference = history["angular_momentum_printed"] - history["angular_momentum"]
    assert np.abs(difference).max() > 0.1
    assert len(upper) == 3 and len(middle) == 6
    for k in range(3):
        assert np.array_equal(lower[k][:, 1], difference[:, k])


def test_momenta_that_are_rounding_are_drawn_as_zero(recordings):
    history = recordings[0].history.copy()
    history["linear_momentum"] = 1e-14 * np.sin(history["time"])[:, None]
    low, high = momenta(history)[0].axes[0].get_ylim()
    assert min(-low, high) > 1e3 * 1e-14


def test_displacements_are_those_of_the_node(recordings):
    figure, data = displacements(recordings, {"S": (10.0, 7.0, 0.0)}, {"S": "zx"})
    assert len(figure.axes) == 2 and all(len(axes.lines) == 2 for axes in figure.axes)
    for recording, size in zip(recordings, (30, 120)):
        node = np.argmin(np.linalg.norm(recording.nodes - (10.0, 7.0, 0.0), axis=1))
        rows = data[(data["elements"] == size) & (data["component"] == "z")]
        assert np.array_equal(rows["displacement"], recording.displacement[:, node, 2])
        assert rows["time"].to_numpy() == pytest.approx(np.linspace(0.0, 1.2, 13))
    assert np.array_equal(lines(figure.axes[0])[1][:, 1], rows["displacement"])


def test_a_point_without_a_node_is_named_with_its_mesh(recordings):
    with pytest.raises(InputError, match=r"l30 \(30 elements\): no node at \[0.5, 0.5, 0.0\]"):
        displacements(recordings[::-1], {"M": (0.5, 0.5, 0.0)})


def test_total_energies_of_meshes(recordings):
    figure, data = total_energies(recordings)
    whole, free = figure.axes
    for axes in (whole, free):
        for line, recording in zip(lines(axes), recordings):
            assert np.array_equal(line[:, 1], total_energy(recording.history))
    assert set(data["elements"]) == {30, 120}


def test_energies_after_unloading_fill_a_panel(recordings):
    """In joules on the left, relative to the finest mesh on the right."""
    _, free = total_energies(recordings)[0].axes
    ends = [total_energy(recording.history)[-1] for recording in recordings]
    assert free.get_xlim() == (1.0, recordings[0].history["time"][-1])
    assert abs(np.diff(ends)[0]) > 0.6 * np.ptp(free.get_ylim())
    beside, = free.child_axes
    beside.figure.draw_without_rendering()
    assert beside.get_ylim() == pytest.approx(
        [100.0 * (energy / ends[1] - 1.0) for energy in free.get_ylim()])
    contents = {**recordings[0].contents}
    contents["description"] = {**contents["description"], "unloaded_at": np.inf}
    assert len(total_energies([Recording("loaded", contents)])[0].axes) == 1


def test_convergence_line_is_the_regression():
    """Through the mean of the logarithms, with the slope given; the reference has no place."""
    n, errors = np.array([30, 120, 480, 1920]), np.array([0.03, 0.011, 0.002, 0.0])
    slope, offset = np.polyfit(np.log(np.sqrt(n[:3])), np.log(errors[:3]), 1)
    figure, data = convergence([Curve("ours", n, errors, slope)])
    assert data["fit"].to_numpy() == pytest.approx(np.exp(offset) * np.sqrt(n[:3])**slope)
    points, line = lines(figure.axes[0])
    assert np.array_equal(points[:, 1], errors[:3]) and np.array_equal(line[:, 1], data["fit"])
    assert f"{slope:.2f}" in figure.axes[0].get_legend().get_texts()[1].get_text()
    figure, data = convergence([Curve("two", n[:3], errors[:3], None)])
    assert len(figure.axes[0].lines) == 1 and data["fit"].isna().all()


def test_sequence_is_deformed_and_coloured_by_energy_over_area(recordings):
    recording = recordings[1]
    figure, data = sequence(recording, (0.0, 0.61, 1.2))
    assert np.allclose(np.unique(data["time"]), (0.0, 0.6, 1.2))
    x = (recording.nodes + recording.displacement[[0, 6, 12]])[:, recording.quads]
    assert np.array_equal(data[["x", "y", "z"]].to_numpy().reshape(x.shape), x)
    density = data["strain_energy_density"].to_numpy()[::4].reshape(3, 120)
    # all elements are squares of 0.5 m
    assert density == pytest.approx(4.0 * recording.contents["strain_energy"][[0, 6, 12]],
                                    rel=1e-12)
    panels = [axes for axes in figure.axes if axes.collections and axes.get_aspect() == 1.0]
    values = np.concatenate([polygons(axes).get_array() for axes in panels])
    assert sorted(values) == pytest.approx(sorted(density.ravel()))


def travelling(recording, metres):
    """A recording that goes so far along X, in 13 even frames."""
    contents = dict(recording.contents)
    away = np.linspace(0.0, metres, 13)[:, None, None] * [1.0, 0.0, 0.0]
    contents["displacement"] = contents["displacement"] + away
    return Recording("away", contents)


def test_sequence_along_a_way(recordings):
    """Each instant has a panel about its centre, and a dot on the way with its time."""
    recording = travelling(recordings[0], 60.0)
    figure, data = sequence(recording, (0.0, 0.6, 1.2), view=(30.0, -60.0))
    panels = [axes for axes in figure.axes if axes.get_title()]
    assert [axes.get_title() for axes in panels] == ["0 s", "0.6 s", "1.2 s"]
    corners = data[["x", "y", "z"]].to_numpy().reshape(3, -1, 3)
    centres = data[["centre_x", "centre_y", "centre_z"]].to_numpy().reshape(3, -1, 3)[:, 0]
    assert centres == pytest.approx(corners.mean(axis=1))  # of elements of one size
    view = View(30.0, -60.0)
    for axes, own, centre in zip(panels, corners, centres):
        drawn = np.concatenate([path.vertices[:4] for path in polygons(axes).get_paths()])
        assert np.sort(drawn, axis=0) == pytest.approx(np.sort(view(own - centre), axis=0))
        assert axes.get_xlim() == panels[0].get_xlim()
    way, = (axes for axes in figure.axes if {"0 s", "0.6 s", "1.2 s"} < {
        text.get_text() for text in axes.texts})
    assert any(np.array_equal(line, view(centres)) for line in lines(way))
    assert len(polygons(way).get_paths()) == 90


def test_shells_along_a_way_stand_clear_of_each_other(recordings):
    """All 13 instants have panels and dots; 20 m are room for the first, the last and few more."""
    figure, data = sequence(travelling(recordings[0], 20.0), np.linspace(0.0, 1.2, 13))
    way = next(axes for axes in figure.axes if "X [m]" in {t.get_text() for t in axes.texts})
    shells = np.reshape([path.vertices[:4] for path in polygons(way).get_paths()], (-1, 120, 2))
    assert 2 <= len(shells) <= 3 and len(set(data["time"])) == 13
    left, right = shells[:, :, 0].min(axis=1), shells[:, :, 0].max(axis=1)
    order = np.argsort(left)
    assert np.all(right[order][:-1] < left[order][1:])
    assert sum(bool(axes.get_title()) for axes in figure.axes) == 13


def test_sequence_magnifies(recordings):
    once, thrice = (sequence(recordings[0], (0.6,), scale)[1] for scale in (1.0, 3.0))
    rest = sequence(recordings[0], (0.6,), 0.0)[1]
    assert (thrice["x"] - rest["x"]).to_numpy() == pytest.approx(
        3.0 * (once["x"] - rest["x"]).to_numpy())


@pytest.mark.parametrize("time", [-0.1, 1.3])
def test_sequence_outside_the_run(recordings, time):
    with pytest.raises(InputError, match=f"time {time:g} s is not in l30, which is recorded from 0 "
                                         "to 1.2 s"):
        sequence(recordings[0], (0.0, time))


def test_static_paths_are_drawn_over_the_load_factor(static_path):
    recording = Recording.open(static_path)
    assert np.array_equal(energies(recording.history)[1]["factor"], [0.0, 0.25, 0.5, 1.0])
    data = displacements([recording], {"tip": (10.0, 0.0, 0.0)}, {"tip": "z"})[1]
    assert np.all(np.diff(data["displacement"]) > 0.0) and data["factor"].max() == 1.0
    assert set(sequence(recording, (0.5, 1.0))[1]["factor"]) == {0.5, 1.0}
    with pytest.raises(InputError, match="no momenta"):
        momenta(recording.history)


def test_runs_beside_static_paths_are_refused(recordings, static_path):
    with pytest.raises(InputError, match="cannot share a figure"):
        displacements([recordings[0], Recording.open(static_path)], {"O": (0.0, 0.0, 0.0)})


def test_mesh_shows_the_printed_loads():
    case = load_case("l-plate")
    figure, data = mesh_and_loads(case.model(30), case)
    loads = data[data["item"] == "load"].set_index("name")
    assert loads.loc["P1", ["fx", "fy", "fz"]].tolist() == [-15.0, 0.0, 5.0]
    assert loads.loc["P1", ["x", "y", "z"]].tolist() == [10.0, 7.0, 0.0]
    assert data[data["item"] == "function"]["value"].tolist() == [0.0, 5.0, 0.0]
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert {"P1", "P2", "P3", "P4", "P5", "P6", "S"} < set(texts)
    assert sum(text.arrow_patch is not None for text in figure.axes[0].texts) == 6
    assert np.array_equal(data.loc[data["item"] == "element", "name"].unique(), np.arange(30))


def overlap(one, two):
    """Common area of two texts as they are printed."""
    a, b = (text.get_window_extent().get_points() for text in (one, two))
    return np.prod(np.maximum(np.minimum(a[1], b[1]) - np.maximum(a[0], b[0]), 0.0))


@pytest.mark.parametrize("name", ["l-plate", "ruler", "hemisphere", "plates"])
def test_names_of_loads_are_clear_of_all_other_texts(name):
    case = load_case(name)
    figure, _ = mesh_and_loads(case.model(case.defaults.elements), case)
    figure.draw_without_rendering()
    texts = [text for text in figure.axes[0].texts if text.get_text()]
    named = [text for text in texts if text.get_text() in {
        *case.points, *(load.name for load in case.loads)}]
    assert len(named) == len(case.points) + len(case.loads)
    assert not any(overlap(one, other) for one in named for other in texts if other is not one)


def test_what_is_behind_the_shell_is_hollow():
    """Of the hemisphere seen from -Y: B and its load, which are on the far side."""
    case = load_case("hemisphere")
    axes = mesh_and_loads(case.model(1024), case, view=(20.0, -70.0))[0].axes[0]
    a, b = (line for line in axes.lines if line.get_marker() == "o")
    assert a.get_markerfacecolor() == a.get_color() and b.get_markerfacecolor() == "white"
    p1, p2, _, p4 = (text.arrow_patch for text in axes.texts if text.arrow_patch)
    assert p2.get_linestyle() != "solid" == p1.get_linestyle() == p4.get_linestyle()


def test_hidden_is_what_elements_lie_before():
    square = np.array([[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]], dtype=float)
    points = [(0.5, 0.4, -1.0), (0.5, 0.4, 1.0), (0.5, 0.4, 0.0), (1.5, 0.4, -1.0)]
    assert hidden(View(90.0, -90.0), points, square).tolist() == [True, False, False, False]
    assert not hidden(View(0.0, -90.0), points, square).any()  # edge-on it covers nothing


def test_arrows_have_a_scale_for_each_unit():
    """As long on paper as an arrow of that size square to the eye; forces and forces per length
    apart."""
    case = load_case("plates")
    model = case.model(432)
    loads = arrows.of_case(model, case)
    point = loads[0]._replace(unit="N", vectors=np.array([[30.0, 0.0, 0.0]]))
    scales = arrows.scales(model, [*loads, point])
    line = max(np.linalg.norm(load.vectors, axis=1).max() for load in loads)
    assert scales == pytest.approx({"N/m": arrows.LONGEST * model.size / line,
                                    "N": arrows.LONGEST * model.size / 30.0})
    assert [arrows.rounded(size) for size in (30.0, 4.9, 0.1, 42313.0)] == pytest.approx(
        [20.0, 2.0, 0.1, 20000.0])
    figure, data = mesh_and_loads(model, case)
    said = [text.get_text() for axes in figure.axes for text in axes.findobj(Text)]
    assert f"force {arrows.rounded(line):g} N/m" in said
    assert not any(text.endswith(" N") for text in said)
    assert set(data.loc[data["item"] == "load", "unit"]) == {"N/m"}
    reference, = (patch for axes in figure.axes[1:] for patch in axes.findobj(FancyArrowPatch))
    figure.draw_without_rendering()
    drawn = reference.get_transform().transform([(0.0, 0.0), (arrows.rounded(line) * scales["N/m"],
                                                              0.0)])
    metre = figure.axes[0].transData.transform([(0.0, 0.0), (1.0, 0.0)])
    assert np.ptp(drawn[:, 0]) == pytest.approx(
        np.ptp(metre[:, 0]) * arrows.rounded(line) * scales["N/m"])


def test_line_loads_are_even_along_their_line():
    case = load_case("ruler")
    data = mesh_and_loads(case.model(120), case)[1]
    edge = data[(data["item"] == "load") & (data["name"] == "edge")]
    assert len(edge) == 5 and edge["fz"].nunique() == 1


def test_loads_of_an_own_model_are_its_nodal_forces():
    plate = cross_code_plate(1)
    _, data = mesh_and_loads(plate)
    loads = data[data["item"] == "load"]
    assert len(loads) == len(plate.loads)
    peak = max(plate.loads[0].history.values)
    assert loads[["fx", "fy", "fz"]].to_numpy() == pytest.approx(
        np.array([load.force for load in plate.loads]) * peak)
    assert isinstance(plate.loads[0], NodalLoad)
    assert isinstance(plate.loads[0].history, TimeFunction)


@pytest.mark.parametrize("angles", [(30.0, -60.0), (90.0, 0.0), (-10.0, 200.0)])
def test_view_is_an_orthogonal_projection(angles):
    view = View(*angles)
    axes = np.vstack([view.screen, view.eye])
    assert np.abs(axes @ axes.T - np.eye(3)).max() < 1e-15
    assert np.linalg.det(axes) == pytest.approx(1.0)


@pytest.mark.parametrize("size", [1e-8, 1.0, 1e9])
def test_numbers_along_the_edges_are_metres(size):
    """Of small and large meshes as well: no power of ten is taken out of them."""
    box = size * np.array([np.zeros(3), np.ones(3)])
    space = Space(Figure().add_subplot(), View(30.0, -60.0), box)
    numbers = {float(text.get_text().replace("−", "-")) for text in space.axes.texts
               if "[m]" not in text.get_text()}
    assert max(numbers) == pytest.approx(size)


def test_nearer_elements_cover_farther_ones():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    near, far = square + [0.0, 0.0, 1.0], square
    view = View(60.0, -60.0)
    space = Space(Figure().add_subplot(), view, bounds(near, far))
    drawn = space.elements(np.stack([near, far])[None], array=np.array([[1.0, 0.0]]))
    assert drawn.get_array().tolist() == [0.0, 1.0]
    assert drawn.get_paths()[1].vertices[:4] == pytest.approx(view(near))
    assert space.axes.get_aspect() == 1.0


def test_files_hold_the_data_and_are_the_same_every_time(recordings, tmp_path):
    written = []
    for k in range(2):
        figure, data = energies(recordings[0].history)
        written.append(save(figure, data, tmp_path, f"same-{k}", ("svg", "png", "pdf")))
    first, second = ([path.read_bytes() for path in paths] for paths in written)
    assert first == second
    assert [path.suffix for path in written[0]] == [".svg", ".png", ".pdf", ".csv"]
    assert b"<svg" in first[0] and b"<image" not in first[0] and first[1][:4] == b"\x89PNG"
    table = pd.read_csv(written[0][-1], dtype=str).astype(float)
    pd.testing.assert_frame_equal(table, data, check_exact=True)


def test_save_refuses(recordings, tmp_path):
    figure, data = energies(recordings[0].history)
    with pytest.raises(InputError, match="format 'eps' is unknown"):
        save(figure, data, tmp_path, "a", ("eps",))
    save(figure, data, tmp_path, "a", ("svg",))
    with pytest.raises(ResultFileError, match="a.svg exists"):
        save(figure, data, tmp_path, "a", ("svg",))
    save(figure, data, tmp_path, "a", ("svg",), overwrite=True)
    with pytest.raises(ResultFileError, match="no folder"):
        save(figure, data, tmp_path / "none", "a")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.csv", "a.svg"]
