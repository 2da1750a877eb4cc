"""Joints and rigid bodies in pictures: what is drawn, where, and where it is as they move."""

import gzip
import json
from base64 import b64decode

import numpy as np
import pytest
from matplotlib import pyplot as plt

from corovec import (
    Ball,
    Cylindrical,
    Expression,
    Gravity,
    Hinge,
    Model,
    Prismatic,
    Revolute,
    RigidBody,
    RigidLink,
    Scheme,
    Settings,
    Spherical,
    Tie,
    Universal,
    block,
    cut,
    simulate,
)
from corovec.reports.colours import ENERGY, coloured
from corovec.reports.film import _scene
from corovec.reports.player import STEPS, player
from corovec.reports.recording import Recording
from corovec.reports.scenes import sequence
from corovec.reports.shells import mesh_and_loads
from corovec.reports.symbols import FEW_NAMES, MOST_NAMES, Symbols, symbols_of
from corovec.solver.model.mechanism import carried, words_of_bodies, words_of_joints
from corovec.verification.helpers import in_process

TURN = ((0.6, 0.8, 0.0), (-0.8, 0.6, 0.0), (0.0, 0.0, 1.0))


def craft(**options):
    """A plate with a hinge on a hub, which carries an arm, a slide on that, and what hangs on
    them, by joints of all kinds but those of plates alone."""
    mesh = block([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], (4, 1))
    mesh, nodes, others = cut(mesh, (1, 0, 0), (1, 1, 0))
    bodies = [RigidBody("hub", 3.0, (0.5, 0.6, 0.7), (-0.3, 0.5, 0.0), mesh.nodes_at(x=0.0)),
              RigidBody("arm", 1.0, (0.1, 0.2, 0.15), (-0.9, 0.5, 0.1), axes=TURN),
              RigidBody("slide", 0.5, (0.05, 0.05, 0.08), (-1.4, 0.5, 0.2)),
              RigidBody("ring", 0.5, (0.05, 0.05, 0.08), (-0.9, 1.4, 0.2)),
              RigidBody("pod", 0.5, (0.05, 0.05, 0.08), (-0.9, -0.4, 0.1)),
              RigidBody("bob", 0.5, (0.05, 0.05, 0.08), (-0.3, 0.5, -1.0))]
    joints = [Hinge(nodes, others, stiffness=2.0, rest=0.8, damping=0.3, name="fold"),
              Revolute("hub", "arm", (-0.5, 0.5, 0.0), (0, 1, 0), 3.0, Expression("t**2"),
                       name="shoulder"),
              Prismatic("arm", "slide", (-1.2, 0.5, 0.2), (1, 0, 0), name="rail"),
              Cylindrical("arm", "ring", (-0.9, 1.0, 0.1), (0, 1, 0), name="sleeve"),
              Universal("arm", "pod", (-0.9, 0.0, 0.1), (1, 0, 0), (0, 0, 1), name="cross"),
              RigidLink("hub", "bob", (-0.3, 0.5, -0.2), (-0.3, 0.5, -0.9), name="rod"),
              Ball("ground", "bob", (-0.3, 0.8, -1.0), name="pin")]
    return Model.of(mesh, 0.02, 1e8, 0.3, 300.0, joints=joints, bodies=bodies,
                    loads=[Gravity((0.5, 1.0, -2.0))], **options)


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """A short motion of it, in which everything turns: its model and its ``Recording``."""
    path = tmp_path_factory.mktemp("symbols") / "craft.h5"
    model = craft()
    simulate(model, Settings(dt=0.02, end_time=0.3, frame_every=3, scheme=Scheme("exact")),
             output=path)
    return model, Recording.open(path)


def at(symbols, places, item, name):
    """Places (n_frames, ..., 3) of the lines and marks of an item."""
    found = [symbol for symbol in (*symbols.lines, *symbols.marks)
             if (symbol.item, symbol.name) == (item, name)]
    return [places[:, list(symbol.points)] for symbol in found]


