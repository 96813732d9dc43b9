"""What does a frame of each arm take at the setting of equal error?

Between two settings, time is read along the straight line of logarithms against the excess FLIP. An
arm without a setting, or one whose coarsest setting is within the error, is taken as it is.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.experiments.fidelity.equal_error import EQUAL_ERROR, excesses
from bench.records.points import Point, grouped
from lod.errors import InputError

READINGS = "blake", "bounded", "solid_angle", "depth"
"""The arms that are readings of the metric; all others are its rivals."""

STAGES = "update", "describe", "build", "trace"
"""The stages of a frame that are timed: pruned and posed, described, built, traced."""


@dataclass(frozen=True)
class AtEqualError:
    """One arm in one field at equal error.

    seconds   of a frame by the clock, all stages; NaN where no setting is within the error
    megabytes the most that a process held at the setting nearest to equal error
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
    for (arm, _), row in grouped(points, "arm", "field").items():
        found.setdefault(arm, []).append(_of_field(row))
    return found


def best_rival(found: dict[str, list[AtEqualError]], quantity: str) -> str | None:
    """Return the rival with the least of a quantity, of those that are within the error everywhere.

    ``quantity`` is ``seconds`` or ``megabytes``. None where there is no such rival.
    """
    able = {
        arm: float(np.mean([getattr(each, quantity) for each in row]))
        for arm, row in found.items()
        if arm not in READINGS and all(each.reached for each in row)
    }
    return min(able, key=able.__getitem__) if able else None


def frame_seconds(point: Point) -> float:
    """Return the median time of a frame, all stages [s]; NaN where it was not timed."""
    try:
        stages = [point.values("us", stage=each) for each in STAGES]
    except InputError:
        return math.nan
    return float(np.median(np.sum(stages, axis=0))) / 1e6


def excess(point: Point) -> float:
    """Return the mean excess FLIP over the pairs of seeds."""
    return float(excesses(point).mean())


def megabytes(point: Point) -> float:
    """Return the memory of a process at this setting [MB]; NaN where it was not measured."""
    try:
        return point.column("peak_bytes")[0] / 1e6
    except InputError:
        return math.nan


def _of_field(row: Sequence[Point]) -> AtEqualError:
    """Read time between the last setting within the error and the first beyond it."""
    held = next((m for m in map(megabytes, row) if math.isfinite(m)), math.nan)
    within = [k for k, point in enumerate(row) if excess(point) <= EQUAL_ERROR]
    if not within or 0 not in within:
        return AtEqualError(math.nan, held)
    last = next((k for k in range(len(row)) if k not in within), len(row)) - 1
    seconds = frame_seconds(row[last])
    if last + 1 < len(row):
        nearer, farther = excess(row[last]), excess(row[last + 1])
        low, high = math.log(max(nearer, 1e-6)), math.log(farther)
        share = (math.log(EQUAL_ERROR) - low) / (high - low)
        beyond = frame_seconds(row[last + 1])
        seconds = math.exp((1 - share) * math.log(seconds) + share * math.log(beyond))
    return AtEqualError(seconds, held)
