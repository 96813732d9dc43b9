"""What is shown of the cases beyond even, flat, clear ground? Counts, and both laws."""

from bench.experiments.scaling.cases_beyond import BEYOND, swept_beyond
from bench.experiments.scaling.claims_beyond import over_bare, over_law
from bench.fields.cases import Case
from bench.plots.plot import Curve, Plot, against_law
from bench.records.records import Point, Record, where
from bench.statistics.estimates import Estimate


def beyond_plots(record: Record) -> tuple[Plot, ...]:
    """Draw a plot for each sweep."""
    chosen = {sweep: where(record.points, sweep=sweep) for sweep in BEYOND}
    return tuple(_plot(sweep, points) for sweep, points in chosen.items() if points)


def half_beyond(point: Point, what: str) -> float:
    """Return half the two-sided 95 % interval of the mean of a point."""
    found = over_law([point], what)
    return (found.high - found.low) / 2 * point.prediction(what)


def _plot(sweep: str, points: list[Point]) -> Plot:
    question = BEYOND[sweep]
    points = sorted(points, key=lambda p: swept_beyond(Case(**p.case)))
    series = [_known(points, what) for what in ("objects", "parts")]
    series.append(_bare(points))
    words = [f"{_at(p)}: {over_bare(p).value:.4f}" for p in points]
    caption = (
        f"Mean number per field, and the law that knows of it. The third series is the bare law's "
        f"πK((P + R)/m)² for the same objects: measured ÷ bare by {question.axis} is "
        f"{', '.join(words)}."
    )
    axis = question.axis, "mean number per field"
    return against_law(f"beyond-{sweep}", question.title, caption, axis, series)


def _at(point: Point) -> str:
    """Return where a case is on the axis, to three digits."""
    return f"{float(f'{swept_beyond(Case(**point.case)):.3g}'):g}"


def _known(points: list[Point], what: str) -> Curve:
    found = [over_law([p], what) for p in points]
    predicted = [p.prediction(what) for p in points]
    return _series(f"{what} displayed", points, predicted, found)


def _bare(points: list[Point]) -> Curve:
    found = [over_bare(p) for p in points]
    return _series(
        "objects, by the bare law", points, [p.prediction("bare") for p in points], found
    )


def _series(
    label: str, points: list[Point], predicted: list[float], found: list[Estimate]
) -> Curve:
    x = [swept_beyond(Case(**p.case)) for p in points]
    numbers = zip(found, predicted, strict=True)
    y, low, high = zip(*((f.value * p, f.low * p, f.high * p) for f, p in numbers), strict=True)
    return Curve(label, x, y, low, high, (x, predicted))
