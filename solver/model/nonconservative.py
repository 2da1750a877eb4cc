"""Loads without a potential: forces that follow the shell, drag of a medium, forces of the user.

Plain data, checked when made; what depends on a mesh is checked by ``Model``.
"""

import hashlib
import inspect
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..checks import (
    distinct,
    floats,
    function,
    integer,
    not_negative,
    number,
    plain_array,
    shown,
    single,
    vector,
)
from ..errors import InputError
from ..fields import put
from .histories import CONSTANT, FunctionOfTime
from .loads import history_of


@dataclass(frozen=True)
class FollowerForce:
    """Force ``force * history(t)`` [N] that turns with a node.

    A number acts along the current normal p of a smooth node, ``f = force p/|p|``.  A vector (3,)
    acts at a junction, or at the centre of a rigid body, where it is ``force`` at the start and has
    constant components along ``t_1 = p_1``, ``t_3 ~ p_1 x p_2``, ``t_2 = t_3 x t_1`` of the first
    two directors of the node.  Directors are those of the generalized midpoint of a step, so the
    size of the force is constant; its work is ``f . dx``.
    """

    node: int
    force: object
    history: FunctionOfTime = CONSTANT

    def __post_init__(self):
        put(self, node=integer("follower force: node", self.node),
            history=history_of(self.history))
        check = number if single(self.force) else vector
        put(self, force=check(f"follower force at node {self.node}: force", self.force, "N"))

    @property
    def along_normal(self):
        """Whether it is a number, along the normal."""
        return isinstance(self.force, float)

    def vector(self, normals):
        """(3,) force at the start of a node with these initial ``normals`` (n, 3) [N]."""
        return self.force * normals[0] if self.along_normal else np.array(self.force)


@dataclass(frozen=True)
class Drag:
    """Drag of a medium of this density [kg/m^3] on elements: along their normals, quadratic.

    ``F = -1/2 density coefficient A |v_n| v_n n * history(t)`` of an element, a quarter at each
    node, ``v_n = n . (v - velocity)``, v the mean of the velocities of its nodes, ``A n = 1/2
    (x_3 - x_1) x (x_4 - x_2)`` its current vector area; all at the generalized midpoint of a step.
    ``velocity`` [m/s] is that of the medium.  In a medium at rest it takes energy in every step of
    the schemes that conserve (``quasi`` with rho_inf = 1, ``exact``); at rest in a medium that
    moves it is the pressure of a wind.  ``elements`` None means all.
    """

    coefficient: float
    density: float
    elements: tuple = None
    velocity: tuple = (0.0, 0.0, 0.0)
    history: FunctionOfTime = CONSTANT

    def __post_init__(self):
        put(self, coefficient=not_negative("drag: coefficient", self.coefficient),
            density=not_negative("drag: density", self.density, "kg/m^3"),
            velocity=vector("drag: velocity", self.velocity, "m/s"),
            history=history_of(self.history))
        if self.elements is not None:
            put(self, elements=distinct("drag: elements", self.elements))


@dataclass(frozen=True, repr=False)
class UserForce:
    """Forces ``function(t, x, v, p) * history(t)`` [N] on all nodes, (n_nodes, 3).

    t is the time [s], in statics the load factor; x (n_nodes, 3) [m], v (n_nodes, 3) [m/s] and p
    (n_directors, 3) are positions, velocities and normals at the generalized midpoint of a step,
    not to be written to; v is zero in statics.  The function must be pure: an iteration calls it
    many times.  Its derivative is not known to the matrix, so the iteration converges linearly,
    and only while the forces change less in a correction than the shell's own: stiff ones need a
    small dt.  ``Model`` calls it once, at the initial configuration.

    A result is of the function's name, source, defaults and of what it closes over, not of what it
    takes from its module; functions without source text are told apart by their names only.
    """

    function: Callable
    history: FunctionOfTime = CONSTANT

    def __post_init__(self):
        put(self, history=history_of(self.history))
        function("user force: function", self.function)
        try:
            signature = inspect.signature(self.function)
            signature.bind(*"txvp")
        except TypeError:
            raise InputError(f"{self.name}: its arguments must be (t, x, v, p), are "
                             f"{_short(str(signature))}") from None
        except ValueError:  # one of another language, which does not tell
            pass

    @property
    def name(self):
        """Of the function, for messages."""
        given = getattr(self.function, "__qualname__", type(self.function).__qualname__)
        return f"user force {given}"

    def __repr__(self):
        return f"UserForce({identity(self.function)}, {self.history!r})"

    def forces(self, t, x, v, p):
        """(n_nodes, 3) of the function, at arrays that it cannot write to [N].

        Raises:
            InputError: it fails, or gives something else.
        """
        arrays = [np.asarray(a).view() for a in (x, v, p)]
        for array in arrays:
            array.flags.writeable = False
        try:
            given = self.function(t, *arrays)
        except Exception as error:
            raise InputError(f"{self.name}: {type(error).__name__} at t = {t:g} s: "
                             f"{_short(str(error))}") from error
        found = plain_array(self.name, given, f"{len(x)}, 3")
        if found.shape != x.shape or found.dtype.kind not in "iuf":
            what = f"shape {found.shape}" if found.dtype.kind in "iuf" else shown(given)
            raise InputError(f"{self.name}: forces must be an array ({len(x)}, 3) of numbers, are "
                             f"{what}")
        return found.astype(float, copy=False)

    def check(self, nodes, velocity, normals):
        """Call it at the initial configuration.

        Raises:
            InputError: as of ``forces``, or a force is not finite.
        """
        floats(self.name, self.forces(0.0, nodes, velocity, normals), nodes.shape)


def _short(text):
    """The start of a text, in one line."""
    text = " ".join(text.split())
    return text if len(text) <= 80 else f"{text[:76]} ..."


def identity(called):
    """What tells a function from another in results: its name, and a digest of its source, its
    defaults and what it closes over, holds or is bound to, as far as these are numbers, texts and
    arrays."""
    bound = getattr(called, "__func__", called)
    owner = bound if hasattr(bound, "__qualname__") else type(bound)
    try:
        source = inspect.getsource(owner)
    except (OSError, TypeError):
        source = ""
    held = [getattr(bound, name, None) for name in ("__defaults__", "__kwdefaults__", "__dict__")]
    held += [_content(cell) for cell in getattr(bound, "__closure__", None) or ()]
    held += [getattr(called, name, None) for name in ("func", "args", "keywords", "__self__")]
    digest = hashlib.sha256("; ".join([source, *map(_plain, held)]).encode())
    name = getattr(owner, "__qualname__", type(owner).__qualname__)
    return f"{owner.__module__}.{name} {digest.hexdigest()}"


def _content(cell):
    """What a cell of a closure holds, None if nothing yet."""
    try:
        return cell.cell_contents
    except ValueError:
        return None


def _plain(value):
    """A value as text that is the same in another process."""
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape} {hashlib.sha256(value.tobytes()).hexdigest()}"
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(_plain, value))}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{key}: {_plain(value[key])}' for key in sorted(value, key=str))}}}"
    if isinstance(value, bool | int | float | str | np.generic | None):
        return repr(value)
    if inspect.isfunction(value):
        return identity(value)
    held = getattr(value, "__dict__", {})
    return type(value).__qualname__ + _plain({
        name: one if isinstance(one, np.ndarray | bool | int | float | str) else type(one).__name__
        for name, one in held.items()})
