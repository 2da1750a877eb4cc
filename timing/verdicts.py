"""Verdicts of the timings: ratios beside the paper's.  Seconds of unknown machines compare not."""

from verification.case import Row

RATIO = 0.25
"""What compilers and caches may change of dense/skyline, relative."""

UNKNOWN = ("the paper's machine, compiler and dense elimination are not known; how much of a step "
           "is not elimination, and what a cache makes of a dense matrix, differ")
WITHIN = 10.0
"""Largest ratio of our dense/skyline to the paper's, or of the paper's to ours, that this
explains."""


def verdicts(ratios):
    """:class:`verification.case.Row` s of a table's ratios (:func:`timing.tables.ratios`)."""
    for row in ratios:
        if row.get("dense_skyline") is None:
            continue
        larger = row["dense_skyline"] > row["paper"]
        yield Row(f"{row['elements']} elements: dense Gauss / skyline LDLT", row["dense_skyline"],
                  row["paper"], "published", RATIO, "another machine", explanation=UNKNOWN,
                  covers=WITHIN - 1.0 if larger else 1.0 - 1.0 / WITHIN)
