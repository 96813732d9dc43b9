"""How is a figure made? Panels of curves as SVG, the numbers behind them and a text alternative.

Only this file draws. A figure has a title that states its message, and panels: each is an SVG of
its own, so narrow that its letters are read on a telephone, and panels stand side by side where
there is room. The same drawing stands on the page, in files and in print; what is black or white in
it follows the page's colours. Colours of curves are those of Okabe & Ito, "Color Universal Design"
(2008), and no two curves differ in colour alone.
"""

import io
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure as Canvas
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter

from bench.statistics.estimates import Estimate

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
MARKERS, GLYPHS = ("o", "s", "^", "D", "v", "P"), ("●■▲◆▼✚", "○□△◇▽✚")
"""Markers of curves, and how text shows them: filled, and hollow from the seventh curve on."""

WIDTH, HEIGHT = 340, 270  # the size of a panel, in CSS pixels where it is shown at its own size

LETTERS = 12  # the size of all letters [CSS pixels]

_INK, _GRID, _PAPER, _GREY = "#1b1b1b", "#e3e3e3", "#fffffe", "#767676"
_PAGE = {_INK: "currentColor", _GRID: "var(--grid, #e3e3e3)", _PAPER: "var(--paper, #fff)"}
"""What stands in the SVG in place of these colours."""

FONTS = '-apple-system, "Segoe UI", Roboto, "Noto Sans", "Liberation Sans", Arial, sans-serif'
"""The letters of figures and pages: those of the reader's own system."""

_MOST_MARKED = 25  # curves of more points tell every n-th of them
_MOST_LETTERS = 30  # names of places with more letters in all are turned, or they would overlap
_PER_INCH = 72  # the units of an SVG in an inch of the canvas

_STYLE: dict[Any, Any] = {
    "svg.hashsalt": "lodbench",  # the same plot has the same bytes
    "svg.fonttype": "none",  # letters stay letters
    "font.size": LETTERS,
    "axes.titlesize": LETTERS,
    "axes.labelsize": LETTERS,
    "xtick.labelsize": LETTERS,
    "ytick.labelsize": LETTERS,
    "legend.fontsize": LETTERS,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": _GRID,
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "legend.frameon": False,
    **dict.fromkeys(("text.color", "axes.edgecolor", "axes.labelcolor"), _INK),
    **dict.fromkeys(("xtick.color", "ytick.color", "axes.titlecolor"), _INK),
}


