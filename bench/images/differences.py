"""How far is a picture from another? FLIP, noise, luminance and coverage by band of distance.

FLIP (Andersson et al., "FLIP: A Difference Evaluator for Alternating Images", HPG 2020) is what is
perceived when two pictures are flipped between, 0 to 1 a pixel; here its mean over the picture.
Pictures are linear radiance, and FLIP compares them as they are displayed: at one exposure for a
view, that of its reference, through the curve of ``scenes.render.pictures``, not rounded to 8 bits.
Two noisy renders of one scene differ too, and noise is taken away in one of two ways.

**Excess.** With seeds a and b, excess = FLIP(tested, a; reference, b) − FLIP(reference, a;
reference, b), and the second term is the noise floor. It is the mean over independent pairs of
seeds. FLIP does not add up: noise hides part of a difference, so the excess is only worth quoting
where the floor is low (FLOOR).

**Extrapolation.** The mean FLIP of two renders with other seeds grows with their noise, whose
standard deviation falls as 1/√N with N samples a pixel. So errors at several N are fitted by
a + b/√N (least squares), and a is what is left where nothing is noisy. Nothing is subtracted from
it: two renders of one scene have an a near 0, which tells how far the fit can be trusted.

The land's luminance is summed over rays, each of which is of one place alone: pictures of one
sample a pixel have a distance for every ray, and no pixel is half land and half sky.
"""

import gc
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from jaxtyping import Float, Float64, Int64

from bench.records.records import Column, Key, Point, columns
from bench.statistics.estimates import (
    Estimate,
    noise_free,
    one_sided_mean,
    two_sided_paired_ratio,
    two_sided_ratio_of_means,
)
from lod.arrays import Reals, freeze
from lod.errors import InputError
from scenes.frame.frame_input import FrameInput
from scenes.frame.layers import SKY_Z, Layers
from scenes.render.pictures import auto_exposure, to_srgb
from scenes.render.render import build_frame, trace
from scenes.sticks.prototype import LUMINANCE

Radiance = Float64[np.ndarray, "h w 3"]  # a picture as linear radiance

PIXELS_PER_DEGREE = 67.0
"""The usual fineness of a display before a viewer: a 0.7 m wide 4K screen at 0.7 m."""

LEAST_PAIRS = 8  # the fewest pairs of seeds of which an excess is estimated
FLOOR = 0.01  # the highest noise floor at which an excess is quoted

Picture = Float[np.ndarray, "_ _ 3"]
"""A picture as it is displayed: sRGB-encoded, 0 to 1, exposure and tone curve applied."""


def one_sided_excess(tested: Reals, noise: Reals) -> Estimate:
    """Estimate FLIP beyond the noise floor from both terms of each pair of seeds, (pairs,) each.

    Its bounds are one-sided. Raises InputError for fewer than LEAST_PAIRS pairs.
    """
    if len(tested) < LEAST_PAIRS:
        raise InputError("pairs", len(tested), f"at least {LEAST_PAIRS} pairs of seeds")
    return one_sided_mean(tested - noise)


def mean_flip(
    test: Picture, reference: Picture, pixels_per_degree: float = PIXELS_PER_DEGREE
) -> float:
    """Return the mean FLIP of two displayed pictures, by its authors' evaluator.

    Raises InputError for pictures of different shapes and for values outside 0 to 1.
    """
    return _evaluated(test, reference, pixels_per_degree, False)[1]


def flip_map(test: Picture, reference: Picture) -> Picture:
    """Return FLIP of every pixel in its authors' colours: dark where it is 0, bright where it is 1.

    Raises InputError for pictures of different shapes and for values outside 0 to 1.
    """
    return _evaluated(test, reference, PIXELS_PER_DEGREE, True)[0]


def _evaluated(
    test: Picture, reference: Picture, pixels_per_degree: float, coloured: bool
) -> tuple[np.ndarray, float]:
    import flip_evaluator

    for name, picture in (("test", test), ("reference", reference)):
        if picture.shape != reference.shape:
            raise InputError(name, picture.shape, f"both pictures are {reference.shape}")
        if not (np.isfinite(picture).all() and picture.min() >= 0 and picture.max() <= 1):
            raise InputError(name, "a value outside 0 to 1", "pictures are sRGB, 0 to 1")
    pair = (np.ascontiguousarray(p, np.float32) for p in (reference, test))
    settings = {"ppd": float(pixels_per_degree)}
    found, mean, _ = flip_evaluator.evaluate(*pair, "LDR", True, coloured, True, settings)
    return np.asarray(found), float(mean)


