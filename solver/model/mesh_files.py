"""Mesh files by meshio: what they hold as faces with names, and the other way round.

While a mesh is read, triangles are faces whose last node is the first again.
"""

import contextlib
import io
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..checks import floats
from ..errors import InputError
from . import abaqus
from .bounded import bounded
from .mesh import coincident, edge_keys, element_edges, few_enough

READ = (".msh", ".inp", ".bdf", ".nas", ".fem", ".vtu", ".vtk", ".xdmf", ".med", ".mesh", ".stl",
        ".obj")
"""Formats whose damaged files meshio ends with an error; readers of others may not end at all."""

WRITTEN = (".msh", ".inp", ".bdf", ".vtu", ".vtk", ".xdmf", ".med")
"""Formats that hold a mesh of quads with names, or numbers of groups, as we read it."""

MOST_VALUES = 1000
"""Different numbers in integer data of the cells that are taken for numbers of groups."""

TAGS = ("gmsh:physical", "nastran:ref", "medit:ref", "su2:tag", "CellEntityIds")
"""Data of cells that numbers their groups: each number is a name."""

GEOMETRY = ("gmsh:geometrical", "gmsh:bounding_entities")
"""What Gmsh says of the geometry: no names."""

REMEDIES = {".msh": "save it as format 4.1 or 2.2, with what is in physical groups only "
                    "(Mesh.SaveAll = 0)"}
"""What helps where meshio cannot read a file."""


class Faces(NamedTuple):
    """What is read: as ``Mesh``, with triangles.

    Attributes:
        nodes: (n, 3) [m].
        faces: (m, 4) node numbers.
        groups, node_sets, lines: ``{name: numbers}``, lines (k, 2).
    """

    nodes: np.ndarray
    faces: np.ndarray
    groups: dict
    node_sets: dict
    lines: dict

    @property
    def triangles(self):
        """(m,) which faces are triangles."""
        return self.faces[:, 3] == self.faces[:, 0]


def read(path, merge, reduce, all_quads):
    """Arguments of ``Mesh`` from a file, and notes (texts) on what was changed.

    Raises:
        InputError: as of ``Mesh.read``.
    """
    data = _contained(path)
    try:
        found, notes = _faces(data, reduce)
        if merge:
            found, note = _merged(found, None if merge is True else merge)
            notes += note
        found, note = _on_edges(found)
        notes += note
        if all_quads:
            found = _divided(found)
        few = int(found.triangles.sum())
        if few:
            n = len(found.faces)
            raise InputError(f"{few} of {n} elements are triangles: Mesh.read(..., all_quads=True) "
                             f"divides each into three quads and the others into four, "
                             f"{4 * n - few} in all; or let the mesher make quads only")
        few_enough(len(found.faces))
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except Exception as error:  # of a damaged file: arrays that fit nothing
        raise InputError(f"{path} cannot be read: {type(error).__name__}") from None
    return dict(zip(("nodes", "quads", "groups", "node_sets", "lines"), found)), notes


def _contained(path):
    """The ``meshio.Mesh`` of a file; whatever reading it may raise or print is one line."""
    import meshio
    path, suffix = Path(path), Path(path).suffix.lower()
    try:
        if not path.exists():
            raise ValueError("there is no such file")
        if not path.is_file():
            raise ValueError("it is not a regular file")
        if suffix not in READ:
            raise ValueError(f"its suffix must be one of {', '.join(READ)}")
        if not path.stat().st_size:
            raise ValueError("it is empty")
        if suffix == ".inp":
            return abaqus.read(path.read_text(encoding="utf-8", errors="replace"))
        with _quiet() as said:
            if suffix in (".bdf", ".fem", ".nas"):
                return meshio.read(io.StringIO(_bulk(path.read_text(errors="replace"))), "nastran")
            with bounded(_binary(), path.stat().st_size):
                return meshio.read(path)
    except (Exception, SystemExit) as error:  # meshio raises everything, and exits
        reason = (getattr(error, "strerror", None) or str(error)) if not isinstance(
            error, SystemExit) else said.getvalue().strip().partition("\n")[0]
        reason = " ".join((reason or type(error).__name__).split())[:150].rstrip(".")
        remedy = f"; {REMEDIES[suffix]}" if suffix in REMEDIES and path.is_file() else ""
        raise InputError(f"{path} cannot be read: {reason}{remedy}") from None


