"""Mass, centre and inertia of a shell, with the consistent mass of its elements."""

from typing import NamedTuple

import numpy as np


class MassProperties(NamedTuple):
    """Of a rigid body that has the shape of the initial shell.

    Attributes:
        mass: [kg].
        centre: (3,) of mass [m].
        inertia: (3, 3) about the centre, ``J = inertia omega`` [kg m^2].
    """

    mass: float
    centre: np.ndarray
    inertia: np.ndarray


def mass_properties(elements, nodes, normals, bodies=()):
    """``MassProperties`` by Eqs. (40a), (40b).

    ``I = sum_ij m_ij s(x_i, x_j) + I_ij s(p_i, p_j) + c_ij (s(x_i, p_j) + s(p_i, x_j))``,
    ``s(a, b) = a . b 1 - b a^T``, as ``a x (omega x b) = s(a, b) omega``; c_ij is the mass that is
    eccentric.  Rigid ``bodies`` are added.
    """
    m = elements.mass
    x, p = nodes[elements.nodes], normals[elements.directors]
    own = np.array([body.mass for body in bodies])
    centres = np.array([body.centre for body in bodies]).reshape(-1, 3)
    mass = m.sum() + own.sum()
    centre = (np.einsum("eij,ejc->c", m, x) + own @ centres) / mass
    eccentric = elements.eccentric
    if len(eccentric):
        centre += np.einsum("eij,ejc->c", eccentric, p) / mass
    arms = x - centre
    spread = (np.einsum("eij,eic,ejd->cd", m, arms, arms)
              + np.einsum("eij,eic,ejd->cd", elements.rotary, p, p))
    if len(eccentric):
        mixed = np.einsum("eij,eic,ejd->cd", eccentric, arms, p)
        spread += mixed + mixed.T
    spread += (centres - centre).T @ (own[:, None] * (centres - centre))
    for body in bodies:
        spread += body.directions.T @ np.diag(body.spread) @ body.directions
    return MassProperties(float(mass), centre, np.trace(spread) * np.eye(3) - spread)
