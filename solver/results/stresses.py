"""Stresses of a configuration, recovered from the fields that the element's energy is made of.

Forces and moments per length act in the axes of an element, e_z along its normal (the side of
``top``), ``z`` the height above its mid-surface:

    n = int sigma dz [N/m]      m = int sigma z dz [N]      q = int (tau_xz, tau_yz) dz [N/m]

with components (xx, yy, xy) and (xz, yz).  Tension is positive; a positive m_xx pulls at the top,
and bends the strip along x so that its ends go down; of a positive q_xz, what lies towards +x pulls
up what lies towards -x.
Equilibrium of a plate reads ``n_ij,j + b_i = 0``, ``m_ij,j = q_iz``, ``q_iz,i + p = 0``.

They are second Piola-Kirchhoff stresses, per initial length, in axes that turn with the element;
where strains are small those of any other measure.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, NamedTuple

import numpy as np

from ..checks import flag, floats, plain_array, vector
from ..errors import InputError
from ..model.constants import apart, in_surface, local_frames
from ..model.joints import places_of
from ..model.model import Model
from ..signatures import checked

LEVELS = ("top", "middle", "bottom")
"""Heights of the columns of ``Stresses.von_mises``: h/2, 0, -h/2."""

STEP = 1e-30
"""Complex step of the linear measures: exact, as nothing is subtracted."""


class Configuration(NamedTuple):
    """Where a shell is, all of its normals included.

    Attributes:
        displacement: (n_nodes, 3) [m].
        directors: (n_directors, 3) unit normals, or their changes where it is linear.
        linear: whether both are small, and strains linear in them.
        velocity: (n_nodes, 3) [m/s]; None at rest.
        director_rates: (n_directors, 3) [1/s]; None at rest.
        hinges: (n, 2) of every place at which a joint has a moment or a drive its angle [rad] and
            whether its latch holds, 1 or 0; None where all are within half a turn and none holds.
    """

    displacement: np.ndarray
    directors: np.ndarray
    linear: bool = False
    velocity: np.ndarray = None
    director_rates: np.ndarray = None
    hinges: np.ndarray = None


@dataclass(frozen=True, eq=False, repr=False)
class Stresses:
    """Forces, moments and stresses, an element or, of ``nodal``, a director a row.

    Attributes:
        n: (n, 3) membrane forces xx, yy, xy [N/m].
        m: (n, 3) moments xx, yy, xy [N].
        q: (n, 2) transverse shear forces xz, yz [N/m].
        axes: (n, 3, 3) present directions of x, y, z, rows.
        thickness: (n,) h [m].
        vertices: (n_elem, 4) director of every vertex; None of nodal values.
        directors: (n_directors, 3) present unit normals.
    """

    n: np.ndarray
    m: np.ndarray
    q: np.ndarray
    axes: np.ndarray
    thickness: np.ndarray
    vertices: np.ndarray | None
    directors: np.ndarray

    def __repr__(self):
        where = "directors" if self.vertices is None else "elements"
        return f"<Stresses: {len(self.n)} {where}, von Mises {self.von_mises.max():.6g} Pa at most>"

    @property
    def top(self):
        """(n, 3) ``n/h + 6 m/h^2`` at z = h/2: xx, yy, xy [Pa]."""
        return self.middle + 6.0 * self.m / self.thickness[:, None] ** 2

    @property
    def middle(self):
        """(n, 3) ``n/h`` [Pa]."""
        return self.n / self.thickness[:, None]

    @property
    def bottom(self):
        """(n, 3) ``n/h - 6 m/h^2`` at z = -h/2 [Pa]."""
        return self.middle - 6.0 * self.m / self.thickness[:, None] ** 2

    @property
    def shear(self):
        """(n, 2) ``3/2 q/h`` at the middle, xz and yz, of a parabola that is zero at top and bottom
        [Pa]."""
        return 1.5 * self.q / self.thickness[:, None]

    @cached_property
    def von_mises(self):
        """(n, 3) at top, middle and bottom:
        ``sqrt(s_xx^2 - s_xx s_yy + s_yy^2 + 3 (s_xy^2 + s_xz^2 + s_yz^2))`` [Pa]."""
        squares = [s[:, 0] ** 2 - s[:, 0] * s[:, 1] + s[:, 1] ** 2 + 3.0 * s[:, 2] ** 2
                   for s in (self.top, self.middle, self.bottom)]
        squares[1] += 3.0 * np.sum(self.shear**2, axis=1)
        return np.sqrt(np.stack(squares, axis=1))

    def principal(self):
        """Principal stresses in the surface, at top, middle and bottom.

        ``s_12 = (s_xx + s_yy)/2 +- sqrt((s_xx - s_yy)^2/4 + s_xy^2)``

        Returns:
            (n, 3, 2) the larger and the smaller one [Pa], and (n, 3, 3) the direction of the larger
            one.
        """
        s = np.stack([self.top, self.middle, self.bottom], axis=1)
        mean, half = 0.5 * (s[..., 0] + s[..., 1]), 0.5 * (s[..., 0] - s[..., 1])
        radius, angle = np.hypot(half, s[..., 2]), 0.5 * np.arctan2(s[..., 2], half)
        along = np.stack([np.cos(angle), np.sin(angle)], axis=2)
        return (np.stack([mean + radius, mean - radius], axis=2),
                np.einsum("nla,nac->nlc", along, self.axes[:, :2]))

    def nodal(self):
        """Means of the elements around every node, a row a director: plates that meet at a fold are
        not mixed.  Those of node i are rows ``model.directors.first[i]`` to ``first[i + 1] - 1``.

        x is that of the first element around the node, along the surface; what the others have is
        turned into its direction, so that a curved surface loses nothing.  Rows of rigid bodies,
        the last ones, are zero, with the global axes and the last thickness.
        """
        if self.vertices is None:
            return self
        order = np.argsort(self.vertices, axis=None, kind="stable")
        uses = np.bincount(self.vertices.ravel())
        begins = np.cumsum(uses) - uses
        axes = _axes(self.axes[order[begins] // 4, 0], self.directors[:len(uses)])

        def mean(values):
            return np.add.reduceat(values.reshape(len(order), -1)[order], begins) / uses[:, None]

        # x of the nodes in the axes of the elements, (n_elem, 4, 2)
        along = unit(np.einsum("nac,nvc->nva", self.axes[:, :2], axes[self.vertices, 0]))
        n, m = (mean(turned(values[:, None], along)) for values in (self.n, self.m))
        q = mean(turned_vector(self.q[:, None], along))
        thickness = mean(np.repeat(self.thickness, 4))[:, 0]
        if bodies := len(self.directors) - len(uses):
            n, m, q = (np.pad(values, ((0, bodies), (0, 0))) for values in (n, m, q))
            axes = np.concatenate([axes, np.broadcast_to(np.eye(3), (bodies, 3, 3))])
            thickness = np.pad(thickness, (0, bodies), "edge")
        return replace(self, n=n, m=m, q=q, axes=axes, thickness=thickness, vertices=None)


def directions(name, value):
    """A direction (3,), or one for each element, (n_elem, 3); the largest component is 1."""
    rows = np.ndim(plain_array(name, value, "3")) == 2
    given = floats(name, value, (None, 3)) if rows else np.array(vector(name, value))
    largest = np.abs(given).max(axis=-1, keepdims=True)
    return given / np.where(largest > 0.0, largest, 1.0)


@checked
def stresses(model: Model, state: Configuration, axes: Annotated[np.ndarray, directions] = None):
    """Stresses at the centres of all elements.

    Args:
        model: ``Model``.
        state: ``Result.state``, one of ``StaticResult.states``, ``LinearResult.state``, or a frame
            of a file, ``Configuration(displacement, director)``.
        axes: direction of x, or (n_elem, 3) one for each element, projected on the initial
            elements, from where on it turns with them; left out, the x of the local frame of every
            element, Eq. (1), which follows its diagonals: neighbours then agree on a regular mesh
            only.

    Returns:
        ``Stresses``.

    Raises:
        InputError: an argument of another kind, a configuration of another model or one that has
            no stresses, or a direction along the normal of an element.
    """
    if axes is not None and axes.ndim == 2:
        axes = floats("axes", axes, (len(model.quads), 3))
    u = floats("state.displacement", state.displacement, model.nodes.shape)
    p = floats("state.directors", state.directors, model.normals.shape)
    with np.errstate(all="ignore"):
        if flag("state.linear", state.linear):
            e, b = (values.imag / STEP + values.real * model.heated for values in measures(
                model, 1j * STEP * u, model.normals + 1j * STEP * p))
            u, p = np.zeros_like(u), model.normals
        else:
            e, b = measures(model, u, p)
        found = recovered(model, e, b, u, p, axes)
        finite = np.isfinite(found.von_mises).all(axis=1)
    if not finite.all():
        raise InputError(f"state: element {np.argmin(finite)} has no stresses, its corners "
                         "coincide or are too far apart")
    return found


def configuration(name, model, given):
    """``given`` as a ``Configuration`` of ``model``, checked, with rates; ``name`` is what it is
    called in errors.

    Raises:
        InputError: it is linear, of another model, or a director is no unit vector.
    """
    if given.linear:
        raise InputError(f"{name} is a linear solution, which is no equilibrium: take a state of "
                         "load_control")
    u = floats(f"{name}.displacement", given.displacement, model.nodes.shape)
    p = floats(f"{name}.directors", given.directors, model.normals.shape)
    v, w = (floats(f"{name}.{of}", none if getattr(given, of) is None else getattr(given, of),
                   none.shape) for of, none in (("velocity", np.zeros_like(u)),
                                                ("director_rates", np.zeros_like(p))))
    off = np.abs(np.linalg.norm(p, axis=1) - 1.0)
    if off.max() > 1e-9:
        raise InputError(f"{name}.directors[{off.argmax()}] is no unit vector")
    hinges, places = given.hinges, places_of(model.joints)
    if not places:
        hinges = None
    if hinges is not None:
        if np.ndim(hinges) == 2 and len(hinges) != places:
            raise InputError(f"{name}.hinges: angles at {len(hinges)} places of joints, the model "
                             f"has {places}; of a state of other joints give none: "
                             f"Configuration({name}.displacement, {name}.directors)")
        hinges = floats(f"{name}.hinges", hinges, (places, 2))
    return Configuration(u, p, False, v, w, hinges)


def recovered(model, e, b, displacement, directors, axes=None):
    """``Stresses`` of measures e (n_elem, n_s) and b (n_elem, 11); see ``stresses``."""
    N, M, S, C = model.recovery
    n, m, q = (np.einsum("ers,es->er", *of) for of in ((N, e), (M, b), (S, b)))
    if C is not None:
        m += np.einsum("ers,es->er", C, e)
    frames = local_frames(_relative(model, displacement))
    if axes is not None:
        along = _seen(model, axes)
        n, m, q = turned(n, along), turned(m, along), turned_vector(q, along)
        frames[:, :2] = turned_vector(frames[:, :2].swapaxes(1, 2), along[:, None]).swapaxes(1, 2)
    return Stresses(n, m, q, frames, model.thickness, model.directors.vertices, directors)


def measures(model, displacement, directors):
    """Membrane measures e (n_elem, n_s) and variables b (n_elem, 11) of bending and shear, Eqs.
    (8), (10), as ``kernels.observation`` has them; analytic in its arguments."""
    elements, count = model.elements, len(model.quads)
    y0, r0, l, Q = (apart(groups, count) for groups in
                    (elements.y0, elements.r0, elements.l, elements.Q))
    corners = _relative(model, displacement)
    frames = local_frames(corners)
    t = np.einsum("eab,ekb->eka", frames, corners[:, 1:]) - y0
    dr = np.einsum("eab,eib->eia", frames[:, :2], directors[elements.directors]) - r0
    w = t[:, :, 2]
    e = np.einsum("eskc,ekc->es", l, t) + 0.5 * np.einsum("eskj,ek,ej->es", Q, w, w)
    if len(elements.coupling):
        e += np.einsum("esk,ek->es", apart(elements.coupling, count), dr.reshape(count, 8))
    return e, np.concatenate([w, dr.reshape(count, 8)], axis=1)


def _relative(model, displacement):
    """Corners of the elements relative to their first one, (n_elem, 4, 3) [m]."""
    x, u = model.nodes[model.quads], displacement[model.quads]
    return (x - x[:, :1]) + (u - u[:, :1])


def _seen(model, directions):
    """Directions in the initial axes x, y of each element: unit vectors (n_elem, 2)."""
    directions = np.broadcast_to(directions, (len(model.quads), 3))
    seen, steep = in_surface(model.nodes[model.quads], directions)
    if steep.any():
        k = np.argmax(steep)
        raise InputError(f"axes ({', '.join(f'{c:g}' for c in directions[k])}) are no direction in "
                         f"the surface of element {k}: they stand on it or are zero; each element "
                         "may have a direction of its own")
    return seen


def turned(values, along):
    """Components xx, yy, xy (..., 3) of tensors in axes whose x is ``along`` (..., 2)."""
    (c, s), (xx, yy, xy) = np.moveaxis(along, -1, 0), np.moveaxis(values, -1, 0)
    return np.stack([c * c * xx + s * s * yy + 2.0 * c * s * xy,
                     s * s * xx + c * c * yy - 2.0 * c * s * xy,
                     c * s * (yy - xx) + (c * c - s * s) * xy], axis=-1)


def turned_vector(values, along):
    """Components (..., 2) of vectors in axes whose x is ``along`` (..., 2)."""
    (c, s), (x, y) = np.moveaxis(along, -1, 0), np.moveaxis(values, -1, 0)
    return np.stack([c * x + s * y, c * y - s * x], axis=-1)


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def _axes(x, normals):
    """(n, 3, 3) axes, x as near to the given one as the normals z let it."""
    x = unit(x - np.sum(x * normals, axis=1, keepdims=True) * normals)
    return np.stack([x, np.cross(normals, x), normals], axis=1)
