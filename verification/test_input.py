"""Wrong input: one clear line that names the thing and its place, and nothing happens."""

import copy
import pickle
import re
from dataclasses import fields

import numpy as np
import pytest

from corovec import (
    InputError,
    Mesh,
    Model,
    Newton,
    NodalLoad,
    NodalMoment,
    Pressure,
    Scheme,
    Settings,
    StaticSettings,
    Support,
    TimeFunction,
    arc_length,
    block,
    drift,
    join,
    line_load,
    line_moment,
    load_control,
    orient,
    rigid_velocity,
    simulate,
    solve_linear,
    sphere_segment,
    surface_load,
    total_energy,
)
from corovec.benchmarks import FOLDER, load_case
from corovec.convergence import run_many
from corovec.solver.checks import HUGE, TINY
from corovec.solver.input.files import read_model
from corovec.solver.model.mesh import node_at, vector_areas
from corovec.verification.models import MATERIAL, rectangle

NODES = np.array([(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0), (1, 1, 0), (2, 1, 0)], dtype=float)
QUADS = np.array([(0, 1, 4, 3), (1, 2, 5, 4)])


def model(nodes=NODES, quads=QUADS, **options):
    return Model(nodes, quads, **{**MATERIAL, **options})


def changed(index, value):
    nodes = NODES.copy()
    nodes[index] = value
    return nodes


@pytest.mark.parametrize("nodes, quads, message", [
    (changed((3, 2), np.nan), QUADS, r"nodes\[3, 2\] is nan, must be finite"),
    (changed((1, 0), np.inf), QUADS, r"nodes\[1, 0\] is inf, must be finite"),
    (NODES[:, :2], QUADS, r"nodes: shape \(6, 2\) given, \(n, 3\) needed"),
    ("plate", QUADS, r"nodes: not an array of numbers"),
    (NODES, QUADS[:, :3], r"quads: shape \(2, 3\) given, \(n, 4\) needed"),
    (NODES, QUADS.astype(float), r"quads: node numbers must be integers"),
    (NODES, [(0, 1, 4, 6), (1, 2, 5, 4)], r"element 0: node 6 does not exist \(0 to 5\)"),
    (NODES, [(0, 1, 4, -1), (1, 2, 5, 4)], r"element 0: node -1 does not exist"),
    (NODES, [(0, 1, 4, 3), (1, 2, 2, 4)], r"element 1: nodes \[1, 2, 2, 4\] repeat"),
    (NODES, [(0, 1, 4, 3), (1, 2, 5, 4), (4, 3, 0, 1)], r"element 2 duplicates element 0"),
    (NODES, [(0, 1, 4, 3), (1, 4, 5, 2)], r"inverted against their neighbours: element 1; "),
    (NODES, [(0, 1, 3, 4), (1, 2, 5, 4)], r"element 0: degenerate or twisted, the diagonals of"),
    (changed(0, (0.9, 0.9, 0.0)), QUADS, r"element 0: degenerate, inverted or not convex at its "
                                         r"node 0"),
    (changed(4, (1.0, 1e-9, 0.0)), QUADS, r"nodes 1 and 4 are at the same place"),
    (changed(4, (1.0, 1e-7, 0.0)), QUADS, r"element 0: degenerate, inverted or not convex at"),
    (changed(0, (0.5, 0.5, 0.0)), [(0, 1, 4, 3), (1, 2, 5, 4)], r"element 0: degenerate"),
    (np.vstack([NODES, (9, 9, 9)]), QUADS, r"node 6 belongs to no element"),
    (np.vstack([NODES, NODES[4] + 1e-12]), [(0, 1, 4, 3), (1, 2, 5, 6)],
     r"nodes 4 and 6 are at the same place \[1.0, 1.0, 0.0\]"),
    (NODES, np.zeros((0, 4), dtype=int), r"quads: shape \(0, 4\) given"),
    (NODES * 1e90, QUADS, r"nodes\[1, 0\] is 1e\+90, must be finite and below 1e\+30"),
    (NODES * 1e-99, QUADS, r"nodes: the mesh is 2e-99 m large, must be 1e-30 m at least"),
    (np.ma.masked_equal(NODES, 2.0), QUADS, r"nodes: some values are masked"),
    (list(np.ma.masked_equal(NODES, 2.0)), QUADS, r"nodes: some values are masked"),
    (NODES, np.ma.masked_equal(QUADS, 5), r"quads: some values are masked"),
])
def test_bad_mesh(nodes, quads, message):
    with pytest.raises(InputError, match=message) as error:
        model(nodes, quads if np.ma.is_masked(quads) else np.array(quads))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("options, message", [
    ({"thickness": 0.0}, r"thickness must be positive \[m\], at least 1e-30, is 0 at element 0"),
    ({"thickness": [0.1, -0.2]}, r"at least 1e-30, is -0.2 at element 1"),
    ({"thickness": [0.1, 0.1, 0.1]}, r"thickness: shape \(3,\) given, \(2\) needed"),
    ({"youngs": -1e6}, r"youngs must be positive \[Pa\]"),
    ({"density": 0.0}, r"density must be positive \[kg/m\^3\]"),
    ({"density": np.nan}, r"density must be finite and below 1e\+30, is nan"),
    ({"poisson": 0.5}, r"poisson must lie in \(-1, 0.5\), is 0.5 at element 0"),
    ({"poisson": -1.0}, r"poisson must lie in \(-1, 0.5\)"),
    ({"membrane": "magic"}, r"membrane 'magic' is unknown, must be one of: stress, strain"),
    ({"shear": "none"}, r"shear 'none' is unknown, must be one of: mitc4, compatible"),
    ({"velocity": np.zeros((5, 3))}, r"velocity: shape \(5, 3\) given, \(6, 3\) needed"),
    ({"normal_velocity": np.tile((0.0, 0.0, 1.0), (6, 1))},
     r"normal_velocity of node 0 is not tangential"),
    ({"normals": np.zeros((6, 3))}, r"normals\[0\] has length 0, must be 1"),
    ({"normals": np.tile((0.0, 0.0, -1.0), (6, 1))}, r"^normals 0, 1, 2, 3, 4, 5 are opposite to"),
    ({"normals": [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0, 0, -1), (0, 1, 0), (0, 0, 1)]},
     r"normals 1, 3 are opposite .*: turn their sign, .*; normals 2, 4 are more than 60 degrees"),
    ({"thickness": "0.1"}, r"thickness must be a number, is '0.1'"),
    ({"thickness": True}, r"thickness must be a number, is True"),
    ({"thickness": None}, r"thickness is missing"),
    ({"youngs": 1e6 + 1j}, r"youngs must be a number"),
    ({"thickness": 1e-99}, r"thickness must be positive \[m\], at least 1e-30, is 1e-99"),
    ({"thickness": np.ma.masked}, r"thickness must be a number, is masked"),
    ({"thickness": np.ma.array([0.1, 0.1], mask=[False, True])}, r"thickness: some values are m"),
    ({"youngs": 10**400}, r"youngs must be a number, is 10+ \.\.\.$"),
    ({"youngs": 1e200}, r"youngs must be finite and below 1e\+30"),
    ({"velocity": np.full((6, 3), 1e200)}, r"velocity\[0, 0\] is 1e\+200, must be finite"),
    ({"loads": None}, r"loads must be a list, is None"),
    ({"loads": [(0, (0, 0, 1))]}, r"loads\[0\] must be one of NodalLoad, NodalMoment, Pressure"),
    ({"supports": "clamped"}, r"supports\[0\] must be one of Support"),
])
def test_bad_properties(options, message):
    with pytest.raises(InputError, match=message):
        model(**options)


