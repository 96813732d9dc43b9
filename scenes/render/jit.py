"""A frame in a JIT variant: wavefronts of samples from Dr.Jit, with haze on every sample.

Paths of light say what camera rays meet, and the radiance that comes along them. All is diffuse.
The sun is sampled at every vertex, and so is one of the surfaces that give light, if there are any;
the sky is met only by rays that surfaces send by the law of the cosine. Guides are of the path's
own first hit. The ray behind the last vertex asks only whether it meets anything: that would send
no light that counts. Means are those of Mitsuba's ``path`` of the same depth.
"""

from dataclasses import replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from scenes.frame.frame_input import Quality, SampleWatch, sampler_seed
from scenes.render.build import GUIDES, BuiltScene, Surfaces
from scenes.render.haze import Haze, JitArrays, air_along
from scenes.render.samples import Samples, pinhole, pixel_sums, sample_groups, sample_rays, sensor

_ROULETTE_DEPTH, _SURVIVAL = 1, 3.0
"""Edges of a path after which Russian roulette decides whether it goes on, and the chance that it
does ÷ the largest share of light that is left: docs/frames.md ("What a ray costs") has others."""


def trace_guides(built: BuiltScene, ray: Any, traced: Any) -> tuple[list[Any], tuple[Any, Any]]:
    """Trace what those rays meet first that are ``traced``.

    Gives an array for each channel of build.GUIDES, 0 where nothing is met; and the hit itself,
    found and completed. Of a box that bends no light nothing is said.
    """
    hit = built.scene.ray_intersect_preliminary(ray, coherent=True, active=traced)
    first = built.surfaces.complete(ray, hit, traced)
    si = first.si
    met = si.is_valid() & ~first.bends_none
    numbers = first.number, si.prim_index
    found = [si.t, *si.sh_frame.n, *first.albedo, *map(mi.Float, numbers)]
    if built.description["after"]:
        found += [*si.p]
    return [dr.select(met, value, 0.0) for value in found], (hit, first)


def trace_paths(built: BuiltScene, sampler: Any, ray: Any, traced: Any) -> tuple[Any, list[Any]]:
    """Trace the radiance along those rays that are ``traced``, and guides as ``trace_guides`` does.

    The paths have at most as many edges as the description's ``max_depth`` says. There is no air,
    but a medium, through which the renderer traces them.
    """
    guides, (hit, first) = trace_guides(built, ray, traced)
    scene, surfaces, si = built.scene, built.surfaces, first.si
    edges = built.description["integrator"]["max_depth"]
    if built.medium:
        light, _, _ = built.integrators["medium"].sample(scene, sampler, ray, built.medium, traced)
        return light, guides
    lights = _Lights(scene, surfaces)
    light = mi.Color3f(0.0)
    if lights.surfaces:
        light = dr.select(si.is_valid(), first.emitted, light)
    # What is left of a path where it meets the sky, and its direction there: it meets it once.
    at_sky = mi.Color3f(dr.select(traced & ~si.is_valid(), 1.0, 0.0)), mi.Vector3f(ray.d)
    ray, left, edge = mi.Ray3f(ray), mi.Color3f(1.0), mi.UInt32(1)

    def go_on(sampler: Any, ray: Any, hit: Any, active: Any, *sums: Any, last: bool = False) -> Any:
        left, light, (share, direction), edge = sums
        si, _, albedo, _, reflects, _ = surfaces.complete(ray, hit, active)
        left = left * albedo
        active &= reflects & (dr.max(left) > 0)
        side = dr.mulsign(mi.Float(1.0), si.wi.z)
        light = light + left * lights.reflected(si, side, sampler, active)
        local = mi.warp.square_to_cosine_hemisphere(sampler.next_2d(active))
        ray = si.spawn_ray(si.sh_frame.to_world(mi.Vector3f(local.x, local.y, local.z * side)))
        if last and not lights.surfaces:
            active &= ray.d.z > 0
            met = scene.ray_test(ray, active)
        else:
            hit = scene.ray_intersect_preliminary(ray, coherent=False, active=active)
            met = hit.is_valid()
            light += left * lights.met(si, ray, hit, local.z * dr.inv_pi, active & met)
        share = dr.select(active & ~met, left, share)
        direction = dr.select(active & ~met, ray.d, direction)
        active, edge = active & met, edge + 1
        if edges > _ROULETTE_DEPTH + 1:
            survival, decide = dr.minimum(_SURVIVAL * dr.max(left), 1.0), edge > _ROULETTE_DEPTH
            active &= ~decide | (sampler.next_1d(active) < survival)
            left = dr.select(decide & active, left / survival, left)
        return sampler, ray, hit, active, left, light, (share, direction), edge

    state = sampler, ray, hit, si.is_valid(), left, light, at_sky, edge
    if edges > 1:
        last_edge = dr.opaque(mi.UInt32, edges - 1)
        state = dr.while_loop(state, lambda *now: now[3] & (now[-1] < last_edge), go_on)
        state = go_on(*state, last=True)
    *_, light, (share, direction), _ = state
    sky = dr.zeros(mi.SurfaceInteraction3f, dr.width(direction))
    sky.wi = -direction
    return light + share * scene.environment().eval(sky), guides


