"""What does a reader of one minute see? The measured claims that matter most, a line each."""

from collections.abc import Sequence
from dataclasses import dataclass

from bench.records.claims import Claim
from bench.report.document import Section, run_command

MEASURED, LIMITS = "What was measured", "What this is not"
"""The headings of the first screen."""

WHAT_THIS_IS_NOT = (
    "Trees, people, animals and ground are the program's own models: other people's may fare "
    "better or worse.",
    "Light is one sun under a clear sky, at a few elevations; nothing indoors and no lamps.",
    "No observer has judged a picture: differences are measured by FLIP, a model of a viewer, and "
    "by luminance and coverage.",
    "Times are of the machine that the record names, and compare methods within one run.",
)

_WIDTH, _HEIGHT, _PAD = 120.0, 16.0, 4.0


@dataclass(frozen=True)
class Headline:
    """One measured claim, the section that it is from, and its interval as a small drawing."""

    section: Section
    claim: Claim

    @property
    def command(self) -> str:
        """The command that measures it again."""
        return run_command(self.section.record)

    @property
    def strip(self) -> "Strip":
        """Where the interval and what was claimed lie, on an axis of the claim's own."""
        return strip_of(self.claim)


def headlines(sections: Sequence[Section]) -> list[Headline]:
    """Give the claims that say that they are headlines, from each experiment's newest record.

    ``sections`` have the newest record of an experiment first.
    """
    newest = {section.record.experiment: section for section in reversed(sections)}
    return [
        Headline(section, claim)
        for section in reversed(newest.values())
        for claim in section.claims
        if claim.headline
    ]


@dataclass(frozen=True)
class Strip:
    """Places along an axis of ``width`` pixels: the claimed range, the interval, the estimate."""

    claimed: tuple[float, float]
    interval: tuple[float, float]
    measured: float
    width: float = _WIDTH
    height: float = _HEIGHT


def strip_of(claim: Claim) -> Strip:
    """Place a claim on an axis that holds the claimed range and the whole interval.

    The axis of a bound from above begins at 0, or at the interval where that lies below 0.
    """
    lowest, highest = claim.bound.range
    if claim.relation == "≤":
        lowest = min(0.0, claim.low, highest)
    elif claim.relation == "≥":
        highest = max(claim.high, lowest)
    left, right = min(lowest, claim.low), max(highest, claim.high)
    scale = (_WIDTH - 2 * _PAD) / ((right - left) or 1.0)

    def at(value: float) -> float:
        return round(_PAD + (value - left) * scale, 2)

    return Strip((at(lowest), at(highest)), (at(claim.low), at(claim.high)), at(claim.measured))