def _binary():
    """Modules of meshio that make arrays by counts in files."""
    from meshio.gmsh import _gmsh22, _gmsh40, _gmsh41, common
    from meshio.vtk import _vtk_42, _vtk_51
    return _gmsh22, _gmsh40, _gmsh41, common, _vtk_42, _vtk_51


@contextlib.contextmanager
def _quiet():
    """What is printed meanwhile; warnings are dropped."""
    said = io.StringIO()
    with (contextlib.redirect_stdout(said), contextlib.redirect_stderr(io.StringIO()),
          warnings.catch_warnings()):
        warnings.simplefilter("ignore")
        yield said


def _bulk(text):
    """The text of a Nastran file that has a bulk section and an end, which some writers leave
    out."""
    text = text if "BEGIN BULK" in text else f"BEGIN BULK\n{text}"
    return text if "\nENDDATA" in text else f"{text}\nENDDATA\n"


def _faces(data, reduce):
    """``Faces`` of a ``meshio.Mesh``, on nodes that they use, and notes."""
    points = np.asarray(data.points)
    if not data.cells or not points.size:
        raise InputError("it holds no elements")
    if points.ndim == 2 and points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    nodes = floats("nodes", points, (None, 3))
    if np.any(data.point_data.get("nastran:ref", 0)):
        raise InputError("nodes in a coordinate system of their own (CP): write them in the basic "
                         "one")
    blocks = [_corners(block, len(nodes)) for block in data.cells]
    dims = np.array([dim for dim, _, _ in blocks])
    _only_faces(data, dims)
    if not reduce and any(more for dim, _, more in blocks if dim == 2):
        kinds = sorted({block.type for block, (dim, _, more) in zip(data.cells, blocks)
                        if dim == 2 and more})
        raise InputError(f"elements of second order ({', '.join(kinds)}): "
                         "Mesh.read(..., reduce=True) takes their corners, or save the mesh as "
                         "one of first order")
    named = _names(data, dims)
    faces = np.concatenate([rows for dim, rows, _ in blocks if dim == 2])
    collapsed = faces[:, 3] == faces[:, 2]  # a triangle, as some programs write it
    faces[collapsed, 3] = faces[collapsed, 0]
    starts = np.cumsum([0] + [len(rows) * (dim == 2) for dim, rows, _ in blocks])
    groups, lines = {}, {}
    sets = {name: np.asarray(numbers, dtype=np.int64).ravel()
            for name, numbers in (*data.point_sets.items(), *_flags(data.point_data))}
    for name, k, members in named:
        dim, rows, _ = blocks[k]
        if dim == 2:
            groups.setdefault(name, []).append(starts[k] + members)
        elif dim == 1:
            lines.setdefault(name, []).append(rows[members])
        else:
            sets[name] = np.union1d(sets.get(name, []), rows[members]).astype(np.int64)
    groups, lines = ({name: np.concatenate(parts) for name, parts in found.items()}
                     for found in (groups, lines))
    faces, new = _once(faces, groups)
    found = Faces(nodes, faces, {name: new[of] for name, of in groups.items()}, sets, lines)
    middle = [np.ravel(block.data) for block, (_, _, more) in zip(data.cells, blocks) if more]
    return _used(found, np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *middle])))


