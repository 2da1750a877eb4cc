"""Meshes of Abaqus input files: nodes, elements and sets, in any number of blocks.

meshio's own reader gives the elements of a set that spans several blocks to others.
"""

import re

import numpy as np

from ..checks import shown

_SOLID, _SHELL = r"(C3D|DC3D)", r"(S|M3D|CPS|CPE|CAX|R3D|DS|SFM3D)"
KINDS = (
    (_SOLID + "4", "tetra", 4), (_SOLID + "10", "tetra10", 10), (_SOLID + "15", "wedge15", 15),
    (_SOLID + "20", "hexahedron20", 20), (_SOLID + "6|SC6", "wedge", 6),
    (_SOLID + "8|SC8", "hexahedron", 8), ("STRI65|" + _SHELL + "6", "triangle6", 6),
    ("STRI3|" + _SHELL + "3", "triangle", 3), (_SHELL + "4", "quad", 4),
    (_SHELL + "8", "quad8", 8), (_SHELL + "9", "quad9", 9), (r"B[23]2|T[23]D3", "line3", 3),
    (r"B[23][13]|[TR][23]D2", "line", 2))
"""What an element type begins with, its kind in meshio's words, its number of nodes."""

REFUSED = ("INCLUDE", "SYSTEM", "NGEN", "NCOPY", "NFILL", "NMAP", "ELGEN", "ELCOPY")
"""Keywords that make other nodes and elements than those that are written down."""


def read(text):
    """``meshio.Mesh`` of the text of an input file.

    Raises:
        ValueError: what it cannot be, naming the line.
    """
    import meshio
    nodes, blocks, sets = {}, [], {"NSET": {}, "ELSET": {}}
    for line, keyword, options, rows in _sections(text):
        try:
            if keyword in REFUSED or (keyword == "INSTANCE" and any(rows)):
                raise ValueError("is not followed, write all nodes and elements down in one part")
            if keyword == "NODE":
                found = {int(row[0]): [float(value) for value in (row[1:] + ["0"] * 3)[:3]]
                         for row in rows}
                if len(found) < len(rows) or found.keys() & nodes.keys():
                    raise ValueError("a node is there twice: write all parts with numbers of their "
                                     "own")
                nodes |= found
                _add(sets["NSET"], options.get("NSET"), found)
            elif keyword == "ELEMENT":
                kind, width = _kind(options.get("TYPE", ""))
                flat = np.array([item for row in rows for item in row if item], dtype=np.int64)
                if flat.size % (width + 1):
                    raise ValueError(f"elements of {width} nodes need {width + 1} numbers each")
                table = flat.reshape(-1, width + 1)
                if table.size:
                    blocks.append((kind, table[:, 0], table[:, 1:]))
                    _add(sets["ELSET"], options.get("ELSET"), table[:, 0].tolist())
            elif keyword in sets:
                items = [item for row in rows for item in row if item]
                if "GENERATE" in options:
                    ranges = [[int(item) for item in row if item] for row in rows]
                    items = [k for low, high, *step in ranges
                             for k in range(low, high + 1, *step)]
                _add(sets[keyword], options.get(keyword), items)
        except (ValueError, TypeError) as error:
            raise ValueError(f"line {line}: *{keyword}: {error}") from None
    rank = dict(zip(nodes, range(len(nodes))))
    elements = np.concatenate([numbers for _, numbers, _ in blocks] or [np.zeros(0, dtype=int)])
    place = dict(zip(elements.tolist(), range(len(elements))))
    if len(place) < len(elements):
        raise ValueError("an element is there twice: write all parts with numbers of their own")
    bounds = np.cumsum([0] + [len(numbers) for _, numbers, _ in blocks])
    cells = {}
    for name, items in sets["ELSET"].values():
        members = _members("ELSET", name, items, sets["ELSET"], place)
        cells[name] = [members[(members >= low) & (members < high)] - low
                       for low, high in zip(bounds[:-1], bounds[1:])]
    points = {name: _members("NSET", name, items, sets["NSET"], rank)
              for name, items in sets["NSET"].values()}
    return meshio.Mesh(np.array(list(nodes.values()), dtype=float).reshape(-1, 3), [
        (kind, _numbers(f"elements {kind}", table, rank)) for kind, _, table in blocks],
        point_sets=points, cell_sets=cells)


