"""What the spectrum experiment claims, judged from its raw powers alone."""

import numpy as np

from bench.records.claims import Claim
from bench.records.old_claims import claim
from bench.records.records import Point
from bench.statistics.estimates import two_sided_paired_ratio, two_sided_share
from lod.arrays import Reals

EDGES = tuple(2.0**k for k in range(-6, 0))
"""Edges of octaves of frequency [cycles a pixel], from 1/64 to 1/2; lower ones are in the first."""

_SOURCE = "§2.1, §2.2"


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Claim for every detail that what is lost lies above the cut-off, and little is left there."""
    return tuple(each for point in points for each in (_lost_below(point), _left_above(point)))


def power(point: Point, name: str, above: bool) -> Reals:
    """Return the power above the cut-off, or below it, in every direction, (directions,)."""
    cutoff = point.prediction("cutoff")
    chosen = [k for k in range(len(EDGES) - 1) if (EDGES[k] >= cutoff) == above]
    rows = [point.values("power", picture=name, octave=k) for k in chosen]
    return np.sum(rows, axis=0)


def octaves(point: Point, name: str) -> Reals:
    """Return the mean power in every octave."""
    rows = [point.values("power", picture=name, octave=k) for k in range(len(EDGES) - 1)]
    return np.array([each.mean() for each in rows]) / 1e12


def _lost_below(point: Point) -> Claim:
    below, above = power(point, "lost", False), power(point, "lost", True)
    about = f"What pruning at {point.case['detail']:g} px takes lies above its cut-off."
    words = about, "share of the difference's power below 1/(2τ)", _SOURCE
    found = two_sided_share(below, below + above)
    return claim(f"lost_below/tau_{point.case['detail']:g}px", words, 0.1, 0, found, "at most")


def _left_above(point: Point) -> Claim:
    about = f"Pruning at {point.case['detail']:g} px leaves little above its cut-off."
    words = about, "power above 1/(2τ) ÷ the whole picture's", _SOURCE
    found = two_sided_paired_ratio(power(point, "pruned", True), power(point, "whole", True))
    return claim(f"left_above/tau_{point.case['detail']:g}px", words, 0.1, 0, found, "at most")
