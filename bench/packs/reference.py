"""The reference of one camera: two independent halves, their noise, and light and cover by band.

A half is the mean of passes of PASS samples a pixel; a pass has seeds of its own, so that halves
are independent, and the error between them at n samples shows whether they converge as 1/n. A
pass's Z is one sample of each pixel: all passes together tell how much of the picture each band of
distance covers, and the land's mean luminance there.
"""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from bench.images.differences import BAND_EDGES_M, EPSILON, mean_flip
from scenes.frame.frame_input import Quality
from scenes.frame.layers import SKY_Z
from scenes.render.pictures import auto_exposure, to_srgb
from scenes.render.render import BuiltFrame, trace
from scenes.sticks.prototype import LUMINANCE

PASS = 16  # samples of a pass, and the least of a half
HALVES = 0, 10_000  # first frame numbers of the samples of each half

EDGES_M = np.array((*BAND_EDGES_M, float(SKY_Z)))


def render_reference(
    built: BuiltFrame, quality: Quality, spp: int, half_floats: bool
) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Render a reference of ``spp`` samples a pixel; gives its channels and what is known of it."""
    passes = max(1, spp // (2 * PASS))
    of_pass = min(PASS, max(1, spp // 2))
    sums = np.zeros((2, *reversed(built.scene.description["camera"]["size"]), 3))
    Z, bands, covered, convergence = np.zeros((0, 0)), [], np.zeros(0), []
    for k in range(passes):
        for half, first in enumerate(HALVES):
            layers = trace(built, replace(quality, spp=of_pass), first + k)
            sums[half] += layers.rgb
            which = np.digitize(layers.Z.astype(np.float64), EDGES_M[1:])
            shares = which[..., None] == np.arange(len(EDGES_M))
            covered = shares + (covered if covered.size else 0.0)
            bands.append(_by_band(layers.rgb @ LUMINANCE, shares))
            Z = Z if Z.size else layers.Z
        done = k + 1
        if done & (done - 1) == 0 or done == passes:
            pair = sums / done
            found = errors_between(pair[0], pair[1])
            convergence.append({"spp": of_pass * done, **found})
    pair = sums / passes
    mean = pair.mean(axis=0)
    colour = np.float16 if half_floats else np.float32
    channels = {name: mean[..., i].astype(colour) for i, name in enumerate("RGB")}
    channels["Z"] = Z.astype(np.float32)
    if not half_floats:
        for name, half in zip("ab", pair, strict=True):
            channels |= {
                f"{name}.{c}": half[..., i].astype(np.float16) for i, c in enumerate("RGB")
            }
        cover = (covered / (2 * passes)).astype(np.float16)
        channels |= {f"cover.{k}": cover[..., k] for k in range(len(EDGES_M) - 1)}
    height, width = Z.shape
    about = {
        "size": [width, height],
        "spp": 2 * passes * of_pass,
        "noise": {key: convergence[-1][key] for key in ("flip", "relmse")},
        "convergence": convergence,
        "relmse_slope": _slope(convergence),
        "bands": _bands(np.array(bands)),
    }
    return channels, about


def errors_between(one: np.ndarray, other: np.ndarray) -> dict[str, float]:
    """Return mean FLIP and relMSE of two pictures of linear radiance, the second the reference."""
    exposure = auto_exposure(other)
    a, b = (to_srgb(np.maximum(e, 0.0), exposure).astype(np.float32) for e in (one, other))
    square = ((one - other) * exposure) ** 2 / ((other * exposure) ** 2 + EPSILON)
    return {"flip": mean_flip(a, b), "relmse": float(square.mean())}


def _by_band(luminance: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Share of the picture and mean luminance of each band, (bands, 2); NaN where it is empty."""
    count = shares.sum(axis=(0, 1))
    light = np.array([luminance[shares[..., k]].sum() for k in range(shares.shape[-1])])
    with np.errstate(invalid="ignore"):
        return np.stack((count / luminance.size, light / count), axis=1)


def _bands(passes: np.ndarray) -> list[dict[str, Any]]:
    """Means over passes (p, bands, 2) with their standard errors; None of what is not there."""
    n, found = len(passes), []
    for row, low in enumerate((*BAND_EDGES_M, None)):
        numbers: list[float | None] = []
        for column in range(2):
            values = passes[:, row, column]
            values = values[np.isfinite(values)]
            error = float(values.std(ddof=1) / math.sqrt(n)) if len(values) > 1 else None
            numbers += [float(values.mean()) if len(values) else None, error]
        names = ("coverage", "coverage_se", "luminance", "luminance_se")
        found.append({"from_m": low, **dict(zip(names, numbers, strict=True))})
    return found


def _slope(convergence: list[dict[str, float]]) -> float | None:
    """Slope of log relMSE by log samples; None of fewer than two counts."""
    if len(convergence) < 2:
        return None
    samples, error = (np.log([each[k] for each in convergence]) for k in ("spp", "relmse"))
    return float(np.polyfit(samples, error, 1)[0])
