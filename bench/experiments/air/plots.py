"""What the air experiment shows: contrast against distance, brightness and colour by distance."""

import numpy as np

from bench.experiment import Table
from bench.experiments.air.claims import SKY, label
from bench.experiments.air.targets import DISTANCES
from bench.plots import Curve, Plot, curves
from bench.records.records import Point, Record, where
from bench.statistics.estimates import two_sided_mean
from lod.air import Air, rgb_extinction

_VISIBILITY_M = 5e3
"""The visibility of the targets that are drawn [m]."""


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw the contrast of black targets in green, and the brightness of the meadow."""
    return _contrast(record), _brightness(record)


def point_table(record: Record) -> Table:
    """Return the heads and rows of a table: the meadow by distance."""
    heads = (
        *("meadow at 5 km", "pixels", "analytic ÷ medium", "scattered ÷ medium"),
        "RGB against spectral, median ΔE₀₀",
    )
    return heads, [_row(point) for point in where(record.points, what="bands")]


def _row(point: Point) -> tuple[str, ...]:
    shares = [f"{_share(point, kind):.3f}" for kind in ("analytic", "scattered")]
    difference = two_sided_mean(point.values("delta_e") / 1000).value
    return (label(point), str(point.column("pixels")[0]), *shares, f"{difference:.2f}")


def _share(point: Point, kind: str) -> float:
    return float(np.mean(point.values(kind) / point.values("medium")))


def _contrast(record: Record) -> Plot:
    drawn = []
    for point in where(record.points, what="targets", visibility=_VISIBILITY_M):
        black = point.values("grey") == 0
        step = point.values("step")[black]
        rows = np.argsort(step)
        target, beyond = (point.values(k, band="g")[black] for k in ("target", "beyond"))
        contrast = np.abs(target / beyond - 1)[rows]
        x = step[rows] / DISTANCES
        law = np.exp(-rgb_extinction(Air(_VISIBILITY_M))[1] * x * _VISIBILITY_M)
        line = x.tolist(), law.tolist()
        drawn.append(Curve(point.case["way"], x.tolist(), contrast.tolist(), line=line))
    words = "; ".join(f"{c.label}: {c.y[-1]:.4f} at V" for c in drawn)
    caption = (
        "Contrast in green of black targets against the endless path beside them, V = 5 km. "
        f"Dashed: exp(−βd). {words}."
    )
    axis = "distance ÷ V", "contrast"
    return curves("contrast", "Contrast in haze", caption, axis, drawn, ("linear", "log"))


def _brightness(record: Record) -> Plot:
    rows = [p for p in where(record.points, what="bands") if p.case["from"] != SKY]
    x = [max(p.case["from"], 25.0) for p in rows]
    even = x, [1.0] * len(x)
    drawn = [
        Curve(k, x, [_share(p, k) for p in rows], line=even) for k in ("analytic", "scattered")
    ]
    words = "; ".join(f"{c.label}: from {min(c.y):.3f} to {max(c.y):.3f}" for c in drawn)
    caption = (
        "Mean luminance of meadow at V = 5 km by distance, over that of the medium which scatters "
        f"light; dashed: as bright. {words}. Analytic takes its airlight from the sky model's "
        "horizon, which a thin layer of air under that sky does not reach; scattered solves that "
        "layer."
    )
    axis = "distance of the band's near end (m)", "luminance ÷ the medium's"
    return curves("medium", "Closed forms and medium", caption, axis, drawn)
