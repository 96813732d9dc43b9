"""What the rivals experiment claims, judged from its raw errors, times and bytes alone."""

from bench.methods.comparison import AtEqualError, at_equal_error, beside_best_rival
from bench.records.claims import Claim
from bench.records.old_claims import claim
from bench.records.records import Point, grouped
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
    compared = beside_best_rival(found, quantity)
    if compared is None or len(compared[1]) < 2:
        return []
    rival, ratios = compared
    word = _WORDS[quantity]
    about = f"At equal error a frame takes no more {word} than by the best rival, {where}."
    words = about, f"{word}, blake ÷ {rival}, at excess FLIP 0.01", _SOURCE
    name = f"{where}/{word}"
    return [claim(name, words, 1.0, 0.0, two_sided_factor(ratios), "at most")]
