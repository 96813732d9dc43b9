"""Does the law hold for mixed species, hills, uneven K, near things, high eyes and haze? (§4.1)

The full law must hold in every case. The bare law is tried at the mildest and the hardest case of
each sweep: where the full law's prediction is further from it than the tolerance, it is expected to
fail, and that it does so refutes nothing.
"""

from collections.abc import Sequence

import numpy as np

from bench.experiments.scaling.cases_beyond import BEYOND, swept_beyond
from bench.fields.cases import Case
from bench.records.claims import Claim
from bench.records.old_claims import claim, verification
from bench.records.records import Point, where
from bench.statistics.estimates import Estimate, two_sided_ratio

_KNOWS = "§4.1, with what the case adds"
_BARE = "§4.1, bare"
_WITHIN = 0.02

_WORDS = {
    "mixed": "several species at once",
    "hills": "hilly ground",
    "patches": "objects in patches",
    "slope": "a density that grows one way",
    "clearing": "an eye in a clearing",
    "near": "limits near the eye",
    "height": "a high eye",
    "haze": "haze",
}


def judge_beyond(points: Sequence[Point]) -> list[Claim]:
    """Claim, for every sweep, the full law, and the bare law at both ends of the sweep."""
    made: list[Claim] = []
    for sweep, words in _WORDS.items():
        chosen = where(points, sweep=sweep)
        made += [_known(sweep, words, chosen, what) for what in ("objects", "parts") if chosen]
        ends = (chosen[0], chosen[-1]) if len(chosen) > 1 else ()
        made += [_bare(sweep, words, point) for point in ends]
    return made


def over_law(points: Sequence[Point], what: str) -> Estimate:
    """Estimate measured ÷ predicted over all fields of points, each with its own dispersion."""
    counts = [p.values(what) for p in points]
    means = [p.prediction(what) for p in points]
    noise = [p.prediction(f"{what}_variance") / p.prediction(what) for p in points]
    lengths = [len(each) for each in counts]
    return two_sided_ratio(
        np.concatenate(counts), np.repeat(means, lengths), np.repeat(noise, lengths)
    )


def over_bare(point: Point) -> Estimate:
    """Estimate objects measured ÷ those of the bare law, of one point."""
    found, share = (
        over_law([point], "objects"),
        point.prediction("objects") / point.prediction("bare"),
    )
    low, value, high = (share * v for v in (found.low, found.value, found.high))
    return Estimate(value, low, high, share * found.standard_error, found.scale, found.rows)


def _known(sweep: str, words: str, points: Sequence[Point], what: str) -> Claim:
    about = f"With {words} the law that knows of it gives the number of {what}, nothing fitted."
    said = about, "measured ÷ predicted", _KNOWS
    name = f"beyond/{sweep}/{what}_ratio"
    return verification(claim(name, said, 1, _WITHIN, over_law(points, what)))


def _bare(sweep: str, words: str, point: Point) -> Claim:
    question, at = BEYOND[sweep], swept_beyond(Case(**point.case))
    about = f"With {words} the bare πK((P + R)/m)² still holds: {question.axis} at {at:.3g}."
    said = about, "objects measured ÷ bare law", _BARE
    foretold = point.prediction("objects") / point.prediction("bare")
    found, known = over_bare(point), abs(foretold - 1) > _WITHIN
    name = f"beyond/{sweep}/bare_at_{at:.3g}"
    return verification(claim(name, said, 1, _WITHIN, found, expected_to_fail=known))
