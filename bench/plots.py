"""What does each point of a finished plot say, and where does it stand?

How is a plot made? SVG text, the numbers behind it and a text alternative; only this file draws.

The same drawing stands in every report: as a file, on the page, and in print. Colours are those of
Okabe & Ito, "Color Universal Design" (2008), and no two curves differ in colour alone.
"""

import io
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from jaxtyping import Float64
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure as Canvas
from matplotlib.ticker import MaxNLocator, NullFormatter

from bench.statistics.estimates import Estimate


@dataclass(frozen=True)
class Mark:
    """A point of a plot as it is drawn.

    curve  number of its curve; what is drawn below others has numbers of its own
    words  what it says: ``pruned: 3.2 at 1e+04``
    place  where it stands in the SVG, from its left and upper edges
    """

    curve: int
    words: str
    place: tuple[float, float]


def marks_at(
    places: Float64[np.ndarray, "n 2"],
    curve: int,
    label: str,
    x: Sequence[float],
    y: Sequence[float],
) -> Iterator[Mark]:
    """Yield the points of one curve that are drawn: those with finite places."""
    for place, at, value in zip(places.round(1).tolist(), x, y, strict=True):
        if np.isfinite(place).all():
            yield Mark(curve, f"{label}: {value:.4g} at {at:.4g}", (place[0], place[1]))


COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
MARKERS = ("o", "s", "^", "D", "v", "P")
_GREY = "#595959"
_MOST_MARKS = 13
"""The most marks along a horizontal axis: the labels of more would overlap."""

_APART = 1.04
"""The ratio by which points of two curves at one x are drawn apart, so that their bars are seen."""

_NARROWEST, _WIDE = 1.03, 2.0
"""The least ratio that an axis of ratios to a line shows, so that noise does not fill it.

The second is the ratio from which on the axis is logarithmic.
"""

_POINTS_PER_INCH = 72
"""The units of an SVG in an inch of the canvas."""

_STYLE: dict[Any, Any] = {
    "svg.hashsalt": "lodbench",  # the same plot has the same bytes
    "svg.fonttype": "path",  # and looks the same on every machine
    "font.size": 11,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#E3E3E3",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "legend.fontsize": 10,
}


@dataclass(frozen=True)
class Curve:
    """One curve: points in order of x, with an optional band and an optional line.

    low, high  edges of the band or ends of the error bar at each x; empty = none
    line       x and y of the points of what was fitted or predicted; both empty = no line
    """

    label: str
    x: Sequence[float]
    y: Sequence[float]
    low: Sequence[float] = ()
    high: Sequence[float] = ()
    line: tuple[Sequence[float], Sequence[float]] = ((), ())

    @property
    def residuals(self) -> tuple[list[float], list[float]]:
        """x, and y ÷ the line at x, where the line reaches; lines are straight in logarithms."""
        if not len(self.line[0]) or min(map(min, (*self.line, self.y))) <= 0:
            return [], []
        ends, x = np.log(np.array(self.line)), np.log(self.x)
        there = (x >= ends[0].min() - 1e-9) & (x <= ends[0].max() + 1e-9)
        over = np.array(self.y)[there] / np.exp(np.interp(x[there], *ends))
        return np.array(self.x)[there].tolist(), over.tolist()


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


