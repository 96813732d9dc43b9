"""The report as data: sections of blocks in reading order, which both writers walk.

A section is one record; its blocks are what a reader meets, one after the other. ``pages`` says how
each kind of block looks, and nothing of what stands in it; ``first_screen`` says what comes first.
"""

import shlex
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from bench.experiment import Table
from bench.plots import Plot
from bench.records.claims import Claim, Kind
from bench.records.probe import CASES
from bench.records.probe import NOTE as PROBE
from bench.records.records import NOTE, PRESET, PRESET_TEXT, Pictures, Record
from bench.statistics.estimates import holm

MARKS = {"holds": "✓", "refuted": "✗", "expected violation": "≠", "inconclusive": "?"}
"""Sign of each verdict, in the order in which verdicts are counted."""

GLOSSARY = (
    ("object, part", "An object is a tree of parts: a person, arms, hands, fingers."),
    (
        "displayed",
        "A part is displayed while the viewer could resolve it: nearer than its limit D.",
    ),
    ("examined", "Tested against the limit, whether it was then displayed or not."),
    ("P, R", "Size of what would be lost, and reach of the part; both in metres (§2.4)."),
    ("K", "Objects per square metre."),
    ("m", "The smallest angle that counts: detail threshold in pixels × the angle of a pixel."),
    ("D", "Limit distance; (P + R)/m for the metric of the paper."),
    ("field", "One random world, from a seed of its own. Every point is a mean over many."),
    ("95 % interval", "Would hold the true value in 95 of 100 repetitions of the experiment."),
    ("holds", "The whole interval lies within what was claimed."),
    ("refuted", "The whole interval lies outside what was claimed."),
    (
        "expected violation",
        "The whole interval lies outside, in a case where the theory itself says that this rule "
        "fails: it shows where the rule ends, and refutes nothing.",
    ),
    (
        "measurement, verification",
        "A measurement could have come out otherwise. A verification follows from how the program "
        "and its world are made, such as the law of a Poisson field: refuted, it shows a bug or a "
        "wrong assumption.",
    ),
    ("inconclusive", "The interval reaches over the edge: more replicates would tell."),
    (
        "equivalent within ±m",
        "The whole interval lies within the margin about the value: equivalence is shown.",
    ),
    ("exact", "Counted or calculated: there is no error of sampling."),
)


def summarise_verdicts(claims: Sequence[Claim]) -> str:
    """Put the verdicts of what was measured into one sentence; none gives an empty text."""
    count = {verdict: sum(c.verdict == verdict for c in claims) for verdict in MARKS}
    if not claims:
        return ""
    failed = count["expected violation"]
    tried = len(claims) - failed
    ends = f" {_EXPECTED[failed > 1].format(failed)}" if failed else ""
    if count["holds"] == tried:
        said = f"all {tried} claims hold{_together(claims)}" if tried > 1 else "the claim holds"
        return f"Yes: {said}.{ends}"
    if count["refuted"]:
        return (
            f"Not as claimed: of {tried} claims {count['refuted']} "
            f"{'is' if count['refuted'] == 1 else 'are'} refuted, "
            f"{count['inconclusive']} inconclusive, {count['holds']} hold.{ends}"
        )
    return f"So far {count['holds']} of {tried} claims hold; the others are inconclusive.{ends}"


def _together(claims: Sequence[Claim]) -> str:
    """Say how many claims of which all hold do so at 5 % for all of them together."""
    tried = [each.chance for each in claims if each.verdict == "holds"]
    return f" ({sum(holm(tried, 0.05))} at 5 % for all of them together, by Holm's correction)"


def verified(claims: Sequence[Claim]) -> str:
    """Put what verifies the program into one sentence; no claims give an empty text."""
    if not claims:
        return ""
    sound = sum(claim.verdict in ("holds", "expected violation") for claim in claims)
    open_ = sum(claim.verdict == "inconclusive" for claim in claims)
    wrong = ", ".join(claim.name for claim in claims if claim.verdict == "refuted")
    ends = f", {open_} inconclusive" if open_ else ""
    ends += f"; REFUTED, which is a bug or a wrong assumption: {wrong}" if wrong else ""
    ends += _together(claims) if sound == len(claims) > 1 else ""
    return f"Verification of the program: {sound} of {len(claims)} as predicted{ends}."


