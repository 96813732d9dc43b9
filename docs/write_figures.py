"""Write the claims and figures of the reference run into pages, between the marks of their blocks.

A block begins with ``<!-- claims: headlines -->`` or ``<!-- claims: EXPERIMENT PATTERN… -->``;
a pattern is one of names of claims as of files (``parts_over*/blake/*``), and ends with
``<!-- end of claims -->``. ``<!-- figure: EXPERIMENT NAME PANELS -->`` begins a figure of
``report.md``, of which so many panels are shown, or all; it ends with ``<!-- end of figure -->``.
``<!-- value: EXPERIMENT PATTERN -->`` begins a number within a sentence, the measured value of the
one claim of that name with its interval, and ``<!-- end of value -->`` ends it. Between
``<!-- found -->`` and ``<!-- end of found -->`` stand the titles of ANSWERS, and between
``<!-- records -->`` and ``<!-- end of records -->`` what measured every record.
``<!-- table: TITLE -->`` begins the table of that title in ``report.md``, and
``<!-- end of table -->`` ends it.
`make docs` fills all pages, and a test compares. Figures of a record whose experiment
asks something else today cannot be drawn again: those blocks and rows stay as they were.
"""

import json
import os
import re
from collections import Counter
from collections.abc import Sequence
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path
from typing import Any

from bench.records.claims import Claim, claim_from
from bench.records.probe import CASES
from bench.records.records import Record, read_records
from bench.report.document import MARKS
from bench.report.write import OTHER_VERSION

ROOT = Path(__file__).parents[1]
REFERENCE = ROOT / "results" / "reference"
HEADLINES = "headlines"
_BLOCK = re.compile(r"(<!-- claims: ([^>]+) -->\n).*?(<!-- end of claims -->)", re.S)
_FIGURE = re.compile(r"(<!-- figure: ([^>]+) -->\n).*?(<!-- end of figure -->)", re.S)
_VALUE = re.compile(r"(<!-- value: (\S+) (\S+) -->).*?(<!-- end of value -->)", re.S)
_FOUND = re.compile(r"(<!-- found -->\n).*?(<!-- end of found -->)", re.S)
_TABLE = re.compile(r"(<!-- table: (.+) -->\n).*?(<!-- end of table -->)", re.S)
_RECORDS = re.compile(r"(<!-- records -->\n).*?(<!-- end of records -->)", re.S)
ANSWERS = (
    ("Do counts follow the law?", "law", "counts", "law"),
    ("Which detail keeps a frame within a budget?", "spread", "budget", "spread"),
    ("How do the parts of one figure drop off with distance?", "figure", "parts", "law"),
    ("What does a larger world cost?", "cost", "stages", "cost"),
    ("Is tone kept at every distance?", "images", "by-distance", "images"),
    ("Are the presets as shipped close to the finest picture?", "bar", "presets", "presets"),
    ("Is it better than other methods?", "methods", "methods", "methods"),
)
"""Questions, the figure whose title answers each (experiment, name), and its page of results."""

NOT_YET = "Not measured yet: the reference run has no record of this experiment."

_HAVE = {
    "holds": ("holds", "hold"),
    "refuted": ("is refuted", "are refuted"),
    "inconclusive": ("is inconclusive", "are inconclusive"),
    "expected violation": ("is an expected violation", "are expected violations"),
}
"""Verdicts as predicates, of one claim and of several."""

_IMAGE = re.compile(r"!\[([^]]*)\]\((plots/([a-z]+)-[0-9a-f]{8}-([\w.-]+)-(\d+|key)\.svg)\)")


def pages() -> list[Path]:
    """Return README, the manual and the pages of results that have a block."""
    every = (ROOT / "README.md", *(ROOT / "docs").glob("*.md"), *(ROOT / "results").glob("*.md"))
    texts = {path: path.read_text(encoding="utf-8") for path in every}
    marks = _BLOCK, _FIGURE, _VALUE
    return [path for path, text in texts.items() if any(each.search(text) for each in marks)]


