"""What the fidelity experiment shows: error against detail and against parts, and a table."""

import math

import numpy as np

from bench.excess_flip import ExcessFlip, over_noise
from bench.fidelity_claims import EQUAL_ERROR, by_view, column, curve, pieces, reached
from bench.fidelity_scene import METRICS_TRIED
from bench.figures import Curve, Figure, curves
from bench.records import Point, Record

_LEAST = 1e-5
"""Errors of nothing are drawn here, for the axis is logarithmic."""


def figures(record: Record) -> tuple[Figure, ...]:
    """Of each view: excess FLIP against detail and against parts."""
    made = []
    for view, points in by_view(record.points).items():
        made += [_figure(record, view, points, "detail"), _figure(record, view, points, "parts")]
    return tuple(made)


def excess(point: Point) -> ExcessFlip:
    """Excess FLIP of a point with its bounds and floor."""
    return over_noise(column(point, "flip"), column(point, "flip_floor"))


def table(record: Record) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Heads and rows: every case."""
    heads = (
        *("view", "metric", "τ (px)", "pruned", "parts", "sticks", "memory (MB)", "prune (ms)"),
        *("build (ms)", "trace (ms)", "excess FLIP", "at most (95 %)", "floor"),
        *("relMSE without noise", "relMSE", "its floor", "SSIM", "its floor"),
    )
    return heads, [_row(point) for point in record.points]


def _row(point: Point) -> tuple[str, ...]:
    case, samples, found = point.case, point.samples, excess(point)
    times = [f"{np.median(samples[f'{k}_us']) / 1000:.1f}" for k in ("prune", "build", "trace")]
    errors = [f"{column(point, f'relmse{k}').mean():.5f}" for k in ("_bias", "", "_floor")]
    likeness = [f"{column(point, f'ssim{k}').mean():.4f}" for k in ("", "_floor")]
    return (
        *(case["view"], case["metric"], f"{case['detail']:g}", case["pruned"]),
        *(str(samples[k][0]) for k in ("parts", "sticks")),
        f"{samples['foretold_bytes'][0] / 1e6:.0f}",
        *times,
        *(f"{v:.4f}" for v in (found.excess, found.high, found.floor)),
        *errors,
        *likeness,
    )


def _figure(record: Record, view: str, points: list[Point], against: str) -> Figure:
    drawn, all_x = [], set()
    for metric in METRICS_TRIED:
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


def _crossings(points: list[Point]) -> str:
    words = []
    for metric in METRICS_TRIED:
        row = curve(points, metric)
        detail, parts = reached(row, np.arange(len(row[0].samples["flip"])))
        where = (
            "not in this range" if math.isnan(detail) else f"τ = {detail:.2g}, {parts:.0f} parts"
        )
        words.append(f"{metric}: {where}")
    return f"It reaches {EQUAL_ERROR} at: " + "; ".join(words) + "."


def _pieces(points: list[Point]) -> str:
    words = [f"{p.case['pruned']} {excess(p).excess:.4f}" for p in pieces(points)]
    return f"At 1 px by blake, pruned alone: {', '.join(words)}."
