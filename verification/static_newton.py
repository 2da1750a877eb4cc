"""Newton's iteration of a static load step, with its tangent or a wrong one."""

from corovec import StaticSettings
from corovec.solver.statics.equilibrium import Equilibrium
from corovec.solver.system.failure import NotConverged

EXACT = StaticSettings(tolerance=1e-24)
"""Iterated until rounding, so that the last corrections show their order too."""


def works_of_step(model, start, increment, geometric=True):
    """Works |residual . correction| of the corrections of one load step.

    Args:
        model: ``Model`` with supports.
        start: load factor of the equilibrium from which the step goes, reached in two steps.
        increment: of the load factor.
        geometric: whether the tangent has its geometric stiffness.

    Returns:
        list of float: a work a correction [J].
    """
    begin = Equilibrium(model, StaticSettings())
    for factor in (0.5 * start, start):
        begin.equilibrate(factor)
    step = Equilibrium(model, EXACT, geometric)
    step.state.unpack(begin.state.pack())
    try:
        step.equilibrate(start + increment)
    except NotConverged:
        pass
    return step.works
