"""How is a plot made? SVG text, the numbers behind it and a text alternative; only this file draws.

Colours are those of Okabe & Ito, "Color Universal Design" (2008), and no two series differ in
colour alone. Error bars are two-sided 95 % intervals of the mean over fields.
"""

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, Union

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure as Canvas
from matplotlib.ticker import NullFormatter

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
MARKERS = ("o", "s", "^", "D", "v", "P")
_GREY = "#595959"
_MOST_MARKS = 13
"""The most marks along a horizontal axis: the labels of more would overlap."""

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
class Plot:
    """A finished plot: SVG text, and a text that says what it shows to those who do not see it.

    svg          the picture
    alt          the text in place of the picture
    drawn        the numbers that it shows; none for a plot that is only a picture
    kind         ``law``: counts with their prediction and the ratio of both; ``ratio``; ``curves``
    axis, scale  labels of the horizontal and the vertical axis; ``log`` or ``linear`` for each
    mark         a value on the horizontal axis that matters, and its name
    """

    name: str
    title: str
    caption: str
    alt: str
    svg: str
    drawn: tuple[Union["Series", "Curve"], ...] = ()
    kind: Literal["law", "ratio", "curves"] = "curves"
    axis: tuple[str, str] = ("", "")
    scale: tuple[str, str] = ("log", "log")
    mark: tuple[float, str] | None = None


@dataclass(frozen=True)
class Series:
    """One line of a plot, points in order of x.

    ``half_interval`` is half the two-sided 95 % interval of each mean.
    """

    label: str
    x: Sequence[float]
    predicted: Sequence[float]
    measured: Sequence[float]
    half_interval: Sequence[float]

    @property
    def ratio(self) -> np.ndarray:
        """The counts measured ÷ predicted, (n,)."""
        return np.array(self.measured) / np.array(self.predicted)

    @property
    def ratio_half_interval(self) -> np.ndarray:
        """Half the two-sided 95 % interval of the ratio, (n,)."""
        return np.array(self.half_interval) / np.array(self.predicted)


def against_law(
    name: str,
    title: str,
    caption: str,
    axis: tuple[str, str],
    series: Sequence[Series],
    mark: tuple[float, str] | None = None,
) -> Plot:
    """Plot counts on logarithmic axes with the prediction, and measured ÷ predicted below.

    ``mark`` is a value on the horizontal axis that matters, and its name.
    """
    with mpl.rc_context(_STYLE):
        canvas = Canvas(figsize=(5.4, 5.2))
        above, below = canvas.subplots(2, 1, sharex=True, height_ratios=(3, 1.25))
        canvas.subplots_adjust(left=0.17, right=0.985, top=0.985, bottom=0.1, hspace=0.06)
        for number, each in enumerate(series):
            _counts(above, each, number)
            _residuals(below, each, number)
        above.set(xscale="log", yscale="log", ylabel=axis[1])
        if mark:
            above.axvline(mark[0], color=_GREY, lw=1.2, ls=":", label=mark[1])
        above.plot([], [], color=_GREY, lw=1.4, label="predicted, nothing fitted")
        above.legend(loc="best")
        below.axhspan(0.98, 1.02, color="#D9D9D9", alpha=0.5, lw=0)
        below.axhline(1.0, color=_GREY, lw=1.2)
        below.set(xlabel=axis[0], ylabel="measured ÷\npredicted")
        _limit_residuals(below, series)
        words, scale = _law_in_words(axis, series), ("log", "log")
        picture = _svg(canvas, name)
        return Plot(name, title, caption, words, picture, tuple(series), "law", axis, scale, mark)


def examined_over_displayed(
    name: str, title: str, caption: str, axis: tuple[str, str], series: Sequence[Series]
) -> Plot:
    """Plot ratios against a size on a logarithmic axis.

    ``predicted`` of each series holds what the measured numbers are divided by.
    """
    with mpl.rc_context(_STYLE):
        canvas = Canvas(figsize=(5.4, 3.9))
        axes = canvas.subplots()
        canvas.subplots_adjust(left=0.12, right=0.985, top=0.98, bottom=0.14)
        for number, each in enumerate(series):
            style = _marks(number) | {"linestyle": "none", "markersize": 5}
            axes.plot(each.x, each.ratio, label=each.label, **style)
        axes.axhline(1.0, color=_GREY, lw=1.2)
        axes.set(xscale="log", xlabel=axis[0], ylabel=axis[1])
        axes.set_ylim(0, 1.4 * max(float(s.ratio.max()) for s in series))
        axes.legend(loc="upper right", ncols=2)
        words = [
            f"{s.label}: {s.ratio.max():.3g} at most, {s.ratio[-1]:.3g} at the largest."
            for s in series
        ]
        alt = f"Plot of {axis[1]} against {axis[0]}. " + " ".join(words)
        picture, scale = _svg(canvas, name), ("log", "linear")
        return Plot(name, title, caption, alt, picture, tuple(series), "ratio", axis, scale)


