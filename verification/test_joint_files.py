"""Joints in model files: where the mesh is opened, what the tables become, mistakes, pictures."""

import json

import numpy as np
import pytest

from corovec import (
    Ball,
    Cylindrical,
    Hinge,
    InputError,
    JointProbe,
    Mesh,
    Model,
    Prismatic,
    Revolute,
    RigidBody,
    RigidLink,
    Scheme,
    Settings,
    Spherical,
    Tie,
    TimeFunction,
    Universal,
    block,
    join,
    read,
    run_model,
    simulate,
)
from corovec.solver.input.files import read_model
from corovec.verification.helpers import corovec, in_process

PANELS = """
name = "panels"
parameters = { thickness = 0.02, youngs = 2e8, poisson = 0.3, density = 1000.0 }
[defaults]
dt = 0.02
end_time = 0.2
[[geometry.blocks]]
corners = [[0, 0, 0], [4, 0, 0], [4, 1, 0], [0, 1, 0]]
divisions = [4, 1]
[[geometry.blocks]]
corners = [[4, 1, 0], [6, 1, 0], [6, 2, 0], [4, 2, 0]]
divisions = [2, 1]
[histories]
opening = { times = [0.0, 1.0], values = [0.0, 1.0] }
push = { times = [0.0, 0.1, 0.2], values = [0.0, 1.0, 0.0] }
"""
HINGE = """
[[joints]]
kind = "hinge"
name = "root"
line = [[2, 0, 0], [2, 1, 0]]
stiffness = 3.0
rest = 1.5
turning = "opening"
damping = 0.1
spring_angles = [-1.0, 0.0, 2.0]
spring_moments = [-5.0, 0.0, 4.0]
damper_rates = [-1.0, 1.0]
damper_moments = [-0.2, 0.2]
stops = [-0.1, 3.2]
stop_stiffness = 500.0
lock = 1.5
lock_stiffness = 1e3
lock_damping = 2.0
torque = 0.5
history = "push"
"""
CORNER = """
[[joints]]
kind = "spherical"
at = [4, 1, 0]
"""

WING = """
name = "wing"
parameters = { thickness = 0.02, youngs = 2e8, poisson = 0.3, density = 1000.0 }
[defaults]
dt = 0.02
end_time = 0.2
[[geometry.blocks]]
corners = [[0.5, -0.5, 0], [3.5, -0.5, 0], [3.5, 0.5, 0], [0.5, 0.5, 0]]
divisions = [4, 2]
[histories]
push = { times = [0.0, 0.1, 0.2], values = [0.0, 1.0, 0.0] }
[[bodies]]
name = "hub"
mass = 20.0
inertia = [2.0, 3.0, 4.0]
centre = [0.3, 0.0, 0.0]
where = { x = 0.5 }
"""
FREE = """
[[bodies]]
name = "free"
mass = 1.0
inertia = [1.0, 1.0, 1.5]
centre = [5.0, 0.0, 0.0]
axes = [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]
"""
ROOT = """
[[joints]]
kind = "revolute"
name = "root"
one = "ground"
other = "hub"
at = [0, 0, 0]
axis = [0, 1, 0]
stiffness = 4.0
rest = 1.0
torque = 2.0
history = "push"
"""


@pytest.fixture
def made(tmp_path):
    """A function that makes the ``ModelFile`` of ``PANELS`` and more text."""
    def make(text, shell=PANELS):
        path = tmp_path / "panels.toml"
        path.write_text(shell + text)
        return read_model(path)
    return make


