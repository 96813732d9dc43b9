"""What the fidelity experiment shows: error against detail and against parts, and a table."""

from collections.abc import Callable, Mapping, Sequence

from bench.experiments.fidelity.claims import pieces
from bench.experiments.fidelity.equal_error import (
    EQUAL_ERROR,
    Reached,
    column,
    curve,
    equal_error,
    metrics_of,
)
from bench.experiments.fidelity.timing import (
    SPP,
    TIMED,
    UNPRUNED,
    megabytes,
    over_unpruned,
    seconds,
    timed,
)
from bench.plots.numbers import four_decimals
from bench.plots.plot import Curve, Plot, curves
from bench.records.points import Point, grouped, where
from bench.records.records import Record
from bench.runner.experiment import Table
from bench.statistics.estimates import Estimate, two_sided_median
from bench.statistics.excess_flip import ExcessFlip, one_sided_excess

FEWEST, ALIKE, MORE = "the fewest", "not told apart from the fewest", "more"
"""How the parts of a metric at equal error compare with those of all metrics."""

_ERROR = "excess FLIP"
_LEAST = 1e-5
"""The value at which an error of 0 is drawn: the axis is logarithmic."""


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw, for each view, excess FLIP against detail, parts, time and memory."""
    made = []
    for (view,), points in grouped(record.points, "view").items():
        made += [_plot(view, points, "detail"), _plot(view, points, "parts")]
        if timed(points):
            made += [_by_time(view, points), _by_memory(view, points)]
    return tuple(made)


def summary(record: Record) -> Table:
    """Return a table: τ and parts at equal error of every view and metric."""
    at = f"τ at excess FLIP {EQUAL_ERROR} (px)"
    heads = ("view", "metric", at, "parts there", "÷ blake's", "among all metrics")
    rows: list[tuple[str, ...]] = []
    for (view,), points in grouped(record.points, "view").items():
        found = equal_error(points)
        words = standing(found)
        for name, each in found.items():
            crossing = _crossing(each, found["blake"], curve(points, name))
            rows.append((view, name, *crossing, words.get(name, "")))
    return heads, rows


def _crossing(each: Reached, ours: Reached, row: Sequence[Point]) -> tuple[str, str, str]:
    if not each.found:
        below, above = excess(row[-1]).high < EQUAL_ERROR, excess(row[0]).low > EQUAL_ERROR
        end, words = (row[-1], ("over", "under")) if below else (row[0], ("under", "over"))
        if not (below or above):
            return "not reached in every draw", "", ""
        detail, parts = end.case["detail"], end.column("parts")[0]
        return f"{words[0]} {detail:g}, the last tried", f"{words[1]} {parts}", ""
    over = _within(each.parts_over(ours), "{:.2f}") if ours.found else ""
    return _within(each.detail, "{:.2f}"), _within(each.part_count, "{:.0f}"), over


def _within(found: Estimate, form: str) -> str:
    value, low, high = (form.format(v) for v in (found.value, found.low, found.high))
    return f"{value} ({low} to {high})"


def excess(point: Point) -> ExcessFlip:
    """Return the excess FLIP of a point with its one-sided bounds and its floor."""
    return one_sided_excess(column(point, "flip"), column(point, "flip_floor"))


def point_table(record: Record) -> Table:
    """Return the heads and rows of a table: every case."""
    heads = (
        *("view", "metric", "τ (px)", "pruned", "parts", "memory (MB)", "a frame's time (s)"),
        *("÷ unpruned", "excess FLIP", "at most (95 %)", "floor"),
        *("relMSE without noise", "relMSE", "its floor", "SSIM", "its floor"),
    )
    views = grouped(record.points, "view")
    return heads, [_row(point, views[(point.case["view"],)]) for point in record.points]


def _row(point: Point, view: Sequence[Point]) -> tuple[str, ...]:
    case = point.case
    place = case["view"], case["metric"], f"{case['detail']:g}", case["pruned"]
    held = str(point.column("parts")[0]), f"{megabytes(point):.0f}"
    if case["pruned"] == TIMED:
        over = over_unpruned(view, point)
        times = (
            _within(two_sided_median(seconds(point)), "{:.3f}"),
            _within(over, "{:.3f}") if over else "",
        )
        return (*place, *held, *times, *[""] * 8)
    found = excess(point)
    errors = [f"{column(point, f'relmse{k}').mean():.5f}" for k in ("_bias", "", "_floor")]
    likeness = [f"{column(point, f'ssim{k}').mean():.4f}" for k in ("", "_floor")]
    flip = [f"{v:.4f}" for v in (found.excess, found.high, found.floor)]
    return (*place, *held, "", "", *flip, *errors, *likeness)


def _plot(view: str, points: list[Point], against: str) -> Plot:
    rows = {metric: curve(points, metric) for metric in metrics_of(points)}
    drawn = [_curve(metric, [(_x(p, against), p) for p in row]) for metric, row in rows.items()]
    at = "detail threshold τ (px)" if against == "detail" else "parts displayed"
    caption = (
        f"Excess FLIP (67 pixels per degree) of the {view} view over the unpruned picture, with "
        f"its 95 % bounds, against {at}; the noise floor is {_floor(points):.4f}. "
        f"{_crossings(points)} {_fewest(points)} {_pieces(points)}"
    )
    return _drawn(view, points, against, (at, _ERROR), caption, drawn)


def _by_time(view: str, points: list[Point]) -> Plot:
    """Draw error against a frame's time, with the unpruned frame's time beside it."""

    def time(point: Point) -> float:
        return two_sided_median(seconds(point)).value

    told = "; ".join(
        f"τ = {p.case['detail']:g} px: {_within(two_sided_median(seconds(p)), '{:.3f}')} s"
        for p in timed(points)
    )
    caption = (
        f"Excess FLIP of the {view} view against a frame's time: prune, build and trace with {SPP} "
        f"samples a pixel, medians of {len(seconds(timed(points)[0]))} rounds in which all metrics "
        f"and details take turns. By blake: {told}. "
        + "".join(
            f"Unpruned: {_within(two_sided_median(seconds(p)), '{:.3f}')} s. "
            for p in timed(points, UNPRUNED)
        )
        + "The ground is whole in all of them, and most of their time is its own."
    )
    axis = "seconds a frame", _ERROR
    return _drawn(view, points, "time", axis, caption, _against_whole(points, time))


def _by_memory(view: str, points: list[Point]) -> Plot:
    """Draw error against the memory of a frame, with the unpruned frame's beside it."""
    least = min(megabytes(p) for p in _frames(points))
    caption = (
        f"Excess FLIP of the {view} view against the most memory that the process which renders it "
        f"is foretold to hold, with {SPP} samples a pixel. "
        + "".join(f"Unpruned: {megabytes(p):.0f} MB. " for p in timed(points, UNPRUNED))
        + f"Some {least:.0f} MB of it are the program, its picture and the ground, however few "
        "parts are displayed."
    )
    axis, drawn = ("peak memory (MB)", _ERROR), _against_whole(points, megabytes)
    return _drawn(view, points, "memory", axis, caption, drawn, "linear")


