"""Verdicts of the timings: ratios beside the paper's.  Seconds of unknown machines compare not."""

from corovec.verification.case import Row

from .printed import doubts

RATIO = 0.25
"""What compilers and caches may change of dense/skyline, relative."""

MACHINES = 2.0
"""By how much machines differ on the finest meshes of the other tables (seen: 0.9 to 1.9)."""


def verdicts(ratios):
    """``Row`` s of a table's ratios (``ratios``); a doubt explains what is near the ratio that it
    predicts."""
    doubted = doubts()
    for row in ratios:
        if row.get("dense_skyline") is None:
            continue
        doubt = doubted.get(row["table"], {"factor": 0.0, "why": ""})
        expected = doubt["factor"] * row["paper"]
        near = expected / MACHINES <= row["dense_skyline"] <= MACHINES * expected
        yield Row(f"{row['elements']} elements: dense Gauss / skyline LDLT", row["dense_skyline"],
                  row["paper"], "published", RATIO, "another machine, the paper's is not known",
                  explanation=doubt["why"] if near else "",
                  covers=MACHINES * doubt["factor"] - 1.0 if near else 0.0)
