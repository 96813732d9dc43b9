"""What does a frame of each method take at the setting of equal error?

Between two settings, time and memory are read along the straight line of logarithms against the
excess FLIP. A method without a setting, or one whose coarsest setting is within the error, is taken
as it is. A method that leaves out what little the eye would miss on the average, but nearly all
that stands far away, is not within the error: of the pixels that things cover in each band of
distances it must cover at least ``LEAST_COVERED``.
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from bench.images.differences import PAIR_BANDS
from bench.images.equal_error import EQUAL_ERROR
from bench.methods.runner import STAGES
from bench.records.records import Key, Point, grouped
from lod.arrays import Reals
from lod.errors import InputError

READINGS = "blake", "bounded", "solid_angle", "depth"
"""The methods that are readings of the metric; all others are its baselines."""

LEAST_COVERED = 0.5
"""The least share of what covers a band of distances that a method may draw."""

WORTH_COUNTING = 0.002
"""Bands are judged in which things cover at least this share of the picture."""


class AtEqualError(NamedTuple):
    """One method in one field at equal error.

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
    """Find every method of one window at equal error, in each of its fields, by its name.

    Time and memory are read between the last setting within the error and the first beyond it.
    """
    found: dict[str, list[AtEqualError]] = {}
    for (method, _), row in grouped(filter(is_measured, points), "arm", "field").items():
        held = next((m for m in map(megabytes, row) if math.isfinite(m)), math.nan)
        beyond = next((k for k, p in enumerate(row) if judged_error(p) > EQUAL_ERROR), len(row))
        two = row[max(beyond - 1, 0) : beyond + 1] if beyond else []
        seconds, between = _between(two, frame_seconds), _between(two, megabytes)
        here = AtEqualError(seconds, between if math.isfinite(between) else held)
        found.setdefault(method, []).append(here)
    return found


def _between(two: Sequence[Point], quantity: Callable[[Point], float]) -> float:
    """Read a quantity at equal error, between a setting within it and one beyond, if there is."""
    if not two:
        return math.nan
    value = quantity(two[0])
    if len(two) == 1 or excess(two[1]) <= EQUAL_ERROR:
        return value
    low, high = (math.log(max(excess(each), 1e-6)) for each in two)
    share = (math.log(EQUAL_ERROR) - low) / (high - low)
    return math.exp((1 - share) * math.log(value) + share * math.log(quantity(two[1])))


def beside_best_baseline(
    found: dict[str, list[AtEqualError]], quantity: str
) -> tuple[str, np.ndarray] | None:
    """Return the best baseline by a quantity, and the metric's ÷ the baseline's by field.

    The best is the one with the least ``seconds`` or ``megabytes`` of those that are within the
    error in every field. None where there is none, or where the metric is not within the error.
    """
    fields = max(map(len, found.values()), default=0)
    able = {
        method: np.array([getattr(each, quantity) for each in row])
        for method, row in found.items()
        if len(row) == fields and all(each.reached for each in row)
    }
    baselines = {method: row for method, row in able.items() if method not in READINGS}
    if not baselines or "blake" not in able:
        return None
    best = min(baselines, key=lambda method: float(np.mean(baselines[method])))
    return best, able["blake"] / baselines[best]


def optional(point: Point, quantity: str, **keys: Key) -> Reals:
    """Return a column of millionths in its unit; of a column that is missing, one NaN."""
    try:
        return point.values(quantity, **keys) / 1e6
    except InputError:
        return np.array([math.nan])


def frame_seconds(point: Point) -> float:
    """Return the median time of a frame, all stages [s]; NaN where it was not timed."""
    return float(np.median(np.sum([optional(point, "us", stage=s) for s in STAGES], axis=0)))


def megabytes(point: Point) -> float:
    """Return the memory of a process at this setting [MB]; NaN where it was not measured."""
    return float(optional(point, "peak_bytes")[0])


def is_measured(point: Point) -> bool:
    """Tell whether a point has errors: one of a window that has a reference, and fits."""
    return "part" not in point.case and any(each.quantity == "flip" for each in point.samples)


def excess(point: Point) -> float:
    """Return the mean excess FLIP over the pairs of seeds."""
    return float((point.values("flip") / 1e6 - point.values("flip_floor") / 1e6).mean())


def judged_error(point: Point) -> float:
    """Return the mean excess FLIP; infinite where a band is covered by less than it must be."""
    return excess(point) if least_covered(point) >= LEAST_COVERED else math.inf


def least_covered(point: Point) -> float:
    """Return the least share of what covers a band that is still covered; 1 where nothing is."""
    shares = [1.0]
    pixels = sum(point.values("pixels", band=band)[0] for band in PAIR_BANDS)
    for band in PAIR_BANDS[:-1]:
        tested, reference = (
            float(point.values("covered", picture=picture, band=band).mean())
            for picture in ("tested", "reference")
        )
        if reference >= WORTH_COUNTING * pixels:
            shares.append(tested / reference)
    return min(shares)
