"""Processes that end with the one that started them."""

import multiprocessing
import os
import threading
import time

PARENT = "COROVEC_PARENT"
"""Variable with the process without which this one ends, however that one died."""


def child_environment(**variables):
    """Environment of a child process that calls ``end_with_parent``."""
    return {**os.environ, **variables, PARENT: str(os.getpid())}


def end_with_parent():
    """If there is a process without which this one ends, end with it."""
    parent = os.environ.pop(PARENT, "")
    if parent:
        threading.Thread(target=_end_with, args=(int(parent),), daemon=True).start()


def follow_parent():
    """End with the process that started this one by ``multiprocessing``."""
    threading.Thread(target=_follow, daemon=True).start()


def _follow():
    multiprocessing.parent_process().join()
    os._exit(1)


def _end_with(parent):
    while os.getppid() == parent:
        time.sleep(1.0)
    os._exit(1)
