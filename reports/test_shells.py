"""The picture of ``corovec check`` shows all that a model file says, each kind in its own way."""

import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.colors import same_color
from matplotlib.patches import FancyArrowPatch
from matplotlib.text import Text

from corovec import (
    Centrifugal,
    Drag,
    FollowerForce,
    Gravity,
    Mesh,
    Model,
    NodalMoment,
    Pressure,
    Steps,
    UserForce,
)
from corovec.reports import arrows
from corovec.reports.arrows import LOOKS
from corovec.reports.checking import summary
from corovec.reports.shells import mesh_and_loads, whole_model
from corovec.solver.input.files import read_model
from corovec.verification.models import MATERIAL, rectangle

SHELL = """
name = "shell"
parameters = { thickness = 0.01, youngs = 1e9, poisson = 0.3, density = 1000.0 }
[[geometry.blocks]]
corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
divisions = [4, 4]
group = "floor"
[[geometry.blocks]]
corners = [[1, 0, 0], [1, 0, 0.5], [1, 1, 0.5], [1, 1, 0]]
divisions = [2, 4]
group = "wall"
"""

EVERYTHING = """
[histories]
wave = { frequency = 5.0, amplitude = 2.0 }
[[loads]]
name = "point"
at = [0, 0, 0]
force = [0, 0, 3]
[[loads]]
name = "edge"
line = [[0, 0, 0], [0, 1, 0]]
force = [-1, 0, 0]
history = "wave"
[[loads]]
name = "snow"
surface = "floor"
force = [0, 0, -5]
[[loads]]
name = "blow"
surface = "wall"
pressure = 7.0
[[loads]]
name = "twist"
at = [0, 1, 0]
moment = [0, 4, 0]
[[loads]]
name = "hinge"
line = [[1, 0, 0.5], [1, 1, 0.5]]
moment = [0, 2, 0]
[[loads]]
name = "weight"
gravity = [0, 0, -9.81]
[motion]
spin = [0, 0, 2]
velocity = [1, 0, 0]
[defaults]
dt = 0.01
end_time = 1.0
"""

HELD = """
[[supports]]
fix = "clamped"
where = { x = 0.0 }
[[supports]]
fix = "pinned"
at = [1, 0, 0.5]
[[supports]]
fix = ["z"]
at = [1, 1, 0.5]
displacement = -0.02
[[steps]]
kind = "static"
"""


@pytest.fixture
def drawn(tmp_path):
    """A function that draws ``SHELL`` and more text: figure, table, model."""
    def draw(text, shell=SHELL):
        path = tmp_path / "shell.toml"
        path.write_text(shell + text)
        definition = read_model(path)
        model = definition.model(definition.elements)
        return *whole_model(model, definition, view=(30.0, -60.0)), model
    return draw


def heads(axes, colour):
    """How many heads of arrows of a colour there are."""
    return sum(same_color(text.arrow_patch.get_edgecolor(), colour) for text in axes.texts
               if text.arrow_patch)


def said(figure):
    return [text.get_text() for axes in figure.axes for text in axes.findobj(Text)]