def test_symbols_move_with_what_they_belong_to(flown):
    """Joints stay where both of their ends are; rods and cuboids keep their lengths and turn;
    nothing of this holds of the initial places."""
    model, recording = flown
    symbols, frames = recording.symbols, np.arange(len(recording.times))
    places = recording.symbol_places(frames)
    np.testing.assert_allclose(places[0], symbols.at_first, atol=1e-12)
    node_of = dict(zip(("hub", "arm", "slide", "ring", "pod", "bob"),
                       (node for node, _ in model.body_masses)))
    for joint in model.joints[1:]:
        if isinstance(joint, RigidLink):
            continue
        own = Symbols({"joints": [{
            "name": "other", "kind": "ball joint", "ends": [None], "axes": [],
            "points": [carried(model, node_of[joint.other], joint.at, turned=False)]}],
            "bodies": []}, model.nodes)
        here = at(symbols, places, joint.kind, joint.name)[-1][:, 0]
        there = own.places(recording.positions(), recording.contents["director"])[:, 0]
        if isinstance(joint, (Prismatic, Cylindrical)):  # the place of other slides along the axis
            ends = at(symbols, places, joint.kind, joint.name)[0]
            axis = (ends[:, 1] - ends[:, 0]) / np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)[
                :, None]
            apart = there - here
            assert np.abs(apart).max() > 1e-4
            apart -= np.sum(apart * axis, axis=1)[:, None] * axis
        else:
            apart = there - here
        np.testing.assert_allclose(apart, 0.0, atol=1e-9)
        if joint.one != "ground":
            assert np.ptp(here, axis=0).max() > 1e-3
    rod, = at(symbols, places, "rigid link", "rod")[:1]
    np.testing.assert_allclose(np.linalg.norm(rod[:, 1] - rod[:, 0], axis=1), 0.7, atol=1e-9)
    edges = np.stack(at(symbols, places, "cuboid", "arm"), axis=1)
    half = np.sqrt(3.0 * np.array([0.125, 0.025, 0.075]))  # of a box: I_1 = m (b^2 + c^2)/3
    lengths = np.linalg.norm(edges[:, :, 1] - edges[:, :, 0], axis=2)
    np.testing.assert_allclose(np.sort(lengths, axis=1),
                               np.tile(np.sort(np.repeat(2.0 * half, 4)), (len(frames), 1)),
                               atol=1e-9)
    ways = edges[:, :, 1] - edges[:, :, 0]
    assert np.abs(ways[-1] - ways[0]).max() > 0.05
    assert np.abs(np.linalg.norm(ways[0] @ np.transpose(TURN), axis=1) - lengths[0]).max() < 1e-12
    hinge, end = at(symbols, places, "hinge", "fold")
    np.testing.assert_array_equal(hinge, recording.positions()[:, list(model.joints[0].nodes)])
    np.testing.assert_array_equal(end[:, 0], hinge[:, -1])  # of its axis
    ground, = at(symbols, places, "ground", "pin")
    np.testing.assert_allclose(ground[:, 0], np.tile((-0.3, 0.8, -1.0), (len(frames), 1)))


def test_axes_turn_with_their_ends(flown):
    """The axis of the shoulder stays that of both bodies, half on either side of its place; the
    two of a cross stay at right angles."""
    model, recording = flown
    places = recording.symbol_places(np.arange(len(recording.times)))
    axis, mark = at(recording.symbols, places, "revolute joint", "shoulder")
    np.testing.assert_allclose(axis.mean(axis=1), mark[:, 0], atol=1e-12)
    one, other, _ = at(recording.symbols, places, "universal joint", "cross")
    products = np.sum((one[:, 1] - one[:, 0]) * (other[:, 1] - other[:, 0]), axis=1)
    np.testing.assert_allclose(products, 0.0, atol=1e-9)
    assert np.abs((one[-1] - one[-1, 0]) - (one[0] - one[0, 0])).max() > 1e-3


def test_normals_of_single_plates_carry_axes():
    """An axis along the normal of a node of the shell turns with it, the shortest way."""
    mesh = block([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], (2, 1))
    body = RigidBody("top", 1.0, (0.1, 0.1, 0.1), (2.0, 0.0, 0.5))
    corner = mesh.nodes_at(x=2.0, y=0.0)[0]
    model = Model.of(mesh, 0.02, 1e8, 0.3, 300.0, bodies=[body],
                     joints=[Revolute(corner, "top", None, (0, 0, 1), name="pivot")])
    directors = np.stack([model.normals] * 2)
    directors[1, model.directors.first[corner]] = (0.6, 0.0, 0.8)
    places = symbols_of(model).places(np.stack([model.nodes] * 2), directors)
    (axis, _) = at(symbols_of(model), places, "revolute joint", "pivot")
    way = axis[1, 1] - axis[1, 0]
    np.testing.assert_allclose(way / np.linalg.norm(way), (0.6, 0.0, 0.8), atol=1e-12)


def test_all_kinds_have_a_symbol_a_row_of_the_key_and_rows_of_data(flown):
    model, _ = flown
    figure, data = mesh_and_loads(model)
    kinds = {"hinge", "revolute joint", "prismatic joint", "cylindrical joint", "universal joint",
             "rigid link", "ball joint", "body", "cuboid", "arm", "ground"}
    assert kinds <= set(data["item"])
    assert list(symbols_of(model).totals.values()) == [
        "1 hinge", "1 ball joint", "1 revolute joint", "1 universal joint", "1 cylindrical joint",
        "1 prismatic joint", "1 rigid link", "6 rigid bodies, 6 kg", "on the ground"]
    names = [text.get_text() for axes in figure.axes for text in axes.texts]
    assert not {"shoulder", "hub, 3 kg"} & set(names)  # of so many none has its name beside it
    assert len(model.joints) + len(model.bodies) > MOST_NAMES


