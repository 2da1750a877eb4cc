"""Model files with masses, springs, foundations, damping, supports that move, and probes."""

import json
import re

import numpy as np
import pytest
from click.testing import CliRunner

from corovec import (
    Damping,
    Drive,
    EnergyProbe,
    Expression,
    Gravity,
    GroundSpring,
    Harmonic,
    InputError,
    Model,
    PointMass,
    Settings,
    Spring,
    StressProbe,
    Support,
    TimeFunction,
    block,
    foundation,
    join,
    load_control,
    run_model,
    simulate,
)
from corovec.solver.cli import cli
from corovec.solver.input.files import read_model

SHELL = """
name = "shell"
parameters = { thickness = 0.01, youngs = 1e9, poisson = 0.3, density = 1000.0 }
[[geometry.blocks]]
corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
divisions = [2, 2]
group = "floor"
[[geometry.blocks]]
corners = [[1, 0, 0], [1, 0, 1], [1, 1, 1], [1, 1, 0]]
divisions = [2, 2]
group = "wall"
"""

EVERYTHING = """
[histories]
shake = { frequency = 4.0 }
tilt = { times = [0.0, 0.1], values = [0.0, 1.0] }
push = { expression = "sin(20 * t)" }
[[drives]]
where = { x = 0.0 }
translation = [0.0, 0.0, 0.02]
rotation = [0.0, 0.1, 0.0]
about = [0.0, 0.5, 0.0]
history = "shake"
turning = "tilt"
[[supports]]
fix = ["y"]
at = [1, 1, 1]
displacement = 0.01
history = "push"
[[masses]]
at = [1, 0, 1]
mass = 2.0
inertia = 0.1
[[masses]]
line = [[1, 0, 0], [1, 1, 0]]
mass = 0.5
[[springs]]
between = [[0.5, 0.5, 0.0], [1.0, 0.5, 1.0]]
stiffness = 300.0
length = 1.0
[[springs]]
between = [[0.5, 0.0, 0.0], [1.0, 0.0, 1.0]]
stiffness = 50.0
[[ground_springs]]
at = [1, 0.5, 1]
stiffness = [10.0, 20.0, 30.0]
turning = 2.0
[[foundations]]
surface = "floor"
stiffness = [0.0, 0.0, 1e4]
[damping]
ratios = [0.05, 0.1]
frequencies = [2.0, 20.0]
[[loads]]
name = "weight"
gravity = [0.0, 0.0, -9.81]
[points]
corner = [1, 0, 1]
[probes]
root = { stress = [0.25, 0.25, 0.0], axes = [0, 1, 0] }
centre = { stress = [1.0, 0.75, 0.75] }
wall = { energy = "wall" }
all = { energy = "all" }
"""

MOTION = """
[[steps]]
kind = "dynamic"
dt = 5e-3
end_time = 0.1
"""

STATIC = """
[[steps]]
kind = "static"
increments = 2
"""


@pytest.fixture
def made(tmp_path):
    """A function that makes the ``ModelFile`` of ``SHELL`` and more text."""
    def make(text):
        path = tmp_path / "shell.toml"
        path.write_text(SHELL + text)
        return read_model(path)
    return make


def in_python(shake, tilt, push):
    """The model of ``EVERYTHING`` with these functions of time, and its mesh."""
    mesh = join([block([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], (2, 2)).named("floor"),
                 block([(1, 0, 0), (1, 0, 1), (1, 1, 1), (1, 1, 0)], (2, 2)).named("wall")])

    def at(*point):
        return int(np.argmin(np.linalg.norm(mesh.nodes - point, axis=1)))
    attached = [PointMass(at(1, 0, 1), 2.0, 0.1),
                *(PointMass(at(1, y, 0), 0.5) for y in (0, 0.5, 1)),
                Spring(at(0.5, 0.5, 0), at(1, 0.5, 1), 300.0, 1.0),
                Spring(at(0.5, 0, 0), at(1, 0, 1), 50.0),
                GroundSpring(at(1, 0.5, 1), (10.0, 20.0, 30.0), 2.0),
                *foundation(mesh.nodes, mesh.quads[mesh.groups["floor"]], (0.0, 0.0, 1e4))]
    return mesh, Model(
        mesh.nodes, mesh.quads, 0.01, 1e9, 0.3, 1000.0, attached=attached,
        damping=Damping.of_ratios(0.05, 2.0, 0.1, 20.0), loads=[Gravity((0, 0, -9.81))],
        supports=[Support((at(1, 1, 1),), ("y",), 0.01, push),
                  Drive([at(0, y, 0) for y in (0, 0.5, 1)], (0, 0, 0.02), (0, 0.1, 0), (0, 0.5, 0),
                        shake, tilt)])


