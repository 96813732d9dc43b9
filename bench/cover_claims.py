"""What the cover experiment claims, judged from its raw samples alone."""

import numpy as np

from bench.claims import Claim, claim
from bench.cover_scene import LOOKS
from bench.records import Point
from bench.statistics import Estimate, paired_ratio

TOLERANCE = 0.02
_SOURCE = "§2.4, issue 4"


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Every band of every picture that has the cover."""
    covered = [point for point in points if point.case["cover"]]
    return tuple(_band(point, k) for point in covered for k in range(bands(point)))


def bands(point: Point) -> int:
    """How many there are."""
    return len(LOOKS[point.case["look"]].edges_m) - 1


def band_name(point: Point, band: int) -> str:
    """From where to where."""
    low, high = LOOKS[point.case["look"]].edges_m[band : band + 2]
    return f"{low:g} to {high:g} m"


def tone(point: Point, band: int) -> Estimate:
    """Light of the band, pruned ÷ whole, over fields."""
    tested, unpruned = (
        np.array(point.samples[f"{which} {band}"], np.float64) for which in ("tested", "whole")
    )
    return paired_ratio(tested, unpruned)


def _band(point: Point, band: int) -> Claim:
    case = point.case
    air = "in its own air" if case["air"] == "preset" else "in clear air"
    where = f"{case['look']} {air}, {band_name(point, band)}"
    about = f"Pruned to {case['detail']:g} px the land keeps its tone: {where}."
    words = about, "mean luminance ÷ that of everything there is", _SOURCE
    name = f"{case['look']}/{case['air']}/tau_{case['detail']:g}/band_{band + 1}"
    return claim(name, words, 1.0, TOLERANCE, tone(point, band))
