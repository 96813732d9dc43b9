"""Camera rays of a run of pixels in a JIT variant, the samples of each pixel side by side.

Sums over them are then made in a fixed order: a film that many threads add to has other last bits
every time.
"""

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from scenes.render.mitsuba.plugin import loaded

SAMPLER = "multijitter"
"""None tried has less noise for the time (``lodbench study render_settings``)."""


def rays(camera: Any, size: tuple[int, int], pixels: slice, spp: int, seed: int) -> tuple[Any, Any]:
    """Sampler and rays: ``spp`` of each pixel of a run, numbered row by row."""
    width, height = size
    count = (pixels.stop - pixels.start) * spp
    sampler = loaded({"type": SAMPLER, "sample_count": spp})
    sampler.set_samples_per_wavefront(spp)
    sampler.seed(seed, count)
    index = dr.arange(mi.UInt32, count) // dr.opaque(mi.UInt32, spp)
    index += dr.opaque(mi.UInt32, pixels.start)
    corner = mi.Vector2f(mi.Float(index % width), mi.Float(index // width))
    film = (corner + sampler.next_2d()) / mi.ScalarVector2f(width, height)
    ray, _ = camera.sample_ray_differential(0.0, 0.0, film, mi.Point2f(0.5))
    return sampler, ray


def sums(colour: Any, spp: int) -> np.ndarray:
    """Of the samples of each pixel, (n, 3)."""
    return np.stack([np.array(dr.block_sum(channel, spp)) for channel in colour], axis=-1)
