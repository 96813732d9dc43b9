"""What a report says, in words and numbers that both of its forms share."""

from collections.abc import Sequence
from dataclasses import dataclass

from bench.plots.plot import Plot
from bench.records.claims import Claim
from bench.records.embedded_pictures import NOTE, Pictures
from bench.records.records import Record
from bench.runner.experiment import Table

MARKS = {"holds": "✓", "refuted": "✗", "fails as expected": "≠", "undecided": "?"}

METRICS = {
    "blake": "blake: a part is displayed when P + R > m·d, as the paper prints it",
    "bounded": "bounded: displayed when P > m·(d − R), R read as a bound on position",
    "solid_angle": "solid_angle: displayed when P > m·d, no bound on position",
    "beyond": "Beyond even, flat, clear ground",
    "sizes": "P of parts against their level, and that of their wholes",
    "posing": "The cost of posing",
    "full": "full: everything is displayed",
    "depth": "depth: P + R > m·(depth along the view axis), which the paper argues against",
    "floor": "Is the noise low enough?",
    "scalar": "Scalar variants",
    "jit": "Frames driven from Dr.Jit",
    "medium": "The medium that scatters light",
    "analytic": "Haze as a formula, in the light of the horizon's sky",
    "scattered": "Haze as a formula, in the light that its layer scatters",
    "spectral": "Light of sixteen bands",
    "lost_below": "Does pruning leave alone what is below its cut-off?",
    "left_above": "Does pruning take what is above its cut-off?",
}

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
        "fails as expected",
        "The whole interval lies outside, in a case where the theory itself says that this rule "
        "fails: it shows where the rule ends, and refutes nothing.",
    ),
    ("undecided", "The interval reaches over the edge: more fields would tell."),
)


@dataclass(frozen=True)
class Section:
    """One record, with all that is made from it, and what it does not say.

    claims  judged here and now from the record's samples
    """

    record: Record
    question: str
    claims: tuple[Claim, ...]
    plots: tuple[Plot, ...]
    table: Table
    caveats: tuple[str, ...] = ()
    pictures: tuple[Pictures, ...] = ()
    summary: Table = ((), [])

    @property
    def anchor(self) -> str:
        """A short name, unique on the page."""
        return f"{self.record.experiment}-{self.record.sha256[:8]}"

    @property
    def title(self) -> str:
        """Experiment, kind of run, and when."""
        kind = "quick run" if self.record.quick else "full run"
        return f"{self.record.experiment}: {kind} of {self.record.made[:10]}"


def answer(claims: Sequence[Claim]) -> str:
    """The verdicts together, in one sentence."""
    count = {verdict: sum(c.verdict == verdict for c in claims) for verdict in MARKS}
    if not claims:
        return "Nothing was claimed."
    failed = count["fails as expected"]
    tried = len(claims) - failed
    ends = f" {_EXPECTED[failed > 1].format(failed)}" if failed else ""
    if count["holds"] == tried:
        return f"Yes: all {tried} claims hold.{ends}"
    if count["refuted"]:
        return (
            f"Not as claimed: of {tried} claims {count['refuted']} "
            f"{'is' if count['refuted'] == 1 else 'are'} refuted, "
            f"{count['undecided']} undecided, {count['holds']} hold.{ends}"
        )
    return f"So far {count['holds']} of {tried} claims hold; the others are undecided.{ends}"


_EXPECTED = (
    "1 more fails where the theory expects it.",
    "{} more fail where the theory expects it.",
)


def groups(claims: Sequence[Claim]) -> dict[str, list[Claim]]:
    """Claims by the first two words of their names, often metric and species, in their order."""
    grouped: dict[str, list[Claim]] = {}
    for claim in claims:
        metric, _, rest = claim.name.partition("/")
        what = rest.partition("/")[0]
        title = f"{METRICS.get(metric, metric)} — {what.replace('_', ' ')}" if rest else "Claims"
        grouped.setdefault(title, []).append(claim)
    return grouped


def verdict(claim: Claim) -> str:
    """The verdict, and within what where something holds."""
    if claim.verdict == "holds" and claim.relation == "equals" and claim.tolerance > 0:
        return f"holds within {claim.tolerance:g}"
    return claim.verdict


CLAIM_HEADS = ("verdict", "claim", "quantity", "claimed", "measured (95 %)", "source", "name")


def words(claim: Claim) -> tuple[str, ...]:
    """A claim as the cells of a table, after its verdict."""
    return (
        *(claim.about, claim.quantity, claim.claimed_text, claim.measured_text),
        *(claim.source, claim.name),
    )


def provenance_rows(section: Section) -> list[tuple[str, str]]:
    """What a reader needs to trust, trace and repeat a record."""
    record, origin = section.record, section.record.provenance
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
    notes = ((key, value) for key, value in record.notes.items() if key != NOTE)
    return rows + [(key.replace("_", " "), _note(value)) for key, value in notes]


def _note(value: object) -> str:
    if isinstance(value, list):
        some = f"{len(value)} values, from {min(value)} to {max(value)}" if len(value) > 20 else ""
        return some or ", ".join(map(str, value)) or "none"
    if isinstance(value, dict):
        return ", ".join(f"{key} {_note(each)}" for key, each in value.items())
    return str(value)


def repeat(section: Section) -> str:
    """The command that makes this record's samples again."""
    quick = " --quick" if section.record.quick else ""
    return f"lodbench run {section.record.experiment}{quick} -o DIR && lodbench report DIR"