def test_tables_become_joints(made):
    """With all fields, on every refinement; places are open to what else stands in the file."""
    definition = made(HINGE + CORNER + """
[[meshes]]
elements = 6
refinement = 1
[[meshes]]
elements = 24
refinement = 2
[[supports]]
where = { x = 0.0 }
fix = "clamped"
[probes]
root = { joint = "root" }
corner = { joint = "joint 1" }
""")
    for elements, n in ((6, 2), (24, 3)):
        model = definition.model(elements)
        hinge, corner = model.joints
        assert len(hinge.nodes) == n and np.ptp(model.nodes[list(hinge.nodes)], axis=0)[1] == 1.0
        assert np.array_equal(*(model.nodes[list(side)] for side in (hinge.nodes, hinge.others)))
        opening, push = (TimeFunction(*points) for points in (
            ((0.0, 1.0), (0.0, 1.0)), ((0.0, 0.1, 0.2), (0.0, 1.0, 0.0))))
        assert hinge == Hinge(
            hinge.nodes, hinge.others, stiffness=3.0, rest=1.5, turning=opening, damping=0.1,
            spring_angles=(-1.0, 0.0, 2.0), spring_moments=(-5.0, 0.0, 4.0),
            damper_rates=(-1.0, 1.0), damper_moments=(-0.2, 0.2), stops=(-0.1, 3.2),
            stop_stiffness=500.0, lock=1.5, lock_stiffness=1e3, lock_damping=2.0,
            torque=0.5, history=push, name="root")
        assert corner == Spherical(corner.nodes) and len(corner.nodes) == 2
        assert np.all(model.nodes[list(corner.nodes)] == (4.0, 1.0, 0.0))
    assert definition.probes_on(definition.mesh(6)) == {"root": JointProbe("root"),
                                                        "corner": JointProbe("joint 1")}
    rows = {row[0]: row[1:3] for row in definition.provenance()}
    assert rows["joints[0] lock"] == (1.5, "rad")


def test_a_mesh_of_a_file_that_is_open(made, tmp_path):
    """Nodes of their own stay as they are."""
    plates = [block([(x, 0, 0), (x + 2, 0, 0), (x + 2, 1, 0), (x, 1, 0)], (2, 1)) for x in (0, 2)]
    n = len(plates[0].nodes)
    Mesh(np.concatenate([plate.nodes for plate in plates]),
         np.concatenate([plates[0].quads, plates[1].quads + n])).write(tmp_path / "two.inp")
    shell = PANELS[:PANELS.index("[[geometry")] + (
        '[geometry]\nfile = "two.inp"\n')
    hinge = HINGE.replace('turning = "opening"\n', "").replace('history = "push"\n', "")
    with pytest.raises(InputError, match="geometry.file: .*nodes 2 and 6 are at the same place"):
        made(hinge, shell)
    model = made(hinge, shell + "apart = true\n").model(4)
    assert len(model.nodes) == 2 * n
    assert {node < n for node in model.joints[0].nodes} == {True}
    assert {node >= n for node in model.joints[0].others} == {True}


def test_a_run_has_what_joints_do(made, tmp_path):
    """Checked, drawn and run by the command line: the picture has the hinge, the summary its name,
    the history its columns."""
    text = HINGE + CORNER + '[probes]\nroot = { joint = "root" }\n'
    path = tmp_path / "panels.toml"
    path.write_text(PANELS + text)
    told = json.loads(in_process("check", str(path), "--output", str(tmp_path / "a.svg"),
                                 "--json").stdout)
    assert told["joints"] == {"root": "hinge", "joint 1": "spherical joint"}
    assert told["probes"] == {"root": "joint root"}
    rows = (tmp_path / "a.csv").read_text()
    assert "hinge" in rows and "spherical joint" in rows
    output = tmp_path / "run.h5"
    done = corovec("run", str(path), "--scheme", "exact", "--output", str(output))
    assert done.returncode == 0, done.stderr
    plot = corovec("plot", str(output), "--output", str(tmp_path / "plots"))
    assert plot.returncode == 0, plot.stderr
    table = (tmp_path / "plots" / "run-probes.csv").read_text().splitlines()[0].split(",")
    assert {"root_angle", "root_rate", "root_moment", "root_force_x", "root_stored", "root_work",
            "root_lost"} <= set(table)