def _sections(text):
    """(line, KEYWORD, options, rows of texts) of all keywords."""
    line, head, rows = 0, None, []
    for k, row in enumerate(text.splitlines(), 1):
        row = row.strip()
        if not row or row.startswith("**"):
            continue
        if row.startswith("*"):
            if head is not None:
                yield line, *_options(head), rows
            line, head, rows = k, row, []
        elif head is not None and head.endswith(","):
            head += row
        else:
            rows.append([item.strip() for item in row.split(",")])
    if head is not None:
        yield line, *_options(head), rows


def _options(head):
    """KEYWORD and {OPTION: value} of a keyword's line."""
    keyword, *options = (part.strip() for part in head[1:].split(","))
    pairs = (option.partition("=") for option in options if option)
    return keyword.upper(), {key.strip().upper(): value.strip().strip('"')
                             for key, _, value in pairs}


def _kind(name):
    """Kind and number of nodes of an element type."""
    for pattern, kind, width in KINDS:
        if re.match(rf"({pattern})(?![0-9])", name.upper()):
            return kind, width
    raise ValueError(f"elements of type {shown(name)} are unknown, shells are S4, S4R, S3 ...")


def _add(sets, name, items):
    """Put items into the set ``name``; names are the same in any case of their letters."""
    if name:
        sets.setdefault(name.upper(), (name, []))[1].extend(items)


def _members(kind, name, items, sets, rank, within=()):
    """Ranks of the members of a set: numbers, or names of other sets."""
    found = []
    for item in items:
        if isinstance(item, str) and not item.isdecimal():
            other = item.strip('"').upper()
            if other not in sets or other in within:
                raise ValueError(f"*{kind} {name}: there is no set {shown(item)}")
            found.extend(_members(kind, *sets[other], sets, rank, (*within, other)).tolist())
        elif int(item) not in rank:
            raise ValueError(f"*{kind} {name}: number {int(item)} does not exist")
        else:
            found.append(rank[int(item)])
    return np.unique(np.array(found, dtype=np.int64))


def _numbers(what, table, rank):
    """Ranks of a table of numbers."""
    try:
        return np.array([rank[k] for k in table.ravel().tolist()]).reshape(table.shape)
    except KeyError as error:
        raise ValueError(f"{what}: node {error} does not exist") from None


def text(mesh):
    """A ``Mesh`` as the text of an input file: shells S4, lines T3D2, numbers from 1."""
    parts = ["*NODE", *(f"{k}, {x!r}, {y!r}, {z!r}"
                        for k, (x, y, z) in enumerate(mesh.nodes.tolist(), 1))]
    parts += ["*ELEMENT, TYPE=S4", *_rows(mesh.quads + 1, 1)]
    start = len(mesh.quads) + 1
    for name, rows in mesh.lines.items():
        parts += [f'*ELEMENT, TYPE=T3D2, ELSET="{name}"', *_rows(rows + 1, start)]
        start += len(rows)
    for keyword, sets in (("ELSET", mesh.groups), ("NSET", mesh.node_sets)):
        for name, numbers in sets.items():
            parts += [f'*{keyword}, {keyword}="{name}"', *(
                ", ".join(map(str, numbers[k:k + 16] + 1)) for k in range(0, len(numbers), 16))]
    return "\n".join(parts) + "\n"


def _rows(table, start):
    """Lines of numbered rows."""
    return [f"{k}, {', '.join(map(str, row))}" for k, row in enumerate(table.tolist(), start)]
