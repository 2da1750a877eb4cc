"""Places of a model file on its mesh: nodes and elements that are given by points or by names."""

import numpy as np
from pydantic import model_validator

from ..model.mesh import node_at
from .values import Line, Name, Number, Point, Strict, in_unit, only_one

Range = Number | tuple[Number, Number]


class Where(Strict):
    """Nodes by their coordinates: a number, or the two ends of a range [m].

    Attributes:
        x: of the nodes.
        y: of the nodes.
        z: of the nodes.
    """

    x: Range | None = None
    y: Range | None = None
    z: Range | None = None


class Placed(Strict):
    """Something at nodes.

    Attributes:
        at: the node at a point [m].
        line: the mesh line between two points [m].
        nodes: a set of nodes or a line of the mesh, by name.
        where: nodes by their coordinates, as ``{ x = 0.0 }``.
    """

    at: in_unit("m", Point) | None = None
    line: in_unit("m", Line) | None = None
    nodes: Name | None = None
    where: Where | None = None

    @model_validator(mode="after")
    def _one_place(self):
        only_one(self, ("at", "line", "nodes", "where"))
        return self

    def numbers(self, mesh):
        """Its nodes on a ``Mesh``, a list.

        Raises:
            InputError: its place is not there.
        """
        if self.at:
            return [node_at(mesh.nodes, self.at.value)]
        if self.line:
            found = mesh.line(*self.line.value)
        elif self.where:
            found = mesh.nodes_at(**self.where.model_dump())
        else:
            found = mesh.node_sets[self.nodes]
        return np.asarray(found).tolist()


def elements_of(mesh, surface):
    """Numbers of the elements of a group of a ``Mesh``, by its name, or of ``all``.

    Raises:
        InputError: there is no such group.
    """
    return np.arange(len(mesh.quads)) if surface == "all" else mesh.groups[surface]
