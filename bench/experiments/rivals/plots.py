"""What the rivals experiment shows: error against time for every arm, and who wins where."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from bench.experiments.rivals.equal_error import (
    STAGES,
    at_equal_error,
    best_rival,
    excess,
    frame_seconds,
    megabytes,
)
from bench.plots.plot import Curve, Plot, curves
from bench.records.points import Point, grouped
from bench.records.records import Record
from bench.runner.experiment import Table
from lod.errors import InputError

_LEAST = 1e-4
"""Excesses below this are drawn as this: noise makes some of them negative."""


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw, for each kind and size of world, the error against the time of a frame, by arm."""
    windows = grouped(record.points, "kind", "objects")
    return tuple(_plot(points, *key) for key, points in windows.items())


def summary(record: Record) -> Table:
    """Return a table: at equal error, each arm's seconds and megabytes in every world."""
    heads = "world", "arm", "seconds at equal error", "MB", "least"
    rows = [row for key, w in _windows(record) for row in _summary_rows(key, w)]
    return heads, rows


def point_table(record: Record) -> Table:
    """Return the heads and rows of a table of every field, arm and setting."""
    heads = ("world", "field", "arm", "setting", "excess FLIP", "SSIM", "sticks", "MB")
    return (*heads, *(f"{stage} s" for stage in STAGES)), [_row(p) for p in record.points]


def _windows(record: Record) -> list[tuple[str, list[Point]]]:
    windows = grouped(record.points, "kind", "objects")
    return [(f"{kind}, {objects:g}", points) for (kind, objects), points in windows.items()]


def _summary_rows(where: str, points: Sequence[Point]) -> list[tuple[str, ...]]:
    found = at_equal_error(points)
    least = {best_rival(found, "seconds"): "time", best_rival(found, "megabytes"): "memory"}
    rows: list[tuple[str, ...]] = []
    for arm, row in found.items():
        reached = all(each.reached for each in row)
        seconds = f"{np.mean([e.seconds for e in row]):.2f}" if reached else "never reached"
        held = f"{np.mean([each.megabytes for each in row]):.0f}"
        rows.append((where, arm, seconds, held, f"rivals' {least[arm]}" if arm in least else ""))
    return rows


def _plot(points: list[Point], kind: str, objects: float) -> Plot:
    drawn = []
    for (arm,), mine in grouped(points, "arm").items():
        settings = grouped(mine, "setting").values()
        timed = [each for each in settings if all(math.isfinite(frame_seconds(p)) for p in each)]
        x = [float(np.mean([frame_seconds(p) for p in each])) for each in timed]
        y = [max(float(np.mean([excess(p) for p in each])), _LEAST) for each in timed]
        if x:
            drawn.append(Curve(arm, x, y))
    caption = "Means over fields, settings next to equal error. Nearer to the lower left is better."
    title = f"{kind}, {objects:g} objects: error against time"
    axis = "seconds of a frame, all stages", "excess FLIP over the whole picture"
    return curves(f"rivals-{kind}-{objects:g}", title, caption, axis, drawn)


def _row(point: Point) -> tuple[str, ...]:
    case: dict[str, Any] = point.case
    where = f"{case['kind']}, {case['objects']:g}", str(case["field"] + 1)
    ssim = float(np.mean(point.values("ssim"))) / 1e6
    held = megabytes(point)
    return (
        *where,
        case["arm"],
        f"{case['setting']:g}",
        f"{excess(point):.4f}",
        f"{ssim:.3f}",
        f"{point.column('sticks')[0]:,}",
        f"{held:.0f}" if math.isfinite(held) else "",
        *(_seconds(point, stage) for stage in STAGES),
    )


def _seconds(point: Point, stage: str) -> str:
    try:
        return f"{float(np.median(point.values('us', stage=stage))) / 1e6:.3f}"
    except InputError:
        return ""
