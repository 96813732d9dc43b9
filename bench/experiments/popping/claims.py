"""What the popping experiment claims, judged from its raw counts alone."""

import numpy as np

from bench.records.claims import Claim, claim
from bench.records.records import Point
from bench.statistics.estimates import mean, paired_ratio, quantile, ratio

WAYS = {
    "unpruned": ("view.metric=full",),
    "fading": ("view.fade=0.2",),
    "clipped": ("view.fade=0.0",),
}
"""How a walk is pruned, and the settings that say so."""

WORST, SWITCHED = "unexplained 0.9999", "switched 0.9999"
"""Of what motion does not explain: with samples of its own in each frame, and with the same."""

_PLANTED = "clipped"
"""The way that is there to pop, so that the test is seen to find it."""

_SOURCE = "§1.2, issue 6"


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Switches against the law; their size; and what fading leaves of popping."""
    counted = [p for p in points if p.case["what"] == "switches"]
    walks = {p.case["way"]: p for p in points if p.case["what"] == "walk"}
    made = [each for point in counted for each in (_law(point), _size(point))]
    return (*made, *(_popped(walks[way]) for way in ("fading", "clipped")), *_residuals(walks))


def _law(point: Point) -> Claim:
    counts = np.array(point.samples["switches"], np.float64)
    predicted = np.full(len(counts), point.predicted["switches"])
    species = point.case["species"]
    about = f"As many parts of {species}s switch in a step as the law predicts, nothing fitted."
    words = about, "switches, measured ÷ predicted", "§4.1"
    return claim(f"blake/{species}/switches", words, 1.0, 0.1, ratio(counts, predicted))


def _size(point: Point) -> Claim:
    species = point.case["species"]
    about = f"A part of a {species} is no larger than τ = 1 px when it switches."
    words = about, "95th percentile of P ÷ (d·θ) at the switch (px)", "§2.4"
    sizes = np.array(point.samples["size_mpx"], np.float64) / 1000
    return claim(f"blake/{species}/size", words, 1.0, 0, quantile(sizes, 0.95), "at most")


def _popped(point: Point) -> Claim:
    way = point.case["way"]
    about = f"No part comes or goes at more than half its size: {way}."
    words = about, "parts popped between two frames", _SOURCE
    found = mean(np.array(point.samples["popped"], np.float64))
    return claim(f"walk/{way}/popped", words, 0, 0, found, "at most", way == _PLANTED)


def _residuals(walks: dict[str, Point]) -> list[Claim]:
    whole, made = np.array(walks["unpruned"].samples[WORST], np.float64), []
    for way in ("fading", "clipped"):
        about = f"The largest changes that motion does not explain are those of no pruning: {way}."
        words = about, "99.99th percentile ÷ that of the unpruned walk", _SOURCE
        found = paired_ratio(np.array(walks[way].samples[WORST], np.float64), whole)
        name = f"walk/{way}/residual"
        made.append(claim(name, words, 1.1, 0, found, "at most", way == _PLANTED))
    both = (np.array(walks[way].samples[SWITCHED], np.float64) for way in ("fading", "clipped"))
    about = "What switches at once, all noise left out, is less than half of that of clipping."
    words = about, "99.99th percentile with the same samples, fading ÷ clipping", _SOURCE
    made.append(claim("walk/fading/switched", words, 0.5, 0, paired_ratio(*both), "at most"))
    return made
