"""How far a motion is from its own mirror image."""

import numpy as np
from scipy.spatial import cKDTree


def asymmetry(nodes, displacement, axis):
    """Largest |u(mirrored X) - mirrored u(X)| of each frame, for the plane normal to an axis.

    Args:
        nodes: (n_nodes, 3) initial places [m], symmetric about the plane.
        displacement: (n_frames, n_nodes, 3) [m].
        axis: 0, 1 or 2; the plane goes through the origin.

    Returns:
        (n_frames,) [m].
    """
    mirror = np.ones(3)
    mirror[axis] = -1.0
    distance, partner = cKDTree(nodes).query(nodes * mirror)
    assert distance.max() < 1e-9 * np.abs(nodes).max()
    return np.abs(displacement[:, partner] - displacement * mirror).max(axis=(1, 2))