def _corners(block, n_nodes):
    """Dimension of a block of cells, their corners (n, 1, 2 or 4), and whether they have other
    nodes."""
    kind, rows = block.type, np.asarray(block.data)
    wanted = next((n for start, n in (("vertex", 1), ("line", 2), ("triangle", 3), ("quad", 4))
                   if kind.startswith(start)), None)
    if kind == "polygon":
        wanted = rows.shape[1] if rows.ndim == 2 and rows.shape[1] in (3, 4) else None
    if wanted is None:
        if block.dim == 3:
            return 3, rows, False
        raise InputError(f"{len(rows)} elements are {kind}s, no quads or triangles")
    if rows.ndim != 2 or rows.shape[1] < wanted or rows.dtype.kind not in "iu":
        raise InputError(f"its {kind}s have other nodes than {wanted} or more")
    rows, more = rows.astype(np.int64), rows.shape[1] > wanted
    bad = rows[(rows < 0) | (rows >= n_nodes)]
    if len(bad):
        raise InputError(f"an element has node {bad[0]} (from 0), which does not exist: there are "
                         f"{n_nodes}")
    rows = rows[:, :wanted]
    return block.dim, rows[:, [0, 1, 2, 0]] if wanted == 3 else rows, more


def _only_faces(data, dims):
    """Raise ``InputError`` for a mesh of volumes, or one without faces."""
    kinds = [f"{len(block)} {block.type}" for block in data.cells]
    if 3 in dims:
        volumes = [kind for kind, dim in zip(kinds, dims) if dim == 3]
        raise InputError(f"volume elements ({', '.join(volumes[:3])}): a shell has faces only, "
                         "save the surfaces alone")
    if not np.any([dim == 2 and len(block) for block, dim in zip(data.cells, dims)]):
        raise InputError(f"no quads, only {', '.join(kinds[:5])}: mesh its surfaces, and put them "
                         "into a physical group or set that is saved")


def _names(data, dims):
    """(name, number of the block, members of the block) of all that names cells."""
    found = []
    for name, parts in data.cell_sets.items():
        if name not in GEOMETRY:
            found += [(name, k, np.asarray(members, dtype=np.int64))
                      for k, members in enumerate(parts) if members is not None and len(members)]
    tags = data.field_data.items() if "gmsh:physical" in data.cell_data else ()
    # None: cells of this number are in a set already
    names = {(int(tag), int(dim)): None if name in data.cell_sets else name
             for name, (tag, dim) in tags}
    for key, parts in data.cell_data.items():
        parts = [np.ravel(part) for part in parts]
        values = np.unique(np.concatenate(parts))
        if (key in GEOMETRY or values.dtype.kind not in "iu" or len(values) > MOST_VALUES
                or any(len(part) != len(block) for part, block in zip(parts, data.cells))):
            continue
        flag = key not in TAGS and set(values.tolist()) <= {0, 1}
        for k, part in enumerate(parts):
            for value in np.unique(part).tolist():
                name = key if flag else (str(value) if key in TAGS else f"{key} {value}")
                if key == "gmsh:physical":
                    name = names.get((value, int(dims[k])), name)
                if name is not None and (value or not (flag or key in TAGS)):
                    found.append((name, k, np.flatnonzero(part == value)))
    return found


def _flags(point_data):
    """Node sets that are given as data of 0 and 1."""
    return [(name, np.flatnonzero(values)) for name, values in point_data.items()
            if name not in TAGS and np.ndim(values) == 1 and np.asarray(values).dtype.kind in "iub"
            and set(np.unique(values).tolist()) == {0, 1}]


def _once(faces, groups):
    """Faces without those that are there again in another group, as Gmsh 2 writes members of two
    groups; and the new number of each."""
    _, first, inverse = np.unique(faces, axis=0, return_index=True, return_inverse=True)
    first = first[inverse.ravel()]
    again = first != np.arange(len(faces))
    if not again.any():
        return faces, np.arange(len(faces))
    group = np.full(len(faces), -1)
    for k, members in enumerate(groups.values()):
        group[members] = k
    again &= group != group[first]
    return faces[~again], (np.cumsum(~again) - 1)[np.where(again, first, np.arange(len(faces)))]


def _used(found, middle):
    """``found`` without nodes of no face, and a note on those that are none of ``middle``."""
    used = np.zeros(len(found.nodes), dtype=bool)
    used[found.faces] = True
    lost = np.setdiff1d(np.flatnonzero(~used), middle)
    new = np.where(used, np.cumsum(used) - 1, -1)
    notes = [f"{len(lost)} node{'s' * (len(lost) > 1)} of no element left out"] * bool(len(lost))
    return _renumbered(found, np.flatnonzero(used), new), notes


