"""Linear statics."""

import numpy as np

from .equilibrium import Equilibrium
from .settings import StaticSettings


def solve_linear(model, solver="skyline"):
    """Linear solution K(0) U = F(t = 1) from the initial configuration.

    Args:
        model: ``Model`` with supports.
        solver: the linear solver, as of ``StaticSettings``.

    Returns:
        (displacement (n_nodes, 3) [m], change of the normals (n_nodes, 3)).

    Raises:
        InputError: the supports leave a rigid motion or a mechanism free.
    """
    equilibrium = Equilibrium(model, StaticSettings(solver=solver))
    correction = equilibrium.solve_increment(equilibrium.prescribed(1.0), 1.0)
    nodes, A1 = equilibrium.system.dofs.nodes, equilibrium.place.start.A1
    displacement = correction[nodes.start[:, None] + np.arange(3)]
    change = np.stack([A1[d, :, :n] @ correction[first + 3:first + 3 + n]
                       for d, first, n in zip(nodes.first, nodes.start, nodes.n_rot)])
    return displacement, change
