"""What does a frame of each method take at the setting of equal error?

A setting passes where, in each band of distances in which things cover ``WORTH_JUDGING`` of the
picture, their coverage and their luminance are within ``BAND_MARGIN`` of the reference's, over all
fields of a world together. Error is mean FLIP between a floor, the reference with other samples,
and a ceiling, the same world with its random objects redrawn: (FLIP − floor) ÷ (ceiling −
floor). Equal error is ``EQUAL_SHARE`` of it, or the error of the coarsest setting that passes where
that is less. Time and memory are read between the last setting within the error and the first
beyond it, along the straight line of logarithms. Beside it stands equal error by excess FLIP alone.
"""

import math
from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

import numpy as np

from bench.images.differences import PAIR_BANDS
from bench.images.equal_error import EQUAL_ERROR
from bench.methods.runner import STAGES
from bench.records.records import Key, Point, grouped
from lod.arrays import Reals
from lod.errors import InputError

READINGS = "blake", "bare", "bounded", "solid_angle", "depth", "contrast_weighted"
"""The methods that are readings of the metric; all others are its baselines."""

Rule = Literal["bands and FLIP", "FLIP alone"]
RULES: tuple[Rule, ...] = ("bands and FLIP", "FLIP alone")
"""The ways to say what equal error is; the first is that of claims that lead."""

EQUAL_SHARE = 0.2  # the share of the way from floor to ceiling at which methods are compared

BAND_MARGIN = 0.02
"""How far coverage and luminance of a band may be from the reference's, as a share."""

WORTH_JUDGING = 0.01  # bands are judged in which things cover at least this share of the picture
MARGIN = 0.05  # the share of time or memory within which methods are equivalent


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


def at_equal_error(points: Sequence[Point], rule: Rule = RULES[0]) -> dict[str, list[AtEqualError]]:
    """Find every method of one world at equal error, in each of its fields, by its name.

    Time and memory are read between the last setting within the error and the first beyond it.
    """
    found: dict[str, list[AtEqualError]] = {}
    for (method,), mine in grouped(filter(is_measured, points), "arm").items():
        passing = {setting: passes(row) for (setting,), row in grouped(mine, "setting").items()}
        for row in grouped(mine, "field").values():
            errors = [
                error(p, rule) if passing[p.case["setting"]] or rule != RULES[0] else math.inf
                for p in row
            ]
            held = next((m for m in map(megabytes, row) if math.isfinite(m)), math.nan)
            beyond = next((k for k, e in enumerate(errors) if e > level(rule)), len(row))
            near = slice(max(beyond - 1, 0), beyond + 1) if beyond else slice(0)
            seconds, between = (
                _between(row[near], errors[near], quantity, level(rule))
                for quantity in (frame_seconds, megabytes)
            )
            here = AtEqualError(seconds, between if math.isfinite(between) else held)
            found.setdefault(method, []).append(here)
    return found


def _between(
    two: Sequence[Point], errors: Sequence[float], quantity: Callable[[Point], float], wanted: float
) -> float:
    """Read a quantity at equal error, between a setting within it and one beyond, if there is."""
    if not two:
        return math.nan
    value = quantity(two[0])
    if len(two) == 1 or math.isinf(errors[1]):
        return value
    low, high = (math.log(max(each, 1e-6)) for each in errors)
    share = (math.log(wanted) - low) / (high - low)
    return math.exp((1 - share) * math.log(value) + share * math.log(quantity(two[1])))


def beside_best(
    found: dict[str, list[AtEqualError]],
    quantity: str,
    mine: str = "blake",
    others: Sequence[str] | None = None,
) -> tuple[str, np.ndarray] | None:
    """Return the best of the other methods by a quantity, and mine ÷ the best's by field.

    The best is the one with the least ``seconds`` or ``megabytes`` of those that are within the
    error in every field; without ``others`` it is one of the metric's baselines. None where there
    is none, or where mine is not within the error.
    """
    fields = max(map(len, found.values()), default=0)
    able = {
        method: np.array([getattr(each, quantity) for each in row])
        for method, row in found.items()
        if len(row) == fields and all(each.reached for each in row)
    }
    rest = {
        method: row
        for method, row in able.items()
        if method != mine and (method not in READINGS if others is None else method in others)
    }
    if not rest or mine not in able:
        return None
    best = min(rest, key=lambda method: float(np.mean(rest[method])))
    return best, able[mine] / rest[best]


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


def error(point: Point, rule: Rule = RULES[0]) -> float:
    """Return the error by a rule: between floor (0) and ceiling (1), or the excess FLIP."""
    if rule == "FLIP alone":
        return excess(point)
    reach = (point.values("flip_ceiling") / 1e6 - point.values("flip_floor") / 1e6).mean()
    return excess(point) / max(float(reach), 1e-9)


def level(rule: Rule) -> float:
    """Return the error at which methods are compared by a rule."""
    return EQUAL_SHARE if rule == RULES[0] else EQUAL_ERROR


def judged_error(points: Sequence[Point]) -> float:
    """Return the mean error of a setting over fields; infinite where a band does not pass."""
    return float(np.mean([error(p) for p in points])) if passes(points) else math.inf


def passes(points: Sequence[Point]) -> bool:
    """Tell whether coverage and luminance of every band pass, over all fields of one setting."""
    return all(
        abs(ratio - 1) <= BAND_MARGIN for row in band_ratios(points).values() for ratio in row
    )


def band_ratios(points: Sequence[Point]) -> dict[str, tuple[float, float]]:
    """Return coverage and luminance ÷ the reference's of every band that is judged, by its name.

    Luminance is the mean over pixels in which things are, of each picture by its own distances.
    """
    found = {}
    pixels = sum(float(p.values("pixels", band=band)[0]) for p in points for band in PAIR_BANDS)
    for band in PAIR_BANDS[:-1]:
        (covered, lit), (of_reference, light) = (
            [
                float(np.mean([p.values(name, picture=which, band=band).mean() for p in points]))
                for name in ("covered", "lit")
            ]
            for which in ("tested", "reference")
        )
        if of_reference * len(points) >= WORTH_JUDGING * pixels:
            brightness = lit / max(covered, 1e-9) / (light / of_reference)
            found[band] = covered / of_reference, brightness
    return found


COSTS: dict[str, tuple[str, Callable[[Point], float], str]] = {
    "time": ("seconds", frame_seconds, "seconds of a frame, all stages"),
    "memory": ("megabytes", megabytes, "most that a process holds (MB)"),
}
"""What is compared: its name at equal error, that of a point, and an axis."""
