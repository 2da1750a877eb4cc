"""Figures of histories: energies, momenta, displacements over time, convergence.

Curves that may coincide lie one upon the other, wide and light below, thin and dark above.
"""

from itertools import cycle
from typing import Annotated, NamedTuple

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, PercentFormatter

from corovec.solver.checks import choice, instance, vector
from corovec.solver.dynamics.energies import COLUMNS, run_of, table_of
from corovec.solver.dynamics.result import End, total_energy
from corovec.solver.errors import InputError
from corovec.solver.names import mathtext, shortened
from corovec.solver.results.frame import Rows, data_frame
from corovec.solver.results.layout import DYNAMICS, STATICS
from corovec.solver.signatures import checked

from .recording import Recording
from .style import (
    BLACK,
    BLUE,
    COLOURS,
    CURVES,
    GREEN,
    MARKERS,
    PURPLE,
    VERMILLION,
    WIDTH,
    styled,
)

MOST_ROWS = 20_000
"""Rows of a history that are drawn at most: beyond, every n-th one, evenly."""

ENERGIES = {
    "total_energy": {"color": "0.78", "linewidth": 4.5},
    "external_work": {"color": BLACK, "linestyle": (0, (4, 2)), "linewidth": 1.0},
    "kinetic_energy": {"color": BLUE},
    "strain_energy": {"color": VERMILLION, "linestyle": (0, (5, 1.5))},
    "support_work": {"color": GREEN, "linestyle": (0, (4, 1.2, 1, 1.2))},
    "dissipated": {"color": PURPLE, "linestyle": (0, (8, 2))}}
"""How each energy is drawn: the work, which is the total where the shell began at rest, upon it."""

PERIODS, LAST = 40, 6
"""A curve that swings more often is drawn thin, and below it its last swings at a larger scale."""

ROUNDING = 1e-9
"""Half the least range of a momentum's axis, relative to the momentum's scale: what is smaller is
rounding and is seen as the zero it is."""


class Curve(NamedTuple):
    """Errors of a sequence of meshes, and the slope of their regression against sqrt(elements),
    NaN or None if they have none."""

    name: str
    elements: tuple
    errors: tuple
    slope: float


def _several(name, recordings):
    """A list of ``Recording`` s, not empty."""
    if not np.iterable(recordings) or not (found := list(recordings)):
        raise InputError(f"{name} must be a list of recordings, not empty")
    return [instance(f"{name}[{k}]", one, Recording) for k, one in enumerate(found)]


def _points(name, points):
    """``{name: place}``, not empty."""
    if not instance(name, points, dict):
        raise InputError(f"{name} must not be empty")
    return {point: vector(f"{name}[{point!r:.80}]", place, "m") for point, place in points.items()}


def _components(name, components):
    """``{name of a point: letters}`` of x, y and z."""
    for point, letters in instance(name, components, dict).items():
        for letter in instance(f"{name}[{point!r:.80}]", letters, str):
            choice(f"{name}[{point!r:.80}]", letter.lower(), tuple("xyz"))
    return components


def _curves(name, curves):
    """A list of ``Curve`` s, not empty."""
    if not np.iterable(curves) or not (found := list(curves)):
        raise InputError(f"{name} must be a list of curves, not empty")
    return [instance(f"{name}[{k}]", one, Curve) for k, one in enumerate(found)]


NOTHING = 1e-12
"""Part of the largest energy of an item below which one is not drawn."""

Recordings = Annotated[list, _several]


