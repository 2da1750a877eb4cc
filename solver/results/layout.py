"""What a result file holds, and where; checked before anything of it is read.

All datasets lie in the file itself, each as one contiguous block but for the times of the view,
which grow.  Links to other files, and storage in them, would let a file reach what is not its own.
"""

from typing import NamedTuple

import h5py
import numpy as np

DYNAMICS = np.dtype([
    ("time", "f8"), ("kinetic_energy", "f8"), ("strain_energy", "f8"), ("external_work", "f8"),
    ("support_work", "f8"), ("dissipated", "f8"),
    ("linear_momentum", "f8", 3), ("angular_momentum", "f8", 3),
    ("angular_momentum_printed", "f8", 3), ("momentum_scale", "f8"), ("angular_scale", "f8"),
    ("load", "f8", 3), ("load_moment", "f8", 3),
    ("reaction", "f8", 3), ("reaction_moment", "f8", 3), ("iterations", "i4"),
    ("work_ratio", "f8"), ("switches", "i4"), ("halvings", "i4"), ("indefinite", "i4"),
    ("parts", "i4"), ("rejected", "i4"), ("local_error", "f8")])
"""A row of a run, one a step; ``support_work`` of supports that move, ``dissipated`` by damping;
``angular_momentum_printed`` is Eq. (50) as printed (one sum over nodes), ``load`` and ``reaction``
are the forces of all loads and of all supports at the generalized midpoint of the step that ends
there, ``load_moment`` and ``reaction_moment`` their moments about the origin, all zero in the first
row; springs to the ground and damping of a shell that is held count among the reactions;
``parts`` are those that an adaptive step was divided into, ``rejected`` those that were taken back
and ``local_error`` the largest error of one, in sizes of the shell."""

STATICS = np.dtype([
    ("factor", "f8"), ("strain_energy", "f8"), ("load", "f8", 3), ("load_moment", "f8", 3),
    ("reaction", "f8", 3), ("reaction_moment", "f8", 3), ("force_balance", "f8"),
    ("moment_balance", "f8"), ("iterations", "i4"), ("steps", "i4"), ("indefinite", "i4"),
    ("negative_pivots", "i4"), ("next_step", "f8")])
"""A row of a static path: its load factor, the resultants of loads and reactions and their moments
about the origin, what is left of their sums (see ``Balance``), iterations, load steps and
factorizations with negative pivots since the row before, how many negative pivots the last of them
has (-1: the solver does not tell), and the step (load factor or arc length) that is tried next."""

PROBES = {
    "node": {"_u": ("displacement", (3,)), "_v": ("velocity", (3,))},
    "stress": {"_n": ("membrane_force", (3,)), "_m": ("moment", (3,)), "_q": ("shear_force", (2,)),
               "_von_mises": ("von_mises", (3,))},
    "energy": {"_strain_energy": ("strain_energy", ())},
    "joint": {"_angle": ("angle", ()), "_rate": ("rate", ()), "_moment": ("hinge_moment", ()),
              "_force": ("joint_force", (3,)), "_stored": ("stored", ()), "_work": ("work", ()),
              "_lost": ("lost", ()), "_slide": ("slide", ()), "_speed": ("speed", ()),
              "_couple": ("couple", (3,)), "_second": ("second_angle", ()),
              "_second_rate": ("second_rate", ())}}
"""What a probe of each kind adds to the columns of a run in time, behind its name: what it is, and
the shape of it."""

ITEMS = {"joints": ("stored", "work", "lost"), "bodies": ("kinetic",),
         "springs": ("stored", "lost")}
"""Energies of single items in a row of a run: of each joint that has a moment or is driven what is
stored there, the work of its motor, servo or drive and what its dampers took, of each rigid body
the kinetic one, of springs what is stored and what their dampers took [J].  Columns have a dot in
their names, as ``joints.work``, and a number an item; nothing of a model without such items."""

OF_JOINTS = {"joints": {"force": (3,), "moment": (), "couple": (3,), "angle": ()},
             "places": {"angle": (), "latched": ()}}
"""What a row of a static path has of joints: of each of them what ``StaticResult`` tells, and of
each place at which one has a moment its angle [rad] and whether its latch holds.  Columns have a
dot in their names, as ``joints.force``; nothing of a model without joints."""

TIMES = "VTKHDF/Steps/Values"


def probed(kinds, items=()):
    """The type of a row of a run with probes, ``{name: kind}``, and ``items``, ``(kind, number)``
    of each of ``ITEMS`` that there are."""
    own = [(f"{name}{end}", "f8", shape)
           for name, kind in kinds.items() for end, (_, shape) in PROBES[kind].items()]
    each = [(f"{kind}.{what}", "f8", (number,))
            for kind, number in items for what in ITEMS[kind]]
    return np.dtype([*DYNAMICS.descr, *own, *each])


