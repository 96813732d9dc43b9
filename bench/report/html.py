"""The report as one HTML page: no request, everything inside, readable without its script."""

from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from string import Template

from bench.plots.plot import Plot
from bench.records.claims import Claim
from bench.records.embedded_pictures import Pictures
from bench.report.document import (
    Block,
    ClaimsBlock,
    Document,
    ListBlock,
    OriginBlock,
    PicturesBlock,
    PlotsBlock,
    Section,
    TableBlock,
)
from bench.report.words import MARKS, claim_cells, verdict_text

_TEMPLATE = Path(__file__).with_name("template.html")
_SCRIPT = Path(__file__).with_name("page.js")

_MARK_RADIUS = 5
"""The radius about a plot's point within which it tells its numbers [units of the SVG]."""

_UNFOLDED_CLAIMS = 4
"""Claims that do not hold are listed at the head of the page; more of them are folded away."""


def to_html(document: Document) -> str:
    """Write the whole page."""
    template, sections = Template(_TEMPLATE.read_text(encoding="utf-8")), document.sections
    return template.substitute(
        title=escape(document.title),
        contents="\n".join(
            f'<li><a href="#{s.anchor}">{escape(s.title)}</a></li>' for s in sections
        ),
        answers="\n".join(_answer(s) for s in sections),
        sections="\n".join(_section(s) for s in sections),
        glossary="\n".join(
            f"<dt>{escape(w)}</dt><dd>{escape(t)}</dd>" for w, t in document.glossary
        ),
        records="\n".join(_provenance(s, s.origin) for s in sections),
        summary="\n".join(_summary_row(s, document.verdicts) for s in sections),
        script=_SCRIPT.read_text(encoding="utf-8"),
    )


def _summary_row(section: Section, verdicts: Sequence[str]) -> str:
    """Write a row of the summary: how many claims have each verdict."""
    counts = "".join(f"<td>{section.count(each)}</td>" for each in verdicts)
    kind = "quick" if section.record.quick else "full"
    return (
        f'<tr><th scope="row"><a href="#{section.anchor}">{escape(section.record.experiment)}</a>'
        f"</th>{counts}<td>{kind}</td><td>{_origin(section)}</td></tr>"
    )


def _origin(section: Section) -> str:
    """Link a record, by its hash, to its provenance."""
    short = section.record.sha256[:8]
    return f'<a class="origin" href="#{section.anchor}-record">record {short}</a>'


def _answer(section: Section) -> str:
    quick = '<span class="quick">quick run: fewer samples</span>' if section.record.quick else ""
    return (
        f'<div class="answer"><p class="question">{escape(section.question)}</p>'
        f"<p><strong>{escape(section.answer)}</strong> {quick} {_origin(section)}</p>"
        f"{_open(section)}</div>"
    )


def _open(section: Section) -> str:
    """List the claims that do not hold, by name."""
    rows = [
        f'<li><span class="{_class(c)}">{verdict_text(c)}</span>: {escape(c.about)} '
        f"{_name(c.name)}</li>"
        for c in section.claims
        if c.verdict not in ("holds", "fails as expected")
    ]
    listed = f'<ul class="open">{"".join(rows)}</ul>' if rows else ""
    if len(rows) <= _UNFOLDED_CLAIMS:
        return listed
    return f"<details><summary>The {len(rows)} claims that do not hold</summary>{listed}</details>"


def _section(section: Section) -> str:
    blocks = "\n".join(_block(section, block) for block in section.blocks())
    return f"""
<section id="{section.anchor}" aria-labelledby="{section.anchor}-title">
<h2 id="{section.anchor}-title">{escape(section.title)}</h2>
{blocks}
</section>"""


def _block(section: Section, block: Block) -> str:
    match block:
        case TableBlock(title, heads, rows, folded):
            table = _table(heads, rows, f"{title}: {section.title}")
            if not folded:
                return f"<h3>{escape(title)}</h3>{table}"
            return (
                f"<details><summary>{escape(title)}, as numbers</summary>"
                f"<p>From {_origin(section)}.</p>\n{table}</details>"
            )
        case ClaimsBlock(title, heads, claims):
            return _claims(title, heads, claims, _origin(section))
        case PlotsBlock(plots):
            drawn = "\n".join(_plot(section, plot) for plot in plots)
            return f'<div class="figures">{drawn}</div>'
        case PicturesBlock(pictures):
            return _pictures(section, pictures)
        case ListBlock(title, items):
            listed = "\n".join(f"<li>{_code(item)}</li>" for item in items)
            return f"<h3>{escape(title)}</h3><ul>{listed}</ul>"
        case OriginBlock():
            return ""  # all provenance stands together, at the end of the page


def _claims(title: str, heads: Sequence[str], claims: Sequence[Claim], origin: str) -> str:
    """Write a row for each claim; on a narrow screen the style makes a labelled card of each."""
    rows = "\n".join(_claim(heads, claim) for claim in claims)
    head = _heads(heads).replace("<tr>", '<tr role="row">', 1)
    head = head.replace("<th ", '<th role="columnheader" ')
    return (
        f'<table class="claims" role="table"><caption>{escape(title)}</caption>'
        f'<thead role="rowgroup">{head}</thead><tbody role="rowgroup">{rows}</tbody></table>'
        f"<p>From {origin}.</p>"
    )


