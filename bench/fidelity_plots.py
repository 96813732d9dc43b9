"""What the fidelity experiment shows: error against detail and against parts, and a table."""

from collections.abc import Sequence

from bench.excess_flip import ExcessFlip, over_noise
from bench.experiments import Table
from bench.fidelity_claims import by_view, pieces
from bench.fidelity_equal_error import (
    EQUAL_ERROR,
    Reached,
    column,
    curve,
    equal_error,
    metrics_of,
)
from bench.fidelity_times import SPP, TIMED, over_unpruned, seconds, timed
from bench.figures import Curve, Figure, curves
from bench.records import Point, Record
from bench.statistics import Estimate, median

_LEAST = 1e-5
"""Errors of nothing are drawn here, for the axis is logarithmic."""


def figures(record: Record) -> tuple[Figure, ...]:
    """Of each view: excess FLIP against detail, parts and time."""
    made = []
    for view, points in by_view(record.points).items():
        made += [_figure(view, points, "detail"), _figure(view, points, "parts")]
        made += [_by_time(view, points)] if timed(points) else []
    return tuple(made)


def summary(record: Record) -> Table:
    """Heads and rows: of every view and metric, τ and parts at equal error."""
    heads = ("view", "metric", f"τ at excess FLIP {EQUAL_ERROR} (px)", "parts there", "÷ blake's")
    rows: list[tuple[str, ...]] = []
    for view, points in by_view(record.points).items():
        found = equal_error(points)
        for each in found.values():
            ends = curve(points, each.metric)
            rows.append((view, each.metric, *_crossing(each, found["blake"], ends)))
    return heads, rows


def _crossing(each: Reached, ours: Reached, row: Sequence[Point]) -> tuple[str, str, str]:
    if not each.found:
        below, above = excess(row[-1]).high < EQUAL_ERROR, excess(row[0]).low > EQUAL_ERROR
        end, words = (row[-1], ("over", "under")) if below else (row[0], ("under", "over"))
        if not (below or above):
            return "not reached in every draw", "", ""
        detail, parts = end.case["detail"], end.samples["parts"][0]
        return f"{words[0]} {detail:g}, the last tried", f"{words[1]} {parts}", ""
    over = _within(each.parts_over(ours), "{:.2f}") if ours.found else ""
    return _within(each.detail, "{:.2f}"), _within(each.part_count, "{:.0f}"), over


def _within(found: Estimate, form: str) -> str:
    value, low, high = (form.format(v) for v in (found.value, found.low, found.high))
    return f"{value} ({low} to {high})"


def excess(point: Point) -> ExcessFlip:
    """Excess FLIP of a point with its bounds and floor."""
    return over_noise(column(point, "flip"), column(point, "flip_floor"))


def table(record: Record) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Heads and rows: every case."""
    heads = (
        *("view", "metric", "τ (px)", "pruned", "parts", "memory (MB)", "a frame's time (s)"),
        *("÷ unpruned", "excess FLIP", "at most (95 %)", "floor"),
        *("relMSE without noise", "relMSE", "its floor", "SSIM", "its floor"),
    )
    views = by_view(record.points)
    return heads, [_row(point, views[point.case["view"]]) for point in record.points]


def _row(point: Point, view: Sequence[Point]) -> tuple[str, ...]:
    case, samples = point.case, point.samples
    place = case["view"], case["metric"], f"{case['detail']:g}", case["pruned"]
    held = str(samples["parts"][0]), f"{samples['foretold_bytes'][0] / 1e6:.0f}"
    if case["pruned"] == TIMED:
        over = over_unpruned(view, point)
        times = _within(median(seconds(point)), "{:.3f}"), _within(over, "{:.3f}") if over else ""
        return (*place, *held, *times, *[""] * 8)
    found = excess(point)
    errors = [f"{column(point, f'relmse{k}').mean():.5f}" for k in ("_bias", "", "_floor")]
    likeness = [f"{column(point, f'ssim{k}').mean():.4f}" for k in ("", "_floor")]
    flip = [f"{v:.4f}" for v in (found.excess, found.high, found.floor)]
    return (*place, *held, "", "", *flip, *errors, *likeness)


def _figure(view: str, points: list[Point], against: str) -> Figure:
    drawn, all_x = [], set()
    for metric in metrics_of(points):
        row = sorted(curve(points, metric), key=lambda p: _x(p, against))
        x = [_x(point, against) for point in row]
        found = [excess(point) for point in row]
        y, low, high = (
            [max(getattr(each, k), _LEAST) for each in found] for k in ("excess", "low", "high")
        )
        drawn.append(Curve(metric, x, y, low, high))
        all_x |= {min(x), max(x)}
    ends = [min(all_x), max(all_x)]
    floor = excess(points[0]).floor
    drawn.append(Curve("noise floor", ends, [floor, floor]))
    axis = ("detail threshold τ (px)" if against == "detail" else "parts displayed", "excess FLIP")
    caption = (
        f"Excess FLIP (67 pixels per degree) of the {view} view over the unpruned picture, with "
        f"its 95 % bounds, against {axis[0]}; the noise floor is {floor:.4f}. {_crossings(points)} "
        f"{_pieces(points)}"
    )
    name = f"fidelity-{view.replace(' ', '-')}-{against}"
    title = f"Error against {against}, {view}"
    return curves(name, title, caption, f"Log-log plot. {caption}", axis, drawn)


def _x(point: Point, against: str) -> float:
    return float(point.case["detail"] if against == "detail" else point.samples["parts"][0])


def _by_time(view: str, points: list[Point]) -> Figure:
    """Error against a frame's time, by blake; the unpruned frame's time beside it."""
    errors = {p.case["detail"]: excess(p) for p in curve(points, "blake")}
    row = [p for p in timed(points) if p.case["detail"] in errors]
    x = [median(seconds(p)).value for p in row]
    found = [errors[p.case["detail"]] for p in row]
    y, low, high = (
        [max(getattr(each, k), _LEAST) for each in found] for k in ("excess", "low", "high")
    )
    whole = timed(points, "full")
    told = "; ".join(
        f"τ = {p.case['detail']:g} px: {_within(median(seconds(p)), '{:.3f}')} s" for p in row
    )
    unpruned = f"Unpruned: {_within(median(seconds(whole[0])), '{:.3f}')} s. " if whole else ""
    caption = (
        f"Excess FLIP of the {view} view by blake against a frame's time: prune, build and trace "
        f"with {SPP} samples a pixel, medians of {len(seconds(row[0]))} rounds in which all "
        f"details take turns. {told}. {unpruned}The ground is whole in all of them, and most of "
        "their time is its own."
    )
    name, axis = f"fidelity-{view.replace(' ', '-')}-time", ("seconds a frame", "excess FLIP")
    order = sorted(range(len(x)), key=x.__getitem__)
    x, y, low, high = ([each[k] for k in order] for each in (x, y, low, high))
    drawn = Curve("blake", x, y, low, high)
    alt = f"Log-log plot. {caption}"
    return curves(name, f"Error against time, {view}", caption, alt, axis, [drawn])


def _crossings(points: list[Point]) -> str:
    words = []
    for each in equal_error(points).values():
        at = f"τ = {each.details[0]:.2g}, {each.parts[0]:.0f} parts"
        words.append(f"{each.metric}: {at if each.found else 'not in this range'}")
    return f"It reaches {EQUAL_ERROR} at: " + "; ".join(words) + "."


def _pieces(points: list[Point]) -> str:
    words = [f"{p.case['pruned']} {excess(p).excess:.4f}" for p in pieces(points)]
    return f"At 1 px by blake, pruned alone: {', '.join(words)}."
