"""Records of what results said, and what is told of the next ones: no timing is a failure."""

import copy
import json

import pytest
from click.testing import CliRunner

from corovec import InputError, ResultFileError, convergence
from corovec.convergence.cli import converge
from corovec.convergence.study import Size
from corovec.reports import changes, tables
from corovec.reports.cli import record as command
from corovec.reports.records import below, keep, load, records_of
from corovec.timing.measure import Effort, Sample
from corovec.timing.report import run

OLD, NEW = "a" * 40, "b" * 40
ENERGY, DRIFT, ORDER = "30 elements: energy after unloading [J]", "momentum drift", "order"
MACHINE = {"processor": "one", "system": "of many"}
ORIGIN = {"date": "2026-01-01T03:00:00", "commit": OLD, "machine": MACHINE,
          "versions": {"numpy": "2.0"}}
LATER = {**ORIGIN, "date": "2026-01-02T03:00:00", "commit": NEW}


def study(origin=ORIGIN, energy=72.337, drift=1e-14, order=2.0, verdict="match"):
    """What ``corovec converge`` writes, as far as records read it."""
    rows = [{"name": ENERGY, "value": energy, "verdict": "deviates (explained)"},
            {"name": DRIFT, "value": drift, "verdict": "match"},
            {"name": ORDER, "value": order, "verdict": verdict}]
    return {"origin": {**origin, "size": "full"}, "mesh": [{"elements": 30, "energy": energy}],
            "verdicts": rows, "runs": [{"case": "l-plate", "membrane": "stress"}]}


def timing(origin=ORIGIN, rounds=(2.0, 2.1, 2.2), reference=0.5):
    """What ``corovec time targets`` writes, as far as records read it."""
    row = {"name": "a step", "unit": "ms", "value": sorted(rounds)[1],
           **{name.removeprefix("x_"): entry
              for name, entry in Sample(rounds, rounds).row("x").items()}}
    return {**origin, "size": "quick", "tables": {"targets": [row]},
            "references": {"targets": Sample((reference,), (reference,)).row("LU")}}


def told(folder, *results):
    """The command's outcome after the results were written."""
    for contents in results:
        path = folder / ("study.json" if "origin" in contents else "timing.json")
        path.write_text(json.dumps(contents), encoding="utf-8")
    return CliRunner().invoke(command, [str(folder), "--list"], catch_exceptions=False)


def test_a_record_is_kept_for_every_commit(tmp_path):
    first = told(tmp_path, study(), timing())
    assert first.exit_code == 0 and first.stdout == "no earlier record\n"
    second = told(tmp_path, study(LATER), timing(LATER))
    assert second.exit_code == 0 and second.stdout == (
        "aaaaaaaaaa -> bbbbbbbbbb, 4 compared: nothing moved beyond rounding\n")
    records, damaged = load(tmp_path)
    assert [each.commit for each in records] == [OLD, NEW] and not damaged
    entry = records[0].entries["converge l-plate --size full"]
    assert entry.numbers == {ENERGY: 72.337, DRIFT: 1e-14, ORDER: 2.0}
    assert entry.verdicts[ORDER] == "match" and entry.machine == MACHINE
    timed = records[0].entries["time targets --size quick"].timings["a step"]
    assert timed.model_dump() == pytest.approx(
        {"least": 4.0, "q1": 4.1, "median": 4.2, "q3": 4.3, "rounds": 3})
    assert len((tmp_path / "records" / f"{OLD}.json").read_bytes()) < 1500


@pytest.mark.parametrize("moved, shown", [
    ({"energy": 72.337 * (1.0 + 1e-8)},
     f"{ENERGY}: 72.337 (aaaaaaaaaa) -> 72.337001 (bbbbbbbbbb)"),
    ({"drift": 2e-11}, f"{DRIFT}: 1e-14 (aaaaaaaaaa) -> 2e-11 (bbbbbbbbbb)"),
    ({"order": 1.9}, f"{ORDER}: 2 (aaaaaaaaaa) -> 1.9 (bbbbbbbbbb)"),
    ({"energy": 72.337 * (1.0 + 1e-10)}, None), ({"drift": 9e-12}, None), ({"order": 2.001}, None)])
