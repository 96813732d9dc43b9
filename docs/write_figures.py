"""Write the claims that pages quote from the reference run, between the marks of their blocks.

A block begins with ``<!-- claims: headlines -->`` or ``<!-- claims: EXPERIMENT PATTERN… -->``;
a pattern is one of names of claims as of files (``parts_over*/blake/*``), and ends with
``<!-- end of claims -->``. `make docs` fills all pages, and a test compares.
"""

import json
import re
from collections import Counter
from collections.abc import Sequence
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path

from bench.records.claims import Claim, claim_from
from bench.report.document import MARKS

ROOT = Path(__file__).parents[1]
REFERENCE = ROOT / "results" / "reference"
HEADLINES = "headlines"
_BLOCK = re.compile(r"(<!-- claims: ([^>]+) -->\n).*?(<!-- end of claims -->)", re.S)


def pages() -> list[Path]:
    """Return README, the manual and the pages of results that have a block."""
    every = (ROOT / "README.md", *(ROOT / "docs").glob("*.md"), *(ROOT / "results").glob("*.md"))
    return [path for path in every if _BLOCK.search(path.read_text(encoding="utf-8"))]


def filled(text: str) -> str:
    """Give a page with all its blocks written. Raises ValueError for a pattern without a claim."""
    return _BLOCK.sub(lambda found: f"{found[1]}\n{_table(*found[2].split())}\n\n{found[3]}", text)


@cache
def judged() -> dict[str, tuple[list[Claim], str]]:
    """Return the claims of the reference run by experiment, and the commits they are of."""
    runs = json.loads((REFERENCE / "claims.json").read_text(encoding="utf-8"))
    return {
        run["experiment"]: ([claim_from(one) for one in run["claims"]], run["commit"])
        for run in runs
    }


def _table(experiment: str, *patterns: str) -> str:
    if experiment == HEADLINES:
        lines = [
            (*_cells(each), f"`run {name}`")
            for name, (claims, _) in judged().items()
            for each in claims
            if each.headline
        ]
        return _markdown(("claim", "measured (95 %)", "verdict", "measured by"), lines)
    if experiment not in judged():
        return "Not measured yet: the reference run has no record of this experiment."
    claims, commit = judged()[experiment]
    for pattern in patterns:
        if not any(fnmatchcase(each.name, pattern) for each in claims):
            raise ValueError(f"{experiment}: no claim is named {pattern}")
    shown = [
        each
        for each in claims
        if (any(fnmatchcase(each.name, one) for one in patterns) if patterns else each.headline)
    ]
    counted = Counter(each.verdict for each in claims)
    said = ", ".join(f"{n} {verdict}" for verdict, n in counted.most_common())
    table = _markdown(("claim", "measured (95 %)", "verdict"), [_cells(each) for each in shown])
    told = f"Of all {len(claims)} claims: {said}. `lodbench run {experiment}`, commit {commit[:7]}."
    return "\n\n".join(filter(None, (table if shown else "", told)))


def _cells(claim: Claim) -> tuple[str, str, str]:
    return claim.sentence, claim.measured_text, f"{MARKS[claim.verdict]} {claim.verdict_text}"


def _markdown(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(
        "| " + " | ".join(each.replace("|", "\\|") for each in line) + " |" for line in lines
    )


if __name__ == "__main__":
    for page in pages():
        page.write_text(filled(page.read_text(encoding="utf-8")), encoding="utf-8")
