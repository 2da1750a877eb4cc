"""Campaigns: nothing is computed twice, nothing is lost, a failure stops nothing else."""

import math
import operator
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import BrokenExecutor, ThreadPoolExecutor
from dataclasses import replace
from functools import partial

import h5py
import numpy as np
import pytest

from corovec import InputError, ResultFileError, Settings, read, simulate
from corovec.benchmarks import load_case
from corovec.convergence import Campaign, Run, processes, run_many, store
from corovec.solver.dynamics import simulation
from corovec.solver.runtime.execution import Workers, complete
from corovec.verification.helpers import read_killed

HERE = Workers(lambda: ThreadPoolExecutor(1), 2)

PLATE = load_case("l-plate").model(30)
RUNS = [Run(PLATE, Settings(dt=dt, end_time=0.4), "l-plate") for dt in (0.02, 0.01)]
TOO_LONG = Run(PLATE, Settings(dt=1.0, end_time=1.0), "l-plate")


@pytest.fixture
def computed(monkeypatch):
    """Runs that are computed rather than taken from their files."""
    seen = []
    monkeypatch.setattr(store, "simulate", lambda model, settings, **options: (
        seen.append(settings.dt), simulate(model, settings, **options))[1])
    return seen


def execute(folder, runs, workers=HERE, notify=None):
    notices = []
    with Campaign(folder, workers, notify or notices.append) as campaign:
        outcomes = campaign.run(runs)
    return [outcomes[run.key] for run in runs], notices


def same_history(path, run):
    return read(path)["history"].tobytes() == simulate(run.model, run.settings).history.tobytes()


def test_finished_runs_are_not_rerun(tmp_path, computed):
    first, _ = execute(tmp_path, RUNS)
    assert [outcome.status for outcome in first] == ["finished"] * 2
    assert sorted(computed) == [0.01, 0.02]
    more = [*RUNS, Run(PLATE, Settings(dt=0.005, end_time=0.4), "l-plate"), RUNS[0]]
    again, _ = execute(tmp_path, more)
    assert [outcome.status for outcome in again] == ["cached", "cached", "finished", "cached"]
    assert sorted(computed) == [0.005, 0.01, 0.02]
    assert again[0].seconds == first[0].seconds > 0.0
    assert same_history(again[0].path, RUNS[0])
    assert np.array_equal(again[0].history, first[0].history)


@pytest.mark.filterwarnings("ignore::corovec.solver.errors.AccuracyWarning")
def test_a_run_that_is_halved_too_often_is_given_up(tmp_path):
    """Its file keeps what it came to; a run that stays within its limit is the one without."""
    settings = Settings(dt=0.1, end_time=4.0, frame_every=5)
    free = Run(PLATE, settings, "l-plate")
    halvings = int(simulate(PLATE, settings).history["halvings"].sum())
    assert halvings > 4
    for limit, status in ((4, "failed"), (halvings, "finished")):
        run = replace(free, most_halvings=limit)
        assert run.key == free.key
        (outcome,), _ = execute(tmp_path, [run])
        assert outcome.status == status, limit
        if status == "failed":  # tried again, it is given up after one step
            reached = read(outcome.path)["step"]
            (again,), _ = execute(tmp_path, [run])
            assert again.status == status and read(outcome.path)["step"] <= reached + 1
    assert same_history(outcome.path, free)


def test_one_file_a_run_named_by_its_hash(tmp_path):
    outcomes, _ = execute(tmp_path, RUNS)
    assert sorted(os.listdir(tmp_path)) == sorted(f"{run.key}.h5" for run in RUNS)
    assert outcomes[0].description["case"] == "l-plate"
    assert outcomes[0].description["solver"] == "skyline"


def test_interrupted_run_goes_on_bit_for_bit(tmp_path, monkeypatch):
    """It starts at its last checkpoint, computes the rest, and ends as if never stopped."""
    monkeypatch.setattr(simulation, "MOST", 10)  # a checkpoint with every frame
    monkeypatch.setattr(simulation, "LEAST", 10)
    run = Run(PLATE, Settings(dt=0.01, end_time=0.6, frame_every=10))
    path = tmp_path / f"{run.key}.h5"

    def stop(step, *_):
        if step == 37:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(run.model, run.settings, output=path, progress=stop)
    steps = []
    monkeypatch.setattr(store, "simulate", partial(
        simulate, progress=lambda step, *_: steps.append(step)))
    (outcome,), notices = execute(tmp_path, [run])
    assert not notices and outcome.status == "finished"
    assert outcome.begun_at == 30 and steps == list(range(31, 61))
    assert same_history(path, run)


