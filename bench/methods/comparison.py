"""What does a frame of each arm take at the setting of equal error?

Between two settings, time and memory are read along the straight line of logarithms against the
excess FLIP. An arm without a setting, or one whose coarsest setting is within the error, is taken
as it is. An arm that leaves out what little the eye would miss on the average, but nearly all that
stands far away, is not within the error: of the pixels that things cover in each band of distances
it must cover at least ``LEAST_COVERED``.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.images.compare import PAIR_BANDS
from bench.images.equal_error import EQUAL_ERROR, excesses
from bench.records.records import Point, grouped
from lod.errors import InputError

READINGS = "blake", "bounded", "solid_angle", "depth"
"""The arms that are readings of the metric; all others are its rivals."""

LEAST_COVERED = 0.5
"""The least share of what covers a band of distances that an arm may draw."""

WORTH_COUNTING = 0.002
"""Bands are judged in which things cover at least this share of the picture."""

STAGES = "update", "describe", "build", "trace"
"""The stages of a frame that are timed: pruned and posed, described, built, traced."""


@dataclass(frozen=True)
class AtEqualError:
    """One arm in one field at equal error.

    seconds   of a frame by the clock, all stages; NaN where no setting is within the error
    megabytes the most that a process held, at the nearest setting where it is known of one alone
    """

    seconds: float
    megabytes: float

    @property
    def reached(self) -> bool:
        """Whether any setting is within the error."""
        return math.isfinite(self.seconds)


def at_equal_error(points: Sequence[Point]) -> dict[str, list[AtEqualError]]:
    """Find every arm of one window at equal error, in each of its fields, by the arm's name."""
    found: dict[str, list[AtEqualError]] = {}
    for (arm, _), row in _rows(points).items():
        found.setdefault(arm, []).append(_of_field(row))
    return found


def at_equal_time(points: Sequence[Point]) -> dict[str, list[float]]:
    """Find every arm's excess FLIP in the time that the metric takes at equal error, by field.

    It is NaN where the metric itself is never within the error, and where every timed setting of
    the arm takes longer. Where every one takes less time it is that of the slowest.
    """
    ours = {
        field: _of_field(row).seconds
        for (arm, field), row in _rows(points).items()
        if arm == "blake"
    }
    found: dict[str, list[float]] = {}
    for (arm, field), row in _rows(points).items():
        found.setdefault(arm, []).append(_excess_within(row, ours.get(field, math.nan)))
    return found


def best_rival(found: dict[str, list[AtEqualError]], quantity: str) -> str | None:
    """Return the rival with the least of a quantity, of those that are within the error everywhere.

    ``quantity`` is ``seconds`` or ``megabytes``. None where there is no such rival.
    """
    fields = max(map(len, found.values()), default=0)
    able = {
        arm: float(np.mean([getattr(each, quantity) for each in row]))
        for arm, row in found.items()
        if arm not in READINGS and len(row) == fields and all(each.reached for each in row)
    }
    return min(able, key=able.__getitem__) if able else None


def beside_best_rival(
    found: dict[str, list[AtEqualError]], quantity: str
) -> tuple[str, np.ndarray] | None:
    """Return the best rival by a quantity, and the metric's quantity ÷ the rival's by field.

    None where there is no such rival, or where the metric is not within the error everywhere.
    """
    rival, mine = best_rival(found, quantity), found.get("blake", [])
    if rival is None or not mine or not all(each.reached for each in mine):
        return None
    ours, theirs = ([getattr(each, quantity) for each in row] for row in (mine, found[rival]))
    return rival, np.array(ours) / np.array(theirs)


def frame_seconds(point: Point) -> float:
    """Return the median time of a frame, all stages [s]; NaN where it was not timed."""
    try:
        stages = [point.values("us", stage=each) for each in STAGES]
    except InputError:
        return math.nan
    return float(np.median(np.sum(stages, axis=0))) / 1e6


def is_measured(point: Point) -> bool:
    """Tell whether a point has errors: one of a window that has a whole picture, and fits."""
    return "part" not in point.case and any(each.quantity == "flip" for each in point.samples)


def least_covered(point: Point) -> float:
    """Return the least share of what covers a band that is still covered; 1 where nothing is."""
    shares = [1.0]
    pixels = sum(point.values("pixels", band=band)[0] for band in PAIR_BANDS)
    for band in PAIR_BANDS[:-1]:
        tested, whole = (
            float(point.values("covered", picture=picture, band=band).mean())
            for picture in ("tested", "reference")
        )
        if whole >= WORTH_COUNTING * pixels:
            shares.append(tested / whole)
    return min(shares)


def judged_error(point: Point) -> float:
    """Return the mean excess FLIP; infinite where a band is covered by less than it must be."""
    return excess(point) if least_covered(point) >= LEAST_COVERED else math.inf


def excess(point: Point) -> float:
    """Return the mean excess FLIP over the pairs of seeds."""
    return float(excesses(point).mean())


def megabytes(point: Point) -> float:
    """Return the memory of a process at this setting [MB]; NaN where it was not measured."""
    try:
        return point.column("peak_bytes")[0] / 1e6
    except InputError:
        return math.nan


def _rows(points: Sequence[Point]) -> dict[tuple[Any, ...], list[Point]]:
    return grouped([point for point in points if is_measured(point)], "arm", "field")


def _excess_within(row: Sequence[Point], seconds: float) -> float:
    """Read the excess at a time along the straight line of logarithms between two settings."""
    timed = sorted((t, excess(p)) for p in row if math.isfinite(t := frame_seconds(p)))
    if not timed or not timed[0][0] <= seconds:
        return math.nan
    slower = next((k for k, (t, _) in enumerate(timed) if t > seconds), len(timed))
    if slower == len(timed):
        return timed[-1][1]
    (before, worse), (after, better) = timed[slower - 1 : slower + 1]
    share = math.log(seconds / before) / math.log(after / before)
    low, high = (math.log(max(each, 1e-6)) for each in (worse, better))
    return math.exp((1 - share) * low + share * high)


def _of_field(row: Sequence[Point]) -> AtEqualError:
    """Read time and memory between the last setting within the error and the first beyond it."""
    held = next((m for m in map(megabytes, row) if math.isfinite(m)), math.nan)
    beyond = next((k for k, p in enumerate(row) if judged_error(p) > EQUAL_ERROR), len(row))
    if beyond == 0:
        return AtEqualError(math.nan, held)
    two = row[beyond - 1 : beyond + 1]
    between = _at(two, frame_seconds), _at(two, megabytes)
    return AtEqualError(between[0], between[1] if math.isfinite(between[1]) else held)


def _at(two: Sequence[Point], quantity: Callable[[Point], float]) -> float:
    """Read a quantity at equal error, between a setting within it and one beyond, if there is."""
    value = quantity(two[0])
    if len(two) == 1 or excess(two[1]) <= EQUAL_ERROR:
        return value
    low, high = (math.log(max(excess(each), 1e-6)) for each in two)
    share = (math.log(EQUAL_ERROR) - low) / (high - low)
    return math.exp((1 - share) * math.log(value) + share * math.log(quantity(two[1])))
