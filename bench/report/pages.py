"""The report as one HTML page: no request, everything inside, readable without its script.

The markup stands in two templates beside this file: ``page.html``, and ``blocks.html``, which has a
macro for each kind of block.

The report as Markdown, its plots and pictures as files beside it.
"""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape

from bench.plots import Plot
from bench.records.records import Pictures
from bench.report.document import (
    MARKS,
    Block,
    ClaimsBlock,
    Document,
    ListBlock,
    OriginBlock,
    PicturesBlock,
    PlotsBlock,
    Section,
    TableBlock,
    claim_cells,
)
from bench.report.first_screen import LIMITS, MEASURED, WHAT_THIS_IS_NOT, headlines

_FOLDER = Path(__file__).parent
_MARK = Markup(
    '<circle class="mark" data-curve="{}" cx="{}" cy="{}" r="5"><title>{}</title></circle>'
)
"""A point of a plot: nothing that is seen, and its numbers under the pointer."""


def to_html(document: Document) -> str:
    """Write the whole page."""
    environment = Environment(
        loader=FileSystemLoader(_FOLDER),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals |= {"marks": MARKS, "cells": claim_cells}
    environment.globals |= {"measured": MEASURED, "limits": LIMITS, "is_not": WHAT_THIS_IS_NOT}
    environment.filters |= {
        "kind": lambda block: type(block).__name__,
        "breakable": _breakable,
        "marked_up": _marked_up,
        "svg": _svg,
    }
    script = Markup((_FOLDER / "page.js").read_text(encoding="utf-8"))
    shown = headlines(document.sections)
    page = environment.get_template("page.html")
    return page.render(document=document, headlines=shown, script=script)


def _svg(plot: Plot, section: Section) -> Markup:
    """Write a plot with its text alternative and its points; its ids are unique on the page."""
    name = f"{section.anchor}-{plot.name}"
    svg = Markup(plot.svg.replace(f"{plot.name}-", f"{name}-"))
    svg = svg.replace("<svg", Markup('<svg role="img" aria-label="{}"').format(plot.alt), 1)
    marks = (_MARK.format(each.curve, *each.place, each.words) for each in plot.marks)
    return svg.replace("</svg>", Markup("").join(marks) + Markup("</svg>"))


def _breakable(name: str) -> Markup:
    """Let a claim's name break after a stroke or an underscore."""
    return Markup(str(escape(name)).replace("/", "/<wbr>").replace("_", "_<wbr>"))


def _marked_up(text: str) -> Markup:
    """Mark up what stands between backquotes as code."""
    pieces = [
        Markup("<code>{}</code>" if k % 2 else "{}").format(p)
        for k, p in enumerate(text.split("`"))
    ]
    return Markup("").join(pieces)


PLOTS = "plots"
"""Folder of the plots and pictures, beside report.md."""


def to_markdown(document: Document) -> str:
    """Write the whole document."""
    pieces = [f"# {document.title}", *_first(document)]
    for section in document.sections:
        pieces += [f"## {section.title}", f"**{section.question}** {section.answer}"]
        pieces += [f"**{section.stale}**"] if section.stale else []
        pieces += [piece for block in section.blocks() for piece in _pieces(section, block)]
    pieces += ["## Words and symbols", _table(("word", "meaning"), document.glossary)]
    return "\n\n".join(pieces) + "\n"


def plot_path(section: Section, plot: Plot) -> str:
    """Path of a plot's file, from the folder of report.md."""
    return f"{PLOTS}/{section.anchor}-{plot.name}.svg"


def picture_path(section: Section, pictures: Pictures, number: int) -> str:
    """Path of one picture's file, from the folder of report.md."""
    return f"{PLOTS}/{section.anchor}-{pictures.name}-{number}.webp"


def _first(document: Document) -> Iterator[str]:
    """Give what the first screen shows."""
    heads = "verdict", "claim", "measured (95 %)", "unit", "command"
    rows = [
        (
            f"{MARKS[each.claim.verdict]} {each.claim.verdict_text}"
            + (" (older code)" if each.section.stale else ""),
            each.claim.sentence,
            each.claim.measured_text,
            each.claim.unit,
            f"`{each.command}`",
        )
        for each in headlines(document.sections)
    ]
    if rows:
        yield f"## {MEASURED}\n\n" + _table(heads, rows)
    yield document.verified
    yield f"## {LIMITS}\n\n" + "\n".join(f"- {each}" for each in WHAT_THIS_IS_NOT)


def _pieces(section: Section, block: Block) -> Iterator[str]:
    match block:
        case TableBlock(title, heads, rows):
            yield f"### {title}\n\n" + _table(heads, rows)
        case ClaimsBlock(title, heads, claims, _):
            yield f"### {title}"
            signed = [(f"{MARKS[c.verdict]} {c.verdict_text}", *claim_cells(c)) for c in claims]
            yield _table(heads, signed)
        case PlotsBlock(plots):
            for plot in plots:
                image = f"![{plot.alt}]({plot_path(section, plot)})"
                yield f"### {plot.title}\n\n{image}\n\n{plot.caption}"
        case PicturesBlock(pictures):
            yield f"### {pictures.title}\n\n{pictures.caption}"
            yield _pictures(section, pictures)
        case ListBlock(title, items):
            yield f"### {title}\n\n" + "\n".join(f"- {item}" for item in items)
        case OriginBlock(heads, rows, command):
            yield "### Where it comes from\n\n" + _table(heads, rows)
            yield f"Repeat it: `{command}`"


def _pictures(section: Section, pictures: Pictures) -> str:
    cells = [
        f"![{label}. {pictures.alt}]({picture_path(section, pictures, number)})"
        for number, (label, _) in enumerate(pictures.layers)
    ]
    return _table([label for label, _ in pictures.layers], [cells])


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join("| " + " | ".join(_cell(cell) for cell in line) + " |" for line in lines)


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")