@dataclass(frozen=True)
class Plot:
    """A finished plot: SVG text, and a text that says what it shows to those who do not see it.

    svg     the picture
    alt     the text in place of the picture
    axis    labels of the horizontal and the vertical axis
    drawn   the numbers that it shows
    marks   its points, where they stand in the picture
    """

    name: str
    title: str
    caption: str
    alt: str
    svg: str
    axis: tuple[str, str]
    drawn: tuple[Curve, ...]
    marks: tuple[Mark, ...]

    @property
    def numbers(self) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """The points of the plot as heads and rows of a table."""
        heads = ("series", *self.axis, "from", "to", "predicted")
        return heads, [row for each in self.drawn for row in _rows(each)]


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
    """Plot curves with their bands and fitted lines.

    Where there are lines, curves ÷ lines are plotted below. ``scale`` is ``log`` or ``linear`` for
    the horizontal and for the vertical axis; a linear vertical axis begins at 0.
    """
    with mpl.rc_context(_STYLE):
        fitted = any(each.residuals[0] for each in drawn)
        canvas = Canvas(figsize=(5.4, 5.2 if fitted else 4.2))
        axes, below = _panels(canvas, fitted)
        for number, each in enumerate(drawn):
            marks = _marks(number)
            if each.low:
                axes.fill_between(
                    each.x, each.low, each.high, color=marks["color"], alpha=0.2, lw=0
                )
            axes.plot(each.line[0], each.line[1], color=marks["color"], lw=1.3, ls="--")
            style = marks | {"lw": 0.9, "markersize": 4.5}
            axes.plot(each.x, each.y, label=each.label, **style)
        axes.set(xscale=scale[0], yscale=scale[1], ylabel=axis[1])
        if scale[1] == "linear":
            axes.set_ylim(bottom=0.0)
        below.set(xlabel=axis[0])
        if fitted:
            _over_lines(below, drawn)
        if scale[0] == "linear":
            _mark_values(axes, sorted({x for each in drawn for x in each.x}))
        within = scale[0] == "log" and _within_a_decade(below.xaxis)
        below.tick_params(which="minor", labelbottom=within)
        axes.tick_params(which="minor", labelleft=_within_a_decade(axes.yaxis))
        axes.legend(loc="best")
        return _finished(canvas, (name, title, caption), axis, drawn, "line")


def against_law(
    name: str,
    title: str,
    caption: str,
    axis: tuple[str, str],
    drawn: Sequence[Curve],
    mark: tuple[float, str] | None = None,
) -> Plot:
    """Plot counts on logarithmic axes with the prediction, and measured ÷ predicted below.

    The line of each curve is the prediction at its x, and its band is shown as error bars.
    ``mark`` is a value on the horizontal axis that matters, and its name.
    """
    with mpl.rc_context(_STYLE):
        canvas = Canvas(figsize=(5.4, 5.2))
        above, below = _panels(canvas, True)
        for number, each in enumerate(drawn):
            _counts(above, each, number)
            _residuals(below, each, number)
        above.set(xscale="log", yscale="log", ylabel=axis[1])
        if mark:
            above.axvline(mark[0], color=_GREY, lw=1.2, ls=":", label=mark[1])
        above.plot([], [], color=_GREY, lw=1.4, label="predicted, no free parameters")
        above.legend(loc="best")
        below.axhspan(0.98, 1.02, color="#D9D9D9", alpha=0.5, lw=0)
        below.axhline(1.0, color=_GREY, lw=1.2)
        below.set(xlabel=axis[0], ylabel="measured ÷\npredicted")
        reaches = (abs(np.array(c.residuals[1]) - 1) + _half_band(c) / c.line[1] for c in drawn)
        reach = max(0.03, min(1.15 * max(float(each.max()) for each in reaches), 1.05))
        below.set_ylim(1 - reach, 1 + reach)
        return _finished(canvas, (name, title, caption), axis, drawn, "prediction", _APART)


def _finished(
    canvas: Canvas,
    words: tuple[str, str, str],
    axis: tuple[str, str],
    drawn: Sequence[Curve],
    line: str,
    apart: float = 1.0,
) -> Plot:
    """Write the SVG and the text in its place, and find where all points are."""
    alt = " ".join((f"Plot of {axis[1]} against {axis[0]}.", *(_in_words(c, line) for c in drawn)))
    svg = _svg(canvas, words[0])
    above, *below = canvas.axes
    marks = [
        mark
        for number, each in enumerate(drawn)
        for mark in marks_at(
            _places(canvas, above, each.x, each.y), number, each.label, each.x, each.y
        )
    ]
    for number, each in enumerate(drawn) if below else ():
        x, over = each.residuals
        places = _places(canvas, below[0], np.array(x) * apart ** (number - 0.5), over)
        marks += marks_at(places, number + len(drawn), f"{each.label} ÷ {line}", x, over)
    return Plot(*words, alt, svg, axis, tuple(drawn), tuple(marks))


def _places(
    canvas: Canvas, axes: Axes, x: Sequence[float] | np.ndarray, y: Sequence[float]
) -> np.ndarray:
    """Return where points of axes stand in the SVG, from its left and upper edges, (n, 2)."""
    right, up = axes.transData.transform(np.column_stack((x, y))).T / canvas.dpi
    return np.column_stack((right, canvas.get_figheight() - up)) * _POINTS_PER_INCH