@pytest.mark.parametrize("make, message", [
    (lambda: model(loads=[NodalLoad(6, (0, 0, 1))]), r"load 0: node 6 does not exist \(0 to 5\)"),
    (lambda: model(loads=[Pressure(1.0, (2,))]), r"load 0: element 2 does not exist \(0 to 1\)"),
    (lambda: NodalLoad(0, {1.0, 2.0, 3.0}), r"force must be three numbers \[N\], is {1.0, 2.0"),
    (lambda: NodalLoad(0, {0: 1.0, 1: 2.0, 2: 3.0}), r"force must be three numbers \[N\], is {0:"),
    (lambda: NodalLoad(0, np.ma.masked_equal([1.0, 2.0, 3.0], 2.0)),
     r"force\[1\] must be a number \[N\], is masked"),
    (lambda: NodalLoad(0, [np.zeros((9, 9)), 0, 1]), r"force\[0\] must be a number \[N\], is arr"),
    (lambda: NodalLoad(0, [(1, (2, 3)), 0, 1]), r"force\[0\] must be a number \[N\], is \(1, \(2"),
    (lambda: NodalLoad(2, (0, np.nan, 1)), r"load at node 2: force\[1\] must be finite"),
    (lambda: NodalLoad(0, (0, 0)), r"load at node 0: force must be three numbers \[N\]"),
    (lambda: NodalLoad(0, "up!"), r"load at node 0: force must be three numbers \[N\]"),
    (lambda: NodalLoad(0, ("0", "0", "1")), r"force\[0\] must be a number \[N\], is '0'"),
    (lambda: NodalLoad(1.0, (0, 0, 1)), r"load: node must be an integer, is 1.0"),
    (lambda: NodalLoad("a", (0, 0, 1)), r"load: node must be an integer, is 'a'"),
    (lambda: NodalLoad(True, (0, 0, 1)), r"load: node must be an integer, is True"),
    (lambda: NodalLoad(0, (0, 0, 1), 5.0), r"history must be a TimeFunction, Steps, .* is 5.0"),
    (lambda: NodalMoment(0, (0, 0)), r"load at node 0: moment must be three numbers \[N m\]"),
    (lambda: Pressure(np.inf), r"pressure must be finite"),
    (lambda: Pressure(1.0, ()), r"pressure: elements must not be empty"),
    (lambda: Pressure(1.0, (0, 1, 0)), r"pressure: elements: 0 is given 2 times"),
    (lambda: Support((), ("x",)), r"support: nodes must not be empty"),
    (lambda: Support((4, 3, 4), ("x",)), r"support: nodes: 4 is given 2 times"),
    (lambda: Support({3, 4}, ("x",)), r"support: nodes must be a sequence of integers, is {3, 4}"),
    (lambda: model(supports=[Support((7,), ("x",))]), r"support 0: node 7 does not exist"),
    (lambda: Support((0,), ("rx",)), r"support: component 'rx' is unknown"),
    (lambda: Support((0,), "xyz"), r"support: components must be a list"),
    (lambda: Support(3, ("x",)), r"support: nodes must be a sequence of integers, is 3"),
    (lambda: Support((1.5,), ("x",)), r"support: nodes\[0\] must be an integer, is 1.5"),
    (lambda: Support((0,), ("px",), 1.0), r"can be prescribed to x, y and z only, not to px"),
    (lambda: model(supports=[Support((4,), ("pz",))]),
     r"node 4: its normal is nearly along z, so that a support of pz alone fixes it"),
    (lambda: rigid_velocity(model(), (0, 0), (0, 0, 1)), r"velocity must be three numbers"),
    (lambda: rigid_velocity(model(), (0, 0, 0), "spin"), r"omega must be three numbers"),
])
def test_bad_loads_and_supports(make, message):
    with pytest.raises(InputError, match=message) as error:
        make()
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("nodes, line, force, message", [
    (NODES, (0, 1, 6), (0, 0, 1), r"node 6 does not exist \(0 to 5\)"),
    (NODES, (-1, 1), (0, 0, 1), r"node -1 does not exist"),
    (NODES, (0.0, 1.0), (0, 0, 1), r"line\[0\] must be an integer, is 0.0"),
    (NODES, "01", (0, 0, 1), r"line must be a sequence of integers, is '01'"),
    (NODES, ("0", "1"), (0, 0, 1), r"line\[0\] must be an integer, is '0'"),
    (NODES, 3, (0, 0, 1), r"line must be a sequence of integers, is 3"),
    (NODES, {0, 1}, (0, 0, 1), r"line must be a sequence of integers, is {0, 1}"),
    (NODES, (0, 1, 1, 2), (0, 0, 1), r"node 1 follows itself in the line"),
    (NODES, (2,), (0, 0, 1), r"line must have two nodes or more, has 1"),
    (NODES[:, :2], (0, 1), (0, 0, 1), r"nodes: shape \(6, 2\) given, \(n, 3\) needed"),
    (NODES, (0, 1), (0, 1), r"must be three numbers \[N.*/m\], is \(0, 1\)"),
    (NODES, (0, 1), 5.0, r"must be three numbers \[N.*/m\], is 5.0"),
    (NODES, (0, 1), "abc", r"must be three numbers \[N.*/m\], is 'abc'"),
    (NODES, (0, 1), (0, np.inf, 0), r"\[1\] must be finite"),
])
def test_bad_line_loads(nodes, line, force, message):
    for what, make in (("line load: ", line_load), ("line moment: ", line_moment)):
        with pytest.raises(InputError, match=f"^{what}.*{message}") as error:
            make(nodes, line, force)
        assert "\n" not in str(error.value)


