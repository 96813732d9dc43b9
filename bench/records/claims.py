"""What was claimed, what was measured, and the verdict: judged here and nowhere else."""

import math
from dataclasses import asdict, dataclass
from typing import Any, Literal

from bench.plots.numbers import four_decimals, plain_number
from bench.statistics.estimates import Estimate
from lod.errors import InputError

Verdict = Literal["holds", "refuted", "fails as expected", "undecided"]
Relation = Literal["equals", "at most"]


@dataclass(frozen=True)
class Claim:
    """One claim and its measurement.

    name       short and unique within its experiment: ``blake/objects/slope_K``
    about      the claim in plain words
    quantity   what the numbers are: an exponent against something, a ratio
    source     where it comes from: a section of the paper, or of the design
    predicted, tolerance   what it must be, and how near
    relation   ``equals``: predicted ± tolerance; ``at most``: not above predicted + tolerance
    measured, low, high    the estimate and its 95 % interval
    expected_to_fail   the theory itself says that it fails here: what is outside refutes nothing
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
        """Holds with the whole interval inside what was claimed; refuted with it wholly outside,
        or, where that was expected, fails as expected.
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
        """What was claimed, as a number with its tolerance."""
        if self.relation == "at most":
            return f"at most {plain_number(self.predicted + self.tolerance)}"
        return f"{plain_number(self.predicted)} ± {self.tolerance:g}"

    @property
    def measured_text(self) -> str:
        """What was measured, with its interval."""
        value, low, high = (four_decimals(v) for v in (self.measured, self.low, self.high))
        return f"{value} ({low} to {high})"

    def as_json(self) -> dict[str, Any]:
        """Plain data, with the verdict worked out; ``expected_to_fail`` only where something is."""
        data = asdict(self) | {"verdict": self.verdict}
        return (
            data
            if self.expected_to_fail
            else {k: v for k, v in data.items() if k != "expected_to_fail"}
        )


def claim(
    name: str,
    words: tuple[str, str, str],
    predicted: float,
    tolerance: float,
    found: Estimate,
    relation: Relation = "equals",
    expected_to_fail: bool = False,
) -> Claim:
    """The claim that ``found`` is ``predicted``; ``words`` are about, quantity and source."""
    interval = found.value, found.low, found.high
    return Claim(name, *words, predicted, tolerance, *interval, relation, expected_to_fail)


def claim_from(data: dict[str, Any]) -> Claim:
    """A claim read back; its verdict is worked out again, never read."""
    return Claim(**{key: value for key, value in data.items() if key != "verdict"})
