"""Settings of all tests of this package."""

import signal

from hypothesis import settings

from corovec import warm_up

# compiling a kernel takes longer than any per-example deadline; examples are the same every run
settings.register_profile("corovec", deadline=None, derandomize=True, max_examples=200)
settings.load_profile("corovec")

# a shell's background jobs ignore interrupts, and so would the commands that tests interrupt
signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_sessionstart():
    """Compile before the workers start, which would each do the same."""
    warm_up(exact=True)
