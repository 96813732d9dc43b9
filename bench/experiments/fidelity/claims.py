"""What the fidelity experiment claims, judged from its raw samples alone. Fields are replicates."""

from collections.abc import Sequence

import numpy as np

from bench.experiments.fidelity.equal_error import EQUAL_ERROR, GRASS_ERROR, Reached, equal_error
from bench.experiments.fidelity.scene import EDGES_M, EVERYTHING, GRASS, GROUND, NOTHING, SPECIES
from bench.experiments.fidelity.shipped.claims import CONTROL, errors
from bench.records.claims import Claim
from bench.records.old_claims import claim
from bench.records.records import Point, grouped, where
from bench.statistics.estimates import (
    Estimate,
    two_sided_mean,
    two_sided_paired_ratio,
    two_sided_ratio_of_means,
)
from bench.statistics.fits import noise_free, one_sided_mean
from lod.arrays import Reals

BANDS = len(EDGES_M) - 2
"""The number of bands of distance that are judged."""

TOLERANCE = 0.02
"""How far a band's luminance and coverage may be from the reference's, as a share."""

LEAST_SHARE = 0.005
"""The share of the land's rays from which on a band of distance is judged."""

_SOURCE = "§2.4"


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Return every claim that these points decide."""
    made: list[Claim] = []
    for (view,), chosen in grouped(where(points, what="headline"), "view").items():
        name = view.replace(" ", "_")
        ways = {p.case["pruned"]: p for p in chosen}
        made += _control(name, ways[NOTHING])
        for pruned in (EVERYTHING, SPECIES, GROUND):
            made += _error(name, ways[pruned])
        for band in judged_bands(ways[EVERYTHING]):
            made += _band(name, ways[EVERYTHING], band)
    for (view,), chosen in grouped(where(points, what="sweep"), "view").items():
        made += _rivals(view, chosen)
    return tuple(made)


def swept(points: Sequence[Point]) -> dict[str, Reached]:
    """Find equal error for every metric of one view's sweep."""
    return equal_error(points, errors, compared_at(points[0].case["view"]))


def compared_at(view: str) -> float:
    """Return the error at which metrics are compared in a view."""
    return GRASS_ERROR if view == GRASS else EQUAL_ERROR


def band_name(band: int) -> str:
    """Return from where to where a band of distance reaches."""
    return f"{EDGES_M[band]:g} to {EDGES_M[band + 1]:g} m"


def judged_bands(point: Point) -> list[int]:
    """Return the bands that hold at least LEAST_SHARE of the reference's land over all fields."""
    rays = [_sums(point, "rays", "reference", band).sum() for band in range(BANDS)]
    filled = [_sums(point, "rays", "tested", band).sum() for band in range(BANDS)]
    return [b for b in range(BANDS) if rays[b] >= LEAST_SHARE * sum(rays) and filled[b] > 0]


def tone(point: Point, band: int) -> Estimate:
    """Estimate a band's mean luminance ÷ the reference's, each by its own distances."""
    return two_sided_ratio_of_means(
        *(
            _sums(point, quantity, picture, band)
            for picture in ("tested", "reference")
            for quantity in ("light", "rays")
        )
    )


def coverage(point: Point, band: int) -> Estimate:
    """Estimate the share of the picture that a band fills ÷ that in the reference."""
    rays = [_sums(point, "rays", picture, band) for picture in ("tested", "reference")]
    return two_sided_paired_ratio(*rays)


def same_place(point: Point, band: int) -> Estimate | None:
    """Estimate FLIP without noise of the pixels that show a band in the reference.

    It is a mean over the fields where it is in the picture; None where those are fewer than two.
    """
    pixels = point.values("pixels", band=band)
    seen = pixels > 0
    if seen.sum() < 2:
        return None
    mine = [c for c in point.samples if c.quantity == "flip_sum_ppm" and c.keys["band"] == band]
    sums = np.array([each.values for each in mine])[:, seen] / 1e6
    counts = np.array([each.keys["samples"] for each in mine], np.float64)
    return one_sided_mean(noise_free(counts, sums / pixels[seen]))


def _sums(point: Point, quantity: str, picture: str, band: int) -> Reals:
    return point.values(quantity, picture=picture, band=band)


def _control(name: str, point: Point) -> list[Claim]:
    view = point.case["view"]
    about = f"Where nothing differs but samples, the fit finds no error: {view}."
    words = about, "mean FLIP without noise of the reference against itself", "HPG 2020"
    found = errors(point)
    if len(found) < 2:
        return []
    return [claim(f"control/{name}", words, 0.0, CONTROL, two_sided_mean(found))]


def _error(name: str, point: Point) -> list[Claim]:
    """Claim that nobody tells the picture from the reference, where there are two fields."""
    pruned, found = point.case["pruned"], errors(point)
    about = f"As good as whole by blake at one pixel, {point.case['view']}; pruned: {pruned}."
    words = about, "mean FLIP without noise, over fields (one-sided)", _SOURCE
    if len(found) < 2:
        return []
    which = f"blake/{name}/error_{pruned}"
    return [claim(which, words, EQUAL_ERROR, 0, one_sided_mean(found), "at most")]


def _band(name: str, point: Point, band: int) -> list[Claim]:
    place = f"{point.case['view']}, {band_name(band)}"
    about = f"Pruned by blake at one pixel the land is as bright as it was: {place}."
    words = about, "mean luminance ÷ the reference's, over fields", _SOURCE
    which = f"blake/{name}/%s_from_{EDGES_M[band]:g}_m"
    made = [claim(which % "tone", words, 1.0, TOLERANCE, tone(point, band))]
    about = f"Pruned by blake at one pixel the land fills as much of the picture: {place}."
    words = about, "share of rays ÷ the reference's, over fields", _SOURCE
    made.append(claim(which % "coverage", words, 1.0, TOLERANCE, coverage(point, band)))
    if (found := same_place(point, band)) is not None:
        about = f"Pruned by blake at one pixel the same places look the same: {place}."
        words = about, "FLIP without noise of the pixels there, over fields", _SOURCE
        made.append(claim(which % "error", words, EQUAL_ERROR, 0, found, "at most"))
    return made


def _rivals(view: str, points: Sequence[Point]) -> list[Claim]:
    """Claim that the default metric needs the fewest parts at equal error, over fields."""
    made, found = [], swept(points)
    ours, name = found["blake"], view.replace(" ", "_")
    for rival in found.values():
        if rival is not ours and ours.found and rival.found:
            about = f"At equal error blake needs no more parts than {rival.metric}, {view}."
            quantity = (
                f"parts by blake ÷ parts by {rival.metric} at an error of {compared_at(view)}"
            )
            words = about, f"{quantity}, over fields", _SOURCE
            which = f"{rival.metric}/{name}/parts"
            made.append(claim(which, words, 1.0, 0, ours.parts_over(rival), "at most"))
    return made
