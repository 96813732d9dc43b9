"""Is a picture of a world right, how far is it from the reference, and what is it worth?

Validity comes first. A picture is *void*, with the reason, where it is of another size, has numbers
that are not finite, repeats the reference's own noise, is lit or seen otherwise, or leaves out most
of what a band of distances shows. What stands within these bounds is judged by its error alone,
the mean FLIP to the reference; the noise of a picture counts, because samples and detail are both
bought with time.

**By band.** The share of a pixel that each band of distances fills is the reference's. A band's
luminance is the mean of the picture under these shares, ÷ the reference's. What a band *keeps* is
the regression of the picture on the reference,

    Σ s (S − S̄)(Rₐ − R̄ₐ) ÷ Σ s (Rₐ − R̄ₐ)(R_b − R̄_b),

where S̄ is S smoothed, s the share, and Rₐ, R_b two references of independent noise, so that no
noise biases it: it falls to 0 where things are left out, and below 1 where they are blurred or
drawn elsewhere. Coverage is counted where a picture has a layer ``Z``.

**The score** is the time to the error that ``blake`` has at one pixel, ÷ the time that it takes in
the published baseline. Between two settings, time is read along the straight line of logarithms
against error. Below 1 is faster.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter

from bench.images.differences import band_name, flip_map, mean_flip
from bench.submissions.diagnosis import LARGEST_FOV, LARGEST_SHIFT_PX, best_cause, registration
from lod.errors import InputError
from scenes.frame.layers import SKY_Z
from scenes.render.exr.layer_file import read_pixels
from scenes.render.pictures import auto_exposure, to_srgb
from scenes.sticks.prototype import LUMINANCE

LEAST_KEPT = 0.5  # the least of a band's structure that a picture must keep
MOST_LUMINANCE = 0.15  # how far the luminance of a band may be off, as a share of the reference's
MOST_SKY = 0.02  # how far the luminance of the clear sky may be off: no method changes it

MOST_ZOOM, MOST_SHIFT_PX = 0.004, 0.5
"""How far the camera may be off: enlargement, and movement of the picture [px]."""

LEAST_SHARE = 0.01  # bands are judged that fill at least this share of the picture

LEAST_STRUCTURE = 0.5
"""What a band keeps is judged where so much of the reference's structure is no noise."""

WITHIN = 0.005  # land luminance and coverage of a renderer that draws everything agree within this

_STRUCTURE_PX = 4.0
_COPIED = 0.2


@dataclass(frozen=True, eq=False)
class Target:
    """One view of a pack as pictures are held against it.

    halves    two references with independent noise, linear radiance, (h, w, 3) each
    Z         distance of what each pixel shows [m], (h, w)
    shares    share of each pixel that every band fills, (bands, h, w); the last band is the sky
    edges_m   where bands of land begin [m]; the last begins where the sky does
    variants  pictures with one mistake each, by its name
    """

    halves: tuple[np.ndarray, np.ndarray]
    Z: np.ndarray
    shares: np.ndarray
    edges_m: tuple[float, ...]
    variants: Mapping[str, np.ndarray]

    @property
    def mean(self) -> np.ndarray:
        """The mean of both references."""
        return np.asarray(np.mean(self.halves, axis=0))


@dataclass(frozen=True)
class Band:
    """What one band of distances shows.

    share      of the picture that it fills in the reference
    luminance  mean luminance ÷ the reference's
    kept       structure that is kept, 1 = all; NaN where the reference has too little
    coverage   share of the picture ÷ the reference's; NaN for a picture without ``Z``
    """

    name: str
    share: float
    luminance: float
    kept: float
    coverage: float


@dataclass(frozen=True)
class Judged:
    """What one picture is worth.

    void       why it does not count; empty where it does
    cause      the mistake that explains its difference best, and how much it explains; empty = none
    flip       mean FLIP to the reference; ``floor`` that of one half to the other
    land, coverage   luminance and coverage of all land ÷ the reference's
    """

    void: str
    cause: str
    explains: float
    flip: float
    floor: float
    land: float
    coverage: float
    bands: tuple[Band, ...]

    def as_json(self) -> dict[str, Any]:
        """Return plain data, in which what is not known is null."""
        return plain(asdict(self))


def judge(path: str | Path, target: Target) -> Judged:
    """Judge a picture's file. Raises InputError where it is no OpenEXR file."""
    channels, _ = read_pixels(path)
    missing = [name for name in "RGB" if name not in channels]
    if missing:
        rule = "channels R, G and B of linear light"
        raise InputError(str(path), ", ".join(sorted(channels)) or "no channels", rule)
    picture = np.stack([np.asarray(channels[c], np.float64) for c in "RGB"], axis=2)
    Z = channels.get("Z")
    return judge_picture(picture, target, None if Z is None else np.asarray(Z, np.float64))


