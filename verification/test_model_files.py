"""Model files of users: every key, what acts, steps, mistakes; the commands around them."""

import json
import re
import tomllib
from dataclasses import asdict

import numpy as np
import pytest
from pydantic import TypeAdapter

from corovec import (
    Cyclic,
    Drag,
    Expression,
    FollowerForce,
    Gravity,
    Harmonic,
    InputError,
    NodalLoad,
    NodalMoment,
    Pressure,
    Scheme,
    Settings,
    Steps,
    Support,
    TimeFunction,
    block,
    read,
    run_model,
)
from corovec.solver.cli import cli
from corovec.solver.input import reference
from corovec.solver.input.acting import KINDS
from corovec.solver.input.attached import SpringBetween
from corovec.solver.input.files import read_model
from corovec.solver.input.running import ReadySteps
from corovec.solver.model.mesh import node_at
from corovec.verification.helpers import corovec, in_process

SHELL = """
name = "shell"
parameters = { thickness = 0.01, youngs = 1e9, poisson = 0.3, density = 1000.0 }
[defaults]
dt = 1e-3
end_time = 0.01
[[geometry.blocks]]
corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
divisions = [2, 2]
group = "left"
[[geometry.blocks]]
corners = [[1, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0]]
divisions = [2, 2]
group = "right"
"""


WITHOUT_DEFAULTS = SHELL[:SHELL.index("[defaults]")] + SHELL[SHELL.index("[[geometry"):]


@pytest.fixture
def made(tmp_path):
    """A function that makes the ``ModelFile`` of ``SHELL`` and more text."""
    def make(text="", shell=SHELL):
        path = tmp_path / "shell.toml"
        path.write_text(shell + text)
        return read_model(path)
    return make


@pytest.mark.parametrize("kind", reference._kinds(reference.ModelFile), ids=lambda k: k.__name__)
def test_the_reference_has_every_key(kind):
    """With what it is, and an example that can stand in a file; none of a key that is gone."""
    examples = tomllib.loads(reference.EXAMPLES.read_text())[kind.__name__]
    assert set(examples) == set(kind.model_fields) == set(reference._attributes(kind))
    for name, field in kind.model_fields.items():
        if not re.search("below$|^written", examples[name]) and "=" not in examples[name][:6]:
            value = tomllib.loads(f"value = {examples[name]}")["value"]
            if not (kind.__name__ == "Load" and name in KINDS):
                TypeAdapter(field.rebuild_annotation()).validate_python(value)


def test_the_example_of_a_spring_is_one():
    """All its keys together make a spring: a damper's table that acts at rest is none."""
    given = {name: tomllib.loads(f"value = {text}")["value"] for name, text in
             tomllib.loads(reference.EXAMPLES.read_text())["SpringBetween"].items()}
    mesh = block([(0, 0, 0.2), (0.6, 0, 0), (0.6, 1, 0), (0, 1, 0.2)], (1, 1))
    spring, = SpringBetween.model_validate(given).made(mesh)
    assert spring.damper_forces == (-2.0, 0.0, 1.0) and spring.steepest == 800.0


def test_reference_and_schema_are_printed():
    text = in_process("schema").stdout
    assert "[[loads]]: A force, a moment, a pressure, a weight, a spin, a drag" in text
    assert re.search(r"gravity +acceleration of everything that has mass \[m/s\^2\]\n +example: "
                     r"\[0.0, 0.0, -9.81\]", text)
    schema = json.loads(in_process("schema", "--json").stdout)
    thickness = schema["$defs"]["Group"]["properties"]["thickness"]
    assert "number" in json.dumps(thickness) and "$ref" in json.dumps(thickness)