def statics(items=()):
    """The type of a row of a static path, with ``items``, ``(kind, number)`` of each of
    ``OF_JOINTS`` that there are."""
    own = [(f"{kind}.{what}", "f8", (number, *shape))
           for kind, number in items for what, shape in OF_JOINTS[kind].items()]
    return np.dtype([*STATICS.descr, *own])


def is_static(row):
    """Whether a type of rows is that of a static path."""
    return "factor" in row.names


def _items_of_rows(static):
    """What rows have of single items, and the folder of it in a file."""
    return (OF_JOINTS, "items") if static else (ITEMS, "energies")


def items_of(row):
    """``(kind, number)`` of the items in a type of rows."""
    kinds, _ = _items_of_rows(is_static(row))
    firsts = {kind: f"{kind}.{next(iter(what))}" for kind, what in kinds.items()}
    return tuple((kind, row[first].shape[0]) for kind, first in firsts.items()
                 if first in row.names)


def probe_kinds(row):
    """``{name: kind}`` of the probes in a type of rows."""
    firsts = {next(iter(ends)): kind for kind, ends in PROBES.items()}
    return {name.removesuffix(end): kind for name in row.names if name not in DYNAMICS.names
            for end, kind in firsts.items() if name.endswith(end)}


def columns(row):
    """``{column: its place in a file}`` of a type of rows."""
    own = {f"{name}{end}": f"probes/{name}/{what}" for name, kind in probe_kinds(row).items()
           for end, (what, _) in PROBES[kind].items()}
    kinds, folder = _items_of_rows(is_static(row))
    own |= {f"{kind}.{what}": f"{folder}/{kind}/{what}"
            for kind, _ in items_of(row) for what in kinds[kind]}
    return {name: own.get(name, f"history/{name}") for name in row.names}


class Sizes(NamedTuple):
    """Numbers on which the shapes of all datasets depend.

    Attributes:
        static: whether it is a static path.
        nodes: of the mesh; elements: of it; directors: of the shell.
        steps: there is room for, beside the start; frames: there is room for.
        numbers: of a packed state.
        supported: whether frames have reactions; stresses: whether they have stresses.
        probes: ``(name, kind)`` of each.
        items: ``(kind, number)`` of those of which rows have something.
    """

    static: bool
    nodes: int
    elements: int
    directors: int
    steps: int
    frames: int
    numbers: int
    supported: bool
    stresses: bool
    probes: tuple = ()
    items: tuple = ()

    @property
    def row(self):
        """Type of a history row."""
        return statics(self.items) if self.static else probed(dict(self.probes), self.items)

    @property
    def fields(self):
        """``{name: (place in the view or None, shape)}`` of what a frame consists of, in the order
        of its checksum."""
        nodal = ["displacement", "normal"]
        several = ["director"] if self.directors > self.nodes else []
        held = ["reaction", "reaction_moment"] if self.supported else []
        fields = {**{name: ("PointData", (self.nodes, 3)) for name in nodal},
                  **{name: (None, (self.directors, 3)) for name in several},
                  **{name: ("PointData", (self.nodes, 3)) for name in held},
                  "strain_energy": ("CellData", (self.elements,))}
        if self.stresses:
            fields |= {name: ("CellData", (self.elements, size)) for name, size in STRESSES.items()}
            fields["nodal_von_mises"] = "PointData", (self.nodes, 3)
        return fields

    @property
    def shown(self):
        """Those of the view."""
        return {name: field for name, field in self.fields.items() if field[0]}


STRESSES = {"membrane_force": 3, "moment": 3, "shear_force": 2, "von_mises": 3}
"""Numbers an element of each field of stresses."""


def fixed(sizes):
    """``{place: (dtype, shape)}`` of the datasets that are written once, with the file."""
    nodes, elements, frames = sizes.nodes, sizes.elements, sizes.frames
    offsets = [f"{place}Offsets/{name}" for name, (place, _) in sizes.shown.items()]
    each = ("PartOffsets", "NumberOfParts", "PointOffsets", *offsets)
    return {"model/nodes": ("f8", (nodes, 3)), "model/quads": ("i8", (elements, 4)),
            "frames/step": ("i8", (frames,)),
            **{f"VTKHDF/NumberOf{what}": ("i8", (1,))
               for what in ("Points", "Cells", "ConnectivityIds")},
            "VTKHDF/Connectivity": ("i8", (4 * elements,)),
            "VTKHDF/Offsets": ("i8", (elements + 1,)), "VTKHDF/Types": ("u1", (elements,)),
            **{f"VTKHDF/Steps/{name}": ("i8", (frames,)) for name in each},
            **{f"VTKHDF/Steps/{name}Offsets": ("i8", (frames, 1))
               for name in ("Cell", "ConnectivityId")}}


