"""What the popping experiment shows: at which distances parts switch, and a table."""

import numpy as np

from bench.experiment import Table
from bench.plots import Curve, Plot, curves
from bench.records.records import Point, Record, where

_SHARES = (0.01, 0.05, 0.1, 0.25, 0.5, 0.75, 0.9, 0.95, 0.99)


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw how switching distances are distributed."""
    points = where(record.points, what="switches")
    drawn, words = [], []
    for point in points:
        metres = point.values("distance_mm") / 1000
        x = np.quantile(metres, _SHARES).tolist()
        drawn.append(Curve(point.case["species"], x, _SHARES))
        words.append(f"of {point.case['species']}s half within {x[4]:.1f} m, 9 in 10 {x[6]:.1f} m")
    caption = f"The share of switches that are nearer than a distance: {'; '.join(words)}."
    axis = "distance of the switch (m)", "share of the switches"
    title = "Where parts switch"
    return (curves("popping", title, caption, axis, drawn),)


def point_table(record: Record) -> Table:
    """Return the heads and rows of a table: switches of every species, then the walks."""
    heads = ("what", "of", "switches a field", "predicted", "size, median (px)", "size, 95 % (px)")
    changes = "popped a frame", "unexplained, 99 %", "99.9 %", "99.99 %"
    return (*heads, *changes), [_row(point) for point in record.points]


def _row(point: Point) -> tuple[str, ...]:
    if point.case["what"] == "switches":
        sizes = np.quantile(point.values("size_mpx") / 1000, (0.5, 0.95))
        counts = f"{point.values('switches').mean():.1f}", f"{point.prediction('switches'):.1f}"
        return "switches", point.case["species"], *counts, *(f"{v:.2f}" for v in sizes), *[""] * 4
    changes = [np.mean(each.values) / 1e6 for each in point.samples if each.keys]
    popped = f"{point.values('popped').mean():.1f}"
    return "walk", point.case["way"], *[""] * 4, popped, *(f"{v:.4f}" for v in changes)