@pytest.mark.parametrize("nodes, quads, force, message", [
    (NODES, [(0, 1, 4, 6)], (0, 0, 1), r"element 0: node 6 does not exist \(0 to 5\)"),
    (NODES, [(0, 1, 4, -3)], (0, 0, 1), r"element 0: node -3 does not exist"),
    (NODES, QUADS.astype(float), (0, 0, 1), r"quads: node numbers must be integers"),
    (NODES, "all", (0, 0, 1), r"quads: shape \(\) given, \(n, 4\) needed"),
    (NODES, QUADS[0], (0, 0, 1), r"quads: shape \(4,\) given"),
    (NODES, [(0, 1, 4, 4)], (0, 0, 1), r"element 0: nodes \[0, 1, 4, 4\] repeat"),
    (NODES, QUADS[[0, 1, 0]], (0, 0, 1), r"element 2 duplicates element 0"),
    ("plate", QUADS, (0, 0, 1), r"surface load: nodes: not an array of numbers"),
    (NODES, QUADS, (0, 1), r"surface load: force must be three numbers \[N/m\^2\]"),
    (NODES, QUADS, (0, 0, None), r"surface load: force\[2\] must be a number .*, is None"),
])
def test_bad_surface_loads(nodes, quads, force, message):
    with pytest.raises(InputError, match=message):
        surface_load(nodes, quads, force)


PUSH = TimeFunction((0.0, 1.0), (0.0, 1.0))


@pytest.mark.parametrize("first, second", [
    ({"displacement": 0.1}, {"displacement": 0.2}),
    ({"displacement": 0.1}, {"displacement": 0.1, "history": PUSH}),
    ({"displacement": 0.1}, {}), ({}, {"displacement": 0.1}),
])
def test_supports_that_contradict_each_other(first, second):
    """A component has one displacement and one history; the same ones may be given again."""
    with pytest.raises(InputError, match="node 4: supports 1 and 2 give z different displacements"):
        model(supports=[Support((0,), ("x",)), Support((3, 4), ("y", "z"), **first),
                        Support((4, 5), ("z", "x"), **second)])
    for same in (first, second):
        model(supports=[Support((3, 4), ("y", "z"), **same), Support((4, 5), ("z",), **same)])


@pytest.mark.parametrize("call, settings", [
    (simulate, Settings(0.1, 0.1)),
    (lambda m, s: load_control(m, [1.0], s), StaticSettings()),
    (lambda m, s: arc_length(m, 1.0, lambda factor, u: True, s), StaticSettings()),
    (lambda m, s: solve_linear(m), None),
], ids=["simulate", "load_control", "arc_length", "solve_linear"])
def test_what_is_no_model_or_no_settings(call, settings):
    for wrong in (None, {"nodes": NODES}, NODES):
        with pytest.raises(InputError, match="^model must be a Model, is") as error:
            call(wrong, settings)
        assert "\n" not in str(error.value)
    if settings is not None:
        for wrong in (None, {"dt": 0.1}, Scheme()):
            with pytest.raises(InputError, match=f"^settings must be a {type(settings).__name__}"):
                call(model(), wrong)


