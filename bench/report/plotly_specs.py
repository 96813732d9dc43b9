"""Which plain data does Plotly.js need to draw, hover and zoom a plot?

No two series differ in colour alone: each has a marker of its own, filled or open.
"""

from collections.abc import Iterable, Iterator, Sequence
from math import ceil, floor, log10
from typing import Any

from bench.plots.plot import COLOURS, Curve, Plot, Series

_GREY = "#595959"
_SYMBOLS = ("circle", "square", "triangle-up", "diamond", "triangle-down", "cross")
_GRID = {"gridcolor": "#E3E3E3", "zeroline": False, "showline": True, "linecolor": _GREY}

_SMALL = 12
"""Font size of the vertical axes' names where two panels share the height."""

_NARROWEST = 1.03
"""Ratios are drawn on an axis that reaches at least so far to either side of 1."""

Spec = dict[str, Any]


def plotly_spec(plot: Plot) -> Spec | None:
    """Give traces and layout of a plot; None for one that holds no numbers."""
    if not plot.drawn:
        return None
    if plot.kind == "law":
        return _law(plot)
    data, layout = list(_traces(plot)), _layout(plot)
    below = [_over_line(k, each) for k, each in enumerate(plot.drawn) if isinstance(each, Curve)]
    below = [each for each in below if each["x"]]
    if below:
        data += below
        _make_room(layout, "measured ÷<br>line")
        layout["yaxis2"] |= {"type": "log", **_about_one([v for each in below for v in each["y"]])}
    return {"data": data, "layout": layout}


