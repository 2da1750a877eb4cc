"""Linear statics."""

import numpy as np
from threadpoolctl import threadpool_limits

from ..errors import InputError
from ..kernels import updates
from ..kernels.arguments import STATIC
from ..kernels.hinges import SLACK
from ..model.model import Model
from ..signatures import checked
from ..system.failure import SingularMatrix
from ..system.loads import at_factor
from ..system.rounding import EPS, judge
from ..system.state import Place
from .equilibrium import Equilibrium
from .result import LinearResult
from .settings import StaticSettings

MOST_REFINEMENTS = 10

LEAST_GAIN = 0.5
"""Ratio of a correction to the one before from which refinement has done what it can."""


@checked
@threadpool_limits.wrap(limits=1)
def solve_linear(model: Model, solver="skyline"):
    """Linear solution K(0) U = F(t = 1) from the initial configuration, K(0) without loads.

    Forces of heat are among F; K(0) is that of the shell without stress.

    Bending of a shell of length L and thickness h is lost in its matrix as (L/h)^2 times the
    rounding error.  The strains of the solution lose less, and their forces refine it.

    Args:
        model: ``Model`` with supports.
        solver: the linear solver, as of ``StaticSettings``.

    Returns:
        ``LinearResult``; ``displacement, change_of_normals = solve_linear(model)`` takes the first
        two of it.

    Warns:
        AccuracyWarning: few digits are correct.

    Raises:
        InputError: the supports leave a rigid motion or a mechanism free.
        StepError: no digit is correct.
    """
    equilibrium = Equilibrium(model, StaticSettings(solver=solver), geometric=not model.heated)
    try:
        pushed = equilibrium.system.driven.linear(equilibrium.state, equilibrium.place.start,
                                                  at_factor(1.0))
        solution = equilibrium.solve_increment(pushed, 1.0, stiffness_at=0.0)
        _refine(equilibrium, solution)
    except SingularMatrix as error:
        raise InputError(f"the shell is a mechanism: {error}") from None
    system = equilibrium.system
    displacement = solution[system.translations]
    change = system.coordinates.change_of_directors(equilibrium.place.start, solution)
    _residual(equilibrium, solution)
    system.hold()
    joints = system.joints(equilibrium.state, equilibrium.place)
    reactions = equilibrium.reactions(1.0)
    return LinearResult(displacement, change[model.directors.first[:-1]], change, reactions.forces,
                        reactions.moments, reactions.force, reactions.moment,
                        equilibrium.balance(1.0, reactions)[1],
                        joints[:, :3], joints[:, 3], joints[:, 4:])


def _refine(equilibrium, solution):
    """Iterative refinement, ``U += K^-1 (F - T^T f(T U))``, while it gains."""
    system, lost = equilibrium.system, [np.inf]
    size = np.abs(system.lengths * solution).max()
    while len(lost) <= MOST_REFINEMENTS and size > 0.0:
        correction = system.solver.solve(_residual(equilibrium, solution))
        lost.append(np.abs(system.lengths * correction).max() / size)
        if not lost[-1] < LEAST_GAIN * lost[-2]:
            break
        solution += correction
    if size > 0.0:
        judge(min(lost), f"the condition of the matrix is about {lost[1] / EPS:.1g}")


def _residual(equilibrium, solution):
    """Forces at free dofs that strains linear in ``solution`` leave, (n_dof,)."""
    system, state, start = equilibrium.system, equilibrium.state, equilibrium.place.start
    initial = start
    if not system.model.heated:
        initial = start._replace(b=np.zeros_like(start.b), e=np.zeros_like(start.e))
    strains = system.predictions()
    updates.predict_strains(system.elements, system.dofs.nodes, state.motion, initial, solution,
                            strains)
    # alpha_f = 1: strains, T and where springs are slack are those of the start of the step
    state.hinges[:, SLACK] = system.turnings.slacks(at_factor(1.0))
    system.assemble(state, Place(start._replace(b=strains.b, e=strains.e)),
                    STATIC._replace(alpha_f=1.0, strain_end=0.0, strain_start=1.0),
                    np.zeros_like(solution), system.loads_by(at_factor(1.0)), tangent=False)
    of_springs = system.forces_of_springs(state, start, solution)
    system.residual.unmasked[:] += of_springs
    system.residual.applied[:] += of_springs
    system.residual.balance[:] += equilibrium.free(of_springs)
    return system.residual.balance
