"""Linear buckling about a state: critical load factors and their shapes."""

from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from ..errors import InputError, StepError
from ..model.histories import CONSTANT
from ..model.model import Model
from ..results.frame import table
from ..signatures import Count, checked
from ..statics.equilibrium import Equilibrium
from ..statics.settings import DEFAULT
from ..system.failure import told
from ..system.linear import UnsymmetricLU, diagonal_lu
from ..system.loads import at_factor
from .eigen import most_negative
from .matrices import free_matrix, of_all, symmetric
from .result import Shapes, shape_fields
from .vibration import base


@dataclass(frozen=True, eq=False, repr=False)
class Buckling(Shapes):
    """Buckling shapes, each with a largest displacement of 1.

    Attributes:
        factors: (n,) critical load factors, ascending.
        factor: load factor of the state.
    """

    factors: np.ndarray
    factor: float

    def __repr__(self):
        return f"<Buckling: {len(self)} from load factor {self.factors[0]:.6g}>"

    def names(self):
        """Number and load factor of each shape."""
        return [f"shape {k + 1}: load factor {f:.6g}" for k, f in enumerate(self.factors)]

    def frame(self):
        """The critical load factors as a ``pandas.DataFrame``."""
        return table({"factor": self.factors})


@checked
@threadpool_limits.wrap(limits=1)
def buckling(model: Model, n: Count = 1, state: object = None, factor: float = None):
    """Critical load factors ``lambda_0 + lambda`` by ``(K + lambda K_g) v = 0`` about a state.

    K is the tangent in the state, at the load factor lambda_0.  K_g is what the stress of the
    linear response ``K du = dF`` to a unit of the load factor adds to it, with the stiffness of
    loads that follow the shell.  About the initial shell this is the classical linear buckling;
    about a state near the critical one it misses no change of shape before.

    Args:
        model: ``Model`` with supports and loads, or prescribed displacements.
        n: how many of the lowest factors above that of the state.
        state: as of ``modes``.
        factor: as of ``modes``.

    Returns:
        ``Buckling``, with fewer than n where there are fewer.

    Warns:
        AccuracyWarning: the loads' stiffness is not symmetric.

    Raises:
        InputError: a load has a function of time of its own, nothing acts, or a rigid motion is
            left free.
        StepError: the state is unstable, no factor is critical, or none was found.
    """
    if any(item.history != CONSTANT for item in (*model.loads, *model.supports)):
        raise InputError("buckling needs loads and prescribed displacements without a history of "
                         "their own")
    if any(getattr(item, "turning", CONSTANT) != CONSTANT for item in model.supports):
        raise InputError("buckling needs drives without a function of time of their turning")
    if any(getattr(joint, "driving", CONSTANT) != CONSTANT for joint in model.joints):
        raise InputError("buckling needs joints that are driven without a function of time of "
                         "their own")
    if model.heated and state is None:
        raise InputError("the sections are heated: give the state that heat alone brings about, "
                         "the row of load factor 0 of a path")
    start, factor = base(model, state, factor)
    equilibrium = Equilibrium(model, DEFAULT, start=start)
    system = equilibrium.system
    with told():
        equilibrium.lean(factor)
        response = _response(equilibrium, factor)
        system.take(UnsymmetricLU(system.numbering))
        equilibrium.assemble(factor)
        K = symmetric(system, free_matrix(system))
        held, negative = diagonal_lu(K)
    if negative:
        raise StepError(f"the state is unstable: its tangent has {negative} negative pivots")
    if not (np.any(response) or np.any(equilibrium.pull)):
        raise InputError("buckling needs a load that is not zero where no support holds")
    equilibrium.predict(response)
    system.foresee(equilibrium.state, response)
    if system.linked:
        system.linked.forces += equilibrium.pull
    if not (equilibrium.strained(response) or np.any(equilibrium.pull)):
        raise InputError("the loads cause no stress: nothing can buckle")
    equilibrium.assemble(factor + 1.0, mixed=True)
    K_g = symmetric(system, free_matrix(system)) - K
    values, vectors = most_negative(K_g, K, n, held.solve)
    if not len(values):
        raise StepError("no load factor above that of the state is critical")
    u, p, energy = shape_fields(system, equilibrium.state, equilibrium.place,
                                of_all(system, vectors))
    sizes = 1.0 / np.linalg.norm(u, axis=2).max(axis=1)[:, None]
    return Buckling(model, system.displacement(equilibrium.state), sizes[..., None] * u,
                    sizes[..., None] * p, sizes**2 * energy, factor - 1.0 / values,
                    factor)


def _response(equilibrium, factor):
    """Linear response (n_dof,) to one more of the load factor."""
    pushed = equilibrium.system.driven.linear(equilibrium.state, equilibrium.place.start,
                                              at_factor(1.0), at_factor(factor))
    return equilibrium.solve_increment(pushed, factor + 1.0, stiffness_at=factor)