@pytest.mark.parametrize("size", [TINY, 0.4 * HUGE])
@pytest.mark.parametrize("value", [TINY, 0.4 * HUGE])
def test_numbers_within_the_bounds_neither_overflow_nor_underflow(size, value):
    """At both ends of what is accepted; NumPy's warnings are errors in these tests."""
    clamped = model(NODES * size, thickness=size, youngs=value, density=value,
                    loads=[NodalLoad(5, (0, 0, value))],
                    supports=[Support((0, 3), ("x", "y", "z", "px", "py", "pz"))])
    displacement, _ = solve_linear(clamped)
    assert np.all(np.isfinite(displacement)) and displacement[5, 2] > 0.0
    free = model(NODES * size, thickness=size, youngs=value, density=value)
    assert simulate(free, Settings(dt=1.0, end_time=1.0)).total_energy[-1] == 0.0


def test_loads_are_plain_data_whatever_they_are_made_of():
    """The same load in other types has the same fingerprint; other supports another one."""
    from corovec.solver.runtime.provenance import fingerprint
    pulse = TimeFunction(np.array([0, 1]), [1, 0])
    plain = model(loads=[NodalLoad(3, (0.0, 0.0, 1.0), TimeFunction((0.0, 1.0), (1.0, 0.0)))])
    other = model(loads=(NodalLoad(np.int64(3), np.array([0, 0, 1.0]), pulse),))
    assert fingerprint(plain) == fingerprint(other)
    many = np.arange(2000)
    shifted = many.copy()
    shifted[1000] = 2000
    plate = rectangle(200.0, 10.0, (200, 10))
    prints = {fingerprint(model(plate.nodes, plate.quads, supports=[Support(nodes, ("x",))]))
              for nodes in (many, shifted)}
    assert len(prints) == 2


