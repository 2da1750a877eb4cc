"""Wrong input: one clear line that names the thing and its place, and nothing happens."""

import numpy as np
import pytest

from solver import InputError, Model, NodalLoad, Settings, Support, TimeFunction, simulate
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
    ({"density": np.nan}, r"density\[0\] is nan, must be finite"),
    ({"poisson": 0.5}, r"poisson must lie in \(-1, 0.5\), is 0.5 at element 0"),
    ({"poisson": -1.0}, r"poisson must lie in \(-1, 0.5\)"),
    ({"membrane": "magic"}, r"membrane 'magic' is unknown, must be one of: stress, strain"),
    ({"shear": "none"}, r"shear 'none' is unknown, must be one of: mitc4, compatible"),
    ({"velocity": np.zeros((5, 3))}, r"velocity: shape \(5, 3\) given, \(6, 3\) needed"),
    ({"normal_velocity": np.tile((0.0, 0.0, 1.0), (6, 1))},
     r"normal_velocity of node 0 is not tangential"),
    ({"loads": [NodalLoad(6, (0, 0, 1))]}, r"load 0: node 6 does not exist \(0 to 5\)"),
    ({"loads": [NodalLoad(0, (0, 0, 1)), NodalLoad(2, (0, np.nan, 1))]},
     r"load 1 at node 2: force .* must be three finite numbers"),
    ({"loads": [NodalLoad(0, (0, 0))]}, r"load 0 at node 0: force \(0, 0\) must be three"),
    ({"loads": [NodalLoad(0, "up")]}, r"load 0 at node 0: force up must be three"),
    ({"supports": [Support((7,), ("x",))]}, r"support 0: node 7 does not exist"),
    ({"supports": [Support((0,), ("rx",))]}, r"support 0: component 'rx' is unknown"),
])
def test_bad_properties(options, message):
    with pytest.raises(InputError, match=message):
        model(**options)


def test_velocity_of_a_support_is_refused():
    still = model(supports=[Support((0,), ("x",))], velocity=np.ones((6, 3)))
    with pytest.raises(InputError, match="node 0: initial velocity of a supported component"):
        simulate(still, Settings(dt=0.1, end_time=0.1))


@pytest.mark.parametrize("times, values, message", [
    ((0.0, 1.0), (1.0,), "2 times but 1 values"),
    ((), (), "0 times but 0 values"),
    ((0.0, 0.0), (1.0, 2.0), "must increase"),
    ((0.0, np.nan), (1.0, 2.0), "must be finite"),
])
def test_bad_time_function(times, values, message):
    with pytest.raises(InputError, match=message):
        TimeFunction(times, values)


@pytest.mark.parametrize("options, message", [
    ({"dt": 0.0}, "dt must be positive and finite"), ({"dt": -1.0}, "dt must be positive"),
    ({"dt": np.nan}, "dt must be positive and finite"),
    ({"end_time": np.inf}, "end_time must be positive and finite"),
    ({"dt": 0.3}, "end_time 1 s is not a multiple of dt 0.3 s; the nearest ones are 0.9 and 1.2"),
    ({"dt": 3.0}, "end_time 1 s is not a multiple"),
    ({"scheme": "euler"}, "scheme 'euler' is unknown, must be one of: quasi, newmark"),
    ({"rho_inf": 1.5}, r"rho_inf must lie in \[0, 1\], is 1.5"),
    ({"rho_inf": np.nan}, "rho_inf must lie in"),
    ({"transformation": "end"}, "transformation 'end' is unknown"),
    ({"solver": "magma"}, "solver 'magma' is unknown, must be one of: auto, skyline, dense"),
    ({"tolerance": 0.0}, "tolerance must lie in"),
    ({"min_iterations": 0}, "min_iterations must lie in"),
    ({"frame_every": -1}, "frame_every must not be negative"),
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
