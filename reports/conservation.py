"""The section of the page on conservation: what each scheme keeps, at which step, at what cost."""

from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from corovec.convergence.conservation import HALVED, KEPT, SCHEMES

from .drawings import benchmarks
from .style import CURVES, MARKERS, WIDTH, styled
from .tables import Table, number, percent

NAMES = {"paper": "quasi, global axes (the paper's)", "quasi": "quasi, axes that follow the nodes",
         "exact": "exact", "dissipating": "exact, dissipating (0.1, selective)",
         "trapezoidal": "trapezoidal rule",
         "generalized-alpha": "generalized-alpha (rho_inf = 0.8)",
         "fourth-order": "exact, of fourth order"}
"""The schemes of the study in words."""

LOOKS = dict(zip(SCHEMES, zip(CURVES, 2 * MARKERS)))
"""Colour and line style, and marker, of each scheme."""

FLOOR = 1e-17
"""Least drift that is drawn: a logarithmic axis has no zero."""


@dataclass(frozen=True)
class Comparison:
    """A drawing of the section.

    Attributes:
        name: of its files.
        title: its caption.
        make: (Figure, DataFrame) of the contents of ``study.json``.
        table: which of its tables it shows, and the column that must have a value.
    """

    name: str
    title: str
    make: Callable
    table: tuple
    dense = False

    def rows(self, study):
        """What it shows, as a DataFrame."""
        name, column = self.table
        return pd.DataFrame(study[name], columns=None if study[name] else [column]).dropna(
            subset=column)

    def available(self, study):
        """Whether there is anything to draw."""
        return bool(study) and not self.rows(study).empty

    def draw(self, study):
        """(Figure, DataFrame)."""
        return self.make(self.rows(study))

    def made_from(self, study, file):
        """What it is made from, in words, and its ``file``."""
        rows = self.rows(study)
        return SimpleNamespace(files=[file], words="; ".join(
            f"{_short(case)}: dt = {', '.join(f'{dt:g}' for dt in sorted(own['dt'].unique()))} s"
            for case, own in rows.groupby("case", sort=False)))


def summary(study):
    """What the exact scheme keeps, and which steps it and quasi hold, in words; empty without a
    flight of it."""
    drifts = {name: [row[f"{name}_drift"] for row in study["flights"]
                     if row["scheme"] == "exact" and row[f"{name}_drift"] is not None]
              for name in ("energy", "linear_momentum", "angular_momentum")}
    if not drifts["energy"]:
        return ""
    steps = {}
    for row in study["schemes"]:
        steps.setdefault(row["case"], {})[row["scheme"]] = (
            number(row["largest_step"], 2) + (" or more" if row["larger_untried"] else ""))
    held = "; ".join(f"{_short(case)} {of['exact']} s ({of['quasi']} s)"
                     for case, of in steps.items() if {"exact", "quasi"} <= set(of))
    kept = ", ".join(f"{name.replace('_', ' ')} {number(max(values), 2)}"
                     for name, values in drifts.items())
    n = len(drifts["energy"])
    return (f"drifts of {n} flight{'s' if n > 1 else ''} at most: {kept}; largest step that it "
            f"holds (quasi): {held}")


def largest(study):
    """The largest time step that each scheme holds, and what it keeps at it."""
    rows = [[_short(row["case"]), NAMES[row["scheme"]],
             number(row["largest_step"], 3) + ("+" if row["larger_untried"] else ""),
             number(row["of_paper"], 3), *_kept(row)] for row in study["schemes"]]
    return Table("The largest time step that each scheme holds, and what it keeps there",
                 ("case", "scheme", "largest step [s]", "of the paper's step", "energy drift",
                  "linear momentum", "angular momentum", "iterations a step",
                  "CPU s a simulated s"),
                 rows, [f"Held: the flight comes to its end with at most {percent(HALVED)} of its "
                        "steps halved, and from unloading to there energy and momenta drift by at "
                        f"most {percent(KEPT)}.  Energy: with what is dissipated.  +: no larger "
                        "step was tried."])


