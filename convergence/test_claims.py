"""What the paper says of its figures, on a run of the coarsest L-plate; files that do not fit."""

import json

import pytest
from click.testing import CliRunner

from corovec import InputError, Settings, read, simulate
from corovec.benchmarks import case_names, load_case
from corovec.convergence.claims import claims, open_runs
from corovec.convergence.cli import claim as command
from corovec.convergence.study import printed_results

SETTINGS = Settings(dt=0.02, end_time=1.2, frame_every=5)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    path = tmp_path_factory.mktemp("claims") / "l30.h5"
    simulate(load_case("l-plate").model(30), SETTINGS, output=path, case="l-plate")
    return path


@pytest.mark.parametrize("case", case_names())
def test_without_runs_there_are_the_printed_numbers_of_nodes_alone(case):
    found = claims(case, {})
    counts = (printed_results(case) or {}).get("nodes", {})
    rows = [row for rows in found.values() for row in rows]
    assert [row.name for row in rows] == [f"{elements} elements: nodes" for elements in counts]
    assert {row.verdict for row in rows} <= {"match" if case == "ruler" else "selected"}


def test_rows_of_a_run(run):
    """The drifts of Fig. 3; Fig. 4 compares meshes, and one has no other."""
    found = claims("l-plate", open_runs("l-plate", [run]))
    assert [row.verdict for row in found["Figure 3"]] == [
        "within tolerance", "match", "within tolerance", "bound met"]
    assert len(found["Figure 6"]) == 1 and found["Figure 4"] == []


def test_paths_on_two_meshes(run):
    """A path that is another's, a tenth of a metre beside it."""
    coarse = read(run)
    moved = {**coarse, "displacement": coarse["displacement"] + (0.0, 0.1, 0.0)}
    (row,) = claims("l-plate", {30: moved, 120: coarse})["Figure 4"]
    extent = float(((coarse["nodes"].max(axis=0) - coarse["nodes"].min(axis=0))**2).sum()**0.5)
    assert row.value == pytest.approx(0.1 / extent) and row.verdict == "selected"


def test_command(run, tmp_path):
    path = tmp_path / "claims.json"
    done = CliRunner().invoke(command, ["l-plate", str(run), "--output", str(path)])
    assert done.exit_code == 0 and "energy drift, 30 elements" in done.output
    written = json.loads(path.read_text(encoding="utf-8"))
    assert written["runs"][0]["elements"] == 30 and written["figures"]["Figure 3"]
    shown = CliRunner().invoke(command, ["l-plate", str(run), "--json"]).output
    assert json.loads(shown)["figures"] == written["figures"]


def test_wrong_files(run, tmp_path):
    stopped = tmp_path / "stopped.h5"

    def stop(step, *_):
        if step == 10:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(load_case("l-plate").model(30), SETTINGS, output=stopped, case="l-plate",
                 progress=stop)
    for case, files, said in (("ruler", [run], "is no run of ruler"),
                              ("l-plate", [stopped], "is not finished"),
                              ("l-plate", [run, run], "a second run of 30 elements")):
        with pytest.raises(InputError, match=said):
            open_runs(case, files)
    with pytest.raises(InputError, match="case 'x' is unknown"):
        CliRunner().invoke(command, ["x"], standalone_mode=False, catch_exceptions=False)
