"""The view that ParaView opens: a VTKHDF transient unstructured grid of links to the frames."""

import h5py
import numpy as np

from .checkpoint import reserve


def make_view(file, model, fields, n_frames):
    """The mesh, and links to the room for ``n_frames``; ``fields``: (place, name, values) each."""
    n_nodes, n_elem = len(model.nodes), len(model.quads)
    root = file.create_group("VTKHDF")
    root.attrs["Version"] = np.array([2, 0], dtype=np.int64)
    root.attrs.create("Type", b"UnstructuredGrid", dtype=h5py.string_dtype("ascii", 16))
    root["NumberOfPoints"] = np.array([n_nodes], dtype=np.int64)
    root["NumberOfCells"] = np.array([n_elem], dtype=np.int64)
    root["NumberOfConnectivityIds"] = np.array([4 * n_elem], dtype=np.int64)
    root["Points"] = file["model/nodes"]
    root["Connectivity"] = model.quads.ravel()
    root["Offsets"] = np.arange(n_elem + 1, dtype=np.int64) * 4
    root["Types"] = np.full(n_elem, 9, dtype=np.uint8)
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = np.int64(0)
    reserve(steps, "Values", (1,), maxshape=(n_frames,), chunks=(n_frames,))
    zeros, frames = np.zeros(n_frames, dtype=np.int64), np.arange(n_frames, dtype=np.int64)
    steps["PartOffsets"] = zeros
    steps["NumberOfParts"] = zeros + 1
    steps["PointOffsets"] = zeros
    steps["CellOffsets"] = zeros[:, None]
    steps["ConnectivityIdOffsets"] = zeros[:, None]
    for place, name, values in fields:
        root[f"{place}/{name}"] = file[f"frames/{name}"]
        steps[f"{place}Offsets/{name}"] = frames * len(values)


def show_frame(file, index, time):
    """Let the view show the frames up to ``index``, which are written; the last one at ``time``."""
    steps = file["VTKHDF/Steps"]
    file.flush()
    # VTK reads all values into room for NSteps: there must never be more of them
    steps.attrs.modify("NSteps", np.int64(index + 1))
    file.flush()
    steps["Values"].resize((index + 1,))
    steps["Values"][index] = time
    file.flush()


def copy_times(file, longer):
    """The times of all frames of a ``file`` into a ``longer`` one."""
    values, times = file["VTKHDF/Steps/Values"][...], longer["VTKHDF/Steps/Values"]
    times.resize(values.shape)
    times[...] = values