def _drawn(
    view: str,
    points: Sequence[Point],
    against: str,
    axis: tuple[str, str],
    caption: str,
    drawn: list[Curve],
    x_scale: str = "log",
) -> Plot:
    """Draw a plot of a view, with the noise floor in it."""
    x = [value for each in drawn for value in each.x]
    floor = Curve("noise floor", [min(x), max(x)], [_floor(points)] * 2)
    name = f"fidelity-{view.replace(' ', '-')}-{against}"
    title = f"Error against {against}, {view}"
    return curves(name, title, caption, axis, [*drawn, floor], (x_scale, "log"))


def _against_whole(points: Sequence[Point], x: Callable[[Point], float]) -> list[Curve]:
    """Draw each metric's error against the cost of its timed frames, and the unpruned cost."""
    drawn = []
    for metric in metrics_of(points):
        errors = {p.case["detail"]: p for p in curve(points, metric)}
        found = [(x(p), errors[p.case["detail"]]) for p in timed(points, metric)]
        drawn += [_curve(metric, found)] if found else []
    y = [_floor(points), *(value for each in drawn for value in each.y)]
    for whole in timed(points, UNPRUNED):
        drawn.append(Curve("unpruned", [x(whole)] * 2, [min(y), max(y)]))
    return drawn


def _curve(metric: str, found: Sequence[tuple[float, Point]]) -> Curve:
    """Make a curve of excess FLIP with its bounds at these places on the horizontal axis."""
    x, points = zip(*sorted(found, key=lambda each: each[0]), strict=True)
    errors = [excess(point) for point in points]
    y, low, high = (
        [max(getattr(each, k), _LEAST) for each in errors] for k in ("excess", "low", "high")
    )
    return Curve(metric, x, y, low, high)


def _floor(points: Sequence[Point]) -> float:
    return excess(next(p for p in points if p.case["pruned"] != TIMED)).floor


def _frames(points: Sequence[Point]) -> list[Point]:
    return where(points, pruned=TIMED)


def _x(point: Point, against: str) -> float:
    return float(point.case["detail"] if against == "detail" else point.column("parts")[0])


def standing(found: Mapping[str, Reached]) -> dict[str, str]:
    """Return FEWEST, ALIKE or MORE for every metric that reaches equal error in every draw."""
    there = {name: each for name, each in found.items() if each.found}
    if not there:
        return {}
    best = min(there.values(), key=lambda each: each.parts[0])
    words = {k: ALIKE if each.parts_over(best).low <= 1 else MORE for k, each in there.items()}
    return words | {best.metric: FEWEST}


def _fewest(points: Sequence[Point]) -> str:
    """Say in a sentence which metric of a view displays the fewest parts at equal error."""
    words = standing(equal_error(points))
    best, alike = ([k for k, word in words.items() if word == each] for each in (FEWEST, ALIKE))
    if not best:
        return "Which metric needs the fewest parts there is not decided: none comes up to it."
    others = f" (not told apart: {', '.join(alike)})" if alike else ""
    return f"The fewest parts there are those of {best[0]}{others}."


def _crossings(points: list[Point]) -> str:
    words = []
    for each in equal_error(points).values():
        at = f"τ = {each.details[0]:.2g}, {each.parts[0]:.0f} parts"
        words.append(f"{each.metric}: {at if each.found else 'not in this range'}")
    return f"It reaches {EQUAL_ERROR} at: " + "; ".join(words) + "."


def _pieces(points: list[Point]) -> str:
    words = [f"{p.case['pruned']} {four_decimals(excess(p).excess)}" for p in pieces(points)]
    return f"At 1 px by blake, pruned alone: {', '.join(words)}."