def test_one_failure_is_reported_and_the_rest_goes_on(tmp_path):
    """The failing run comes first; a later campaign tries it again."""
    runs = [TOO_LONG, *RUNS]
    for status in ("finished", "cached"):
        outcomes, notices = execute(tmp_path, runs)
        assert [outcome.status for outcome in outcomes] == ["failed", status, status]
        assert "too long for its time function" in outcomes[0].error
        assert outcomes[0].history is None
        assert len(notices) == 1 and "dt 1 s" in notices[0] and "failed" in notices[0]


def flip_a_bit(path):
    with h5py.File(path, "r+") as file:
        file["history/strain_energy"][7] *= 1.0 + 1e-15


def truncate(path):
    path.write_bytes(path.read_bytes()[:5000])


def replace_by_text(path):
    path.write_text("not a result")


def replace_by_another(path):
    simulate(PLATE, Settings(dt=0.1, end_time=0.4), output=path, overwrite=True)


@pytest.mark.parametrize("damage", [flip_a_bit, truncate, replace_by_text, replace_by_another])
def test_damaged_file_is_set_aside_and_its_run_repeated(tmp_path, computed, damage):
    (outcome, other), _ = execute(tmp_path, RUNS)
    damage(outcome.path)
    damaged = outcome.path.read_bytes()
    computed.clear()
    (again, untouched), notices = execute(tmp_path, RUNS)
    assert (again.status, untouched.status) == ("finished", "cached") and computed == [0.02]
    assert len(notices) == 1 and "set aside" in notices[0] and outcome.path.name in notices[0]
    assert outcome.path.with_suffix(".damaged-0").read_bytes() == damaged
    assert same_history(again.path, RUNS[0])


def test_warning_by_default(tmp_path):
    with pytest.warns(UserWarning, match="dt 1 s.*failed: InputError"):
        with Campaign(tmp_path, HERE) as campaign:
            campaign.run([TOO_LONG])


def test_unwritable_folder(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ResultFileError, match="file/runs cannot be written: Not a directory"):
        Campaign(tmp_path / "file" / "runs", HERE)


def test_frames_are_read_from_the_file(tmp_path):
    run = Run(PLATE, Settings(dt=0.02, end_time=0.2, frame_every=4), "l-plate")
    (outcome,), _ = execute(tmp_path, [run])
    time, moved = outcome.frames
    assert time == pytest.approx([0.0, 0.08, 0.16, 0.2]) and moved.shape == (4, 48, 3)
    assert np.abs(moved[-1]).max() > 0.0 == np.abs(moved[0]).max()


@pytest.mark.parametrize("jobs, message", [(0, "at least 1, is 0"), (-2, "at least 1, is -2"),
                                           (1.5, "must be an integer")])
def test_wrong_number_of_jobs(jobs, message):
    with pytest.raises(InputError, match=f"jobs .*{message}"):
        processes(jobs)


def test_process_that_dies_takes_no_other_task_with_it():
    """Every other task ends, each exactly once; those of the dead process fail."""
    root, wrong, die = partial(math.sqrt, 4.0), partial(math.sqrt, -1.0), partial(os._exit, 3)
    tasks = [partial(time.sleep, 0.1), die, *[partial(math.sqrt, 4.0) for _ in range(6)], wrong,
             root]
    ended = list(complete(processes(2), operator.call, tasks))
    assert sorted(map(id, tasks)) == sorted(id(task) for task, *_ in ended)
    errors = {id(task): error for task, _, error in ended if error}
    assert errors.keys() == {id(die), id(wrong)}
    assert isinstance(errors[id(die)], BrokenExecutor)
    assert isinstance(errors[id(wrong)], ValueError)
    assert [value for task, value, _ in ended if task is root] == [2.0]


def test_one_job_needs_no_process():
    """It is done here, one task after the other; an error is one of the task."""
    ended = complete(processes(1), operator.call, [os.getpid, partial(math.sqrt, -1.0), os.getppid])
    pid, wrong, parent = [error or value for _, value, error in ended]
    assert (pid, parent) == (os.getpid(), os.getppid()) and isinstance(wrong, ValueError)


CAMPAIGN = """
from corovec.convergence import Campaign, Run, processes
from corovec import Settings
from corovec.benchmarks import load_case
if __name__ == "__main__":
    run = Run(load_case("l-plate").model(30), Settings(dt=1e-3, end_time=6.0, frame_every=50))
    with Campaign("runs", processes(2)) as campaign:
        print(run.key, flush=True)
        campaign.run([run])
"""


