"""What the depth experiment shows: surfaces pierced against the world's size, and a table."""

from bench.experiment import Table
from bench.experiments.depth.claims import METRICS_TRIED, QUADRANTS, total
from bench.plots.plot import Curve, Plot, curves
from bench.records.records import Point, Record, where
from bench.statistics.estimates import two_sided_mean

_LABELS = {"blake": "pruned", "full": "unpruned"}


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw the surfaces pierced against the world's size, pruned and unpruned."""
    rays = QUADRANTS * record.notes["rays_in_a_quadrant"]
    drawn = []
    for metric in METRICS_TRIED:
        row = where(record.points, metric=metric)
        found = [two_sided_mean(total(p) / rays) for p in row]
        y, low, high = ([max(getattr(e, k), 1e-3) for e in found] for k in ("value", "low", "high"))
        drawn.append(Curve(_LABELS[metric], [p.case["extent"] for p in row], y, low, high))
    words = "; ".join(f"{c.label} {c.y[0]:.2f} to {c.y[-1]:.2f}" for c in drawn)
    told = " ".join(f"{c.about} {c.measured:.3f}: {c.verdict}." for c in record.claims)
    caption = (
        f"Surfaces that a level ray pierces, against the side of the world: {words}. The eye is in "
        f"the middle. {told}"
    )
    axis = "side of the world (m)", "surfaces pierced by a ray"
    title = "Depth complexity"
    return (curves("depth", title, caption, axis, drawn),)


def point_table(record: Record) -> Table:
    """Return the heads and rows of a table: means over fields in every quadrant."""
    heads = ("side (m)", "metric", *(f"quadrant {k + 1}" for k in range(QUADRANTS)), "all")
    return heads, [_row(point, record.notes["rays_in_a_quadrant"]) for point in record.points]


def _row(point: Point, rays: int) -> tuple[str, ...]:
    quadrants = [sum(point.column("pierced", quadrant=k)) / rays for k in range(QUADRANTS)]
    fields = len(total(point))
    numbers = [each / fields for each in (*quadrants, sum(quadrants) / QUADRANTS)]
    return f"{point.case['extent']:g}", point.case["metric"], *(f"{v:.3f}" for v in numbers)