def flights(study):
    """Every flight."""
    rows = [[_short(row["case"]), NAMES[row["scheme"]], number(row["dt"], 3),
             number(row["reached"], 4) + ("" if row["reached"] > row["end_time"] * (1.0 - 1e-9)
                                          else f" of {row['end_time']:g}"),
             *_kept(row), number(row["energy_rise"], 2), percent(row["halved_share"]),
             number(row["path_error"], 2)] for row in study["flights"]]
    return Table("Every flight",
                 ("case", "scheme", "dt [s]", "until [s]", "energy drift", "linear momentum",
                  "angular momentum", "iterations a step", "CPU s a simulated s",
                  "rise of the energy", "steps halved", "error of the path"), rows,
                 ["Until: of a flight that failed, its last frame.  Rise: above what the "
                  "energy was at any time before.  CPU seconds are of this machine.  Error of "
                  "the path: the largest distance of a node from where small steps have it (of "
                  "quasi; of the L-plate of fourth order), relative to the largest displacement."])


@styled
def drift(rows):
    """Largest drift of the energy so far against time, case by case, on a logarithmic axis.

    Args:
        rows: columns case, scheme, dt, time, energy_drift.

    Returns:
        (Figure, DataFrame): the rows.
    """
    figure, panels = _panels(rows)
    for axes, (case, own) in zip(panels, rows.groupby("case", sort=False)):
        for scheme, curve in own.groupby("scheme", sort=False):
            (colour, dashes), _ = LOOKS[scheme]
            axes.plot(curve["time"], np.maximum(curve["energy_drift"], FLOOR), color=colour,
                      linestyle=dashes, label=NAMES[scheme])
        axes.set(yscale="log", xlabel="time [s]", ylabel="energy drift",
                 title=f"{_short(case)}, dt = {own['dt'].iloc[0]:g} s")
        axes.xaxis.set_major_locator(MaxNLocator(5))
    _legend(figure, panels)
    return figure, rows


@styled
def precision(rows):
    """Error of the path against the time that a simulated second takes, case by case.

    Args:
        rows: columns case, scheme, dt, cpu_per_second, path_error.

    Returns:
        (Figure, DataFrame): the rows that are drawn.
    """
    rows = rows[["case", "scheme", "dt", "cpu_per_second", "path_error"]].dropna()
    figure, panels = _panels(rows)
    for axes, (case, own) in zip(panels, rows.groupby("case", sort=False)):
        for scheme, curve in own.groupby("scheme", sort=False):
            (colour, dashes), marker = LOOKS[scheme]
            axes.plot(curve["cpu_per_second"], curve["path_error"], marker, color=colour,
                      linestyle=dashes, fillstyle="none", label=NAMES[scheme])
        axes.set(xscale="log", yscale="log", xlabel="CPU seconds a simulated second",
                 ylabel="error of the path", title=_short(case))
    _legend(figure, panels)
    return figure, rows


DRAWINGS = (
    Comparison("energy-drift", "Drift of the energy since unloading, at the same time step", drift,
               ("energy", "energy_drift")),
    Comparison("work-precision", "Work and precision: the error of the path against the time that "
               "a simulated second takes, from small steps to large ones", precision,
               ("flights", "path_error")))
"""The drawings of the section."""


def _kept(row):
    """Drifts, iterations and seconds of a flight as texts."""
    return [*(number(row[f"{name}_drift"], 2) for name in (
        "energy", "linear_momentum", "angular_momentum")),
        number(row["iterations_per_step"], 3), number(row["cpu_per_second"], 3)]


def _short(case):
    """A benchmark in few words."""
    known = benchmarks()
    return known[case].short if case in known else case


def _panels(rows):
    """A figure with a panel for each case of ``rows``, two side by side: (Figure, panels)."""
    n = rows["case"].nunique()
    figure = Figure(figsize=(WIDTH, 0.4 + 2.3 * -(-n // 2)), layout="constrained")
    panels = figure.subplots(-(-n // 2), min(n, 2), squeeze=False).ravel()
    for axes in panels[n:]:
        axes.remove()
    return figure, panels[:n]


def _legend(figure, panels):
    """One legend of all schemes above all panels."""
    found = {label: handle for axes in panels
             for handle, label in zip(*axes.get_legend_handles_labels())}
    figure.legend(found.values(), found, loc="outside upper center", ncols=2)