def test_a_file_with_all_of_it_is_the_model_in_python(made):
    """The same history, probes included, to the last bit."""
    mesh, model = in_python(Harmonic(4.0), TimeFunction((0.0, 0.1), (0.0, 1.0)),
                            Expression("sin(20 * t)"))
    probes = {"corner": (1.0, 0.0, 1.0), "root": StressProbe((0.25, 0.25, 0), axes=(0, 1, 0)),
              "centre": StressProbe((1.0, 0.75, 0.75)), "wall": EnergyProbe(mesh.groups["wall"]),
              "all": EnergyProbe()}
    told = simulate(model, Settings(dt=5e-3, end_time=0.1), probes=probes).history
    read = run_model(made(EVERYTHING + MOTION)).dynamic.history
    assert read.dtype == told.dtype
    for name in told.dtype.names:
        assert np.array_equal(read[name], told[name]), name
    for name in ("support_work", "dissipated", "all_strain_energy", "root_von_mises"):
        assert np.abs(read[name]).max() > 0.0, name


def said(*arguments):
    """What a command prints."""
    return CliRunner().invoke(cli, list(map(str, arguments)), catch_exceptions=False).stdout


def test_energies_are_told_where_there_are_any(made, tmp_path):
    """``corovec run`` and ``info``: works and losses where not zero, the balance always."""
    made(EVERYTHING + MOTION)
    output = tmp_path / "all.h5"
    told = json.loads(said("run", tmp_path / "shell.toml", "--output", output, "--json"))
    again = json.loads(said("info", output, "--json"))
    for key in ("support_work", "dissipated", "energy_balance"):
        assert again[key] == told[key]
    history = run_model(made(EVERYTHING + MOTION)).dynamic.history
    assert told["support_work"] == pytest.approx(history["support_work"][-1])
    assert told["dissipated"] == pytest.approx(history["dissipated"][-1])
    energy = history["kinetic_energy"] + history["strain_energy"] + history["dissipated"]
    left = energy - energy[0] - history["external_work"] - history["support_work"]
    assert told["energy_balance"] == pytest.approx(np.abs(left).max() / told["total_energy"],
                                                   rel=1e-6)
    assert told["energy_balance"] < 1e-6  # what Newton's iteration leaves, tolerance 1e-6
    assert np.abs(left - history["dissipated"]).max() > 1e-2  # the check can tell
    text = said("info", output)
    assert "dissipated  " in text and "support work  " in text and "energy balance  " in text
    made("[defaults]\ndt = 1e-3\nend_time = 2e-3\n[motion]\nspin = [0, 0, 1]\n")
    plain = said("run", tmp_path / "shell.toml")
    assert "energy balance" in plain
    assert "dissipated" not in plain and "support work" not in plain


def test_supports_that_move_are_still_in_a_static_step_before_a_motion(made):
    """They grow to where they are at t = 0, as loads do: the motion starts there."""
    static, dynamic = run_model(made(EVERYTHING + STATIC + MOTION))
    zero = TimeFunction((0.0, 1.0), (0.0, 0.0))
    _, model = in_python(zero, zero, zero)
    assert np.abs(static.displacement[-1] - load_control(model, [0.5, 1.0]).displacement[-1]
                  ).max() < 1e-9
    row = dynamic.history["corner_u"][0]
    assert row == pytest.approx(static.displacement[-1][np.argmax(np.all(
        model.nodes == (1, 0, 1), axis=1))], abs=1e-12)
    assert dynamic.history["support_work"][-1] != 0.0