@pytest.mark.parametrize(("text", "told"), [
    (HINGE.replace("[2, 1, 0]]", "[3, 1, 0]]"), r"joints\[0\]: no mesh line from"),
    (HINGE.replace("[[2, 0, 0], [2, 1, 0]]", "[[0, 0, 0], [0, 1, 0]]"),
     r"joints\[0\]: cut: the edge between nodes 0 and 5 needs one element on either side"),
    (HINGE + HINGE, r"joints\[1\].name: root is that of joints\[0\] as well"),
    (HINGE.replace("stop_stiffness = 500.0\n", ""),
     r"joints\[0\]: hinge root: stop_stiffness must be positive"),
    (HINGE.replace("lock = 1.5", "lock = 0.0"), r"joints\[0\]: hinge root: lock must not be the"),
    (HINGE.replace('"opening"', '"closing"'),
     r"joints\[0\].turning: 'closing' is not among opening, push"),
    (HINGE.replace("line", "at"), r"joints\[0\].at"),
    (HINGE.replace("line = [[2, 0, 0], [2, 1, 0]]", "at = [4, 1, 0]"),
     r"joints\[0\]: a hinge has a line, a spherical joint an at"),
    (CORNER + "damping = 1.0\n", r"joints\[0\]: damping: a spherical joint has no moment"),
    (CORNER.replace("[4, 1, 0]", "[0, 0, 0]"), r"joints\[0\]: one plate only is at"),
    (HINGE + CORNER
     + '[[drives]]\nat = [2, 0, 0]\ntranslation = [0, 0, 1]\nhistory = "push"\n',
     "a Drive moves node 2, which is joined"),
    (CORNER + '[probes]\na = { joint = "tip" }\n',
     "probes.a: joint 'tip' is unknown, must be one")])
def test_mistakes(made, text, told):
    with pytest.raises(InputError, match=told):
        made(text)


def test_plates_that_are_joined_in_blocks_stay_whole_elsewhere(made):
    """Nodes are made where joints are."""
    mesh = made(HINGE + CORNER).mesh(6)
    whole = join([block([(0, 0, 0), (4, 0, 0), (4, 1, 0), (0, 1, 0)], (4, 1)),
                  block([(4, 1, 0), (6, 1, 0), (6, 2, 0), (4, 2, 0)], (2, 1))])
    assert len(mesh.nodes) == len(whole.nodes) + 3


def test_a_body_on_a_spring_is_the_model_in_python(made):
    """A body that carries an edge, on a revolute joint with a spring and a motor: the file moves as
    the model in Python, to the last bit; points can be centres of bodies."""
    definition = made(ROOT + "[points]\nhub = [0.3, 0.0, 0.0]\n", WING)
    mesh = block([(0.5, -0.5, 0), (3.5, -0.5, 0), (3.5, 0.5, 0), (0.5, 0.5, 0)], (4, 2))
    edge = np.flatnonzero(mesh.nodes[:, 0] == 0.5).tolist()
    push = TimeFunction((0.0, 0.1, 0.2), (0.0, 1.0, 0.0))
    model = Model.of(
        mesh, 0.02, 2e8, 0.3, 1000.0,
        bodies=[RigidBody("hub", 20.0, (2.0, 3.0, 4.0), (0.3, 0.0, 0.0), edge)],
        joints=[Revolute("ground", "hub", (0, 0, 0), (0, 1, 0), name="root", stiffness=4.0,
                         rest=1.0, torque=2.0, history=push)])
    settings, probes = Settings(0.02, 0.2, Scheme("exact")), {"root": JointProbe("root")}
    told, same = (simulate(one, settings, probes={"hub": len(mesh.nodes), **probes}).history
                  for one in (definition.model(8), model))
    assert definition.probes_on(definition.mesh(8)) == {"hub": (0.3, 0.0, 0.0)}
    assert told["root_angle"][-1] > 1e-3
    for name in told.dtype.names:
        assert np.array_equal(told[name], same[name]), name


