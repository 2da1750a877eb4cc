"""Newton's iteration of a static load step, with its tangent or a wrong one.

The only place that reaches into ``solver.statics``, for what no result holds.
"""

from corovec import StaticSettings
from corovec.solver.statics.path import _Path

EXACT = StaticSettings(tolerance=1e-24)
"""Iterated until rounding, so that the last corrections show their order too."""


class _MaterialTangent(_Path):
    """A wrong iteration: its tangent leaves out the geometric stiffness."""

    def _solve(self, factor):
        for stresses in self.system.predicted:
            stresses[:] = 0.0
        self.system.mixed = True
        return super()._solve(factor)


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
    begin = _Path(model, StaticSettings())
    for last, factor in ((0.0, 0.5 * start), (0.5 * start, start)):
        _, failure = begin.equilibrate(last, factor)
        assert failure is None
    path = (_Path if geometric else _MaterialTangent)(model, EXACT)
    path.state = begin.state
    path.equilibrate(start, start + increment)
    return path.works
