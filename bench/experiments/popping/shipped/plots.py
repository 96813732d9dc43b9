"""What is shown of walks through presets as shipped: change by frame, and a row for each walk."""

import numpy as np

from bench.experiment import Table
from bench.experiments.popping.shipped.claims import MOST_CHANGE, changes
from bench.plots import Curve, Plot, curves
from bench.records.records import Point, Record, grouped


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw, for each preset, what motion does not explain of each frame."""
    walks = grouped(record.points, "preset")
    return tuple(_plot(preset, points) for (preset,), points in walks.items())


def _plot(preset: str, points: list[Point]) -> Plot:
    drawn = [Curve(p.case["way"], p.column("frame"), changes(p).tolist()) for p in points]
    frames = points[0].column("frame")
    drawn.append(Curve("not seen as a jump", [frames[0], frames[-1]], [MOST_CHANGE] * 2))
    of_ways = [f"{c.label} {np.mean(c.y):.4f}, at most {max(c.y):.4f}" for c in drawn[:-1]]
    words = "; ".join(of_ways)
    caption = (
        f"A walk through {preset}: the change that 1 in 10 000 pixels of a frame exceeds and that "
        f"motion does not explain, as a share of white. Mean over frames: {words}."
    )
    axis = "frame", "unexplained change (share of white)"
    name, title = f"popping-shipped-{preset}", f"What jumps from frame to frame: {preset}"
    return curves(name, title, caption, axis, drawn, ("linear", "linear"))


def point_table(record: Record) -> Table:
    """Return the heads and rows of a table: every walk in every way."""
    heads = "preset", "pruned", "pairs", "parts popped", "change, mean", "change, largest"
    return heads, [_row(point) for point in record.points]


def _row(point: Point) -> tuple[str, ...]:
    case, found, popped = point.case, changes(point), point.values("popped")
    counts = str(len(found)), f"{popped.sum():.0f}"
    return case["preset"], case["way"], *counts, f"{found.mean():.4f}", f"{found.max():.4f}"
