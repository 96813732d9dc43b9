"""What was claimed, what was measured, and the verdict: judged here and nowhere else."""

import math
from dataclasses import asdict, dataclass
from typing import Any, Literal

from bench.statistics.estimates import Estimate
from lod.errors import InputError

Verdict = Literal["holds", "refuted", "breaks", "undecided"]
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
    foreseen   the theory itself says that it fails here: what is outside *breaks* as foreseen, and
        refutes nothing
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
    foreseen: bool = False

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
        or, where that was foreseen, breaks.
        """
        lowest = self.predicted - self.tolerance if self.relation == "equals" else -math.inf
        highest = self.predicted + self.tolerance
        if lowest <= self.low and self.high <= highest:
            return "holds"
        if self.high < lowest or self.low > highest:
            return "breaks" if self.foreseen else "refuted"
        return "undecided"

    def as_json(self) -> dict[str, Any]:
        """Plain data, with the verdict worked out; ``foreseen`` only where something is."""
        data = asdict(self) | {"verdict": self.verdict}
        return data if self.foreseen else {k: v for k, v in data.items() if k != "foreseen"}


def claim(
    name: str,
    words: tuple[str, str, str],
    predicted: float,
    tolerance: float,
    found: Estimate,
    relation: Relation = "equals",
    foreseen: bool = False,
) -> Claim:
    """The claim that ``found`` is ``predicted``; ``words`` are about, quantity and source."""
    interval = found.value, found.low, found.high
    return Claim(name, *words, predicted, tolerance, *interval, relation, foreseen)


def claim_from(data: dict[str, Any]) -> Claim:
    """A claim read back; its verdict is worked out again, never read."""
    return Claim(**{key: value for key, value in data.items() if key != "verdict"})
