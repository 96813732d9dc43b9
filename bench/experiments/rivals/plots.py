"""What the rivals experiment shows: error against time and memory for every arm."""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from bench.experiments.rivals.equal_error import (
    STAGES,
    excess,
    frame_seconds,
    is_measured,
    megabytes,
)
from bench.plots.plot import Curve, Plot, curves
from bench.records.points import Point, grouped
from bench.records.records import Record
from bench.runner.experiment import Table
from lod.errors import InputError

_LEAST = 1e-4
"""Excesses below this are drawn as this: noise makes some of them negative."""

_COSTS: dict[str, tuple[Callable[[Point], float], str]] = {
    "time": (frame_seconds, "seconds of a frame, all stages"),
    "memory": (megabytes, "most that a process holds (MB)"),
}


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw, for each kind and size of world, the error against time and memory, by arm."""
    windows = grouped(filter(is_measured, record.points), "kind", "objects")
    return tuple(
        plot
        for key, points in windows.items()
        for cost in _COSTS
        for plot in _plot(points, cost, *key)
    )


def point_table(record: Record) -> Table:
    """Return the heads and rows of a table of every field, arm and setting."""
    heads = ("world", "field", "arm", "setting", "excess FLIP", "SSIM", "sticks", "MB")
    measured = [_row(point) for point in record.points if is_measured(point)]
    return (*heads, *(f"{stage} s" for stage in STAGES)), measured


def _plot(points: Sequence[Point], cost: str, kind: str, objects: float) -> Iterator[Plot]:
    of_point, axis = _COSTS[cost]
    drawn = []
    for (arm,), mine in grouped(points, "arm").items():
        settings = grouped(mine, "setting").values()
        known = [each for each in settings if all(math.isfinite(of_point(p)) for p in each)]
        x = [float(np.mean([of_point(p) for p in each])) for each in known]
        y = [max(float(np.mean([excess(p) for p in each])), _LEAST) for each in known]
        if x:
            drawn.append(Curve(arm, x, y))
    if not drawn:
        return
    caption = "Means over fields, settings next to equal error. Nearer to the lower left is better."
    title = f"{kind}, {objects:g} objects: error against {cost}"
    name = f"rivals-{kind.replace(' ', '-')}-{objects:g}-{cost}"
    yield curves(name, title, caption, (axis, "excess FLIP over the whole picture"), drawn)


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
