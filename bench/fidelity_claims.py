"""What the fidelity experiment claims, judged from its raw samples alone."""

import math
from collections.abc import Sequence

import numpy as np

from bench.claims import Claim, claim
from bench.excess_flip import FLOOR
from bench.fidelity_measure import BANDS
from bench.fidelity_scene import GROUND, PIECES, PIECES_DETAIL, SPECIES
from bench.records import Point
from bench.statistics import CONFIDENCE, Estimate, mean
from lod.arrays import Ints, Reals

EQUAL_ERROR = 0.01
"""The excess FLIP at which metrics are compared."""

JUDGED_AT_PX = 1.0
FEWEST_PIXELS = 30
_QUOTED = SPECIES, GROUND, "everything"
_DRAWS = 400
_SOURCE = "§2.4, issue 6"


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Every claim that these points decide."""
    made: list[Claim] = []
    for view, chosen in by_view(points).items():
        name = view.replace(" ", "_")
        made.append(_floor(name, view, chosen[0]))
        at = [p for p in chosen if p.case["detail"] == JUDGED_AT_PX]
        made += [_excess(name, p) for p in at if p.case["pruned"] in _QUOTED]
        made += [_luminance(name, p, b) for p in at for b in BANDS[:-1] if _any_light(p, b)]
        made += _rivals(name, view, chosen)
    return tuple(made)


def _any_light(point: Point, band: str) -> bool:
    enough = point.samples[f"pixels {band}"][0] >= FEWEST_PIXELS
    return point.case["pruned"] == "everything" and enough


def by_view(points: Sequence[Point]) -> dict[str, list[Point]]:
    """Points of every view, in the order they come."""
    views: dict[str, list[Point]] = {}
    for point in points:
        views.setdefault(point.case["view"], []).append(point)
    return views


def curve(points: Sequence[Point], metric: str) -> list[Point]:
    """The species pruned by a metric, from the finest detail to the coarsest."""
    mine = [p for p in points if p.case["metric"] == metric and p.case["pruned"] == SPECIES]
    return sorted(mine, key=lambda p: p.case["detail"])


def pieces(points: Sequence[Point]) -> list[Point]:
    """What its pieces cost, each pruned alone."""
    at = [p for p in points if p.case["detail"] == PIECES_DETAIL]
    return [p for p in at if p.case["pruned"] in (*PIECES, GROUND)]


def excesses(point: Point) -> Reals:
    """Excess FLIP of every pair of seeds, (pairs,)."""
    return column(point, "flip") - column(point, "flip_floor")


def column(point: Point, name: str) -> Reals:
    """A sample of every pair, out of millionths."""
    return np.array(point.samples[name], np.float64) / 1e6


def reached(
    points: Sequence[Point], pairs: Ints, error: float = EQUAL_ERROR
) -> tuple[float, float]:
    """τ [px] and number of parts at which the excess comes up to an error, over some pairs.

    Between two details along straight lines of their logarithms; NaN where it is never there.
    """
    found = np.maximum([excesses(p)[pairs].mean() for p in points], 1e-6)
    for k in range(1, len(points)):
        if found[k - 1] <= error < found[k]:
            low, high = np.log(found[[k - 1, k]])
            share = (math.log(error) - low) / (high - low)
            ends = [(p.case["detail"], p.samples["parts"][0]) for p in points[k - 1 : k + 1]]
            return tuple(
                float(v) for v in np.exp((1 - share) * np.log(ends[0]) + share * np.log(ends[1]))
            )  # type: ignore[return-value]
    return math.nan, math.nan


def _floor(name: str, view: str, point: Point) -> Claim:
    about = f"The noise of the {view} view is low enough to quote an excess over it."
    words = about, "FLIP of the reference against itself with another seed", "issue 6"
    return claim(f"floor/{name}", words, FLOOR, 0, mean(column(point, "flip_floor")), "at most")


def _excess(name: str, point: Point) -> Claim:
    metric, pruned = point.case["metric"], point.case["pruned"]
    about = f"As good as whole by {metric} at one pixel, {point.case['view']}; pruned: {pruned}."
    words = about, "excess FLIP, 67 pixels per degree", _SOURCE
    which = f"{metric}/{name}/excess_{pruned}"
    return claim(which, words, EQUAL_ERROR, 0, mean(excesses(point)), "at most")


def _luminance(name: str, point: Point, band: str) -> Claim:
    share = column(point, f"tested {band}") / column(point, f"reference {band}")
    about = f"Pruning by blake at one pixel keeps the light {band}, {point.case['view']}."
    words = about, "mean luminance ÷ the reference's", _SOURCE
    which = band.replace(" ", "_")
    return claim(f"blake/{name}/luminance_{which}", words, 1.0, 0.02, mean(share))


def _rivals(name: str, view: str, points: Sequence[Point]) -> list[Claim]:
    """Does the default metric need the fewest parts at equal error? Over resampled pairs."""
    made, ours = [], curve(points, "blake")
    for rival in dict.fromkeys(p.case["metric"] for p in points):
        theirs = curve(points, rival)
        if rival == "blake" or not (ours and theirs):
            continue
        ratio = _resampled(ours, theirs)
        if ratio is not None:
            about = f"At equal error blake needs no more parts than {rival}, {view}."
            words = about, f"parts by blake ÷ parts by {rival} at excess FLIP 0.01", _SOURCE
            made.append(claim(f"{rival}/{name}/parts", words, 1.0, 0, ratio, "at most"))
    return made


def _resampled(ours: Sequence[Point], theirs: Sequence[Point]) -> Estimate | None:
    """Ratio of parts, with the percentiles of a bootstrap over pairs; None where either is never
    there."""
    pairs = np.arange(len(ours[0].samples["flip"]))
    rng = np.random.Generator(np.random.Philox(0))
    draws = [pairs, *(rng.choice(pairs, len(pairs)) for _ in range(_DRAWS))]
    found = np.array([reached(ours, k)[1] / reached(theirs, k)[1] for k in draws])
    if not np.isfinite(found).all():
        return None
    low, high = np.quantile(found[1:], [(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2])
    value = float(found[0])
    spread = float(found[1:].std(ddof=1))
    return Estimate(value, min(float(low), value), max(float(high), value), spread, 1.0, len(pairs))
