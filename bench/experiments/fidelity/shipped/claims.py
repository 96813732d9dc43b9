"""What is claimed of presets as shipped, judged from the raw samples of their places alone."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.records.claims import Claim
from bench.records.old_claims import claim
from bench.records.records import Column, Point, where
from bench.statistics.estimates import Estimate, two_sided_mean
from bench.statistics.fits import noise_free, one_sided_mean
from lod.arrays import Reals

NOTHING, EVERYTHING = "nothing", "everything"
GROUND, REST = "ground alone", "all but the ground"
"""What is pruned, while the rest is the reference's."""

BANDS = 8
"""The number of bands of distance."""

MOST_ERROR = 0.01
"""The greatest error at which nobody tells a picture from the reference."""

MOST_LIGHT, MOST_LIGHT_OF_BAND = 0.01, 0.02
"""How far the land's mean luminance may be from the reference's, in all and in a band."""

LEAST_SHARE = 0.01
"""The share of the land's rays from which on a band of distance is judged."""

CONTROL = 0.002
"""How far from 0 the fit may find the error of the reference against itself."""

_SOURCE = "§2.4"


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Claim error and light of every preset in every way that it was pruned, and of the fit."""
    made = [_control(where(points, pruned=NOTHING))]
    for point in where(points, step=1.0):
        if point.case["pruned"] != NOTHING:
            made += [_error(point), _light(point), _bands(point)]
    return tuple(made)


def errors(point: Point) -> Reals:
    """Return the error of every place: mean FLIP without noise, (places,)."""
    found = flip_columns(point)
    counts = np.array([each.keys["samples"] for each in found], np.float64)
    return noise_free(counts, np.array([each.values for each in found]) / 1e6)


def flip_columns(point: Point) -> list[Column]:
    """Return the columns of mean FLIP [ppm], from the fewest samples of a pixel to the most."""
    mine = [each for each in point.samples if each.quantity == "flip_ppm"]
    return sorted(mine, key=lambda each: int(each.keys["samples"]))


def error(point: Point) -> Estimate:
    """Estimate the mean error over places, with one-sided bounds."""
    return one_sided_mean(errors(point))


def light_ratios(point: Point) -> Reals:
    """Return the land's mean luminance, pruned ÷ reference, of every place, (places,)."""
    (light, rays), (whole, of_all) = (
        [_bands_of(point, name, which).sum(axis=0) for name in ("light", "rays")]
        for which in ("tested", "reference")
    )
    return np.asarray((light / rays) / (whole / of_all))


@dataclass(frozen=True, eq=False)
class Band:
    """One band of distance of a preset, in the places where it holds enough of the land.

    share     share of the reference's land that it holds there
    light     mean luminance, pruned ÷ reference, (places,)
    coverage  share of the picture that it fills, pruned ÷ reference, (places,)
    """

    number: int
    share: float
    light: Reals
    coverage: Reals

    @property
    def off(self) -> bool:
        """Whether its mean luminance over places is farther off than it may be."""
        return bool(abs(self.light.mean() - 1) > MOST_LIGHT_OF_BAND)


def judged_bands(point: Point) -> list[Band]:
    """Return the bands that hold at least LEAST_SHARE of the land in a place or more."""
    (light, rays), (whole, of_all) = (
        [_bands_of(point, name, which) for name in ("light", "rays")]
        for which in ("tested", "reference")
    )
    share, made = of_all / of_all.sum(axis=0), []
    for k in range(BANDS):
        here = (share[k] >= LEAST_SHARE) & (rays[k] > 0)
        if here.any():
            tone = (light[k] / np.maximum(rays[k], 1))[here] / (whole[k][here] / of_all[k][here])
            coverage = rays[k][here] / of_all[k][here]
            made.append(Band(k, float(share[k][here].mean()), tone, coverage))
    return made


def _bands_of(point: Point, quantity: str, picture: str) -> np.ndarray:
    """Return sums of a quantity in one picture, (bands, places)."""
    rows = [point.values(quantity, picture=picture, band=k) for k in range(BANDS)]
    return np.array(rows)


def _name(point: Point) -> str:
    ways = {EVERYTHING: "everything", GROUND: "ground", REST: "rest"}
    return f"{point.case['preset']}/{ways[point.case['pruned']]}"


def _subject(point: Point) -> str:
    words = {EVERYTHING: "as shipped", GROUND: "with its ground alone pruned as shipped"}
    pruned = point.case["pruned"]
    return f"{point.case['preset']} {words.get(pruned, f'with {pruned} pruned as shipped')}"


def _control(points: Sequence[Point]) -> Claim:
    about = "Where nothing differs but samples, the fit finds no error: references, all places."
    words = about, "mean FLIP without noise of a reference against itself", "Andersson et al. 2020"
    found = two_sided_mean(np.concatenate([errors(point) for point in points]))
    return claim("fit/control", words, 0.0, CONTROL, found)


def _error(point: Point) -> Claim:
    about = f"Nobody tells {_subject(point)} from a picture that is far finer."
    words = about, "mean FLIP without noise, over places (one-sided)", _SOURCE
    return claim(f"{_name(point)}/error", words, MOST_ERROR, 0, error(point), "at most")


def _light(point: Point) -> Claim:
    about = f"The land of {_subject(point)} is as bright as that of a far finer picture."
    words = about, "mean luminance of the land ÷ the reference's, over places", _SOURCE
    found = two_sided_mean(light_ratios(point))
    return claim(f"{_name(point)}/light", words, 1.0, MOST_LIGHT, found)


def _bands(point: Point) -> Claim:
    """Claim that the mean over these places is near enough in each band: a count, without error."""
    bands, most = judged_bands(point), f"{100 * MOST_LIGHT_OF_BAND:g} %"
    about = f"In no band of distance is the land of {_subject(point)} more than {most} off."
    words = about, f"bands of {len(bands)} whose mean over places is off", _SOURCE
    off = float(sum(each.off for each in bands))
    counted = Estimate(off, off, off, 0.0, 1.0, len(bands))
    return claim(f"{_name(point)}/bands", words, 0, 0, counted, "at most")
