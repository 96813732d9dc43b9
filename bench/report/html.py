"""The report as one HTML page: no request, everything inside, readable without its script.

The markup stands in two templates beside this file: ``page.html``, and ``blocks.html``, which has a
macro for each kind of block.
"""

from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape

from bench.plots.plot import Plot
from bench.report.document import Document, Section
from bench.report.first_screen import LIMITS, MEASURED, WHAT_THIS_IS_NOT, headlines
from bench.report.words import MARKS, claim_cells

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
