"""What the haze experiment shows: parts left of each size against visibility, and a table."""

import numpy as np

from bench.experiments.haze.claims import Kind, by_kind
from bench.fields.part_sizes import SIZES, law_total, total
from bench.plots.plot import Curve, Plot, curves
from bench.records.records import Point, Record

_AXIS = "visibility V (m)", "share of the parts that is left"
_VIEWERS = {"nobody": "no eye", "eye": "an eye at 67 pixels per degree"}


def plots(record: Record) -> tuple[Plot, ...]:
    """A plot for each species, viewer and width."""
    return tuple(_plot(record, kind, points) for kind, points in by_kind(record.points).items())


def table(record: Record) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Heads and rows: parts of each size at each visibility, in clear air and in haze."""
    heads = (
        *("species", "viewer", "width (px)", "V (km)", "P", "in clear air", "predicted"),
        *("in haze", "predicted", "saved (%)", "predicted (%)"),
    )
    rows = [_row(p, size) for p in record.points for size in SIZES if _any(p, size)]
    return heads, rows


def _row(point: Point, size: str) -> tuple[str, ...]:
    case = point.case
    numbers = [
        f"{value:.5g}"
        for air in ("clear", "hazy")
        for value in (float(total(point, air, [size]).mean()), law_total(point, air, [size]))
    ]
    saved = [f"{100 * (1 - share):.1f}" for share in _left(point, size)]
    place = f"{case['width']}", f"{case['visibility'] / 1000:g}"
    return case["species"], case["viewer"], *place, size, *numbers, *saved


def _left(point: Point, size: str) -> tuple[float, float]:
    """Share that haze leaves, measured and predicted."""
    clear, hazy = (float(total(point, air, [size]).sum()) for air in ("clear", "hazy"))
    wanted, law = (law_total(point, air, [size]) for air in ("clear", "hazy"))
    return hazy / clear, law / wanted


def _any(point: Point, size: str) -> bool:
    return law_total(point, "clear", [size]) > 0 and bool(total(point, "clear", [size]).any())


def _plot(record: Record, kind: Kind, points: list[Point]) -> Plot:
    species, viewer, width = kind
    drawn = []
    for size in (s for s in SIZES if _any(points[0], s)):
        V = [point.case["visibility"] for point in points]
        left = np.array([_left(point, size) for point in points])
        drawn.append(Curve(size, V, left[:, 0].tolist(), line=(V, left[:, 1].tolist())))
    fields = len(next(iter(points[0].samples.values())))
    caption = (
        f"Parts of each size P displayed in haze, over those displayed in clear air at the same "
        f"m; {_VIEWERS[viewer]}, a picture {width} pixels wide, {fields} fields. Dashed: "
        f"predicted."
    )
    words = [
        f"{c.label}: {c.y[0]:.3g} at {c.x[0]:.0f} m, {c.y[2]:.3g} at {c.x[2]:.0f} m." for c in drawn
    ]
    alt = f"Log-log plot of {_AXIS[1]} against {_AXIS[0]}. " + " ".join(words)
    title = f"What haze leaves of {species}s ({_VIEWERS[viewer]}, {width} px)"
    return curves(f"haze-{species}-{viewer}-{width}", title, caption, alt, _AXIS, drawn)