def _merged(found, tolerance):
    """``found`` with nodes at one place made one, and a note."""
    kept, rank = coincident(found.nodes, found.faces, tolerance)
    gone = len(found.nodes) - len(kept)
    edges = element_edges(found.faces)
    short = (rank[edges[:, 0]] == rank[edges[:, 1]]) & (edges[:, 0] != edges[:, 1])
    if short.any():
        i, j = edges[np.argmax(short)]
        raise InputError(f"element {np.argmax(short) // 4}: its nodes {i} and {j} would be merged, "
                         "give a smaller tolerance")
    return _renumbered(found, kept, rank), [f"{gone} nodes merged into others"] * bool(gone)


def _renumbered(found, kept, new):
    """``found`` with the nodes ``kept``, ``new`` (n,) being the number of each, -1 for none."""
    sets = {name: new[numbers] for name, numbers in found.node_sets.items()}
    lines = {name: new[edges] for name, edges in found.lines.items()}
    return Faces(found.nodes[kept], new[found.faces], found.groups,
                 {name: numbers[numbers >= 0] for name, numbers in sets.items()},
                 {name: edges[(edges >= 0).all(axis=1)] for name, edges in lines.items()})


def _on_edges(found):
    """``found`` with those lines only that are edges of elements, and a note."""
    keys = edge_keys(element_edges(found.faces))
    on = {name: np.isin(edge_keys(edges), keys) & (edges[:, 0] != edges[:, 1])
          for name, edges in found.lines.items()}
    off = sum(int((~edges).sum()) for edges in on.values())
    sets = dict(found.node_sets)
    for name, edges in found.lines.items():  # their nodes stay, whatever the edges
        sets[name] = np.union1d(sets.get(name, edges[:0, 0]), edges)
    lines = {name: edges[on[name]] for name, edges in found.lines.items() if on[name].any()}
    return found._replace(node_sets=sets, lines=lines), [
        f"{off} line elements along no edge left out"] * bool(off)


def _divided(found):
    """``found`` with triangles divided into three quads, quads into four.

    Groups and lines are those of the parts.  Node sets gain the middle of edges between two of
    their nodes, if that is no chord between two nodes of the boundary, and of elements.
    """
    nodes, faces, triangle = found.nodes, found.faces, found.triangles
    n, edges = len(nodes), element_edges(faces)
    real = edges[:, 0] != edges[:, 1]
    keys, first, inverse, uses = np.unique(edge_keys(edges[real]), return_index=True,
                                           return_inverse=True, return_counts=True)
    ends = edges[real][first]
    middle = np.full(len(edges), -1)
    middle[real] = n + inverse
    middle = middle.reshape(-1, 4)
    before = np.roll(middle, 1, axis=1)
    before[triangle, 0] = middle[triangle, 2]
    centre = n + len(keys) + np.arange(len(faces))
    parts = np.stack([faces, middle, np.repeat(centre[:, None], 4, axis=1), before], axis=2)
    there = np.ones(faces.shape, dtype=bool)
    there[triangle, 3] = False
    total = nodes[faces].sum(axis=1) - triangle[:, None] * nodes[faces[:, 0]]
    new = np.concatenate([nodes, 0.5 * (nodes[ends[:, 0]] + nodes[ends[:, 1]]),
                          total / (4.0 - triangle[:, None])])
    parent = np.nonzero(there)[0]
    rim = np.zeros(n, dtype=bool)
    rim[ends[uses == 1]] = True
    groups = {name: np.flatnonzero(np.isin(parent, of)) for name, of in found.groups.items()}
    lines, sets = {}, {}
    for name, line in found.lines.items():
        at = n + np.searchsorted(keys, edge_keys(line))
        lines[name] = np.concatenate([np.stack([line[:, 0], at], axis=1),
                                      np.stack([at, line[:, 1]], axis=1)])
    for name, numbers in found.node_sets.items():
        inside = np.zeros(n, dtype=bool)
        inside[numbers] = True
        chord = (uses > 1) & rim[ends].all(axis=1)
        whole = inside[faces].all(axis=1) & ~rim[faces].all(axis=1)
        sets[name] = np.concatenate([numbers, n + np.flatnonzero(inside[ends].all(axis=1) & ~chord),
                                     centre[whole]])
    return Faces(new, parts[there], groups, sets, lines)