def test_the_file_to_start_from_runs(tmp_path):
    """Checked, drawn and run; a file that is there stays."""
    path, output = tmp_path / "my.toml", tmp_path / "my.h5"
    assert in_process("new", str(path)).returncode == 0
    assert "exists; --overwrite replaces it" in in_process("new", str(path)).stderr
    assert f"corovec run {path.name} --output" in path.read_text()
    checked = json.loads(corovec("check", str(path), "--output", str(tmp_path / "a.svg"),
                                 "--json").stdout)
    assert checked["held_nodes"] == 5 and checked["loads"] == {"weight": "gravity",
                                                               "pull": "force"}
    assert checked["body"]["mass"] == pytest.approx(0.6 * 0.2 * 0.002 * 2700.0)
    assert (tmp_path / "a.svg").stat().st_size > 1000
    run = json.loads(corovec("run", str(path), "--output", str(output), "--json").stdout)
    weight = 9.81 * checked["body"]["mass"]
    np.testing.assert_allclose(run["static"]["reaction"], (0.0, 0.0, weight + 1.0), atol=1e-6)
    contents = read(output)
    assert contents["history"]["tip_u"].shape == (501, 3)
    assert contents["von_mises"].shape[1:] == (48, 3)
    # it starts at the equilibrium under both loads, and swings about that of its weight alone
    tip = contents["history"]["tip_u"][:, 2]
    static = read(tmp_path / "my-static.h5")["displacement"][-1]
    assert tip[0] == pytest.approx(static[:, 2].min(), rel=1e-2)
    assert tip.max() > 0.5 * tip[0] and tip.min() == pytest.approx(tip[0], rel=1e-2)


def test_loads(made):
    """Each kind at each place, as Python makes them."""
    model = made("""
[histories]
pulse = { times = [0.0, 0.1], values = [1.0, 0.0] }
jump = { times = [0.0, 0.1], values = [1.0, 0.0], jumps = true, peak = 3.0 }
wave = { frequency = 5.0, amplitude = 2.0, peak = 2.0 }
gust = { expression = "sin(t)", peak = 2.0 }
[[loads]]
name = "point"
at = [0, 0, 0]
force = [1, 0, 0]
history = "pulse"
[[loads]]
name = "twist"
at = [2, 1, 0]
moment = [0, 1, 0]
history = "jump"
[[loads]]
name = "edge"
line = [[2, 0, 0], [2, 1, 0]]
force = [0, 0, 4]
history = "wave"
[[loads]]
name = "hinge"
line = [[2, 0, 0], [2, 1, 0]]
moment = [0, 4, 0]
[[loads]]
name = "all"
surface = "all"
force = [0, 0, 2]
[[loads]]
name = "half"
surface = "left"
force = [0, 0, 2]
[[loads]]
name = "blow"
surface = "right"
pressure = 7.0
[[loads]]
name = "air"
pressure = 7.0
[[loads]]
name = "weight"
gravity = [0, 0, -9.81]
history = "gust"
""")
    loads, mesh = model.model(8).loads, model.mesh(8)
    assert NodalLoad(0, (1, 0, 0), TimeFunction((0.0, 0.1), (1.0, 0.0))) in loads
    twist = next(load for load in loads if isinstance(load, NodalMoment))
    assert twist.history == Steps((0.0, 0.1), (3.0, 0.0))
    forces = {name: sum(np.array(load.force) for load in loads
                        if isinstance(load, NodalLoad) and load.history == history)
              for name, history in (("edge", Harmonic(5.0, 4.0)), ("surface", TimeFunction(
                  (0.0,), (1.0,))))}
    np.testing.assert_allclose(forces["edge"], (0, 0, 4), atol=1e-14)
    np.testing.assert_allclose(forces["surface"], (0, 0, 2 * 2 + 2), atol=1e-14)
    moments = sum(np.array(load.moment) for load in loads if isinstance(load, NodalMoment))
    np.testing.assert_allclose(moments, (0, 1 + 4, 0), atol=1e-14)
    assert Pressure(7.0, mesh.groups["right"].tolist()) in loads and Pressure(7.0) in loads
    assert loads[-1] == Gravity((0, 0, -9.81), Expression("2.0 * (sin(t))"))


