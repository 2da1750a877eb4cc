"""Verdicts of the timings: ratios beside the paper's.  Seconds of unknown machines compare not."""

from corovec.solver.kernels.lanes import WIDTH
from corovec.verification.case import Row

from .printed import doubts

RATIO = 0.25
"""What compilers and caches may change of dense/skyline, relative."""

MACHINES = 2.0
"""By how much machines differ on the finest meshes of the other tables (seen: 0.9 to 1.9)."""

CACHE = 32e6
"""Bytes of a full matrix beyond which dense elimination waits for memory."""

UNKNOWN = ("the paper's machine, compiler and elimination are not known: the ratio lies between 1, "
           "where steps are not elimination, and that of the operations, where they are nothing "
           f"else, times the {WIDTH} numbers of a vector instruction where dense elimination "
           "waits for memory and the skyline does not (the paper's own Table 6: 2.7 times)")


def verdicts(ratios):
    """``Row`` s of a table's ratios (``ratios``)."""
    doubted = doubts()
    for row in ratios:
        if row.get("dense_skyline") is None:
            continue
        doubt = doubted.get(row["table"])
        larger = row["dense_skyline"] > row["paper"]
        waiting = WIDTH if 8.0 * row["unknowns"]**2 > CACHE else 1.0
        bound = waiting * row["operations"] if larger else 1.0
        if doubt and larger:
            bound = MACHINES * doubt["factor"] * row["paper"]
        yield Row(f"{row['elements']} elements: dense Gauss / skyline LDLT", row["dense_skyline"],
                  row["paper"], "published", RATIO, "another machine",
                  explanation=doubt["why"] if doubt else UNKNOWN,
                  covers=abs(bound / row["paper"] - 1.0))