@checked
@styled
def energies(history: Rows, unloaded_at: End = np.inf, end: float = None):
    """Kinetic, strain and total energy and the work of the loads over time.

    Figs. 3, 8, 11, 15.  Work of supports and energy dissipated by damping where there is any.  In
    statics the strain energy over the load factor.  Of more than ``PERIODS`` swings the last
    ``LAST`` are drawn again, below and larger.

    Args:
        history: of a ``Result`` or ``read``.
        unloaded_at: time from which no load acts [s]; the time before is shaded.
        end: last time that is drawn [s]; default: all.

    Returns:
        (Figure, DataFrame): columns time, kinetic_energy, strain_energy, total_energy,
        external_work, and support_work, dissipated where these are not zero; in statics factor,
        strain_energy.
    """
    if "factor" in history.dtype.names:
        figure, ((axes,),) = _panels(1, None, 0.45 * WIDTH)
        data = pd.DataFrame({name: history[name] for name in ("factor", "strain_energy")})
        axes.plot(data["factor"], data["strain_energy"], color=BLUE, marker="o", markersize=3.0)
        axes.set(xlabel="load factor", ylabel="strain energy [J]")
        return figure, data
    rows = _rows(history, end)
    data = pd.DataFrame({
        "time": rows["time"], "kinetic_energy": rows["kinetic_energy"],
        "strain_energy": rows["strain_energy"], "total_energy": total_energy(rows),
        "external_work": rows["external_work"],
        **{name: rows[name] for name in ("support_work", "dissipated") if history[name].any()}})
    window = _last_swings(data["time"], [data["kinetic_energy"], data["strain_energy"]])
    figure, panels = _panels(1, window, 0.45 * WIDTH)
    for (axes,), swung in zip(panels, (window, None)):
        for column in (name for name in ENERGIES if name in data):
            axes.plot(data["time"], data[column], label=column.replace("_", " "),
                      **_thin(ENERGIES[column], swung))
        _over_time(axes, data["time"], unloaded_at)
        axes.set_ylabel("energy [J]")
    _magnify(panels, window)
    _legend(figure, panels[-1][0])
    return figure, data


UNITS = {"reaction": "N", "reaction_moment": "N m", "_u": "m", "_v": "m/s", "_n": "N/m", "_m": "N",
         "_q": "N/m", "_von_mises": "Pa", "_strain_energy": "J", "_angle": "rad", "_rate": "rad/s",
         "_moment": "N m", "_force": "N", "_stored": "J", "_work": "J", "_lost": "J",
         "_slide": "m", "_speed": "m/s", "_couple": "N m", "_second": "rad"}
"""Of resultants, and of the columns of probes by their ends."""

MAY_BE_NONE = ("_angle", "_rate", "_moment", "_stored", "_work", "_lost", "_slide", "_speed",
               "_couple", "_second")
"""Ends of columns that are not drawn where they are zero: what a joint does not have."""


def tracked(history):
    """Columns of a history that ``probes`` draws: resultants of reactions that are not zero, and
    what probes kept."""
    known = {*DYNAMICS.names, *STATICS.names} - {"reaction", "reaction_moment"}
    return [name for name in history.dtype.names
            if name not in known and "." not in name
            and (not name.startswith("reaction") or history[name].any())]


@checked
@styled
def probes(history: Rows, unloaded_at: End = np.inf, end: float = None):
    """Resultants of the reactions, and what probes kept, over time (in statics the load factor).

    Args:
        history: of a ``Result`` or ``read``.
        unloaded_at: time from which no load acts [s]; the time before is shaded.
        end: last time that is drawn [s]; default: all.

    Returns:
        (Figure, DataFrame): columns time (or factor), and those of ``data_frame``; what a joint
        does not have, as energy of a spring, has columns of zeros and is not drawn.

    Raises:
        InputError: neither reactions nor probes are there.
    """
    names = tracked(history)
    if not names:
        raise InputError("history has neither reactions nor probes")
    static = "factor" in history.dtype.names
    across, rows = ("factor", history) if static else ("time", _rows(history, end))
    table = data_frame(rows)
    parts_of = {name: [part for part in table if part == name or (
        part.rpartition("_")[0] == name and part not in names)] for name in names}
    drawn = [part for parts in parts_of.values() for part in parts]
    names = [name for name in names if np.any(rows[name]) or not name.endswith(MAY_BE_NONE)]
    figure, (column,) = _panels(len(names), None, 0.3 + 1.45 * len(names))
    for axes, name in zip(column, names):
        unit = next(unit for ending, unit in UNITS.items() if name.endswith(ending))
        parts = parts_of[name]
        for part, (colour, dashes) in zip(parts, CURVES):
            axes.plot(table[across], table[part], color=colour, linestyle=dashes,
                      label=part.removeprefix(f"{name}_"))
        if not static:
            _over_time(axes, table[across], unloaded_at)
        axes.set_xlabel("")
        axes.set_ylabel(f"{mathtext(name)} [{unit}]")
        if len(parts) > 1:
            axes.legend(loc="upper right", ncols=len(parts), fontsize=6.5)
    column[-1].set_xlabel("load factor" if static else "time [s]")
    return figure, table[[across, *drawn]]