def test_what_moves_beyond_rounding_is_told_with_both_numbers_and_commits(tmp_path, moved, shown):
    told(tmp_path, study())
    line, *every = told(tmp_path, study(LATER, **moved)).stdout.splitlines()
    if shown is None:
        assert line.endswith(": nothing moved beyond rounding") and not every
    else:
        shown = f"converge l-plate --size full: {shown}"
        assert line.endswith(f": 1 number moved; first {shown}")
        assert every == [f"number: {shown}"]


@pytest.mark.parametrize("before, now, status", [
    ("match", "deviates (open)", 1), ("within tolerance", "deviates (explained)", 1),
    ("deviates (explained)", "deviates (open)", 1), ("better", "failed", 1),
    ("deviates (open)", "match", 0), ("match", "within tolerance", 0)])
def test_the_exit_status_says_whether_a_verdict_fell(tmp_path, before, now, status):
    told(tmp_path, study(verdict=before))
    done = told(tmp_path, study(LATER, verdict=now))
    assert done.exit_code == status and f"2, {before} (aaaaaaaaaa) -> 2, {now}" in done.stdout
    assert ("1 verdict fell" in done.stdout) == bool(status)


def test_every_deviation_of_the_page_is_one_to_fall_to():
    assert changes.FALLEN == ("failed", "deviates (open)", "deviates (explained)")
    assert set(changes.FALLEN) < set(tables.VERDICTS)


def test_a_failed_run_and_rows_that_come_and_go(tmp_path):
    told(tmp_path, study())
    failed = study(LATER, energy=None)
    failed["verdicts"][1]["name"] = "momentum drift, other time step"
    line, *every = told(tmp_path, failed).stdout.splitlines()
    assert "1 number moved, 1 row is new, 1 row is gone" in line
    assert f"{ENERGY}: 72.34 (aaaaaaaaaa) -> none (bbbbbbbbbb)" in every[0] and len(every) == 3


@pytest.mark.parametrize("rounds, moved", [
    ((3.0, 3.1, 3.2), True), ((1.0, 1.1, 1.2), True),
    ((1.0, 2.3, 3.0), False), ((2.16, 2.16, 2.16), False)])
def test_timings_are_told_with_their_spread_and_never_fail(tmp_path, rounds, moved):
    """Told only if quartiles lie apart and medians by a tenth."""
    told(tmp_path, timing())
    done = told(tmp_path, timing(LATER, rounds=rounds))
    assert done.exit_code == 0 and ("1 timing moved" in done.stdout) == moved
    assert ("a step: 4.2 (4.1 to 4.3, 3 rounds) (aaaaaaaaaa) -> " in done.stdout) == moved


def test_timings_are_ratios_to_the_reference_of_their_run(tmp_path):
    """A machine that is three times as slow in all that it does tells nothing."""
    told(tmp_path, timing())
    slow = timing(LATER, rounds=(6.0, 6.3, 6.6), reference=1.5)
    assert "nothing moved" in told(tmp_path, slow).stdout


def test_other_machines_compare_numbers_but_no_timings(tmp_path):
    told(tmp_path, study(), timing())
    other = {**LATER, "machine": {**MACHINE, "processor": "other"}, "versions": {"numpy": "2.1"}}
    done = told(tmp_path, study(other, energy=72.4), timing(other, rounds=(9.0, 9.0, 9.0)))
    assert "1 number moved" in done.stdout and "timing moved" not in done.stdout
    assert "timings of another machine are not compared" in done.stdout
    assert done.stdout.splitlines()[0].count("numpy 2.0 -> 2.1") == 1


