"""What does a reader of one minute see? This file alone says it, for both kinds of page."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from bench.plots import Plot
from bench.records.claims import Claim
from bench.records.records import Pictures
from bench.report.document import (
    Block,
    Headline,
    HeadlinesBlock,
    ListBlock,
    Section,
    TextBlock,
    run_command,
    verified,
)

TITLE = "lodbench: what was claimed, and what was measured"

LEDE = (
    "In 1987 E. H. Blake gave a rule for what to leave out of a picture, and claimed that with it "
    "the work for a picture depends on what its viewer can make out, and no longer on how large "
    "the world is. Here this is measured, with the other claims of his paper and of this program."
)

LAW = (
    "In his symbols (§4.1) the law is that objects in a frame number π·K·(D² − h²), with "
    "D = (P + R)/m. Every number comes from a record named beside it, by the hash of its content; "
    "every verdict is worked out from the record: from its samples, or from the interval it holds."
)

WHAT_THIS_IS_NOT = (
    "Trees, people, animals and ground are the program's own models: other people's may fare "
    "better or worse.",
    "Light is one sun under a clear sky, at a few elevations; nothing indoors and no lamps.",
    "No observer has judged a picture: differences are measured by FLIP, a model of a viewer, and "
    "by luminance and coverage.",
    "Times are of the machine that the record names, and compare methods within one run.",
)


FIRST = "counts"
"""Name of the plot that opens the page where there is one: counts against the law."""


@dataclass(frozen=True)
class Hero:
    """What opens the page: an answer, its plot, a pair of pictures, and the command for them.

    plot, pictures  each with the section that it is from; None where no record holds one
    """

    answer: str
    plot: tuple[Section, Plot] | None
    pictures: tuple[Section, Pictures] | None
    command: str


def hero(sections: Sequence[Section]) -> Hero:
    """Choose what opens the page: the plot of the law, else the first; the first pictures."""
    plots = [(section, plot) for section in sections for plot in section.plots]
    first = next((each for each in plots if each[1].name == FIRST), plots[0] if plots else None)
    shown = [(section, each) for section in sections for each in section.pictures]
    section = first[0] if first else sections[0]
    answer = f"{first[1].title}." if first else section.answer
    return Hero(
        answer, first, shown[0] if shown else None, f"{run_command(section.record)} -o out/records"
    )


def first_screen(sections: Sequence[Section]) -> Iterator[Block]:
    """Give what the pages begin with, in reading order; ``sections`` have the newest first."""
    yield TextBlock(LEDE, lede=True)
    newest = {section.record.subject: section for section in reversed(sections)}
    rows = [
        Headline(
            section,
            claim,
            (claim.sentence, claim.measured_text, claim.unit, f"`{run_command(section.record)}`"),
            _strip(claim),
        )
        for section in reversed(newest.values())
        for claim in section.claims
        if claim.headline
    ]
    if rows:
        heads = "verdict", "claim", "measured (95 %)", "unit", "command", "interval"
        caption = "Shaded: what was claimed. Line: the 95 % interval."
        yield HeadlinesBlock("What was measured", caption, heads, rows)
    checks = [claim for each in sections for claim in each.of_kind("verification")]
    yield TextBlock(f"{verified(checks)} {LAW}".strip())
    yield ListBlock("What this is not", WHAT_THIS_IS_NOT)


_WIDTH, _HEIGHT, _PAD = 120.0, 16.0, 4.0
_SVG = Markup(
    '<svg class="strip" viewBox="0 0 {width} {height}" role="img" aria-label="{words}">'
    '<rect x="{left}" y="2" width="{wide}" height="12"/>'
    '<line x1="{low}" x2="{high}" y1="8" y2="8"/><circle cx="{value}" cy="8" r="3"/></svg>'
)


def _strip(claim: Claim) -> Markup:
    """Draw the claimed range, the interval and the estimate on an axis that holds all of them.

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

    return _SVG.format(
        width=_WIDTH,
        height=_HEIGHT,
        words=f"measured {claim.measured_text}, claimed {claim.bound}",
        left=at(lowest),
        wide=round(at(highest) - at(lowest), 2),
        low=at(claim.low),
        high=at(claim.high),
        value=at(claim.measured),
    )
