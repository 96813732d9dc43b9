"""What the cover experiment claims, judged from its raw samples alone."""

from bench.experiments.cover.scene import LOOKS
from bench.records.claims import Claim
from bench.records.old_claims import claim
from bench.records.records import Point
from bench.statistics.estimates import (
    Estimate,
    two_sided_paired_ratio,
    two_sided_ratio_of_means,
)
from lod.arrays import Reals

TOLERANCE = 0.02
SAME_RAYS = "pruned, along the rays of the whole"
"""The name of the pruned picture along the rays that have the band in the whole picture."""

_SOURCE = "§2.4"


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Return a claim for every band of every picture that has the far cover."""
    covered = [point for point in points if point.case["cover"]]
    return tuple(made for point in covered for k in range(bands(point)) for made in _band(point, k))


def bands(point: Point) -> int:
    """Return the number of bands of a point."""
    return len(LOOKS[point.case["look"]].edges_m) - 1


def band_name(point: Point, band: int) -> str:
    """Return from where to where a band reaches, in words."""
    low, high = LOOKS[point.case["look"]].edges_m[band : band + 2]
    return f"{low:g} to {high:g} m"


def tone(point: Point, band: int, light: str = "light") -> Estimate:
    """Estimate mean luminance of a band, pruned ÷ whole, over fields: each by its own distances.

    ``light`` is ``light`` for all of it, or ``land`` for that of the land without the airlight.
    """
    return two_sided_ratio_of_means(
        *(
            _sums(point, band, quantity, picture)
            for picture in ("pruned", "whole")
            for quantity in (light, "rays")
        )
    )


def coverage(point: Point, band: int) -> Estimate:
    """Estimate how much of the picture a band fills, pruned ÷ whole, over fields."""
    return two_sided_paired_ratio(*(_sums(point, band, "rays", p) for p in ("pruned", "whole")))


def land_share(point: Point, band: int) -> float:
    """Return the land's share of a band's light in the whole picture; the rest is airlight."""
    land, light = (_sums(point, band, each, "whole") for each in ("land", "light"))
    return float(land.sum() / light.sum())


def same_rays(point: Point, band: int) -> float:
    """Return luminance, pruned ÷ whole, along the rays that have the band in the whole picture."""
    pruned, whole = (_sums(point, band, "light", each) for each in (SAME_RAYS, "whole"))
    return float(pruned.sum() / whole.sum())


def _sums(point: Point, band: int, quantity: str, picture: str) -> Reals:
    return point.values(quantity, picture=picture, band=band)


def _band(point: Point, band: int) -> list[Claim]:
    """Claim the tone of a band, that of its land where air adds light, and its coverage."""
    case = point.case
    air = "in its own air" if case["air"] == "preset" else "in clear air"
    where = f"{case['look']} {air}, {band_name(point, band)}"
    name = f"{case['look']}/{case['air']}/tau_{case['detail']:g}/band_{band + 1}"
    about = f"Pruned to {case['detail']:g} px the land keeps its tone: {where}."
    words = about, "mean luminance ÷ that of everything there is", _SOURCE
    made = [claim(name, words, 1.0, TOLERANCE, tone(point, band))]
    if case["air"] == "preset":
        about = f"Pruned to {case['detail']:g} px the land keeps its tone, airlight apart: {where}."
        share = f"{100 * land_share(point, band):.0f} % of the light"
        words = about, f"mean luminance of the land ({share}) ÷ that of all of it", _SOURCE
        made.append(claim(f"{name}/land", words, 1.0, TOLERANCE, tone(point, band, "land")))
    about = f"Pruned to {case['detail']:g} px the land fills as much of the picture: {where}."
    words = about, "rays ÷ those of everything there is", _SOURCE
    return [*made, claim(f"{name}/coverage", words, 1.0, TOLERANCE, coverage(point, band))]
