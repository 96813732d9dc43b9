"""What the air experiment claims, judged from its raw radiances alone (§2.1)."""

from collections.abc import Sequence

import numpy as np

from bench.experiments.air.targets import DISTANCES, extinction_seen, visibility_seen
from bench.records.claims import Claim
from bench.records.old_claims import claim, verification
from bench.records.records import Point, grouped, where
from bench.statistics.estimates import Estimate, two_sided_mean
from lod.air import Air, rgb_extinction

BAND_EDGES_M = (0.0, 50.0, 100.0, 200.0, 400.0, 800.0, 1600.0, 3200.0, 6400.0)
SKY = 1e10
"""The lower edge [m] of the band of rays that meet nothing."""

FEWEST = 30
"""The fewest pixels with which a band is judged."""

TOLERANCE = {"scalar": 0.01, "jit": 0.01, "medium": 0.03}
_TARGETS = ("black", "grey")
_SOURCE = "§2.1"


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Return every claim that these points decide."""
    targets = where(points, what="targets")
    bands = [p for p in where(points, what="bands") if p.column("pixels")[0] >= FEWEST]
    made = [each for point in targets for each in _visibility(point)]
    for (way,), chosen in grouped(targets, "way").items():
        made += _extinction(way, chosen)
    for point in bands:
        made += _colour(point) if point.case["from"] == SKY else _medium(point) + _colour(point)
    return tuple(made)


def found(point: Point) -> tuple[np.ndarray, np.ndarray]:
    """Fit β of each band and its standard error from black and from grey targets, (2, bands)."""
    target, beyond = (
        np.stack([point.values(name, band=band) for band in "rgb"], axis=1)
        for name in ("target", "beyond")
    )
    distance = point.case["visibility"] * point.values("step") / DISTANCES
    fit = extinction_seen(target, beyond, distance, point.values("grey") == 1)
    return fit[:2], fit[2:]


def _visibility(point: Point) -> list[Claim]:
    """Claim that V at 550 nm, from black and from grey targets, is the V of the air."""
    way, true, made = point.case["way"], point.case["visibility"], []
    for name, beta, error in zip(_TARGETS, *found(point), strict=True):
        seen = visibility_seen(beta, error)
        share = Estimate(seen.value / true, seen.low / true, seen.high / true, 0.0, 1.0, len(beta))
        about = f"{name.capitalize()} targets tell the visibility of {true / 1000:g} km."
        words = about, "V at 550 nm ÷ what it is", _SOURCE
        which = f"{way}/{name}/V_{true / 1000:g}km"
        made.append(_of_way(way, claim(which, words, 1.0, TOLERANCE[way], share)))
    return made


def _extinction(way: str, points: Sequence[Point]) -> list[Claim]:
    """Claim that β of each band is that of the air, over all visibilities and targets."""
    shares = np.concatenate(
        [found(p)[0] / rgb_extinction(Air(p.case["visibility"])) for p in points]
    )
    made = []
    for number, band in enumerate(("red", "green", "blue")):
        about = f"Contrast falls as exp(−βd) in {band}."
        words = about, "β ÷ what it is, over targets and visibilities", _SOURCE
        share = two_sided_mean(shares[:, number])
        made.append(_of_way(way, claim(f"{way}/beta/{band}", words, 1.0, TOLERANCE[way], share)))
    return made


def _of_way(way: str, made: Claim) -> Claim:
    """Return the claim on one way to render haze: the formula can only give back its own β."""
    return made if way == "medium" else verification(made)


def _medium(point: Point) -> list[Claim]:
    """Claim that both closed forms are as bright as the medium."""
    made, where = [], label(point)
    medium = point.values("medium")
    for kind, airlight in (("analytic", "the horizon's sky"), ("scattered", "its layer")):
        about = f"With the airlight of {airlight} the meadow is as bright as the medium's, {where}."
        words = about, "mean luminance ÷ the medium's", _SOURCE
        share = two_sided_mean(point.values(kind) / medium)
        name = f"{kind}/meadow/from_{point.case['from']:g}m"
        made.append(claim(name, words, 1.0, 0.03, share))
    return made


def _colour(point: Point) -> list[Claim]:
    where = label(point)
    about = f"RGB haze has the colour of spectral haze, {where}."
    words = about, "median CIEDE2000 over pixels", _SOURCE
    share = two_sided_mean(point.values("delta_e") / 1000)
    name = "sky" if point.case["from"] == SKY else f"from_{point.case['from']:g}m"
    return [claim(f"spectral/meadow/{name}", words, 2.0, 0.0, share, "at most")]


def label(point: Point) -> str:
    """Return the name of the band, in words."""
    return "in the sky" if point.case["from"] == SKY else f"from {point.case['from']:g} m"
