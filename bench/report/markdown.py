"""The report as Markdown, its plots as files beside it."""

from collections.abc import Iterable, Sequence

from bench.records.embedded_pictures import Pictures
from bench.report.words import (
    CLAIM_HEADS,
    GLOSSARY,
    MARKS,
    Section,
    answer,
    groups,
    provenance_rows,
    repeat,
    verdict,
    words,
)

PLOTS = "plots"
"""Folder of the plots, beside report.md."""


def document(sections: Sequence[Section]) -> str:
    """The whole document."""
    blocks = ["# lodbench: what was claimed, and what was measured"]
    for section in sections:
        blocks += _section(section)
    blocks += ["## Words and symbols", _table(("word", "meaning"), GLOSSARY)]
    return "\n\n".join(blocks) + "\n"


def picture_path(section: Section, each: Pictures, number: int) -> str:
    """Where a picture lies, from report.md."""
    return f"{PLOTS}/{section.anchor}-{each.name}-{number}.webp"


def _section(section: Section) -> Iterable[str]:
    yield f"## {section.title}"
    yield f"**{section.question}** {answer(section.claims)}"
    if section.summary[1]:
        yield "### In short\n\n" + _table(*section.summary)
    for title, claims in groups(section.claims).items():
        yield f"### {title}"
        rows = [(f"{MARKS[c.verdict]} {verdict(c)}", *words(c)) for c in claims]
        yield _table(CLAIM_HEADS, rows)
    for plot in section.plots:
        path = f"{PLOTS}/{section.anchor}-{plot.name}.svg"
        yield f"### {plot.title}\n\n![{plot.alt}]({path})\n\n{plot.caption}"
    for each in section.pictures:
        yield f"### {each.title}\n\n{each.caption}"
        paths = [picture_path(section, each, number) for number in range(len(each.layers))]
        cells = [
            f"![{label}. {each.alt}]({path})"
            for (label, _), path in zip(each.layers, paths, strict=True)
        ]
        yield _table([label for label, _ in each.layers], [cells])
    yield "### What this does not say\n\n" + "\n".join(f"- {caveat}" for caveat in section.caveats)
    heads, rows = section.table
    if rows:
        yield "### Every point\n\n" + _table(heads, rows)
    yield "### Where it comes from\n\n" + _table(("what", "value"), provenance_rows(section))
    yield f"Repeat it: `{repeat(section)}`"


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join("| " + " | ".join(_cell(cell) for cell in line) + " |" for line in lines)


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")
