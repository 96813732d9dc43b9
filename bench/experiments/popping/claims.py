"""What the popping experiment claims, judged from its raw counts alone."""

import numpy as np

from bench.records.claims import Claim
from bench.records.old_claims import claim, verification
from bench.records.records import Point, where
from bench.statistics.estimates import (
    two_sided_mean,
    two_sided_paired_ratio,
    two_sided_quantile,
    two_sided_ratio,
)
from lod.arrays import Reals

WAYS = {
    "unpruned": ("view.metric=full",),
    "fading": ("view.fade=0.2",),
    "clipped": ("view.fade=0.0",),
}
"""The ways to prune a walk, and the settings of each."""

QUANTILES = (0.99, 0.999, 0.9999)
SWITCHED = "switched"
"""Columns of what motion does not explain; frames have the same samples, so there is no noise."""

UNEXPLAINED_BY_MOTION = 0.01
"""How much of white motion may leave unexplained where nothing is pruned."""

_PLANTED = "clipped"
"""The way that is meant to pop, which shows that the test finds popping."""

_SOURCE = "§1.2"


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Claim switches and their sizes against the law, and what fading leaves of popping."""
    counted = where(points, what="switches")
    walks = {p.case["way"]: p for p in where(points, what="walk")}
    made = [each for point in counted for each in (_law(point), _size(point))]
    return (*made, *(_popped(walks[way]) for way in ("fading", "clipped")), *_residuals(walks))


def _law(point: Point) -> Claim:
    counts = point.values("switches")
    predicted = np.full(len(counts), point.prediction("switches"))
    species = point.case["species"]
    about = f"As many parts of {species}s switch in a step as the law predicts, nothing fitted."
    words = about, "switches, measured ÷ predicted", "§4.1"
    found = two_sided_ratio(counts, predicted)
    return verification(claim(f"blake/{species}/switches", words, 1.0, 0.1, found))


def _size(point: Point) -> Claim:
    species = point.case["species"]
    about = f"A part of a {species} is no larger than τ = 1 px when it switches."
    words = about, "95th percentile of P ÷ (d·θ) at the switch (px)", "§2.4"
    sizes = point.values("size_mpx") / 1000
    found = two_sided_quantile(sizes, 0.95)
    return verification(claim(f"blake/{species}/size", words, 1.0, 0, found, "at most"))


def _popped(point: Point) -> Claim:
    way = point.case["way"]
    about = f"No part comes or goes at more than half its size: {way}."
    words = about, "parts popped between two frames", _SOURCE
    found = two_sided_mean(point.values("popped"))
    return claim(f"walk/{way}/popped", words, 0, 0, found, "at most", way == _PLANTED)


def _residuals(walks: dict[str, Point]) -> list[Claim]:
    """Claim that motion explains an unpruned walk, and that fading leaves less than clipping."""
    found = two_sided_mean(_worst(walks["unpruned"]) / 1e6)
    about = "Where nothing is pruned, motion explains what changes."
    words = about, "99.99th percentile of what it does not, of white", _SOURCE
    name, most = "walk/unpruned/switched", UNEXPLAINED_BY_MOTION
    made = [verification(claim(name, words, most, 0, found, "at most"))]
    found = two_sided_paired_ratio(*(_worst(walks[way]) for way in ("fading", "clipped")))
    quantity = "99.99th percentile of what motion does not explain, fading ÷ clipping"
    for name, most, about in (
        ("better", 1.0, "Fading leaves less of a switch than clipping does."),
        ("switched", 0.5, "What switches at once is less than half of that of clipping."),
    ):
        words = about, quantity, _SOURCE
        made.append(claim(f"walk/fading/{name}", words, most, 0, found, "at most"))
    return made


def _worst(point: Point) -> Reals:
    """Return the largest changes of every walk, at the highest quantile [10⁻⁶ of white]."""
    return point.values(SWITCHED, quantile=QUANTILES[-1])
