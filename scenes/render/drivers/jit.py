"""A frame in a JIT variant: wavefronts of samples from Dr.Jit, with haze on every sample."""

import math
from dataclasses import replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from lod.air import Mist, haze_extinction, mist_extinction
from scenes.frame.frame_input import Quality, SampleWatch, sampler_seed
from scenes.render.build import GUIDES, BuiltScene, pinhole, sensor
from scenes.render.drivers.camera_rays import in_window, pixel_sums, sample_groups, sample_rays
from scenes.render.drivers.samples import Samples
from scenes.render.haze import Haze, in_scattered_light
from scenes.render.scattered_layer import NEAR_M, RATIO

_IMAGE_CHANNELS = 4
"""R, G, B and A of the image come before the guides."""

_SMALL = 2e-3
"""Below it (1 − exp(−x))/x is 1 − x/2, in float32 more exactly than by its own formula."""

_NO_END = 1e30


def render_jit(
    built: BuiltScene, haze: Haze, quality: Quality, frame: int, watch: SampleWatch
) -> Samples:
    """Render group by group of samples, run by run of pixels.

    The sample that Z, N and the ids come from is each pixel's first, somewhere in the pixel; with
    a lens, one more through the lens's centre.
    """
    width, height = built.description["camera"]["size"]
    window = quality.window_of((width, height))
    total = Samples.zeros(window, width)
    view = sensor(built.description["camera"])
    for number, spp in enumerate(sample_groups(quality.spp)):
        step = max(1, quality.most_samples // spp)
        for first in range(0, width * height, step):
            pixels = slice(first, min(first + step, width * height))
            if not window.share(pixels, width)[0].any():
                continue
            seed = sampler_seed(quality.seed, frame, number, first)
            group = replace(quality, spp=spp, seed=seed)
            _wavefront(built, haze, view, total, group, pixels, keep=number == 0)
            watch(spp * int(np.count_nonzero(window.share(pixels, width)[0])))
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
    traced = in_window(group.window_of(size), size, pixels, group.spp)
    colour, _, values = built.integrators["all"].sample(built.scene, sampler, ray, None, traced)
    guides = values[_IMAGE_CHANNELS:]
    finite = dr.all(dr.isfinite(colour))
    colour = composite_haze(haze, dr.select(finite, colour, 0.0), guides[0], ray.d)
    # All outputs together, or every channel would trace the scene again.
    bad = dr.select(finite, mi.UInt32(0), mi.UInt32(1))
    dr.eval(colour, guides, bad)
    _add(total, colour, guides, pixels, group.spp, keep)
    if keep and built.description["camera"]["lens"]:
        _keep_sharp(built, total, group, pixels)
    if group.coverage:
        every = np.stack([np.array(guide) for guide in guides], axis=-1)
        total.count_objects(built, pixels, every.reshape(-1, group.spp, len(guides)))
    total.replaced += int(dr.sum(bad)[0])


def _add(
    total: Samples, colour: Any, guides: list[Any], pixels: slice, spp: int, keep: bool
) -> None:
    total.add("rgb", pixels, pixel_sums(colour, spp))
    total.add("albedo", pixels, pixel_sums(guides[GUIDES["albedo"]], spp))
    if keep:
        first = dr.arange(mi.UInt32, pixels.stop - pixels.start) * spp
        chosen = [np.array(dr.gather(mi.Float, guide, first)) for guide in guides]
        total.keep(pixels, np.stack(chosen, axis=-1))


def _keep_sharp(built: BuiltScene, total: Samples, group: Quality, pixels: slice) -> None:
    """Keep what one ray of each pixel meets through the centre of the lens."""
    camera = built.description["camera"]
    sampler, ray = sample_rays(
        sensor(pinhole(camera)), camera["size"], pixels, replace(group, spp=1)
    )
    _, _, guides = built.integrators["guides"].sample(built.scene, sampler, ray)
    dr.eval(guides)
    total.keep(pixels, np.stack([np.array(guide) for guide in guides], axis=-1))


def composite_haze(haze: Haze, radiance: Any, distance: Any, direction: Any) -> Any:
    """Apply L·T + L_air·(1 − T) to samples; distance 0 says that a sample met nothing.

    scalar_passes.composite_haze does the same to whole pixels: the two change together. The path of
    each sample is known here, so that one that goes level or lower (``<= horizon_sine``) shows the
    airlight, and any other the sky. Of a pixel only the centre is known there, and the comparison
    leaves room for the rays about it. Level rays count as below: with scattered haze horizon_sine
    is 0, and a level ray never leaves the layer.
    """
    depth = distance * _kernel_input(haze_extinction(haze.air, haze.wavelengths))
    if haze.air.mist:
        metres = mist_equivalent_length(
            haze.air.mist, haze.eye_m, distance, direction.z, haze.horizon_sine
        )
        depth += metres * _kernel_input(mist_extinction(haze.air, haze.wavelengths))
    airlight = airlight_along(haze, direction, dr.select(distance > 0, distance, _NO_END))
    below_horizon = direction.z <= haze.horizon_sine
    above = radiance if haze.sky_table is None else visible_sky(haze.sky_table, direction)
    sky = dr.select(below_horizon, airlight, above)
    disc = dr.dot(direction, mi.Vector3f(_kernel_input(haze.to_sun))) > haze.sun_cosine
    sky += dr.select(disc, _kernel_input(haze.sun), 0.0)
    if haze.sky_table is not None:  # the table includes what the air does to the sky
        depth = dr.select(distance > 0, depth, 0.0)
    transmittance = dr.exp(-depth)
    added = in_scattered_light(airlight, transmittance)
    return dr.fma(dr.select(distance > 0, radiance, sky), transmittance, added)


def mist_equivalent_length(
    mist: Mist, eye_m: float, distance: Any, rise: Any, horizon_sine: float
) -> Any:
    """Length [m] of a path at the mist's base with as much mist as each ray, on Dr.Jit arrays.

    lod.air and haze.mist_transmittance do the same for NumPy arrays.
    """
    scale = dr.opaque(mi.Float, mist.scale_m)
    start = dr.opaque(mi.Float, eye_m - mist.base_m)
    end = dr.fma(distance, rise, start)
    lower, upper = dr.minimum(start, end), dr.maximum(start, end)
    lower_above, upper_above = dr.maximum(lower, 0.0), dr.maximum(upper, 0.0)
    above = dr.select(upper > lower, (upper_above - lower_above) / (upper - lower), 1.0)
    x = (upper_above - lower_above) / scale
    mean = dr.select(x > _SMALL, (1 - dr.exp(-x)) / x, 1 - x / 2)
    share = 1 - above + above * mean * dr.exp(-lower_above / scale)
    beyond = dr.maximum(-start, 0.0) + scale * dr.exp(-dr.maximum(start, 0.0) / scale)
    return dr.select(distance > 0, distance * share, beyond / dr.maximum(rise, horizon_sine))


def _kernel_input(values: np.ndarray) -> Any:
    """Make three numbers an input of the kernel (``dr.opaque``), not constants in its code.

    This is a barrier to Dr.Jit's optimiser: a kernel is not compiled anew when the numbers change.
    """
    return mi.Color3f([dr.opaque(mi.Float, float(value)) for value in values])


def airlight_along(haze: Haze, direction: Any, distance: Any) -> Any:
    """Look up the airlight as haze.airlight_along does, for Dr.Jit arrays."""
    table = haze.airlight_table
    planes, rows = table.shape[:2]
    flat = table.reshape(planes * rows, *table.shape[2:])
    root = dr.mulsign(dr.sqrt(dr.abs(direction.z)), direction.z)
    row = dr.clip((root + 1) / 2 * (rows - 1), 0.0, rows - 1.0)
    if planes == 1:
        return _interpolate(flat, row, direction)
    plane = dr.log(dr.maximum(distance, NEAR_M) / NEAR_M) / math.log(RATIO)
    plane = dr.clip(plane, 0.0, planes - 1.0)
    near_plane = dr.floor(plane)
    far_plane = dr.minimum(near_plane + 1, planes - 1.0)
    near = _interpolate(flat, near_plane * rows + row, direction)
    far = _interpolate(flat, far_plane * rows + row, direction)
    return dr.fma(far - near, plane - near_plane, near)


def visible_sky(table: np.ndarray, direction: Any) -> Any:
    """Look up the sky in a table as haze.sky_through_air does, for Dr.Jit arrays."""
    row = dr.sqrt(dr.maximum(direction.z, 0.0)) * (len(table) - 1)
    return _interpolate(table, row, direction)


def _interpolate(table: np.ndarray, row: Any, direction: Any) -> Any:
    """Interpolate as direction_table.interpolate does in a direction's azimuth, for Dr.Jit."""
    rows, columns = table.shape[:2]
    values = mi.Float(table.astype(np.float32).reshape(-1))
    turn = dr.atan2(direction.x, direction.y) / (2 * math.pi)
    row, column = dr.clip(row, 0.0, rows - 1.0), (turn - dr.floor(turn)) * columns
    lower, left = mi.UInt32(row), mi.UInt32(column)
    up_share, right_share = row - mi.Float(lower), column - mi.Float(left)
    upper, left, right = dr.minimum(lower + 1, rows - 1), left % columns, (left + 1) % columns

    def between(line: Any) -> Any:
        first = dr.gather(mi.Color3f, values, line * columns + left)
        last = dr.gather(mi.Color3f, values, line * columns + right)
        return dr.fma(last - first, right_share, first)

    below = between(lower)
    return dr.fma(between(upper) - below, up_share, below) if rows > 1 else below