@dataclass(frozen=True)
class Curve:
    """One curve: points in order of x, with an optional band and an optional fitted line.

    low, high  edges of the band at each x; empty = no band
    line       x and y of the points of what was fitted; both empty = no line
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
        if len(self.line[0]) < 2 or min(map(min, (*self.line, self.y))) <= 0:
            return [], []
        ends, x = np.log(np.array(self.line)), np.log(self.x)
        there = (x >= ends[0].min() - 1e-9) & (x <= ends[0].max() + 1e-9)
        over = np.array(self.y)[there] / np.exp(np.interp(x[there], *ends))
        return np.array(self.x)[there].tolist(), over.tolist()


def curves(
    name: str,
    title: str,
    caption: str,
    alt: str,
    axis: tuple[str, str],
    drawn: Sequence[Curve],
    x_scale: str = "log",
) -> Plot:
    """Plot curves with their bands and fitted lines, the vertical axis logarithmic.

    Where there are lines, curves ÷ lines are plotted below. ``x_scale`` is ``log`` or ``linear``.
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
        axes.set(xscale=x_scale, yscale="log", ylabel=axis[1])
        below.set(xlabel=axis[0])
        if fitted:
            _over_lines(below, drawn)
        if x_scale == "linear":
            _mark_values(axes, sorted({x for each in drawn for x in each.x}))
        within = x_scale == "log" and _within_a_decade(below.xaxis)
        below.tick_params(which="minor", labelbottom=within)
        axes.tick_params(which="minor", labelleft=_within_a_decade(axes.yaxis))
        axes.legend(loc="best")
        picture, scale = _svg(canvas, name), (x_scale, "log")
        return Plot(name, title, caption, alt, picture, tuple(drawn), "curves", axis, scale)


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


def _panels(canvas: Canvas, fitted: bool) -> tuple[Axes, Axes]:
    """Make the axes for curves, and the lowest axes, which have the horizontal label."""
    if not fitted:
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
    axes.set(yscale="log", ylabel="measured ÷\nline")
    axes.yaxis.set_minor_formatter(NullFormatter())


def _counts(axes: Axes, series: Series, number: int) -> None:
    axes.plot(series.x, series.predicted, color=_GREY, lw=1.4, zorder=1)
    style = _marks(number) | {"linestyle": "none", "markersize": 6, "capsize": 2}
    axes.errorbar(series.x, series.measured, yerr=series.half_interval, label=series.label, **style)


def _residuals(axes: Axes, series: Series, number: int) -> None:
    style = _marks(number) | {"linestyle": "none", "markersize": 4.5, "capsize": 2, "lw": 1}
    # Points of different series at one x stand a little apart.
    x = np.array(series.x) * 1.04 ** (number - 0.5)
    axes.errorbar(x, series.ratio, yerr=series.ratio_half_interval, **style)


def _limit_residuals(axes: Axes, series: Sequence[Series]) -> None:
    far = max(float(np.max(np.abs(s.ratio - 1) + s.ratio_half_interval)) for s in series)
    reach = max(0.03, min(1.15 * far, 1.05))
    axes.set_ylim(1 - reach, 1 + reach)


def _marks(number: int) -> dict[str, Any]:
    kind = number % len(COLOURS)
    fill = COLOURS[kind] if number % 2 == 0 else "white"
    return {"color": COLOURS[kind], "marker": MARKERS[kind], "markerfacecolor": fill}


def _law_in_words(axis: tuple[str, str], series: Sequence[Series]) -> str:
    words = [f"Log-log plot of {axis[1]} against {axis[0]}, with measured ÷ predicted below."]
    for each in series:
        worst = np.abs(each.ratio - 1).max()
        words.append(
            f"{each.label}: from {each.measured[0]:.4g} at {each.x[0]:.3g} to "
            f"{each.measured[-1]:.4g} at {each.x[-1]:.3g}, never more than {100 * worst:.2g} % "
            f"from the prediction."
        )
    return " ".join(words)


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
