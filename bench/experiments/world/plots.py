"""What the world experiment shows: time and parts against the number of objects, and a table."""

import numpy as np

from bench.experiment import Table
from bench.experiments.world.claims import added_by_parts, beyond_limit, seconds
from bench.plots import Curve, Plot, curves
from bench.records.records import Point, Record, where
from bench.statistics.estimates import two_sided_median
from bench.statistics.fits import RivalModels, compare_with_log

_LABELS = {"blake": "pruned", "full": "unpruned"}


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw time, then parts."""
    return _time(record), _parts(record)


def point_table(record: Record) -> Table:
    """Return the heads and rows of a table: every world."""
    heads = ("pruned", "objects in the world", "side (m)", "limit (m)", "objects", "parts")
    return (*heads, "scene (MB)", "scene's hash", "s (95 %)"), [_row(p) for p in record.points]


def _row(point: Point) -> tuple[str, ...]:
    case, found = point.case, two_sided_median(seconds(point))
    counts = f"{point.column('objects')[0]:,}", f"{point.column('parts')[0]:,}"
    return (
        *(_LABELS[case["metric"]], f"{case['objects']:.0e}", f"{case['side_m']:.4g}"),
        *(f"{case['limit_m']:.4g}" if case["limit_m"] else "none", *counts),
        *(f"{point.column('bytes')[0] / 1e6:.1f}", case["scene"]),
        f"{found:.4f}",
    )


def _time(record: Record) -> Plot:
    drawn = []
    for metric, label in _LABELS.items():
        points = where(record.points, metric=metric)
        found = [two_sided_median(seconds(p)) for p in points]
        bands = [f.low for f in found], [f.high for f in found]
        x = [float(p.case["objects"]) for p in points]
        drawn.append(Curve(label, x, [f.value for f in found], *bands, line=_line(metric, points)))
    rivals = _rival_models(where(record.points, metric="full"))
    same = len({p.case["scene"] for p in beyond_limit(record.points)})
    caption = (
        "From prune to plain scene, seconds of one core: medians with their 95 % intervals. Of the "
        f"worlds larger than the limit distance, {len(beyond_limit(record.points))} give {same} "
        f"scene{'s' if same > 1 else ''}, compared bit for bit. {_words(drawn)} Dashed: no growth "
        f"once the world is larger than the limit; unpruned, what parts add to the smallest "
        f"world, of which {rivals.words}, x being the parts added."
    )
    axis = "objects in the world", "seconds for a frame"
    return curves("time", "A frame in ever larger worlds", caption, axis, drawn)


def _line(metric: str, points: list[Point]) -> tuple[list[float], list[float]]:
    """Return what was fitted, at the points: a constant beyond the limit, or parts added."""
    if metric != "full":
        beyond = beyond_limit(tuple(points))
        middle = float(np.median(np.concatenate([seconds(p) for p in beyond])))
        return [float(p.case["objects"]) for p in beyond], [middle] * len(beyond)
    parts = np.array([float(p.column("parts")[0]) for p in points[1:]])
    first = float(np.median(seconds(points[0])))
    fitted = first + _rival_models(points).line(parts - points[0].column("parts")[0])
    return [float(p.case["objects"]) for p in points[1:]], fitted.tolist()


def _rival_models(points: list[Point]) -> RivalModels:
    return compare_with_log(*added_by_parts(points))


def _parts(record: Record) -> Plot:
    drawn = []
    for metric, label in _LABELS.items():
        points = where(record.points, metric=metric)
        y = [float(np.maximum(p.column("parts")[0], 1)) for p in points]
        drawn.append(Curve(label, [float(p.case["objects"]) for p in points], y))
    caption = f"Parts displayed from the same eye. {_words(drawn)}"
    axis = "objects in the world", "parts displayed"
    return curves("parts", "Parts in ever larger worlds", caption, axis, drawn)


def _words(drawn: list[Curve]) -> str:
    return " ".join(
        f"{c.label}: {c.y[0]:.3g} at {c.x[0]:.0e} objects, {c.y[-1]:.3g} at {c.x[-1]:.0e}."
        for c in drawn
    )
