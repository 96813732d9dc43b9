"""Processor's time of the rays of a built frame, without air: ours, Mitsuba's, intersections alone.

All have the same camera rays, run by run of pixels as a frame has them. Mitsuba's is its ``path``
under its ``aov``, which give the same radiance and guides. The floor intersects, and does nothing
else, the very rays that our integrator sends: it traces them once with its loop evaluated edge by
edge, so that they can be kept.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import islice
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from scenes.frame.frame_input import Quality, sampler_seed
from scenes.render.build import GUIDES, BuiltScene, load_plugin
from scenes.render.jit import trace_paths
from scenes.render.samples import pixel_sums, sample_rays, sensor


@dataclass
class _Kept:
    """A scene that keeps the rays that it is asked about, (name of its method, ray, flags)."""

    scene: Any
    asked: list[tuple[str, Any, Any]] = field(default_factory=list)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.scene, name)

    def ray_test(self, ray: Any, active: Any) -> Any:
        return self._keep("ray_test", ray, active)

    def ray_intersect_preliminary(self, ray: Any, coherent: bool, active: Any) -> Any:
        return self._keep("ray_intersect_preliminary", ray, active, coherent=coherent)

    def _keep(self, name: str, ray: Any, active: Any, **how: bool) -> Any:
        ray, flags = mi.Ray3f(ray), {**how, "active": mi.Bool(active)}
        dr.eval(ray, flags)
        self.asked.append((name, ray, flags))
        return getattr(self.scene, name)(ray, **flags)


def trace_times(
    built: BuiltScene, quality: Quality, way: str, most_runs: int | None = None
) -> tuple[float, np.ndarray]:
    """Trace a frame in a way ("ours", "mitsuba" or "floor"): seconds, and radiance (pixels, 3).

    Of a picture it may trace the first runs of pixels alone. The floor's radiance is that of the
    rays that it keeps, whose time is not counted.
    """
    seconds, found = 0.0, []
    for sampler, ray in islice(_runs(built, quality), most_runs):
        dr.eval(ray)
        kept = _Kept(built.scene)
        if way == "floor":
            with dr.scoped_set_flag(dr.JitFlag.SymbolicLoops, False):
                colour, guides = trace_paths(replace(built, scene=kept), sampler, ray, True)
                dr.eval(colour, guides)
        dr.sync_thread()
        start = time.process_time()
        if way == "ours":
            colour, guides = trace_paths(built, sampler, ray, True)
        elif way == "mitsuba":
            colour, _, guides = _mitsuba(built).sample(built.scene, sampler, ray, None, True)
        else:
            guides = [getattr(built.scene, name)(each, **how) for name, each, how in kept.asked]
            guides = [hit if isinstance(hit, mi.Bool) else hit.t for hit in guides]
        dr.eval(colour, guides)
        dr.sync_thread()
        seconds += time.process_time() - start
        seen: Any = mi.Color3f(colour)
        seen = dr.select(dr.all(dr.isfinite(seen)), seen, 0.0)  # others are black, as in frames
        found.append(pixel_sums(seen, quality.spp) / quality.spp)
    return seconds, np.concatenate(found)


def _runs(built: BuiltScene, quality: Quality) -> Iterator[tuple[Any, Any]]:
    camera = built.description["camera"]
    view, (width, height) = sensor(camera), camera["size"]
    step = max(1, quality.most_samples // quality.spp)
    for first in range(0, width * height, step):
        pixels = slice(first, min(first + step, width * height))
        seed = sampler_seed(quality.seed, 0, 0, first)
        yield sample_rays(view, (width, height), pixels, replace(quality, seed=seed))


def _mitsuba(built: BuiltScene) -> Any:
    path = {"type": "path", "max_depth": built.description["integrator"]["max_depth"]}
    aovs = ",".join(f"{name}:{name}" for name in GUIDES if name != "position")
    return load_plugin({"type": "aov", "aovs": aovs, "image": path})
