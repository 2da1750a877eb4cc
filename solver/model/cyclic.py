"""Cyclic symmetry: one sector stands for all, its two edges moving alike but for a turn."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from ..checks import integer, vector
from ..errors import InputError
from ..fields import put

NEAR = 1e-6
"""Distance, in sizes of the shell, up to which a node is where another one is turned to."""

ALIKE = 1e-9
"""Difference of velocities of the two edges, relative, that is none."""


@dataclass(frozen=True)
class Cyclic:
    """The shell is one of ``sectors`` equal ones about an ``axis`` through the point ``about`` [m].

    A node x_m on one edge and x_s on the other, x_m turned by 2 pi / sectors, move alike:
    ``dx_s = R dx_m``, ``p_s = R p_m``.  Loads, supports and velocities are those of every sector,
    turned.  Only motions with this symmetry are computed: no buckling, no mode and no motion in
    which sectors differ.  Energies, masses and loads are those of one sector; reactions include
    what the neighbours do to its edges.
    """

    sectors: int
    axis: tuple = (0.0, 0.0, 1.0)
    about: tuple = (0.0, 0.0, 0.0)

    def __post_init__(self):
        sectors = integer("cyclic: sectors", self.sectors)
        axis = vector("cyclic: axis", self.axis)
        if sectors < 2:
            raise InputError(f"cyclic: sectors must be 2 or more, is {sectors}")
        if not any(axis):
            raise InputError("cyclic: axis must not be zero")
        put(self, sectors=sectors, axis=axis, about=vector("cyclic: about", self.about, "m"))

    @property
    def direction(self):
        """(3,) unit vector along the axis."""
        return np.array(self.axis) / np.linalg.norm(self.axis)

    @property
    def rotation(self):
        """R (3, 3), by the angle of a sector."""
        return Rotation.from_rotvec(2.0 * np.pi / self.sectors * self.direction).as_matrix()

    def arms(self, x):
        """(n, 3) from the axis to points x, at right angles [m]."""
        arms = np.asarray(x) - self.about
        return arms - np.outer(arms @ self.direction, self.direction)


class Pairs(NamedTuple):
    """Nodes of the two edges of a sector.

    Attributes:
        rotation: R (3, 3), ``x_s = R x_m`` about the axis.
        masters: (n,) nodes of the one edge.
        slaves: (n,) those of the other, in this order.
        directors: (2, k) their directors, those of masters first.
    """

    rotation: np.ndarray
    masters: np.ndarray
    slaves: np.ndarray
    directors: np.ndarray

    def differ(self, values, of=None):
        """Whether vectors (n_nodes, 3) of slaves are not R times those of masters; ``of``: instead
        of ``directors``."""
        one, other = (self.masters, self.slaves) if of is None else of
        off = np.abs(values[other] - values[one] @ self.rotation.T).max()
        return off > ALIKE * (1.0 + np.abs(values).max())

    def summed(self, values, of=None):
        """The same vectors with sums of both edges on each, ``v_m + R^T v_s`` and that turned."""
        one, other = (self.masters, self.slaves) if of is None else of
        total = np.array(values)
        total[one] += values[other] @ self.rotation
        total[other] = total[one] @ self.rotation.T
        return total


def find_pairs(cyclic, nodes, quads, directors, limit):
    """``Pairs`` of a sector: nodes where another one is turned to.

    Args:
        cyclic: ``Cyclic``.
        nodes, quads: of the mesh.
        directors: ``Directors``.
        limit: largest angle between normals of the two edges [degrees], one of them turned.

    Raises:
        InputError: there are none, they are not one to one along two edges, one is on the axis, or
            a fold is along the edges.
    """
    size = np.ptp(nodes, axis=0).max()
    turned = (nodes - cyclic.about) @ cyclic.rotation.T + cyclic.about
    distance, found = cKDTree(nodes).query(turned)
    masters = np.flatnonzero(distance <= NEAR * size)
    slaves = found[masters]
    angle = 360.0 / cyclic.sectors
    if not len(masters):
        raise InputError(f"cyclic: no node is where another one is turned to by {angle:g} degrees")
    near = np.linalg.norm(cyclic.arms(nodes), axis=1) <= NEAR * size
    if np.any(near):
        raise InputError(f"cyclic: node {int(np.argmax(near))} is on the axis")
    both = np.intersect1d(masters, slaves)
    if len(both):
        raise InputError(f"cyclic: nodes on both sides of node {both[0]} are {angle:g} degrees "
                         "from it, the mesh must be one sector")
    _check_edges(quads, masters, slaves)
    R = cyclic.rotation
    return Pairs(R, masters, slaves, _pair_directors(R, masters, slaves, directors, limit))


def _check_edges(quads, masters, slaves):
    """The element edges between masters are those between slaves, and each has one."""
    ends = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
    place = np.full(quads.max() + 1, -1)
    edges = []
    for side in (masters, slaves):
        place[:] = -1
        place[side] = np.arange(len(side))
        own = np.sort(place[ends], axis=1)
        edges.append(set(map(tuple, own[own[:, 0] >= 0].tolist())))
    lonely = np.setdiff1d(np.arange(len(masters)), np.array(list(edges[0] & edges[1])).ravel())
    if edges[0] != edges[1] or len(lonely):
        pair = next(iter(edges[0] ^ edges[1]), lonely[:1])[0]
        raise InputError(f"cyclic: the mesh along the edges differs at nodes {masters[pair]} and "
                         f"{slaves[pair]}")


def _pair_directors(rotation, masters, slaves, directors, limit):
    """(2, k) directors of masters and slaves that are the same one, turned."""
    first, normals, found = directors.first, directors.normals, []
    for m, s in zip(masters, slaves):
        of_m, of_s = (np.arange(first[i], first[i + 1]) for i in (m, s))
        cosines = normals[of_m] @ rotation.T @ normals[of_s].T
        match = np.argmax(cosines, axis=1)
        if (len(of_m) != len(of_s) or len(set(match)) < len(of_m)
                or cosines.max(axis=1).min() < np.cos(np.radians(limit))):
            raise InputError(f"cyclic: the plates at nodes {m} and {s} do not go on smoothly from "
                             "sector to sector: have folds inside of one")
        found.append([of_m, of_s[match]])
    return np.concatenate(found, axis=1)
