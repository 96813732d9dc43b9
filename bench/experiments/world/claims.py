"""What the world experiment claims, judged from its points alone (§4.1)."""

from collections.abc import Sequence

import numpy as np

from bench.records.claims import Claim
from bench.records.old_claims import claim, verification
from bench.records.records import Point, where
from bench.statistics.estimates import Estimate, exactly, two_sided_median
from bench.statistics.fits import fit_exponent

_LAW = "§4.1"
_CLEAR = 2.5
"""The side, in limit distances, from which on a world is beyond the limit.

The eye is in the middle, and whoever walks may come from a little further.
"""


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Return every claim that these points decide."""
    beyond = beyond_limit(points)
    unpruned = where(points, metric="full")
    return (*_of_pruned(beyond), *_of_everything(unpruned, beyond[-1]))


def _of_pruned(beyond: list[Point]) -> tuple[Claim, ...]:
    """Claim what holds of every world that reaches beyond the limit."""
    hashes = float(len({p.case["scene"] for p in beyond}))
    same = "The frame is the same, bit for bit, in every world larger than the limit."
    longer = "A larger world takes no longer, once it is larger than the limit."
    equal = same, "different scenes among them", _LAW
    slope = longer, "exponent of time against objects", _LAW
    return (
        verification(claim("world/same_scene", equal, 1.0, 0.0, exactly(hashes, len(beyond)))),
        verification(claim("world/seconds/slope", slope, 0.0, 0.01, power_of_worlds(beyond))),
    )


def _of_everything(unpruned: list[Point], last: Point) -> tuple[Claim, ...]:
    """Claim what everything costs, beside what is displayed of the largest world, ``last``."""
    largest = unpruned[-1]
    saved = two_sided_median(seconds(largest) / float(np.median(seconds(last))))
    about = (
        f"Every object of a world of {largest.case['objects']:.0e} takes longer than what "
        f"is displayed of one of {last.case['objects']:.0e}."
    )
    longer = about, "1 ÷ how many times as long", _LAW
    about = "Unpruned, every object adds its time."
    added = about, "exponent of added time against added parts", _LAW
    return (
        claim("full/seconds/slope", added, 1.0, 0.1, power_of_parts(unpruned)),
        claim("full/over_pruned", longer, 1.0, 0.0, _inverse(saved), "at most"),
    )


def beyond_limit(points: Sequence[Point]) -> list[Point]:
    """Return the pruned worlds that reach beyond the limit distance on all sides."""
    return [
        p
        for p in points
        if p.case["metric"] != "full" and p.case["side_m"] > _CLEAR * p.case["limit_m"]
    ]


def seconds(point: Point, column: str = "cpu_us") -> np.ndarray:
    """Return the CPU seconds of every repeat, or another column in millionths."""
    return point.values(column) / 1e6


def power_of_worlds(points: Sequence[Point], column: str = "cpu_us") -> Estimate:
    """Estimate the exponent of time, or of another column, against objects.

    Each repeat is a share of its own round of all worlds.
    """
    rounds = np.array([seconds(p, column) for p in points])
    x = np.array([float(p.case["objects"]) for p in points])
    return fit_exponent(np.repeat(x, rounds.shape[1]), (rounds / rounds.mean(axis=0)).ravel())


def power_of_parts(points: list[Point]) -> Estimate:
    """Estimate the exponent of added time against added parts, from the smallest world on.

    Ground and camera take time in an empty world, too.
    """
    return fit_exponent(*added_by_parts(points))


def added_by_parts(
    points: Sequence[Point], column: str = "cpu_us", by: str = "parts"
) -> tuple[np.ndarray, np.ndarray]:
    """Return the parts beyond those of the smallest world, and the time they add [s].

    There is a value for every repeat that takes longer; other columns may be named.
    """
    parts = np.array([float(p.column(by)[0]) for p in points])
    rounds = np.array([seconds(p, column) for p in points])
    added = (rounds[1:] - np.median(rounds[0])).ravel()
    x = np.repeat(parts[1:] - parts[0], rounds.shape[1])
    return x[added > 0], added[added > 0]


def _inverse(found: Estimate) -> Estimate:
    return Estimate(1 / found.value, 1 / found.high, 1 / found.low, 0.0, 1.0, found.rows)
