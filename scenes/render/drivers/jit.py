"""A frame in a JIT variant: wavefronts of samples from Dr.Jit, with haze on every sample."""

import math
from dataclasses import replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from lod.atmosphere.air import haze_extinction, mist_extinction
from lod.atmosphere.mist import Mist
from scenes.frame.quality import Quality, sampler_seed
from scenes.render.drivers.accumulate import Samples, Watch
from scenes.render.drivers.camera_rays import pixel_sums, sample_rays
from scenes.render.drivers.sample_counts import sample_groups
from scenes.render.haze.haze import Haze
from scenes.render.haze.scattered_layer import NEAR_M, RATIO
from scenes.render.mitsuba.build import GUIDES, BuiltScene, sensor

_IMAGE_CHANNELS = 4
"""R, G, B and A of the image come before the guides."""

_SMALL = 2e-3
"""Below it (1 − exp(−x))/x is 1 − x/2, in float32 more exactly than by its own formula."""

_NO_END = 1e30


def render_jit(
    built: BuiltScene, haze: Haze, quality: Quality, frame: int, watch: Watch
) -> Samples:
    """Render group by group of samples, run by run of pixels.

    The sample that Z, N and the ids come from is each pixel's first, somewhere in the pixel.
    """
    width, height = built.description["camera"]["size"]
    total = Samples.zeros(width, height)
    view = sensor(built.description["camera"])
    for number, spp in enumerate(sample_groups(quality.spp)):
        step = max(1, quality.most_samples // spp)
        for first in range(0, width * height, step):
            pixels = slice(first, min(first + step, width * height))
            seed = sampler_seed(quality.seed, frame, number, first)
            group = replace(quality, spp=spp, seed=seed)
            _wavefront(built, haze, view, total, group, pixels, keep=number == 0)
            watch(spp * (pixels.stop - pixels.start))
    total.rgb /= quality.spp
    total.albedo /= quality.spp
    return total


def _wavefront(
    built: BuiltScene,
    haze: Haze,
    view: Any,
    total: Samples,
    group: Quality,
    pixels: slice,
    keep: bool,
) -> None:
    """Add a group of samples of each pixel of a run to ``total``."""
    size = built.description["camera"]["size"]
    sampler, ray = sample_rays(view, size, pixels, group)
    # Radiance and what was met, of every sample; then the air in between.
    colour, _, values = built.integrators["all"].sample(built.scene, sampler, ray)
    guides = values[_IMAGE_CHANNELS:]
    finite = dr.all(dr.isfinite(colour))
    colour = _hazy(haze, dr.select(finite, colour, 0.0), guides[0], ray.d)
    # All outputs together, or every channel would trace the scene again.
    bad = dr.select(finite, mi.UInt32(0), mi.UInt32(1))
    dr.eval(colour, guides, bad)
    _add(total, colour, guides, pixels, group.spp, keep)
    total.replaced += int(dr.sum(bad)[0])


def _add(
    total: Samples, colour: Any, guides: list[Any], pixels: slice, spp: int, keep: bool
) -> None:
    rgb, albedo = total.rgb.reshape(-1, 3)[pixels], total.albedo.reshape(-1, 3)[pixels]
    rgb += pixel_sums(colour, spp)
    albedo += pixel_sums(guides[GUIDES["albedo"]], spp)
    if keep:
        first = dr.arange(mi.UInt32, pixels.stop - pixels.start) * spp
        chosen = [np.array(dr.gather(mi.Float, guide, first)) for guide in guides]
        total.keep(pixels, np.stack(chosen, axis=-1))


def _hazy(haze: Haze, colour: Any, distance: Any, direction: Any) -> Any:
    """Radiance of samples in their air; distance 0 means that nothing was met."""
    depth = distance * _opaque(haze_extinction(haze.air, haze.wavelengths))
    if haze.air.mist:
        metres = _mist_metres(haze.air.mist, haze.eye_m, distance, direction.z, haze.lowest)
        depth += metres * _opaque(mist_extinction(haze.air, haze.wavelengths))
    air = _airlight(haze, direction, dr.select(distance > 0, distance, _NO_END))
    low = direction.z <= haze.lowest
    sky = dr.select(low, air, colour if haze.seen is None else _visible_sky(haze.seen, direction))
    disc = dr.dot(direction, mi.Vector3f(_opaque(haze.to_sun))) > haze.sun_cosine
    sky += dr.select(disc, _opaque(haze.sun), 0.0)
    if haze.seen is not None:  # which holds what the air does to the sky
        depth = dr.select(distance > 0, depth, 0.0)
    through = dr.exp(-depth)
    return dr.fma(dr.select(distance > 0, colour, sky), through, air * (1 - through))


def _mist_metres(mist: Mist, eye_m: float, distance: Any, rise: Any, lowest: float) -> Any:
    """Metres at its base that hold as much mist as each ray: mist.mean_share and depth_beyond."""
    scale = dr.opaque(mi.Float, mist.scale_m)
    start = dr.opaque(mi.Float, eye_m - mist.base_m)
    end = dr.fma(distance, rise, start)
    low, high = dr.minimum(start, end), dr.maximum(start, end)
    low_above, high_above = dr.maximum(low, 0.0), dr.maximum(high, 0.0)
    above = dr.select(high > low, (high_above - low_above) / (high - low), 1.0)
    x = (high_above - low_above) / scale
    mean = dr.select(x > _SMALL, (1 - dr.exp(-x)) / x, 1 - x / 2)
    share = 1 - above + above * mean * dr.exp(-low_above / scale)
    beyond = dr.maximum(-start, 0.0) + scale * dr.exp(-dr.maximum(start, 0.0) / scale)
    return dr.select(distance > 0, distance * share, beyond / dr.maximum(rise, lowest))


def _opaque(values: np.ndarray) -> Any:
    """Three numbers as memory, not as code: the kernel stays the same when they change."""
    return mi.Color3f([dr.opaque(mi.Float, float(value)) for value in values])


def _airlight(haze: Haze, direction: Any, distance: Any) -> Any:
    """Look up the airlight as haze.airlight_along does, for Dr.Jit arrays."""
    planes, rows = haze.airlight.shape[:2]
    flat = haze.airlight.reshape(planes * rows, *haze.airlight.shape[2:])
    root = dr.mulsign(dr.sqrt(dr.abs(direction.z)), direction.z)
    row = dr.clip((root + 1) / 2 * (rows - 1), 0.0, rows - 1.0)
    if planes == 1:
        return _interpolate(flat, row, direction)
    plane = dr.log(dr.maximum(distance, NEAR_M) / NEAR_M) / math.log(RATIO)
    plane = dr.clip(plane, 0.0, planes - 1.0)
    low = dr.floor(plane)
    near = _interpolate(flat, low * rows + row, direction)
    far = _interpolate(flat, dr.minimum(low + 1, planes - 1.0) * rows + row, direction)
    return dr.fma(far - near, plane - low, near)


def _visible_sky(seen: np.ndarray, direction: Any) -> Any:
    """Look up the sky as it is seen, by direction_table.row_upper, for Dr.Jit arrays."""
    row = dr.sqrt(dr.maximum(direction.z, 0.0)) * (len(seen) - 1)
    return _interpolate(seen, row, direction)


def _interpolate(table: np.ndarray, row: Any, direction: Any) -> Any:
    """Interpolate in a direction's azimuth as direction_table does, for Dr.Jit arrays."""
    rows, columns = table.shape[:2]
    values = mi.Float(table.astype(np.float32).reshape(-1))
    turn = dr.atan2(direction.x, direction.y) / (2 * math.pi)
    row, column = dr.clip(row, 0.0, rows - 1.0), (turn - dr.floor(turn)) * columns
    low, left = mi.UInt32(row), mi.UInt32(column)
    down, across = row - mi.Float(low), column - mi.Float(left)
    high, left, right = dr.minimum(low + 1, rows - 1), left % columns, (left + 1) % columns

    def between(line: Any) -> Any:
        first = dr.gather(mi.Color3f, values, line * columns + left)
        return dr.fma(dr.gather(mi.Color3f, values, line * columns + right) - first, across, first)

    lower = between(low)
    return dr.fma(between(high) - lower, down, lower) if rows > 1 else lower
