"""What does a reader of one minute see? Its words and what is chosen, for both kinds of page.

In which order they stand is for ``page.html`` and ``page.md.jinja`` to say.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from bench.plots import Plot
from bench.records.claims import Claim
from bench.records.records import Pictures
from bench.report.document import Section, run_command, verified

TITLE = "lodbench: what was claimed, and what was measured"  # tells that a page is a report

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

HEADINGS = {"measured": "What was measured", "limits": "What this is not"}

MOST = 10  # claims that lead where none is marked to

FIRST = "budget", "counts"
"""Names of the plots of which the first that there is opens the page: the law that is no identity
on a Poisson field, and counts against the one that is."""

HEADLINE_HEADS = "claim", "measured (95 %)", "unit", "command"  # after the verdict


@dataclass(frozen=True)
class FirstScreen:
    """What the pages begin with.

    answer, command  what the first record says, and the command that measures it again
    plot, pictures   each with the section that it is from; None where no record holds one
    headlines        measured claims that lead, each with its section, of the newest records
    verified         what verifies the program, in a sentence, and what the law is
    """

    answer: str
    command: str
    plot: tuple[Section, Plot] | None
    pictures: tuple[Section, Pictures] | None
    headlines: list[tuple[Section, Claim]]
    verified: str


def first_screen(sections: Sequence[Section]) -> FirstScreen:
    """Choose what opens the pages; ``sections`` have the newest record of an experiment first.

    That is the plot of a law, else the first one, and the first pictures.
    """
    plots = [(section, plot) for section in sections for plot in section.plots]
    named = [each for name in FIRST for each in plots if each[1].name == name]
    first = next(iter([*named, *plots]), None)
    section = first[0] if first else sections[0]
    newest = {section.record.experiment: section for section in reversed(sections)}
    checks = [claim for each in sections for claim in each.of_kind("verification")]
    return FirstScreen(
        f"{first[1].title}." if first else section.answer,
        f"{run_command(section.record)} -o out/records",
        first,
        next(((s, each) for s in sections for each in s.pictures), None),
        [(s, c) for s in reversed(newest.values()) for c in s.claims if c.headline]
        or [(section, each) for each in section.of_kind("measurement")][:MOST],
        f"{verified(checks)} {LAW}".strip(),
    )


def headline_cells(section: Section, claim: Claim) -> tuple[str, ...]:
    """Write a claim of the first screen as the cells after its verdict."""
    told = f"`{run_command(section.record)}`"
    return claim.sentence, claim.measured_text, claim.unit, told


_WIDTH, _HEIGHT, _PAD = 120.0, 16.0, 4.0
_SVG = Markup(
    '<svg class="strip" viewBox="0 0 {width} {height}" role="img" aria-label="{words}">'
    '<rect x="{left}" y="2" width="{wide}" height="12"/>'
    '<line x1="{low}" x2="{high}" y1="8" y2="8"/><circle cx="{value}" cy="8" r="3"/></svg>'
)


def strip(claim: Claim) -> Markup:
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