def test_a_static_step_with_joints(made):
    """A servo and a motor are where they are at t = 0 in the static step, from which the motion
    begins: it stays there until they move."""
    definition = made("""
[histories.late]
times = [0.0, 0.06, 0.1]
values = [0.3, 0.3, 1.0]
[[joints]]
kind = "revolute"
name = "root"
one = "ground"
other = "hub"
at = [0, 0, 0]
axis = [0, 1, 0]
stiffness = 400.0
rest = 1.0
turning = "late"
[[loads]]
name = "weight"
gravity = [0, 0, -0.5]
[[steps]]
kind = "static"
[[steps]]
kind = "dynamic"
scheme = "exact"
dt = 0.02
end_time = 0.1
[probes]
root = { joint = "root" }
""", WING)
    run = run_model(definition)
    angle = run.static.joint_angles[-1, 0]
    model = definition.model(8)
    x = model.nodes[:, 0] + run.static.displacement[-1, :, 0]
    assert 400.0 * (angle - 0.3) == pytest.approx(0.5 * model.nodal_mass @ x, rel=1e-6)
    told = run.dynamic.history
    np.testing.assert_allclose(told["root_angle"][:4], angle, atol=1e-9)
    assert told["root_angle"][-1] > angle + 1e-3
    np.testing.assert_allclose(told["root_force"][1], run.static.joint_forces[-1, 0], atol=1e-6)


@pytest.mark.parametrize(("text", "joint"), [
    ('kind = "ball"\none = "hub"\nother = "free"\nat = [4, 0, 0]', Ball("hub", "free", (4, 0, 0))),
    ('kind = "ball"\none = [3.5, 0.5, 0]\nother = "free"', Ball(14, "free")),
    ('kind = "revolute"\none = "hub"\nother = "free"\nat = [4, 0, 0]\naxis = [0, 2, 0]\n'
     'angle = 0.5\ndriving = "push"',
     Revolute("hub", "free", (4, 0, 0), (0, 1, 0), 0.5,
              TimeFunction((0.0, 0.1, 0.2), (0.0, 1.0, 0.0)))),
    ('kind = "cylindrical"\none = "hub"\nother = "free"\nat = [4, 0, 0]\naxis = [1, 0, 0]',
     Cylindrical("hub", "free", (4, 0, 0), (1, 0, 0))),
    ('kind = "prismatic"\none = "hub"\nother = "free"\nat = [4, 0, 0]\naxis = [1, 0, 0]',
     Prismatic("hub", "free", (4, 0, 0), (1, 0, 0))),
    ('kind = "universal"\none = "hub"\nother = "free"\nat = [4, 0, 0]\naxis = [1, 0, 0]\n'
     'other_axis = [0, 0, 1]', Universal("hub", "free", (4, 0, 0), (1, 0, 0), (0, 0, 1))),
    ('kind = "link"\none = [3.5, 0.5, 0]\nother = "free"\nto = [5, 0, 1]',
     RigidLink(14, "free", None, (5, 0, 1)))])
def test_tables_become_joints_of_bodies(made, text, joint):
    model = made(FREE + "[[joints]]\n" + text, WING).model(8)
    assert model.joints == (joint,)
    assert model.bodies[1].axes[0] == (0.0, 1.0, 0.0) and model.bodies[1].nodes == ()


def test_a_tie_of_a_mesh_of_a_file(made, tmp_path):
    """Its sides are lines of the mesh."""
    plates = [block([(x, 0, 0), (x + 2, 0, 0), (x + 2, 1, 0), (x, 1, 0)], (2, n))
              for x, n in ((0, 2), (2, 3))]
    n = len(plates[0].nodes)
    nodes = np.concatenate([plate.nodes for plate in plates])
    sides = [np.flatnonzero(nodes[:, 0] == 2.0) for _ in plates]
    line, tied = ([int(i) for i in side if (i < n) == first] for side, first in zip(
        sides, (True, False)))
    Mesh(nodes, np.concatenate([plates[0].quads, plates[1].quads + n]),
         node_sets={"fine": tied}, lines={"coarse": list(zip(line, line[1:]))}
         ).write(tmp_path / "two.inp")
    shell = PANELS[:PANELS.index("[[geometry")] + '[geometry]\nfile = "two.inp"\napart = true\n'
    tie = '[[joints]]\nkind = "tie"\nname = "seam"\nnodes = "fine"\ncurve = "coarse"\n'
    assert made(tie, shell).model(10).joints == (Tie(tied, line, "seam"),)


