"""What the cover experiment shows: tone against distance, with cover and without, and a table."""

from bench.experiment import Table
from bench.experiments.cover.claims import (
    TOLERANCE,
    band_name,
    bands,
    coverage,
    land_share,
    same_rays,
    tone,
)
from bench.experiments.cover.scene import LOOKS
from bench.plots import Curve, Plot, curves
from bench.records.records import Point, Record, where
from bench.statistics.estimates import Estimate

_AIR = {"preset": "the preset's air", "clear": "clear air"}


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw a plot of each look in clear air, where haze hides nothing."""
    return tuple(_plot(record, look) for look in LOOKS)


def _plot(record: Record, look: str) -> Plot:
    mine = where(record.points, look=look, air="clear")
    drawn = [_curve(point) for point in mine]
    words = "; ".join(f"{c.label}: {', '.join(f'{y:.3f}' for y in c.y)}" for c in drawn)
    about = (
        f"Mean luminance of {look} in clear air, pruned ÷ everything there is, from band to band "
        f"of distance ({100 * TOLERANCE:g} % is claimed): {words}."
    )
    axis = "distance (m)", "luminance ÷ that of everything"
    title = f"The tone of the land: {look}"
    return curves(f"cover-{look}", title, about, axis, drawn)


def _curve(point: Point) -> Curve:
    edges = LOOKS[point.case["look"]].edges_m
    found = [tone(point, k) for k in range(bands(point))]
    middle = [(edges[k] * edges[k + 1]) ** 0.5 for k in range(len(found))]
    cover = "" if point.case["cover"] else ", without cover"
    y, low, high = ([max(getattr(e, k), 1e-3) for e in found] for k in ("value", "low", "high"))
    return Curve(f"{point.case['detail']:g} px{cover}", middle, y, low, high)


def point_table(record: Record) -> Table:
    """Return the heads and rows of a table: every band of every picture."""
    heads = ("look", "air", "detail (px)", "cover", "band", "pruned ÷ whole", "95 % interval")
    more = (
        *("land's share of the light", "land alone, pruned ÷ whole"),
        *("coverage, pruned ÷ whole", "95 % interval", "the same rays, pruned ÷ whole"),
    )
    return (*heads, *more), [_row(p, k) for p in record.points for k in range(bands(p))]


def _row(point: Point, band: int) -> tuple[str, ...]:
    case, found = point.case, tone(point, band)
    cover = "left on the land" if case["cover"] else "none"
    case_ = case["look"], _AIR[case["air"]], f"{case['detail']:g}", cover
    land, filled = tone(point, band, "land"), coverage(point, band)
    more = f"{100 * land_share(point, band):.0f} %", f"{land:.3f}", f"{filled.value:.3f}"
    last = _interval(filled), f"{same_rays(point, band):.3f}"
    return *case_, band_name(point, band), f"{found.value:.3f}", _interval(found), *more, *last


def _interval(found: Estimate) -> str:
    return f"{found.low:.3f}-{found.high:.3f}"
