"""Verdicts of the timings: ratios beside the paper's.  Seconds of unknown machines compare not."""

from verification.case import Row

RATIO = 0.25
"""What compilers and caches may change of dense/skyline, relative."""

MEMORY = 3.0
"""Times as long that a product of dense elimination may take, whose matrix no cache holds (the
paper's own ratio of Table 6 is 2.7 times that of the operations)."""

UNKNOWN = ("the paper's machine, compiler and elimination are not known: the ratio lies between 1, "
           "where steps are not elimination, and three times that of the operations, where they "
           "are nothing else and dense elimination waits for memory")


def verdicts(ratios):
    """:class:`verification.case.Row` s of a table's ratios (:func:`timing.tables.ratios`)."""
    for row in ratios:
        if row.get("dense_skyline") is None:
            continue
        larger = row["dense_skyline"] > row["paper"]
        bound = MEMORY * row["operations"] if larger else 1.0
        yield Row(f"{row['elements']} elements: dense Gauss / skyline LDLT", row["dense_skyline"],
                  row["paper"], "published", RATIO, "another machine", explanation=UNKNOWN,
                  covers=abs(bound / row["paper"] - 1.0))
