"""What other publications and elements give for the popular benchmarks."""

import tomllib
from functools import cache
from pathlib import Path

from .case import Row

PUBLISHED = Path(__file__).parent / "published"

MACNEAL = "MacNeal and Harder 1985, Finite Elem. Anal. Des. 1, 3-20"
SZE = "Sze, Liu and Lo 2004, Finite Elem. Anal. Des. 40, 1551-1569, "

OTHER = "other code"
TWO_PERCENT = "2 % asked of every mesh against MITC4, or better"

HEMISPHERE = 0.0940
"""Displacement of the linear hemisphere with a hole, of MacNeal and Harder."""

MITC4_HEMISPHERE = {4: 1.0372, 8: 0.9970, 16: 0.9905}
"""What MITC4 gives of it, by the elements along an edge."""


@cache
def published(file, name):
    """One table of a file of published results."""
    with open(PUBLISHED / f"{file}.toml", "rb") as text:
        return tomllib.load(text)[name]


def compare(name, value, reference, mitc4, kind="recalled", explanation="", covers=0.0):
    """Row: normalised value beside MITC4's on the same mesh.

    An explanation ``covers`` what was seen when it was written, and little more.
    """
    return Row(name, value / reference, mitc4, kind, 0.02, TWO_PERCENT, scale=1.0, target=1.0,
               explanation=explanation, covers=covers)
