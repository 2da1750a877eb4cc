"""The paper's figures: what each shows, how it is drawn, and which are the same picture.

Which benchmarks and figures there are, and in which order, stands in ``drawings.toml``.
"""

import tomllib
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np

from corovec.convergence.study import printed_results

from . import figures

DRAWINGS = Path(__file__).with_name("drawings.toml")


@dataclass(frozen=True)
class Drawing:
    """One picture of the page.

    Attributes:
        name: of its files.
        title: caption.
        kind: one of ``KINDS``.
        options: of that kind.
    """

    name: str
    title: str
    kind: str
    options: dict = field(default_factory=dict)

    @property
    def dense(self):
        """Whether it is a picture of many polygons, shown as PNG."""
        return self.kind == "motion"

    def available(self, sources):
        """Whether what it is made from is there."""
        needs = KINDS[self.kind][1]
        return needs is None or bool(getattr(sources, needs))

    def recordings(self, sources):
        """The ``Recording`` s that it draws."""
        return {"recordings": sources.recordings,
                "finest": sources.recordings[-1:]}.get(KINDS[self.kind][1], [])

    def draw(self, sources):
        """(Figure, DataFrame) from ``Sources``."""
        return KINDS[self.kind][0](sources, **self.options)


@dataclass(frozen=True)
class PaperFigure:
    """A figure of the paper.

    Attributes:
        label: as ``Figure 3``.
        drawings: ``Drawing`` s that show it.
        topic: what it is about, in few words.
        halves: ``{letter: topic}`` where each half has a verdict of its own.
        lost: curves of other authors, whose data is lost and which are not redrawn.
        not_reproducible: why its picture cannot be the paper's; empty if it can.
        of_study: rows of the convergence study that are its verdict, by what is in their names.
        level: whether it shows the energy after unloading, which the study compares.
    """

    label: str
    drawings: tuple
    topic: str = ""
    halves: dict = field(default_factory=dict)
    lost: str = ""
    not_reproducible: str = ""
    of_study: tuple = ()
    level: bool = False

    @property
    def verdicts(self):
        """``{label: topic}`` of what has a verdict."""
        return {self.label + letter: topic for letter, topic in self.halves.items()} or {
            self.label: self.topic}


@dataclass(frozen=True)
class Shown:
    """A benchmark of the page.

    Attributes:
        name: of its file.
        short: its title, in few words.
        figures: ``PaperFigure`` s.
    """

    name: str
    short: str
    figures: tuple

    @property
    def verdicts(self):
        """``{label: (PaperFigure, topic)}`` of everything that has a verdict."""
        return {label: (figure, topic) for figure in self.figures
                for label, topic in figure.verdicts.items()}


@cache
def benchmarks():
    """``{name: Shown}`` of all benchmarks of the page, in its order."""
    with open(DRAWINGS, "rb") as file:
        return {name: Shown(name, entry["short"], tuple(map(_figure, entry["figures"])))
                for name, entry in tomllib.load(file).items()}


def _figure(entry):
    return PaperFigure(**{**entry, "drawings": tuple(Drawing(**drawing)
                                                     for drawing in entry["drawings"])})


@dataclass(frozen=True)
class Sources:
    """What the drawings of a case are made from.

    Attributes:
        case: its definition.
        recordings: ``Recording`` s of its runs, the coarsest first, perhaps none.
        study: contents of ``study.json`` or None.
    """

    case: object
    recordings: list
    study: dict

    @property
    def finest(self):
        """The recording on the finest mesh of the case; None if there is none."""
        return self.recordings[-1] if self.recordings else None


def _mesh(sources):
    case = sources.case
    return figures.mesh_and_loads(case.model(case.defaults.elements), case)


def _energies(sources, end=None):
    return figures.energies(sources.finest.history, sources.finest.unloaded_at, end)


def _momenta(sources):
    return figures.momenta(sources.finest.history, sources.finest.unloaded_at)


def _total(sources):
    return figures.total_energies(sources.recordings)


def _displacements(sources, components=None):
    points = {name: point.value for name, point in sources.case.points.items()}
    return figures.displacements(sources.recordings, points, components)


def _convergence(sources):
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


def _motion(sources, end, intervals):
    """Sequence at ``intervals`` + 1 instants until ``end`` [s], those that are recorded."""
    times = np.linspace(0.0, end, intervals + 1)
    last = sources.finest.times[-1] * (1.0 + 1e-9)
    return figures.sequence(sources.finest, times[times <= last])


KINDS = {"mesh": (_mesh, None), "energies": (_energies, "finest"),
         "momenta": (_momenta, "finest"), "total energies": (_total, "recordings"),
         "displacements": (_displacements, "recordings"), "convergence": (_convergence, "study"),
         "motion": (_motion, "finest")}
"""How each kind is drawn, and the one of the ``Sources`` that it needs."""
