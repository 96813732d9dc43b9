"""What the motion experiment shows: parts that motion keeps against speed, and a table."""

from bench.experiment import Table
from bench.experiments.motion.claims import PICTURE, kept, one_sided_excess_flip, parts
from bench.plots import Curve, Plot, curves
from bench.records.records import Point, Record, where


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw the share that motion keeps of pans at one shutter."""
    pans = where(record.points, world="endless", speed=0.0, shutter=180.0)
    found = [kept(point) for point in pans]
    turns = [point.case["turn"] for point in pans]
    shares, low, high = ([getattr(e, k) for e in found] for k in ("value", "low", "high"))
    words = ", ".join(f"{y:.3g} at {x:g}°/s" for x, y in zip(turns, shares, strict=True))
    caption = f"Parts kept when motion is counted, shutter 180°, 24 frames/s: {words}."
    axis = "speed of the pan (degrees/s)", "parts kept ÷ by size and distance alone"
    drawn = [Curve("meadow, 640 px", turns, shares, low, high)]
    return (curves("motion", "What a pan hides", caption, axis, drawn, ("linear", "log")),)


def point_table(record: Record) -> Table:
    """Return the heads and rows of a table: every case."""
    heads = ("world", "pan (°/s)", "ahead (m/s)", "shutter (°)", "by size and distance")
    rows = [_pictured(p) if p.case["world"] == PICTURE else _row(p) for p in record.points]
    return (*heads, "by motion as well", "kept", "95 % interval", "excess FLIP"), rows


def _row(point: Point) -> tuple[str, ...]:
    case, found = point.case, kept(point)
    moves = (f"{case[k]:g}" for k in ("turn", "speed", "shutter"))
    counts = (f"{parts(point, k).mean():.0f}" for k in ("spatial", "motion"))
    kept_ = f"{found.value:.3f}", f"{found.low:.3f}-{found.high:.3f}"
    return case["world"], *moves, *counts, *kept_, ""


def _pictured(point: Point) -> tuple[str, ...]:
    """Describe a rendered move: how far the cut by motion is from the cut without."""
    case, found = point.case, one_sided_excess_flip(point)
    moves = (f"{case[k]:g}" for k in ("turn", "speed", "shutter"))
    floor = float(point.values("flip_floor").mean()) / 1e6
    excess = f"{found.value:.4f} ({found.low:.4f}-{found.high:.4f}) over a floor of {floor:.3f}"
    return f"picture, {case['cut']}", *moves, *[""] * 4, excess
