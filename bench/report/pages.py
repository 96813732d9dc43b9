"""How does each kind of block look: on one HTML page, and in Markdown?

The HTML page asks for nothing, has everything inside, and can be read without its script. Its
markup stands in two templates beside this file: ``page.html``, and ``blocks.html``, which has a
macro for each kind of block. In Markdown, plots and pictures are files beside the text.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from bench.plots import FONTS, Drawing, Plot, key_of
from bench.records.claims import Claim
from bench.records.records import Pictures
from bench.report.document import (
    GLOSSARY,
    MARKS,
    Block,
    ClaimsBlock,
    HeadlinesBlock,
    ListBlock,
    OriginBlock,
    PicturesBlock,
    PlotsBlock,
    Section,
    TableBlock,
    TextBlock,
    claim_cells,
)
from bench.report.first_screen import TITLE, first_screen, hero

_FOLDER = Path(__file__).parent
_MARK = Markup('<circle class="mark" data-curve="{}" cx="{}" cy="{}"><title>{}</title></circle>')
"""A point of a plot: nothing that is seen, and its numbers under the pointer."""


def to_html(sections: Sequence[Section]) -> str:
    """Write the whole page."""
    environment = Environment(
        loader=FileSystemLoader(_FOLDER),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals |= {"marks": MARKS, "cells": claim_cells, "key_of": key_of}
    environment.filters |= {
        "kind": lambda block: type(block).__name__,
        "marked_up": _marked_up,
        "svg": _svg,
    }
    script = Markup((_FOLDER / "page.js").read_text(encoding="utf-8"))
    page = environment.get_template("page.html")
    return page.render(
        title=TITLE,
        hero=hero(sections),
        first=list(first_screen(sections)),
        sections=sections,
        glossary=GLOSSARY,
        script=script,
        fonts=Markup(FONTS),
    )


def _svg(drawing: Drawing, lead: str) -> Markup:
    """Write a panel with its text alternative and its points; ``lead`` makes its ids unique."""
    svg = Markup(
        drawing.svg.replace(f"style='font-family: {FONTS}' ", "").replace(
            f"{drawing.name}-", f"{lead}-{drawing.name}-"
        )
    )
    svg = svg.replace("<svg", Markup('<svg role="img" aria-label="{}"').format(drawing.alt), 1)
    marks = (_MARK.format(each.curve, *each.place, each.words) for each in drawing.marks)
    return svg.replace("</svg>", Markup("").join(marks) + Markup("</svg>"))


def _marked_up(text: str) -> Markup:
    pieces = [
        Markup("<code>{}</code>" if k % 2 else "{}").format(p)
        for k, p in enumerate(text.split("`"))
    ]
    return Markup("").join(pieces)


PLOTS = "plots"
"""Folder of the plots and pictures, beside report.md."""


def to_markdown(sections: Sequence[Section]) -> str:
    """Write the whole document."""
    pieces = [f"# {TITLE}"]
    for block in first_screen(sections):
        pieces += _pieces(None, block, "##")
    for section in sections:
        pieces += [f"## {section.title}", f"**{section.question}** {section.answer}"]
        pieces += [f"**{section.stale}**"] if section.stale else []
        pieces += [piece for block in section.blocks() for piece in _pieces(section, block)]
    pieces += ["## Words and symbols", _table(("word", "meaning"), GLOSSARY)]
    return "\n\n".join(pieces).replace("<", "&lt;") + "\n"  # no record writes HTML


def plot_files(section: Section, plot: Plot) -> dict[str, tuple[str, str]]:
    """Give the SVG and the text alternative of a plot's key and panels, by path from report.md."""
    whole = {f"{plot.name}-key": (plot.key, ", ".join(plot.labels))} if plot.key else {}
    whole |= {each.name: (each.svg, each.alt) for each in plot.drawings}
    return {f"{PLOTS}/{section.anchor}-{name}.svg": made for name, made in whole.items()}


def picture_path(section: Section, pictures: Pictures, number: int) -> str:
    """Path of one picture's file, from the folder of report.md."""
    return f"{PLOTS}/{section.anchor}-{pictures.name}-{number}.webp"


def _pieces(section: Any, block: Block, level: str = "###") -> Iterator[str]:
    match block:
        case TextBlock(text):
            yield text
        case HeadlinesBlock(title, _, heads, rows):
            marked = [
                (
                    _verdict(each.claim) + (" (older code)" if each.section.stale else ""),
                    *each.cells,
                )
                for each in rows
            ]
            yield f"{level} {_cell(title)}\n\n" + _table(heads[:-1], marked)
        case TableBlock(title, heads, rows):
            yield f"{level} {_cell(title)}\n\n" + _table(heads, rows)
        case ClaimsBlock(title, heads, claims, _, whole):
            told = [(_verdict(each), *claim_cells(each, whole)) for each in claims]
            yield f"{level} {_cell(title)}\n\n" + _table(heads, told)
        case PlotsBlock(plots):
            for plot in plots:
                files = plot_files(section, plot)
                images = " ".join(f"![{_cell(alt)}]({path})" for path, (_, alt) in files.items())
                yield f"{level} {_cell(plot.title)}\n\n{images}\n\n{_cell(plot.caption)}"
        case PicturesBlock(pictures):
            labels = [label for label, _ in pictures.layers]
            paths = (picture_path(section, pictures, number) for number in range(len(labels)))
            alts = (_cell(f"{label}. {pictures.alt}") for label in labels)
            cells = [f"![{a}]({b})" for a, b in zip(alts, paths, strict=True)]
            rows = f"{_table(labels, ())}\n| {' | '.join(cells)} |"
            yield f"{level} {_cell(pictures.title)}\n\n{_cell(pictures.caption)}\n\n{rows}"
        case ListBlock(title, items):
            yield f"{level} {title}\n\n" + "\n".join(f"- {item}" for item in items)
        case OriginBlock(heads, rows, command):
            yield f"{level} Where it comes from\n\n" + _table(heads, rows)
            yield f"Repeat it: `{_cell(command)}`"


def _verdict(claim: Claim) -> str:
    return f"{MARKS[claim.verdict]} {claim.verdict_text}"


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join("| " + " | ".join(_cell(cell) for cell in line) + " |" for line in lines)


def _cell(text: str) -> str:
    """Write a text in one line, as what it is: no cell, link or picture begins in it."""
    return re.sub(r"[|\[\]]", r"\\\g<0>", " ".join(text.split()))
