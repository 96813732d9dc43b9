"""What the haze experiment shows: parts left of each size against visibility, and a table."""

import numpy as np

from bench.experiment import Table
from bench.experiments.haze.claims import KIND
from bench.part_sizes import SIZES, part_counts, predicted_parts, shares_kept
from bench.plots import Curve, Plot, curves
from bench.records.records import Point, Record, grouped

_AXIS = "visibility V (m)", "share of the parts that is left"
_VIEWERS = {"nobody": "no eye", "eye": "an eye at 67 pixels per degree"}


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw a plot for each species, viewer and width."""
    return tuple(_plot(points, *kind) for kind, points in grouped(record.points, *KIND).items())


def point_table(record: Record) -> Table:
    """Return a table: parts of each size at each visibility, in clear air and in haze."""
    heads = (
        *("species", "viewer", "width (px)", "V (km)", "P", "in clear air", "predicted"),
        *("in haze", "predicted", "saved (%)", "predicted (%)"),
    )
    rows = [_row(p, size) for p in record.points for size in SIZES if _any(p, size)]
    return heads, rows


def _row(point: Point, size: str) -> tuple[str, ...]:
    case = point.case
    numbers = [f"{value:.5g}" for air in ("clear", "hazy") for value in _means(point, size, air)]
    saved = [f"{100 * (1 - share):.1f}" for share in _left(point, size)]
    place = f"{case['width']}", f"{case['visibility'] / 1000:g}"
    return case["species"], case["viewer"], *place, size, *numbers, *saved


def _left(point: Point, size: str) -> tuple[float, float]:
    """Return the share that haze leaves, measured and predicted."""
    found, law = shares_kept([point], {"air": "hazy"}, {"air": "clear"}, [size])
    return found.value, law


def _means(point: Point, size: str, air: str) -> tuple[float, float]:
    """Return the mean parts of a field, measured and predicted."""
    counts = part_counts(point, [size], air=air)
    return float(counts.mean()), predicted_parts(point, [size], air=air)


def _any(point: Point, size: str) -> bool:
    counts = part_counts(point, [size], air="clear")
    return predicted_parts(point, [size], air="clear") > 0 and bool(counts.any())


def _plot(points: list[Point], species: str, viewer: str, width: int) -> Plot:
    drawn = []
    for size in (s for s in SIZES if _any(points[0], s)):
        V = [point.case["visibility"] for point in points]
        left = np.array([_left(point, size) for point in points])
        drawn.append(Curve(size, V, left[:, 0].tolist(), line=(V, left[:, 1].tolist())))
    fields = len(points[0].samples[0].values)
    caption = (
        f"Parts of each size P displayed in haze, over those displayed in clear air at the same "
        f"m; {_VIEWERS[viewer]}, a picture {width} pixels wide, {fields} fields. Dashed: "
        f"predicted."
    )
    title = f"What haze leaves of {species}s ({_VIEWERS[viewer]}, {width} px)"
    return curves(f"haze-{species}-{viewer}-{width}", title, caption, _AXIS, drawn)