def test_loads_without_potential(made):
    """Forces that follow nodes, drag on a group and everywhere; where they come from is told."""
    model = made("""
[histories]
gust = { times = [0.0, 0.1], values = [1.0, 2.0] }
[[loads]]
name = "jet"
at = [2, 1, 0]
follower = { value = -3.0, unit = "N", provenance = "assumed", source = "a guess" }
history = "gust"
[[loads]]
name = "air"
drag = 1.2
density = 1.225
[[loads]]
name = "gale"
drag = 2.0
density = 1.2
velocity = [10.0, 0.0, 1.0]
surface = "right"
history = "gust"
""")
    jet, air, gale = model.model(8).loads
    gust = TimeFunction((0.0, 0.1), (1.0, 2.0))
    mesh = model.mesh(8)
    assert jet == FollowerForce(node_at(mesh.nodes, (2.0, 1.0, 0.0)), -3.0, gust)
    assert air == Drag(1.2, 1.225)
    assert gale == Drag(2.0, 1.2, mesh.groups["right"].tolist(), (10.0, 0.0, 1.0), gust)
    rows = model.provenance()
    assert ("jet", -3.0, "N", "assumed", "a guess") in rows
    assert ("gale velocity", [10.0, 0.0, 1.0], "m/s", "given", "") in rows
    with pytest.raises(InputError, match="smooth, it does not turn about its normal"):
        made("[[loads]]\nname = 'a'\nat = [0, 0, 0]\nfollower = [0, 0, 1]").model(8)


def test_what_differs_from_place_to_place(made):
    """Groups and arithmetic at the nodes."""
    model = made("[groups]\nright = { thickness = 0.02, youngs = 2e9 }\n").model(8)
    assert sorted(model.thickness) == [0.01] * 4 + [0.02] * 4
    assert sorted(model.youngs) == [1e9] * 4 + [2e9] * 4 and set(model.density) == {1000.0}
    tapered = made(shell=SHELL.replace("thickness = 0.01", 'thickness_at = "0.02 - 0.005 * x"'))
    centres = tapered.mesh(8).nodes[tapered.mesh(8).quads].mean(axis=1)
    np.testing.assert_allclose(tapered.model(8).thickness, 0.02 - 0.005 * centres[:, 0])


def test_supports_and_motion(made):
    """By words and by components, at places; spin about the mass centre."""
    model = made("""
[[supports]]
fix = "clamped"
where = { x = 0.0 }
[[supports]]
fix = ["z"]
line = [[2, 0, 0], [2, 1, 0]]
[[supports]]
fix = "pinned"
at = [1, 1, 0]
""").model(8)
    assert model.fixed.sum() == 3 * 6 + 3 + 3
    assert Support(np.flatnonzero(model.nodes[:, 0] == 0.0).tolist(),
                   ("x", "y", "z", "px", "py", "pz")) in model.supports
    free = made("[motion]\nspin = [0, 0, 2]\nvelocity = [1, 0, 0]\n").model(8)
    x, y, _ = free.nodes.T
    np.testing.assert_allclose(free.velocity, np.column_stack(
        [1.0 - 2.0 * (y - 0.5), 2.0 * (x - 1.0), 0.0 * x]), atol=1e-14)


def test_oblique_supports(made):
    """Words and components along axes of their own; axes that are none."""
    text = """
[[supports]]
fix = "symmetry x"
axes = [[3, 4, 0], [-4, 3, 0], [0, 0, 1]]
where = { x = 0.0 }
"""
    model = made(text).model(8)
    rim = np.flatnonzero(model.nodes[:, 0] == 0.0).tolist()
    assert set(model.oblique) == set(rim) and not model.fixed[:, :3].any()
    assert model.supports[0].components == ("x", "px")
    np.testing.assert_allclose(model.oblique[0], [[(0.6, 0.8, 0.0)]] * 2, atol=1e-15)
    with pytest.raises(InputError, match=r"supports\[0\]: support: axes must be three orthogonal"):
        made(text.replace("-4, 3", "4, 3"))