_EXPECTED = (
    "1 more is an expected violation.",
    "{} more are expected violations.",
)


def _group_claims(claims: Sequence[Claim]) -> Iterable[tuple[str, list[Claim]]]:
    grouped: dict[str, list[Claim]] = {}
    for claim in claims:
        grouped.setdefault(claim.estimand, []).append(claim)
    return grouped.items()


CLAIM_HEADS = ("verdict", "condition", "claimed", "measured (95 %)", "unit", "source", "name")


def claim_cells(claim: Claim, whole: bool = False) -> tuple[str, ...]:
    """Write a claim as the cells after its verdict; ``whole`` where no heading says of what."""
    return (
        *(
            claim.sentence if whole else claim.where or "everywhere",
            str(claim.bound),
            claim.measured_text,
            claim.unit,
        ),
        *(claim.source, claim.name),
    )


@dataclass(frozen=True)
class TableBlock:
    """A heading and a table of text cells; ``folded`` where only few readers want it."""

    title: str
    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    folded: bool = False


@dataclass(frozen=True)
class ClaimsBlock:
    """Claims that belong together, one row each under the same heads, after their verdicts.

    ``folded`` where only few readers want it, ``whole`` where each says all that it claims.
    """

    title: str
    heads: Sequence[str]
    claims: Sequence[Claim]
    folded: bool = False
    whole: bool = False


@dataclass(frozen=True)
class PlotsBlock:
    """Plots that stand side by side where there is room."""

    plots: Sequence[Plot]


@dataclass(frozen=True)
class PicturesBlock:
    """Pictures of one view, to be laid over each other or side by side."""

    pictures: Pictures


@dataclass(frozen=True)
class ListBlock:
    """A heading and sentences under it; text between backquotes is code."""

    title: str
    items: Sequence[str]


@dataclass(frozen=True)
class OriginBlock:
    """What a reader needs to trust, trace and repeat a record; ``command`` makes its samples."""

    heads: Sequence[str]
    rows: Sequence[tuple[str, str]]
    command: str


@dataclass(frozen=True)
class TextBlock:
    """A paragraph; text between backquotes is code. ``lede`` where it opens the page."""

    text: str
    lede: bool = False


@dataclass(frozen=True)
class Headline:
    """One measured claim in a row of the first screen, and the section that it is from.

    cells    texts of the row, after the verdict
    drawing  the claimed range and the interval, as a small SVG
    """

    section: "Section"
    claim: Claim
    cells: tuple[str, ...]
    drawing: str


@dataclass(frozen=True)
class HeadlinesBlock:
    """The claims that a reader of one minute sees, a row each under their heads."""

    title: str
    caption: str
    heads: tuple[str, ...]
    rows: Sequence[Headline]


Block = (
    TableBlock
    | ClaimsBlock
    | PlotsBlock
    | PicturesBlock
    | ListBlock
    | OriginBlock
    | TextBlock
    | HeadlinesBlock
)


