"""Motion blur: a frame as the mean of sub-frames, evenly spread over the time the shutter is open.

Taken in the middles of N equal times, they spread what moves by L over N places: the variance of
its profile grows by L²/12·(1 − 1/N²), that of a box where N → ∞. Sub-frame i of frame f is rendered
whole, haze included, with its share of the samples and the seed ``sampler_seed(seed, f, i)``.
Colour and albedo are means over all samples; Z, N, ids and motion are those of sub-frame N // 2.
Where only the camera moves and haze is analytic, the scene is built once; otherwise once for each.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from lod.atmosphere.air import Air
from lod.errors import InputError
from scenes.frame.displayed import Visible
from scenes.frame.layers import Layers
from scenes.frame.quality import Quality, sampler_seed
from scenes.frame.types import Instant
from scenes.render.pictures.denoise import check_denoiser
from scenes.render.pipeline.render import BuiltFrame, build_frame, move_camera, trace, with_denoised
from scenes.world.light import Light

_ADDED = ("clamped", "replaced")
"""Statistics of samples; the others are of a scene."""


def render_exposed(
    instants: Sequence[Callable[[], Instant]],
    air: Air,
    light: Light,
    quality: Quality,
    frame: int = 0,
    watch: Callable[[int], object] = lambda samples: None,
    denoise: bool = False,
) -> Layers:
    """Render ``frame``: same arguments, same bytes. Sub-frames are made one at a time.

    Raises InputError where there are more of them than samples a pixel.
    """
    n, spp = len(instants), quality.spp
    if not 1 <= n <= spp:
        raise InputError("subframes", n, f"from 1 to {spp}, the samples per pixel", "raise --spp")
    if denoise:
        check_denoiser()
    rgb = albedo = np.zeros(3)
    lit = air, light, quality
    seconds, added = dict[str, float](), dict.fromkeys(_ADDED, 0)
    stage: BuiltFrame | None = None
    visible: tuple[Visible, ...] = ()
    for number, instant in enumerate(instants):
        now = instant()
        if stage and now.visible is visible and quality.haze == "analytic":
            stage = move_camera(stage, now.camera, air, now.after)
        else:
            stage = None  # a JIT variant would count its shapes, too
            stage, visible = build_frame(now.camera, now.visible, *lit, now.after), now.visible
        count = spp // n + (number < spp % n)
        own = replace(quality, spp=count, seed=sampler_seed(quality.seed, frame, number))
        layers = trace(stage, own, frame, watch)
        rgb, albedo = rgb + count / spp * layers.rgb, albedo + count / spp * layers.albedo
        seconds = {k: seconds.get(k, 0.0) + each for k, each in layers.seconds.items()}
        added = {k: added[k] + layers.statistics[k] for k in _ADDED}
        if number == n // 2:
            middle = layers
    statistics = {**middle.statistics, **added, "subframes": n}
    mean = replace(middle, rgb=rgb, albedo=albedo, seconds=seconds, statistics=statistics)
    return with_denoised(mean) if denoise else mean