def growing(sizes):
    """``{place: (dtype, shape)}`` of the datasets that a run fills."""
    row = sizes.row
    return {**{place: (row[name].base, (sizes.steps + 1, *row[name].shape))
               for name, place in columns(row).items()},
            **{f"frames/{name}": ("f8", (sizes.frames * size, *rest))
               for name, (_, (size, *rest)) in sizes.fields.items()},
            "frames/checksum": ("u4", (sizes.frames,)),
            "checkpoint/state": ("f8", (2, sizes.numbers)), "checkpoint/stamp": ("i8", (2, 2))}


def links(sizes):
    """``{place in the view: dataset that is shown there}``."""
    return {"VTKHDF/Points": "model/nodes",
            **{f"VTKHDF/{place}/{name}": f"frames/{name}"
               for name, (place, _) in sizes.shown.items()}}


def checked_sizes(file):
    """``Sizes`` of a file all of whose datasets are there, its own and of the right shapes.

    Raises:
        ValueError: what is missing or different.
    """
    def rows(place):
        shape = _stored(file, place).shape
        return shape[0] if shape else 0

    static, framed = "factor" in set(_own(file, "history")), set(_own(file, "frames"))
    packed = _stored(file, "checkpoint/state").shape or (0,)
    nodes, frames = rows("model/nodes"), rows("frames/step")
    directors = rows("frames/director") // max(frames, 1) if "director" in framed else nodes
    sizes = Sizes(static, nodes, rows("model/quads"), directors,
                  rows(f"history/{'factor' if static else 'time'}") - 1, frames, packed[-1],
                  "reaction" in framed, "von_mises" in framed,
                  _probes(file) if "probes" in file else (),
                  _items(file, static))
    for place, (dtype, shape) in {**fixed(sizes), **growing(sizes)}.items():
        _check(_stored(file, place), place, dtype, shape)
    times = _stored(file, TIMES, h5py.h5d.CHUNKED)
    if (times.dtype, times.chunks, times.maxshape) != ("f8", *2 * ((sizes.frames,),)):
        raise ValueError(f"{TIMES} has another shape or type")
    for place, shown in links(sizes).items():
        if _own(file, place) != file[shown]:
            raise ValueError(f"{place} does not show {shown}")
    return sizes


def _probes(file):
    """``(name, kind)`` of every probe in a file."""
    kinds = {what: kind for kind, ends in PROBES.items() for what, _ in ends.values()}
    return tuple((name, next((kind for what, kind in kinds.items()
                              if what in _own(file, f"probes/{name}")), "node"))
                 for name in _own(file, "probes"))


def _items(file, static):
    """``(kind, number)`` of the items of which a file's rows have something."""
    kinds, folder = _items_of_rows(static)
    found = set(_own(file, folder)) if folder in file else ()
    shapes = {kind: _stored(file, f"{folder}/{kind}/{next(iter(what))}").shape
              for kind, what in kinds.items() if kind in found}
    return tuple((kind, shape[1] if len(shape) > 1 else 0) for kind, shape in shapes.items())


def _own(file, place):
    """What is at a place, if no link on the way leads elsewhere."""
    item = file
    for name in place.split("/"):
        try:
            link = item.id.links.get_info(name.encode())
        except (AttributeError, KeyError, RuntimeError):
            raise ValueError(f"{place} is missing") from None
        if link.type != h5py.h5l.TYPE_HARD:
            raise ValueError(f"{place} is a link to somewhere else")
        item = item[name]
    return item


def _stored(file, place, layout=h5py.h5d.CONTIGUOUS):
    """The dataset at a place, if its numbers are in this file, as they are."""
    dataset = _own(file, place)
    if not isinstance(dataset, h5py.Dataset):
        raise ValueError(f"{place} is not a dataset")
    how = dataset.id.get_create_plist()
    if how.get_layout() != layout or how.get_external_count() or how.get_nfilters():
        raise ValueError(f"{place} is not stored as corovec stores it")
    return dataset


def _check(dataset, place, dtype, shape):
    """Refuse another type or shape, and numbers that the file is too short to hold."""
    if dataset.dtype != dtype or dataset.shape != shape:
        raise ValueError(f"{place} is {dataset.dtype} {dataset.shape}, must be {np.dtype(dtype)} "
                         f"{shape}")
    offset = dataset.id.get_offset()
    if offset is None or offset + dataset.nbytes > dataset.file.id.get_filesize():
        raise ValueError(f"{place} is longer than the file")