@checked
@styled
def energies_by_item(run: Annotated[tuple, run_of], unloaded_at: End = np.inf):
    """Energies over time of the shell, bodies, joints, springs, loads and supports of a run.

    A panel each for what is kinetic, stored, dissipated and done as work, where there is any; of
    more items than there are curves the smaller ones together.

    Args:
        run: ``Result``, or what ``read`` returns of a run in time.
        unloaded_at: time from which no load acts [s]; the time before is shaded.

    Returns:
        (Figure, DataFrame): that of ``energy_table``.

    Raises:
        InputError: no run in time.
    """
    history, names = run
    table = table_of(_rows(history, None), names)
    wide = {what: table.pivot(index="time", columns=["item", "kind"], values=what)
            for what in COLUMNS}
    items = list(dict.fromkeys(zip(table["item"], table["kind"])))
    least = NOTHING * max(values.abs().to_numpy().max() for values in wide.values())
    sizes = {what: values.abs().max() for what, values in wide.items()}
    shown = [what for what in COLUMNS if sizes[what].max() > least]
    ranked = sorted(items, key=lambda item: -max(sizes[what][item] for what in shown or COLUMNS))
    single = [item for item in items if item in ranked[:len(CURVES) - (len(items) > len(CURVES))]]
    figure, (column,) = _panels(max(len(shown), 1), None, 0.4 + 1.6 * max(len(shown), 1))
    for axes, what in zip(column, shown or COLUMNS[:1]):
        values = wide[what]
        for item, (colour, dashes) in zip(single, CURVES):
            if sizes[what][item] > least:
                axes.plot(values.index, values[item], color=colour, linestyle=dashes,
                          label=mathtext(shortened(item[0])))
        if rest := [item for item in items if item not in single and sizes[what][item] > least]:
            axes.plot(values.index, values[rest].sum(axis=1), color="0.6", linewidth=0.9,
                      label=f"{len(rest)} others" if len(rest) > 1 else rest[0][0])
        _over_time(axes, values.index.to_numpy(), unloaded_at)
        axes.set(xlabel="", ylabel=f"{what} [J]")
        if axes.get_legend_handles_labels()[0]:
            axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    column[-1].set_xlabel("time [s]")
    return figure, table


@checked
@styled
def total_energies(recordings: Recordings):
    """Total energy over time, mesh by mesh (Fig. 3d), and how far the meshes are apart.

    The second panel, of runs that go on after their loads, has the energies from then on, in joules
    and relative to the finest mesh.

    Returns:
        (Figure, DataFrame): columns run, elements, time, total_energy.
    """
    finest = max(recordings, key=lambda recording: recording.elements)
    unloaded_at = recordings[0].unloaded_at
    labels, looks = _labels(recordings), _layers(len(recordings))
    runs = [_rows(one.history, None) for one in recordings]
    data = pd.concat([pd.DataFrame({
        "run": one.name, "elements": one.elements, "time": rows["time"],
        "total_energy": total_energy(rows)}) for one, rows in zip(recordings, runs)],
        ignore_index=True)
    free = data[data["time"] >= unloaded_at]
    apart = unloaded_at < data["time"].max() and np.ptp(free["total_energy"]) > 0.0
    figure = Figure(figsize=(WIDTH, 0.45 * WIDTH), layout="constrained")
    panels = figure.subplots(1, 1 + apart, squeeze=False)[0]
    for axes in panels:
        for rows, label, look in zip(runs, labels, looks):
            axes.plot(rows["time"], total_energy(rows), label=label, **look)
        _over_time(axes, data["time"], unloaded_at)
    panels[0].set_ylabel("total energy [J]")
    if apart:
        level = total_energy(finest.history)[-1]
        low, high = free["total_energy"].min(), free["total_energy"].max()
        panels[1].set(xlim=(unloaded_at, data["time"].max()), title="after unloading",
                      ylim=(low - 0.12 * (high - low), high + 0.12 * (high - low)))
        panels[1].ticklabel_format(axis="y", useOffset=False)
        beside = panels[1].secondary_yaxis("right", functions=(
            lambda energy: 100.0 * (energy / level - 1.0), lambda part: level * (1 + part / 100.0)))
        beside.set_ylabel(f"relative to {labels[recordings.index(finest)]} [%]")
        beside.spines["right"].set_visible(True)
    _legend(figure)
    return figure, data


