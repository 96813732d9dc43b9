"""Which words does the report use for verdicts, groups of claims and symbols?"""

from collections.abc import Iterable, Sequence

from bench.records.claims import Claim

MARKS = {"holds": "✓", "refuted": "✗", "fails as expected": "≠", "undecided": "?"}
"""Sign of each verdict, in the order in which verdicts are counted."""

GROUP_TITLES = {
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
    (
        "measurement, verification",
        "A measurement could have come out otherwise. A verification follows from how the program "
        "and its world are made, such as the law of a Poisson field: refuted, it shows a bug or a "
        "wrong assumption.",
    ),
    ("undecided", "The interval reaches over the edge: more fields would tell."),
)


def summarise_verdicts(claims: Sequence[Claim]) -> str:
    """Put the verdicts of what was measured into one sentence; none gives an empty text."""
    count = {verdict: sum(c.verdict == verdict for c in claims) for verdict in MARKS}
    if not claims:
        return ""
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


def verified(claims: Sequence[Claim]) -> str:
    """Put what verifies the program into one sentence; no claims give an empty text."""
    if not claims:
        return ""
    sound = sum(claim.verdict in ("holds", "fails as expected") for claim in claims)
    open_ = sum(claim.verdict == "undecided" for claim in claims)
    wrong = ", ".join(claim.name for claim in claims if claim.verdict == "refuted")
    ends = f", {open_} undecided" if open_ else ""
    ends += f"; REFUTED, which is a bug or a wrong assumption: {wrong}" if wrong else ""
    return f"Verification of the program: {sound} of {len(claims)} as predicted{ends}."


_EXPECTED = (
    "1 more fails where the theory expects it.",
    "{} more fail where the theory expects it.",
)


def group_claims(claims: Sequence[Claim]) -> Iterable[tuple[str, list[Claim]]]:
    """Group claims by the first two words of their names, often metric and species.

    Gives pairs of a title and its claims, in the order in which the groups first occur.
    """
    grouped: dict[str, list[Claim]] = {}
    for claim in claims:
        first, _, rest = claim.name.partition("/")
        second = rest.partition("/")[0].replace("_", " ")
        title = f"{GROUP_TITLES.get(first, first)} — {second}" if rest else "Claims"
        grouped.setdefault(title, []).append(claim)
    return grouped.items()


def verdict_text(claim: Claim) -> str:
    """Write the verdict, with the tolerance within which something holds."""
    if claim.verdict == "holds" and claim.relation == "equals" and claim.tolerance > 0:
        return f"holds within {claim.tolerance:g}"
    return claim.verdict


CLAIM_HEADS = ("verdict", "claim", "quantity", "claimed", "measured (95 %)", "source", "name")


def claim_cells(claim: Claim) -> tuple[str, ...]:
    """Write a claim as the cells of a table row that follow its verdict."""
    return (
        *(claim.about, claim.quantity, claim.claimed_text, claim.measured_text),
        *(claim.source, claim.name),
    )