def write(path, mesh, overwrite):
    """``Mesh.write``."""
    import meshio
    path, suffix = Path(path), Path(path).suffix.lower()
    if suffix not in WRITTEN:
        raise InputError(f"{path} cannot be written: its suffix must be one of "
                         f"{', '.join(WRITTEN)}")
    if path.exists() and not overwrite:
        raise InputError(f"{path} exists already: overwrite=True replaces it")
    try:
        with _quiet():
            if suffix == ".inp":
                path.write_text(abaqus.text(mesh), encoding="utf-8")
            elif suffix == ".msh":
                meshio.write(path, _tagged(mesh, "gmsh:physical"), "gmsh22")
            elif suffix == ".bdf":
                data = _tagged(mesh, "nastran:ref")
                # its fields of 16 characters hold no more digits
                data.points = np.vectorize(lambda x: float(f"{x:.9e}"))(data.points)
                meshio.write(path, data)
            else:
                meshio.write(path, _flagged(mesh, "_" if suffix == ".vtk" else " "))
    except (Exception, SystemExit) as error:
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        raise InputError(f"{path} cannot be written: {' '.join(reason.split())[:150]}") from None


def _tagged(mesh, key):
    """``meshio.Mesh`` with numbers of groups: members of several are there several times."""
    import meshio
    blocks, tags, names = [], [], {}
    first = np.zeros(len(mesh.quads), dtype=np.int64)
    for tag, (name, members) in enumerate(mesh.groups.items(), 1):
        again = members[first[members] > 0]
        first[members[first[members] == 0]] = tag
        names[name] = (tag, 2)
        if key == "gmsh:physical" and len(again):
            blocks.append(("quad", mesh.quads[again]))
            tags.append(np.full(len(again), tag))
    blocks.insert(0, ("quad", mesh.quads))
    tags.insert(0, first)
    if key == "gmsh:physical":
        points = {name: numbers for name, numbers in mesh.node_sets.items()
                  if name not in mesh.lines}
        for kind, dim, found in (("line", 1, mesh.lines), ("vertex", 0, points)):
            for tag, (name, rows) in enumerate(found.items(), 1):
                # names that several kinds share stay, told apart by a letter at the end
                names[name if name not in names else f"{name} ({kind})"] = (tag, dim)
                blocks.append((kind, rows.reshape(-1, dim + 1)))
                tags.append(np.full(len(rows), tag))
    data = {key: tags}
    if key == "gmsh:physical":
        data["gmsh:geometrical"] = [np.ones_like(tag) for tag in tags]
    return meshio.Mesh(mesh.nodes, blocks, cell_data=data, field_data={
        name: np.array(pair) for name, pair in names.items()})


def _flagged(mesh, space):
    """``meshio.Mesh`` with data of 0 and 1 for every name, ``space`` for spaces in it."""
    import meshio
    blocks = [("quad", mesh.quads), *(("line", rows) for rows in mesh.lines.values() if len(rows))]
    lines = [name for name, rows in mesh.lines.items() if len(rows)]
    data = {}
    for name in (*mesh.groups, *lines):
        flags = [np.zeros(len(rows), dtype=np.int32) for _, rows in blocks]
        flags[0][mesh.groups.get(name, [])] = 1
        if name in lines:
            flags[1 + lines.index(name)][:] = 1
        data[name.replace(" ", space)] = flags
    points = {}
    for name, numbers in mesh.node_sets.items():
        if name not in mesh.lines:
            points[name.replace(" ", space)] = np.isin(np.arange(len(mesh.nodes)),
                                                       numbers).astype(np.int32)
    return meshio.Mesh(mesh.nodes, blocks, cell_data=data, point_data=points)