@checked
@styled
def momenta(history: Rows, unloaded_at: End = np.inf, end: float = None):
    """Linear and angular momentum about the origin over time, the latter by both definitions.

    Figs. 3b, 3c, 8, 16.  Angular momentum of the consistent mass, sum m_ij x_i x v_j, and as
    Eq. (50) prints it, with a single sum; the lowest panel shows their difference.

    Args: as of ``energies``.

    Returns:
        (Figure, DataFrame): column time, and for each momentum its components, as
        linear_momentum_x.

    Raises:
        InputError: the history of a static path.
    """
    if "factor" in history.dtype.names:
        raise InputError("a static path has no momenta")
    rows = _rows(history, end)
    names = ("linear_momentum", "angular_momentum", "angular_momentum_printed")
    data = pd.DataFrame({"time": rows["time"],
                         **{f"{name}_{c}": rows[name][:, k] for name in names
                            for k, c in enumerate("xyz")}})
    figure = Figure(figsize=(WIDTH, 0.95 * WIDTH), layout="constrained")
    upper, middle, lower = figure.subplots(3, 1, sharex=True, height_ratios=(1, 1, 0.7))
    time = data["time"]
    differences = rows[names[2]] - rows[names[1]]
    often = _last_swings(time, differences.T)
    for k, ((colour, dashes), width) in enumerate(zip(CURVES, (4.0, 2.0, 1.0))):
        consistent, printed = (rows[name][:, k] for name in names[1:])
        looks = {"color": colour, "linestyle": dashes}
        upper.plot(time, rows[names[0]][:, k], label="XYZ"[k], linewidth=width,
                   color=colour if k else _light(colour), linestyle=dashes)
        middle.plot(time, consistent, color=_light(colour), linewidth=4.5, zorder=1.9)
        middle.plot(time, printed, linewidth=1.0, **looks)
        lower.plot(time, differences[:, k], **_thin({**looks, "linewidth": 0.9}, often))
    for axes, scale in ((upper, "momentum_scale"), (middle, "angular_scale"),
                        (lower, "angular_scale")):
        _over_time(axes, time, unloaded_at)
        _at_least(axes, ROUNDING * history[scale].max())
    for axes in (upper, middle):
        axes.set_xlabel("")
    upper.set_ylabel("linear momentum\n[kg m/s]")
    middle.set_ylabel("angular momentum\n[kg m²/s]")
    lower.set_ylabel("as printed −\nconsistent [kg m²/s]")
    middle.set_title("wide, light: consistent mass; thin, dark: as printed, Eq. (50)", loc="right",
                     size=7.5)
    _legend(figure)
    return figure, data