def _claim(heads: Sequence[str], claim: Claim) -> str:
    cells = [
        f'<td role="cell" class="{_class(claim)}"><span aria-hidden="true">'
        f"{MARKS[claim.verdict]}</span> {verdict_text(claim)}</td>"
    ]
    for head, cell in zip(heads[1:], claim_cells(claim), strict=True):
        text = _name(cell) if head == "name" else escape(cell)
        cells.append(f'<td role="cell" data-head="{head}">{text}</td>')
    return f'<tr role="row">{"".join(cells)}</tr>'


def _class(claim: Claim) -> str:
    """Name the class of a verdict in the page's style: its first word."""
    return claim.verdict.partition(" ")[0]


def _name(name: str) -> str:
    """Write a claim's name so that it may break after a stroke or an underscore."""
    return f"<code>{escape(name).replace('/', '/<wbr>').replace('_', '_<wbr>')}</code>"


def _plot(section: Section, plot: Plot) -> str:
    """Write a plot with its points, which tell their numbers, and the numbers as a table."""
    name = f"{section.anchor}-{plot.name}"
    svg = plot.svg.replace("<svg", f'<svg role="img" aria-label="{escape(plot.alt)}"', 1)
    # Several records may show the same plot: ids stay unique on the page.
    svg = svg.replace(f"{plot.name}-", f"{name}-")
    marks = "".join(
        f'<circle class="mark" data-curve="{mark.curve}" cx="{mark.place[0]}" cy="{mark.place[1]}"'
        f' r="{_MARK_RADIUS}"><title>{escape(mark.words)}</title></circle>'
        for mark in plot.marks
    )
    numbers = _table(*plot.numbers, label=f"Numbers of: {plot.title}")
    return (
        f'<figure class="plot" id="{name}-figure"><h3>{escape(plot.title)}</h3>'
        f"{svg.replace('</svg>', f'{marks}</svg>')}"
        f"<details><summary>Numbers of this plot</summary>{numbers}</details>"
        f"<figcaption>{escape(plot.caption)} {_origin(section)}</figcaption></figure>"
    )


def _pictures(section: Section, pictures: Pictures) -> str:
    """Lay two of the pictures over each other, with a slider between them."""
    name = f"{section.anchor}-{pictures.name}"
    images = [f"data:image/webp;base64,{data}" for _, data in pictures.layers]
    labels = [label for label, _ in pictures.layers]
    selects = "".join(
        f'<label>{side} <select autocomplete="off">'
        + "".join(
            f'<option data-src="{image}" data-alt="{escape(f"{label}. {pictures.alt}")}"'
            f"{' selected' if number == chosen else ''}>{escape(label)}</option>"
            for number, (label, image) in enumerate(zip(labels, images, strict=True))
        )
        + "</select></label>"
        for side, chosen in (("left", 0), ("right", 1))
    )
    shown = "".join(
        f'<img src="{images[number]}" alt="{escape(f"{labels[number]}. {pictures.alt}")}">'
        for number in (1, 0)
    )
    return (
        f'<figure class="pictures" id="{name}-pictures"><h3>{escape(pictures.title)}</h3>'
        f'<div class="pair">{shown}</div><div class="controls">{selects}<label>divide at '
        f'<input type="range" min="0" max="100" value="50" autocomplete="off"></label></div>'
        f"<figcaption>{escape(pictures.caption)} {_origin(section)}</figcaption></figure>"
    )


def _provenance(section: Section, origin: OriginBlock) -> str:
    table = _table(origin.heads, origin.rows, f"Provenance of {section.title}")
    facts = table.replace("<table>", '<table class="facts">', 1)
    return (
        f'<h3 id="{section.anchor}-record">{escape(section.title)}</h3>{facts}'
        f"<p>Repeat it: <code>{escape(origin.command)}</code>. The same seed gives the same "
        f"samples, and so the same SHA-256 of samples.</p>"
    )


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]], label: str) -> str:
    body = "\n".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    return _framed(label, _heads(heads) + body)


def _framed(label: str, rows: str, caption: str = "") -> str:
    """Put a table into a frame that scrolls where the screen is narrow, by keyboard too."""
    caption = f"<caption>{escape(caption)}</caption>" if caption else ""
    return (
        f'<div class="wide" role="region" tabindex="0" aria-label="{escape(label)}">'
        f"<table>{caption}{rows}</table></div>"
    )


def _heads(heads: Sequence[str]) -> str:
    return "<tr>" + "".join(f'<th scope="col">{escape(h)}</th>' for h in heads) + "</tr>"


def _code(text: str) -> str:
    """Mark up what stands between backquotes as code."""
    pieces = escape(text).split("`")
    return "".join(f"<code>{p}</code>" if i % 2 else p for i, p in enumerate(pieces))
