"""What the pixels experiment shows: how parts to a pixel are spread, and a table."""

import numpy as np

from bench.experiment import Table
from bench.experiments.pixels.claims import MOST, ratios
from bench.plots import Curve, Plot, curves
from bench.records.records import Point, Record, grouped

_SHARES = (0.5, 0.2, 0.1, 0.05, 0.02, 0.01)
_AXIS = "parts ÷ pixels covered", "share of the objects that have more"


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw, for each species and detail, the share of objects beyond each ratio."""
    kinds = grouped(record.points, "species", "detail")
    return tuple(_plot(points, *kind) for kind, points in kinds.items())


def point_table(record: Record) -> Table:
    """Return the heads and rows of a table: percentiles by pixels covered and by area."""
    heads = ("species", "metric", "τ (px)", "objects", "median", "95 %", "largest")
    return (*heads, "by area: median", "95 %"), [_row(point) for point in record.points]


def _row(point: Point) -> tuple[str, ...]:
    case, found, area = point.case, ratios(point), ratios(point, "area")
    numbers = [*np.quantile(found, (0.5, 0.95, 1.0)), *np.quantile(area, (0.5, 0.95))]
    place = case["species"], case["metric"], f"{case['detail']:g}", str(len(found))
    return *place, *(f"{v:.2f}" for v in numbers)


def _plot(points: list[Point], species: str, detail: float) -> Plot:
    drawn, words = [], []
    for point in points:
        found = ratios(point)
        x = np.quantile(found, [1 - share for share in _SHARES]).tolist()
        drawn.append(Curve(point.case["metric"], x, _SHARES))
        words.append(f"{point.case['metric']} {x[3]:.2f} at 5 %")
    caption = (
        f"Of {species}s at τ = {detail:g} px, drawn alone: the share of them that have more parts "
        f"to a pixel covered. {'; '.join(words)}; at most {MOST:g} is claimed."
    )
    title = f"Parts to a pixel, {species}s, τ = {detail:g} px"
    name = f"pixels-{species}-{detail:g}"
    return curves(name, title, caption, _AXIS, drawn)
