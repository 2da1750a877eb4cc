"""Entry point of the command ``corovec``: an interrupt is one line whenever it comes."""

import os
import signal
import sys

from corovec.solver.runtime.process import end_with_parent


def main():
    """Run ``main``.

    Libraries that are interrupted while they load may end with a traceback or lose the interrupt,
    so that until they are there it ends the process at once.  Later it is an exception, which only
    the compiler's callbacks lose.
    """
    end_with_parent()
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupted)
    sys.unraisablehook = _lost
    from corovec.solver.cli import main
    if signal.getsignal(signal.SIGINT) is _interrupted:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    main()


def _interrupted(*_):
    os.write(2, b"\ncorovec: error: interrupted\n")
    os._exit(130)


def _lost(error):
    if error.exc_type is KeyboardInterrupt:
        _interrupted()
    sys.__unraisablehook__(error)


if __name__ == "__main__":
    main()
