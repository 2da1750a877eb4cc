"""How many digits of a solution rounding has left."""

import numpy as np

from ..errors import AccuracyWarning, StepError, warn

FEW, NONE = 1e-3, 0.1
"""Relative errors from which a solution is warned of, and refused."""

EPS = np.finfo(float).eps


def judge(error, cause):
    """Warn of a solution with few correct digits, or refuse it.

    Args:
        error: estimate of its relative error.
        cause: where it comes from, in words.

    Raises:
        StepError: no digit is correct.
    """
    found = f"rounding leaves the displacements a relative error of about {error:.1g}: {cause}"
    if not error < NONE:
        raise StepError(found)
    if error > FEW:
        warn(found, AccuracyWarning)
