"""Directors of a mesh: one normal a node, several where plates meet at a junction."""

from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..checks import floats
from ..errors import InputError
from ..names import listed
from .constants import CORNERS, shape_functions
from .mesh import check_connectivity, check_shapes, element_edges, node_numbers

LARGEST_DEVIATION = 40.0
"""Largest angle [degrees] between a nodal normal and the normals of the elements it averages."""

FOLD_ANGLE = 45.0
"""Neighbours whose normals differ by this angle [degrees] or more meet at a fold, a junction."""

LEAST_SPREAD = 0.02
"""Sine of the least angle (1 degree) between two plates of a junction: the nodal frame needs it."""


class Directors(NamedTuple):
    """Mid-surface normals of a mesh: one a node, several where plates meet at a junction.

    Attributes:
        normals: (n_directors, 3) unit vectors, node after node.
        first: (n_nodes + 1,) those of node i are ``first[i] .. first[i + 1] - 1``.
        vertices: (n_elem, 4) director of every vertex.
    """

    normals: np.ndarray
    first: np.ndarray
    vertices: np.ndarray


class Folds(NamedTuple):
    """How the edges between elements were decided: folds, or smooth.

    Attributes:
        folded: number of edges at which elements of different plates meet.
        smooth: number of the other edges that elements share.
        smallest_fold: smallest angle of a fold [degrees]; None without folds.
        largest_smooth: largest angle across a smooth edge [degrees]; None without them.
    """

    folded: int
    smooth: int
    smallest_fold: float | None
    largest_smooth: float | None


class _Pairs(NamedTuple):
    """Pairs of uses of one edge by two elements; a use is ``4 element + side``.

    Attributes:
        one, other: (n, 2) vertices (4 element + corner) of both elements at the ends of the edge.
        edge: (n,) number of the edge.
        same_way: (n,) whether both elements run through it in the same direction.
        alone: (n,) whether no third element has the edge.
    """

    one: np.ndarray
    other: np.ndarray
    edge: np.ndarray
    same_way: np.ndarray
    alone: np.ndarray

    @property
    def elements(self):
        """(n, 2) numbers of the elements."""
        return np.stack([self.one[:, 0], self.other[:, 0]], axis=1) // 4


def find_directors(nodes, quads, fold_angle=FOLD_ANGLE, patches=None):
    """Directors of all nodes: means of the unit element normals of a patch, Eqs. (13), (14).

    Around a node the elements fall into patches: neighbours across an edge belong together where
    their normals there differ by less than ``fold_angle`` [degrees], or where their numbers in
    ``patches`` (n_elem,) are the same.  A node with several patches is a junction.

    Raises:
        InputError: normals cancel or differ too much within a patch, all plates of a junction are
            coplanar, or an element is inverted against a neighbour of its patch.
    """
    normals = vertex_normals(nodes, quads)
    pairs = _pairs(quads)
    smooth, _ = _decided(pairs, normals, fold_angle, patches)
    _check_orientation(quads, pairs, smooth)
    joined = smooth & ~pairs.same_way
    links = np.stack([pairs.one[joined], pairs.other[joined]], axis=2).reshape(-1, 2)
    graph = coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(quads.size,) * 2)
    count, group = connected_components(graph, directed=False)
    node = np.empty(count, dtype=np.int64)
    node[group] = quads.ravel()
    order = np.argsort(node, kind="stable")
    rank = np.empty(count, dtype=np.int64)
    rank[order] = np.arange(count)
    node, vertices = node[order], rank[group].reshape(quads.shape)
    total = np.zeros((count, 3))
    np.add.at(total, vertices, normals)
    length = np.linalg.norm(total, axis=1)
    if np.any(length < 1e-6):
        raise InputError(f"node {node[np.argmin(length)]}: the normals of its elements cancel")
    mean = total / length[:, None]
    cosine = np.einsum("eic,eic->ei", normals, mean[vertices])
    angle = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
    if angle.max() > LARGEST_DEVIATION:
        element, vertex = np.unravel_index(np.argmax(angle), angle.shape)
        raise InputError(f"node {quads[element, vertex]}: the normal of element {element} is "
                         f"{angle.max():.0f} degrees from the mean of its patch there, at most "
                         f"{LARGEST_DEVIATION:g} make a smooth shell: refine the mesh")
    first = np.searchsorted(node, np.arange(len(nodes) + 1))
    return _spread(Directors(mean, first, vertices))


def find_folds(nodes, quads, fold_angle=FOLD_ANGLE, patches=None):
    """``Folds`` of a mesh, decided as by ``find_directors``."""
    pairs = _pairs(quads)
    smooth, angles = _decided(pairs, vertex_normals(nodes, quads), fold_angle, patches)
    smooth = smooth & ~pairs.same_way
    folds = len(np.unique(pairs.edge[~smooth]))
    return Folds(folds, len(np.unique(pairs.edge)) - folds,
                 float(angles[~smooth].min()) if folds else None,
                 float(angles[smooth].max()) if np.any(smooth) else None)


def fold_edges(nodes, quads, fold_angle=FOLD_ANGLE, patches=None):
    """(n, 2) nodes at the ends of the edges that ``find_folds`` calls folded."""
    pairs = _pairs(quads)
    smooth, _ = _decided(pairs, vertex_normals(nodes, quads), fold_angle, patches)
    folded = np.flatnonzero(~smooth | pairs.same_way)
    _, first = np.unique(pairs.edge[folded], return_index=True)
    return quads.ravel()[pairs.one[folded[first]]]


