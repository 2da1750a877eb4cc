"""The paper's figures: what each shows, how it is drawn, and which are the same picture."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from corovec.convergence.study import printed_results

from . import figures


@dataclass(frozen=True)
class Drawing:
    """One picture of the page.

    Attributes:
        name: of its files; figure: of the paper, as ``Figure 3``; title: caption.
        draw: makes (Figure, DataFrame) from ``Sources``; dense: a picture of many polygons,
            shown as PNG.
    """

    name: str
    figure: str
    title: str
    draw: Callable
    dense: bool = False


@dataclass(frozen=True)
class Sources:
    """What the drawings of a case are made from.

    Attributes:
        case: its definition; recordings: ``Recording`` s of its runs, the
            coarsest first, perhaps none; study: contents of ``study.json`` or None.
    """

    case: object
    recordings: list
    study: dict

    @property
    def finest(self):
        return self.recordings[-1]


def available(drawing, sources):
    """Whether what a drawing is made from is there."""
    if drawing.draw is _mesh:
        return True
    return sources.study is not None if drawing.draw is _rates else bool(sources.recordings)


def _mesh(sources):
    case = sources.case
    return figures.mesh_and_loads(case.model(case.defaults.elements), case)


def _energies(end=None):
    return lambda sources: figures.energies(sources.finest.history, sources.finest.unloaded_at, end)


def _momenta(sources):
    return figures.momenta(sources.finest.history, sources.finest.unloaded_at)


def _total(sources):
    return figures.total_energies(sources.recordings)


def _points(components=None):
    def draw(sources):
        points = {name: point.value for name, point in sources.case.points.items()}
        return figures.displacements(sources.recordings, points, components)
    return draw


def _rates(sources):
    """Errors by the paper's rule, finest mesh as reference: printed and ours."""
    study, printed = sources.study, printed_results(sources.case.name)
    slopes = next(row for row in study["summary"] if row["quantity"].startswith("slope"))
    errors = [float(text.rstrip("%")) / 100.0 for text in printed["error"]]
    mesh = study["mesh"]
    return figures.convergence([
        figures.Curve(f"printed, {printed['elements'][-1]} as reference",
                      tuple(printed["elements"]), tuple(errors), slopes["of_all_printed"]),
        *(figures.Curve(f"{name}, {mesh[-1]['elements']} as reference",
                        tuple(row["elements"] for row in mesh), tuple(row[error] for row in mesh),
                        slopes[slope])
          for name, error, slope in (("printed", "error_of_printed", "of_printed"),
                                     ("ours", "error", "ours")))])


def _motion(end, count):
    """Sequence at ``count`` + 1 instants until ``end`` [s], those that are recorded."""
    def draw(sources):
        times = np.linspace(0.0, end, count + 1)
        last = sources.finest.times[-1] * (1.0 + 1e-9)
        return figures.sequence(sources.finest, times[times <= last])
    return draw


MESH = "Mesh, loads and their functions of time"

DRAWINGS = {
    "l-plate": (
        Drawing("figure-02", "Figure 2", MESH, _mesh),
        Drawing("figure-03a", "Figure 3", "Energies", _energies()),
        Drawing("figure-03bc", "Figure 3", "Linear and angular momentum", _momenta),
        Drawing("figure-03d", "Figure 3", "Total energy, mesh by mesh", _total),
        Drawing("figure-04", "Figure 4", "Displacements of S, mesh by mesh", _points()),
        Drawing("figure-05", "Figure 5", "Error of the energy after unloading against the number "
                "of elements; slopes are over its root, as along an edge", _rates),
        Drawing("figure-06", "Figure 6", "Motion over 20 s, 1 s apart", _motion(20.0, 20), True)),
    "ruler": (
        Drawing("figure-07", "Figure 7", MESH, _mesh),
        Drawing("figure-08a", "Figure 8", "Energies", _energies()),
        Drawing("figure-08bc", "Figure 8", "Linear and angular momentum", _momenta),
        Drawing("figure-09", "Figure 9", "Motion over 0.4 s, 0.01 s apart", _motion(0.4, 40),
                True)),
    "hemisphere": (
        Drawing("figure-10", "Figure 10", MESH, _mesh),
        Drawing("figure-11a", "Figure 11", "Energies", _energies()),
        Drawing("figure-11b", "Figure 11", "Energies until 0.1 s", _energies(0.1)),
        Drawing("figure-12", "Figure 12", "Displacements of A in X and of B in Y",
                _points({"A": "x", "B": "y"})),
        Drawing("figure-13", "Figure 13", "Motion over 0.11 s, 0.01 s apart", _motion(0.11, 11),
                True)),
    "plates": (
        Drawing("figure-14", "Figure 14", MESH, _mesh),
        Drawing("figure-15", "Figure 15", "Energies", _energies()),
        Drawing("figure-16", "Figure 16", "Linear momentum (a); angular momentum by both "
                "definitions (b)", _momenta),
        Drawing("figure-17", "Figure 17", "Motion over 14 s, 1 s apart", _motion(14.0, 14),
                True))}

TOPICS = {
    "Figure 2": "mesh, loads", "Figure 3": "energies, momenta", "Figure 4": "displacements",
    "Figure 5": "convergence", "Figure 6": "motion", "Figure 7": "mesh, loads",
    "Figure 8": "energies, momenta", "Figure 9": "motion", "Figure 10": "mesh, loads",
    "Figure 11": "energies", "Figure 12": "displacements", "Figure 13": "motion",
    "Figure 14": "mesh, loads", "Figure 15": "energies", "Figure 16a": "linear momentum",
    "Figure 16b": "angular momentum", "Figure 17": "motion"}
"""What each figure is about, in few words; Figure 16 has a verdict for each of its halves."""

LOST = {
    "Figure 3": "curve of Lavrenčič and Brank, [73] of the paper",
    "Figure 8": "curves of Kuhl and Ramm, [72], and of Yang and Xia, [66]",
    "Figure 15": "curve of Chróścielewski and Witkowski, [77]",
}
"""Curves of other authors in the paper's figures: their data is lost, they are not redrawn."""


def figures_of(case):
    """The figures of a case that have a verdict."""
    drawn = dict.fromkeys(drawing.figure for drawing in DRAWINGS[case])
    return [name for name in TOPICS if name in drawn or name.rstrip("ab") in drawn]
