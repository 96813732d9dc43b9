"""What the rivals experiment claims, judged from its raw errors, times and bytes alone."""

import numpy as np

from bench.experiments.rivals.equal_error import AtEqualError, at_equal_error, best_rival
from bench.records.claims import Claim, claim
from bench.records.points import Point, grouped
from bench.statistics.estimates import two_sided_factor

_SOURCE = "§4.1, derived: docs/method.md"
_WORDS = {"seconds": "time", "megabytes": "memory"}


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Claim, for every kind and size of world, that the metric's frame costs less than rivals'."""
    made = []
    for (kind, objects), window in grouped(points, "kind", "objects").items():
        found = at_equal_error(window)
        for quantity in _WORDS:
            made += _cheaper(f"{kind}/{objects:g}", found, quantity)
    return tuple(made)


def _cheaper(where: str, found: dict[str, list[AtEqualError]], quantity: str) -> list[Claim]:
    """Compare the metric with the rival that needs least; fields are the replicates."""
    rival, mine = best_rival(found, quantity), found["blake"]
    if rival is None or not all(each.reached for each in mine) or len(mine) < 2:
        return []
    ratios = [
        getattr(ours, quantity) / getattr(theirs, quantity)
        for ours, theirs in zip(mine, found[rival], strict=True)
    ]
    word = _WORDS[quantity]
    about = f"At equal error a frame takes no more {word} than by the best rival, {where}."
    words = about, f"{word}, blake ÷ {rival}, at excess FLIP 0.01", _SOURCE
    name = f"{where}/{word}"
    return [claim(name, words, 1.0, 0.0, two_sided_factor(np.array(ratios)), "at most")]