def orient(nodes, quads):
    """``quads`` with those turned that run against the first one of their part.

    Neighbours across an edge of two elements run through it in opposite directions then, and their
    normals are on one side of the shell, also beyond folds.

    Args:
        nodes: (n_nodes, 3) [m].
        quads: (n_elem, 4) node numbers, in order round each element.

    Returns:
        (n_elem, 4) node numbers.

    Raises:
        InputError: no mesh, a twisted element, or one side only, as a Moebius strip.
    """
    nodes = floats("nodes", nodes, (None, 3))
    quads = node_numbers(quads, len(nodes))
    check_connectivity(quads)
    check_shapes(nodes, quads)
    pairs = _pairs(quads)
    turned, one_sided = _turned(len(quads), pairs, pairs.alone)
    if np.any(one_sided):
        raise InputError(_one_sided(one_sided))
    return np.where(turned[:, None], quads[:, ::-1], quads)


def _pairs(quads):
    """``_Pairs`` of all edges that several elements have."""
    edges = element_edges(quads)
    ordered = np.sort(edges, axis=1)
    order = np.lexsort((ordered[:, 1], ordered[:, 0]))
    edge = np.cumsum(np.any(np.diff(ordered[order], axis=0, prepend=-1) != 0, axis=1)) - 1
    uses = np.bincount(edge)
    found = [np.flatnonzero(edge[shift:] == edge[:-shift]) for shift in range(1, uses.max())]
    first = np.concatenate([np.zeros(0, dtype=np.int64), *found])
    last = np.concatenate([np.zeros(0, dtype=np.int64),
                           *(at + shift for shift, at in enumerate(found, 1))])
    one, other = order[first], order[last]
    same_way = edges[one, 0] == edges[other, 0]
    there = np.stack([_next(other), other], axis=1)
    there[same_way] = there[same_way, ::-1]
    return _Pairs(np.stack([one, _next(one)], axis=1), there, edge[first], same_way,
                  uses[edge[first]] == 2)


def _next(vertices):
    """The next vertex of the same element, of numbers ``4 element + corner``."""
    return vertices - vertices % 4 + (vertices + 1) % 4


def _decided(pairs, normals, fold_angle, patches):
    """Which pairs are smooth, and the larger angle between the normals at either end [degrees].

    At a junction, plates on either side that go on smoothly but have opposite normals count as two.
    """
    flat = normals.reshape(-1, 3)
    cosine = np.einsum("nec,nec->ne", flat[pairs.one], flat[pairs.other]).T
    cosine = np.where(pairs.same_way, -cosine, cosine).min(axis=0)
    one, other = pairs.elements.T
    smooth = (cosine > np.cos(np.radians(fold_angle)) if patches is None
              else patches[one] == patches[other])
    return smooth, np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))


def _check_orientation(quads, pairs, smooth):
    """Raise ``InputError`` for elements that are inverted against their neighbours in a patch."""
    smooth = smooth & pairs.alone
    wrong = np.flatnonzero(smooth & pairs.same_way)
    if not len(wrong):
        return
    turned, one_sided = _turned(len(quads), pairs, smooth)
    if np.any(one_sided):
        raise InputError(_one_sided(one_sided))
    turned = np.flatnonzero(turned)
    k, (one, other) = wrong[0], pairs.elements[wrong[0]]
    start, end = quads.ravel()[pairs.one[k]]
    raise InputError(
        f"inverted against their neighbours: element{'s' * (len(turned) > 1)} {listed(turned)}; "
        f"elements {one} and {other} both run from node {start} to node {end} "
        "(corovec.orient turns them)")


def _turned(n_elem, pairs, needed):
    """Which elements must be turned so that all ``needed`` pairs run in opposite directions, the
    first one of each part staying, and which are on a part with one side only.

    Each element is there twice, as it is and turned; what must go together is linked.
    """
    one, other = pairs.elements[needed].T
    shift = np.where(pairs.same_way[needed], n_elem, 0)
    ends = np.concatenate([one, one + n_elem]), np.concatenate([other + shift,
                                                                other + n_elem - shift])
    graph = coo_array((np.ones(len(ends[0])), ends), shape=(2 * n_elem,) * 2)
    _, group = connected_components(graph, directed=False)
    return group[:n_elem] > group[n_elem:], group[:n_elem] == group[n_elem:]


def _one_sided(elements):
    """What is said of a part that cannot be oriented."""
    return ("the shell has one side only, as a Moebius strip: no order of the nodes lets all "
            f"neighbours agree on it, elements {listed(np.flatnonzero(elements))}; cut it, or let "
            "it fold")


def _spread(directors):
    """The same directors, those of a junction ordered so that its first two are least parallel.

    Raises:
        InputError: the plates of a junction are coplanar.
    """
    normals, first, vertices = directors
    swapped = np.arange(len(normals))
    for i in np.flatnonzero(np.diff(first) > 1):
        members = np.arange(first[i], first[i + 1])
        pairs = list(combinations(members, 2))
        sizes = [np.linalg.norm(np.cross(normals[a], normals[b])) for a, b in pairs]
        best = int(np.argmax(sizes))
        if sizes[best] < LEAST_SPREAD:
            raise InputError(f"node {i}: the {len(members)} plates that meet there are coplanar, "
                             "no junction: let them share an edge, in one patch")
        swapped[members] = [*pairs[best], *(m for m in members if m not in pairs[best])]
    back = np.argsort(swapped)
    return Directors(normals[swapped], first, back[vertices])


def vertex_normals(nodes, quads):
    """(n_elem, 4, 3) unit normals of the elements at their vertices."""
    return np.stack([_normals_at(nodes[quads], corner) for corner in CORNERS], axis=1)


def _normals_at(corners, corner):
    """Unit normals (n_elem, 3) of the bilinear surfaces at one corner, Eq. (13)."""
    _, natural = shape_functions(corner)
    d_xi, d_eta = np.einsum("ai,eic->aec", natural, corners)
    normal = np.cross(d_xi, d_eta)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)