def corner(angle=90.0, flip=False, **options):
    """Two plates that meet on an edge; ``angle`` between them, 180 when they go on straight."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    nodes = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (c, 0, s), (c, 1, s)]
    return model(nodes, [(0, 1, 2, 3), (0, 4, 5, 3) if flip else (0, 3, 5, 4)], **options)


def same_normals():
    """Normals of a right-angled corner, both plates of every junction along their bisector."""
    directors = corner().directors
    normals = directors.normals.copy()
    for i in np.flatnonzero(np.diff(directors.first) > 1):
        pair = slice(directors.first[i], directors.first[i] + 2)
        normals[pair] = normals[pair].sum(axis=0) / np.sqrt(2.0)
    return normals


def test_folds_are_junctions_from_the_fold_angle_on():
    """Plates that meet at an angle share nodes with two directors, or are one by their numbers."""
    assert np.diff(corner(90.0).directors.first).tolist() == [2, 1, 1, 2, 1, 1]
    assert np.diff(corner(136.0).directors.first).tolist() == [1, 1, 1, 1, 1, 1]
    assert np.diff(corner(134.0).directors.first).tolist() == [2, 1, 1, 2, 1, 1]
    assert np.diff(corner(136.0, fold_angle=40).directors.first).tolist() == [2, 1, 1, 2, 1, 1]
    assert len(corner(110.0, patches=(7, 7)).normals) == 6
    assert len(corner(160.0, patches=(1, 2)).normals) == 8


@pytest.mark.parametrize("make, message", [
    (lambda: corner(180.0, patches=(1, 2)), "node 0: the 2 plates that meet there are coplanar"),
    (lambda: corner(0.5), "node 0: the 2 plates that meet there are coplanar"),
    (lambda: corner(170.0, flip=True), "inverted against their neighbours: element 1; "),
    (lambda: corner(80.0, patches=(1, 1)), "is 50 degrees from the mean of its patch"),
    (lambda: corner(fold_angle=0.0), r"fold_angle must lie in \(0, 90\] \[degrees\], is 0"),
    (lambda: corner(patches=(1, 2, 3)), r"patches: 3 given, one an element \(2\) needed"),
    (lambda: corner(patches=(1, 2.5)), r"patches\[1\] must be an integer"),
    (lambda: corner(normals=np.tile((0, 0, 1.0), (6, 1))), r"normals: shape \(6, 3\) given"),
    (lambda: corner(normals=np.array([(0, 1, 1), (0, 1, 1), *[(0, 0, 1)] * 6]) / 2**0.5),
     "has length"),
    (lambda: corner(normals=same_normals()), "plates that meet at node 0 are given the same"),
    (lambda: corner(normal_velocity=np.eye(8, 3)), "normal_velocity of node"),
])
def test_bad_junctions(make, message):
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize("copied", [lambda plate: plate, copy.deepcopy,
                                    lambda plate: pickle.loads(pickle.dumps(plate))])
def test_models_cannot_be_changed_behind_their_back(copied):
    """Nor can those that came to another process, for which kernels would be compiled anew."""
    plate = copied(model())
    for name in ("nodes", "quads", "thickness", "normals", "velocity"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(plate, name)[0] = 1


def test_pulse_that_the_steps_miss():
    """A pulse of 0.4 ms between two samples of dt = 1 ms would be lost; the message says so."""
    pulse = TimeFunction((0.0, 2e-4, 4e-4), (0.0, 100.0, 0.0))
    hit = model(loads=[NodalLoad(0, (0, 0, 200.0), pulse)])
    with pytest.raises(InputError, match="load 0: dt 0.001 s is too long for its time function: .* "
                       "shortest time between its points is 0.0002 s"):
        simulate(hit, Settings(dt=1e-3, end_time=1e-2))
    simulate(hit, Settings(dt=2e-5, end_time=1e-3))


@pytest.mark.parametrize("run", [lambda m: simulate(m, Settings(dt=0.1, end_time=0.1)),
                                 lambda m: load_control(m, [1.0]), solve_linear])
def test_loads_that_do_nothing_are_told(run):
    """All of them held: a warning with their numbers, about the line that called.  A surface load
    on a clamped edge, whose other nodes are free, is none."""
    clamped = Support((0, 3), ("x", "y", "z", "px", "py", "pz"))
    held = [NodalLoad(0, (0, 0, 1)), NodalMoment(3, (1, 0, 0))]
    with pytest.warns(UserWarning, match="no load does anything: .* all of loads 0, 1, whose nodes"
                      ) as told:
        run(model(loads=held, supports=[clamped]))
    assert told[0].filename == __file__
    run(model(loads=[*held, NodalLoad(1, (0, 0, 1))], supports=[clamped]))
    run(model(loads=surface_load(NODES, QUADS, (0, 0, -1)), supports=[clamped]))


def test_velocity_of_a_support_is_refused():
    still = model(supports=[Support((0,), ("x",))], velocity=np.ones((6, 3)))
    with pytest.raises(InputError, match="node 0: initial velocity of a supported component"):
        simulate(still, Settings(dt=0.1, end_time=0.1))


@pytest.mark.parametrize("times, values, message", [
    ((0.0, 1.0), (1.0,), "2 times but 1 values"),
    ((), (), "0 times but 0 values"),
    (None, (1.0,), "times must be a list of numbers, is None"),
    (("abc",), (1.0,), r"times\[0\] must be a number, is 'abc'"),
    ((0.0, 0.0), (1.0, 2.0), "must increase"),
    ((0.0, np.nan), (1.0, 2.0), "must be finite"),
])
def test_bad_time_function(times, values, message):
    with pytest.raises(InputError, match=message):
        TimeFunction(times, values)


@pytest.mark.parametrize("options, message", [
    ({"dt": 0.0}, "dt must be positive"), ({"dt": -1.0}, "dt must be positive"),
    ({"dt": 1e-99, "end_time": 1e-98}, r"dt must be positive \[s\], at least 1e-30, is 1e-99"),
    ({"dt": np.nan}, "dt must be finite"),
    ({"end_time": np.inf}, "end_time must be finite"),
    ({"dt": 0.3}, "end_time 1 s is not a multiple of dt 0.3 s; the nearest ones are 0.9 and 1.2"),
    ({"dt": 3.0}, "end_time 1 s is not a multiple of dt 3 s; the smallest is 3 s"),
    ({"scheme": "quasi"}, r"scheme must be a Scheme, as scheme=Scheme\(name='quasi'\), is 'quasi'"),
    ({"newton": "full"}, r"newton must be a Newton, as newton=Newton\(kind='full'\), is 'full'"),
    ({"newton": Scheme()}, r"newton must be a Newton, is Scheme\("),
    ({"solver": "magma"}, "solver 'magma' is unknown, must be one of: auto, skyline, dense"),
    ({"frame_every": -1}, "frame_every must not be negative"),
    ({"frame_every": 2.5}, "frame_every must be an integer, is 2.5"),
    ({"dt": "0.1"}, r"dt must be a number \[s\], is '0.1'"),
    ({"dt": 1e-12}, "at most 1e.08 can be recorded"),
])
def test_bad_settings(options, message):
    with pytest.raises(InputError, match=message):
        Settings(**{"dt": 0.1, "end_time": 1.0, **options})


@pytest.mark.parametrize("kind, options, message", [
    (Scheme, {"name": "euler"}, "name 'euler' is unknown, must be one of: quasi, exact, newmark"),
    (Scheme, {"name": None}, "name None is unknown"),
    (Scheme, {"rho_inf": 1.5}, r"rho_inf must lie in \[0, 1\], is 1.5"),
    (Scheme, {"rho_inf": np.nan}, "rho_inf must be finite"),
    (Scheme, {"rho_inf": "1"}, "rho_inf must be a number, is '1'"),
    (Scheme, {"transformation": "end"}, "transformation 'end' is unknown"),
    (Scheme, {"axes": "body"}, "axes 'body' is unknown, must be one of: nodal, global"),
    (Scheme, {"name": "newmark", "rho_inf": 0.5}, "belong to the scheme quasi"),
    (Scheme, {"dissipates": "constant"}, "dissipates belongs to the scheme exact; quasi has none"),
    (Newton, {"kind": "broyden"}, "kind 'broyden' is unknown, must be one of: modified, full"),
    (Newton, {"tolerance": 0.0}, "tolerance must lie in"),
    (Newton, {"min_iterations": 0}, "min_iterations must lie in"),
    (Newton, {"min_iterations": 2.5}, "min_iterations must be an integer"),
    (Newton, {"max_iterations": 0}, "max_iterations must be at least 1, is 0"),
    (Newton, {"max_iterations": 1, "min_iterations": 1}, "a kept matrix takes 2 iterations at l"),
])
def test_bad_scheme_and_newton(kind, options, message):
    with pytest.raises(InputError, match=message):
        kind(**options)


def test_settings_describe_themselves():
    """Every field is in the docstring, with its unit and choices."""
    for kind in (Settings, Scheme, Newton, StaticSettings):
        for field in fields(kind):
            line = next(line for line in kind.__doc__.splitlines()
                        if line.startswith(f"        {field.name}: "))
            assert f"[{field.metadata['unit']}]" in line or not field.metadata["unit"]
            assert all(f"``{choice}``" in line for choice in field.metadata["choices"])


def test_unknown_case_and_mesh():
    with pytest.raises(InputError, match="case 'l-shape' is unknown, must be one of: hemisphere, "
                       "l-plate, plates, ruler"):
        load_case("l-shape")
    with pytest.raises(InputError, match="no mesh of 31 elements, must be one of: 30, 120, 480"):
        load_case("l-plate").model(31)


def test_no_node_at_a_load_point():
    with pytest.raises(InputError, match=r"no node at \[5.0, 5.0, 0.0\]; the nearest, node 5"):
        node_at(NODES, (5, 5, 0))


def test_definition_file_reports_every_error_with_its_path(tmp_path):
    """An unknown field, a wrong type and a missing value: all at once."""
    source = (FOLDER / "l-plate.toml").read_text()
    broken = (source.replace("thickness = {", "thicknes = {")
              .replace("value = 0.3,", 'value = "soft",')
              .replace('provenance = "selected"', 'provenance = "guessed"', 1))
    path = tmp_path / "broken.toml"
    path.write_text(broken)
    with pytest.raises(InputError) as error:
        read_model(path)
    text = str(error.value)
    for where in ("parameters.thickness: is missing",
                  "parameters.thicknes: is unknown, did you mean 'thickness'?",
                  "parameters.poisson.value: must be a number, is 'soft'",
                  "geometry.provenance: must be 'printed', 'derived', "):
        assert where in text
    path.write_text("name = [")
    with pytest.raises(InputError, match="broken.toml"):
        read_model(path)


JUNK = (b"1", np.timedelta64(1), np.datetime64("2020"), 1j, "1", [1.0], True, None, object())


@pytest.mark.parametrize("value", JUNK, ids=lambda value: type(value).__name__)
def test_what_python_takes_for_a_number_and_is_none(value):
    """Bytes, times and flags are refused as numbers and as integers, each in one line."""
    for make in (lambda: Settings(dt=value, end_time=1.0), lambda: Scheme(rho_inf=value),
                 lambda: Newton(min_iterations=value), lambda: Pressure(value),
                 lambda: NodalLoad(value, (0.0, 0.0, 1.0)), lambda: Pressure(1.0, [value])):
        with pytest.raises(InputError) as told:
            make()
        assert len(str(told.value)) < 300 and "\n" not in str(told.value)


@pytest.mark.parametrize("value", [2**63, 10**30, 10**400, -10**400])
def test_integers_have_a_bound(value):
    """Also those that have more digits than Python shows."""
    with pytest.raises(InputError, match="frame_every must be at most 1e.15"):
        Settings(dt=0.1, end_time=1.0, frame_every=value)


@pytest.mark.parametrize("wrong, message", [
    ({"overwrite": "no"}, "overwrite must be True or False, is 'no'"),
    ({"resume": 1}, "resume must be True or False"),
    ({"progress": 5}, "progress must be a function, is 5"),
    ({"case": object()}, "case must be one line of 1 to 200")])
def test_nothing_is_touched_before_the_arguments_are_checked(tmp_path, wrong, message):
    """An earlier result stays as it was."""
    path = tmp_path / "run.h5"
    path.write_bytes(b"earlier")
    model = rectangle(1.0, 1.0, (1, 1))
    with pytest.raises(InputError, match=message):
        simulate(model, Settings(dt=0.1, end_time=0.2), output=path, **{"overwrite": True, **wrong})
    assert path.read_bytes() == b"earlier"


@pytest.mark.parametrize("items, executor, message", [
    (None, None, "items must be a list, is None"), (3, None, "items must be a list"),
    ({}, None, "items must be a list"), ([], 3, "executor must be a concurrent.futures.Executor"),
    ([(1, 2, 3)], None, r"items\[0\] must be a Run or a pair")])
def test_junk_for_many_runs(items, executor, message):
    with pytest.raises(InputError, match=message):
        run_many(items, executor)


@pytest.mark.parametrize("text, message", [
    ("a = " + 5000 * "[" + 5000 * "]", "nested too deeply"), (None, "not a regular file")])
def test_model_files_that_are_none(tmp_path, text, message):
    path = tmp_path / "shell.toml"
    if text is None:
        path.symlink_to("/dev/zero")
    else:
        path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=message):
        read_model(path)


def two_plates(distance):
    """Two squares of side 1 that far apart."""
    nodes = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
    return np.vstack([nodes, nodes + (distance, 0, 0)]), np.array([(0, 1, 2, 3), (4, 5, 6, 7)])


def test_places_are_told_apart_by_the_size_of_the_elements_there():
    """Two plates 2e9 sizes apart are two; so are a point beside one of them and its node."""
    nodes, quads = two_plates(2e9)
    assert len(model(nodes, quads).normals) == 8
    joined = join([Mesh(nodes[:4], quads[:1]), Mesh(nodes[4:], quads[:1])])
    assert np.array_equal(joined.nodes, nodes)
    assert node_at(nodes, (2e9 + 1.0, 1.0, 0.0)) == 6
    with pytest.raises(InputError, match="no node at"):
        node_at(nodes, (0.5, 0.0, 0.0))


@pytest.mark.parametrize("angle", [0.0, 90.0])
def test_nodes_that_hang_on_an_edge(angle):
    """One element beside two: their common node is none of its nodes, flat or at a fold."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    nodes = np.array([(-1, 0, 0), (0, 0, 0), (0, 2, 0), (-1, 2, 0), (0, 1, 0),
                      (c, 0, s), (c, 1, s), (c, 2, s)])
    with pytest.raises(InputError, match="node 4 lies on the edge of element 0 between its nodes"):
        model(nodes, [(0, 1, 2, 3), (1, 5, 6, 4), (4, 6, 7, 2)])


