"""What the fidelity experiment shows: error by distance, error against parts, and tables."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from bench.experiment import Table
from bench.experiments.fidelity.claims import (
    band_name,
    compared_at,
    coverage,
    judged_bands,
    same_place,
    swept,
    tone,
)
from bench.experiments.fidelity.equal_error import Reached
from bench.experiments.fidelity.scene import EDGES_M, EVERYTHING
from bench.experiments.fidelity.shipped.claims import errors, flip_columns
from bench.plots import Curve, Plot, curves
from bench.records.claims import four_decimals
from bench.records.records import Point, Record, grouped, where
from bench.statistics.estimates import Estimate
from bench.statistics.fits import one_sided_mean

FEWEST, ALIKE, MORE = "the fewest", "not told apart from the fewest", "more"
"""How the parts of a metric at equal error compare with those of all metrics."""

_LEAST = 1e-4
"""The value at which an error of 0 or below is drawn: the axis is logarithmic."""


def summary(record: Record) -> Table:
    """Return a table: error of every headline, then τ and parts of every metric at equal error."""
    heads = ("view", "what", "fields", "error, or τ at equal error (px)", "parts", "÷ blake's")
    rows: list[tuple[str, ...]] = []
    for point in where(record.points, what="headline"):
        found = errors(point)
        value = interval(one_sided_mean(found)) if len(found) > 1 else four_decimals(found[0])
        parts = f"{point.values('parts').mean():,.0f}"
        rows.append((point.case["view"], _pruned(point), str(len(found)), value, parts, ""))
    for (view,), points in grouped(where(record.points, what="sweep"), "view").items():
        found_by_metric = swept(points)
        words = standing(found_by_metric)
        for name, each in found_by_metric.items():
            rows.append((view, name, *_crossing(each, found_by_metric["blake"], words)))
    return heads, rows


def _pruned(point: Point) -> str:
    return f"pruned: {point.case['pruned']}"


def _crossing(each: Reached, ours: Reached, words: Mapping[str, str]) -> tuple[str, ...]:
    fields = str(len(each.details))
    if not each.found:
        return fields, "not reached in every field", "", ""
    over = f"{each.parts_over(ours):.2f}" if ours.found else ""
    return (
        fields,
        f"{each.detail:.2f}",
        f"{each.part_count:.0f}",
        f"{over}: {words[each.metric]}",
    )


def standing(found: Mapping[str, Reached]) -> dict[str, str]:
    """Return FEWEST, ALIKE or MORE for every metric that reaches equal error in every field."""
    there = {name: each for name, each in found.items() if each.found}
    if not there:
        return {}
    best = min(there.values(), key=lambda each: each.part_count.value)
    words = {k: ALIKE if each.parts_over(best).low <= 1 else MORE for k, each in there.items()}
    return words | {best.metric: FEWEST}


def point_table(record: Record) -> Table:
    """Return the heads and rows of a table: every band of every headline, then every sweep."""
    heads = (
        *("view", "metric", "τ (px)", "pruned", "distances", "FLIP without noise"),
        *("FLIP with most samples", "luminance ÷ reference's", "coverage ÷ reference's"),
    )
    rows = [row for point in record.points for row in _rows(point)]
    return heads, rows


def _rows(point: Point) -> list[tuple[str, ...]]:
    case = point.case
    place = case["view"], case["metric"], f"{case['detail']:g}", case["pruned"]
    found = errors(point)
    value = interval(one_sided_mean(found)) if len(found) > 1 else four_decimals(found[0])
    most = four_decimals(float(np.mean(flip_columns(point)[-1].values)) / 1e6)
    rows: list[tuple[str, ...]] = [(*place, "all", value, most, "", "")]
    if case["what"] == "headline" and len(found) > 1:
        for band in judged_bands(point):
            same = same_place(point, band)
            light = interval(tone(point, band)), interval(coverage(point, band))
            rows.append((*place, band_name(band), interval(same) if same else "", "", *light))
    return rows


def interval(found: Estimate) -> str:
    """Write an estimate with its interval, with four decimals."""
    value, low, high = (four_decimals(v) for v in (found.value, found.low, found.high))
    return f"{value} ({low} to {high})"


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw everything pruned by distance, and for each swept view error against τ and parts."""
    made = _by_distance(where(record.points, what="headline", pruned=EVERYTHING))
    for (view,), points in grouped(where(record.points, what="sweep"), "view").items():
        made.append(_sweep(view, points, "detail threshold τ (px)", lambda p: p.case["detail"]))
        made.append(_sweep(view, points, "parts displayed", lambda p: p.values("parts").mean()))
    return tuple(made)


def _by_distance(points: Sequence[Point]) -> list[Plot]:
    kinds: dict[str, Callable[[Point, int], Estimate | None]] = {
        "tone": tone,
        "coverage": coverage,
        "same place": same_place,
    }
    titles = "luminance ÷ the reference's", "coverage ÷ the reference's", "FLIP without noise"
    made = []
    for (name, estimate), axis in zip(kinds.items(), titles, strict=True):
        drawn = [_band_curve(p, estimate, name == "same place") for p in points if _judged(p)]
        if drawn:
            caption = (
                f"Everything pruned by blake at one pixel, {name} by distance, means over fields "
                f"with 95 % intervals: {'; '.join(map(_told, drawn))}."
            )
            axes, title = ("distance (m)", axis), f"By distance: {name}"
            scale = "log" if name == "same place" else "linear"
            plot_name = f"fidelity-{name.replace(' ', '-')}"
            made.append(curves(plot_name, title, caption, axes, drawn, ("log", scale)))
    return made


def _judged(point: Point) -> bool:
    return len(errors(point)) > 1 and len(judged_bands(point)) > 1


def _band_curve(
    point: Point, estimate: Callable[[Point, int], Estimate | None], error: bool
) -> Curve:
    found = {b: e for b in judged_bands(point) if (e := estimate(point, b)) is not None}
    least = _LEAST if error else -np.inf
    y, low, high = (
        [max(getattr(e, k), least) for e in found.values()] for k in ("value", "low", "high")
    )
    middle = [np.sqrt(max(EDGES_M[b], 5.0) * EDGES_M[b + 1]) for b in found]
    return Curve(point.case["view"], [float(x) for x in middle], y, low, high)


def _told(curve: Curve) -> str:
    return f"{curve.label}: {', '.join(f'{y:.3f}' for y in curve.y)}"


def _sweep(view: str, points: Sequence[Point], axis: str, x: Callable[[Point], float]) -> Plot:
    drawn = []
    for (metric,), row in grouped(points, "metric").items():
        found = sorted(((float(x(p)), one_sided_mean(errors(p))) for p in row), key=lambda e: e[0])
        y, low, high = (
            [max(getattr(e, k), _LEAST) for _, e in found] for k in ("value", "low", "high")
        )
        drawn.append(
            Curve(metric, [max(at, 1.0 if "parts" in axis else 0) for at, _ in found], y, low, high)
        )
    said = "; ".join(
        f"{each.metric}: {f'τ = {each.detail:.2f}' if each.found else 'not in every field'}"
        for each in swept(points).values()
    )
    caption = (
        f"Mean FLIP without noise of the {view} view, all but the ground pruned, "
        f"over fields with one-sided 95 % bounds. It comes up to {compared_at(view)} at {said}."
    )
    against = "parts" if "parts" in axis else "detail"
    name = f"fidelity-{view.replace(' ', '-')}-{against}"
    title = f"Error against {against}, {view}"
    return curves(name, title, caption, (axis, "error"), drawn, ("log", "log"))