def test_sectors(made):
    """A quarter of a cylinder that spins about its axis."""
    text = """
[cyclic]
sectors = 4
[motion]
spin = [0, 0, 2]
"""
    shell = SHELL[:SHELL.index("[[geometry")] + """
[geometry.cylinder]
radius = 1.0
length = 1.0
divisions = [4, 2]
angle = 90.0
"""
    model = made(text, shell).model(8)
    assert model.cyclic == Cyclic(4) and len(model.pairs.masters) == 3
    assert model.velocity[0] == pytest.approx((0.0, 2.0, 0.0))
    with pytest.raises(InputError, match="no node is where another one is turned to by 72 degrees"):
        made(text.replace("4", "5"), shell)
    with pytest.raises(InputError, match="cyclic: cyclic: sectors must be 2 or more"):
        made(text.replace("4", "1"), shell)


def test_meshes_of_files(tmp_path, made):
    """Groups and lines of the file by name, its path from the folder of the model file, in mm."""
    mesh = block([(0, 0, 0), (2000, 0, 0), (2000, 1000, 0), (0, 1000, 0)], (4, 2))
    edge = mesh.line((2000.0, 0.0, 0.0), (2000.0, 1000.0, 0.0))
    type(mesh)(mesh.nodes, mesh.quads, {"skin": np.arange(8)},
               lines={"tip": np.column_stack([edge[:-1], edge[1:]])}).write(tmp_path / "p.msh")
    model = made("""
[geometry]
file = "p.msh"
scale = 1e-3
[[supports]]
fix = "clamped"
where = { x = 0.0 }
[[loads]]
name = "tip"
curve = "tip"
force = [0, 0, 6]
[[loads]]
name = "skin"
surface = "skin"
pressure = 1.0
[[steps]]
kind = "static"
""", shell=SHELL[:SHELL.index("[[geometry")])
    shell = model.model(8)
    assert np.ptp(shell.nodes, axis=0).tolist() == [2.0, 1.0, 0.0] and model.sizes == (8,)
    forces = sum(np.array(load.force) for load in shell.loads if isinstance(load, NodalLoad))
    np.testing.assert_allclose(forces, (0, 0, 6))
    assert model.dynamic is None and model.static.increments == 10


LOAD = '[[loads]]\nname = "a"\n'


