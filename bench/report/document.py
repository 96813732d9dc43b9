"""The report as data: a section for each record, with all that is worked out from it.

Two templates beside this file walk the sections: ``page.html``, and ``report.md``.
"""

import shlex
from collections import Counter
from collections.abc import Sequence
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


_EXPECTED = ("1 more is an expected violation.", "{} more are expected violations.")

CLAIM_HEADS = ("verdict", "condition", "claimed", "measured (95 %)", "unit", "source", "name")


def claim_cells(claim: Claim, whole: bool = False) -> tuple[str, ...]:
    """Write a claim as the cells after its verdict; ``whole`` where no heading says of what."""
    said = claim.sentence if whole else claim.where or "everywhere"
    told = str(claim.bound), claim.measured_text, claim.unit, claim.source, claim.name
    return said, *told


@dataclass(frozen=True)
class Section:
    """One record with everything that is worked out from it.

    claims      judged from the record's samples when the report is written
    tables      titled tables that follow the plots
    caveats     what the record does not say
    stale       a sentence that says that the record is of older code; empty where it is not
    """

    record: Record
    question: str
    claims: tuple[Claim, ...]
    plots: tuple[Plot, ...]
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
    def command(self) -> str:
        """The command that makes its samples again, and its report."""
        return f"{run_command(self.record)} -o DIR && lodbench report DIR"

    @property
    def origin(self) -> list[tuple[str, str]]:
        """What a reader needs to trust and to trace the record, as rows of a table."""
        return _provenance_rows(self.record)

    @property
    def decisive(self) -> list[Claim]:
        """The measured claims that lead."""
        return [claim for claim in self.of_kind("measurement") if claim.headline]

    @property
    def groups(self) -> dict[str, list[Claim]]:
        """The other measured claims, by what they estimate."""
        grouped: dict[str, list[Claim]] = {}
        for claim in self.of_kind("measurement"):
            if not claim.headline:
                grouped.setdefault(claim.estimand, []).append(claim)
        return grouped

    def of_kind(self, kind: Kind) -> list[Claim]:
        """Give the claims of one kind."""
        return [claim for claim in self.claims if claim.kind == kind]


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
        *_cases_row(record),
        ("system", f"{origin.platform}, Python {origin.python}"),
        ("packages", versions),
    ]
    notes = ((key, value) for key, value in record.notes.items() if key not in _UNSAID)
    return rows + [(key.replace("_", " "), _note_text(value)) for key, value in notes]


def _cases_row(record: Record) -> list[tuple[str, str]]:
    """Say how many cases are of which commit and machine, where they are of several."""
    made = [(c["commit"], c["cpu"], c["cores"]) for c in record.notes.get(CASES, ())]
    of = Counter(made).items()
    told = (f"{n} of {str(at)[:7]} on {cpu}, {cores} cores" for (at, cpu, cores), n in of)
    return [("cases", "; ".join(told))] if len(of) > 1 else []


_UNSAID = (NOTE, PROBE, CASES, PRESET_TEXT)  # notes that are no text


def _note_text(value: object) -> str:
    if isinstance(value, list):
        some = f"{len(value)} values, from {min(value)} to {max(value)}" if len(value) > 20 else ""
        return some or ", ".join(map(str, value)) or "none"
    if isinstance(value, dict):
        return ", ".join(f"{key} {_note_text(each)}" for key, each in value.items())
    return str(value)
