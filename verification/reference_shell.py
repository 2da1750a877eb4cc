"""Linear statics of a whole shell from the independent element, in director coordinates.

Nothing is shared with the solver but the data of the model: the stiffness is the Hessian of
``energy`` at rest, and normals turn in the plane that is
tangential to them, without rotational variables.
"""

import numpy as np
from scipy.linalg import null_space
from scipy.sparse import block_diag, coo_array, csc_array
from scipy.sparse.linalg import spsolve

from . import reference_element
from .jets import Jet


def solve_linear(model, **forms):
    """Linear solution as ``solve_linear`` gives it, for nodal forces.

    Args:
        model: ``Model``.
        forms: ``membrane`` and ``shear`` of the reference element.

    Returns:
        (displacement (n_nodes, 3) [m], change of the normals (n_nodes, 3)).
    """
    free = csc_array(block_diag([_free_directions(normal, fixed)
                                 for normal, fixed in zip(model.normals, model.fixed)]))
    force = np.zeros((len(model.nodes), 6))
    for load in model.loads:
        force[load.node, :3] += load.force
    K = free.T @ stiffness(model, **forms) @ free
    change = (free @ spsolve(csc_array(K), free.T @ force.ravel())).reshape(-1, 6)
    return change[:, :3], change[:, 3:]


def stiffness(model, **forms):
    """Stiffness at rest (6 n_nodes, 6 n_nodes) on (x_i, p_i), node by node, sparse."""
    dofs = (6 * model.quads[:, :, None] + np.arange(6)).reshape(-1, 24)
    blocks = np.empty((len(dofs), 24, 24))
    for k, quad in enumerate(model.quads):
        X, P = model.nodes[quad], model.normals[quad]
        q = Jet.variables(np.hstack([X, P]).ravel()).reshape(4, 6)
        blocks[k] = reference_element.energy(q[:, :3], q[:, 3:], X, P, model.thickness[k],
                                             model.youngs[k], model.poisson[k], **forms).hessian
    n = 6 * len(model.nodes)
    rows, columns = np.repeat(dofs, 24, axis=1), np.tile(dofs, (1, 24))
    return coo_array((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(n, n)).tocsc()


def _free_directions(normal, fixed):
    """Orthonormal (6, n) directions in which a node may move: unit normal kept, supports held."""
    held = np.eye(6)[fixed]
    return null_space(np.vstack([np.r_[np.zeros(3), normal], held]))