def test_a_static_step_alone_takes_the_load_factor(made):
    """A support that moves is at its function of the factor."""
    text = EVERYTHING.replace("[0.0, 0.1], values", "[0.0, 1.0], values")
    file = made(text + STATIC)
    static, root = run_model(file).static, file.mesh(8).nodes[:, 0] == 0.0
    sines = np.repeat(np.sin(0.1 * static.factors)[:, None], 3, axis=1)
    assert np.allclose(static.normals[:, root, 0], sines, atol=1e-9)


def test_a_shaken_base_is_a_weight_that_changes():
    """In the frame that moves with the base: ``g = -a(t)``, exact without rotation (docs)."""
    mesh = block([(0, 0, 0), (1, 0, 0), (1, 0.1, 0), (0, 0.1, 0)], (8, 1))
    root, tip = (tuple(mesh.nodes_at(x=x).tolist()) for x in (0.0, 1.0))
    clamped = ("x", "y", "z", "px", "py", "pz")
    # u = 0.01 (1 - cos w t), a = 0.01 w^2 cos w t
    options = {"thickness": 0.01, "youngs": 1e9, "poisson": 0.0, "density": 1000.0}
    driven = Model.of(mesh, **options, supports=[Drive(root, (0, 0, 0.01), history=Expression(
        "1 - cos(12 * t)"))])
    weighed = Model.of(mesh, **options, supports=[Support(root, clamped)], loads=[
        Gravity((0, 0, -0.01 * 144), Expression("cos(12 * t)"))])
    one, two = (simulate(model, Settings(dt=2e-3, end_time=0.5), probes={"tip": tip[0]}).history
                for model in (driven, weighed))
    relative = one["tip_u"][:, 2] - 0.01 * (1.0 - np.cos(12.0 * one["time"]))
    assert np.abs(relative - two["tip_u"][:, 2]).max() < 5e-3 * np.abs(relative).max()  # dt^2
    assert np.abs(one["tip_u"][:, 2] - two["tip_u"][:, 2]).max() > 0.1 * np.abs(relative).max()


def test_what_a_file_defines_is_listed(made):
    rows = {row[0]: row[1:3] for row in made(EVERYTHING + MOTION).provenance()}
    assert rows["masses[0] inertia"] == (0.1, "kg m^2") and rows["springs[0] length"] == (1.0, "m")
    assert rows["foundations[0] stiffness"] == ([0.0, 0.0, 1e4], "N/m^3")
    assert rows["drives[0] rotation"] == ([0.0, 0.1, 0.0], "rad")
    assert rows["damping frequencies"] == ([2.0, 20.0], "Hz")
    assert rows["probe root stress"] == ([0.25, 0.25, 0.0], "m")


MASS, DRIVE = "[[masses]]\nat = [0, 0, 0]\n", "[[drives]]\nwhere = { x = 0.0 }\n"
Q = "[histories]\nq = { times = [0.0], values = [1.0], unit = 'm' }\n"


