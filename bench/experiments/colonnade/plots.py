"""What the colonnade shows: sizes and errors column by column, and a table."""

import numpy as np

from bench.experiment import Table
from bench.experiments.colonnade.claims import MIDDLE, columns
from bench.experiments.colonnade.scene import image_width
from bench.plots import Curve, Plot, curves
from bench.records.records import Key, Point, Record

_AXIS = "place of the column, to the right of the axis (m)"
_LEAST = 1e-4
"""The value at which an error of 0 is drawn: the axis is logarithmic."""


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw sizes, then errors at 8 px by both metrics and by depth with as many parts."""
    return _sizes(record), _errors(record)


def point_table(record: Record) -> Table:
    """Return a table: every column of every cut, its left half mirrored by its right."""
    heads = ("metric", "detail (px)", "place (m)", "pixels", "solid angle (msr)", "parts")
    rows = [_row(point) for point in record.points if point.case["column"] >= MIDDLE]
    return (*heads, "error in the image (%)", "error at the eye (%)"), rows


def _row(point: Point) -> tuple[str, ...]:
    case = point.case
    return (
        *(case["metric"], f"{case['detail']:g}", f"{case['aside']:g}"),
        *(f"{_mean(point, 'pixels'):.0f}", f"{_mean(point, 'solid_angle_usr') / 1000:.2f}"),
        str(point.column("parts")[0]),
        *(f"{_mean(point, 'error_ppm', weight=k) / 1e4:.2f}" for k in ("image", "eye")),
    )


def _mean(point: Point, name: str, **keys: Key) -> float:
    return float(np.mean(point.column(name, **keys)))


def _sizes(record: Record) -> Plot:
    row = columns(record.points, ("blake", 8.0))
    x = [point.case["aside"] for point in row]
    names = {
        "width of the image": "shaft_mpx",
        "area of the image": "pixels",
        "solid angle": "solid_angle_usr",
    }
    drawn = []
    for label, name in names.items():
        y = np.array([_mean(point, name) for point in row])
        law = [image_width(each) / image_width(0.0) for each in x] if name == "shaft_mpx" else []
        line = x[: len(law)], law
        drawn.append(Curve(label, x, (y / y[MIDDLE]).tolist(), line=line))
    caption = (
        "Equal columns in a row parallel to the picture plane, 12 m from the eye. To the side "
        "their images grow and the solid angles that they subtend shrink: outermost ÷ middle is "
        + ", ".join(f"{each.y[-1]:.2f} for the {each.label}" for each in drawn)
        + ". Dashed: the width that perspective gives a shaft."
    )
    axis = _AXIS, "÷ that of the middle column"
    return curves("sizes", "Leonardo's columns", caption, axis, drawn, ("linear", "log"))


def _errors(record: Record) -> Plot:
    drawn = []
    for which in (("blake", 8.0), ("depth", 8.0), ("depth", 12.0)):
        row = columns(record.points, which)
        y = [max(_mean(point, "error_ppm", weight="image") / 1e6, _LEAST) for point in row]
        parts = sum(point.column("parts")[0] for point in row)
        label = f"{which[0]}, {which[1]:g} px: {parts} parts"
        drawn.append(Curve(label, [point.case["aside"] for point in row], y))
    words = "; ".join(
        f"{each.label}, {100 * each.y[MIDDLE]:.1f} % in the middle and {100 * each.y[-1]:.1f} % "
        "at the right end"
        for each in drawn
    )
    caption = (
        f"Mean difference of luminance between the pruned picture and the whole one, over the "
        f"pixels of each column, as a share of its luminance. {words}."
    )
    axis = _AXIS, "error in the image"
    return curves("errors", "Which columns suffer", caption, axis, drawn, ("linear", "log"))
