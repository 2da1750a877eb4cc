"""Load control: equilibrium at given load factors, with steps that are divided and grow."""

import zlib
from collections.abc import Callable

import numpy as np
from threadpoolctl import threadpool_limits

from ..checks import floats
from ..errors import InputError, StepError
from ..model.model import Model
from ..results.files import output_path
from ..signatures import File, checked
from ..system.failure import NotConverged, told
from .path import Path
from .settings import DEFAULT, StaticSettings

SLACK = 1.001
"""A step that ends this near to the next factor, in its own lengths, goes there at once."""


@checked
@threadpool_limits.wrap(limits=1)
def load_control(model: Model, factors, settings: StaticSettings = DEFAULT,
                 progress: Callable = None, *, output: File = None, overwrite: bool = False,
                 resume: bool = False):
    """Equilibrium at each of the ascending load ``factors``, from zero load.

    A step that does not converge is divided, and grows again where it converges fast.

    Args:
        model: ``Model`` with supports.
        factors: load factors to stop at.
        settings: ``StaticSettings``.
        progress: called with (factor, last factor).
        output: result file (HDF5), which gets a row and a frame for zero load and each factor.
        overwrite: replace ``output`` if it exists.
        resume: continue ``output`` from its last factor if it exists.

    Returns:
        ``StaticResult``, a row for each factor.

    Warns:
        AccuracyWarning: rounding leaves few digits of the displacements or of the reactions.
        StabilityWarning: the path passed a bifurcation.

    Raises:
        InputError: factors do not ascend, or a rigid motion is left free.
        ResultFileError: ``output`` exists, is damaged, foreign, or from other parameters.
        StepError: no convergence even with the smallest step: a mechanism, or a limit point,
            where arc length goes on.
    """
    factors = floats("factors", factors, (None,))
    if np.any(np.diff(np.r_[0.0, factors]) <= 0.0):
        raise InputError("factors must be a list of numbers that ascend from above zero")
    output = output_path(output, overwrite, resume)
    path = Path(model, settings)
    path.begin(factors[0], output, overwrite, resume, len(factors), method="load control",
               factors=_listed(factors))
    for target in factors[len(path.rows) - 1:]:
        with told():
            _reach(path, float(target), settings)
        if progress is not None:
            progress(target, factors[-1])
    return path.result(1)


def _reach(path, target, settings):
    """Steps from the last row to the factor ``target``, and the row there."""
    reached, step = path.rows.reached
    iterations, steps = 0, 0
    step = max(step, 0.25 * (target - reached))
    smallest = (target - reached) / 2**settings.max_divisions
    while reached < target:
        goal = target if reached + SLACK * step >= target else reached + step
        try:
            used = path.equilibrium.equilibrate(goal)
        except NotConverged as failure:
            iterations += len(path.equilibrium.works)
            step = 0.5 * (goal - reached)
            if step < smallest:
                raise StepError(f"no equilibrium found beyond load factor {reached:.6g}: "
                                f"{failure}") from None
            continue
        iterations, steps, reached = iterations + used, steps + 1, goal
        if used <= settings.fast_iterations:
            step *= 1.5
    path.append(target, iterations, steps, step, shown=target)
    path.warn_of_bifurcation("perturb the shell, or let arc_length switch to the other branch")


def _listed(factors):
    """Load factors in short, for the settings of a result file: number, ends and CRC-32."""
    return (f"{len(factors)} from {factors[0]:g} to {factors[-1]:g} "
            f"({zlib.crc32(factors.tobytes()):08x})")
