"""The mesh study behind ``corovec converge``."""

import json

import pytest

from convergence.study import mesh_study, planned_runs, printed_energies
from verification.helpers import corovec


def test_printed_energies_are_those_of_table_1():
    energies, table = printed_energies("l-plate")
    assert table == "Table 1"
    assert [text for _, text in energies.values()] == ["71.373", "72.455", "72.908", "73.135",
                                                       "73.268"]


def test_study_of_the_coarse_meshes():
    """Energies rise with refinement, as the printed ones do; every run conserves."""
    frame = mesh_study("l-plate", planned_runs("l-plate", (30, 120), dt=1e-2))
    assert frame["elements"].tolist() == [30, 120]
    assert 70.0 < frame["energy"][0] < frame["energy"][1] < 73.0
    assert frame["energy_drift"].max() < 1e-5
    assert frame["linear_momentum_drift"].max() < 1e-11
    # assumed geometry and load: no agreement is asserted, only that the difference is computed
    ours, printed = frame["energy"][0], 71.373
    assert frame["difference_percent"][0] == pytest.approx(100.0 * (ours / printed - 1.0))


def test_command_prints_the_table():
    arguments = ("converge", "l-plate", "--elements", "30", "--dt", "0.01")
    done = corovec(*arguments)
    assert done.returncode == 0
    assert "71.373" in done.stdout and "Agreement is not proof" in done.stdout
    row = json.loads(corovec(*arguments, "--json").stdout)["rows"][0]
    assert row["printed"] == "71.373" and row["elements"] == 30