def test_a_tie_of_blocks(made):
    """Of their sides, by name; on every refinement.  The sides are places of supports too."""
    blocks = """[geometry]
apart = true

[[geometry.blocks]]
corners = [[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]]
divisions = [2, 2]
sides = { rim = 2, root = 4 }

[[geometry.blocks]]
corners = [[2, 0, 0], [4, 0, 0], [4, 1, 0], [2, 1, 0]]
divisions = [2, 3]
sides = { edge = 4 }

[[meshes]]
elements = 10
refinement = 1

[[meshes]]
elements = 40
refinement = 2

[[supports]]
nodes = "root"
fix = "clamped"
"""
    tie = '[[joints]]\nkind = "tie"\nname = "seam"\nnodes = "edge"\ncurve = "rim"\n'
    definition = made(tie, PANELS[:PANELS.index("[[geometry")] + blocks)
    for n, fine, coarse in ((10, 4, 3), (40, 7, 5)):
        model = definition.model(n)
        (joint,) = model.joints
        for nodes, count in ((joint.nodes, fine), (joint.line, coarse)):
            assert len(nodes) == count and np.all(model.nodes[list(nodes), 0] == 2.0)
        assert np.all(model.nodes[list(model.supports[0].nodes), 0] == 0.0)
    joined = blocks.replace("apart = true\n", "")
    with pytest.raises(InputError, match="node 2 is on both sides"):
        made(tie, PANELS[:PANELS.index("[[geometry")] + joined)


@pytest.mark.parametrize(("text", "told"), [
    (ROOT.replace('"hub"', '"hob"'), r"joints\[0\]: 'hob' is no body, must be one of: hub, ground"),
    (ROOT.replace('other = "hub"\n', ""), r"joints\[0\]: other: missing, a revolute joint needs"),
    (ROOT.replace("at = [0, 0, 0]", ""), r"joints\[0\]: at is missing"),
    (ROOT.replace('"hub"', "[9, 9, 9]"), r"joints\[0\]: .*\[?9"),
    (ROOT + 'driving = "pull"\nangle = 1.0', r"joints\[0\].driving: 'pull' is not among push"),
    (ROOT + "angle = 1.0", r"joints\[0\]: revolute joint root: a joint that is driven by its"),
    (ROOT.replace('"revolute"', '"cylindrical"'),
     r"joints\[0\]: history, rest, stiffness, torque: a cylindrical joint has no such thing"),
    (HINGE.replace("[2, 0, 0], [2, 1, 0]", "[2, -0.5, 0], [2, 0.5, 0]") + "axis = [0, 1, 0]",
     r"joints\[0\]: axis: a hinge joint has no such thing"),
    (FREE + FREE, r"bodies\[2\].name: free is that of bodies\[1\] as well"),
    (FREE.replace("1.5]", "3.0]"), r"bodies\[1\]: body free: moments of inertia"),
    (FREE + "where = { x = 0.5 }", r"bodies\[1\]: hub carries node 0 as well"),
    (FREE + 'nodes = "rim"', r"bodies\[1\]: .*rim"),
    (FREE.replace("mass = 1.0", "mass = 0.0"), r"bodies\[1\].mass")])
def test_mistakes_of_bodies(made, text, told):
    with pytest.raises(InputError, match=told):
        made(text, WING)


def test_a_run_with_a_body(made, tmp_path):
    """Drawn with its arms, told by its mass; the result file has its frames and can be plotted."""
    path = tmp_path / "wing.toml"
    path.write_text(WING + ROOT + '[probes]\nroot = { joint = "root" }\n')
    told = json.loads(in_process("check", str(path), "--output", str(tmp_path / "a.svg"),
                                 "--json").stdout)
    assert told["joints"] == {"root": "revolute joint"}
    assert told["bodies"] == {"hub": {"mass": 20.0, "nodes": 3}}
    rows = [line.split(",")[0] for line in (tmp_path / "a.csv").read_text().splitlines()]
    assert rows.count("arm") == 2 * (3 + 1) and rows.count("body") == 1
    assert rows.count("cuboid") == 2 * 12 and rows.count("ground") == 1
    output = tmp_path / "run.h5"
    done = corovec("run", str(path), "--scheme", "exact", "--output", str(output))
    assert done.returncode == 0, done.stderr
    assert read(output)["nodal_von_mises"].shape[1:] == (16, 3)
    plot = corovec("plot", str(output), "--output", str(tmp_path / "plots"))
    assert plot.returncode == 0, plot.stderr
