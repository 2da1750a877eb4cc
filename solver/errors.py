"""Errors that a user can cause, and a warning; each message is one line that names the thing and
its place."""

import sys
import warnings

from .names import printable

INNER = ("corovec", "contextlib", "threadpoolctl")
"""Packages that a warning is not about: it names the line of the user that called them."""


class _OneLine(Exception):
    """An error whose message is one printable line, whatever the names in it are made of."""

    def __init__(self, message):
        super().__init__(printable(message))


class InputError(_OneLine, ValueError):
    """Something in the input is wrong; nothing has been computed or overwritten."""


class StepError(_OneLine, RuntimeError):
    """A step of time, load or arc length did not converge, even after it was divided as often as
    allowed, or a path did not reach its end."""


class ResultFileError(_OneLine):
    """A result file cannot be written, read or resumed."""


class AccuracyWarning(UserWarning):
    """Results are there, but have fewer correct digits than they show."""


class MeshWarning(UserWarning):
    """A mesh was read and is not quite what the file holds: nodes left out, elements turned."""


class ResultFileWarning(UserWarning):
    """Something at the end of a result file is damaged, and what was written before it is used."""


class StabilityWarning(UserWarning):
    """A path of equilibria has passed a bifurcation: states after it may be unstable."""


def warn(message, category):
    """A warning of one line, about the user's line that called this package."""
    depth, frame = 1, sys._getframe()
    while frame is not None and frame.f_globals.get("__name__", "").partition(".")[0] in INNER:
        depth, frame = depth + 1, frame.f_back
    warnings.warn(printable(message), category, stacklevel=depth)
