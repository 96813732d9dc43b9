"""What the spectrum experiment shows: power against frequency, and a table."""

from itertools import pairwise

import numpy as np

from bench.experiment import Table
from bench.experiments.spectrum.claims import EDGES, octaves
from bench.plots import Curve, Plot, curves
from bench.records.records import Point, Record

_MIDDLES = [float(np.sqrt(a * b)) for a, b in pairwise(EDGES)]
_NAMES = {"whole": "unpruned", "pruned": "pruned", "lost": "difference"}
_LEAST = 1e-12


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw a plot for every detail."""
    return tuple(_plot(record, point) for point in record.points)


def point_table(record: Record) -> Table:
    """Return the heads and rows of a table: power in every octave."""
    heads = ("τ (px)", "cut-off (cycles/px)", "from", "to", *_NAMES.values())
    return heads, [row for point in record.points for row in _rows(point)]


def _rows(point: Point) -> list[tuple[str, ...]]:
    columns = [octaves(point, name) for name in _NAMES]
    place = f"{point.case['detail']:g}", f"{point.prediction('cutoff'):g}"
    return [
        (*place, f"{EDGES[k]:g}", f"{EDGES[k + 1]:g}", *(f"{each[k]:.3g}" for each in columns))
        for k in range(len(EDGES) - 1)
    ]


def _plot(record: Record, point: Point) -> Plot:
    detail, cutoff = point.case["detail"], point.prediction("cutoff")
    drawn = [
        Curve(label, _MIDDLES, np.maximum(octaves(point, name), _LEAST).tolist())
        for name, label in _NAMES.items()
    ]
    ends = [min(min(each.y) for each in drawn), max(max(each.y) for each in drawn)]
    drawn.append(Curve("cut-off 1/(2τ)", [cutoff, cutoff], ends))
    told = " ".join(
        f"{c.about} {c.quantity}: {c.measured:.3f}: {c.verdict}."
        for c in record.claims
        if c.name.endswith(f"tau_{detail:g}px")
    )
    caption = (
        f"Power of pictures of albedo by octave of frequency, unpruned, pruned at τ = {detail:g} "
        f"px, and their difference. {told}"
    )
    axis = "frequency (cycles per pixel)", "power in the octave"
    title = f"Is pruning a low-pass filter? τ = {detail:g} px"
    return curves(f"spectrum-{detail:g}", title, caption, axis, drawn)
