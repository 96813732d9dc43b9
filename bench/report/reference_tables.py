"""Which tables of a run's claims do pages quote? They are read from claims.json and claims.csv."""

import csv
import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from bench.plots.numbers import four_decimals
from bench.records.claims import Claim, claim_from
from bench.report.first_screen import CHOSEN
from bench.report.words import MARKS, verdict_text, verified

HEADS = "claim", "quantity", "claimed", "measured (95 %)", "verdict"
_GONE = "–"
_VERBS = {"holds": "hold", "fails as expected": "fail as expected"}


@dataclass(frozen=True)
class JudgedClaim:
    """A claim of the run, the experiment that it is of, and the commit that was measured."""

    experiment: str
    claim: Claim
    commit: str


def judged_claims(folder: Path) -> list[JudgedClaim]:
    """Read all claims of a folder with a report. Raises FileNotFoundError where there is none."""
    runs = json.loads((folder / "claims.json").read_text(encoding="utf-8"))
    return [
        JudgedClaim(run["experiment"], claim_from(one), commit)
        for run, commit in ((run, _commit(folder, run)) for run in runs)
        for one in run["claims"]
    ]


def chosen_table(found: Sequence[JudgedClaim]) -> str:
    """Write the claims of the report's first screen, a row each."""
    by_name = {(each.experiment, each.claim.name): each for each in found}
    rows = [by_name[name] for name in CHOSEN if name in by_name]
    told = [(*_cells(each.claim), f"`run {each.experiment}`") for each in rows]
    measured_at = short_commits(each.commit for each in rows)
    ends = f"Measured at {measured_at}; a row is missing where its claim is newer."
    return f"{markdown_table((*HEADS, 'measured by'), told)}\n\n{ends}"


def experiment_table(found: Sequence[JudgedClaim], experiment: str, *patterns: str) -> str:
    """Write claims of an experiment, a row each, and in a sentence how its claims were judged.

    ``patterns`` are those of names of claims, as of files (``blake/*/ratio``); none = all that was
    measured. Raises ValueError for a pattern that no claim has, unless there is no record.
    """
    mine = [each for each in found if each.experiment == experiment]
    if not mine:
        return "Not measured yet: the reference run has no record of this experiment."
    claims = [each.claim for each in mine]
    for pattern in patterns:
        if not any(fnmatchcase(each.name, pattern) for each in claims):
            raise ValueError(f"{experiment}: no claim is named {pattern}")
    measured = [each for each in claims if each.kind == "measurement"]
    asked = [each for each in claims if any(fnmatchcase(each.name, one) for one in patterns)]
    rows = [_cells(each, f" `{each.name}`") for each in (asked if patterns else measured)]
    verifying = [each for each in claims if each.kind == "verification"]
    open_ = [f"`{each.name}` {each.measured_text}" for each in verifying if _is_open(each)]
    sentences = [
        f"{len(measured)} measured claims: {_counted(measured)}." if measured else "",
        verified(verifying),
        f"Undecided of these: {'; '.join(open_)}." if open_ else "",
        f"`lodbench run {experiment}`, {short_commits(each.commit for each in mine)}.",
    ]
    table = markdown_table(HEADS, rows) if rows else ""
    return "\n\n".join(filter(None, (table, " ".join(filter(None, sentences)))))


def changed_table(before: Path, found: Sequence[JudgedClaim]) -> str:
    """Write every claim whose verdict differs from that of an earlier run, or that is gone.

    ``before`` is the claims.csv of the earlier run. Experiments without a record now are left out.
    """
    now = {(each.experiment, each.claim.name): each.claim for each in found}
    ran = {each.experiment for each in found}
    rows = []
    for row in _rows_of(before):
        claim = now.get((row["experiment"], row["name"]))
        if row["experiment"] in ran and (claim is None or claim.verdict != row["verdict"]):
            numbers = (four_decimals(float(row[key])) for key in ("measured", "low", "high"))
            value, low, high = numbers
            told = f"{value} ({low} to {high}) {row['verdict']}"
            today = f"{claim.measured_text} {verdict_text(claim)}" if claim else _GONE
            rows.append((row["experiment"], f"`{row['name']}`", told, today))
    return markdown_table(("experiment", "claim", "before", "now"), rows)


def markdown_table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Write a table in Markdown."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(
        "| " + " | ".join(each.replace("|", "\\|") for each in line) + " |" for line in lines
    )


def short_commits(names: Iterable[str]) -> str:
    """Name commits by their first seven digits; one that had changes says so."""
    short = [f"{each[:7]}{' with changes' if '+' in each else ''}" for each in sorted(set(names))]
    listed = " and ".join(filter(None, (", ".join(short[:-1]), *short[-1:])))
    return f"commit{'s' if len(short) > 1 else ''} {listed}"


def _is_open(claim: Claim) -> bool:
    return claim.verdict == "undecided"


def _counted(claims: Sequence[Claim]) -> str:
    counts = ((verdict, sum(each.verdict == verdict for each in claims)) for verdict in MARKS)
    return ", ".join(f"{n} {_VERBS.get(verdict, verdict)}" for verdict, n in counts if n)


def _cells(claim: Claim, name: str = "") -> tuple[str, ...]:
    verdict = f"{MARKS[claim.verdict]} {verdict_text(claim)}"
    return claim.about + name, claim.quantity, claim.claimed_text, claim.measured_text, verdict


def _commit(folder: Path, run: dict[str, str]) -> str:
    path = folder / f"{run['experiment']}-{run['record_sha256'][:16]}.json"
    content = json.loads(path.read_text(encoding="utf-8"))["content"]
    return str(content["provenance"]["commit"])


def _rows_of(path: Path) -> Iterator[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as lines:
        yield from csv.DictReader(lines)