def test_every_kind_of_load_is_drawn(drawn):
    """By its name, in its colour, its vectors at their largest; what turns has two heads."""
    figure, data, model = drawn(EVERYTHING)
    axes = figure.axes[0]
    names = {"point", "edge", "snow", "blow", "twist", "hinge", "weight", "velocity", "spin"}
    assert names <= {text.get_text() for text in axes.texts}
    loads = data[data["item"] == "load"]
    assert loads.groupby("name")["unit"].first().to_dict() == {
        "point": "N", "edge": "N/m", "snow": "N/m^2", "blow": "Pa", "twist": "N m",
        "hinge": "N m/m", "weight": "m/s^2", "velocity": "m/s", "spin": "rad/s"}
    counts = loads["name"].value_counts()
    assert heads(axes, LOOKS["force"].colour) == sum(counts[["point", "edge", "snow"]])
    assert heads(axes, LOOKS["pressure"].colour) == counts["blow"] == 8
    assert heads(axes, LOOKS["moment"].colour) == 2 * sum(counts[["twist", "hinge"]])
    assert heads(axes, LOOKS["gravity"].colour) == counts["weight"] == 1
    assert heads(axes, LOOKS["velocity"].colour) == 1 + 2
    row = loads.set_index("name").loc
    vector, place = ["fx", "fy", "fz"], ["x", "y", "z"]
    assert row["edge", vector].to_numpy() == pytest.approx(np.tile((-2.0, 0, 0), (5, 1)), abs=1e-3)
    assert np.all(row["blow", vector].to_numpy() == (-7.0, 0.0, 0.0))
    for name in ("weight", "spin", "velocity"):
        assert row[name, place].tolist() == pytest.approx(model.centre)
    words = said(figure)
    assert {"moment 2 N m", "pressure 5 Pa", "gravity 5 m/s²", "spin 2 rad/s"} <= set(words)


def test_groups_normals_folds_and_supports_are_drawn(drawn):
    """Each with a row of the key; rows that are not needed are not there."""
    figure, data, model = drawn(HELD)
    axes, words = figure.axes[0], said(figure)
    assert {"floor", "wall", "fold", "normal of the elements", "held: clamped", "held: pinned",
            "held: z", "displacement 0.02 m"} <= set(words)
    polygons = next(item for item in axes.collections if isinstance(item, PolyCollection))
    assert sorted(np.unique(polygons.get_array(), return_counts=True)[1]) == [8, 16]
    assert len(data[data["item"] == "fold"]) == 2 * 4 == 2 * model.folds.folded
    assert np.all(data.loc[data["item"] == "fold", ["x", "z"]].to_numpy() == (1.0, 0.0))
    normals = data.loc[data["item"] == "normal", ["nx", "ny", "nz"]].to_numpy()
    assert len(normals) == 10 and {tuple(n) for n in normals.round(9) + 0.0} == {
        (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0)}
    markers = [line.get_marker() for line in axes.lines]
    assert markers.count("s") == 5 and markers.count("^") == 1 and markers.count("D") == 1
    assert heads(axes, LOOKS["displacement"].colour) == 1
    plain = SHELL[:SHELL.index("[[geometry.blocks]]\ncorners = [[1")]
    words = said(drawn("[defaults]\ndt = 0.01\nend_time = 0.1\n", plain)[0])
    assert "normal of the elements" in words
    assert not {"floor", "fold", "at the largest, to scale:"} & set(words)


def test_elements_of_two_groups_and_of_none_have_colours_of_their_own(drawn, tmp_path):
    mesh = rectangle(2.0, 1.0, (4, 2))
    Mesh(mesh.nodes, mesh.quads, {"a": [0, 1, 2], "b": [2, 3]}).write(tmp_path / "m.vtu")
    figure, data, _ = drawn("[geometry]\nfile = 'm.vtu'\n[[steps]]\nkind = 'static'\n",
                            SHELL[:SHELL.index("[[geometry")])
    assert {"a", "b", "a and b", "in no group"} <= set(said(figure))
    polygons = next(item for item in figure.axes[0].collections if isinstance(item, PolyCollection))
    assert sorted(np.unique(polygons.get_array(), return_counts=True)[1]) == [1, 1, 2, 4]
    assert len(data[data["item"] == "group"]) == 3 + 2


def test_arrows_on_a_surface_stand_before_it(drawn):
    """Those that push end at the surface, those that pull begin there: the eye is above."""
    model = rectangle(2.0, 1.0, (2, 1))
    at, normals = arrows.middle(model.nodes[model.quads])
    eye = np.array([0.0, 0.6, 0.8])
    for size in (1.0, -1.0):
        one = arrows.Drawn("", at, size * normals, "Pa", normals=normals)
        ends = arrows.ends(model, one, {"Pa": 0.5}, eye)
        assert ends[:, :, 2].min() == 0.0 and ends[:, :, 2].max() == 0.5
        assert np.all(np.diff(ends[:, :, 2]) == 0.5 * size)


