"""From unknowns to positions and normals: numbering, coordinates, the discrete system, matrices."""
