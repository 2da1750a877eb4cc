"""Where runs are executed: worker processes of this machine, or those of a Dask scheduler, or here.

All are a ``concurrent.futures.Executor``; ``complete`` is the loop over any.
"""

import math
import multiprocessing
import signal
from collections import deque
from collections.abc import Callable
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from contextlib import contextmanager
from typing import NamedTuple

from ..checks import integer
from ..errors import InputError
from ..signatures import checked
from .process import follow_parent
from .provenance import usable_cores

CONNECT = 10.0
"""Seconds within which a scheduler must answer, and have a worker."""


class Workers(NamedTuple):
    """How to start an executor, how many tasks it is given at a time, and whether its workers
    write to this machine's disk."""

    start: Callable[[], Executor]
    width: float
    shared_disk: bool = True


def processes(jobs=None):
    """Worker processes of this machine; ``jobs`` of them, by default one a usable core.

    They are spawned, for forked children and threaded libraries do not go together; one task waits
    for the first that is free.  A single job is done by this process: to start another takes longer
    than many a task.
    """
    return processes_of(multiprocessing.get_context("spawn"), jobs)


def processes_of(context, jobs=None):
    """The same of a ``multiprocessing`` context."""
    jobs = usable_cores() if jobs is None else integer("jobs", jobs)
    if jobs < 1:
        raise InputError(f"jobs must be at least 1, is {jobs}")
    if jobs == 1:
        return Workers(_Here, 1)
    return Workers(lambda: ProcessPoolExecutor(jobs, context, _begin), jobs + 1)


class _Here(Executor):
    """This process, at once."""

    def submit(self, function, /, *arguments, **options):
        future = Future()
        try:
            future.set_result(function(*arguments, **options))
        except Exception as error:
            future.set_exception(error)
        return future


@checked
@contextmanager
def dask_workers(address: str):
    """Workers of the Dask scheduler at ``address``, as a context.

    Raises:
        InputError: ``distributed`` is not installed, nothing answers, or there are no workers.
    """
    try:
        from distributed import Client
        from distributed.comm import get_address_host_port
    except ImportError:
        raise InputError("a scheduler needs the extra [cluster]: pip install 'corovec[cluster]'"
                         ) from None
    try:
        get_address_host_port(address)  # a Client made in vain is slow to go
        client = Client(address, timeout=CONNECT, set_as_default=False)
    except (OSError, ValueError, ImportError) as error:
        raise InputError(f"scheduler '{address}' cannot be reached: "
                         f"{str(error) or type(error).__name__}") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=CONNECT)
        except TimeoutError:
            raise InputError(f"scheduler '{address}' has no workers") from None
        yield Workers(client.get_executor, math.inf, shared_disk=False)


def isolated(function, *arguments):
    """``function(*arguments)`` in a worker process of its own."""
    executor = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), _begin)
    try:
        result = executor.submit(function, *arguments).result()
    except BaseException:
        _stop(executor, ())
        raise
    executor.shutdown()
    return result


def complete(workers, function, tasks):
    """Yield ``(task, function(task), None)`` or ``(task, None, error)`` as tasks finish.

    A task that takes its worker process with it fails alone: those that were under way with it are
    run again, one at a time.

    Raises:
        InputError: the worker processes do not even start.
    """
    suspects = []
    for task, value, error in _complete(workers, function, tasks):
        if isinstance(error, BrokenExecutor):
            suspects.append(task)
        else:
            yield task, value, error
    yield from _complete(workers._replace(width=1), function, suspects)


def failure(future):
    """What became of a finished future instead of a result; None if it has one."""
    return CancelledError("cancelled") if future.cancelled() else future.exception()


def _complete(workers, function, tasks):
    if not tasks:
        return
    waiting, running = deque(tasks), {}
    executor, started = _start(workers)
    try:
        while waiting or running:
            broken = not _submit(executor, function, waiting, running, workers.width)
            done, _ = wait(running, return_when=FIRST_COMPLETED)
            if broken or any(isinstance(failure(future), BrokenExecutor) for future in done):
                done, _ = wait(running)
                if isinstance(started.exception(), BrokenExecutor):
                    raise InputError("the worker processes end as they start; a script needs "
                                     "'if __name__ == \"__main__\":' around what starts them")
                executor.shutdown()
                executor, started = _start(workers)
            for future in done:
                error = failure(future)
                yield running.pop(future), None if error else future.result(), error
    except BaseException:
        _stop(executor, running)
        raise
    executor.shutdown()


def _start(workers):
    """An executor, and the future of a first task that tells whether its workers start."""
    executor = workers.start()
    return executor, executor.submit(int)


def _submit(executor, function, waiting, running, width):
    """Fill up what is running from what is waiting; False if the executor has broken."""
    try:
        while waiting and len(running) < width:
            running[executor.submit(function, waiting[0])] = waiting[0]
            waiting.popleft()
    except BrokenExecutor:
        return False
    return True


def _stop(executor, running):
    """End worker processes at once; the files of their runs keep the last checkpoint."""
    children = list((getattr(executor, "_processes", None) or {}).values())
    for future in running:
        future.cancel()
    executor.shutdown(wait=False)
    for child in children:
        child.terminate()


def _begin():
    """A worker process leaves Ctrl-C to the campaign, and ends when that has died."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    follow_parent()