@pytest.mark.parametrize("text, message", [
    (LOAD, "loads[0]: one of force, moment, pressure, gravity, centrifugal, follower, drag is "
     "needed, none is given"),
    (LOAD + "follower = 1.0", "loads[0]: a follower needs one of: at, nodes"),
    (LOAD + "at = [0, 0, 0]\nfollower = 'up'", "loads[0].follower: must be a number, is"),
    (LOAD + "at = [0, 0, 0]\nfollower = [0, 1]", "loads[0].follower: must be a number or three"),
    (LOAD + "drag = 1.0", "loads[0]: a drag needs the density of the medium"),
    (LOAD + "drag = -1.0\ndensity = 1.0", "loads[0].drag: must not be negative, is -1"),
    (LOAD + "pressure = 1.0\ndensity = 1.0", "loads[0]: a pressure has no density"),
    (LOAD + "gravity = [0, 0, 1]\nvelocity = [0, 0, 1]", "loads[0]: a gravity has no velocity"),
    (LOAD + "drag = 1.0\ndensity = 1.0\nsurface = 'middle'", "loads[0].surface: group 'middle'"),
    (LOAD + "force = [0, 0, 1]", "loads[0]: a force needs one of: at, line, curve, nodes, surface"),
    (LOAD + "at = [0, 0, 0]\nforce = [0, 0, 1]\npressure = 1", "force and pressure are given"),
    (LOAD + "at = [0, 0, 0]\npressure = 1", "a pressure has no at, it acts on one of: surface"),
    (LOAD + "surface = 'all'\nmoment = [0, 0, 1]", "a moment has no surface, it acts on one of:"),
    (LOAD + "at = [0, 0, 0]\ngravity = [0, 0, 1]", "a gravity has no at"),
    (LOAD + "about = [0, 0, 0]\ngravity = [0, 0, 1]", "a gravity has no about"),
    (LOAD + "centrifugal = [0, 0, 1]", "centrifugal forces are those of a frame that turns: of a"),
    (LOAD + "surface = 'middle'\npressure = 1", "loads[0].surface: group 'middle' is unknown, must "
     "be one of: left, right"),
    (LOAD + "curve = 'rim'\nforce = [0, 0, 1]", "loads[0].curve: line 'rim' is unknown, there is"),
    (LOAD + "nodes = 'rim'\nforce = [0, 0, 1]", "loads[0].nodes: node set 'rim' is unknown"),
    (LOAD + "at = [9, 0, 0]\nforce = [0, 0, 1]", "loads[0].at: no node at [9.0, 0.0, 0.0]"),
    (LOAD + "at = [0, 0]\nforce = [0, 0, 1]", "loads[0].at[2]: is missing"),
    (LOAD + "gravity = 9.81", "loads[0].gravity: must be a list, is 9.81"),
    (LOAD + "pressure = 1\nhistory = 'q'", "loads[0].history: 'q' is unknown, there is none"),
    (LOAD + "pressure = { value = 1.0, unit = 'kPa', provenance = 'given', source = '' }",
     "loads[0]: pressure in 'kPa', history in '', peak in '': one must be in 'Pa'"),
    ("[histories]\nq = { times = [0.0], frequency = 1.0 }", "times and frequency are given"),
    ("[histories]\nq = { times = [0.0] }", "histories.q: values are missing"),
    ("[histories]\nq = { frequency = 0.0 }", "histories.q.frequency: must be positive"),
    ("[histories]\nq = { expression = '2 * w' }", "histories.q: expression '2 * w': 'w' is not"),
    ("[histories]\nq = { expression = 't', amplitude = 2.0 }",
     "amplitude belongs to frequency, this has expression"),
    ("[histories]\nq = { csv = 'gust.csv' }", "gust.csv cannot be read: No such file"),
    ("[[supports]]\nfix = 'glued'\nwhere = { x = 0.0 }", "'glued' is unknown, must be one of: "
     "clamped, pinned"),
    ("[[supports]]\nfix = ['u']\nwhere = { x = 0.0 }", "'u' is unknown, must be one of: x, y, z"),
    ("[[supports]]\nfix = 'pinned'", "supports[0]: one of at, line, nodes, where is needed"),
    ("[[supports]]\nfix = 'pinned'\nwhere = { x = 7.0 }", "supports[0]: no nodes at x = 7"),
    ("[groups]\nmiddle = { thickness = 0.1 }", "groups.middle: group 'middle' is unknown"),
    ("[[steps]]\nkind = 'modal'", "steps[0]: "),
    ("[[steps]]\nkind = 'dynamic'\ndt = 1.0\nend_time = 1.0\nscheme = 'exact'\ndissipation = true",
     "steps[0].dynamic.dissipation: must be a number, is True"),
    ("[[steps]]\nkind = 'dynamic'\ndt = 1.0\nend_time = 1.0\nscheme = 'exact'\nrho_inf = 0.9",
     "rho_inf and transformation belong to the scheme quasi"),
    ("[[steps]]\nkind = 'dynamic'\ndt = 1.0\nend_time = 1.0\ndissipates = 'constant'",
     "dissipates belongs to the scheme exact"),
    ("[[steps]]\nkind = 'dynamic'\ndt = 1.0\nend_time = 1.0\n[[steps]]\nkind = 'static'",
     "steps: one static, one dynamic, or a static and a dynamic one are possible"),
    ("[[steps]]\nkind = 'static'\nloads = ['a']", "steps[0].loads: 'a' is unknown, there is none"),
    ("[[steps]]\nkind = 'static'\n[motion]\nspin = [0, 0, 1]", "motion: the motion starts from"),
    ("[points]\n'left tip' = [0, 0, 0]", "points.left tip: a name is letters, digits and _"),
    ("[output]\nframe_every = -1", "output.frame_every: "),
    ("[geometry.sphere]\nradius = 1.0\npolar_angles = [10, 90]\ndivisions = [9, 2]",
     "geometry: one of file, blocks, sphere, cylinder is needed, blocks and sphere are given"),
])
def test_mistakes(made, text, message):
    """Each with its place in the file and what helps, on one line."""
    with pytest.raises(InputError, match=re.escape(message)) as told:
        made(text)
    assert "\n" not in str(told.value) and "shell.toml: " in str(told.value)