def test_lines_that_leave_the_edges():
    """A line that passes over a node, and, where the elements are given, a diagonal."""
    for make in (line_load, line_moment):
        with pytest.raises(InputError, match="node 1 is between nodes 0 and 2"):
            make(NODES, (0, 2), (0, 0, 1))
        with pytest.raises(InputError, match="no element edge joins nodes 0 and 4"):
            make(NODES, (0, 4), (0, 0, 1), quads=QUADS)
        assert len(make(NODES, (0, 1, 2), (0, 0, 1), quads=QUADS)) == 3


def test_all_inverted_elements_are_named_and_turned():
    plate = rectangle(5.0, 4.0, (5, 4))
    quads = plate.quads.copy()
    quads[[3, 7, 8, 19]] = quads[[3, 7, 8, 19], ::-1]
    with pytest.raises(InputError, match="inverted .* elements 3, 7, 8, 19; elements .* both run"):
        model(plate.nodes, quads)
    assert model(plate.nodes, orient(plate.nodes, quads)).normals[:, 2].min() == 1.0
    many = np.where(np.arange(20)[:, None] % 2, plate.quads[:, ::-1], plate.quads)
    with pytest.raises(InputError, match=r"\.\.\. \(10 in all\); elements"):
        model(plate.nodes, many)


