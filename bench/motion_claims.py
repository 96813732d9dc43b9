"""What the motion experiment claims, judged from its raw counts alone (§5.2)."""

import numpy as np

from bench.claims import Claim, claim
from bench.records import Point
from bench.statistics import Estimate, share

REDDY = "Reddy 1997"
_ISSUE = "issue 9"


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Every claim that these points decide."""
    made = []
    for point in points:
        turn, speed, shutter = (point.case[k] for k in ("turn", "speed", "shutter"))
        if point.case["world"] == "finite":
            made.append(_reddy(point))
        elif turn == speed == 0:
            about = "A camera at rest leaves out nothing more."
            words = about, "share of the parts that motion leaves out", _ISSUE
            made.append(claim("rest/parts", words, 0.0, 0.0, left_out(point)))
        elif (turn, shutter) == (90.0, 180.0):
            about = "A fast pan (90°/s, 180° shutter) leaves out at least a tenth of the parts."
            words = about, "share of the parts that motion keeps", _ISSUE
            made.append(claim("pan/parts", words, 0.9, 0.0, kept(point), "at most"))
        elif speed == 1.4:
            about = "At walking pace motion hides next to nothing."
            words = about, "share of the parts that motion leaves out", _ISSUE
            made.append(claim("walk/parts", words, 0.0, 0.01, left_out(point), "at most"))
    return tuple(made)


def kept(point: Point) -> Estimate:
    """Share of the parts that are left by size and distance that motion keeps."""
    return share(_column(point, "motion"), _column(point, "spatial"))


def left_out(point: Point) -> Estimate:
    """The rest of them."""
    spatial = _column(point, "spatial")
    return share(spatial - _column(point, "motion"), spatial)


def _reddy(point: Point) -> Claim:
    """Of all that is left out of a fast pan, what size and distance had left out already."""
    everything, spatial, motion = (
        _column(point, name) for name in ("everything", "spatial", "motion")
    )
    about = "Size and distance give about 95 % of any gain, velocity the rest."
    words = about, "share of the parts left out that size and distance leave out", REDDY
    found = share(everything - spatial, everything - motion)
    return claim("finite/size_and_distance", words, 0.95, 0.05, found)


def _column(point: Point, name: str) -> np.ndarray:
    return np.array(point.samples[name], np.float64)