def test_few_arrows_are_spread_out():
    grid = np.stack(np.meshgrid(np.arange(20.0), np.arange(20.0), [0.0]), axis=-1).reshape(-1, 3)
    few = grid[arrows.spread(grid, 12)]
    apart = np.linalg.norm(few[:, None] - few, axis=2) + 1e9 * np.eye(12)
    assert len(few) == 12 and apart.min() > 4.0
    assert np.linalg.norm(grid[arrows.spread(grid, 1, few)] - few, axis=1).min() > 2.0
    line = arrows.Drawn("", grid[:20], np.tile((0.0, 0.0, 1.0), (20, 1)), "N/m", line=True)
    assert line.thinned(4.0, ()).at[:, 0].tolist() == [0, 2, 5, 7, 10, 12, 14, 17, 19]
    along = line._replace(vectors=np.tile((1.0, 0.0, 0.0), (20, 1))).thinned(4.0, ())
    assert len(along.at) == 1 + 19 // 4


def test_loads_of_an_own_model_of_every_kind():
    """Without a model file: moments, pressure and weight as well."""
    plate = rectangle(2.0, 1.0, (2, 1))
    model = Model(plate.nodes, plate.quads, **MATERIAL, loads=[
        NodalMoment(1, (0.0, 2.0, 0.0)), Pressure(3.0, [1]), Gravity((0.0, 0.0, -9.81))])
    figure, data = mesh_and_loads(model)
    loads = data[data["item"] == "load"].set_index("unit")
    assert set(loads.index) == {"N m", "Pa", "m/s^2"}
    assert loads.loc["Pa", ["x", "y", "z", "fz"]].tolist() == [1.5, 0.5, 0.0, 3.0]
    assert sum(len(axes.findobj(FancyArrowPatch)) for axes in figure.axes[1:]) == 2 + 1 + 1


def test_loads_without_potential_are_drawn(drawn):
    """A force that follows along the normal, the velocity of a medium, whatever multiplies its
    force; nothing of a medium at rest and of the user's forces."""
    plate = rectangle(2.0, 1.0, (2, 1))
    loads = [FollowerForce(1, -2.0), Drag(1.0, 1.0, [1], (0.0, 0.0, 3.0), Steps((0.0,), (5.0,))),
             Drag(1.0, 1.0), UserForce(lambda t, x, v, p: 0.0 * x), Centrifugal((0.0, 0.0, 4.0))]
    model = Model(plate.nodes, plate.quads, **MATERIAL, loads=loads)
    _, data = mesh_and_loads(model)
    own = data[data["item"] == "load"].set_index("unit")["fz"].to_dict()
    assert own == {"N": -2.0, "m/s": 3.0, "rad/s": 4.0}
    _, data, _ = drawn('''
[histories]
five = { times = [0.0], values = [5.0] }
[[loads]]
name = "thrust"
at = [0, 1, 0]
follower = -2.0
[[loads]]
name = "gale"
surface = "floor"
drag = 1.0
density = 1.2
velocity = [0, 0, 3]
history = "five"
[[loads]]
name = "air"
drag = 1.0
density = 1.2
[defaults]
dt = 0.01
end_time = 1.0
''')
    loads = data[data["item"] == "load"]
    assert set(loads["name"]) == {"thrust", "gale"}
    sizes = {name: set(of[["fx", "fy", "fz"]].abs().max(axis=1).dropna())
             for name, of in loads.groupby("name")}
    assert sizes == {"thrust": {2.0}, "gale": {3.0}}


def test_names_are_clear_of_one_another(drawn):
    figure, _, _ = drawn(EVERYTHING)
    figure.draw_without_rendering()
    boxes = [text.get_window_extent().get_points() for text in figure.axes[0].texts
             if text.get_text()]
    for k, a in enumerate(boxes):
        for b in boxes[:k]:
            assert np.any(np.minimum(a[1], b[1]) <= np.maximum(a[0], b[0]))


