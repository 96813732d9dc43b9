"""A claim as data: what is estimated, what is claimed of it, and the interval that decides.

One template makes a claim's sentence, its name and its row of a table; this is the only file that
judges. A claim holds where its whole 95 % interval lies within what is claimed, it is refuted where
the whole interval lies outside, and otherwise it is inconclusive.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal

from scipy import stats

from bench.statistics.estimates import Estimate
from lod.errors import InputError

Relation = Literal["≤", "≥", "within", "="]
Kind = Literal["measurement", "verification"]
"""A verification follows from how the program and its scenes are made: only a bug or a wrong
assumption of the prediction could refute it. A measurement could have come out otherwise."""

Verdict = Literal["holds", "refuted", "inconclusive", "expected violation"]
JSON_VERDICT: Mapping[Verdict, str] = {
    "holds": "holds",
    "refuted": "refuted",
    "inconclusive": "undecided",
    "expected violation": "refuted",
}
"""What programs read as the verdict; ``expected_violation`` stands beside it."""

EXACT = "exact"
"""The unit of replication of a number that is counted or calculated, and so has no error."""

UNREPLICATED = "unreplicated"
"""The unit of replication of a single value, whose interval has no width though it has an error."""


@dataclass(frozen=True)
class Bound:
    """What a claim says of its estimand: a relation to a value, within a margin."""

    relation: Relation
    value: float
    margin: float = 0.0

    @property
    def range(self) -> tuple[float, float]:
        """The least and the greatest number that agree with the claim."""
        if self.relation == "≤":
            return -math.inf, self.value
        if self.relation == "≥":
            return self.value, math.inf
        return self.value - self.margin, self.value + self.margin

    def __str__(self) -> str:
        """Write the relation and the value: ``≤ 0.01``, ``within 1 ± 0.02``, ``= 0``."""
        number = plain_number(self.value)
        return f"within {number} ± {self.margin:g}" if self.margin else f"{self.relation} {number}"


def at_most(value: float) -> Bound:
    """Claim that the estimand is at most a value."""
    return Bound("≤", value)


def at_least(value: float) -> Bound:
    """Claim that the estimand is at least a value."""
    return Bound("≥", value)


def within(value: float, margin: float) -> Bound:
    """Claim that the estimand is equivalent to a value: not further from it than the margin."""
    return Bound("within", value, margin)


def equals(value: float) -> Bound:
    """Claim that a number that is counted or calculated is exactly a value."""
    return Bound("=", value)


@dataclass(frozen=True)
class Claim:
    """One claim and the estimate that decides it; every text about it is made from these fields.

    estimand     what is estimated, in the terms of the field: ``luminance ratio``
    relation, value, margin   what is claimed of it
    condition    where: names and values, as ``{"preset": "meadow", "τ": "1 px"}``
    unit         the unit of replication: field, place, walk, frame, repeat, pose …; ``exact`` where
                 a number has no error, ``unreplicated`` where its error is not known
    source       where the claim comes from: a section of Blake (1987) as ``§2.4``, or another text
    measured, low, high   the estimate and its 95 % interval
    replicates   how many independent units the interval is from
    violation_expected   whether the theory says that it fails here, so that failing refutes nothing
    headline     whether the report's first screen shows it

    Raises InputError unless all numbers are finite, low ≤ measured ≤ high and margin ≥ 0, and for
    a single value without an interval that is neither exact nor said to be unreplicated.
    """

    estimand: str
    relation: Relation
    value: float
    margin: float
    condition: dict[str, str | int | float]
    unit: str
    source: str
    measured: float
    low: float
    high: float
    replicates: int = 1
    kind: Kind = "measurement"
    violation_expected: bool = False
    headline: bool = False

    def __post_init__(self) -> None:
        numbers = (self.value, self.margin, self.measured, self.low, self.high)
        if not all(math.isfinite(v) for v in numbers):
            raise InputError(f"claim {self.name}", numbers, "every number is finite")
        if not (self.low <= self.measured <= self.high and self.margin >= 0):
            raise InputError(f"claim {self.name}", numbers, "low <= measured <= high, margin >= 0")
        alone = self.low == self.high and self.replicates < 2
        if alone and self.unit not in (EXACT, UNREPLICATED):
            rule = f"an interval with a width, or the unit {EXACT} or {UNREPLICATED}"
            raise InputError(f"claim {self.name}", self.measured, rule)

    @property
    def bound(self) -> Bound:
        """What is claimed."""
        return Bound(self.relation, self.value, self.margin)

    @property
    def name(self) -> str:
        """A name that is unique within the experiment, in letters, digits and a few marks."""
        return "/".join(_slug(each) for each in (self.estimand, *self.condition.values()))

    @property
    def where(self) -> str:
        """The condition in words: texts as they are, numbers and symbols with their names."""
        return ", ".join(
            value if isinstance(value, str) and len(key) > 2 else f"{key} = {_number(value)}"
            for key, value in self.condition.items()
        )

    @property
    def sentence(self) -> str:
        """The claim as a sentence: ``FLIP to unpruned ≤ 0.01 (blake, τ = 1 px).``"""
        where = f" ({self.where})" if self.condition else ""
        return f"{self.estimand[:1].upper()}{self.estimand[1:]} {self.bound}{where}."

    @property
    def verdict(self) -> Verdict:
        """The verdict by the interval."""
        lowest, highest = self.bound.range
        if lowest <= self.low and self.high <= highest:
            return "holds"
        if self.high < lowest or self.low > highest:
            return "expected violation" if self.violation_expected else "refuted"
        return "inconclusive"

    @property
    def chance(self) -> float:
        """The chance, at most, of so good an interval if the truth were at the claim's edge.

        It is that of Student's t, of which an end of the interval is taken for a one-sided bound of
        95 %: those of a two-sided interval are further out.
        """
        sides = zip(self.bound.range, (self.low, self.high), strict=True)
        reach = min(
            (edge - self.measured) / (end - self.measured) if end != self.measured else math.inf
            for edge, end in sides
        )
        freedom = max(self.replicates - 1, 1)
        return float(stats.t.sf(stats.t.ppf(0.95, freedom) * reach, freedom))

    @property
    def verdict_text(self) -> str:
        """The verdict in words; where a claim of equivalence holds, with its margin."""
        if self.verdict == "holds" and self.relation == "within":
            return f"equivalent within ±{self.margin:g}"
        return self.verdict

    @property
    def measured_text(self) -> str:
        """The estimate with its interval, or the word for why it has none."""
        value, low, high = (four_decimals(v) for v in (self.measured, self.low, self.high))
        return (
            f"{value} ({self.unit})"
            if self.unit in (EXACT, UNREPLICATED)
            else f"{value} ({low} to {high})"
        )

    def as_json(self) -> dict[str, Any]:
        """Return plain data with the name, the sentence and the verdict."""
        return {
            "name": self.name,
            "sentence": self.sentence,
            **asdict(self),
            "predicted": self.value,
            "verdict": JSON_VERDICT[self.verdict],
        }


def claim(
    estimand: str,
    bound: Bound,
    condition: Mapping[str, str | int | float],
    estimate: Estimate,
    *,
    unit: str,
    source: str,
    alone: str = "",
    kind: Kind = "measurement",
    violation_expected: bool = False,
    headline: bool = False,
) -> Claim:
    """Make a claim, as ``claim("parts ÷ predicted", within(1, 0.005), {…}, found, unit="field")``.

    Arguments are those of ``Claim``; the whole of the estimate's interval decides the verdict.
    ``alone`` is the unit in place of the usual one where that interval has no width.
    """
    if alone and estimate.low == estimate.high:
        unit = alone
    return Claim(
        estimand,
        bound.relation,
        bound.value,
        bound.margin,
        dict(condition),
        unit,
        source,
        estimate.value,
        estimate.low,
        estimate.high,
        estimate.rows,
        kind,
        violation_expected,
        headline,
    )


_NOT_FIELDS = {"name", "sentence", "predicted", "verdict"}


def claim_from(data: Mapping[str, Any]) -> Claim:
    """Read a claim back from plain data; its verdict is worked out again and never read."""
    return Claim(**{key: value for key, value in data.items() if key not in _NOT_FIELDS})


def four_decimals(value: float) -> str:
    """Write a number with four decimals, a true minus sign, and no sign before zero."""
    return f"{round(value, 4) + 0.0:.4f}".replace("-", "−")


def plain_number(value: float) -> str:
    """Write a number with as many digits as it needs, six at most, and a true minus sign."""
    return f"{value:g}".replace("-", "−")


def _number(value: str | int | float) -> str:
    return value if isinstance(value, str) else plain_number(value)


_ASCII = {"÷": " over ", "τ": "tau", "σ": "sigma", "β": "beta", "≤": "le", "≥": "ge", "½": "half"}


def _slug(value: str | int | float) -> str:
    text = _number(value).replace("−", "-").lower()
    for mark, word in _ASCII.items():
        text = text.replace(mark, word)
    return re.sub(r"[^a-z0-9.+-]+", "_", text.replace("–", "-")).strip("_") or "0"
