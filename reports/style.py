"""One look for all figures, and how they are written: SVG, PNG or PDF, with their data as CSV.

Colours are those of Okabe and Ito, which colour-blind eyes tell apart, and every curve of a panel
has a line style of its own as well, so that a grey print can be read.
"""

from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import Annotated

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox
from pandas import DataFrame

from corovec.solver.checks import choice, shown
from corovec.solver.errors import InputError
from corovec.solver.results.files import replacing, writable_path
from corovec.solver.signatures import File, checked

BLUE, ORANGE, GREEN, PURPLE, BLACK, SKY, VERMILLION = (
    "#0072B2", "#E69F00", "#009E73", "#CC79A7", "#000000", "#56B4E9", "#D55E00")

CURVES = ((BLUE, "-"), (VERMILLION, (0, (5, 1.5))), (BLACK, (0, (1, 1))),
          (GREEN, (0, (4, 1.2, 1, 1.2))), (PURPLE, (0, (8, 2))), (ORANGE, (0, (2, 1.5))),
          (SKY, "-"))
"""Colour and line style of the curves of a panel, in this order."""

MARKERS = "osD^v"

COLOURS = "YlGnBu"
"""Colour map of element values: from light to dark, the same to colour-blind eyes and in grey."""

SIGNED = "PuOr_r"
"""That of values of either sign: white is zero, orange is positive; grey has their size alone."""

STYLE = {
    "font.family": "DejaVu Sans", "font.size": 8.0, "axes.labelsize": 8.0, "axes.titlesize": 8.5,
    "legend.fontsize": 7.5, "xtick.labelsize": 7.5, "ytick.labelsize": 7.5, "axes.grid": True,
    "grid.color": "0.88", "grid.linewidth": 0.5, "axes.axisbelow": True, "axes.linewidth": 0.6,
    "axes.spines.top": False, "axes.spines.right": False, "lines.linewidth": 1.2,
    "lines.markersize": 4.5, "legend.frameon": False, "legend.handlelength": 3.0,
    "figure.dpi": 72.0, "savefig.dpi": 220.0, "svg.hashsalt": "corovec", "pdf.fonttype": 42,
    "text.usetex": False, "axes.formatter.limits": (-3, 4), "axes.formatter.use_mathtext": True,
    "path.simplify": True}

WIDTH = 6.7
"""Inches: a text column of a page, 170 mm."""

MARGIN = 0.05
"""Inches of white around a figure."""

FORMATS = {"svg": {"Date": None, "Creator": None}, "png": {"Software": None},
           "pdf": {"CreationDate": None, "Creator": None, "Producer": None}}
"""Formats of figures, each with what keeps dates out of the file."""


@contextmanager
def style():
    """The settings of all figures, while they are made and while they are written."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(STYLE)
        yield


def styled(function):
    """Call ``function`` with ``style`` in force."""
    @wraps(function)
    def call(*arguments, **options):
        with style():
            return function(*arguments, **options)
    return call


def _formats(name, formats):
    """Some of ``FORMATS``."""
    given = () if isinstance(formats, str) or not np.iterable(formats) else tuple(formats)
    if not given:
        raise InputError(f"{name} must be a list of {', '.join(FORMATS)}, is {shown(formats)}")
    return tuple(choice("format", kind, FORMATS) for kind in given)


def targets(folder, name, formats=("svg", "png")):
    """Paths of the files that ``save`` writes."""
    formats = _formats("formats", formats)
    return [Path(folder) / f"{name}.{kind}" for kind in (*formats, "csv")]


@checked
@styled
def save(figure: Figure, data: DataFrame, folder: File, name: str,
         formats: Annotated[tuple, _formats] = ("svg", "png"), overwrite: bool = False):
    """Write a figure in each of ``formats``, and its data as CSV; returns the paths.

    Every file is complete or not there.  The same figure makes the same bytes.

    Raises:
        InputError: a format that is not among ``FORMATS``.
        ResultFileError: a file exists and is not to be overwritten, or cannot be written.
    """
    paths = [writable_path(path, overwrite) for path in targets(folder, name, formats)]
    figure.draw_without_rendering()
    figure.set_layout_engine(None)  # the layout found serves all formats
    for axes in figure.axes:  # its last digits are not the same every time
        axes.set_position(np.round(axes.get_position(original=True).bounds, 6))
    box = Bbox(np.round(figure.get_tightbbox().padded(MARGIN).get_points(), 4))
    for path, kind in zip(paths, (*formats, "csv")):
        with replacing(path) as partial:
            if kind == "csv":
                data.to_csv(partial, index=False, errors="backslashreplace")
            else:
                figure.savefig(partial, format=kind, metadata=FORMATS[kind], bbox_inches=box)
    return paths
