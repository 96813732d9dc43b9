"""How does a section look: on one HTML page, and in Markdown?

The HTML page asks for nothing, has everything inside, and can be read without its script. Its
markup stands in the templates ``page.html`` and ``blocks.html`` beside this file, and that of the
Markdown, whose plots and pictures are files beside the text, in ``page.md.jinja``.
"""

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from markupsafe import Markup

from bench.plots import FONTS, Drawing, Plot, key_of
from bench.records.claims import Claim
from bench.records.records import Pictures
from bench.report.document import CLAIM_HEADS, MARKS, Section, claim_cells
from bench.report.first_screen import (
    HEADINGS,
    HEADLINE_HEADS,
    LEDE,
    TITLE,
    WHAT_THIS_IS_NOT,
    first_screen,
    headline_cells,
    strip,
)
from bench.templates import filled

_FOLDER = Path(__file__).parent
_MARK = Markup('<circle class="mark" data-curve="{}" cx="{}" cy="{}"><title>{}</title></circle>')
"""A point of a plot: nothing that is seen, and its numbers under the pointer."""


def to_html(sections: Sequence[Section]) -> str:
    """Write the whole page."""
    script = Markup((_FOLDER / "page.js").read_text(encoding="utf-8"))
    return _filled("page.html", sections, script=script, fonts=Markup(FONTS))


def to_markdown(sections: Sequence[Section]) -> str:
    """Write the whole document."""
    text = _filled("page.md.jinja", sections)
    return text.replace("<", "&lt;")  # no record writes HTML


def _filled(template: str, sections: Sequence[Section], **more: Markup) -> str:
    called = (claim_cells, headline_cells, key_of, picture_path, plot_files, strip)
    return filled(
        _FOLDER / template,
        {"marked_up": _marked_up, "svg": _svg, "cell": _cell, "verdict": _verdict},
        **{each.__name__: each for each in called},
        marks=MARKS,
        table=_table,
        claim_heads=CLAIM_HEADS,
        headings=HEADINGS,
        headline_heads=HEADLINE_HEADS,
        title=TITLE,
        lede=LEDE,
        this_is_not=WHAT_THIS_IS_NOT,
        first=first_screen(sections),
        sections=sections,
        **more,
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


PLOTS = "plots"  # folder of the plots and pictures, beside report.md


def plot_files(section: Section, plot: Plot) -> dict[str, tuple[str, str]]:
    """Give the SVG and the text alternative of a plot's key and panels, by path from report.md."""
    whole = {f"{plot.name}-key": (plot.key, ", ".join(plot.labels))} if plot.key else {}
    whole |= {each.name: (each.svg, each.alt) for each in plot.drawings}
    return {f"{PLOTS}/{section.anchor}-{name}.svg": made for name, made in whole.items()}


def picture_path(section: Section, pictures: Pictures, number: int) -> str:
    """Path of one picture's file, from the folder of report.md."""
    return f"{PLOTS}/{section.anchor}-{pictures.name}-{number}.webp"


def _verdict(claim: Claim) -> str:
    return f"{MARKS[claim.verdict]} {claim.verdict_text}"


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join("| " + " | ".join(_cell(cell) for cell in line) + " |" for line in lines)


def _cell(text: str) -> str:
    """Write a text in one line, as what it is: no cell, link or picture begins in it."""
    return re.sub(r"[|\[\]]", r"\\\g<0>", " ".join(text.split()))
