"""Energies by item: the table of a run closes, and each of its entries is right by itself."""

import json
from functools import cache

import numpy as np
import pytest

from corovec import (
    Damping,
    EnergyProbe,
    Expression,
    Gravity,
    GroundSpring,
    Hinge,
    InputError,
    JointProbe,
    Model,
    ResultFileError,
    Revolute,
    RigidBody,
    Scheme,
    Settings,
    Spring,
    Steps,
    TimeFunction,
    block,
    cut,
    energy_table,
    load_control,
    read,
    simulate,
)
from corovec.solver.dynamics.energies import COLUMNS, MOST_SPRINGS
from corovec.solver.results.description import parsed
from corovec.solver.results.layout import Sizes
from corovec.solver.runtime.provenance import describe

EXACT = Scheme("exact")
RUN = Settings(dt=0.01, end_time=0.2, scheme=EXACT)
PROBES = {"shell": EnergyProbe(), "fold": JointProbe("fold"), "drive": JointProbe("drive"),
          "hub": 12, "motor": JointProbe("motor")}


@cache
def craft(**options):
    """A hub that carries a plate with a hinge, on it an arm that is driven, on that a wheel with a
    motor."""
    mesh = block([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], (4, 1))
    mesh, nodes, others = cut(mesh, (1, 0, 0), (1, 1, 0))
    bodies = [RigidBody("hub", 3.0, (0.5, 0.6, 0.7), (-0.3, 0.5, 0.0), mesh.nodes_at(x=0.0)),
              RigidBody("arm", 1.0, (0.1, 0.2, 0.2), (-0.9, 0.5, 0.1)),
              RigidBody("wheel", 0.5, (0.05, 0.05, 0.08), (-1.4, 0.5, 0.2))]
    joints = [Hinge(nodes, others, stiffness=2.0, rest=0.4, damping=0.3, name="fold"),
              Revolute("hub", "arm", (-0.5, 0.5, 0.0), (0, 1, 0), 0.7, Expression("t**2 * (1 - t)"),
                       name="drive"),
              Revolute("arm", "wheel", (-1.4, 0.5, 0.2), (0, 1, 0), torque=0.6, stiffness=0.2,
                       name="motor")]
    return Model.of(mesh, 0.02, 1e8, 0.3, 300.0, joints=joints, bodies=bodies, **options)


@cache
def flown():
    return simulate(craft(), RUN, probes=PROBES)


def entry(table, item, what):
    return table.loc[table["item"] == item, what].to_numpy()


def test_the_sum_of_all_items_is_the_balance():
    """Nothing is left over at any instant, and no loads take part, nor has the shell lost any."""
    result = flown()
    table, history = energy_table(result), result.history
    sums = table.groupby("time")[list(COLUMNS)].sum()
    for name, what in (("kinetic_energy", "kinetic"), ("strain_energy", "stored"),
                       ("dissipated", "dissipated"), ("external_work", "work")):
        np.testing.assert_allclose(sums[what], history[name], rtol=1e-12, atol=1e-14)
    total = sums["kinetic"] + sums["stored"] + sums["dissipated"] - sums["work"]
    scale = sums["kinetic"].max() + sums["stored"].max()
    np.testing.assert_allclose(total - total.iloc[0], 0.0, atol=1e-12 * scale)  # 1e-13 measured
    assert result.energy_balance < 1e-12
    for item, what in (("loads", "work"), ("shell", "dissipated")):
        np.testing.assert_allclose(entry(table, item, what), 0.0, atol=1e-15 * scale)
    assert not {"supports"} & set(table["item"])


def test_entries_are_those_of_the_items_by_themselves():
    """Strain energy of the elements; of joints what their probes tell; of the hub m v^2/2 as long
    as it does not turn, and no less later; of the drive the integral of its moment."""
    result = flown()
    table, history = energy_table(result), result.history
    np.testing.assert_allclose(entry(table, "shell", "stored"), history["shell_strain_energy"],
                               rtol=1e-9, atol=1e-13)
    for joint in ("fold", "drive", "motor"):
        for own, what in (("stored", "stored"), ("lost", "dissipated"), ("work", "work")):
            np.testing.assert_array_equal(entry(table, joint, what), history[f"{joint}_{own}"])
    for what, joint in (("stored", "fold"), ("dissipated", "fold"), ("work", "motor"),
                        ("work", "drive"), ("stored", "motor")):
        assert entry(table, joint, what)[-1] > 1e-5
    moved = 1.5 * np.sum(history["hub_v"]**2, axis=1)
    assert np.all(entry(table, "hub", "kinetic") >= moved)
    assert entry(table, "hub", "kinetic")[-1] > 1.01 * moved[-1]
    power = np.cumsum(history["drive_moment"][1:] * np.diff(history["drive_angle"]))
    np.testing.assert_allclose(entry(table, "drive", "work")[1:], power, rtol=1e-3, atol=1e-6)


