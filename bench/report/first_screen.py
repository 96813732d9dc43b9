"""What does a reader of one minute see? This file alone says it, for both kinds of page."""

from collections.abc import Iterator, Sequence

from markupsafe import Markup

from bench.records.claims import Claim
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
    "A picture of a meadow may hold a million people, and those far away are a few pixels high: "
    "most of their hands and faces, and of the leaves about them, can be left out before the "
    "picture is made. In 1987 E. H. Blake gave a rule for what to leave out, and claimed that with "
    "it the work for a picture depends on what its viewer can make out, and no longer on how large "
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


def first_screen(sections: Sequence[Section]) -> Iterator[Block]:
    """Give what the pages begin with, in reading order; ``sections`` have the newest first."""
    yield TextBlock(LEDE, lede=True)
    newest = {section.record.experiment: section for section in reversed(sections)}
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