def filled(text: str, folder: str = "reference") -> str:
    """Give a page with all its blocks written; ``folder`` is the way to the reference run.

    Raises ValueError for a pattern without a claim, and for a figure that is not there.
    """
    text = _BLOCK.sub(lambda found: f"{found[1]}\n{_table(*found[2].split())}\n\n{found[3]}", text)
    text = _VALUE.sub(lambda old: f"{old[1]}{_value(old[2], old[3])}{old[4]}", text)
    text = _FOUND.sub(lambda old: f"{old[1]}\n{_found(folder, old[0])}\n\n{old[2]}", text)
    text = _TABLE.sub(lambda old: f"{old[1]}\n{_copied(old[2])}\n\n{old[3]}", text)
    text = _RECORDS.sub(lambda old: f"{old[1]}\n{_measured_by()}\n\n{old[2]}", text)
    return _FIGURE.sub(
        lambda old: (
            old[0]
            if _is_other_today(old[2].split()[0])
            else f"{old[1]}\n{_figure(folder, *old[2].split())}\n\n{old[3]}"
        ),
        text,
    )


def _is_other_today(experiment: str) -> bool:
    report = (REFERENCE / "report.md").read_text(encoding="utf-8")
    section = re.search(rf"^## {experiment}: .*?(?=^## |\Z)", report, re.S | re.M)
    return section is not None and OTHER_VERSION in section[0]


def folder_of(page: Path) -> str:
    """Give the way from a page to the reference run."""
    return Path(os.path.relpath(REFERENCE, page.parent)).as_posix()


def _figure(folder: str, experiment: str, name: str, panels: str = "99") -> str:
    if experiment not in judged():
        return NOT_YET
    title, found, caption = _drawn(experiment, name)
    shown = [each for each in found if each[4] == "key" or int(each[4]) < int(panels)]
    images = {each[4]: f"![{each[0]}]({folder}/{each[1]})" for each in shown}
    key = images.pop("key", "")
    return "\n\n".join(filter(None, (f"**{title}.**", key, " ".join(images.values()), caption)))


def _found(folder: str, old: str) -> str:
    was = dict(re.findall(r"^\| ([^|]*\?) \| ([^|]*) \|", old, re.M))
    lines = [
        (
            question,
            _answer(experiment, name, was.get(question, "")),
            f"[{page}]({folder.removesuffix('reference')}{page}.md)",
        )
        for question, experiment, name, page in ANSWERS
    ]
    return _markdown(("question", "what was found", "more"), lines)


@cache
def _records() -> list[Record]:
    return sorted(read_records(REFERENCE), key=lambda each: each.made)


def _measured_by() -> str:
    lines = []
    for record in _records():
        topics = ", ".join(f"`{name}`" for name in record.notes["sizes"])
        groups: dict[tuple[str, ...], list[dict[str, Any]]] = {}
        for case in record.notes[CASES]:
            machine = f"{case['cpu']}, {case['cores']} cores, {case['memory_bytes'] / 1e9:.0f} GB"
            where = case["digest"][:7], case["commit"][:7], machine
            groups.setdefault(where, []).append(case)
        for where, made in groups.items():
            loads = [case["load"] for case in made]
            hours = sum(case["processor_seconds"] for case in made) / 3600
            told = f"{min(loads):.1f} to {max(loads):.1f}", str(len(made)), f"{hours:.2f}"
            lines.append((topics, *where, *told, record.made[:10]))
    heads = ("topics", "sources", "commit", "machine", "load", "cases", "core hours", "recorded")
    return _markdown(heads, lines)


def _answer(experiment: str, name: str, was: str) -> str:
    if _is_other_today(experiment):
        return was
    return f"{_drawn(experiment, name)[0]}." if experiment in judged() else NOT_YET


def _copied(title: str) -> str:
    report = (REFERENCE / "report.md").read_text(encoding="utf-8")
    return report.split(f"\n### {title}\n\n", 1)[1].split("\n\n", 1)[0]


