"""Arc length: equilibrium paths through limit points and snap-backs (Crisfield, cylindrical)."""

from collections.abc import Callable

import numpy as np
from threadpoolctl import threadpool_limits

from ..errors import InputError, StepError
from ..model.histories import CONSTANT
from ..model.loads import Drive
from ..model.model import Model
from ..results.files import output_path
from ..signatures import Count, File, Positive, checked
from ..system.failure import NotConverged, told
from .path import Path
from .settings import DEFAULT, StaticSettings

ROOM = 100
"""Steps that a file has room for at first."""


@checked
@threadpool_limits.wrap(limits=1)
def arc_length(model: Model, length: Positive, until: Callable,
               settings: StaticSettings = DEFAULT, max_steps: Count = 2000, wanted: Count = 5, *,
               switch: bool = False, output: File = None, overwrite: bool = False,
               resume: bool = False):
    """Equilibrium path through limit points and snap-backs, by Crisfield's cylindrical arc length.

    Every load must be proportional to the load factor (constant history).  A step satisfies
    ``|du| = length`` over the displacements of all nodes; the length adapts so that about
    ``wanted`` iterations are needed.

    Args:
        model: ``Model``.
        length: first arc length [m].
        until: function of a row ``(factor, displacement)`` that ends the path when true.
        settings: ``StaticSettings``.
        max_steps: steps of the path at most.
        wanted: iterations of a step, see above.
        switch: where the path has passed a bifurcation, leave it for the branch that starts there,
            by a step along the shape in which the tangent is weakest; else there is a warning.
        output: result file (HDF5), which gets every row and frame; ParaView shows their numbers as
            time, because factors may fall.
        overwrite: replace ``output`` if it exists.
        resume: continue ``output`` from its last row if it exists; ``until`` may be another.

    Returns:
        ``StaticResult``, a row for each step, the first at zero load.

    Warns:
        AccuracyWarning, StabilityWarning: as of ``load_control``.

    Raises:
        InputError: a load depends on time, none acts on a free component, or a displacement is
            prescribed.
        ResultFileError: ``output`` exists, is damaged, foreign, or from other parameters.
        StepError: no convergence even with the smallest length, or ``until`` not met in time.
    """
    if any(load.history != CONSTANT for load in model.loads):
        raise InputError("arc length needs loads without a history of their own")
    if any(isinstance(support, Drive) or support.displacement for support in model.supports):
        raise InputError("arc length cannot prescribe displacements")
    if any(getattr(joint, "angle", None) is not None for joint in model.joints):
        raise InputError("arc length cannot drive joints")
    output = output_path(output, overwrite, resume)
    path = Path(model, settings)
    arc = _Arc(path, settings)
    smallest = length * 1e-6
    path.begin(length, output, overwrite, resume, ROOM, method="arc length", length=length,
               wanted_iterations=wanted,
               switch=switch)
    factor, length = path.rows.reached
    while len(path.rows) == 1 or not until(factor, path.rows.displacement(-1)):
        if len(path.rows) > max_steps:
            raise StepError(f"the path did not reach its end within {max_steps} steps")
        leaves = switch and path.unseen > 0
        try:
            used, reached = arc.step(factor, length, leaves)
        except NotConverged as failure:
            length *= 0.5
            if length < smallest:
                raise StepError(f"no equilibrium found beyond load factor {factor:.6g}: "
                                f"{failure}") from None
            continue
        length *= min(2.0, np.sqrt(wanted / used))
        factor = reached
        with told():
            path.append(factor, used, 1, length, shown=len(path.rows), turned=arc.turned)
        if leaves:  # the tangent of the other branch has its own negative pivots
            path.unseen = 0
        if not switch:
            path.warn_of_bifurcation("switch=True follows the other branch")
    return path.result(0)


INVERSE_ITERATIONS = 30
"""Beyond a bifurcation one eigenvalue is far nearer to zero than all others."""


class _Arc:
    """Steps of given length along a path.

    Attributes:
        turned: whether the load turned round in the last step.

    Raises:
        InputError: no load acts on a free component.
    """

    def __init__(self, path, settings):
        self._path, self._equilibrium, self._settings = path, path.equilibrium, settings
        system = path.equilibrium.system
        if not np.any(path.equilibrium.free(path.equilibrium.unit_forces())):
            raise InputError("arc length needs a load that is not zero where no support holds")
        self._displacements = np.sort(system.translations.ravel())
        self.turned = False

    def step(self, factor, length, branch=False):
        """One step; (iterations, new factor).  ``branch``: off the path, along its weakest shape.

        Raises:
            NotConverged: why there is none; the state is as it was.
        """
        backup = self._equilibrium.backup()
        try:
            return self._iterate(factor, length, branch)
        except NotConverged:
            self._equilibrium.restore(backup)
            raise

    def _iterate(self, factor, length, branch):
        equilibrium, taken = self._equilibrium, self._displacements
        moved = first = None
        equilibrium.works = []
        for k in range(1, self._settings.max_iterations + 1):
            load = equilibrium.unit_forces()
            correction = equilibrium.correction(factor, mixed=k > 1)
            pull = equilibrium.pull
            tangent = equilibrium.response(load)
            if k == 1:
                # predictor along the tangent, onwards, or along the weakest shape
                rising = self._onwards(tangent)
                size = length / np.linalg.norm(tangent[taken])
                change = 0.0 if branch else size if rising else -size
                correction = length * self._weakest() if branch else change * tangent
                pull = 0.0
                moved = correction[taken].copy()
                first = size**2 * abs(float(load @ tangent))
                equilibrium.works.append(first)
            else:
                equilibrium.works.append(equilibrium.work(correction))
                change = _onto_arc(moved, correction[taken], tangent[taken], length)
                if change is None or not np.isfinite(equilibrium.works[-1]):
                    raise NotConverged("the arc is not met")
                correction = correction + change * tangent
                moved += correction[taken]
            factor += change
            equilibrium.move(correction, pull + change * equilibrium.pull)
            if equilibrium.converged(k, first):
                self.turned = rising is not bool(moved @ tangent[taken] >= 0.0)
                return k, factor
        raise NotConverged(equilibrium.too_slow(first))

    def _onwards(self, tangent):
        """Whether ``tangent`` points away from the row before the last one."""
        rows = self._path.rows
        if len(rows) == 1:
            return True
        moved = rows.displacement(-1) - rows.displacement(-2)
        return bool(np.sum(moved * tangent[self._equilibrium.system.translations]) >= 0.0)

    def _weakest(self):
        """The shape (n_dof,) of the eigenvalue of the tangent that is next to zero, by inverse
        iteration; its displacements have the length 1."""
        equilibrium, scale = self._equilibrium, self._equilibrium.system.lengths
        shape = equilibrium.free(np.random.default_rng(0).standard_normal(len(scale)))
        for _ in range(INVERSE_ITERATIONS):
            shape = equilibrium.system.solver.solve(equilibrium.free(scale**2 * shape))
            shape /= np.linalg.norm(shape[self._displacements])
        return shape


def _onto_arc(moved, correction, tangent, length):
    """Root of ``|moved + correction + c tangent| = length`` that keeps the direction, or None."""
    base = moved + correction
    a, b, c = tangent @ tangent, 2.0 * base @ tangent, base @ base - length**2
    discriminant = b * b - 4.0 * a * c
    if not discriminant >= 0.0:
        return None
    root = np.sqrt(discriminant)
    candidates = ((-b + root) / (2.0 * a), (-b - root) / (2.0 * a))
    return max(candidates, key=lambda s: moved @ (base + s * tangent))
