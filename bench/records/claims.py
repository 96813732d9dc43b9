"""What was claimed, what was measured, and what is the verdict? The only file that judges."""

import math
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

from bench.plots.numbers import four_decimals, plain_number
from bench.statistics.estimates import Estimate
from lod.errors import InputError

Verdict = Literal["holds", "refuted", "fails as expected", "undecided"]
Relation = Literal["equals", "at most"]
Kind = Literal["measurement", "verification"]
"""A verification follows from how the program and its world are made: only a bug or a wrong
assumption of the prediction could refute it. A measurement could have come out otherwise."""


@dataclass(frozen=True)
class Claim:
    """One claim, and the measurement that decides it.

    name       short and unique within its experiment: ``blake/objects/slope_K``
    about      the claim in plain words
    quantity   what the numbers are: an exponent against something, a ratio
    source     where it comes from: a section of Blake (1987) as ``§2.4``, or another text
    predicted, tolerance   the number that is claimed, and how far from it a number still agrees
    relation   ``equals``: predicted ± tolerance; ``at most``: not above predicted + tolerance
    measured, low, high    the estimate and its 95 % interval, or its one-sided 95 % bounds
    expected_to_fail   whether the theory says that it fails here, so that failing refutes nothing
    kind       whether it verifies the program or measures something

    Raises InputError for numbers that are not finite, unless low ≤ measured ≤ high, for a
    tolerance below 0 and for another relation.
    """

    name: str
    about: str
    quantity: str
    source: str
    predicted: float
    tolerance: float
    measured: float
    low: float
    high: float
    relation: Relation = "equals"
    expected_to_fail: bool = False
    kind: Kind = "measurement"

    def __post_init__(self) -> None:
        numbers = (self.predicted, self.tolerance, self.measured, self.low, self.high)
        if not all(math.isfinite(v) for v in numbers):
            raise InputError(f"claim {self.name}", numbers, "every number is finite")
        if not (self.low <= self.measured <= self.high and self.tolerance >= 0):
            raise InputError(
                f"claim {self.name}", numbers, "low <= measured <= high, tolerance >= 0"
            )
        if self.relation not in ("equals", "at most"):
            raise InputError(f"claim {self.name}", self.relation, "'equals' or 'at most'")

    @property
    def verdict(self) -> Verdict:
        """The verdict by the interval.

        The claim holds where the whole interval lies within what was claimed. It is refuted, or
        fails as expected, where the whole interval lies outside. Otherwise it is undecided.
        """
        lowest = self.predicted - self.tolerance if self.relation == "equals" else -math.inf
        highest = self.predicted + self.tolerance
        if lowest <= self.low and self.high <= highest:
            return "holds"
        if self.high < lowest or self.low > highest:
            return "fails as expected" if self.expected_to_fail else "refuted"
        return "undecided"

    @property
    def claimed_text(self) -> str:
        """The number that was claimed, with its tolerance, as text."""
        if self.relation == "at most":
            return f"at most {plain_number(self.predicted + self.tolerance)}"
        return f"{plain_number(self.predicted)} ± {self.tolerance:g}"

    @property
    def measured_text(self) -> str:
        """The number that was measured, with its interval, as text."""
        value, low, high = (four_decimals(v) for v in (self.measured, self.low, self.high))
        return f"{value} ({low} to {high})"

    def as_json(self) -> dict[str, Any]:
        """Return plain data with the verdict; what a claim is by default is left out."""
        data = asdict(self) | {"verdict": self.verdict}
        return {k: v for k, v in data.items() if k not in _DEFAULTS or v != _DEFAULTS[k]}


_DEFAULTS = {"expected_to_fail": False, "kind": "measurement"}
"""What records of before a key was known say by its absence."""


def claim(
    name: str,
    words: tuple[str, str, str],
    predicted: float,
    tolerance: float,
    measured: Estimate,
    relation: Relation = "equals",
    expected_to_fail: bool = False,
) -> Claim:
    """Make the claim that an estimate is ``predicted`` ± ``tolerance``, or at most their sum.

    It is a measurement; ``verification`` turns it into the other kind.


    name               short and unique within its experiment: ``blake/objects/slope_K``
    words              (about, quantity, source): the claim as a sentence; what the numbers are; and
                       where the claim comes from, a section of Blake (1987) or another text
    measured           the estimate; the whole of its interval decides the verdict
    relation           ``equals`` or ``at most``
    expected_to_fail   whether the theory says that the claim fails here

    Raises InputError for numbers that are not finite and for a tolerance below 0.
    """
    interval = measured.value, measured.low, measured.high
    return Claim(name, *words, predicted, tolerance, *interval, relation, expected_to_fail)


def verification(made: Claim) -> Claim:
    """Return the claim as a verification."""
    return replace(made, kind="verification")


def claim_from(data: dict[str, Any]) -> Claim:
    """Read a claim back from plain data; its verdict is worked out again and never read."""
    return Claim(**{key: value for key, value in data.items() if key != "verdict"})
