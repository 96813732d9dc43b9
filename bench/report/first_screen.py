"""What does a reader of one minute see? The measured claims that matter most, a line each."""

from collections.abc import Sequence
from dataclasses import dataclass

from bench.records.claims import Claim
from bench.report.document import Section

CHOSEN = (
    ("world", "full/over_pruned"),
    ("fidelity", "blake/eye_level/error_everything"),
    ("fidelity", "blake/aerial/error_everything"),
    ("fidelity_shipped", "meadow/everything/error"),
    ("cost", "prune_share"),
    ("rivals", "crowd/100000/time"),
    ("rivals", "forest/10000/memory"),
    ("colonnade", "blake/column/error_eye"),
    ("figure", "blake/person/exponent_visible"),
    ("figure", "blake/person/exponent"),
)
"""The experiments and measured claims that the first screen shows, ten at most."""

MEASURED, LIMITS = "What was measured", "What this is not"
"""The headings of the first screen."""

WHAT_THIS_IS_NOT = (
    "Trees, people, animals and ground are the program's own models: other people's may fare "
    "better or worse.",
    "Light is one sun under a clear sky, at a few elevations; nothing indoors and no lamps.",
    "Nobody has looked: that a picture is as good as the whole one is judged by FLIP, a model of "
    "a viewer, and by luminance.",
    "Times are of the machine that the record names, and compare ways within one run.",
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
        return f"lodbench run {self.section.record.experiment}"

    @property
    def strip(self) -> "Strip":
        """Where the interval and what was claimed lie, on an axis of the claim's own."""
        return strip_of(self.claim)


def headlines(sections: Sequence[Section]) -> list[Headline]:
    """Give the chosen claims, each from its experiment's newest record; what is not there is not.

    ``sections`` have the newest record of an experiment first.
    """
    newest = {section.record.experiment: section for section in reversed(sections)}
    found = {
        (experiment, claim.name): Headline(section, claim)
        for experiment, section in newest.items()
        for claim in section.claims
    }
    return [found[each] for each in CHOSEN if each in found]


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

    The axis of an ``at most`` begins at 0, or at the interval where that lies below 0.
    """
    highest = claim.predicted + claim.tolerance
    lowest = claim.predicted - claim.tolerance
    if claim.relation == "at most":
        lowest = min(0.0, claim.low, highest)
    left, right = min(lowest, claim.low), max(highest, claim.high)
    scale = (_WIDTH - 2 * _PAD) / ((right - left) or 1.0)

    def at(value: float) -> float:
        return round(_PAD + (value - left) * scale, 2)

    return Strip((at(lowest), at(highest)), (at(claim.low), at(claim.high)), at(claim.measured))
