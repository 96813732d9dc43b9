"""What is shown of presets as shipped: a row for each, every band, and error against triangles."""

import math
from collections.abc import Sequence

import numpy as np

from bench.experiment import Table
from bench.experiments.fidelity.shipped.claims import (
    GROUND,
    MOST_ERROR,
    NOTHING,
    error,
    flip_columns,
    judged_bands,
    light_ratios,
)
from bench.experiments.fidelity.shipped.pictures import band_edges
from bench.experiments.fidelity.shipped.places import places
from bench.plots import Curve, Plot, curves
from bench.records.claims import four_decimals
from bench.records.records import Point, Record, grouped, where
from bench.statistics.estimates import Estimate, two_sided_mean

EQUAL_TRIANGLES = 250_000
"""The number of triangles at which errors of the ground alone are compared between versions."""

_LEAST = 1e-4
"""The value at which an error of 0 or below is drawn: the axis is logarithmic."""


def summary(record: Record) -> Table:
    """Return a table: error, light, bands and cost of every preset, in every way it was pruned."""
    heads = (
        *("preset", "pruned", "τ (px)", "reference's τ (px)", "places"),
        *("FLIP with most samples", "error", "at most (95 %)", "same pictures' error"),
        *("land's luminance ÷ reference's", "bands within 2 %", "farthest off"),
        *("sticks", "triangles"),
    )
    control = {p.case["preset"]: error(p).value for p in where(record.points, pruned=NOTHING)}
    tested = [p for p in record.points if p.case["pruned"] != NOTHING]
    return heads, [_summed_up(point, control[point.case["preset"]]) for point in tested]


def _summed_up(point: Point, control: float) -> tuple[str, ...]:
    case, found, bands = point.case, error(point), judged_bands(point)
    most = flip_columns(point)[-1].values
    worst = max(bands, key=lambda each: abs(each.light.mean() - 1))
    return (
        *(case["preset"], case["pruned"], f"{point.values('detail_ppm')[0] / 1e6:g}"),
        *(_range(point.values("reference_ppm") / 1e6), str(len(most))),
        *(f"{v:.4f}" for v in (np.mean(most) / 1e6, found.value, found.high, control)),
        _interval(two_sided_mean(light_ratios(point))),
        f"{sum(not each.off for each in bands)} of {len(bands)}",
        f"{worst.light.mean():.3f} ({_distances(point, worst.number)})",
        *(f"{point.values(name).mean():,.0f}" for name in ("sticks", "triangles")),
    )


def point_table(record: Record) -> Table:
    """Return the heads and rows of a table: every judged band of every preset."""
    heads = (
        *("preset", "pruned", "τ (px)", "distances", "places", "share of the land"),
        *("luminance ÷ reference's", "95 % interval", "coverage ÷ reference's"),
    )
    points = [p for p in record.points if p.case["pruned"] != NOTHING]
    return heads, [row for point in points for row in _band_rows(point)]


def _band_rows(point: Point) -> list[tuple[str, ...]]:
    case, detail = point.case, f"{point.values('detail_ppm')[0] / 1e6:g}"
    rows: list[tuple[str, ...]] = []
    for band in judged_bands(point):
        found = two_sided_mean(band.light) if len(band.light) > 1 else None
        rows.append(
            (
                *(case["preset"], case["pruned"], detail, _distances(point, band.number)),
                *(str(len(band.light)), f"{100 * band.share:.1f} %"),
                f"{band.light.mean():.4f}",
                f"{found.low:.4f}-{found.high:.4f}" if found else "",
                f"{band.coverage.mean():.4f}",
            )
        )
    return rows


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw the ground's error against its triangles, of every preset whose ground stood alone."""
    alone = grouped(where(record.points, pruned=GROUND), "preset")
    if not alone:
        return ()
    drawn, words = [], []
    for (preset,), points in alone.items():
        row = sorted(points, key=_triangles)
        found = [error(point) for point in row]
        y, low, high = (
            [max(getattr(e, k), _LEAST) for e in found] for k in ("value", "low", "high")
        )
        drawn.append(Curve(preset, [_triangles(p) for p in row], y, low, high))
        at = error_at(row, EQUAL_TRIANGLES)
        words.append(f"{preset} {'not in this range' if math.isnan(at) else f'{at:.4f}'}")
    x = [value for each in drawn for value in each.x]
    drawn.append(Curve("nobody tells", [min(x), max(x)], [MOST_ERROR] * 2))
    caption = (
        "Error of pictures whose ground alone is pruned, at half, once and twice the shipped τ, "
        "against the triangles in them: mean FLIP without noise, mean over places with one-sided "
        f"95 % bounds. At {EQUAL_TRIANGLES:,} triangles: {', '.join(words)}."
    )
    axis = "triangles in the picture", "error (mean FLIP without noise)"
    title = "What the ground's triangles buy"
    return (curves("fidelity-shipped-ground", title, caption, axis, drawn),)


def error_at(points: Sequence[Point], triangles: int) -> float:
    """Read the error at a number of triangles, along straight lines of logarithms; or NaN.

    ``points`` are of one preset, from the fewest triangles to the most.
    """
    x, y = (np.log([_triangles(p) for p in points]), [error(p).value for p in points])
    within = x[0] <= math.log(triangles) <= x[-1]
    if not within:
        return math.nan
    return float(np.exp(np.interp(math.log(triangles), x, np.log(np.maximum(y, _LEAST)))))


def _triangles(point: Point) -> float:
    return float(point.values("triangles").mean())


def _distances(point: Point, band: int) -> str:
    """Write from where to where a band reaches."""
    edges = band_edges(places(point.case["preset"], 1, "1x1", 0)[0].load())
    if band == len(edges) - 2:
        return f"from {edges[band]:.3g} m"
    return f"{edges[band]:.3g} to {edges[band + 1]:.3g} m"


def _range(values: np.ndarray) -> str:
    low, high = values.min(), values.max()
    return f"{low:.3g}" if low == high else f"{low:.3g} to {high:.3g}"


def _interval(found: Estimate) -> str:
    value, low, high = (four_decimals(v) for v in (found.value, found.low, found.high))
    return f"{value} ({low} to {high})"