REFERENCE, TESTED, LIGHT = 0, 1000, 2000
"""First frame numbers of samples: pictures of the reference and of what is tested have others.

The light of both is of the same samples: where they show the same, there is no noise between them.
"""


@dataclass(frozen=True, eq=False)
class LandLight:
    """Sums over the rays that meet land, by bands of distance, (bands,) each.

    light  luminance
    rays   how many there are
    """

    light: Float64[np.ndarray, " bands"]
    rays: Int64[np.ndarray, " bands"]

    def __post_init__(self) -> None:
        freeze(self, light=np.float64, rays=np.int64)


@dataclass(frozen=True, eq=False)
class Seen:
    """What is seen of one scene.

    pictures  linear radiance, one of every count of samples, for each of the first samples
    land, things   light of all land by bands of distance, and of what stands on it
    Z         (h, w) distance of what each pixel shows [m], in the last picture of the first row
    sticks, triangles   how many the scene has
    """

    pictures: tuple[tuple[Radiance, ...], ...]
    land: LandLight
    things: LandLight
    Z: np.ndarray
    sticks: int
    triangles: int


@dataclass(frozen=True)
class Looks:
    """How scenes are looked at: samples of a pixel in each picture, and passes over the light."""

    samples: tuple[int, ...]
    light_passes: int


def look(frame_input: FrameInput, looks: Looks, edges_m: np.ndarray, *firsts: int) -> Seen:
    """Build a frame's scene once and take its pictures, from the samples ``firsts`` on each.

    The ground is the first of what is displayed: its tiles are no things.
    """
    gc.collect()  # a scene that was built before is large
    stage, quality = build_frame(frame_input), frame_input.quality
    tiles = int(frame_input.displayed[0].cut.object.max(initial=0)) + 1
    made = [
        [trace(stage, replace(quality, spp=spp), first + k) for k, spp in enumerate(looks.samples)]
        for first in firsts
    ]
    passes = [
        (each.rgb, each.Z, np.where(each.object > tiles, each.Z, SKY_Z))
        for k in range(looks.light_passes)
        for each in [trace(stage, replace(quality, spp=1), LIGHT + k)]
    ]
    land, things = (sum_land(((each[0], each[n]) for each in passes), edges_m) for n in (1, 2))
    counts = made[0][0].statistics
    pictures = tuple(tuple(each.rgb.astype(np.float64) for each in row) for row in made)
    return Seen(pictures, land, things, made[0][-1].Z, counts["sticks"], counts["triangles"])


def sum_land(passes: Iterable[tuple[np.ndarray, np.ndarray]], edges_m: np.ndarray) -> LandLight:
    """Sum the luminance of rays that meet land, band by band.

    ``passes`` are pairs of radiance (h, w, 3) and distance (h, w) [m], of one ray a pixel.
    """
    bands = len(edges_m) - 1
    light, rays = np.zeros(bands), np.zeros(bands, np.int64)
    for rgb, Z in passes:
        land = Z < SKY_Z
        band = np.digitize(Z[land].astype(np.float64), edges_m[1:-1])
        light += np.bincount(band, rgb[land].astype(np.float64) @ LUMINANCE, bands)
        rays += np.bincount(band, minlength=bands)
    return LandLight(light, rays)


def flips(tested: Sequence[Radiance], reference: Sequence[Radiance]) -> list[float]:
    """Return the mean FLIP of each two pictures with as many samples, as ``flips_by_pixel``."""
    return [float(each.mean()) for each in flips_by_pixel(tested, reference)]


def flips_by_pixel(tested: Sequence[Radiance], reference: Sequence[Radiance]) -> list[Reals]:
    """Return FLIP of every pixel of each two pictures with as many samples, row by row.

    They are displayed at one exposure, that of the reference's last picture.
    """
    exposure = auto_exposure(reference[-1])
    shown = (
        [to_srgb(each, exposure).astype(np.float32) for each in pictures]
        for pictures in (tested, reference)
    )
    return [
        _evaluated(one, other, PIXELS_PER_DEGREE, False)[0].astype(np.float64).ravel()
        for one, other in zip(*shown, strict=True)
    ]


def band_name(edges_m: Sequence[float], band: int) -> str:
    """Write from where to where a band of distance reaches; the last has no end."""
    low, high = edges_m[band : band + 2]
    return f"from {low:.3g} m" if high >= SKY_Z else f"{low:.4g}–{high:.4g} m"


def band_sums(
    point: Point, quantity: str, band: int, pictures: tuple[str, str] = ("tested", "reference")
) -> tuple[Reals, Reals]:
    """Return sums of a quantity over a band in both pictures, by replicate, (n,) each."""
    one, other = (point.values(quantity, picture=each, band=band) for each in pictures)
    return one, other


