"""A frame in a JIT variant: wavefronts of samples from Dr.Jit, with haze on every sample."""

from dataclasses import replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from scenes.frame.frame_input import Quality, SampleWatch, sampler_seed
from scenes.render.build import GUIDES, BuiltScene, pinhole, sensor
from scenes.render.drivers.camera_rays import in_window, pixel_sums, sample_groups, sample_rays
from scenes.render.drivers.samples import Samples
from scenes.render.haze import Haze, JitArrays, air_along

_IMAGE_CHANNELS = 4
"""R, G, B and A of the image come before the guides."""


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
    below_horizon = ray.d.z <= haze.horizon_sine
    transmittance, added = air_along(haze, guides[0], ray.d, below_horizon, JitArrays)
    colour = dr.fma(dr.select(finite, colour, 0.0), transmittance, added)
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
