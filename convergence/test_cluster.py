"""A campaign on a real Dask scheduler with two worker processes, one of which is killed."""

import signal
import subprocess
import sys
import threading
import time

import pytest

pytest.importorskip("distributed", reason="the extra [cluster] is not installed")

from distributed import Client

from corovec import InputError, Settings, read, simulate
from corovec.benchmarks import load_case
from corovec.convergence import Campaign, Run, campaign, dask_workers
from corovec.solver.runtime import execution

PLATE = load_case("l-plate").model(30)
RUNS = [Run(PLATE, Settings(dt=dt, end_time=1.0), "l-plate")
        for dt in (2e-3, 2.5e-3, 4e-3, 5e-3, 0.01)]
TOO_LONG = Run(PLATE, Settings(dt=1.0, end_time=1.0), "l-plate")


@pytest.fixture
def cluster(tmp_path):
    """(address, worker processes) of a scheduler on the loopback."""
    address = tmp_path / "scheduler.json"
    command = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1",
               "--port", "0", "--no-dashboard", "--scheduler-file", str(address)]
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", "--scheduler-file",
              str(address), "--nthreads", "1", "--no-nanny", "--no-dashboard",
              "--local-directory", str(tmp_path)]
    processes = [subprocess.Popen(arguments, stderr=subprocess.DEVNULL, cwd=tmp_path)
                 for arguments in (command, worker, worker)]
    wait_until(address.exists)
    with Client(scheduler_file=str(address), set_as_default=False) as client:
        client.wait_for_workers(2, timeout=120)
        yield client, processes[1:]
    for process in processes:
        process.kill()
        process.wait()


def wait_until(condition):
    deadline = time.monotonic() + 300.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.02)


@pytest.mark.slow
def test_killed_worker_loses_nothing(cluster, tmp_path):
    """Killed while it computes and after it has delivered: its runs are done by the other one.

    The workers return the files, this process writes them; the run that fails is reported.
    """
    client, workers = cluster
    folder, notices, found = tmp_path / "runs", [], {}

    def run_campaign():
        with (dask_workers(client.scheduler.address) as there,
              Campaign(folder, there, notices.append) as campaign):
            found.update(campaign.run([*RUNS, TOO_LONG]))

    thread = threading.Thread(target=run_campaign)
    thread.start()
    wait_until(lambda: list(folder.glob("*.h5")) and all(client.processing().values()))
    workers[0].send_signal(signal.SIGKILL)
    workers[0].wait()
    assert len(list(folder.glob("*.h5"))) < len(RUNS)
    thread.join(timeout=300.0)
    assert len(client.scheduler_info()["workers"]) == 1
    assert [found[run.key].status for run in RUNS] == ["finished"] * len(RUNS)
    assert "too long for its time function" in found[TOO_LONG.key].error and len(notices) == 1
    for run in RUNS:
        history = read(folder / f"{run.key}.h5")["history"]
        assert history.tobytes() == simulate(run.model, run.settings).history.tobytes()
    assert len(list(folder.iterdir())) == len(RUNS)


@pytest.mark.slow
def test_worker_with_other_code_is_refused(monkeypatch, tmp_path, cluster):
    client, _ = cluster
    monkeypatch.setattr(campaign, "code_version", lambda: "0.0.1+other")
    notices = []
    with (dask_workers(client.scheduler.address) as there,
          Campaign(tmp_path / "runs", there, notices.append) as mine):
        (outcome,) = mine.run(RUNS[-1:]).values()
    assert outcome.status == "failed" and "the campaign 0.0.1+other" in notices[0]


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nonsense", "http://127.0.0.1:1"])
def test_bad_address(monkeypatch, address):
    monkeypatch.setattr(execution, "CONNECT", 0.5)
    with pytest.raises(InputError, match=f"^scheduler '{address}' cannot be reached: "):
        with dask_workers(address):
            pass


@pytest.mark.slow
def test_scheduler_without_workers(monkeypatch, cluster):
    monkeypatch.setattr(execution, "CONNECT", 3.0)
    client, workers = cluster
    for worker in workers:
        worker.kill()
    wait_until(lambda: not client.scheduler_info()["workers"])
    with pytest.raises(InputError, match="has no workers"):
        with dask_workers(client.scheduler.address):
            pass


def test_extra_is_needed(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"needs the extra \[cluster\]"):
        with dask_workers("tcp://127.0.0.1:8786"):
            pass
