"""What a verification case is: a claim, its source, and rows of numbers with verdicts."""

from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np

KINDS = {
    "analytic": "closed form or an identity that holds exactly",
    "published": "number printed in the paper",
    "statement": "what the paper says in words, here of our own numbers",
    "recalled": "number of a publication as quoted elsewhere or remembered; the page was not seen",
    "other code": "number of another program",
    "converged": "our own result on a fine mesh or with small steps",
    "baseline": "what a wrong or weaker variant gives, to show that the check can tell",
}
OK = ("match", "within tolerance", "bound met", "better", "selected", "calibrated",
      "deviates (explained)")

EQUAL = 1e-9
"""Largest tolerance of an identity that rounding alone fills."""

CHOSEN = ("selected", "calibrated")
"""Provenances of data that printed results chose: agreement with these proves nothing."""

FITTED = 1e-3
"""Largest difference, relative, that counts as agreement which such a choice brought about: it is
made with one mesh and time step, and used with others."""


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
        above: the reference is a bound: the value must be at least so large.
        digits: the tolerance is half of the last printed digit: agreement is equality.
        uncertainty: of the value, in the unit of ``scale``: it agrees only if all of it does.
        rests_on: the weakest provenance of the data behind the value; empty if that is no matter.
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
    digits: bool = False
    uncertainty: float = 0.0
    rests_on: str = ""

    @property
    def difference(self):
        """(value - reference) / scale."""
        scale = self.scale if self.scale is not None else abs(self.reference)
        return float((self.value - self.reference) / scale) if scale else float(self.value)

    @property
    def verdict(self):
        """One of ``OK``, or deviates (open)."""
        if not np.isfinite(self.value):
            return "deviates (open)"
        if self.above and self.value >= self.reference:
            return "bound met"
        if self.target is not None and abs(self.value - self.target) < abs(
                self.reference - self.target):
            return "better"
        if not self.above and abs(self.difference) + self.uncertainty <= self.limit:
            return self._agreement
        explained = self.explanation and abs(self.difference) <= self.covers
        return "deviates (explained)" if explained else "deviates (open)"

    @property
    def limit(self):
        """Largest |difference|, with its uncertainty, that counts as agreement."""
        chosen = self.rests_on in CHOSEN and self.scale is None
        return max(self.tolerance, FITTED) if chosen else self.tolerance

    @property
    def _agreement(self):
        if self.rests_on in CHOSEN:
            return self.rests_on
        equal = (self.digits or self.kind == "analytic" and self.tolerance <= EQUAL
                 or self.value == self.reference)
        return "match" if equal else "within tolerance"

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