@dataclass(frozen=True)
class Curve:
    """One curve: points in order of x, with optional intervals and an optional line.

    low, high  ends of the interval at each x; empty = none
    line       x and y of the points of what was fitted or predicted; both empty = no line
    """

    label: str
    x: Sequence[float]
    y: Sequence[float]
    low: Sequence[float] = ()
    high: Sequence[float] = ()
    line: tuple[Sequence[float], Sequence[float]] = ((), ())

    @property
    def thinned(self) -> "Curve":
        """The curve with as few points as are told, evenly chosen."""
        step = max(-(-len(self.x) // _MOST_MARKED), 1)
        rows = (self.x, self.y, self.low, self.high)
        whole = len(self.line[1]) == len(self.x)
        line = (self.line[0][::step], self.line[1][::step]) if whole else self.line
        x, y, low, high = (row[::step] for row in rows)
        return Curve(self.label, x, y, low, high, line)


def estimated(
    label: str,
    x: Sequence[float],
    found: Sequence[Estimate],
    line: tuple[Sequence[float], Sequence[float]] = ((), ()),
    least: float = -np.inf,
) -> Curve:
    """Make a curve of estimates and their intervals, drawn at ``least`` where they are below it."""
    y, low, high = ([max(getattr(e, k), least) for e in found] for k in ("value", "low", "high"))
    return Curve(label, list(x), y, low, high, line)


SIDE = 0.21  # how far the two bars of a place are from it


@dataclass(frozen=True)
class Panel:
    """One pair of axes, and what is drawn in them.

    title    what is seen in it, in a few words
    axis     labels of the horizontal and the vertical axis
    scale    ``log`` or ``linear`` for the horizontal and for the vertical axis
    look     ``line``, ``points`` that nothing joins, or ``bars`` that stand on one another
    ticks    names of the places 0, 1, 2 … on the horizontal axis; empty = numbers
    sides    names of the two bars to the left and to the right of a place, at ∓ SIDE
    between  what is claimed, as a shaded band: its least and its greatest value
    """

    title: str
    axis: tuple[str, str]
    drawn: Sequence[Curve]
    scale: tuple[str, str] = ("log", "log")
    look: Literal["line", "points", "bars"] = "line"
    ticks: Sequence[str] = ()
    sides: Sequence[str] = ()
    between: tuple[float, float] | None = None


@dataclass(frozen=True)
class Mark:
    """A point of a panel as it is drawn.

    curve  number of its curve in the whole figure
    words  what it says: ``pruned: 3.2 at 1e+04``
    place  where it stands in the SVG, from its left and upper edges
    """

    curve: int
    words: str
    place: tuple[float, float]


@dataclass(frozen=True)
class Drawing:
    """A finished panel: SVG text, the text in its place, and where its points stand."""

    name: str
    panel: Panel
    alt: str
    svg: str
    marks: tuple[Mark, ...]

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of its curves."""
        return _labels([self.panel])


@dataclass(frozen=True)
class Plot:
    """A finished figure: its title is its message; ``key`` says as SVG which curve is which.

    The key is empty where there is one curve alone.
    """

    name: str
    title: str
    caption: str
    drawings: tuple[Drawing, ...]
    key: str = ""

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """Labels of the curves of all panels, in the order of their numbers."""
        return _labels([each.panel for each in self.drawings])

    @property
    def numbers(self) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """The points of the figure as heads and rows of a table."""
        heads = ("panel", "series", "x", "y", "from", "to", "line")
        return heads, [
            (each.panel.title, *row)
            for each in self.drawings
            for curve in each.panel.drawn
            for row in _rows(curve.thinned)
        ]


def _labels(panels: Sequence[Panel]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(curve.label for each in panels for curve in each.drawn))


def _rows(curve: Curve) -> Iterator[tuple[str, ...]]:
    without: list[Any] = [""] * len(curve.x)
    line = curve.line[1] if len(curve.line[1]) == len(curve.x) else without
    columns = curve.x, curve.y, curve.low or without, curve.high or without, line
    for row in zip(*columns, strict=True):
        yield (curve.label, *(v if isinstance(v, str) else f"{float(v):.5g}" for v in row))


def curves(
    name: str,
    title: str,
    caption: str,
    axis: tuple[str, str],
    drawn: Sequence[Curve],
    scale: tuple[str, str] = ("log", "log"),
) -> Plot:
    """Draw a figure of one panel of curves, with their intervals and fitted lines."""
    return figure(name, title, caption, [Panel("", axis, drawn, scale)])


def figure(name: str, title: str, caption: str, panels: Sequence[Panel]) -> Plot:
    """Draw a figure; curves of one label look alike in all of its panels."""
    labels = _labels(panels)
    with mpl.rc_context(_STYLE):
        drawings = tuple(
            _drawing(f"{name}-{k}", panel, labels) for k, panel in enumerate(panels) if panel.drawn
        )
        return Plot(name, title, caption, drawings, _key(f"{name}-key", labels))


def _drawing(name: str, panel: Panel, labels: Sequence[str]) -> Drawing:
    layout = ConstrainedLayoutEngine(w_pad=0.04, h_pad=0.04)
    canvas = Canvas(figsize=(WIDTH / _PER_INCH, HEIGHT / _PER_INCH), layout=layout)
    axes = canvas.subplots()
    draw = {"line": _lines, "points": _points, "bars": _bars}[panel.look]
    draw(axes, [(labels.index(each.label), each) for each in panel.drawn])
    axes.set(xscale=panel.scale[0], yscale=panel.scale[1], xlabel=panel.axis[0])
    # Above the axes: a label at the side would take the room of the curves.
    axes.set_title(panel.title, pad=22 if panel.title else None)
    axes.annotate(panel.axis[1], (0, 1), (0, 6), "axes fraction", "offset points")
    lowest = min(min(each.low or each.y, default=0.0) for each in panel.drawn)
    if panel.scale[1] == "linear" and lowest >= 0 and panel.between is None:
        axes.set_ylim(bottom=0.0)
    if panel.between is not None:
        axes.axhspan(*panel.between, color=_GREY, alpha=0.25, lw=0)
    if panel.ticks:
        wide = sum(map(len, panel.ticks)) > _MOST_LETTERS
        turned: dict[str, Any] = {"rotation": 40, "ha": "right"} if wide else {}
        axes.set_xticks(range(len(panel.ticks)), panel.ticks, **turned)
        axes.grid(axis="x", visible=False)
    else:
        _ticks(axes.xaxis, 5)
    _ticks(axes.yaxis, 6)
    words = (_in_words(each) for each in panel.drawn[:6])
    title = f"{panel.title}. " if panel.title else ""
    alt = " ".join((f"{title}Plot of {panel.axis[1]} against {panel.axis[0]}.", *words))
    svg = _svg(canvas, name)
    marks = tuple(
        mark
        for each in panel.drawn
        for mark in _marks(canvas, axes, labels.index(each.label), each.thinned, panel)
    )
    return Drawing(name, panel, alt.strip(), svg, marks)


def _lines(axes: Axes, drawn: Sequence[tuple[int, Curve]]) -> None:
    for number, each in drawn:
        style: dict[str, Any] = {"gid": f"curve-{number}", "zorder": 3 - 0.01 * number}
        look = _look(number) | {"markevery": max(len(each.x) * len(drawn) // 60, 1)}
        if each.low:
            band = {"color": look["color"], "alpha": 0.18, "lw": 0}
            axes.fill_between(each.x, each.low, each.high, **band, **style)
        if len(each.line[0]):
            axes.plot(*each.line, color=look["color"], lw=1.1, ls="--", **style)
        axes.plot(each.x, each.y, lw=1.4, markersize=5, **look, **style)


def _points(axes: Axes, drawn: Sequence[tuple[int, Curve]]) -> None:
    for number, each in drawn:
        style: dict[str, Any] = {"gid": f"curve-{number}", "zorder": 3 - 0.01 * number}
        if each.low:
            ends: dict[str, Any] = {"color": _look(number)["color"], "lw": 1.0, "alpha": 0.7}
            gap = [math.nan] * len(each.x)  # all intervals are one path, which is short as SVG
            rows = np.column_stack((each.low, each.high, gap)).ravel()
            axes.plot(np.repeat(each.x, 3), rows, **ends, **style)
        if len(each.line[0]):
            axes.plot(*each.line, color=_GREY, lw=1.1, ls="--", gid=f"curve-{number}")
        axes.plot(each.x, each.y, ls="none", markersize=5, **_look(number), **style)


def _bars(axes: Axes, drawn: Sequence[tuple[int, Curve]]) -> None:
    top = np.zeros(len(drawn[0][1].x))
    for number, each in drawn:
        colour, hatch = COLOURS[number % len(COLOURS)], "///" if number >= len(COLOURS) else None
        style: dict[str, Any] = {
            "color": colour,
            "hatch": hatch,
            "gid": f"curve-{number}",
            "edgecolor": _PAPER,
        }
        axes.bar(each.x, each.y, 0.8 if float(each.x[0]).is_integer() else 0.4, bottom=top, **style)
        top += np.array(each.y)


def _look(number: int) -> dict[str, Any]:
    kind, hollow = number % len(COLOURS), number >= len(COLOURS)
    fill = {"markerfacecolor": _PAPER} if hollow else {}
    return {"color": COLOURS[kind], "marker": MARKERS[kind], **fill}


def key_of(number: int) -> tuple[str, str]:
    """Return the colour of a curve, and its marker as a letter."""
    kind = number % len(COLOURS)
    return COLOURS[kind], GLYPHS[number >= len(COLOURS)][kind]


def _key(name: str, labels: Sequence[str]) -> str:
    if len(labels) < 2:
        return ""
    rows = -(-len(labels) // 2)
    canvas = Canvas(figsize=(WIDTH / _PER_INCH, (20 * rows + 8) / _PER_INCH))
    handles = [mpl.lines.Line2D([], [], lw=1.4, **_look(n)) for n in range(len(labels))]
    canvas.legend(handles, labels, ncols=2, loc="center left", mode="expand")
    return _svg(canvas, name)


def _ticks(axis: Axis, most: int) -> None:
    low, high = axis.get_view_interval()
    axis.set_minor_formatter(NullFormatter())
    if axis.get_scale() == "linear":
        axis.set_major_locator(MaxNLocator(most, steps=(1, 2, 2.5, 5, 10)))
    elif high < 30 * low:  # few decades: marks within them
        within = (1.0, 1.5, 2.0, 3.0, 5.0) if high < 4 * low else (1.0, 2.0, 5.0)
        axis.set_major_locator(LogLocator(subs=within if high < 12 * low else (1.0, 3.0)))
    else:
        axis.set_major_locator(LogLocator(numticks=most + 1))
    axis.set_major_formatter(lambda value, _: number_text(value))


def number_text(value: float) -> str:
    """Write a number of an axis: ``0.01``, ``500``, ``10⁴``, without small letters."""
    if value == 0 or 1e-3 <= abs(value) < 1e4:
        return f"{value:.4g}".replace("-", "−")
    power = math.floor(math.log10(abs(value)) + 1e-9)
    front = value / 10.0**power
    raised = str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"10{raised}" if abs(front - 1) < 1e-9 else f"{front:.3g}·10{raised}"


def _in_words(curve: Curve) -> str:
    if not len(curve.x):
        return f"{curve.label}."
    said = f"{curve.label}: from {curve.y[0]:.4g} at {curve.x[0]:.3g}"
    return f"{said} to {curve.y[-1]:.4g} at {curve.x[-1]:.3g}."


def _marks(canvas: Canvas, axes: Axes, number: int, curve: Curve, panel: Panel) -> Iterator[Mark]:
    """Yield the points of one curve that are drawn: those with finite places."""
    y = list(curve.y)
    if panel.look == "bars":  # in the middle of its part of the bar
        below = [0.0] * len(y)
        for other in panel.drawn[: [c.label for c in panel.drawn].index(curve.label)]:
            below = [a + b for a, b in zip(below, other.y, strict=True)]
        y = [a + b / 2 for a, b in zip(below, y, strict=True)]
    right, up = axes.transData.transform(np.column_stack((curve.x, y))).T / canvas.dpi
    places = np.column_stack((right, canvas.get_figheight() - up)) * _PER_INCH
    ends: Sequence[Any] = list(zip(curve.low, curve.high, strict=True)) or [None] * len(y)
    for place, at, value, both in zip(
        places.round(1).tolist(), curve.x, curve.y, ends, strict=True
    ):
        if np.isfinite(place).all():
            where = panel.ticks[round(at)] if panel.ticks else f"{at:.4g}"
            where += f", {panel.sides[at > round(at)]}" if panel.sides else ""
            interval = f" ({both[0]:.4g} to {both[1]:.4g})" if both else ""
            words = f"{curve.label}: {value:.4g}{interval} at {where}"
            yield Mark(number, words, (place[0], place[1]))


def _svg(canvas: Canvas, name: str) -> str:
    """Return a panel as an ``svg`` element that scales, with ids of its own on a page."""
    stream = io.StringIO()
    canvas.savefig(stream, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
    text = stream.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>\s*|<!--.*?-->\s*", "", text, flags=re.DOTALL)
    text = re.sub(r'^(<svg[^>]*?) width="([\d.]*)pt"', r'\1 width="\2"', text)
    text = re.sub(r'^(<svg[^>]*?) height="([\d.]*)pt"', r'\1 height="\2"', text)
    text = re.sub(r'<g id="curve-(\d+)">', r'<g data-curve="\1">', text)
    text = re.sub(r'<g id="[^"]*">', "<g>", text)  # what nothing refers to, and other white space
    text = re.sub(r"> <", "><", re.sub(r"\s+", " ", text)).replace("xlink:href", "href")
    text = re.sub(r'; stroke-linecap: square| xmlns:xlink="[^"]*"', "", text)
    while "<g></g>" in text:
        text = text.replace("<g></g>", "")
    text = re.sub(r" font-family: [^;]*;", "", text)
    within = re.compile(r"(\d\.\d\d)\d+")  # a hundredth of a pixel is enough
    text = re.sub(r"<[^>]*>", lambda tag: within.sub(r"\1", tag[0]), text)
    for colour, of_page in _PAGE.items():
        text = text.replace(colour, of_page)
    for number, old in enumerate(dict.fromkeys(re.findall(r'\bid="([^"]*)"', text))):
        text = re.sub(rf'(\bid="|href="#|url\(#){re.escape(old)}\b', rf"\g<1>{name}-{number}", text)
    return text.replace("<svg", f"<svg style='font-family: {FONTS}'", 1)


def alone(svg: str) -> str:
    """Return an SVG as a file of its own, which is black on white wherever it is shown."""
    return svg.replace("<svg style='", "<svg style='color: #1b1b1b; background: #fff; ", 1)
