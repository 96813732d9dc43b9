"""What does the scaling experiment show? Its points as series, plots and tables."""

from collections.abc import Callable, Iterable

import numpy as np
from scipy import stats

from bench.experiment import Table
from bench.experiments.scaling.cases_beyond import BEYOND, swept_beyond
from bench.experiments.scaling.claims import by_kind, case_of, noise_of, swept
from bench.experiments.scaling.count_field import COLUMNS
from bench.experiments.scaling.plots_beyond import beyond_plots, half_beyond
from bench.plots.plot import Curve, Plot, against_law, curves
from bench.records.records import Point, Record, where
from bench.statistics.estimates import TWO_SIDED_TAILS

_AXES = {
    "density": "K, objects per m²",
    "size": "P + R of the whole object (m)",
    "detail": "m (rad), by detail threshold",
    "resolution": "m (rad), by picture width",
    "magnification": "m (rad), by field of view",
    "world": "L, side of the world (m)",
}
_TITLES = {
    "density": "More objects per area",
    "size": "Larger objects",
    "detail": "Coarser detail, by threshold",
    "resolution": "Coarser detail, by resolution",
    "magnification": "Coarser detail, by field of view",
    "world": "A larger world",
}
_PER_FIELD = "mean number per field"

Noise = dict[str, float]
"""Variance measured ÷ variance predicted, for every metric, species and count."""


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw every sweep of the default metric, then every metric against its own prediction."""
    kinds, noise = by_kind(record.points), noise_of(record.points)
    made = [
        _sweep_plot(record, species, sweep, noise)
        for species, metric in kinds
        if metric == "blake"
        for sweep in _AXES
        if _chosen(record, species, metric, sweep)
    ]
    made += beyond_plots(record)
    made += [_law_plot(record, what, noise) for what in ("objects", "parts")]
    made += [_search_plot(record, what) for what in ("objects", "parts")]
    return tuple(made)


def point_table(record: Record) -> Table:
    """Return a table: every point with what was predicted, measured and examined."""
    heads = (
        *("species", "metric", "sweep", "swept", "fields", "objects predicted", "measured", "±"),
        *("ratio", "parts predicted", "measured", "±", "ratio"),
        *("objects examined ÷ displayed", "parts examined ÷ displayed"),
    )
    noise = noise_of(record.points)
    return heads, [_row(point, noise) for point in record.points]


def _row(point: Point, noise: Noise) -> tuple[str, ...]:
    case, count = case_of(point), len(point.column(COLUMNS[0]))
    beyond = case.sweep in BEYOND
    value = swept_beyond(case) if beyond else swept(point)
    cells = [case.species, case.metric, case.sweep, f"{value:.4g}", str(count)]
    for what in ("objects", "parts"):
        predicted, measured = point.prediction(what), mean(point, what)
        half = half_beyond(point, what) if beyond else half_interval(point, what, noise)
        cells += [f"{predicted:.5g}", f"{measured:.5g}", f"{half:.2g}"]
        cells.append(f"{measured / predicted:.4f}")
    for what in ("objects", "parts"):
        cells.append(f"{mean(point, what + '_examined') / mean(point, what):.3f}")
    return tuple(cells)


def mean(point: Point, column: str) -> float:
    """Return the mean count of a field."""
    return float(np.mean(point.column(column)))


def half_interval(point: Point, what: str, noise: Noise) -> float:
    """Return half the two-sided 95 % interval of the mean.

    The variance is the law's, times the ratio ``noise`` that all fields of the species and metric
    together have to it: few large fields alone could not say how much they vary.
    """
    scale = noise[f"{point.case['metric']}/{point.case['species']}/{what}"]
    variance = scale * point.prediction(f"{what}_variance") / len(point.column(what))
    return float(stats.norm.ppf(TWO_SIDED_TAILS[1]) * np.sqrt(variance))


def _sweep_plot(record: Record, species: str, sweep: str, noise: Noise) -> Plot:
    points = _chosen(record, species, "blake", sweep)
    series = [
        _series(f"{what} displayed", points, what, swept, noise) for what in ("objects", "parts")
    ]
    mark = None
    if sweep == "world":
        mark = 2 * max(p.prediction("farthest_limit") for p in points), "L = 2D"
    return against_law(
        name=f"{species}-{sweep}",
        title=f"{_TITLES[sweep]} ({species}s)",
        caption=_caption(record, f"blake/{species}/objects/slope_{sweep}"),
        axis=(_AXES[sweep], _PER_FIELD),
        drawn=series,
        mark=mark,
    )


def _caption(record: Record, name: str) -> str:
    return " ".join(
        f"{c.about} Objects' {c.quantity}: {c.measured_text}, "
        f"claimed {c.claimed_text}: {c.verdict}."
        for c in record.claims
        if c.name == name
    )


def _law_plot(record: Record, what: str, noise: Noise) -> Plot:
    def predicted(point: Point) -> float:
        return point.prediction(what)

    series = [
        _series(f"{metric}, {species}", points, what, predicted, noise)
        for (species, metric), points in by_kind(record.points).items()
    ]
    title = f"All sweeps, against the prediction: {what}"
    caption = (
        f"Every point of every sweep, as predicted and as measured, {what} per field. The shaded "
        f"band is ± 2 %. Nothing is fitted: the line is the law with its prefactor."
    )
    axis = f"{what} predicted per field", f"{what} measured per field"
    return against_law(f"law-{what}", title, caption, axis, series)


def _search_plot(record: Record, what: str) -> Plot:
    series = []
    for (species, metric), points in by_kind(record.points).items():
        endless = sorted(
            (p for p in points if p.case["extent"] is None), key=lambda p: mean(p, what)
        )
        displayed = [mean(p, what) for p in endless]
        examined = [mean(p, f"{what}_examined") for p in endless]
        shares = [a / b for a, b in zip(examined, displayed, strict=True)]
        series.append(Curve(f"{metric}, {species}", displayed, shares))
    title = f"Examined for each one displayed: {what}"
    caption = (
        f"How many {what} had to be tested for each one displayed, in endless worlds: it does not "
        f"grow with the field, so that searching costs no more than in proportion."
    )
    axis = f"{what} displayed per field", f"{what} examined ÷ displayed"
    return curves(f"examined-{what}", title, caption, axis, series, ("log", "linear"))


def _series(
    label: str, points: Iterable[Point], what: str, along: Callable[[Point], float], noise: Noise
) -> Curve:
    points = sorted(points, key=along)
    x, y = [along(p) for p in points], [mean(p, what) for p in points]
    half = [half_interval(p, what, noise) for p in points]
    low, high = ([a + k * b for a, b in zip(y, half, strict=True)] for k in (-1, 1))
    return Curve(label, x, y, low, high, (x, [p.prediction(what) for p in points]))


def _chosen(record: Record, species: str, metric: str, sweep: str) -> list[Point]:
    return where(record.points, species=species, metric=metric, sweep=sweep)
