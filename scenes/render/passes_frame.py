"""A frame in a scalar variant: a film with a square of pixels for each pixel, one sample in each.

One sample in a film pixel keeps haze exact: radiance and distance come from two passes with one
seed, and so along the same rays (the renderer seeds each film pixel on its own). The square keeps
the film plane stratified. Normals, albedo and ids cost more than the picture in scalar variants, so
they come from a guide pass of at most 2 × 2 samples.
"""

import math
from functools import lru_cache
from typing import Any

import mitsuba as mi
import numpy as np

from scenes.render.build import GUIDES, Built, sensor
from scenes.render.frame import Quality, sampler_seed
from scenes.render.haze import Haze, airlight_towards, finish
from scenes.render.samples import Samples

MOST_SAMPLES = 2**20
"""Samples in one pass: bounds memory, and how long Ctrl-C waits."""

_GUIDE = -1


def render_passes(built: Built, haze: Haze, quality: Quality, frame: int) -> Samples:
    """Render square by square, band by band; then the guides.

    The sample that Z, N and the ids come from is the last of the guide pass's square: below and
    right of the pixel's centre (anywhere in the pixel, under 4 samples).
    """
    camera = built.description["camera"]
    total = Samples.zeros(*camera["size"])
    for number, side in enumerate(square_sides(quality.spp)):
        for rows in _bands(camera, side):
            seed = sampler_seed(quality.seed, frame, number, rows[0])
            _add_colour(built, haze, total, side, rows, seed)
    total.rgb /= quality.spp
    side = 2 if quality.spp >= 4 else 1
    for rows in _bands(camera, side):
        seed = sampler_seed(quality.seed, frame, _GUIDE, rows[0])
        _add_guides(built, total, side, rows, seed)
    total.albedo /= side**2
    return total


def _bands(camera: dict[str, Any], side: int) -> list[tuple[int, int]]:
    """Rows of pixels, as many as one pass takes, (first, one past the last)."""
    width, height = camera["size"]
    step = max(1, MOST_SAMPLES // (width * side**2))
    return [(top, min(top + step, height)) for top in range(0, height, step)]


def _add_colour(
    built: Built, haze: Haze, total: Samples, side: int, rows: tuple[int, int], seed: int
) -> None:
    """Add one sample in each film pixel of a band to ``total.rgb``."""
    camera = built.description["camera"]
    view = sensor(camera, side, (rows[0] * side, rows[1] * side))
    radiance = _pass(built, view, "image", seed)
    distance = _pass(built, view, "distance", seed)[..., 0]
    finite = np.isfinite(radiance).all(axis=-1)
    radiance[~finite] = 0.0
    directions = pixel_directions(camera, 1, rows)
    air = airlight_towards(haze, directions).astype(np.float32)
    # A film pixel's ray is known to within its pixel: no ray that could go below may stay black.
    slack = math.hypot(1, 1) * math.tan(math.radians(camera["fov_x_deg"]) / 2) / camera["size"][0]
    low = directions[..., 2] < haze.lowest + slack
    disc = pixel_directions(camera, side, rows) @ haze.to_sun > haze.sun_cosine
    air, low = (np.repeat(np.repeat(v, side, axis=0), side, axis=1) for v in (air, low))
    colour = finish(haze, radiance, distance, air, low, disc)
    total.rgb[slice(*rows)] += _by_pixel(colour, side).sum(axis=(1, 3))
    total.replaced += int(np.count_nonzero(~finite))


def _add_guides(built: Built, total: Samples, side: int, rows: tuple[int, int], seed: int) -> None:
    view = sensor(built.description["camera"], side, (rows[0] * side, rows[1] * side))
    guides = _by_pixel(_pass(built, view, "guides", seed), side)
    band = slice(*rows)
    total.albedo[band] += guides[..., GUIDES["albedo"]].sum(axis=(1, 3))
    total.keep(band, guides[:, -1, :, -1])


def _pass(built: Built, view: Any, integrator: str, seed: int) -> np.ndarray:
    """One sample in each film pixel, (rows, columns, channels) float32."""
    chosen = built.integrators[integrator]
    return np.array(mi.render(built.scene, sensor=view, integrator=chosen, spp=1, seed=seed))


def _by_pixel(film: np.ndarray, side: int) -> np.ndarray:
    """(h·side, w·side, c) → (h, side, w, side, c)."""
    rows, columns, channels = film.shape
    return film.reshape(rows // side, side, columns // side, side, channels)


def pixel_directions(camera: dict[str, Any], side: int, rows: tuple[int, int]) -> np.ndarray:
    """Unit directions through the centres of a band of film pixels, (rows, columns, 3) float32."""
    width, height = camera["size"]
    tan_x = math.tan(math.radians(camera["fov_x_deg"]) / 2)
    tan_y = tan_x * height / width
    x = ((np.arange(width * side) + 0.5) / (width * side) * 2 - 1) * tan_x
    y = (1 - (np.arange(rows[0] * side, rows[1] * side) + 0.5) / (height * side) * 2) * tan_y
    forward, up = camera["forward"], camera["up"]
    right = np.cross(forward, up)
    across, down = forward + x[:, None] * right, y[:, None] * up
    directions = across.astype(np.float32)[None] + down.astype(np.float32)[:, None]
    directions /= np.sqrt(np.sum(directions**2, axis=2, keepdims=True))
    return directions


@lru_cache(maxsize=64)
def square_sides(spp: int) -> tuple[int, ...]:
    """Sides of few squares that add up to ``spp``, the largest first: 8 → (2, 2), 16 → (4,)."""
    if spp > 1024:
        side = math.isqrt(spp)
        return (side, *square_sides(spp - side**2))
    best: list[tuple[int, ...]] = [()]
    for n in range(1, spp + 1):
        options = ((*best[n - side**2], side) for side in range(1, math.isqrt(n) + 1))
        best.append(min(options, key=lambda sides: (len(sides), max(sides))))
    return tuple(sorted(best[spp], reverse=True))