def test_a_body_that_turns_has_the_energy_of_its_spin():
    """About a principal axis: I w^2/2 of each body, of the plate the rest."""
    body = RigidBody("top", 2.0, (0.3, 0.4, 0.5), (5.0, 0.0, 0.0))
    mesh = block([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], (1, 1))
    model = Model.of(mesh, 0.02, 1e8, 0.3, 300.0, bodies=[body],
                     joints=[Revolute("ground", "top", (5.0, 0, 0), (0, 0, 1), torque=1.0,
                                      name="spindle")])
    table = energy_table(simulate(model, Settings(dt=0.01, end_time=0.1, scheme=EXACT)))
    time = np.linspace(0.0, 0.1, 11)
    np.testing.assert_allclose(entry(table, "top", "kinetic"), 0.5 * 0.5 * (time / 0.5)**2,
                               rtol=4e-7)  # (w dt)^2/12 of a step
    np.testing.assert_allclose(entry(table, "shell", "kinetic"), 0.0, atol=1e-17)


def test_springs_loads_and_damping():
    """A plate on springs that falls, by the paper's scheme; what is stored in each spring."""
    mesh = block([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], (2, 1))
    attached = [Spring(0, 5, 30.0, length=2.0), Spring(1, 3, 20.0),
                GroundSpring(2, (0.0, 0.0, 50.0), turning=2.0), GroundSpring(0, (9.0, 9.0, 9.0))]
    model = Model.of(mesh, 0.02, 1e8, 0.3, 300.0, loads=[Gravity((0, 0, -9.81))],
                     attached=attached, damping=Damping(0.1, 1e-3))
    result = simulate(model, Settings(dt=0.005, end_time=0.1),
                      probes={f"n{k}": k for k in (0, 1, 3, 5)} | {"all": EnergyProbe()})
    history, table = result.history, energy_table(result)
    assert list(table["item"][:5]) == ["shell", "spring 0", "spring 1", "springs to the ground",
                                       "loads"]
    np.testing.assert_allclose(entry(table, "shell", "stored"), history["all_strain_energy"],
                               rtol=1e-9, atol=1e-12)
    for k, (one, other, stiffness, slack) in enumerate(((0, 5, 30.0, 2.0), (1, 3, 20.0, None))):
        ends = [model.nodes[i] + history[f"n{i}_u"] for i in (one, other)]
        length = np.linalg.norm(ends[1] - ends[0], axis=1)
        longer = length - (length[0] if slack is None else slack)
        np.testing.assert_allclose(entry(table, f"spring {k}", "stored"),
                                   0.5 * stiffness * longer**2, rtol=1e-9, atol=1e-14)
    assert entry(table, "springs to the ground", "stored")[-1] > 0.0
    assert entry(table, "shell", "dissipated")[-1] == history["dissipated"][-1] > 0.0
    np.testing.assert_array_equal(entry(table, "loads", "work"), history["external_work"])
    many = Model.of(mesh, 0.02, 1e8, 0.3, 300.0, attached=[Spring(0, 5, 1.0, 2.0)] * (
        MOST_SPRINGS + 1))
    table = energy_table(simulate(many, Settings(dt=0.01, end_time=0.02)), row=0)
    assert list(table["item"]) == ["shell", "springs", "loads"]
    assert entry(table, "springs", "stored")[0] == pytest.approx(
        0.5 * 51 * (np.sqrt(5.0) - 2.0)**2)


