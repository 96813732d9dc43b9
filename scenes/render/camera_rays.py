"""Camera rays: how samples are shared out, and rays through the pixels of a film.

Counts of samples are exact, in groups that keep their strata. In a JIT variant the samples of each
pixel stand side by side, and sums over them are made in a fixed order: a film that many threads add
to has other last bits every time.
"""

import math
from functools import lru_cache
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from scenes.frame.frame_input import Quality
from scenes.render.light import load_plugin


@lru_cache(maxsize=64)
def sample_groups(spp: int) -> tuple[int, ...]:
    """Split ``spp`` into counts that the multijitter sampler takes as they are: 7 → (6, 1).

    It lays samples out in isqrt(n) rows, and would round any other count up.
    """
    if spp == 0:
        return ()
    count = next(n for n in range(spp, 0, -1) if n % math.isqrt(n) == 0)
    return (count, *sample_groups(spp - count))


@lru_cache(maxsize=64)
def square_sides(spp: int) -> tuple[int, ...]:
    """Split ``spp`` into few squares and give their sides, largest first: 8 → (2, 2), 16 → (4,)."""
    if spp > 1024:
        side = math.isqrt(spp)
        return (side, *square_sides(spp - side**2))
    best: list[tuple[int, ...]] = [()]
    for n in range(1, spp + 1):
        options = ((*best[n - side**2], side) for side in range(1, math.isqrt(n) + 1))
        best.append(min(options, key=lambda sides: (len(sides), max(sides))))
    return tuple(sorted(best[spp], reverse=True))


def sample_rays(
    camera: Any, size: tuple[int, int], pixels: slice, quality: Quality
) -> tuple[Any, Any]:
    """Make sampler and rays: ``quality.spp`` of each pixel of a run, numbered row by row."""
    (width, height), spp = size, quality.spp
    count = (pixels.stop - pixels.start) * spp
    sampler = load_plugin({"type": quality.sampler, "sample_count": spp})
    sampler.set_samples_per_wavefront(spp)
    sampler.seed(quality.seed, count)
    index = dr.arange(mi.UInt32, count) // dr.opaque(mi.UInt32, spp)
    index += dr.opaque(mi.UInt32, pixels.start)
    corner = mi.Vector2f(mi.Float(index % width), mi.Float(index // width))
    film = (corner + sampler.next_2d()) / mi.ScalarVector2f(width, height)
    on_lens = sampler.next_2d() if camera.needs_aperture_sample() else mi.Point2f(0.5)
    ray, _ = camera.sample_ray_differential(0.0, 0.0, film, on_lens)
    return sampler, ray


def pixel_sums(colour: Any, spp: int) -> np.ndarray:
    """Sum the samples of each pixel of a run in each colour, (n, 3)."""
    return np.stack([np.array(dr.block_sum(channel, spp)) for channel in colour], axis=-1)


def pixel_directions(camera: dict[str, Any], side: int, rows: tuple[int, int]) -> np.ndarray:
    """Unit directions through the centres of a band of film pixels, (rows, columns, 3) float32."""
    width, height = camera["size"]
    x = (np.arange(width * side) + 0.5) / (width * side) * 2 - 1
    y = 1 - (np.arange(rows[0] * side, rows[1] * side) + 0.5) / (height * side) * 2
    forward, up = camera["forward"], camera["up"]
    right = np.cross(forward, up)
    if camera["panorama"]:
        turn, rise = math.pi * x, math.pi / 2 * y
        level = np.sin(turn)[:, None] * right + np.cos(turn)[:, None] * forward
        return (np.cos(rise)[:, None, None] * level + np.sin(rise)[:, None, None] * up).astype(
            np.float32
        )
    tan_x = math.tan(math.radians(camera["fov_x_deg"]) / 2)
    tan_y = tan_x * height / width
    x, y = x * tan_x, y * tan_y
    across, down = forward + x[:, None] * right, y[:, None] * up
    directions = across.astype(np.float32)[None] + down.astype(np.float32)[:, None]
    directions /= np.sqrt(np.sum(directions**2, axis=2, keepdims=True))
    return directions