def test_a_twisted_element_is_no_moebius_strip():
    """`orient` says what `Model` says."""
    plate = rectangle(5.0, 4.0, (5, 4))
    quads = plate.quads.copy()
    quads[5] = quads[5, [0, 2, 1, 3]]
    for call in (orient, model):
        with pytest.raises(InputError, match="element 5: degenerate or twisted, the diagonals of "
                                             "its nodes .* are parallel"):
            call(plate.nodes, quads)


def test_corners_of_a_block_go_round_it():
    with pytest.raises(InputError, match="corners must go round a convex block, their sides cross"):
        block([(0, 0, 0), (1, 1, 0), (1, 0, 0), (0, 1, 0)], (2, 2))


def test_orientation_goes_beyond_folds_and_ends_at_a_moebius_strip():
    """The sides of a box all look outwards or all inwards; a strip with a half turn has one."""
    corners = np.array([(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    box = np.array([(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4),
                    (1, 3, 7, 5)])
    turned = orient(corners, box)
    middle = corners[turned].mean(axis=1) - 0.5
    outward = np.sign(np.einsum("ei,ei->e", vector_areas(corners[turned]), middle))
    assert abs(outward.sum()) == 6.0 and np.array_equal(turned[0], box[0])
    n = 24
    along = np.linspace(0.0, 2.0 * np.pi, n, endpoint=False)[:, None]
    across = np.array([-0.2, 0.2])
    radius = 1.0 + across * np.cos(0.5 * along)
    strip = np.stack([radius * np.cos(along), radius * np.sin(along),
                      across * np.sin(0.5 * along)], axis=2).reshape(-1, 3)
    k = 2 * np.arange(n)
    quads = np.stack([k, k + 1, np.roll(k, -1) + 1, np.roll(k, -1)], axis=1)
    quads[-1, 2:] = quads[-1, 3], quads[-1, 2]
    for call in (orient, model):
        with pytest.raises(InputError, match="one side only, as a Moebius strip: .* elements 0"):
            call(strip, quads)


def test_edges_are_told_as_they_were_decided():
    assert corner(136.0).folds == pytest.approx((0, 1, None, 44.0))
    assert corner(134.0).folds == pytest.approx((1, 0, 46.0, None))
    assert model().folds == (0, 1, None, 0.0)


def test_a_row_is_no_history():
    history = simulate(model(), Settings(dt=0.1, end_time=0.2)).history
    for call in (total_energy, lambda rows: drift(rows, 0.0)):
        for part in (history[0], history[None], history[["time", "strain_energy"]]):
            with pytest.raises(InputError, match="history must be that of a result"):
                call(part)


def test_a_model_shows_itself_in_one_short_line():
    plate = rectangle(2.0, 1.0, (20, 10), loads=[NodalLoad(0, (0, 0, 1))])
    assert repr(plate) == "Model(200 elements, 231 nodes, 1 load, 0 supports, 2 x 1 x 0 m)"


@pytest.mark.parametrize("kind, options, message", [
    (Settings, {"rho_inf": 0.9}, r"Settings has no rho_inf: it belongs to scheme, as Settings\("
                                 r"scheme=Scheme\(rho_inf=\.\.\.\)\)"),
    (Settings, {"max_iterations": 9}, r"as Settings\(newton=Newton\(max_iterations=\.\.\.\)\)"),
    (StaticSettings, {"dt": 0.1}, "StaticSettings has no 'dt', must be one of: solver, tolerance"),
])
def test_settings_of_another_place(kind, options, message):
    with pytest.raises(InputError, match=message):
        kind(**options)


@pytest.mark.parametrize("divisions, message", [
    ((8, 4), r"no smooth sphere, .*: take at least \(9, 2\)"), ((16, 1), r"at least \(9, 2\)"),
    ((10**6, 10**6), "a mesh of 1e.12 elements is too large"), ((0, 4), r"divisions\[0\] must be")])
def test_divisions_of_a_sphere(divisions, message):
    with pytest.raises(InputError, match=message):
        sphere_segment(1.0, (20.0, 90.0), divisions)
    assert Model.of(sphere_segment(1.0, (20.0, 90.0), (9, 2)), **MATERIAL).folds.folded == 0


def test_meshes_have_a_bound():
    """It is told at once, before anything of that size is made."""
    with pytest.raises(InputError, match="a mesh of 1e.18 elements is too large"):
        block([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], (10**9, 10**9))


PLATE_FILE = (FOLDER / "l-plate.toml").read_text()


@pytest.mark.parametrize("old, new, message", [
    ("refinement = 2", "refinement = 1", r"meshes\[1\]: refinement 1 has 30 elements, not 120"),
    ("divisions = [8, 2]", "divisions = [1000000000, 1000000000]", "m.toml: .*elements"),
    ("[10.0, 5.0, 0.0]", "[1e308, 5.0, 0.0]", r"geometry.blocks\[2\].corners\[1\]\[0\]: must be"),
    ('unit = "m", provenance = "assumed", source = "Fig. 4', 'unit = "km", provenance = '
     '"assumed", source = "Fig. 4', r"points.S: in 'km', must be in 'm'"),
    ('name = "l-plate"', 'name = "a\\nb"', "name: must be one line of 1 to 200 printable"),
    ('name = "l-plate"', '"" = 1\nname = "l-plate"', 'm.toml: "": '),
    ("[[meshes]]\nelements = 120", "[[meshes]]\nelements = 30\nrefinement = 1\n[[meshes]]\n"
     "elements = 120",
     r"meshes\[1\].elements: 30 is that of meshes\[0\] as well"),
])
def test_wrong_values_of_a_model_file(tmp_path, old, new, message):
    """Each with the file and its place, and none ends in a warning or takes long."""
    assert old in PLATE_FILE
    path = tmp_path / "m.toml"
    path.write_text(PLATE_FILE.replace(old, new, 1))
    with pytest.raises(InputError, match=message) as told:
        read_model(path)
    assert str(told.value).startswith(f"{path}: ") and "Value error" not in str(told.value)


FLAP = """
name = "flap"
[parameters]
thickness = 0.02
youngs = 1e8
poisson = 0.3
density = 1000.0
[[geometry.blocks]]
corners = [[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]]
divisions = [8, 4]
[[meshes]]
elements = 32
refinement = 1
[defaults]
elements = 32
dt = 2e-3
end_time = 1.0
[histories.pulse]
times = [0.0, 0.1, 0.2]
values = [0.0, 1.0, 0.0]
[[loads]]
name = "hit"
at = [0, 0, 0]
force = [0, 0, 200]
history = "pulse"
"""


@pytest.mark.parametrize("old, new, message", [
    ("[2, 0, 0], [2, 1, 0]", "[2, 1, 0], [2, 0, 0]",
     "geometry.blocks[0].corners: must go round a convex block, their sides cross"),
    ("youngs", "yongs", "parameters.yongs: is unknown, did you mean 'youngs'?"),
    ("thickness = 0.02", 'thickness = "0.02"', "parameters.thickness: must be a number, is '0.02'"),
    ("1000.0", "-1", "parameters.density: must be positive, at least 1e-30, is -1"),
    ("0.3", "0.5", "parameters.poisson: must lie in (-1, 0.5), is 0.5"),
    ("name", "supports = [1]\nname", "supports[0]: must be a table, is 1"),
    ("name", "patches = [1]\nname", "patches: is unknown here, it is given in Python"),
    ("name", "line = 1\nname", "line: is unknown here"),
    ("[[loads]]", "[loads]", "loads: must be a list of tables, write [[loads]]"),
    ("[[geometry.blocks]]", "[geometry.blocks]", "write [[geometry.blocks]]"),
    ("[8, 4]", "[8, 4, 2]", "geometry.blocks[0].divisions: must be a list of at most 2, is ["),
    ("[0.0, 0.1, 0.2]", "0.0", "histories.pulse.times: must be a list, is 0.0"),
    ('"pulse"', "3", "loads[0].history: must be one line of 1 to 200 printable characters, is 3"),
])
def test_errors_of_a_model_file_show_the_value_and_what_helps(tmp_path, old, new, message):
    path = tmp_path / "flap.toml"
    assert old in FLAP
    path.write_text(FLAP)
    assert read_model(path).title == ""
    path.write_text(FLAP.replace(old, new, 1))
    with pytest.raises(InputError, match=re.escape(message)) as told:
        read_model(path)
    assert "\n" not in str(told.value)


def test_a_model_file_of_another_encoding(tmp_path):
    path = tmp_path / "m.toml"
    path.write_bytes(PLATE_FILE.encode("utf-16"))
    with pytest.raises(InputError, match="m.toml: .*utf-8"):
        read_model(path)


def test_loads_of_one_name_are_refused(tmp_path):
    path = tmp_path / "m.toml"
    names = re.findall(r'^name = "(.*)"$', PLATE_FILE, re.MULTILINE)
    path.write_text(PLATE_FILE.replace(f'name = "{names[2]}"', f'name = "{names[1]}"'))
    with pytest.raises(InputError, match=rf"loads\[1\].name: {names[1]} is that of loads\[0\]"):
        read_model(path)


def test_signatures_are_readable():
    """`help` shows types, no checks of them."""
    import inspect

    import corovec
    for name in corovec.__all__:
        if inspect.isfunction(function := getattr(corovec, name)):
            assert not re.search("Annotated|<function| at 0x", str(inspect.signature(function)))
