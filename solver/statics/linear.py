"""Linear statics."""

import numpy as np
from threadpoolctl import threadpool_limits

from ..errors import InputError
from ..model.model import Model
from ..signatures import checked
from ..system.failure import SingularMatrix
from .equilibrium import Equilibrium
from .settings import StaticSettings


@checked
@threadpool_limits.wrap(limits=1)
def solve_linear(model: Model, solver="skyline"):
    """Linear solution K(0) U = F(t = 1) from the initial configuration, K(0) without loads.

    Args:
        model: ``Model`` with supports.
        solver: the linear solver, as of ``StaticSettings``.

    Returns:
        (displacement (n_nodes, 3) [m], change of the normals (n_nodes, 3)).

    Raises:
        InputError: the supports leave a rigid motion or a mechanism free.
    """
    equilibrium = Equilibrium(model, StaticSettings(solver=solver))
    try:
        correction = equilibrium.solve_increment(equilibrium.prescribed(1.0), 1.0,
                                                 stiffness_at=0.0)
    except SingularMatrix as error:
        raise InputError(f"the shell is a mechanism: {error}") from None
    nodes, A1 = equilibrium.system.dofs.nodes, equilibrium.place.start.A1
    displacement = correction[equilibrium.system.translations]
    change = np.stack([A1[d, :, :n] @ correction[first + 3:first + 3 + n]
                       for d, first, n in zip(nodes.first, nodes.start, nodes.n_rot)])
    return displacement, change
