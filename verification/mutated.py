"""A program: one case with the text of another file in the place of one of the solver's.

``mutants.py`` starts it, with the solver's file, the other one, the case, and the file of the
verdicts.  It ends when its standard input is closed.
"""

import json
import os
import sys
import threading
from importlib.machinery import SourceFileLoader
from pathlib import Path


def replace_source(file, source):
    """From now on ``file`` is imported with the text of ``source``; returns the list of the modules
    for which that has happened."""
    original, replaced = SourceFileLoader.get_code, []

    def get_code(loader, name):
        if loader.path == file:
            replaced.append(name)
            return compile(Path(source).read_text(encoding="utf-8"), file, "exec")
        return original(loader, name)

    SourceFileLoader.get_code = get_code
    return replaced


def run(file, source, case, output):
    """Verdicts of one case with the text of ``source`` in the place of ``file``."""
    replaced = replace_source(file, source)
    from .registry import find, make_report, run_case
    outcome = run_case(find([case])[0])
    if not replaced:
        sys.exit(f"{file} was not imported")
    report = make_report([outcome], date="", complete=True)
    Path(output).write_text(json.dumps(report), encoding="utf-8")


def end_with_parent():
    """The pipe to standard input closes when the parent process ends, or is interrupted."""
    os.read(sys.stdin.fileno(), 1)
    os._exit(1)


if __name__ == "__main__":
    threading.Thread(target=end_with_parent, daemon=True).start()
    run(*sys.argv[1:])
