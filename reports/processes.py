"""Commands of ``corovec``, each in a process of its own that need not load everything again.

The processes are forked from a server that has loaded the libraries and the kernels (``loaded.py``)
and does nothing else, so that no thread is lost on the way.  Where none can be (Windows), they are
spawned.
"""

import multiprocessing
import os
import sys
import threading
from importlib import import_module
from multiprocessing.connection import wait

from corovec.__main__ import main
from corovec.solver.runtime.process import follow_parent

LOADED = f"{__package__}.loaded"
"""Module that loads all that the commands need."""

_one_at_a_time = threading.Lock()
"""Held while a process starts or is taken leave of: both look after all others."""


def execute(command, log):
    """Exit status of ``corovec`` with the arguments ``command``; what it says is in the file
    ``log``.  May be called from several threads."""
    process = context().Process(target=_run, args=(command, log))
    with _one_at_a_time:
        process.start()
    wait([process.sentinel])
    with _one_at_a_time:
        process.join()
    return process.exitcode


def context():
    """How such processes are started: a context of ``multiprocessing``."""
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    server = multiprocessing.get_context("forkserver")
    server.set_forkserver_preload([LOADED])
    return server


def _run(command, log):
    """In the new process: both streams into the log, then the command as a shell would call it."""
    follow_parent()
    with open(log, "wb") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    import_module(LOADED)  # if it is not there yet
    sys.argv = ["corovec", *command]
    main()
