"""Which words does the report use for verdicts, groups of claims and symbols?"""

from collections.abc import Iterable, Sequence

from bench.records.claims import Claim

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
        return f"Yes: all {tried} claims hold.{ends}"
    if count["refuted"]:
        return (
            f"Not as claimed: of {tried} claims {count['refuted']} "
            f"{'is' if count['refuted'] == 1 else 'are'} refuted, "
            f"{count['inconclusive']} inconclusive, {count['holds']} hold.{ends}"
        )
    return f"So far {count['holds']} of {tried} claims hold; the others are inconclusive.{ends}"


def verified(claims: Sequence[Claim]) -> str:
    """Put what verifies the program into one sentence; no claims give an empty text."""
    if not claims:
        return ""
    sound = sum(claim.verdict in ("holds", "expected violation") for claim in claims)
    open_ = sum(claim.verdict == "inconclusive" for claim in claims)
    wrong = ", ".join(claim.name for claim in claims if claim.verdict == "refuted")
    ends = f", {open_} inconclusive" if open_ else ""
    ends += f"; REFUTED, which is a bug or a wrong assumption: {wrong}" if wrong else ""
    return f"Verification of the program: {sound} of {len(claims)} as predicted{ends}."


_EXPECTED = (
    "1 more is an expected violation.",
    "{} more are expected violations.",
)


def group_claims(claims: Sequence[Claim]) -> Iterable[tuple[str, list[Claim]]]:
    """Group claims by their estimands; gives titles and claims, as the groups first occur."""
    grouped: dict[str, list[Claim]] = {}
    for claim in claims:
        grouped.setdefault(claim.estimand, []).append(claim)
    return grouped.items()


CLAIM_HEADS = ("verdict", "condition", "claimed", "measured (95 %)", "unit", "source", "name")


def claim_cells(claim: Claim) -> tuple[str, ...]:
    """Write a claim as the cells of a table row that follow its verdict."""
    return (
        *(claim.where or "everywhere", str(claim.bound), claim.measured_text, claim.unit),
        *(claim.source, claim.name),
    )