@pytest.mark.parametrize("text, message", [
    (MASS, "masses[0].mass: is missing"),
    (MASS + "mass = -1.0", "masses[0].mass: must not be negative, is -1"),
    (MASS + "mass = { value = 1.0, unit = 'g', provenance = 'given', source = '' }",
     "masses[0].mass: in 'g', must be in 'kg'"),
    (MASS + "mass = 1.0\ninertai = 2.0", "masses[0].inertai: is unknown, did you mean 'inertia'?"),
    ("[[masses]]\nmass = 1.0", "masses[0]: one of at, line, nodes, where is needed, none is given"),
    ("[[masses]]\nmass = 1.0\nnodes = 'tip'", "masses[0]: node set 'tip' is unknown"),
    ("[[masses]]\nmass = 1.0\nline = [[1, 0, 0], [1, 1, 0]]\n[[masses]]\nat = [1, 0.5, 0]\n"
     "mass = 1.0\ninertia = 1.0", "masses[1]: several plates meet at node"),
    ("[[springs]]\nbetween = [[0, 0, 0], [0, 0, 0]]\nstiffness = 1.0",
     "springs[0]: spring: both ends are node 0"),
    ("[[springs]]\nbetween = [[0, 0, 0], [5, 0, 0]]\nstiffness = 1.0",
     "springs[0]: no node at [5.0, 0.0, 0.0]"),
    ("[[springs]]\nbetween = [[0, 0, 0], [1, 0, 0]]\nstiffness = 1.0\nlength = 0.0",
     "springs[0].length: must be positive"),
    ("[[ground_springs]]\nat = [0, 0, 0]", "ground_springs[0]: a stiffness or turning is needed"),
    ("[[ground_springs]]\nat = [0, 0, 0]\nstiffness = [1, -2, 0]",
     "ground_springs[0].stiffness[1]: must not be negative, is -2"),
    ("[[foundations]]\nsurface = 'roof'\nstiffness = [0, 0, 1]",
     "foundations[0]: group 'roof' is unknown, must be one of: floor, wall"),
    ("[damping]\nmass = 1.0\nratios = [0.1, 0.1]",
     "damping: mass and stiffness, or ratios and frequencies are needed"),
    ("[damping]", "damping: mass and stiffness, or ratios and frequencies are needed"),
    ("[damping]\nratios = [0.1, 0.1]", "damping: frequencies are missing"),
    ("[damping]\nfrequencies = [1, 2]", "damping: ratios are missing"),
    ("[damping]\nratios = [0.1, 1e-4]\nfrequencies = [1, 50]",
     "damping: ratios 0.1 at 1 Hz and 0.0001 at 50 Hz need mass"),
    (DRIVE, "drives[0]: a translation or a rotation is needed"),
    (DRIVE + "translation = [0, 0, 1]\nturning = 'q'", "drives[0]: turning belongs to a rotation"),
    (DRIVE + "translation = [0, 0, 1]\nhistory = 'w'", "drives[0].history: 'w' is unknown"),
    (DRIVE + "translation = [0, 0, 1]\nhistory = 'q'\n" + Q,
     "drives[0].history: 'q' is in 'm', must be without unit"),
    (DRIVE + "translation = [0, 0, 1]\n[[supports]]\nfix = 'pinned'\nat = [0, 0, 0]\n",
     "supports[0] and drives[0] give x different displacements"),
    ("[probes]\na = { energy = 'roof' }", "probes.a: group 'roof' is unknown, must be one of"),
    ("[probes]\na = { energy = 'all', axes = [1, 0, 0] }", "probes.a: axes belong to stress"),
    ("[probes]\na = {}", "probes.a: one of stress, energy, joint is needed, none is given"),
    ("[probes]\n'a b' = { energy = 'all' }", "probes.a b: a name is letters, digits and _"),
    ("[probes]\na = { stress = [0, 0, 0], axes = [0, 0, 1] }",
     "probes.a: axes (0.0, 0.0, 1.0) are no direction in the surface of element 0"),
    ("[probes]\na = { energy = 'all' }\n[points]\na = [0, 0, 0]", "probes.a: a point has the same"),
])
def test_mistakes(made, text, message):
    """Each with its place in the file, on one line."""
    with pytest.raises(InputError, match=re.escape(message)) as told:
        made(text + STATIC)
    assert "\n" not in str(told.value) and "shell.toml: " in str(told.value)


def test_all_mistakes_are_told_at_once(made):
    with pytest.raises(InputError) as told:
        made(MASS + "mass = -1.0\n" + DRIVE + "[damping]\nmass = 'x'\n" + STATIC)
    assert all(f"{place}: " in str(told.value) for place in ("masses[0].mass", "drives[0]",
                                                             "damping.mass"))