def test_few_have_their_names_beside_them():
    """In a picture of a model; joints of plates have symbols too."""
    parts = [block([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], (1, 1)),
             block([(1, 1, 0), (2, 1, 0), (2, 2, 0), (1, 2, 0)], (1, 1)),
             block([(3, 0, 0), (4, 0, 0), (4, 1, 0), (3, 1, 0)], (1, 1)),
             block([(4, 0, 0), (5, 0, 0), (5, 1, 0), (4, 1, 0)], (1, 2))]
    nodes, quads = [], []
    for part in parts:
        quads.append(part.quads + sum(map(len, nodes)))
        nodes.append(part.nodes)
    x = np.concatenate(nodes)
    corner = np.flatnonzero(np.all(np.isclose(x, (1, 1, 0)), axis=1)).tolist()
    seam = [i for i in np.flatnonzero(np.isclose(x[:, 0], 4.0)).tolist() if i >= 12]
    line = [i for i in np.flatnonzero(np.isclose(x[:, 0], 4.0)).tolist() if i < 12]
    model = Model(x, np.concatenate(quads), 0.02, 1e8, 0.3, 300.0, joints=[
        Spherical(corner, name="corner"), Tie(seam, line, name="seam")])
    figure, data = mesh_and_loads(model)
    assert {"spherical joint", "tie"} <= set(data["item"])
    assert (data["item"] == "tie").sum() == 2 * (len(seam) - 1)
    names = [text.get_text() for axes in figure.axes for text in axes.texts]
    assert {"corner", "seam"} <= set(names)


def test_films_and_sequences_draw_them_where_they_are(flown):
    """Lines of the film are those of the frame; no names where there are many."""
    _, recording = flown
    shown = np.arange(len(recording.times))
    figure, draw = _scene(recording, shown, 1.0, (20.0, -60.0), False,
                          coloured(recording, ENERGY).at(shown))
    axes = figure.axes[0]
    rods = [lines for lines in axes.collections if lines.get_label() == "_rod"]
    assert len(rods) == 1
    seen = []
    for k in (0, len(shown) - 1):
        draw(k)
        seen.append(rods[0].get_segments()[0])
    assert np.abs(seen[1] - seen[0]).max() > 1e-3
    words = [text.get_text() for text in axes.get_legend().get_texts()]
    assert "6 rigid bodies, 6 kg" in words and "on the ground" in words
    assert len(recording.symbols.marks) > FEW_NAMES
    assert not {"shoulder", "hub, 3 kg"} & {text.get_text() for text in axes.texts}
    figure, _ = sequence(recording, recording.times[[0, -1]])
    drawn = [[lines for lines in axes.collections if lines.get_label() == "_rod"]
             for axes in figure.axes]
    assert sum(map(len, drawn)) >= 2
    plt.close("all")


def test_summaries_tell_them(flown, tmp_path):
    """Of a file by ``info``, in words and as JSON, with the energies of all items; as CSV too."""
    _, recording = flown
    path = tmp_path / "craft.h5"
    simulate(craft(), Settings(dt=0.02, end_time=0.04, scheme=Scheme("exact")), output=path)
    told = json.loads(in_process("info", str(path), "--energy", "--json").stdout)
    assert told["joints"]["rail"] == "prismatic joint" and len(told["joints"]) == 7
    assert told["bodies"]["hub"] == {"mass": 3.0, "nodes": 2}
    total = sum(row["kinetic"] for row in told["energies"])
    assert total == pytest.approx(told["kinetic_energy"], rel=1e-12)
    table = tmp_path / "energies.csv"
    words = in_process("info", str(path), "--energy", "--csv", str(table)).stdout
    assert "1 hinge (fold), 1 revolute joint (shoulder)" in words
    assert "hub 3 kg with 2 nodes, arm 1 kg" in words
    assert "shoulder (joint)" in words and "left over" in words
    rows = table.read_text().splitlines()
    assert rows[0] == "time,item,kind,kinetic,stored,dissipated,work"
    assert len(rows) == 1 + 3 * len(told["energies"])
    plain = in_process("info", str(path)).stdout
    assert "shoulder (joint)" not in plain


def test_words_of_many():
    assert words_of_joints({f"h{k}": "hinge" for k in range(49)}) == "49 hinges"
    bodies = {f"b{k}": {"mass": 2.0, "nodes": 0} for k in range(9)}
    assert words_of_bodies(bodies) == "9 rigid bodies, 18 kg"
    assert words_of_bodies({"a": {"mass": 2.0, "nodes": 1}}) == "a 2 kg with 1 node"


def test_players_have_them(flown):
    """Their points follow the nodes, in every frame; of each look there is a line or a mark."""
    _, recording = flown
    data = player(recording)
    scaled = np.frombuffer(gzip.decompress(b64decode(data["position"])), "<u2")
    x = scaled.reshape(data["frames"], data["nodes"], 3) / STEPS * data["size"] + data["low"]
    x = x[:, len(recording.nodes):] + np.transpose(data["centre"])[:, None]
    places = recording.symbol_places(np.arange(data["frames"]))
    np.testing.assert_allclose(x, places, atol=2e-4)
    marks = {row["mark"] for row in data["symbols"]}
    assert marks == {None, "circle", "circle-open", "square", "diamond", "cross", "x"}
    for row in data["symbols"]:
        points = np.array(row["points"])
        assert points.min() >= len(recording.nodes) and points.max() < data["nodes"]
        assert row["mark"] or len(points) % 2 == 0
