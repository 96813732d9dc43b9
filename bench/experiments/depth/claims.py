"""What the depth experiment claims, judged from its raw counts alone."""

import numpy as np

from bench.records.claims import Claim
from bench.records.old_claims import claim, verification
from bench.records.records import Point, where
from bench.statistics.estimates import two_sided_paired_ratio, two_sided_slope
from lod.arrays import Reals

QUADRANTS = 4
_SOURCE = "§4.1"


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Claim growth with the world, pruned and not, and that every quadrant is like all of them."""
    pruned, full = (
        sorted(where(points, metric=m), key=lambda p: p.case["extent"]) for m in METRICS_TRIED
    )
    made = [_growth(full), _beyond(pruned[-2], pruned[-1])]
    return (*made, *(_direction(pruned[-1], k) for k in range(QUADRANTS)))


METRICS_TRIED = "blake", "full"


def total(point: Point) -> Reals:
    """Return the sticks that all rays of each field pierce, (fields,)."""
    return np.sum([point.values("pierced", quadrant=k) for k in range(QUADRANTS)], axis=0)


def _growth(points: list[Point]) -> Claim:
    counts = np.concatenate([total(p) for p in points])
    extent = np.concatenate([np.full(len(total(p)), p.case["extent"]) for p in points])
    about = "Unpruned, depth complexity grows with the side of the world."
    words = about, "exponent against the world's side", _SOURCE
    return claim("full/growth", words, 1.0, 0.2, two_sided_slope(counts, extent))


def _beyond(near: Point, far: Point) -> Claim:
    """Compare the same fields in two windows, both larger than the limit."""
    about = "Pruned, depth complexity does not grow with a world that is larger than the limit."
    sides = f"{far.case['extent']:g} m ÷ {near.case['extent']:g} m"
    words = about, f"surfaces pierced in the same fields, {sides}", _SOURCE
    found = two_sided_paired_ratio(total(far), total(near))
    return verification(claim("blake/growth", words, 1.0, 0.02, found))


def _direction(point: Point, quadrant: int) -> Claim:
    counts = point.values("pierced", quadrant=quadrant)
    about = f"Pruned, depth complexity is the same in every direction: quadrant {quadrant + 1}."
    words = about, "surfaces pierced ÷ the mean of all directions", _SOURCE
    found = two_sided_paired_ratio(QUADRANTS * counts, total(point))
    return verification(claim(f"blake/direction_{quadrant + 1}", words, 1.0, 0.15, found))
