"""Many runs: each with one result file, never computed twice; or in memory, for studies of models.

>>> from corovec.convergence import run_many
>>> if __name__ == "__main__":
...     results = run_many([(model, Settings(dt=0.02, end_time=1.0)) for model in models])
"""

import os
import sys
import tempfile
import warnings
from collections.abc import Callable
from concurrent.futures import Executor, wait
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Annotated

from corovec import Configuration, InputError, ResultFileError, read, simulate, warm_up
from corovec.solver.checks import shown
from corovec.solver.dynamics.probes import probes_of
from corovec.solver.results.files import replacing, writable_folder
from corovec.solver.runtime.execution import Workers, complete, failure, processes
from corovec.solver.signatures import Count, File, checked

from .run import Run, as_run, code_version
from .store import inspect, record, set_aside


@dataclass(frozen=True, eq=False)
class Outcome:
    """What became of a run.

    Attributes:
        run: the ``Run``.
        path: its result file.
        status: ``finished`` now, ``cached`` from an earlier campaign, or ``failed``.
        error: why it failed.
        seconds: of the process that finished it.
        cpu: CPU time of that process for it [s].
        begun_at: the step at which that process took over.
        description: what the file says of solver, versions and machine.
    """

    run: Run
    path: Path
    status: str
    error: str = ""
    seconds: float = float("nan")
    cpu: float = float("nan")
    begun_at: int = 0
    description: dict = None

    @property
    def history(self):
        """Histories of the run, read from its file; None if it failed."""
        return None if self.status == "failed" else read(self.path)["history"]

    @property
    def frames(self):
        """Times of the frames (m,) and displacements (m, n_nodes, 3); None if the run failed."""
        if self.status == "failed":
            return None
        contents = read(self.path)
        return contents["history"]["time"][contents["frame_steps"]], contents["displacement"]


class Campaign:
    """Runs with one result file each in ``folder``, executed by ``workers``.

    Finished runs are not run again, interrupted ones go on from their last checkpoint (on this
    machine), and one that fails does not stop the others.  Use it as a context: it shows one
    progress bar on standard error where that is a terminal.

    Args:
        folder: where the result files are.
        workers: ``Workers``.
        notify: called with a line of text when a run fails or a file is found damaged.

    Raises:
        ResultFileError: the folder cannot be written.
    """

    @checked
    def __init__(self, folder: File, workers: Workers, notify: Callable = warnings.warn):
        self.folder = writable_folder(folder)
        self._workers, self._notify = workers, notify
        self._bar = None

    def __enter__(self):
        from tqdm import tqdm
        self._bar = tqdm(total=0, unit=" element steps", unit_scale=True, disable=None,
                         file=sys.stderr, leave=False)
        return self

    def __exit__(self, *_):
        self._bar.close()

    def run(self, runs):
        """``{key: Outcome}`` of all ``runs``, the longest first."""
        outcomes, tasks = {}, []
        for run in sorted(runs, key=lambda run: -run.work):
            if run.key in outcomes:
                continue
            outcomes[run.key] = outcome = self._outcome(run, "cached")
            if outcome is None:
                path = self._path(run) if self._workers.shared_disk else None
                tasks.append((run, path, code_version()))
        self._bar.total += sum(run.work for run, *_ in tasks)
        self._bar.refresh()
        for (run, *_), data, error in complete(self._workers, _record, tasks):
            outcomes[run.key] = self._finish(run, data, error)
            self._bar.set_postfix_str(f"last: {run}", refresh=False)
            self._bar.update(run.work)
        return outcomes

    def _path(self, run):
        return self.folder / f"{run.key}.h5"

    def _outcome(self, run, status):
        """The ``Outcome`` of a finished run, None if it is not; damage is set aside."""
        path = self._path(run)
        try:
            contents = inspect(path, run)
        except ResultFileError as error:
            if not os.access(path, os.R_OK | os.W_OK):
                raise
            self._notify(f"{error}; set aside as {set_aside(path).name}, its run is repeated")
            return None
        if contents is None:
            return None
        return Outcome(run, path, status, description=contents["description"],
                       **contents["stamp"])

    def _finish(self, run, data, error):
        """Outcome of a run that a worker has ended; ``data`` is its file, if that was elsewhere."""
        path = self._path(run)
        if error is None and data is not None:
            with replacing(path) as partial:
                partial.write_bytes(data)
        outcome = self._outcome(run, "finished") if error is None else None
        if outcome is None:
            text = f"{type(error).__name__}: {error}" if error else "its result file is damaged"
            self._notify(f"{run}: failed: {text}")
            outcome = Outcome(run, path, "failed", error=text)
        return outcome


def _executor(name, value):
    if not callable(getattr(value, "submit", None)):
        raise InputError(f"{name} must be a concurrent.futures.Executor or None, is {shown(value)}")
    return value


@checked
def run_many(items: list[Annotated[Run, as_run]], executor: Annotated[Executor, _executor] = None,
             jobs: Count = None, probes: Annotated[dict, probes_of] = None,
             start: Configuration = None):
    """Run many models and keep the results in memory.

    Args:
        items: pairs (model or case, ``Settings``); a case's name stands for its default
            mesh.  Or ``Run`` s.
        executor: any ``concurrent.futures.Executor``; left out, ``jobs`` spawned processes, one a
            usable core, or this process for one job.  A script needs ``if __name__ ==
            "__main__":`` around a call that spawns.
        probes: of every run, as of ``simulate``; a place is looked for in the mesh of each.
        start: of every run, as of ``simulate``: one state, of a mesh that all have.

    Returns:
        list: in the order of ``items``, each a ``Result``, or the exception that its
        run ended with.

    Raises:
        InputError: an item or ``jobs`` is not what it should be; nothing has been computed.
    """
    compute = partial(_compute, probes=probes, start=start)
    if executor is None:
        ended = {run: error or value
                 for run, value, error in complete(processes(jobs), compute, items)}
        return [ended[run] for run in items]
    futures = [executor.submit(compute, run) for run in items]
    wait(futures)
    return [failure(future) or future.result() for future in futures]


@cache
def _warm_up(exact):
    """Kernels are compiled or loaded once a process, those of the exact scheme where it runs."""
    return warm_up(exact)


def _compute(run, probes, start):
    """In a worker: the result of a run."""
    _warm_up(run.settings.scheme.exact)
    return simulate(run.model, run.settings, probes=probes, start=start)


def _record(task):
    """In a worker: a run into its file, or the bytes of that file where it has no path."""
    run, path, code = task
    if code != code_version():
        raise InputError(f"the worker runs corovec {code_version()}, the campaign {code}")
    _warm_up(run.settings.scheme.exact)
    if path is not None:
        return record(run, path)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.h5"
        record(run, path)
        return path.read_bytes()