def _in_words(curve: Curve, line: str) -> str:
    said = f"{curve.label}: from {curve.y[0]:.4g} at {curve.x[0]:.3g}"
    said += f" to {curve.y[-1]:.4g} at {curve.x[-1]:.3g}"
    over = curve.residuals[1]
    far = max((abs(each - 1) for each in over), default=0.0)
    return f"{said}, never more than {100 * far:.2g} % from the {line}." if over else f"{said}."


def _mark_values(axes: Axes, x: list[float]) -> None:
    """Put marks at the values themselves, or at every n-th of them, where labels fit."""
    step = -(-len(x) // _MOST_MARKS)
    marks = x[step - 1 :: step]
    if min(np.diff(marks), default=0.0) > (x[-1] - x[0]) / (2 * _MOST_MARKS):
        axes.set_xticks(marks)


def _within_a_decade(axis: Axis) -> bool:
    """Label marks with plain numbers where an axis spans less than a decade; say if so."""
    low, high = axis.get_view_interval()
    if narrow := high < 10 * low:
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter("{x:g}")
    return bool(narrow)


def _panels(canvas: Canvas, two: bool) -> tuple[Axes, Axes]:
    """Make the axes for curves, and the lowest axes, which have the horizontal label."""
    if not two:
        axes = canvas.subplots()
        canvas.subplots_adjust(left=0.15, right=0.985, top=0.98, bottom=0.13)
        return axes, axes
    above, below = canvas.subplots(2, 1, sharex=True, height_ratios=(3, 1.25))
    canvas.subplots_adjust(left=0.17, right=0.985, top=0.985, bottom=0.1, hspace=0.06)
    return above, below


def _over_lines(axes: Axes, drawn: Sequence[Curve]) -> None:
    for number, each in enumerate(drawn):
        style = _marks(number) | {"linestyle": "none", "markersize": 4}
        axes.plot(*each.residuals, **style)
    axes.axhline(1.0, color=_GREY, lw=1.2)
    farthest = max(abs(np.log(v)) for each in drawn for v in each.residuals[1])
    reach = np.exp(max(np.log(_NARROWEST), 1.1 * farthest))
    scale = "log" if reach > _WIDE else "linear"
    axes.set(yscale=scale, ylim=(1 / reach, reach), ylabel="measured ÷\nline")
    axes.yaxis.set_minor_formatter(NullFormatter())
    if scale == "linear":
        axes.yaxis.set_major_locator(MaxNLocator(4, steps=(1, 2, 4, 5, 10)))


def _counts(axes: Axes, curve: Curve, number: int) -> None:
    axes.plot(*curve.line, color=_GREY, lw=1.4, zorder=1)
    style = _marks(number) | {"linestyle": "none", "markersize": 6, "capsize": 2}
    axes.errorbar(curve.x, curve.y, yerr=_half_band(curve), label=curve.label, **style)


def _residuals(axes: Axes, curve: Curve, number: int) -> None:
    style = _marks(number) | {"linestyle": "none", "markersize": 4.5, "capsize": 2, "lw": 1}
    x, over = curve.residuals
    apart = np.array(x) * _APART ** (number - 0.5)
    axes.errorbar(apart, over, yerr=_half_band(curve) / curve.line[1], **style)


def _half_band(curve: Curve) -> np.ndarray:
    return (np.array(curve.high) - curve.low) / 2


def _marks(number: int) -> dict[str, Any]:
    kind = number % len(COLOURS)
    fill = COLOURS[kind] if number % 2 == 0 else "white"
    return {"color": COLOURS[kind], "marker": MARKERS[kind], "markerfacecolor": fill}


def _svg(canvas: Canvas, name: str) -> str:
    """Return the plot as an ``svg`` element that scales, with ids of its own on a page."""
    stream = io.StringIO()
    canvas.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    text = stream.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>\s*", "", text, flags=re.DOTALL)
    text = re.sub(r'^(<svg[^>]*?) width="[^"]*"', r"\1", text)
    text = re.sub(r'^(<svg[^>]*?) height="[^"]*"', r"\1", text)
    return re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{name}-", text)