def judge_picture(picture: np.ndarray, target: Target, Z: np.ndarray | None = None) -> Judged:
    """Judge linear radiance, (h, w, 3), with the distance of what it shows where that is known."""
    whole = target.mean
    floor = _flip(*target.halves, auto_exposure(whole))
    if picture.shape != whole.shape:
        (h, w), (right_h, right_w) = picture.shape[:2], whole.shape[:2]
        cause = "half size" if (2 * h, 2 * w) == (right_h, right_w) else ""
        return _void(f"size: {w}x{h}, must be {right_w}x{right_h}", floor, cause)
    bad = ~np.isfinite(picture).all(axis=2)
    if bad.any():
        y, x = (int(each[0]) for each in np.nonzero(bad))
        told = f"{int(bad.sum())} pixels are not finite, the first in row {y}, column {x}"
        return _void(told, floor, "NaNs or infinities")
    light = picture @ LUMINANCE
    if light.mean() <= 0:
        return _void("no light", floor, "a black picture")
    exposure = auto_exposure(whole)
    bands = tuple(_bands(picture, target, Z))
    land = 1 - target.shares[-1]
    measured: dict[str, Any] = {
        "flip": _flip(picture, whole, exposure),
        "floor": floor,
        "land": _mean_under(light, land) / _mean_under(whole @ LUMINANCE, land),
        "coverage": math.nan if Z is None else float((Z < SKY_Z).mean() / land.mean()),
        "bands": bands,
    }
    found = best_cause(picture, whole, exposure, target.variants, target.Z)
    reasons = list(_reasons(picture, target, bands))
    if len(levels := _levels(picture)) <= 256:
        return Judged("", f"8 bit: {len(levels)} values of a channel", 1.0, **measured)
    if any(each.startswith("a copy") for each in reasons):
        named = "a copy of the reference", 1.0
    else:
        named = (found.name, round(found.explains, 4)) if found else ("", 0.0)
    free = ("blurred", "half size", "nothing beyond")  # what a method may do, by its error
    if found and not found.name.startswith(free) and named[0] == found.name:
        reasons = [f"another picture: {found.name}", *reasons]
        if not found.name.startswith(("camera", "field of view")):
            reasons = [each for each in reasons if not each.startswith("camera")]
    return Judged("; ".join(reasons), *named, **measured)


def _void(reason: str, floor: float, cause: str) -> Judged:
    nan = math.nan
    return Judged(reason, cause, 1.0 if cause else 0.0, nan, floor, nan, nan, ())


def _reasons(picture: np.ndarray, target: Target, bands: Sequence[Band]) -> list[str]:
    """Say what is wrong with a picture of the right size; nothing where all is within bounds."""
    found = []
    one, two = target.halves
    apart, noise = (each @ LUMINANCE for each in (picture - target.mean, (one - two) / 2))
    power = float((noise**2).sum())
    slope, error = float((apart * noise).sum()), float(np.sqrt(((apart * noise) ** 2).sum()))
    half = abs(slope) > max(_COPIED * power, 6 * error)
    if power and (half or float((apart**2).sum()) < (1 - _COPIED) * power):
        found.append("a copy: it has the reference's own noise")
    sky = target.shares[-1] > 0.99
    if sky.mean() >= LEAST_SHARE:
        ratio = float((picture[sky] @ LUMINANCE).sum() / (target.mean[sky] @ LUMINANCE).sum())
        if not abs(ratio - 1) <= MOST_SKY:
            found.append(f"light: the sky is {ratio:.3f} times as bright")
    exposure = auto_exposure(target.mean)
    pair = (to_srgb(each, exposure) @ LUMINANCE for each in (picture, target.mean))
    scale, dx, dy = registration(*pair)
    if not (abs(scale - 1) <= MOST_ZOOM and math.hypot(dx, dy) <= MOST_SHIFT_PX):
        moved = f"enlarged by {100 * (scale - 1):+.1f} %, moved by {dx:+.1f}, {dy:+.1f} px"
        near = abs(scale - 1) < LARGEST_FOV and math.hypot(dx, dy) < LARGEST_SHIFT_PX
        found.append(f"camera: {moved if near else 'nothing stands where it should'}")
    for band in bands[:-1]:
        if band.share >= LEAST_SHARE:
            if not abs(band.luminance - 1) <= MOST_LUMINANCE:
                found.append(f"{band.name}: luminance {band.luminance:.3f} times the reference's")
            if band.kept < LEAST_KEPT:
                found.append(f"{band.name}: {max(band.kept, 0):.0%} of its structure is kept")
            if not (math.isnan(band.coverage) or abs(math.log(max(band.coverage, 1e-9))) < 0.7):
                found.append(f"{band.name}: coverage {band.coverage:.2f} times the reference's")
    return found