@pytest.mark.slow
def test_killed_campaign_leaves_no_process_and_resumes(tmp_path):
    """SIGKILL of the campaign alone: its worker ends too, and the next campaign goes on."""
    script = tmp_path / "script.py"
    script.write_text(CAMPAIGN)
    campaign = subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True,
                                cwd=tmp_path,
                                env={**os.environ, "PYTHONPATH": ":".join(sys.path)})
    with campaign:
        path = tmp_path / "runs" / f"{campaign.stdout.readline().strip()}.h5"
        wait_until(lambda: steps_in(path) >= 300)
        campaign.send_signal(signal.SIGKILL)
    time.sleep(0.5)
    reached = steps_in(path)
    time.sleep(0.5)
    assert 300 <= steps_in(path) == reached < 6000
    run = Run(PLATE, Settings(dt=1e-3, end_time=6.0, frame_every=50))
    (outcome,), notices = execute(path.parent, [run])
    assert not notices and outcome.begun_at == reached
    assert same_history(path, run)


def steps_in(path):
    try:
        return read_killed(path)["step"]
    except ResultFileError:
        return -1  # not there yet, or being written at this instant


def wait_until(condition):
    deadline = time.monotonic() + 300.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.02)


@pytest.mark.slow
def test_many_models_in_memory():
    """Results in order, the failed one in its place; spawned processes and a given executor."""
    stiffer = replace(PLATE, youngs=2e6)
    short = Settings(dt=0.02, end_time=0.2)
    items = [(PLATE, short), TOO_LONG, (stiffer, short),
             ("l-plate", Settings(dt=0.02, end_time=0.1))]
    expected = [simulate(*item).history for item in (items[0], items[2])]
    with ThreadPoolExecutor(1) as executor:
        for results in (run_many(items, jobs=2), run_many(items, executor)):
            assert isinstance(results[1], InputError)
            assert np.array_equal(results[0].history, expected[0])
            assert np.array_equal(results[2].history, expected[1])
            assert len(results[3].displacement) == 155 and results[3].settings.end_time == 0.1


@pytest.mark.slow
def test_many_models_with_probes():
    """A place is that of a node of each mesh; a mesh without one leaves its exception."""
    short = Settings(dt=0.02, end_time=0.2)
    items = [(PLATE, short), (replace(PLATE, nodes=PLATE.nodes + 1.0, normals=None), short)]
    with ThreadPoolExecutor(1) as executor:
        for results in (run_many(items, jobs=2, probes={"tip": PLATE.nodes[-1].tolist()}),
                        run_many(items, executor, probes={"tip": PLATE.nodes[-1]})):
            assert np.array_equal(results[0].probes["tip"]["displacement"][-1],
                                  results[0].displacement[-1])
            assert isinstance(results[1], InputError)
    with pytest.raises(InputError, match="probes must be a dictionary"):
        run_many(items, probes=[0])


def test_many_models_start_from_one_state():
    """Each from the end of another run, with its velocities."""
    short = Settings(dt=0.02, end_time=0.2)
    begun = simulate(PLATE, short).state
    items = [(replace(PLATE, loads=[]), short), (replace(PLATE, youngs=2e6, loads=[]), short)]
    with ThreadPoolExecutor(1) as executor:
        results = run_many(items, executor, start=begun)
    for item, result in zip(items, results):
        assert np.array_equal(result.history, simulate(*item, start=begun).history)
        assert result.history["kinetic_energy"][0] > 0.0
    with pytest.raises(InputError, match="start must be a Configuration"):
        run_many(items, start=0)


@pytest.mark.slow
def test_script_that_starts_itself_again_is_told_so(tmp_path):
    """Spawned processes import the script: without its guard they would start themselves."""
    script = tmp_path / "script.py"
    script.write_text(CAMPAIGN.replace('if __name__ == "__main__":', "if True:"))
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, cwd=tmp_path,
                          env={**os.environ, "PYTHONPATH": ":".join(sys.path)})
    assert "InputError: the worker processes end as they start" in done.stderr


def test_many_models_checks_before_it_computes():
    with pytest.raises(InputError, match="a pair of Model and NoneType"):
        run_many([(PLATE, Settings(dt=0.02, end_time=0.2)), (PLATE, None)])
    with pytest.raises(InputError, match="jobs must be at least 1"):
        run_many([], jobs=0)
