"""The mesh of a model file: a file, blocks, a cylinder or a sphere, and refinements of these."""

from dataclasses import replace
from functools import cached_property
from typing import Literal

import numpy as np
from pydantic import Field, field_validator, model_validator

from ..model.generators import block, corners_of, cylinder, sphere_segment
from ..model.meshes import Mesh, join
from .values import (
    Beside,
    Count,
    Divisions,
    Name,
    Point,
    Polar,
    Positive,
    Provenance,
    Strict,
    columns,
    in_unit,
    only_one,
    within,
)


class Block(Strict):
    """A flat quadrilateral of elements.

    Attributes:
        corners: four points round it [m].
        divisions: elements along the sides 1-2 and 2-3; neighbours need the same of a common edge.
        group: a name for its elements.
        sides: names for the lines along its sides, 1 from its first corner to the second.
    """

    corners: tuple[Point, Point, Point, Point]
    divisions: Divisions
    group: Name | None = None
    sides: dict[Name, Literal[1, 2, 3, 4]] = {}

    @field_validator("corners")
    @classmethod
    def _round(cls, corners):
        corners_of("", corners)
        return corners

    def mesh(self, refinement):
        """``Mesh`` of it, ``refinement`` times as fine."""
        made = block(self.corners, tuple(refinement * n for n in self.divisions))
        lines = {}
        for name, side in self.sides.items():
            line = made.line(self.corners[side - 1], self.corners[side % 4])
            lines[name] = np.stack([line[:-1], line[1:]], axis=1)
        made = replace(made, lines=lines)
        return made.named(self.group) if self.group else made


class Sphere(Strict):
    """Segment of a sphere between two parallels, about the Z axis, with exact normals.

    Attributes:
        radius: of the middle surface [m].
        polar_angles: of the upper and the lower parallel [deg].
        divisions: elements round (at least 9) and along the meridian (one for every 45 degrees).
    """

    radius: in_unit("m", Positive)
    polar_angles: in_unit("deg", tuple[Polar, Polar])
    divisions: in_unit("", Divisions)

    @field_validator("polar_angles")
    @classmethod
    def _from_above(cls, angles):
        if not angles.value[0] < angles.value[1]:
            raise ValueError(f"the upper parallel comes first: {angles.value} must increase")
        return angles

    def mesh(self, refinement):
        """``Mesh`` of it, ``refinement`` times as fine."""
        n, m = self.divisions.value
        return sphere_segment(self.radius.value, self.polar_angles.value,
                              (refinement * n, refinement * m))


class Cylinder(Strict):
    """Cylinder about the Z axis from z = 0, or a part of it from the X axis on; exact normals.

    Attributes:
        radius: of the middle surface [m].
        length: along the axis [m].
        divisions: elements round and along.
        angle: how far round it goes [deg].
    """

    radius: in_unit("m", Positive)
    length: in_unit("m", Positive)
    divisions: in_unit("", Divisions)
    angle: in_unit("deg", within(0.0, 360.0 + 1e-9)) = Field(360.0, validate_default=True)

    def mesh(self, refinement):
        """``Mesh`` of it, ``refinement`` times as fine."""
        n, m = self.divisions.value
        return cylinder(self.radius.value, self.length.value, (refinement * n, refinement * m),
                        angle=self.angle.value)


class Geometry(Strict):
    """One of a mesh file, blocks joined where their nodes coincide, a sphere segment, a cylinder.

    Attributes:
        file: path of a mesh of any format that meshio reads, from the folder of the model file;
            its physical groups and sets arrive by name.
        scale: of the coordinates in ``file``, to have them in m.
        merge: makes nodes at one place of ``file`` one.
        reduce: takes the corners of elements of second order of ``file``.
        all_quads: divides triangles of ``file`` into three quads and each quad into four.
        apart: nodes of ``file``, or of different blocks, may be at one place, of plates that joints
            hold together.
        blocks: ``Block`` s.
        sphere: ``Sphere``.
        cylinder: ``Cylinder``.
        unit: of the blocks' corners, m.
        provenance: where the geometry comes from.
        source: in words.
    """

    file: Beside | None = None
    scale: Positive = 1.0
    merge: bool = False
    reduce: bool = False
    all_quads: bool = False
    apart: bool = False
    blocks: list[Block] | None = None
    sphere: Sphere | None = None
    cylinder: Cylinder | None = None
    unit: str | None = None
    provenance: Provenance = "given"
    source: str = ""

    @model_validator(mode="after")
    def _one_kind(self):
        kind = only_one(self, ("file", "blocks", "sphere", "cylinder"))
        if self.blocks == []:
            raise ValueError("blocks must not be empty")
        if self.blocks and self.unit not in ("m", None):
            raise ValueError(f"blocks in '{self.unit}', must be in 'm'")
        kinds = {"apart": ("file", "blocks")}
        for name in ("scale", "merge", "reduce", "all_quads", "apart"):
            if name in self.model_fields_set and kind not in kinds.get(name, ("file",)):
                raise ValueError(f"{name} is for a mesh of a file, this has {kind}")
        return self

    @property
    def elements(self):
        """Number of elements at refinement 1."""
        return len(self._read.quads) if self.file else sum(n * m for n, m in self._divisions)

    @property
    def _divisions(self):
        """Divisions of every part at refinement 1."""
        round_one = self.sphere or self.cylinder
        return ([round_one.divisions.value] if round_one
                else [block.divisions for block in self.blocks])

    @cached_property
    def _read(self):
        """The mesh in the file [m]."""
        read = Mesh.read(self.file, merge=self.merge, reduce=self.reduce, all_quads=self.all_quads,
                         apart=self.apart)
        if self.scale == 1.0:
            return read
        return replace(read, nodes=read.nodes * self.scale)

    def mesh(self, refinement):
        """``Mesh``, ``refinement`` times as fine."""
        if self.file:
            return self._read
        if self.blocks:
            # their normals are the means of the elements', which know where plates meet
            meshes = [block.mesh(refinement) for block in self.blocks]
            return replace(join(meshes, apart=self.apart), normals=None)
        return (self.sphere or self.cylinder).mesh(refinement)

    def rows(self):
        """Rows (parameter, value, unit, provenance, source)."""
        shape = self.sphere or self.cylinder
        kind = (f"{len(self.blocks)} blocks" if self.blocks else
                "sphere segment" if self.sphere else "cylinder" if self.cylinder else self.file)
        unit = ("m" if self.blocks else "") if self.unit is None else self.unit
        return [("geometry", kind, unit, self.provenance, self.source),
                *((name, *columns(given)) for name, given in shape or ())]


class Refinement(Strict):
    """A mesh of the model.

    Attributes:
        elements: how many it has.
        refinement: of the divisions of the geometry.
        provenance: where it comes from.
    """

    elements: Count
    refinement: Count
    provenance: Provenance = "given"