def _drawn(experiment: str, name: str) -> tuple[str, list[tuple[str, ...]], str]:
    """Return the title, the images and the caption of a figure of report.md.

    The title of a run that has seen some of its places says how many.
    """
    mine = (record for record in _records() if record.experiment == experiment)
    seen = "".join(f" ({each.notes['places']} places)" for each in mine if "places" in each.notes)
    pieces = (REFERENCE / "report.md").read_text(encoding="utf-8").split("\n\n")
    for title, images, caption in zip(pieces, pieces[1:], pieces[2:], strict=False):
        found = _IMAGE.findall(images) if title.startswith("### ") else []
        if any(each[2:4] == (experiment, name) for each in found):
            return title.removeprefix("### ") + seen, found, caption
    raise ValueError(f"report.md has no figure {name} of {experiment}")


@cache
def judged() -> dict[str, tuple[list[Claim], str]]:
    """Return the claims of the reference run by experiment, and the commits they are of.

    Those of several records of an experiment, as of topics that were run apart, are together.
    """
    runs = json.loads((REFERENCE / "claims.json").read_text(encoding="utf-8"))
    found: dict[str, tuple[list[Claim], str]] = {}
    for run in runs:
        claims, commits = found.get(run["experiment"], ([], ""))
        for commit in run["case_commits"] or [run["commit"]]:
            if commit[:7] not in commits:
                commits = ", ".join(filter(None, (commits, commit[:7])))
        found[run["experiment"]] = [*claims, *map(claim_from, run["claims"])], commits
    return found


def _table(experiment: str, *patterns: str) -> str:
    if experiment == HEADLINES:
        lines = [
            (*_cells(each), f"`{_command(name)}`")
            for name, (claims, _) in judged().items()
            for each in claims
            if each.headline
        ]
        return _markdown(("claim", "measured (95 %)", "verdict", "measured by"), lines)
    if experiment not in judged():
        return NOT_YET
    claims, commits = judged()[experiment]
    for pattern in patterns:
        if not any(fnmatchcase(each.name, pattern) for each in claims):
            raise ValueError(f"{experiment}: no claim is named {pattern}")
    shown = [
        each
        for each in claims
        if (any(fnmatchcase(each.name, one) for one in patterns) if patterns else each.headline)
    ]
    counted = Counter(each.verdict for each in claims).most_common()
    *others, last = [f"{n} {_HAVE[verdict][n > 1]}" for verdict, n in counted]
    said = " and ".join(filter(None, (", ".join(others), last)))
    checks = sum(each.kind == "verification" for each in claims)
    verified = f", of which {checks} verify the program," if checks else ""
    table = _markdown(("claim", "measured (95 %)", "verdict"), [_cells(each) for each in shown])
    made = f"`lodbench {_command(experiment)}`, commit {commits}"
    told = f"Of all {len(claims)} claims{verified} {said}. {made}."
    return "\n\n".join(filter(None, (table if shown else "", told)))


def _command(experiment: str) -> str:
    mine = (record for record in _records() if record.experiment == experiment)
    return " ".join(("run", *(topic for record in mine for topic in record.notes["sizes"])))


def _value(experiment: str, pattern: str) -> str:
    claims, _ = judged().get(experiment, ([], ""))
    named = [each for each in claims if fnmatchcase(each.name, pattern)]
    if len(named) != 1:
        raise ValueError(
            f"{experiment}: {len(named)} claims are named {pattern}, where one is meant"
        )
    found = named[0]
    return f"{found.measured:.2g} ({found.low:.2g} to {found.high:.2g})"


def _cells(claim: Claim) -> tuple[str, str, str]:
    return claim.sentence, claim.measured_text, f"{MARKS[claim.verdict]} {claim.verdict_text}"


def _markdown(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(
        "| " + " | ".join(each.replace("|", "\\|") for each in line) + " |" for line in lines
    )


if __name__ == "__main__":
    for page in pages():
        text = page.read_text(encoding="utf-8")
        page.write_text(filled(text, folder_of(page)), encoding="utf-8")