@dataclass(frozen=True)
class Section:
    """One record with everything that is worked out from it.

    claims      judged from the record's samples when the report is written
    point_table heads and rows of every point
    tables      titled tables that follow the plots
    caveats     what the record does not say
    stale       a sentence that says that the record is of older code; empty where it is not
    """

    record: Record
    question: str
    claims: tuple[Claim, ...]
    plots: tuple[Plot, ...]
    point_table: Table
    caveats: tuple[str, ...] = ()
    pictures: tuple[Pictures, ...] = ()
    tables: tuple[tuple[str, Table], ...] = ()
    stale: str = ""

    @property
    def anchor(self) -> str:
        """Name that is unique on the page: the experiment and the record's hash."""
        return f"{self.record.experiment}-{self.record.sha256[:8]}"

    @property
    def title(self) -> str:
        """Experiment, kind of run, and day."""
        kind = "quick run" if self.record.quick else "full run"
        return f"{self.record.subject}: {kind} of {self.record.made[:10]}"

    @property
    def answer(self) -> str:
        """What was measured, and what was verified, in a sentence each."""
        said = (
            summarise_verdicts(self.of_kind("measurement")),
            verified(self.of_kind("verification")),
        )
        return " ".join(sentence for sentence in said if sentence)

    @property
    def origin(self) -> OriginBlock:
        """Provenance of the record, and the command that makes its samples again."""
        command = f"{run_command(self.record)} -o DIR && lodbench report DIR"
        return OriginBlock(("what", "value"), _provenance_rows(self.record), command)

    def of_kind(self, kind: Kind) -> list[Claim]:
        """Give the claims of one kind."""
        return [claim for claim in self.claims if claim.kind == kind]

    def blocks(self) -> Iterator[Block]:
        """Give the blocks of the section in reading order; empty tables are left out."""
        measured = self.of_kind("measurement")
        yield PlotsBlock(self.plots)
        yield from (PicturesBlock(each) for each in self.pictures)
        if decisive := [claim for claim in measured if claim.headline]:
            heads = "verdict", "claim", *CLAIM_HEADS[2:]
            yield ClaimsBlock("What decides", heads, decisive, whole=True)
        for title, claims in _group_claims([c for c in measured if not c.headline]):
            yield ClaimsBlock(title, CLAIM_HEADS, claims, folded=True)
        yield from (TableBlock(title, *table, folded=True) for title, table in self.tables)
        if checks := self.of_kind("verification"):
            yield ClaimsBlock("Verification", CLAIM_HEADS, checks, folded=True)
        yield ListBlock("What this does not say", self.caveats)
        yield TextBlock(f"Every point stands in `tables/{self.anchor}.csv`, beside this page.")
        yield self.origin


def run_command(record: Record) -> str:
    """Write the command that measures a record's topics again."""
    topics = dict.fromkeys(str(p.case.get("topic", record.experiment)) for p in record.points)
    quick = " --quick" if record.quick else ""
    own = f" --preset {shlex.quote(str(record.notes[PRESET]))}" if PRESET in record.notes else ""
    return f"lodbench run {shlex.join(topics) or record.experiment}{own}{quick}"


def _provenance_rows(record: Record) -> list[tuple[str, str]]:
    origin = record.provenance
    versions = ", ".join(f"{name} {version}" for name, version in sorted(origin.packages.items()))
    rows = [
        ("record", record.name),
        ("SHA-256 of the record", record.sha256),
        ("SHA-256 of its samples", record.samples_sha256),
        ("experiment", f"{record.experiment}, version {record.version}"),
        ("run", "quick: the same points, fewer fields" if record.quick else "full"),
        ("made", record.made),
        ("commit", origin.commit or "not from a checkout"),
        ("scene", origin.scene),
        ("seed", str(origin.seed)),
        ("renderer's variant", origin.variant or "none: nothing was rendered"),
        ("machine", f"{origin.cpu}, {origin.cores} cores, {origin.threads} thread used"),
        ("system", f"{origin.platform}, Python {origin.python}"),
        ("packages", versions),
    ]
    notes = ((key, value) for key, value in record.notes.items() if key not in _UNSAID)
    return rows + [(key.replace("_", " "), _note_text(value)) for key, value in notes]


_UNSAID = (NOTE, PROBE, CASES, PRESET_TEXT)
"""Notes that are no text."""


def _note_text(value: object) -> str:
    if isinstance(value, list):
        some = f"{len(value)} values, from {min(value)} to {max(value)}" if len(value) > 20 else ""
        return some or ", ".join(map(str, value)) or "none"
    if isinstance(value, dict):
        return ", ".join(f"{key} {_note_text(each)}" for key, each in value.items())
    return str(value)
