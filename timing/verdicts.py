"""Verdicts of the timings: ratios beside the paper's.  Seconds of unknown machines compare not."""

from verification.case import Row

RATIO = 0.25
"""What compilers and caches may change of dense/skyline, relative."""

UNKNOWN = ("the paper's machine, compiler and elimination are not known: the ratio lies between 1, "
           "where steps are not elimination, and that of the operations, where they are nothing "
           "else")


def verdicts(ratios):
    """:class:`verification.case.Row` s of a table's ratios (:func:`timing.tables.ratios`)."""
    for row in ratios:
        if row.get("dense_skyline") is None:
            continue
        larger = row["dense_skyline"] > row["paper"]
        bound = row["operations"] if larger else 1.0
        yield Row(f"{row['elements']} elements: dense Gauss / skyline LDLT", row["dense_skyline"],
                  row["paper"], "published", RATIO, "another machine", explanation=UNKNOWN,
                  covers=abs(bound / row["paper"] - 1.0))
