"""Errors that a user can cause, and a warning; each message is one line that names the thing and
its place."""

from .names import printable


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


class ResultFileWarning(UserWarning):
    """Something at the end of a result file is damaged, and what was written before it is used."""