@pytest.mark.parametrize("shell, message", [
    (SHELL.replace("[defaults]\ndt = 1e-3\nend_time = 0.01\n", ""), "defaults: is missing, with"),
    (SHELL.replace("thickness = 0.01,", ""), "parameters.thickness: is missing"),
    (SHELL.replace("thickness = 0.01,", "thickness_at = 'x - 5',"),
     "parameters.thickness_at: is -5 m at node"),
    (SHELL.replace("thickness = 0.01,", "thickness_at = '1 / x',"), "parameters.thickness_at: "),
    (SHELL.replace("thickness = 0.01,", "thickness = 0.01, thickness_at = 'x',"),
     "parameters.thickness: is given by thickness_at as well"),
    (SHELL[:SHELL.index("[[geometry")] + "[geometry]\nfile = 'none.msh'", "none.msh"),
    (SHELL[:SHELL.index("[[geometry")] + "[geometry]\nmerge = true\n[geometry.cylinder]\n"
     "radius = 1\nlength = 1\ndivisions = [16, 2]", "merge is for a mesh of a file"),
])
def test_mistakes_in_the_shell(made, shell, message):
    with pytest.raises(InputError, match=re.escape(message)) as told:
        made(shell=shell)
    assert "\n" not in str(told.value)


def test_the_dynamic_step_is_checked_first_and_speaks_of_its_loads(tmp_path):
    """Options before the static step has written anything; a load that it names, by its number in
    the file."""
    path, output = tmp_path / "shell.toml", tmp_path / "a.h5"
    path.write_text(WITHOUT_DEFAULTS + """
[histories]
short = { times = [0.0, 1e-4, 2e-4], values = [1.0, 100.0, 0.0] }
[[supports]]
fix = "clamped"
where = { x = 0.0 }
[[loads]]
name = "weight"
gravity = [0, 0, -9.81]
[[loads]]
name = "hit"
at = [2, 1, 0]
force = [0, 0, 1]
history = "short"
[[steps]]
kind = "static"
increments = 1
loads = ["weight"]
[[steps]]
kind = "dynamic"
dt = 1e-3
end_time = 0.01
loads = ["hit"]
""")
    said = in_process("run", str(path), "--rho-inf", "2", "--output", str(output)).stderr
    assert "--rho-inf" in said and not list(tmp_path.glob("*.h5"))
    assert "loads[1].history: " in in_process("run", str(path)).stderr
    path.write_text(path.read_text() + "scheme = 'exact'\ndissipation = 0.1\n")
    said = in_process("run", str(path), "--scheme", "quasi").stderr
    assert f"dissipation of {path} belongs to the scheme exact" in said, "no option was given"


def test_a_copy_with_other_values_forgets_what_was_cached(made):
    history = made('''
[histories.ramp]
times = [0.0, 1.0]
values = [0.0, 1.0]
''').histories["ramp"]
    assert history.function()(1.0) == 1.0
    other = history.model_copy(update={"values": [0.0, 5.0]})
    assert other.function()(1.0) == 5.0 and history.function()(1.0) == 1.0


TWO_STEPS = WITHOUT_DEFAULTS + """
[[supports]]
fix = "clamped"
where = { x = 0.0 }
[[loads]]
name = "weight"
gravity = [0, 0, -9.81]
[[loads]]
name = "pull"
at = [2, 1, 0]
force = [0, 0, -1]
[[steps]]
kind = "static"
increments = 1
"""

MOTION = """
[[steps]]
kind = "dynamic"
dt = 1e-3
end_time = 0.005
loads = ["weight"]
[points]
tip = [2, 1, 0]
"""