@pytest.mark.parametrize("damage", ["", '{"commit": "c"', "[]", '{"format": "other"}'])
def test_a_damaged_record_is_told_and_skipped(tmp_path, damage):
    told(tmp_path, study())
    (tmp_path / "records" / "c.json").write_text(damage, encoding="utf-8")
    (tmp_path / "records" / "d.json").write_text(
        load(tmp_path)[0][0].model_dump_json().replace("72.337", '"72"'), encoding="utf-8")
    done = told(tmp_path, study(LATER, energy=72.4))
    assert done.exit_code == 0 and "1 number moved" in done.stdout
    for name in ("c.json", "d.json"):
        assert f"record {name} is damaged and skipped" in done.stdout
    (tmp_path / "records" / f"{NEW}.json").write_text(damage, encoding="utf-8")
    told(tmp_path, study(LATER, energy=72.4))
    assert [each.commit for each in load(tmp_path)[0]] == [OLD, NEW]


def test_an_interrupted_night_goes_on(tmp_path):
    """What a commit's record has stays when the rest comes; a commit is not its own past."""
    told(tmp_path, study())
    told(tmp_path, study(LATER, verdict="deviates (open)"))
    other = study(LATER)
    other["runs"][0]["case"] = "ruler"
    assert told(tmp_path, other).stdout == "no earlier record\n"
    (record,) = (each for each in load(tmp_path)[0] if each.commit == NEW)
    assert set(record.entries) == {f"converge {case} --size full" for case in ("l-plate", "ruler")}
    again = told(tmp_path, study({**LATER, "date": "2026-01-03"}, verdict="deviates (open)"))
    assert again.exit_code == 1 and "aaaaaaaaaa -> bbbbbbbbbb" in again.stdout


def test_the_newest_record_before_is_the_one_compared_with(tmp_path):
    for day, commit in enumerate(("c", "e", "d"), start=1):
        told(tmp_path, study({**ORIGIN, "date": f"2026-01-0{day}", "commit": commit}))
    assert told(tmp_path, study({**LATER, "date": "2026-01-04"})).stdout.startswith("d -> bbbb")
    assert told(tmp_path, study({**LATER, "date": "2026-01-02"})).stdout.startswith("e -> bbbb")


def test_other_membrane_fields_have_records_of_their_own(tmp_path):
    other = study()
    other["runs"][0]["membrane"] = "strain"
    (record,) = records_of([(tmp_path, other)])
    assert set(record.entries) == {"converge l-plate --size full --membrane strain"}


@pytest.mark.parametrize("name, damage", [
    ("study.json", "no"), ("study.json", "[]"), ("study.json", '{"origin": {}}'),
    ("timing.json", '{"commit": 1}'), ("timing.json", '{"commit": ["x"], "references": {}}')])
def test_damaged_results_are_told(tmp_path, name, damage):
    (tmp_path / name).write_text(damage, encoding="utf-8")
    with pytest.raises(ResultFileError, match=f"{name} is damaged"):
        records_of(below(tmp_path))


def test_no_results_are_an_error(tmp_path):
    with pytest.raises(InputError, match="holds no study.json or timing.json"):
        command.main([str(tmp_path / "none")], standalone_mode=False)


@pytest.mark.slow
def test_what_the_suites_write_is_recorded(tmp_path, monkeypatch):
    """A study of two meshes and the growth of the smallest model, as they are."""
    monkeypatch.setitem(convergence.study.SIZES, "quick",
                        Size(2, 120, 200, 200, 3e4, 3e4, 2, 2.0))
    effort = Effort(3, 2, 0.0, 0.0, 10.0, 0.0, 200, False)
    CliRunner().invoke(converge, ["l-plate", "--jobs", "1", "--output", str(tmp_path)],
                       catch_exceptions=False)
    report = {**copy.deepcopy(LATER), "size": "quick"}
    list(run(["growth"], report, effort, tmp_path))
    records = records_of(below(tmp_path))
    keep(tmp_path, records)
    kept = {name: entry for each in load(tmp_path)[0] for name, entry in each.entries.items()}
    energies = {name: value for name, value in kept["converge l-plate --size quick"].numbers.items()
                if name.endswith("elements: energy after unloading [J]")}
    assert [round(value) for value in energies.values()] == [71, 72]
    assert any("angular momentum drift" in name
               for name in kept["converge l-plate --size quick"].verdicts)
    assert "l-plate 30 skyline: step" in kept["time growth --size quick"].timings