def luminance_ratio(
    point: Point,
    band: int,
    light: str = "light",
    pictures: tuple[str, str] = ("tested", "reference"),
) -> Estimate:
    """Estimate a band's mean luminance ÷ the reference's, each by its own distances."""
    (lit, of_reference), (rays, all_rays) = (
        band_sums(point, each, band, pictures) for each in (light, "rays")
    )
    return two_sided_ratio_of_means(lit, rays, of_reference, all_rays)


def coverage_ratio(
    point: Point, band: int, pictures: tuple[str, str] = ("tested", "reference")
) -> Estimate:
    """Estimate the share of the picture that a band fills ÷ that in the reference."""
    return two_sided_paired_ratio(*band_sums(point, "rays", band, pictures))


def errors(point: Point, **keys: Key) -> Reals:
    """Return mean FLIP without noise of every replicate, of the columns with these keys, (n,)."""
    flips = [each for each in point.samples if each.quantity == "flip_ppm"]
    mine = [each for each in flips if keys.items() <= each.keys.items()]
    found = sorted(mine, key=lambda each: int(each.keys["samples"]))
    counts = np.array([each.keys["samples"] for each in found], np.float64)
    return noise_free(counts, np.array([each.values for each in found]) / 1e6)


def same_place(point: Point, band: int) -> Estimate | None:
    """Estimate FLIP without noise of the pixels that show a band in the reference.

    It is a mean over the replicates where it is in the picture; None where those are fewer than
    two.
    """
    pixels = point.values("pixels", band=band)
    seen = pixels > 0
    if seen.sum() < 2:
        return None
    mine = [c for c in point.samples if c.quantity == "flip_sum_ppm" and c.keys["band"] == band]
    sums = np.array([each.values for each in mine])[:, seen] / 1e6
    counts = np.array([each.keys["samples"] for each in mine], np.float64)
    return one_sided_mean(noise_free(counts, sums / pixels[seen]))


def sums_by_band(
    quantity: str, values: np.ndarray, keys: dict[str, Key], unit: float = 1e-6
) -> list[Column]:
    """Make a column of whole numbers of a unit for each band."""
    return [
        Column(quantity, [round(float(value) / unit)], keys | {"band": band})
        for band, value in enumerate(values)
    ]


BAND_EDGES_M = (0.0, 20.0, 60.0, 200.0)
"""The distances where bands of mean luminance begin [m]; the last band is the sky."""

EPSILON = 0.01  # the number added to a squared picture by which noise is divided, in exposed light


@dataclass(frozen=True, eq=False)
class Reference:
    """The unpruned view, by pairs of seeds.

    pictures  of every pair, with another seed than the tested picture
    exposure  of the mean of all of them
    floor     FLIP of every pair where the tested picture is unpruned, too [10⁻⁶]
    Z         (h, w) distance of what each pixel shows [m]
    """

    pictures: list[Radiance]
    exposure: float
    floor: list[int]
    Z: np.ndarray


def reference_of(same: Sequence[Layers], other: Sequence[Layers]) -> Reference:
    """Make the reference of rendered frames, of the tested picture's seeds and of others."""
    one, two = ([each.rgb.astype(np.float64) for each in row] for row in (same, other))
    plain = Reference(two, auto_exposure(np.mean(two, axis=0)), [], same[0].Z)
    return replace(plain, floor=pair_flips(one, plain))


def pair_flips(tested: Sequence[Radiance], whole: Reference) -> list[int]:
    """Return the mean FLIP of every pair [10⁻⁶]."""
    shown = (
        [to_srgb(each, whole.exposure).astype(np.float32) for each in row]
        for row in (tested, whole.pictures)
    )
    return [round(1e6 * mean_flip(one, other)) for one, other in zip(*shown, strict=True)]


def picture_errors(tested: Sequence[Radiance], whole: Reference) -> tuple[Column, ...]:
    """Measure FLIP of every pair and its floor [10⁻⁶], and the pixels of every band."""
    edges = (*BAND_EDGES_M, float(SKY_Z), np.inf)
    pixels = (
        Column("pixels", [int(((whole.Z >= low) & (whole.Z < high)).sum())], {"band": name})
        for name, (low, high) in zip(PAIR_BANDS, pairwise(edges), strict=True)
    )
    flip = {"flip": pair_flips(tested, whole), "flip_floor": whole.floor}
    return (*columns(flip), *pixels)


def pair_band_name(low: float) -> str:
    """Return the name of the band that begins at a distance [m]."""
    return "sky" if low == float(SKY_Z) else f"from {low:g} m"


PAIR_BANDS = tuple(pair_band_name(low) for low in (*BAND_EDGES_M, float(SKY_Z)))
