"""A frame in a JIT variant: wavefronts of samples from Dr.Jit, with haze on every sample."""

from dataclasses import replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from scenes.frame.frame_input import Quality, SampleWatch, sampler_seed
from scenes.render.build import GUIDES, BuiltScene, pinhole, sensor
from scenes.render.camera_rays import pixel_sums, sample_groups, sample_rays
from scenes.render.haze import Haze, JitArrays, air_along
from scenes.render.integrator import trace_guides, trace_paths
from scenes.render.samples import Samples


def render_jit(
    built: BuiltScene, haze: Haze, quality: Quality, frame: int, watch: SampleWatch
) -> Samples:
    """Render group by group of samples, run by run of pixels.

    The sample that Z, N and the ids come from is each pixel's first, somewhere in the pixel; with
    a lens, one more through the lens's centre.
    """
    camera = built.description["camera"]
    total = Samples.none_of(built, quality)
    view = sensor(camera)
    for number, spp in enumerate(sample_groups(quality.spp)):
        step = max(1, quality.most_samples // spp)
        for pixels, taken in total.runs(camera["size"][1], step):
            seed = sampler_seed(quality.seed, frame, number, pixels.start)
            group = replace(quality, spp=spp, seed=seed)
            first = _add_run(total, built, haze, view, pixels, group)
            if number == 0:
                if camera["lens"]:  # what one ray of each pixel meets through the lens's centre
                    single = replace(group, spp=1)
                    _, ray = sample_rays(sensor(pinhole(camera)), camera["size"], pixels, single)
                    dr.eval(guides := trace_guides(built, ray, traced=True)[0])
                    first = np.stack([np.array(guide) for guide in guides], axis=-1)
                total.keep(pixels, first)
            watch(spp * taken)
    total.rgb /= quality.spp
    total.albedo /= quality.spp
    return total


def _add_run(
    total: Samples, built: BuiltScene, haze: Haze, view: Any, pixels: slice, group: Quality
) -> np.ndarray:
    """Add a group of samples of each pixel of a run; gives the first's guides, (n, channels)."""
    camera, spp = built.description["camera"], group.spp
    sampler, ray = sample_rays(view, camera["size"], pixels, group)
    traced: Any = True
    if not total.window.is_all_of(camera["size"]):
        # Rays beside the window are seeded all the same, so that each pixel has the samples that it
        # has in the whole picture.
        traced = mi.Bool(total.window.share(pixels, total.width)[0].repeat(spp))
    # Radiance and what was met, of every sample; then the air between, unless it is a medium.
    colour, guides = trace_paths(built, sampler, ray, traced)
    finite = dr.all(dr.isfinite(colour))
    colour = dr.select(finite, colour, 0.0)
    if not built.medium:
        below_horizon = ray.d.z <= haze.horizon_sine
        transmittance, added = air_along(haze, guides[0], ray.d, below_horizon, JitArrays)
        colour = dr.fma(colour, transmittance, added)
    # All outputs together, or every channel would trace the scene again.
    bad = dr.select(finite, mi.UInt32(0), mi.UInt32(1))
    dr.eval(colour, guides, bad)
    total.add("rgb", pixels, pixel_sums(colour, spp))
    total.add("albedo", pixels, pixel_sums(guides[GUIDES["albedo"]], spp))
    total.replaced += int(dr.sum(bad)[0])
    if group.coverage:
        every = np.stack([np.array(guide) for guide in guides], axis=-1)
        total.count_objects(built, pixels, every.reshape(-1, spp, len(guides)))
    return np.stack([np.array(guide)[::spp] for guide in guides], axis=-1)
