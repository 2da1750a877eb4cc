"""Static equilibrium: linear solution, load control with automatic steps, and arc length.

The load factor plays the part of time: every load and prescribed displacement is taken at
``t = factor``, so a load that is left constant is applied as ``factor * load``.  Assembly, solvers
and result file are those of dynamics.  As the normals are the whole state (no rates to carry over),
the rotational variables may be switched after every iteration.
"""

import time
import zlib

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from threadpoolctl import threadpool_limits

from ..checks import count, floats, instance, positive
from ..errors import InputError, StepError
from ..kernels import assembly
from ..model.loads import CONSTANT
from ..model.model import Model
from ..results.files import output_path
from ..runtime.provenance import describe
from ..system.linear import SingularMatrix
from ..system.system import NOT_TOLD, State, System
from .result import Rows, StaticResult
from .settings import StaticSettings

DEFAULT = StaticSettings()

STATIC = (0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""Step factors of equilibrium at the end of the increment: no inertia, no averaging."""

LARGEST_TURN = 1.0
"""Largest rotation of a normal in one iteration [rad]."""

ROOM = 100
"""Steps of an arc length that a file has room for at first."""


def solve_linear(model, solver="skyline"):
    """Linear solution K(0) U = F(t = 1) from the initial configuration.

    Returns:
        (displacement (n_nodes, 3) [m], change of the normals (n_nodes, 3)).

    Raises:
        InputError: the supports leave a rigid motion or a mechanism free.
    """
    path = _Path(model, StaticSettings(solver=solver))
    correction = path.solve_increment(path.prescribed(1.0), 1.0)
    system, start = path.system, path.system.numbering.start
    displacement = correction[start[:, None] + np.arange(3)]
    change = np.stack([A1[:, :n] @ correction[first + 3:first + 3 + n] for A1, first, n in
                       zip(system.A1[model.directors.first[:-1]], start, system.numbering.n_rot)])
    return displacement, change


@threadpool_limits.wrap(limits=1)
def load_control(model, factors, settings=DEFAULT, progress=None, *, output=None,
                 overwrite=False, resume=False):
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

    Raises:
        InputError: factors do not ascend, or a mechanism is left free.
        ResultFileError: ``output`` exists, is damaged, foreign, or from other parameters.
        StepError: no convergence even with the smallest step; at a limit point use arc length.
    """
    factors = floats("load factors", factors, (None,)) if np.size(factors) else np.zeros(0)
    if not len(factors) or np.any(np.diff(np.r_[0.0, factors]) <= 0.0):
        raise InputError("load factors must be a list of numbers that ascend from above zero")
    output = output_path(output, overwrite, resume)
    clock = time.perf_counter()
    path = _Path(model, settings)
    path.begin(factors[0], output, overwrite, resume, len(factors), method="load control",
               factors=_listed(factors))
    for target in factors[len(path.rows) - 1:]:
        reached, step = path.rows.reached
        iterations, steps = 0, 0
        step = max(step, 0.25 * (target - reached))
        smallest = (target - reached) / 2**settings.max_divisions
        while reached < target:
            goal = target if reached + 1.001 * step >= target else reached + step
            used, failure = path.equilibrate(reached, goal)
            iterations += used
            if failure is None:
                reached, steps = goal, steps + 1
                if used <= settings.fast_iterations:
                    step *= 1.5
                continue
            step = 0.5 * (goal - reached)
            if step < smallest:
                raise StepError(f"no equilibrium beyond load factor {reached:.6g}: {failure}")
        path.append(target, iterations, steps, step, shown=target)
        if progress is not None:
            progress(target, factors[-1])
    return path.result(1, clock)


@threadpool_limits.wrap(limits=1)
def arc_length(model, length, until, settings=DEFAULT, max_steps=2000, wanted=5, *,
               output=None, overwrite=False, resume=False):
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
        output: result file (HDF5), which gets every row and frame; ParaView shows their numbers as
            time, because factors may fall.
        overwrite: replace ``output`` if it exists.
        resume: continue ``output`` from its last row if it exists; ``until`` may be another.

    Returns:
        ``StaticResult``, a row for each step, the first at zero load.

    Raises:
        InputError: a load depends on time or follows the shell, none acts on a free component, or
            a displacement is prescribed.
        ResultFileError: ``output`` exists, is damaged, foreign, or from other parameters.
        StepError: no convergence even with the smallest length, or ``until`` not met in time.
    """
    length = positive("arc length", length, "m")
    max_steps, wanted = count("max_steps", max_steps), count("wanted", wanted)
    if not callable(until):
        raise InputError("until must be a function of (factor, displacement)")
    instance("model", model, Model)
    if any(load.history != CONSTANT for load in model.loads):
        raise InputError("arc length needs loads without a history of their own")
    if any(support.displacement for support in model.supports):
        raise InputError("arc length cannot prescribe displacements")
    output = output_path(output, overwrite, resume)
    clock = time.perf_counter()
    path = _Path(model, settings)
    if not path.system.all_dead:
        raise InputError("arc length needs dead nodal forces")
    if not np.any(path._free(path.system.loads_at(1.0)[0])):
        raise InputError("arc length needs a load that is not zero where no support holds")
    smallest = length * 1e-6
    path.begin(length, output, overwrite, resume, ROOM, method="arc length", length=length,
               wanted_iterations=wanted)
    factor, length = path.rows.reached
    while len(path.rows) == 1 or not until(factor, path.rows.displacement(-1)):
        if len(path.rows) > max_steps:
            raise StepError(f"the path did not reach its end within {max_steps} steps")
        used, outcome = path.arc_step(factor, length)
        if isinstance(outcome, str):
            length *= 0.5
            if length < smallest:
                raise StepError(f"no equilibrium beyond load factor {factor:.6g}: {outcome}")
            continue
        length *= min(2.0, np.sqrt(wanted / used))
        factor = outcome
        path.append(factor, used, 1, length, shown=len(path.rows))
    return path.result(0, clock)


class _Path:
    """A state that is moved from equilibrium to equilibrium, and a row of each of them."""

    def __init__(self, model, settings):
        instance("model", model, Model)
        self.settings = instance("settings", settings, StaticSettings)
        self.system = System(model, settings.solver)
        self.state = self.system.initial_state()
        self.indefinite = 0
        self.works = []
        self.rows = Rows(self.system, self.state)
        self._translations = self.system.numbering.start[:, None] + np.arange(3)
        self._zero = np.zeros(self.system.numbering.n_dof)
        self._prescribed = _prescribed(model, self.system.numbering)
        _check_held(model)

    def begin(self, first_step, output, overwrite, resume, n_steps, **plan):
        """The row of zero load, or every row of the file that is continued."""
        if output is None:
            self.append(0.0, 0, 0, first_step, 0.0)
            return
        description = describe(self.system.model, self.settings, self.system.solver.name, **plan)
        if resume and output.exists():
            self.rows.resume(output, description)
        else:
            self.append(0.0, 0, 0, first_step, 0.0)
            self.rows.create(output, description, n_steps, overwrite)

    def append(self, factor, iterations, steps, next_step, shown):
        """A row of the state; ``shown`` is its time in ParaView."""
        residual = self.system.residual
        instant = self._assemble(factor, tangent=False)
        reactions = (residual[0] - residual[1])[self._translations]
        self.rows.append((factor, instant.strain, reactions.sum(axis=0), iterations, steps,
                          self.indefinite, next_step), reactions, shown)
        self.indefinite = 0

    def result(self, first, clock):
        """``StaticResult`` of the rows from ``first`` on."""
        return StaticResult(*self.rows.columns(first), tuple(self.works), self.system.solver.name,
                            self.rows.indefinite, time.perf_counter() - clock)

    def prescribed(self, factor):
        """Prescribed displacements (n_dof,) at a load factor [m]."""
        values = self._zero.copy()
        for history, pattern in self._prescribed.items():
            values += (factor if history == CONSTANT else history(factor)) * pattern
        return values

    def equilibrate(self, start, goal):
        """Newton's iteration from ``start`` to ``goal``; (iterations, None or why it failed)."""
        backup = self._copy()
        pushed = self.prescribed(goal) - self.prescribed(start)
        self.works = []
        self.system.mixed = False
        for k in range(1, self.settings.max_iterations + 1):
            try:
                if k == 1 and np.any(pushed):
                    correction = self.solve_increment(pushed, goal)
                else:
                    correction = self._solve(goal)
            except SingularMatrix as error:
                return self._give_up(backup, k, str(error))
            work = abs(float(self.system.residual[0] @ correction))
            self.works.append(work)
            if not np.isfinite(work):
                return self._give_up(backup, k, "the iteration diverges")
            self._move(correction)
            if work <= max(self.settings.tolerance * max(self.works),
                           self.system.roundoff_work) and k > 1:
                return k, None
        return self._give_up(backup, k, f"{k} iterations reached a work ratio of "
                                        f"{work / max(self.works):.2g}")

    def arc_step(self, factor, length):
        """One step of given length; (iterations, new factor or why it failed)."""
        backup, system = self._copy(), self.system
        moved, first = None, None
        system.mixed = False
        displacements = np.sort(self._translations.ravel())
        unit_load = system.loads_at(1.0)[0]
        for k in range(1, self.settings.max_iterations + 1):
            try:
                correction = self._solve(factor)
            except SingularMatrix as error:
                return self._give_up(backup, k, str(error))
            tangent = system.solver.solve(self._free(unit_load))
            if k == 1:
                # predictor along the tangent, onwards
                size = length / np.linalg.norm(tangent[displacements])
                change = size if self._onwards(tangent) else -size
                correction = change * tangent
                moved = correction[displacements].copy()
                first = abs(change * float(unit_load @ correction))
            else:
                work = abs(float(system.residual[0] @ correction))
                change = _onto_arc(moved, correction[displacements], tangent[displacements],
                                   length)
                if change is None or not np.isfinite(work):
                    return self._give_up(backup, k, "the arc is not met")
                correction = correction + change * tangent
                moved += correction[displacements]
            factor += change
            self._move(correction)
            if k > 1 and work <= max(self.settings.tolerance * first, system.roundoff_work):
                return k, factor
        return self._give_up(backup, k, f"{k} iterations reached a work ratio of "
                                        f"{work / first:.2g}")

    def _onwards(self, tangent):
        """Whether ``tangent`` points away from the row before the last one."""
        if len(self.rows) == 1:
            return True
        moved = self.rows.displacement(-1) - self.rows.displacement(-2)
        return np.sum(moved * tangent[self._translations]) >= 0.0

    def solve_increment(self, pushed, factor):
        """First correction of a step with prescribed displacements: the free dofs follow linearly.

        The forces of the push are taken from a small one, a millionth of the shell's size.
        """
        self._assemble(factor)
        residual = self.system.residual[0].copy()
        if np.any(pushed):
            fraction = 1e-6 * self.system.model.size / np.abs(pushed).max()
            forces = self.system.residual[1].copy()
            self.system.assemble(self.state, STATIC, False, fraction * pushed,
                                  self._loads(factor), tangent=False)
            residual += self._free(self.system.residual[1] - forces) / fraction
        self._factor()
        return self.system.solver.solve(residual) + pushed

    def _loads(self, factor):
        return self.system.static_loads(factor)

    def _assemble(self, factor, tangent=True):
        instant = self.system.observe(self.state)
        self.system.assemble(self.state, STATIC, False, self._zero, self._loads(factor), tangent)
        return instant

    def _factor(self):
        try:
            self._factorize()
        except SingularMatrix as error:
            raise InputError(f"the shell is a mechanism: {error}") from None

    def _factorize(self):
        negative = self.system.factorize()
        self.indefinite = NOT_TOLD if negative is None else self.indefinite + bool(negative)

    def _solve(self, factor):
        self._assemble(factor)
        self._factorize()
        return self.system.solver.solve(self.system.residual[0])

    def _free(self, vector):
        return np.where(self.system.fixed, 0.0, vector)

    def _move(self, correction):
        """Apply a correction, scaled down if it turns a normal by more than ``LARGEST_TURN``; its
        linear part is the stress of the next tangent."""
        system, state = self.system, self.state
        start = system.numbering.start
        turn = system.largest_turn(correction)
        if turn > LARGEST_TURN:
            correction = LARGEST_TURN / turn * correction
        system.predict_strains(state, correction)
        system.mixed = True
        system.turn(state, correction)
        assembly.move_nodes(start, correction, state.x, state.x_low)

    def _give_up(self, backup, iterations, why):
        for name, array in zip(State.ARRAYS, backup):
            getattr(self.state, name)[...] = array
        return iterations, why

    def _copy(self):
        return [getattr(self.state, name).copy() for name in State.ARRAYS]


def _check_held(model):
    """Every connected part of the shell must be held against its six rigid motions."""
    n_nodes, quads, fixed = len(model.nodes), model.quads, model.fixed
    links = coo_array((np.ones(quads.size), (np.repeat(quads[:, 0], 4), quads.ravel())),
                      shape=(n_nodes, n_nodes))
    n_parts, part = connected_components(links, directed=False)
    for k in range(n_parts):
        inside = part == k
        held = fixed[inside]
        x = (model.nodes[inside] - model.nodes[inside].mean(axis=0)) / model.size
        p = model.normals[model.directors.first[:-1]][inside]
        motions = np.zeros((len(x), 6, 6))
        motions[:, :3, :3] = np.eye(3)
        for axis, omega in enumerate(np.eye(3)):
            motions[:, :3, 3 + axis] = np.cross(omega, x)
            motions[:, 3:, 3 + axis] = np.cross(omega, p)
        free = 6 - np.linalg.matrix_rank(motions[held], tol=1e-9) if held.any() else 6
        if free:
            which = "the shell" if n_parts == 1 else f"the part with node {np.argmax(inside)}"
            motions = "1 rigid motion" if free == 1 else f"{free} rigid motions"
            raise InputError(f"the supports leave {motions} of {which} free")


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


def _listed(factors):
    """Load factors in short, for the settings of a result file: number, ends and CRC-32."""
    return (f"{len(factors)} from {factors[0]:g} to {factors[-1]:g} "
            f"({zlib.crc32(factors.tobytes()):08x})")


def _prescribed(model, numbering):
    """``{history: (n_dof,) displacement}`` of the supports that move."""
    patterns = {}
    for support in model.supports:
        if support.displacement != 0.0:
            pattern = patterns.setdefault(support.history, np.zeros(numbering.n_dof))
            for node in support.nodes:
                for component in support.components:
                    first = numbering.start[node]
                    pattern[first + "xyz".index(component)] = support.displacement
    return patterns