class _Lights:
    """The lights of a scene but for its sky: the sun, and surfaces, sampled with equal chances."""

    def __init__(self, scene: Any, surfaces: Surfaces) -> None:
        self._scene, self._shapes = scene, surfaces
        names = [each.id() for each in scene.emitters()]
        self._sun = scene.emitters()[names.index("sun")]
        self.surfaces = [row for row, name in enumerate(names) if name not in ("sky", "sun")]
        self._count = dr.opaque(mi.Float, len(self.surfaces))

    def reflected(self, si: Any, side: Any, sampler: Any, active: Any) -> Any:
        """Estimate the radiance that white surfaces reflect of the lights, each at its ``side``."""
        to_sun, irradiance = self._sun.sample_direction(si, mi.Point2f(0.0), active)
        light = self._seen(si, side, to_sun.d, si.spawn_ray(to_sun.d), active) * irradiance
        if self.surfaces:
            which, across = sampler.next_2d(active)
            which *= self._count
            number = mi.UInt32(dr.minimum(which, self._count - 1))
            row = dr.gather(mi.UInt32, mi.UInt32(self.surfaces), number, active)
            emitter = dr.gather(mi.EmitterPtr, self._scene.emitters_dr(), row, active)
            at = mi.Point2f(which - number, across)
            there, weight = emitter.sample_direction(si, at, active)
            share = self._seen(si, side, there.d, si.spawn_ray_to(there.p), active)
            chance = there.pdf / self._count  # 0 behind the surface
            light += (
                dr.select(chance > 0, share * weight * _power(chance, share), 0.0) * self._count
            )
        return light

    def met(self, si: Any, ray: Any, hit: Any, density: Any, active: Any) -> Any:
        """Estimate the same of surfaces, by rays of a ``density`` by solid angle that met them."""
        if not self.surfaces:
            return mi.Color3f(0.0)
        there = self._shapes.complete(ray, hit, active)
        sample = mi.DirectionSample3f(self._scene, there.si, si)
        other = there.si.shape.emitter().pdf_direction(si, sample, active) / self._count
        return dr.select(active, there.emitted, 0.0) * _power(density, other)

    def _seen(self, si: Any, side: Any, direction: Any, ray: Any, active: Any) -> Any:
        """cos θ / π of a direction in which a light is seen, 0 of another."""
        cosine = dr.dot(si.sh_frame.n, direction) * side
        active = active & (cosine > 0)
        return dr.select(active & ~self._scene.ray_test(ray, active), cosine * dr.inv_pi, 0.0)


def _power(own: Any, other: Any) -> Any:
    """Weight of a sample by Veach's power heuristic, given its density in two ways of sampling."""
    return dr.select(own > 0, dr.square(own) / (dr.square(own) + dr.square(other)), 0.0)


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