def test_of_files_that_are_resumed(tmp_path):
    """The table of a file is that of the result, also of one that was continued."""
    path = tmp_path / "run.h5"
    result = simulate(craft(), RUN, output=path)
    table = energy_table(result)
    assert table.equals(energy_table(read(path)))
    last = table.iloc[-len(table) // 21:].reset_index(drop=True)
    assert energy_table(read(path), -1).equals(last)
    assert read(path)["description"]["energies"] == {
        "joints": ["fold", "drive", "motor"], "bodies": ["hub", "arm", "wheel"]}
    half = tmp_path / "half.h5"

    def stop(step, *_):
        if step == 13:
            raise KeyboardInterrupt

    settings = Settings(dt=0.01, end_time=0.2, scheme=EXACT, frame_every=2)
    with pytest.raises(KeyboardInterrupt):
        simulate(craft(), settings, output=half, progress=stop)
    again = simulate(craft(), settings, output=half, resume=True)
    whole = simulate(craft(), settings)
    assert np.array_equal(again.history, whole.history)


def test_steps_that_are_halved_and_adaptive_book_the_same():
    """Works and losses are the sums of all parts of a step."""
    settings = Settings(dt=0.1, end_time=0.2, scheme=EXACT, error=1e-7)
    result = simulate(craft(), settings)
    assert result.history["parts"].max() > 1
    sums = energy_table(result).groupby("time")[list(COLUMNS)].sum()
    left = (sums - sums.iloc[0]) @ [1.0, 1.0, 1.0, -1.0]
    scale = sums["kinetic"].max() + sums["stored"].max()  # as of the sum of all items
    assert np.abs(left).max() < 1e-12 * scale
    assert abs(entry(energy_table(result, -1), "loads", "work")[0]) < 1e-15


def test_plain_models_keep_their_rows_and_files():
    mesh = block([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], (2, 1))
    model = Model.of(mesh, 0.02, 1e8, 0.3, 300.0, loads=[Gravity((0, 0, -1.0), Steps(
        (0.0, 0.02), (1.0, 0.0)))])
    result = simulate(model, Settings(dt=0.01, end_time=0.04))
    assert not [name for name in result.history.dtype.names if "." in name]
    assert list(energy_table(result, -1)["item"]) == ["shell", "loads"]


def test_what_has_no_table():
    with pytest.raises(InputError, match="run must be a Result, or what read returns"):
        energy_table(3)
    with pytest.raises(InputError, match="run must be a Result"):
        energy_table({"history": np.zeros(3)})
    with pytest.raises(InputError, match=r"row must lie in \[-21, 20\], is 21"):
        energy_table(flown(), 21)
    mesh = block([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], (2, 1))
    held = Model.of(mesh, 0.02, 1e8, 0.3, 300.0, attached=[
        GroundSpring(k, (9.0, 9.0, 9.0)) for k in range(6)], loads=[Gravity((0, 0, -1.0))])
    with pytest.raises(InputError, match="run must be a Result"):
        energy_table(load_control(held, [1.0]))


@pytest.mark.parametrize(("change", "message"), [
    (lambda told: told["joints"][0].update(nodes=[99]), "a joint or a body where there is no node"),
    (lambda told: told["joints"][0].update(nodes=[-1]), "a joint or a body where there is no node"),
    (lambda told: told["joints"][1]["points"][0].update(first=99), "where there is no node"),
    (lambda told: told["bodies"][0].update(first=-3), "where there is no node"),
    (lambda told: told["bodies"][0].update(axes=[[1.0, 0.0, 0.0]]), "description.bodies.0.axes"),
    (lambda told: told["energies"]["bodies"].pop(), "description.energies is")])
def test_descriptions_of_joints_that_are_not_there(change, message):
    """A file that is signed, from elsewhere, is refused before anything is drawn of it."""
    told = describe(craft(), RUN, "skyline", None, {}, None,
                    {"joints": ["a", "b", "c"], "bodies": ["a", "b", "c"]})
    sizes = Sizes(False, len(craft().nodes), len(craft().quads), len(craft().normals), 1, 1, 1,
                  False, False, items=(("joints", 3), ("bodies", 3)))
    parsed(json.dumps(told), sizes)
    change(told)
    with pytest.raises(ValueError, match=message):
        parsed(json.dumps(told), sizes)


def test_damaged_energies_are_told(tmp_path):
    import h5py
    path = tmp_path / "run.h5"
    simulate(craft(), RUN, output=path)
    with h5py.File(path, "r+") as file:
        file["energies/joints/work"][5, 1] += 1.0
    with pytest.raises(ResultFileError, match="damaged"):
        read(path)
    with h5py.File(path, "r+") as file:
        del file["energies/bodies/kinetic"]
    with pytest.raises(ResultFileError, match="energies/bodies/kinetic is missing"):
        read(path)


@pytest.mark.parametrize(("options", "end"), [
    ({}, 0.0), ({"angle": 0.5, "driving": TimeFunction((0.0, 2.0), (0.0, 1.0))}, 2.0),
    ({"torque": 1.0, "history": TimeFunction((0.0, 3.0), (1.0, 0.0))}, 3.0),
    ({"torque": 1.0}, np.inf), ({"stiffness": 1.0, "rest": 1.0}, 0.0)])
def test_motors_and_drives_of_bodies_load_a_model(options, end):
    """As those of hinges do: until they end."""
    mesh = block([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], (1, 1))
    model = Model.of(mesh, 0.02, 1e8, 0.3, 300.0, bodies=[
        RigidBody("top", 2.0, (0.3, 0.4, 0.5), (5.0, 0.0, 0.0))], joints=[
        Revolute("ground", "top", (5.0, 0, 0), (0, 0, 1), **options)])
    assert model.unloaded_at == end
