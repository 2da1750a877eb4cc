"""The view that ParaView opens: a VTKHDF transient unstructured grid of links to the frames."""

import h5py
import numpy as np

from .layout import TIMES, links

QUAD = 9
"""VTK's number of a cell with four nodes."""


def make_view(file, model, sizes):
    """The mesh, and links to the room for all frames; the datasets are there, to be filled."""
    n_nodes, n_elem = sizes.nodes, sizes.elements
    frames = np.arange(sizes.frames)
    root, steps = file["VTKHDF"], file["VTKHDF/Steps"]
    root.attrs["Version"] = np.array([2, 0], dtype=np.int64)
    root.attrs.create("Type", b"UnstructuredGrid", dtype=h5py.string_dtype("ascii", 16))
    for what, number in (("Points", n_nodes), ("Cells", n_elem), ("ConnectivityIds", 4 * n_elem)):
        root[f"NumberOf{what}"][...] = number
    root["Connectivity"][...] = model.quads.ravel()
    root["Offsets"][...] = np.arange(n_elem + 1) * 4
    root["Types"][...] = QUAD
    for what in ("Part", "Point", "Cell", "ConnectivityId"):
        steps[f"{what}Offsets"][...] = 0
    steps["NumberOfParts"][...] = 1
    for name, (place, (size, *_)) in sizes.shown.items():
        steps[f"{place}Offsets/{name}"][...] = frames * size
    for place, shown in links(sizes).items():
        file[place] = file[shown]
    steps.attrs["NSteps"] = np.int64(0)


def show_frames(file, first, times):
    """Let the view show the frames from ``first`` on, which are written, at ``times``."""
    count = first + len(times)
    file.flush()
    # VTK reads all values into room for NSteps: there must never be more of them
    file["VTKHDF/Steps"].attrs.modify("NSteps", np.int64(count))
    file.flush()
    file[TIMES].resize((count,))
    file[TIMES][first:] = times
    file.flush()


def frames_shown(file):
    """How many frames the view shows."""
    return int(file["VTKHDF/Steps"].attrs["NSteps"])


def copy_times(file, longer):
    """The times of all frames of a ``file`` into a ``longer`` one."""
    times = file[TIMES][...]
    longer[TIMES].resize(times.shape)
    longer[TIMES][...] = times