def test_steps_run_from_python(made, tmp_path):
    """An equilibrium under all loads, and a motion that starts there under those that it names."""
    static, dynamic = run_model(made(MOTION, TWO_STEPS), output=tmp_path / "a.h5")
    np.testing.assert_allclose(dynamic.history["tip_u"][0], static.displacement[-1, 14], rtol=1e-12)
    assert dynamic.history["kinetic_energy"][-1] > 0.0 and len(dynamic.history) == 6
    assert np.array_equal(read(tmp_path / "a-static.h5")["displacement"][-1],
                          static.displacement[-1])
    assert np.array_equal(read(tmp_path / "a.h5")["history"]["tip_u"], dynamic.history["tip_u"])
    alone = run_model(made("", TWO_STEPS))
    assert alone.dynamic is None
    np.testing.assert_allclose(alone.static.displacement[-1], static.displacement[-1], rtol=1e-9,
                               atol=1e-12)
    short = run_model(made(shell=SHELL), settings=Settings(1e-3, 2e-3))
    assert short.static is None and len(short.dynamic.history) == 3


def test_both_steps_are_of_one_model(made):
    """Its directors and element constants are made once; only the loads differ."""
    steps = ReadySteps(made(MOTION, TWO_STEPS))
    assert steps.static.elements is steps.dynamic.elements
    assert [type(load) for load in steps.static.loads] == [Gravity, NodalLoad]
    assert steps.dynamic.loads == (Gravity((0.0, 0.0, -9.81)),)


def test_a_motion_holds_what_the_static_step_pushed(made):
    """And goes on from there by the support's function of time."""
    pushed = TWO_STEPS.replace("[[loads]]", """[[supports]]
fix = ["z"]
displacement = 0.01
where = { x = 2.0 }
[[loads]]""", 1)
    static, dynamic = run_model(made(MOTION, pushed))
    for u in (static.displacement[-1, 14], *dynamic.history["tip_u"]):
        assert u[2] == pytest.approx(0.01, rel=1e-12)
    assert dynamic.history["kinetic_energy"][-1] > 0.0


@pytest.mark.parametrize("keys, scheme", [
    ("scheme = 'exact'\ndissipation = 0.1\ndissipates = 'constant'",
     Scheme("exact", dissipation=0.1, dissipates="constant")),
    ("rho_inf = 0.9", Scheme(rho_inf=0.9)), ("scheme = 'newmark'", Scheme("newmark"))])
def test_the_scheme_of_a_motion(made, tmp_path, keys, scheme):
    """That of the file, in Python and by the command, where no option says otherwise."""
    steps = MOTION.replace("loads =", f"{keys}\nloads =")
    assert made(steps, TWO_STEPS).dynamic.settings().scheme == scheme
    output = tmp_path / "a.h5"
    assert in_process("run", str(tmp_path / "shell.toml"), "--output", str(output)).returncode == 0
    assert read(output)["description"]["settings"]["scheme"] == asdict(scheme)


def test_the_file_to_start_from_by_another_scheme(made):
    """What stands there as a comment is possible as it is."""
    start = reference.START.read_text()
    for key in ("scheme", "dissipation", "error"):
        assert f"\n# {key} = " in start
        start = start.replace(f"\n# {key} = ", f"\n{key} = ")
    settings = made("", start).dynamic.settings()
    assert settings.scheme == Scheme("exact", dissipation=0.1) and settings.error == 1e-5


def test_settings_are_of_a_motion(made):
    with pytest.raises(InputError, match="settings are of a motion, the model has a static step"):
        run_model(made("", TWO_STEPS), settings=Settings(1e-3, 2e-3))


@pytest.mark.parametrize("option", ["--dt=1e-3", "--end-time=1", "--rho-inf=0.9", "--stresses",
                                    "--newton=full", "--solver=skyline"])
def test_options_of_a_motion_beside_a_static_step(tmp_path, option):
    """Are refused, also those that are given their defaults, before anything is computed."""
    path, output = tmp_path / "shell.toml", tmp_path / "a.h5"
    path.write_text(TWO_STEPS)
    with pytest.raises(InputError, match=rf"^{option.partition('=')[0]} is of a motion, .*shell"):
        cli.main(["run", str(path), option, "--output", str(output)], standalone_mode=False)
    assert not output.exists()
