"""What the eye experiment shows: parts left against pixels per degree, and a table."""

from bench.experiment import Table
from bench.experiments.eye.claims import VIEWERS
from bench.part_sizes import part_counts, predicted_parts, shares_kept
from bench.plots import Curve, Plot, curves
from bench.records.records import Point, Record, grouped

_AXIS = "pixels per degree of sight", "share of the parts that is left"
_LABELS = {
    "blur": "blur alone",
    "contrast": "contrast alone",
    "faint": "contrast alone, all of 0.1",
    "both": "both, all of 0.1",
}


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw a plot for each species."""
    return tuple(_plot(points, *kind) for kind, points in grouped(record.points, "species").items())


def point_table(record: Record) -> Table:
    """Return the heads and rows of a table: every display and contrast."""
    heads = (
        *(
            "species",
            "pixels per degree",
            "θ_eff (px)",
            "contrast",
            "parts, ideal eye",
            "predicted",
        ),
        *("parts", "predicted", "left (%)", "predicted (%)"),
    )
    return heads, [_row(point, viewer) for point in record.points for viewer in VIEWERS]


def _row(point: Point, viewer: str) -> tuple[str, ...]:
    case = point.case
    numbers = [
        f"{value:.5g}"
        for each in ("ideal", viewer)
        for value in (
            float(part_counts(point, viewer=each).mean()),
            predicted_parts(point, viewer=each),
        )
    ]
    left = [f"{100 * share:.2f}" for share in _left(point, viewer)]
    place = f"{case['pixels_per_degree']:g}", f"{case['blur_px']:.3f}"
    return case["species"], *place, _LABELS[viewer], *numbers, *left


def _left(point: Point, viewer: str) -> tuple[float, float]:
    """Return the share of what an ideal eye sees, measured and predicted."""
    found, law = shares_kept([point], {"viewer": viewer}, {"viewer": "ideal"})
    return found.value, law


def _plot(points: list[Point], species: str) -> Plot:
    drawn = []
    for viewer in VIEWERS:
        x = [point.case["pixels_per_degree"] for point in points]
        left = [_left(point, viewer) for point in points]
        lines = x, [law for _, law in left]
        drawn.append(Curve(_LABELS[viewer], x, [share for share, _ in left], line=lines))
    caption = (
        "Parts displayed for an eye before a display, over those displayed for an ideal eye at one "
        "pixel of detail; clear air, a picture 640 pixels wide. Dashed: predicted."
    )
    title = f"What display and eye leave of {species}s"
    return curves(f"eye-{species}", title, caption, _AXIS, drawn)
