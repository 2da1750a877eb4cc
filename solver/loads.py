"""Line, surface and edge-moment loads as consistent nodal loads of the initial configuration."""

import numpy as np

from .element import GAUSS, shape_functions
from .model import CONSTANT, NodalLoad, NodalMoment


def line_load(nodes, line, force, history=CONSTANT):
    """Dead force per length [N/m] along the element edges between consecutive nodes of ``line``.

    ``f_i = q int N_i dL`` with the linear shape functions of an edge: half of q L to either end.
    """
    return [NodalLoad(i, tuple(share * np.asarray(force, dtype=float)), history)
            for i, share in _line_shares(nodes, line).items()]


def line_moment(nodes, line, moment, history=CONSTANT):
    """Moment per length [N m/m] about fixed axes along the edges of ``line``."""
    return [NodalMoment(i, tuple(share * np.asarray(moment, dtype=float)), history)
            for i, share in _line_shares(nodes, line).items()]


def surface_load(nodes, quads, force, history=CONSTANT):
    """Dead force per initial area [N/m^2] on the elements ``quads``: ``f_i = q int N_i dA``."""
    nodes, quads = np.asarray(nodes, dtype=float), np.asarray(quads)
    shares = np.zeros(len(nodes))
    for point in GAUSS:
        shape, natural = shape_functions(point)
        tangents = np.einsum("ai,eic->aec", natural, nodes[quads])
        area = np.linalg.norm(np.cross(tangents[0], tangents[1]), axis=1)
        for i in range(4):
            np.add.at(shares, quads[:, i], shape[i] * area)
    return [NodalLoad(int(i), tuple(shares[i] * np.asarray(force, dtype=float)), history)
            for i in np.unique(quads)]


def _line_shares(nodes, line):
    """Length that belongs to each node of a polyline of element edges [m]."""
    points = np.asarray(nodes, dtype=float)[list(line)]
    shares = {int(i): 0.0 for i in line}
    for i, j, length in zip(line[:-1], line[1:], np.linalg.norm(np.diff(points, axis=0), axis=1)):
        shares[int(i)] += 0.5 * length
        shares[int(j)] += 0.5 * length
    return shares