def _bands(picture: np.ndarray, target: Target, Z: np.ndarray | None) -> list[Band]:
    lights = [each @ LUMINANCE for each in (picture, *target.halves)]
    reference = (lights[1] + lights[2]) / 2
    rough = [each - gaussian_filter(each, _STRUCTURE_PX, mode="nearest") for each in lights]
    edges = (*target.edges_m, math.inf)
    found = []
    for k, share in enumerate(target.shares):
        fills = float(share.mean())
        luminance = kept = coverage = math.nan
        if fills > 0:
            luminance = _mean_under(lights[0], share) / _mean_under(reference, share)
            both = float((share * rough[1] * rough[2]).sum())
            each = [float((share * r**2).sum()) for r in rough[1:]]
            if both > LEAST_STRUCTURE * math.sqrt(each[0] * each[1]):
                by_halves = [float((share * rough[0] * r).sum()) for r in rough[1:]]
                kept = sum(by_halves) / 2 / both
            if Z is not None:
                coverage = float(((edges[k] <= Z) & (Z < edges[k + 1])).mean()) / fills
        name = "sky" if k == len(target.shares) - 1 else band_name(edges, k)
        found.append(Band(name, fills, luminance, kept, coverage))
    return found


def _mean_under(light: np.ndarray, share: np.ndarray) -> float:
    return float((light * share).sum() / share.sum())


def _flip(tested: np.ndarray, reference: np.ndarray, exposure: float) -> float:
    one, two = (to_srgb(each, exposure).astype(np.float32) for each in (tested, reference))
    return mean_flip(one, two)


def _levels(picture: np.ndarray) -> np.ndarray:
    return max((np.unique(picture[..., c]) for c in range(3)), key=len)


def difference_map(picture: np.ndarray, target: Target) -> np.ndarray:
    """Return FLIP of every pixel in its authors' colours, (h, w, 3); what is not finite is white.

    A picture of another size is held against the reference as far as both reach.
    """
    whole = target.mean
    h, w = (min(n) for n in zip(picture.shape[:2], whole.shape[:2], strict=True))
    tested, reference, exposure = picture[:h, :w], whole[:h, :w], auto_exposure(whole)
    bad = ~np.isfinite(tested).all(axis=2)
    shown = [
        to_srgb(np.where(bad[..., None], 0, each), exposure).astype(np.float32)
        for each in (tested, reference)
    ]
    return np.where(bad[..., None], 1.0, flip_map(*shown))


# The score.


@dataclass(frozen=True)
class Timed:
    """One setting of a submission in one world: its error, whether it counts, and its seconds."""

    flip: float
    counts: bool
    seconds: float


@dataclass(frozen=True)
class Score:
    """Time to the error that ``blake`` has at one pixel, ÷ that of the published baseline.

    ratio   of times; NaN where the error is not reached, or nothing was timed
    told    why, or that it is an upper bound, because every setting is within the error
    """

    ratio: float
    told: str = field(default="")


def score(runs: Sequence[Timed], flip: float, baseline_s: float) -> Score:
    """Read the time at an error from settings, and divide it by the baseline's."""
    able = sorted((r for r in runs if r.counts), key=lambda r: r.flip)
    within = [r for r in able if r.flip <= flip]
    if not within:
        return Score(math.nan, "void" if runs and not able else "error not reached")
    timed = [r for r in within if math.isfinite(r.seconds)]
    if not timed:
        return Score(math.nan, "no seconds")
    best = min(timed, key=lambda r: r.seconds)
    beyond = [r for r in able if r.flip > flip and r.seconds < best.seconds]
    if not beyond:
        return Score(best.seconds / baseline_s, "at most: every setting is within the error")
    other = min(beyond, key=lambda r: r.flip)
    share = math.log(flip / best.flip) / math.log(other.flip / best.flip)
    seconds = math.exp((1 - share) * math.log(best.seconds) + share * math.log(other.seconds))
    return Score(seconds / baseline_s)


def plain(value: Any) -> Any:
    """Return plain data with numbers to six digits, and null for those that are not finite."""
    match value:
        case dict():
            return {k: plain(v) for k, v in value.items()}
        case list() | tuple():
            return [plain(v) for v in value]
        case float():
            return float(f"{round(value, 12):.6g}") + 0.0 if math.isfinite(value) else None
    return value