def numbers(plot: Plot) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Give the points of a plot as heads and rows of a table."""
    x, y = plot.axis
    heads = ("series", x, y, "from", "to", "predicted")
    return heads, [row for each in plot.drawn for row in _rows(each, plot.kind)]


def _rows(each: Series | Curve, kind: str) -> Iterator[tuple[str, ...]]:
    if isinstance(each, Curve):
        bands = zip(each.low, each.high, strict=True) if each.low else [("", "")] * len(each.x)
        fitted = each.line[1] if len(each.line[1]) == len(each.x) else [""] * len(each.x)
        for x, y, band, line in zip(each.x, each.y, bands, fitted, strict=True):
            yield (each.label, *map(_short, (x, y, *band, line)))
        return
    if kind == "ratio":
        for x, y in zip(each.x, each.ratio.tolist(), strict=True):
            yield (each.label, _short(x), _short(y), "", "", "")
        return
    for x, y, half, law in zip(
        each.x, each.measured, each.half_interval, each.predicted, strict=True
    ):
        yield (each.label, *map(_short, (x, y, y - half, y + half, law)))


def _short(value: Any) -> str:
    return value if isinstance(value, str) else f"{float(value):.5g}"


def _law(plot: Plot) -> Spec:
    """Draw counts above and measured ÷ predicted below, on one horizontal axis."""
    data: list[Spec] = []
    for number, each in enumerate(plot.drawn):
        assert isinstance(each, Series)
        line = {"color": _GREY, "width": 1.4}
        data.append(
            {
                **_points("predicted, nothing fitted", each.x, each.predicted),
                "mode": "lines",
                "line": line,
                "legendgroup": "law",
                "showlegend": number == 0,
            }
        )
    for number, each in enumerate(plot.drawn):
        assert isinstance(each, Series)
        mark = {"mode": "markers", "marker": _marker(number, 8), "legendgroup": str(number)}
        data.append(
            {
                **_points(each.label, each.x, each.measured),
                **mark,
                "error_y": _bars(each.half_interval),
            }
        )
        below = {**_points(each.label, each.x, each.ratio.tolist()), "yaxis": "y2"}
        below["error_y"] = _bars(each.ratio_half_interval.tolist())
        data.append({**below, **mark, "showlegend": False})
    layout = _layout(plot)
    _make_room(layout, "measured ÷<br>predicted")
    return {"data": data, "layout": layout}


def _make_room(layout: Spec, below: str) -> None:
    """Make room for a second panel below, with a line at 1."""
    layout["yaxis"] |= {"domain": [0.34, 1.0]}
    layout["yaxis2"] = {**_GRID, **_title(below), "domain": [0.0, 0.27]}
    for axis in ("yaxis", "yaxis2"):
        layout[axis]["title"] = {**layout[axis]["title"], "font": {"size": _SMALL}}
    layout["xaxis"] |= {"anchor": "y2"}
    layout["shapes"] = [*layout.get("shapes", []), _level(1.0)]


def _over_line(number: int, curve: Curve) -> Spec:
    """Divide a curve by its fitted line."""
    mark = {"mode": "markers", "marker": _marker(number, 6), "legendgroup": str(number)}
    return {**_points(curve.label, *curve.residuals), **mark, "yaxis": "y2", "showlegend": False}


def _traces(plot: Plot) -> Iterator[Spec]:
    for number, each in enumerate(plot.drawn):
        marker, colour = _marker(number, 7), COLOURS[number % len(COLOURS)]
        group = {"legendgroup": str(number)}
        if isinstance(each, Series):
            yield {
                **_points(each.label, each.x, each.ratio.tolist()),
                **group,
                "mode": "markers",
                "marker": marker,
            }
            continue
        if each.low:
            yield _edge(each.x, each.high, group)
            faint = {"fill": "tonexty", "fillcolor": f"{colour}33"}
            yield {**_edge(each.x, each.low, group), **faint}
        if len(each.line[0]):
            dash = {"color": colour, "width": 1.3, "dash": "dash"}
            yield {**_edge(*each.line, group), "line": dash}
        style = {"mode": "lines+markers", "marker": marker, "line": {"color": colour, "width": 1}}
        yield {**_points(each.label, each.x, each.y), **group, **style}


def _edge(x: Iterable[float], y: Iterable[float], group: Spec) -> Spec:
    quiet = {"mode": "lines", "line": {"width": 0}, "hoverinfo": "skip", "showlegend": False}
    return {"type": "scatter", "x": list(x), "y": list(y), **group, **quiet}


def _points(label: str, x: Iterable[float], y: Iterable[float]) -> Spec:
    shown = "%{fullData.name}<br>%{x:.4~g}: %{y:.4~g}<extra></extra>"
    return {
        "type": "scatter",
        "name": label,
        "hovertemplate": shown,
        "x": [float(v) for v in x],
        "y": [float(v) for v in y],
    }


def _bars(half: Sequence[float]) -> Spec:
    return {"type": "data", "array": [float(v) for v in half], "thickness": 1.2, "width": 3}


def _marker(number: int, size: int) -> Spec:
    colour = COLOURS[number % len(COLOURS)]
    symbol = _SYMBOLS[number % len(_SYMBOLS)] + ("" if number % 2 == 0 else "-open")
    return {"color": colour, "symbol": symbol, "size": size, "line": {"color": colour, "width": 2}}


def _layout(plot: Plot) -> Spec:
    x_scale, y_scale = plot.scale
    x = [v for each in plot.drawn for v in each.x]
    y = [v for each in plot.drawn for v in (each.y if isinstance(each, Curve) else each.measured)]
    layout: Spec = {
        "xaxis": {**_GRID, **_title(plot.axis[0]), **_scale(x_scale, x)},
        "yaxis": {**_GRID, **_title(plot.axis[1]), **_scale(y_scale, y)},
    }
    if plot.kind == "ratio":
        layout["yaxis"]["rangemode"] = "tozero"
        layout["shapes"] = [_level(1.0) | {"yref": "y"}]
    if plot.mark:
        at, name = plot.mark
        line = {"color": _GREY, "width": 1.2, "dash": "dot"}
        layout["shapes"] = [
            {"type": "line", "x0": at, "x1": at, "y0": 0, "y1": 1, "yref": "paper", "line": line}
        ]
        layout["annotations"] = [_note(at, name, x_scale)]
    return layout


def _scale(scale: str, values: Sequence[float]) -> Spec:
    """Choose an axis and its marks.

    A logarithmic axis of more than a decade and a half names powers of ten alone, a shorter one 1,
    2 and 5 as well. Values that are all the same stand in the middle.
    """
    chosen: Spec = {"type": scale, "exponentformat": "power", "automargin": True}
    low, high = min(values), max(values)
    if scale != "log" or low <= 0:
        return chosen
    if high > 30 * low:
        return chosen | {"dtick": 1, "minor": {"ticks": "outside", "ticklen": 3, "dtick": "D1"}}
    if high > 3 * low:
        return chosen | _named(low, high)
    if high < _NARROWEST * low:
        chosen |= {"range": [log10(low / 1.1), log10(high * 1.1)]}
    return chosen | {"exponentformat": "none"}


def _about_one(values: Sequence[float]) -> Spec:
    """Give a logarithmic range about 1 that holds the values, and that noise does not fill."""
    reach = max(log10(_NARROWEST), 1.1 * max(abs(log10(v)) for v in values))
    return {"range": [-reach, reach]}


def _named(low: float, high: float) -> Spec:
    """Mark every digit of the powers of ten about a range, with names at 1, 2 and 5."""
    powers = range(floor(log10(low)) - 1, ceil(log10(high)) + 1)
    marks = [(digit, power) for power in powers for digit in range(1, 10)]
    names = [_plain(*mark) if mark[0] in (1, 2, 5) else "" for mark in marks]
    values = [float(f"{digit}e{power}") for digit, power in marks]
    return {"tickmode": "array", "tickvals": values, "ticktext": names}


def _plain(digit: int, power: int) -> str:
    """Write a digit times a power of ten, in full where that is short."""
    if -4 < power < 5:
        return f"{float(f'{digit}e{power}'):g}"
    return f"{digit}×10<sup>{str(power).replace('-', '−')}</sup>"


def _title(text: str) -> Spec:
    return {"title": {"text": text}}


def _level(y: float) -> Spec:
    line = {"color": _GREY, "width": 1.2}
    ends = {"x0": 0, "x1": 1, "xref": "paper", "y0": y, "y1": y, "yref": "y2"}
    return {"type": "line", **ends, "line": line}


def _note(x: float, name: str, scale: str) -> Spec:
    at = log10(x) if scale == "log" else x
    place = {"x": at, "y": 0, "yref": "y domain", "xanchor": "left", "yanchor": "bottom"}
    return {"text": name, "showarrow": False, **place}