def test_long_names_and_many_functions_leave_room(drawn):
    """Names lose their middle; of many functions the units are told, and how many are not drawn."""
    name = "outer panel of the left wing between ribs seven and twelve"
    many = "".join(f"""
[histories.f{k}]
times = [0.0, {k + 1.0}]
values = [1.0, 0.0]
[[loads]]
name = "{name} {k}"
at = [0, 0, 0]
force = [0, 0, {k + 1.0}]
history = "f{k}"
""" for k in range(9))
    figure, data, _ = drawn(f"[defaults]\ndt = 0.01\nend_time = 0.1\n{many}",
                            SHELL.replace("floor", name))
    figure.draw_without_rendering()  # it would warn if there were no room
    words = said(figure)
    assert "outer panel …en and twelve" in words and "2 others" in words
    assert figure.axes[1].get_ylabel() == "[–]" and max(map(len, words)) < 40
    assert f"{name} 8" in set(data["name"])


ATTACHED = """
[histories]
shake = { frequency = 4.0, amplitude = 2.0 }
tilt = { times = [0.0, 0.1], values = [0.0, 1.0] }
[[drives]]
where = { x = 0.0 }
translation = [0.0, 0.0, 0.02]
rotation = [0.0, 0.3, 0.0]
about = [0.0, 0.5, 0.0]
history = "shake"
turning = "tilt"
[[masses]]
line = [[1, 0, 0.5], [1, 1, 0.5]]
mass = 0.5
[[springs]]
between = [[0.25, 0.5, 0.0], [1.0, 0.5, 0.5]]
stiffness = 300.0
[[foundations]]
surface = "floor"
stiffness = [0.0, 0.0, 1e4]
[damping]
mass = 2.0
[probes]
root = { stress = [0.1, 0.1, 0.0] }
wall = { energy = "wall" }
[defaults]
dt = 0.01
end_time = 0.1
"""


def test_what_is_attached_or_moves_is_drawn_and_counted(drawn, tmp_path):
    """Marks with rows of the key; a translation at each node, a rotation with two heads."""
    figure, data, model = drawn(ATTACHED)
    axes, words = figure.axes[0], said(figure)
    assert {"held: clamped, moved", "point masses, 2.5 kg", "springs to the ground", "spring",
            "displacement 0.02 m", "rotation 0.2 rad", "root", "translation"} <= set(words)
    markers = [line.get_marker() for line in axes.lines]
    assert markers.count("X") == 5 and markers.count(r"$\wr$") == 25
    assert sum(line.get_marker() == "o" and line.get_color() == "#000000"
               for line in axes.lines) == 5
    assert heads(axes, LOOKS["rotation"].colour) == 5 + 2
    rows = data.set_index("name").loc
    assert np.all(rows["translation", ["fx", "fy", "fz"]].to_numpy().round(4) == (0, 0, 0.04))
    assert rows["rotation", ["x", "y", "z", "fy"]].tolist() == [0.0, 0.5, 0.0, 0.3]
    assert data.loc[data["item"] == "spring", ["x", "y", "z"]].to_numpy().tolist() == [
        [0.25, 0.5, 0.0], [1.0, 0.5, 0.5]]
    assert rows["root", ["item", "x", "y", "z"]].tolist() == ["point", 0.125, 0.125, 0.0]
    assert set(data.loc[data["item"] == "function", "name"]) == {"shake", "tilt"}
    told = summary(read_model(tmp_path / "shell.toml"), model)
    assert told["moved_nodes"] == 5 and told["point_masses"] == {"number": 5, "kg": 2.5}
    assert (told["springs"], told["springs_to_the_ground"]) == (1, 25)
    assert told["damping"] == {"mass [1/s]": 2.0, "stiffness [s]": 0.0}
    assert told["probes"] == {"root": "stress", "wall": "energy of wall"}
    assert told["body"]["mass"] == pytest.approx(1.5 * 10.0 + 2.5)
