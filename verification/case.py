"""What a verification case is: a claim, its source, and rows of numbers with verdicts."""

from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np

KINDS = {
    "analytic": "closed form or an identity that holds exactly",
    "published": "number printed in a publication, seen in the source named",
    "statement": "what the paper says in words, here of our own numbers",
    "recalled": "number of a publication as quoted elsewhere or remembered; the page was not seen",
    "other code": "number of another program",
    "converged": "our own result on a fine mesh or with small steps",
    "baseline": "what a wrong or weaker variant gives, to show that the check can tell",
}
OK = ("match", "within tolerance", "better", "calibrated", "deviates (explained)")

FITTED = 1e-3
"""Largest difference, relative, that still counts as the result of a calibration: it is made with
one mesh and time step, and used with others."""


@dataclass(frozen=True)
class Row:
    """One number beside its reference.

    Attributes:
        name: what the number is.
        value: ours.
        reference: the number to compare with.
        kind: where the reference comes from, one of ``KINDS``.
        tolerance: largest |value - reference| allowed, in the unit of ``scale``.
        scale: what differences are divided by; the size of the reference if left out.
        reason: why the tolerance is what it is.
        target: for a reference that is another element's result: the exact value both approximate;
            a value nearer to it than the reference is ``better``.
        explanation: why a row may deviate; with it, a deviation is ``deviates (explained)``.
        covers: largest |difference| that the explanation covers.
        above: the value must be at least the reference (for baselines that must fail).
        fitted: the value was calibrated to the reference, so that agreement proves nothing.
    """

    name: str
    value: float
    reference: float
    kind: str
    tolerance: float
    reason: str
    scale: float = None
    target: float = None
    explanation: str = ""
    covers: float = 0.0
    above: bool = False
    fitted: bool = False

    @property
    def difference(self):
        """(value - reference) / scale."""
        scale = self.scale if self.scale is not None else abs(self.reference)
        return float((self.value - self.reference) / scale) if scale else float(self.value)

    @property
    def verdict(self):
        """match, better, within tolerance, calibrated, deviates (explained) or (open)."""
        if not np.isfinite(self.value):
            return "deviates (open)"
        if self.above and self.value >= self.reference:
            return "match"
        if self.target is not None and abs(self.value - self.target) < abs(
                self.reference - self.target):
            return "better"
        if self.fitted and abs(self.difference) <= FITTED:
            return "calibrated"
        if not self.above and abs(self.difference) <= self.tolerance:
            exact = (self.kind == "analytic" and self.tolerance <= 1e-6
                     or self.value == self.reference)
            return "match" if exact else "within tolerance"
        explained = self.explanation and abs(self.difference) <= self.covers
        return "deviates (explained)" if explained else "deviates (open)"

    def __str__(self):
        relative = self.scale is None and self.reference != 0.0
        difference = f"{self.difference:+.2%}" if relative else f"{self.difference:+.2e}"
        return (f"{self.name:<64} {self.value:>12.6g} {self.reference:>12.6g} {difference:>9}  "
                f"{self.verdict}")

    def as_dict(self):
        """Its fields and verdict."""
        return {**asdict(self), "value": float(self.value), "reference": float(self.reference),
                "difference": self.difference, "verdict": self.verdict}


@dataclass(frozen=True)
class Case:
    """One verification case.

    Attributes:
        name: how it is called on the command line.
        suite: which suite it belongs to.
        claim: what it shows.
        source: author, year, table or figure of the references.
        definition: geometry, material, loads and supports in words.
        run: makes the rows: returns or yields them; a function that can be pickled, for worker
            processes.
        slow: takes more than some seconds; run by ``corovec verify``, not by the tests.
    """

    name: str
    suite: str
    claim: str
    source: str
    definition: str
    run: Callable
    slow: bool = False


def at_least(name, value, bound, reason, kind="baseline"):
    """Row of a number that must reach ``bound``: by default a baseline, a wrong variant's error."""
    return Row(name, value, bound, kind, 0.0, reason, above=True)


def small(name, value, bound, reason, scale=1.0):
    """Row of an error that must vanish: |value| <= bound."""
    return Row(name, value, 0.0, "analytic", bound, reason, scale=scale)
