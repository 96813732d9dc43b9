"""What the motion experiment claims, judged from its raw counts alone (§5.2)."""

import math
from collections.abc import Sequence
from dataclasses import replace

from bench.images.compare import one_sided_excess
from bench.images.equal_error import EQUAL_ERROR
from bench.records.claims import Claim
from bench.records.old_claims import claim, verification
from bench.records.records import Point, where
from bench.statistics.estimates import Estimate, two_sided_share
from lod.arrays import Reals

REDDY = "Reddy 1997"
_DERIVED = "derived: docs/method.md"
PICTURE = "picture"
"""The value of ``world`` in points of rendered pictures."""


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Return every claim that these points decide."""
    made = []
    counted = [point for point in points if point.case["world"] != PICTURE]
    for point in counted:
        turn, speed = (point.case[k] for k in ("turn", "speed"))
        if point.case["world"] == "finite":
            made.append(_reddy(point))
        elif turn == speed == 0:
            about = "A camera at rest leaves out nothing more."
            words = about, "share of the parts that motion leaves out", _DERIVED
            made.append(verification(claim("rest/parts", words, 0.0, 0.0, left_out(point))))
        elif is_fast(point):
            about = (
                "A fast pan (90°/s, 180° shutter) leaves out at least a tenth of the parts: with "
                "less, that its picture stays as it is would say nothing."
            )
            words = about, "share of the parts that motion keeps", _DERIVED
            made.append(claim("pan/parts", words, 0.9, 0.0, kept(point), "at most"))
        elif speed == 1.4:
            about = "At walking pace motion hides next to nothing."
            words = about, "share of the parts that motion leaves out", _DERIVED
            made.append(claim("walk/parts", words, 0.0, 0.01, left_out(point), "at most"))
    return (*made, *_pictures(points, made))


def _pictures(points: Sequence[Point], counted: Sequence[Claim]) -> list[Claim]:
    """Claim what the blurred pan shows; nothing where motion hides too few parts."""
    if not any(each.name == "pan/parts" and each.verdict == "holds" for each in counted):
        return []
    fast = [p for p in where(points, world=PICTURE) if is_fast(p)]
    pictures = {point.case["cut"]: point for point in fast}
    made = []
    if "motion" in pictures:
        about = "What motion leaves out of a fast pan is not missed in its blurred picture."
        words = about, "excess FLIP over the picture cut by size and distance, 67 px/°", _DERIVED
        bound = one_sided_excess_flip(pictures["motion"])
        made.append(claim("pan/excess", words, EQUAL_ERROR, 0.0, bound, "at most"))
    if "planted" in pictures:
        about = "The same test fails a planted cut of the pan, with m four times as large."
        words = about, "0.01 − its excess FLIP", _DERIVED
        found = one_sided_excess_flip(pictures["planted"])
        under = replace(
            found,
            value=EQUAL_ERROR - found.value,
            low=EQUAL_ERROR - found.high,
            high=EQUAL_ERROR - found.low,
        )
        made.append(verification(claim("pan/planted", words, 0.0, 0.0, under, "at most")))
    return made


def is_fast(point: Point) -> bool:
    """Say whether a point is of the fast pan that the claims are about."""
    return {"turn": 90.0, "speed": 0.0, "shutter": 180.0}.items() <= point.case.items()


def one_sided_excess_flip(point: Point) -> Estimate:
    """Estimate excess FLIP; low and high are one-sided 95 % bounds (``excess_flip``)."""
    tested, floor = (point.values(k) / 1e6 for k in ("flip", "flip_floor"))
    found = one_sided_excess(tested, floor)
    error = float((tested - floor).std(ddof=1)) / math.sqrt(found.pairs)
    return Estimate(found.excess, found.low, found.high, error, 1.0, found.pairs)


def kept(point: Point) -> Estimate:
    """Estimate the share of the parts left by size and distance that motion keeps."""
    return two_sided_share(parts(point, "motion"), parts(point, "spatial"))


def left_out(point: Point) -> Estimate:
    """Estimate the share of the parts left by size and distance that motion leaves out."""
    spatial = parts(point, "spatial")
    return two_sided_share(spatial - parts(point, "motion"), spatial)


def _reddy(point: Point) -> Claim:
    """Claim the share of all that is left out of a fast pan that size and distance leave out."""
    everything, spatial, motion = (parts(point, cut) for cut in ("everything", "spatial", "motion"))
    about = "Size and distance give about 95 % of any gain, velocity the rest."
    words = about, "share of the parts left out that size and distance leave out", REDDY
    found = two_sided_share(everything - spatial, everything - motion)
    return claim("finite/size_and_distance", words, 0.95, 0.05, found)


def parts(point: Point, cut: str) -> Reals:
    """Return the parts that every field displays by a cut, (fields,)."""
    return point.values("parts", cut=cut)
