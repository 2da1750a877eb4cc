"""All figures of one or several result files: what ``corovec plot`` draws."""

from functools import partial
from itertools import combinations

import numpy as np

from corovec.benchmarks import case_names, load_case
from corovec.solver.checks import number, positive
from corovec.solver.errors import InputError
from corovec.solver.runtime.provenance import fingerprint

from .colours import ENERGY, VON_MISES, coloured
from .curves import tracked
from .figures import (
    displacements,
    energies,
    energies_by_item,
    mesh_and_loads,
    momenta,
    probes,
    sequence,
    total_energies,
)
from .recording import Recording
from .stress import stress


def open_together(paths):
    """Recordings of files whose figures go into one folder.

    Raises:
        ResultFileError: as of ``Recording.open``.
        InputError: files of the same name, of different cases, or of runs and static paths.
    """
    recordings = [Recording.open(path) for path in paths]
    for (one, first), (two, second) in combinations(zip(paths, recordings), 2):
        if first.name == second.name:
            raise InputError(f"{one} and {two}: figures are named by their files, whose names must "
                             "differ")
        if first.case != second.case:
            raise InputError(f"{one} is of {first.case or 'an own model'} and {two} of "
                             f"{second.case or 'an own model'}: plot them one by one")
        if first.static != second.static:
            raise InputError(f"{one} and {two}: a run and a static path, plot them one by one")
    return recordings


def gallery(recordings, at=(), interval=None, scale=1.0, view=None, color=ENERGY):
    """``{name: function}`` of all figures; each function draws one and returns it with its table.

    Args:
        recordings: of ``open_together``.
        at: initial places (x, y, z) of nodes whose displacement is drawn [m].
        interval: between the frames of the motion [s].
        scale: of the displacements.
        view: (elevation, azimuth) [degrees].
        color: what colours the elements, see ``coloured``.

    Raises:
        InputError: a place without a node, an interval longer than a run, or no stresses to colour
            by.
    """
    scale = number("scale", scale)
    points = _points(recordings, at)
    for recording in recordings:
        coloured(recording, color)
        for point in points.values():
            recording.at(point)
    figures = {}
    for recording in recordings:
        run, history, unloaded_at = recording.name, recording.history, recording.unloaded_at
        figures[f"{run}-mesh"] = partial(mesh_and_loads, *_model(recording), view=view)
        figures[f"{run}-energies"] = partial(energies, history, unloaded_at)
        if not recording.static and any("." in name for name in history.dtype.names):
            figures[f"{run}-energies-by-item"] = partial(energies_by_item, recording.contents,
                                                         unloaded_at)
        if not recording.static:
            figures[f"{run}-momenta"] = partial(momenta, history, unloaded_at)
        if tracked(history):
            figures[f"{run}-probes"] = partial(probes, history, unloaded_at)
        figures[f"{run}-motion"] = partial(sequence, recording, _times(recording, interval),
                                           scale, view, color)
        if "von_mises" in recording.contents:
            for name in dict.fromkeys((VON_MISES, VON_MISES if color == ENERGY else color)):
                figures[f"{run}-{name.replace('_', '-')}"] = partial(stress, recording, scale, view,
                                                                     name)
    several = len(recordings) > 1
    figures["displacements" if several else f"{recordings[0].name}-displacements"] = partial(
        displacements, recordings, points)
    if several and not recordings[0].static:
        figures["energies"] = partial(total_energies, recordings)
    return figures


def _model(recording):
    """The model and case of a benchmark, if they still are as they were run; else the mesh."""
    if recording.case in case_names():
        case, description = load_case(recording.case), recording.contents["description"]
        if recording.elements in case.sizes:
            model = case.model(recording.elements, membrane=description["membrane"],
                               shear=description["shear"])
            if fingerprint(model) == description["fingerprint"]:
                return model, case
    return recording, None


def _points(recordings, at):
    """``{name: place}`` of the nodes whose displacement is drawn."""
    if at:
        return {f"({x:g}, {y:g}, {z:g})": (x, y, z) for x, y, z in at}
    case = recordings[0].case
    if case in case_names() and (points := load_case(case).points):
        return {name: point.value for name, point in points.items()}
    coarsest = min(recordings, key=lambda recording: recording.elements)
    farthest = np.linalg.norm(coarsest.displacement, axis=2).max(axis=0).argmax()
    return _points(recordings, [coarsest.nodes[farthest].tolist()])


def _times(recording, interval):
    """Times of the frames of the motion, all that are recorded at most; or None."""
    if interval is None:
        return None
    last = recording.times.max()
    if positive("interval", interval) > last:
        raise InputError(f"interval {interval:g} is longer than {recording.name}, which ends at "
                         f"{last:g}")
    if last / interval > len(recording.times):
        return recording.times
    return np.arange(0.0, last * (1.0 + 1e-9), interval)
