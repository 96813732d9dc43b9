"""What the pixels experiment claims, judged from its raw counts alone."""

from bench.records.claims import Claim
from bench.records.old_claims import claim
from bench.records.records import Point
from bench.statistics.estimates import two_sided_quantile
from lod.arrays import Reals

MOST, SHARE = 4.0, 0.95
"""The ratio that at most 5 % of the objects may exceed, and the share that may not."""

_SOURCE = "§4.1"


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Return one claim for every point, by pixels covered."""
    return tuple(_claim(point) for point in points)


def _claim(point: Point) -> Claim:
    case = point.case
    about = (
        f"A {case['species']} hardly ever has many more parts than it covers pixels, "
        f"τ = {case['detail']:g} px."
    )
    words = about, "95th percentile of parts ÷ pixels covered", _SOURCE
    name = f"{case['metric']}/{case['species']}/pixels_{case['detail']:g}px"
    return claim(name, words, MOST, 0, two_sided_quantile(ratios(point), SHARE), "at most")


def ratios(point: Point, out_of: str = "pixels") -> Reals:
    """Return parts ÷ pixels of every object, or parts ÷ ``area`` [px] where it is not 0."""
    parts, covered = (point.values(k) for k in ("parts", out_of))
    if out_of == "area":
        covered = covered / 1000
    return parts[covered > 0] / covered[covered > 0]