@checked
@styled
def displacements(recordings: Recordings, points: Annotated[dict, _points],
                  components: Annotated[dict, _components] = None):
    """Displacements of points over time, run by run (Figs. 4, 12).

    Of more than ``PERIODS`` swings the last ``LAST`` are drawn again, below and larger.

    Args:
        recordings: of one shell, on several meshes or of several settings.
        points: ``{name: (x, y, z)}``, initial places of nodes that all meshes have [m].
        components: ``{name: "xyz"}``, which components to draw; default: all.

    Returns:
        (Figure, DataFrame): columns run, elements, time (in statics factor), point, component,
        displacement.

    Raises:
        InputError: a mesh without a node at a point, or runs beside static paths.
    """
    static = recordings[0].static
    if any(recording.static != static for recording in recordings):
        raise InputError("a run and a static path cannot share a figure")
    across = "factor" if static else "time"
    names = [(name, c) for name in points for c in (components or {}).get(name, "xyz").lower()]
    data = pd.concat([pd.DataFrame({
        "run": recording.name, "elements": recording.elements, across: recording.times,
        "point": name, "component": c,
        "displacement": recording.at(points[name])[:, "xyz".index(c)]})
        for name, c in names for recording in recordings], ignore_index=True)
    drawn = data.groupby(["point", "component", "run"], sort=False)
    labels, looks = _labels(recordings), _layers(len(recordings))
    window = None if static else _last_swings(recordings[-1].times, [
        drawn.get_group((*name, recordings[-1].name))["displacement"] for name in names])
    figure, panels = _panels(len(names), window, 0.3 + 1.45 * len(names))
    for column, swung in zip(panels, (window, None)):
        for axes, (name, c) in zip(column, names):
            for recording, label, look in zip(recordings, labels, looks):
                rows = drawn.get_group((name, c, recording.name))
                axes.plot(rows[across], rows["displacement"], label=label, **_thin(look, swung))
            _over_time(axes, data[across], recordings[0].unloaded_at)
            axes.set_xlabel("")
            axes.set_ylabel(f"{c.upper()} displacement\nof {mathtext(name)} [m]")
        for axes in column if window else column[-1:]:
            axes.set_xlabel("load factor" if static else "time [s]")
    _magnify(panels, window)
    _legend(figure, panels[-1][0])
    return figure, data


@checked
@styled
def convergence(curves: Annotated[list, _curves]):
    """Errors against the elements along an edge on logarithmic axes, with their slopes (Fig. 5).

    Each line has its regression's slope and passes through the means of the logarithms, where
    least squares put it; without a slope there is none.  Errors that are not positive (the
    reference mesh itself) have no place.

    Args:
        curves: ``Curve`` s.

    Returns:
        (Figure, DataFrame): columns curve, elements, error, fit (of the line).
    """
    figure = Figure(figsize=(0.62 * WIDTH, 0.5 * WIDTH), layout="constrained")
    axes, tables = figure.add_subplot(xscale="log", yscale="log"), []
    for curve, marker, (colour, dashes) in zip(curves, MARKERS, cycle(CURVES)):
        n, errors = np.asarray(curve.elements, dtype=float), np.asarray(curve.errors, dtype=float)
        n, errors = n[errors > 0.0], errors[errors > 0.0]
        edge = np.log(np.sqrt(n))
        slope = np.nan if curve.slope is None else curve.slope
        fit = np.exp(np.log(errors).mean() + slope * (edge - edge.mean()))
        axes.plot(np.exp(edge), errors, marker, color=colour, label=mathtext(curve.name),
                  fillstyle="full" if marker == "o" else "none")
        if np.isfinite(slope):
            axes.plot(np.exp(edge), fit, color=colour, linestyle=dashes, linewidth=0.9,
                      label=f"slope {slope:.2f}")
        tables.append(pd.DataFrame({"curve": curve.name, "elements": n.astype(int),
                                    "error": errors, "fit": fit}))
    data = pd.concat(tables, ignore_index=True)
    meshes = np.unique(data["elements"])
    axes.set_xticks(np.sqrt(meshes), [str(n) for n in meshes])
    axes.minorticks_off()
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=2))
    axes.set(xlabel="elements (spaced by their root)", ylabel="relative error of the energy")
    axes.legend()
    return figure, data


