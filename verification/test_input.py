"""Wrong input: one clear line that names the thing and its place, and nothing happens."""

import numpy as np
import pytest

from solver import (
    InputError,
    Model,
    NodalLoad,
    NodalMoment,
    Pressure,
    Settings,
    Support,
    TimeFunction,
    rigid_velocity,
    simulate,
)
from solver.cases import FOLDER, load_case, read_case
from solver.mesh import node_at
from verification.models import MATERIAL

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
    (NODES, [(0, 1, 4, 3), (1, 4, 5, 2)], r"element 1 is inverted against its neighbour 0"),
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
])
def test_bad_mesh(nodes, quads, message):
    with pytest.raises(InputError, match=message) as error:
        model(nodes, np.array(quads))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("options, message", [
    ({"thickness": 0.0}, r"thickness must be positive \[m\], is 0 at element 0"),
    ({"thickness": [0.1, -0.2]}, r"thickness must be positive \[m\], is -0.2 at element 1"),
    ({"thickness": [0.1, 0.1, 0.1]}, r"thickness: shape \(3,\) given, \(2\) needed"),
    ({"youngs": -1e6}, r"youngs must be positive \[Pa\]"),
    ({"density": 0.0}, r"density must be positive \[kg/m\^3\]"),
    ({"density": np.nan}, r"density must be finite and below 1e\+100, is nan"),
    ({"poisson": 0.5}, r"poisson must lie in \(-1, 0.5\), is 0.5 at element 0"),
    ({"poisson": -1.0}, r"poisson must lie in \(-1, 0.5\)"),
    ({"membrane": "magic"}, r"membrane 'magic' is unknown, must be one of: stress, strain"),
    ({"shear": "none"}, r"shear 'none' is unknown, must be one of: mitc4, compatible"),
    ({"velocity": np.zeros((5, 3))}, r"velocity: shape \(5, 3\) given, \(6, 3\) needed"),
    ({"normal_velocity": np.tile((0.0, 0.0, 1.0), (6, 1))},
     r"normal_velocity of node 0 is not tangential"),
    ({"normals": np.zeros((6, 3))}, r"normals\[0\] has length 0, must be 1"),
    ({"normals": np.tile((0.0, 0.0, -1.0), (6, 1))}, r"normals\[0\] is more than 60 degrees"),
    ({"thickness": "0.1"}, r"thickness must be a number, is '0.1'"),
    ({"thickness": True}, r"thickness must be a number, is True"),
    ({"thickness": None}, r"thickness must be a number, is None"),
    ({"youngs": 1e6 + 1j}, r"youngs must be a number"),
    ({"youngs": 1e200}, r"youngs must be finite and below 1e\+100"),
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
    (lambda: NodalLoad(2, (0, np.nan, 1)), r"load at node 2: force\[1\] must be finite"),
    (lambda: NodalLoad(0, (0, 0)), r"load at node 0: force must be three numbers \[N\]"),
    (lambda: NodalLoad(0, "up!"), r"load at node 0: force must be three numbers \[N\]"),
    (lambda: NodalLoad(0, ("0", "0", "1")), r"force\[0\] must be a number \[N\], is '0'"),
    (lambda: NodalLoad(1.0, (0, 0, 1)), r"load: node must be an integer, is 1.0"),
    (lambda: NodalLoad("a", (0, 0, 1)), r"load: node must be an integer, is 'a'"),
    (lambda: NodalLoad(True, (0, 0, 1)), r"load: node must be an integer, is True"),
    (lambda: NodalLoad(0, (0, 0, 1), 5.0), r"history must be a TimeFunction, is 5.0"),
    (lambda: NodalMoment(0, (0, 0)), r"load at node 0: moment must be three numbers \[N m\]"),
    (lambda: Pressure(np.inf), r"pressure must be finite"),
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
    with pytest.raises(InputError, match=message):
        make()


def test_loads_are_plain_data_whatever_they_are_made_of():
    """The same load in other types has the same fingerprint; other supports another one."""
    from solver.provenance import fingerprint
    pulse = TimeFunction(np.array([0, 1]), [1, 0])
    plain = model(loads=[NodalLoad(3, (0.0, 0.0, 1.0), TimeFunction((0.0, 1.0), (1.0, 0.0)))])
    other = model(loads=(NodalLoad(np.int64(3), np.array([0, 0, 1.0]), pulse),))
    assert fingerprint(plain) == fingerprint(other)
    many = np.arange(2000) % 6
    shifted = many.copy()
    shifted[1000] = (shifted[1000] + 1) % 6
    prints = {fingerprint(model(supports=[Support(nodes, ("x",))])) for nodes in (many, shifted)}
    assert len(prints) == 2


def test_a_fold_and_a_junction_are_told():
    """Plates that meet at an angle are not a smooth shell."""
    folded = changed([2, 5], NODES[[1, 4]] + (0.0, 0.0, 1.0))
    with pytest.raises(InputError, match="folds and junctions are not supported"):
        model(folded)
    nodes = np.vstack([NODES, NODES[[1, 4]] + (0.0, 0.0, 1.0)])
    with pytest.raises(InputError, match="between nodes 1 and 4 belongs to 3 elements"):
        model(nodes, np.vstack([QUADS, (1, 4, 7, 6)]))


def test_models_cannot_be_changed_behind_their_back():
    plate = model()
    for name in ("nodes", "quads", "thickness", "normals", "velocity"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(plate, name)[0] = 1


def test_pulse_that_the_steps_miss():
    """A pulse of 0.4 ms between two samples of dt = 1 ms would be lost; the message says so."""
    pulse = TimeFunction((0.0, 2e-4, 4e-4), (0.0, 100.0, 0.0))
    hit = model(loads=[NodalLoad(0, (0, 0, 200.0), pulse)])
    with pytest.raises(InputError, match="load 0: dt 0.001 s is too long for its time function"):
        simulate(hit, Settings(dt=1e-3, end_time=1e-2))
    simulate(hit, Settings(dt=2e-5, end_time=1e-3))


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
    ({"dt": np.nan}, "dt must be finite"),
    ({"end_time": np.inf}, "end_time must be finite"),
    ({"dt": 0.3}, "end_time 1 s is not a multiple of dt 0.3 s; the nearest ones are 0.9 and 1.2"),
    ({"dt": 3.0}, "end_time 1 s is not a multiple"),
    ({"scheme": "euler"}, "scheme 'euler' is unknown, must be one of: quasi, newmark"),
    ({"rho_inf": 1.5}, r"rho_inf must lie in \[0, 1\], is 1.5"),
    ({"rho_inf": np.nan}, "rho_inf must be finite"),
    ({"transformation": "end"}, "transformation 'end' is unknown"),
    ({"solver": "magma"}, "solver 'magma' is unknown, must be one of: auto, skyline, dense"),
    ({"tolerance": 0.0}, "tolerance must lie in"),
    ({"min_iterations": 0}, "min_iterations must lie in"),
    ({"frame_every": -1}, "frame_every must not be negative"),
    ({"frame_every": 2.5}, "frame_every must be an integer, is 2.5"),
    ({"min_iterations": 2.5}, "min_iterations must be an integer"),
    ({"dt": "0.1"}, r"dt must be a number \[s\], is '0.1'"),
    ({"dt": 1e-12}, "at most 1e.08 can be recorded"),
    ({"scheme": "newmark", "rho_inf": 0.5}, "belong to the scheme quasi"),
    ({"max_iterations": 0}, "max_iterations must be at least 1, is 0"),
])
def test_bad_settings(options, message):
    with pytest.raises(InputError, match=message):
        Settings(**{"dt": 0.1, "end_time": 1.0, **options})


def test_unknown_case_and_mesh():
    with pytest.raises(InputError, match="case 'l-shape' is unknown, must be one of: l-plate"):
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
              .replace('provenance = "assumed"', 'provenance = "guessed"', 1))
    path = tmp_path / "broken.toml"
    path.write_text(broken)
    with pytest.raises(InputError) as error:
        read_case(path)
    text = str(error.value)
    for where in ("parameters.thickness: Field required", "parameters.thicknes: Extra inputs",
                  "parameters.poisson.value: Input should be a valid number",
                  "geometry.provenance: Input should be"):
        assert where in text
    path.write_text("name = [")
    with pytest.raises(InputError, match="broken.toml"):
        read_case(path)
