"""The report as one HTML page: no script, no request, everything inside."""

from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from string import Template

from bench.claims import Claim
from bench.figures import Figure
from bench.report_parts import (
    CLAIM_HEADS,
    GLOSSARY,
    MARKS,
    Section,
    answer,
    groups,
    provenance_rows,
    repeat,
    words,
)

_TEMPLATE = Path(__file__).with_name("report_template.html")


def page(sections: Sequence[Section]) -> str:
    """The whole page."""
    template = Template(_TEMPLATE.read_text(encoding="utf-8"))
    return template.substitute(
        contents="\n".join(
            f'<li><a href="#{s.anchor}">{escape(s.title)}</a></li>' for s in sections
        ),
        answers="\n".join(_answer(s) for s in sections),
        sections="\n".join(_section(s) for s in sections),
        glossary="\n".join(f"<dt>{escape(w)}</dt><dd>{escape(t)}</dd>" for w, t in GLOSSARY),
        records=_records(sections),
    )


def _answer(section: Section) -> str:
    quick = '<span class="quick">quick run: fewer samples</span>' if section.record.quick else ""
    return (
        f'<div class="answer"><p class="question">{escape(section.question)}</p>'
        f"<p><strong>{escape(answer(section.record.claims))}</strong> {quick}</p>"
        f"{_open(section)}</div>"
    )


def _open(section: Section) -> str:
    """The claims that do not hold, by name."""
    rows = [
        f'<li><span class="{c.verdict}">{c.verdict}</span>: {escape(c.about)} {_name(c.name)}</li>'
        for c in section.record.claims
        if c.verdict != "holds"
    ]
    return f'<ul class="open">{"".join(rows)}</ul>' if rows else ""


def _section(section: Section) -> str:
    tables = [_claims(title, c) for title, c in groups(section.record.claims).items()]
    figures = "\n".join(_figure(section, figure) for figure in section.figures)
    limits = "\n".join(f"<li>{_code(limit)}</li>" for limit in section.limits)
    return f"""
<section id="{section.anchor}" aria-labelledby="{section.anchor}-title">
<h2 id="{section.anchor}-title">{escape(section.title)}</h2>
{"".join(tables[:1])}
<div class="figures">{figures}</div>
{"".join(tables[1:])}
<h3>What this does not say</h3><ul>{limits}</ul>
<details><summary>Every point, as numbers</summary>
{_table(*section.table, label="Every point")}</details>
</section>"""


def _claims(title: str, claims: Sequence[Claim]) -> str:
    """One row a claim; on a narrow screen the style makes a card of each, labelled cell by cell."""
    rows = "\n".join(_claim(claim) for claim in claims)
    heads = _heads(CLAIM_HEADS).replace("<tr>", '<tr role="row">', 1)
    heads = heads.replace("<th ", '<th role="columnheader" ')
    return (
        f'<table class="claims" role="table"><caption>{escape(title)}</caption>'
        f'<thead role="rowgroup">{heads}</thead><tbody role="rowgroup">{rows}</tbody></table>'
    )


def _claim(claim: Claim) -> str:
    cells = [
        f'<td role="cell" class="{claim.verdict}"><span aria-hidden="true">'
        f"{MARKS[claim.verdict]}</span> {claim.verdict}</td>"
    ]
    for head, cell in zip(CLAIM_HEADS[1:], words(claim), strict=True):
        text = _name(cell) if head == "name" else escape(cell)
        cells.append(f'<td role="cell" data-head="{head}">{text}</td>')
    return f'<tr role="row">{"".join(cells)}</tr>'


def _name(name: str) -> str:
    """A claim's name, that may break after a stroke or an underscore."""
    return f"<code>{escape(name).replace('/', '/<wbr>').replace('_', '_<wbr>')}</code>"


def _figure(section: Section, figure: Figure) -> str:
    svg = figure.svg.replace("<svg", f'<svg role="img" aria-label="{escape(figure.alt)}"', 1)
    # Several records may show the same figure: ids stay unique on the page.
    svg = svg.replace(f"{figure.name}-", f"{section.anchor}-{figure.name}-")
    return (
        f"<figure><h3>{escape(figure.title)}</h3>{svg}"
        f"<figcaption>{escape(figure.caption)}</figcaption></figure>"
    )


def _records(sections: Sequence[Section]) -> str:
    return "\n".join(
        f"<h3>{escape(s.title)}</h3>{_facts(s)}"
        f"<p>Repeat it: <code>{escape(repeat(s))}</code>. The same seed gives the same samples, "
        f"and so the same SHA-256 of samples.</p>"
        for s in sections
    )


def _facts(section: Section) -> str:
    table = _table(("what", "value"), provenance_rows(section), section.title)
    return table.replace("<table>", '<table class="facts">', 1)


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]], label: str) -> str:
    body = "\n".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    return _framed(label, _heads(heads) + body)


def _framed(label: str, rows: str, caption: str = "") -> str:
    """A table that scrolls in its own frame where the screen is narrow, by keyboard too."""
    caption = f"<caption>{escape(caption)}</caption>" if caption else ""
    return (
        f'<div class="wide" role="region" tabindex="0" aria-label="{escape(label)}">'
        f"<table>{caption}{rows}</table></div>"
    )


def _heads(heads: Sequence[str]) -> str:
    return "<tr>" + "".join(f'<th scope="col">{escape(h)}</th>' for h in heads) + "</tr>"


def _code(text: str) -> str:
    """Text with `code` marked up."""
    pieces = escape(text).split("`")
    return "".join(f"<code>{p}</code>" if i % 2 else p for i, p in enumerate(pieces))