def _rows(history, end):
    """The rows that are drawn: until ``end``, at most about ``MOST_ROWS``, the last one always."""
    if end is not None:
        if not history["time"][0] < end <= history["time"][-1] * (1.0 + 1e-9):
            raise InputError(f"end {end:g} s is not within the history, which ends at "
                             f"{history['time'][-1]:g} s")
        history = history[history["time"] <= end * (1.0 + 1e-9)]
    every = -(-len(history) // MOST_ROWS)
    last = len(history) - 1
    return history[np.append(np.arange(0, last, every), last)]


def _labels(recordings):
    """Names of the curves of several runs: their meshes, or the runs where meshes are the same."""
    sizes = [recording.elements for recording in recordings]
    return [f"{size} elements" if len(set(sizes)) == len(sizes) else mathtext(recording.name)
            for size, recording in zip(sizes, recordings)]


def _light(colour):
    """A light tint of a colour."""
    return tuple(1.0 - 0.38 * (1.0 - part) for part in to_rgb(colour))


def _layers(n):
    """How each of ``n`` curves is drawn that may coincide: all are seen where they do, in grey too.
    """
    if n == 1:
        return [{"color": BLUE}]
    tints = colormaps[COLOURS](np.linspace(0.3, 1.0, n))
    return [{"color": tuple(tint), "linewidth": width, "solid_capstyle": "butt"}
            for tint, width in zip(tints, np.linspace(0.8 + 1.6 * (n - 1), 0.8, n))]


def _thin(looks, swung):
    """How a curve is drawn that swings often: thin and solid, if it is not wide to lie below."""
    width = looks.get("linewidth", 1.2)
    return looks if swung is None or width > 2.0 else {
        **looks, "linewidth": 0.5 * width, "linestyle": "-"}


def _last_swings(time, curves):
    """(start, end) of the last ``LAST`` swings of that curve which swings most; None if that is
    not often.  A swing leads from the lower third of a curve's range into its upper one and back.
    """
    found = [_swings(np.asarray(curve)) for curve in curves]
    starts = max(found, key=len)
    return (float(time[starts[-LAST - 1]]), float(time.max())) if len(starts) > PERIODS else None


def _swings(values):
    """Indices where a curve comes into the upper third of its range from the lower one."""
    third = np.ptp(values) / 3.0
    side = (values > values.max() - third).astype(int) - (values < values.min() + third)
    outside = np.flatnonzero(side)
    return outside[1:][np.diff(side[outside]) == 2]


def _panels(n, window, height):
    """A figure of ``n`` panels of ``height`` [inches] together, each time with its window beneath
    if there is one: (Figure, [panels, their windows])."""
    rows = n if window is None else 2 * n
    figure = Figure(figsize=(WIDTH, height * rows / n), layout="constrained")
    column = figure.subplots(rows, 1, squeeze=False)[:, 0]
    return figure, [column[k::rows // n] for k in range(rows // n)]


def _magnify(panels, window):
    """Show the window in the panels beneath, and frame it in those above."""
    if window is not None:
        for whole, part in zip(*panels):
            part.set_xlim(window)
            whole.axvspan(*window, facecolor="none", edgecolor="0.2", linewidth=0.8, zorder=4)
            whole.set_title("framed: enlarged below", loc="right", size=7.5)


def _over_time(axes, time, unloaded_at):
    """The axis of time, with the time under load shaded."""
    first, last = time.min(), time.max()
    axes.set(xlim=(first, last), xlabel="time [s]")
    if unloaded_at > first and np.isfinite(unloaded_at):
        axes.axvspan(first, min(unloaded_at, last), color="0.93", linewidth=0.0, zorder=0,
                     label="loaded")


def _at_least(axes, half):
    """Give the vertical axis a range of ``half`` at least on either side of its middle."""
    low, high = axes.get_ylim()
    if high - low < 2.0 * half:
        axes.set_ylim(0.5 * (low + high) - half, 0.5 * (low + high) + half)


def _legend(figure, axes=None):
    """One legend above all panels, from ``axes``; default: the first one."""
    handles, labels = (axes or figure.axes[0]).get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=min(len(labels), 5))
