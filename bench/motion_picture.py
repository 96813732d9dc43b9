"""What motion leaves out of a fast pan, looked for in the blurred picture: excess FLIP.

`meadow` panned at 90°/s under a 180° shutter, seen through windows of the frame that is 640 pixels
wide: 96 × 54 pixels about the horizon, where most of the parts are, each of eight pairs of seeds
another way. The reference is the same blurred frame, cut by size and distance alone: what those
cost the picture is the experiment ``fidelity``. The planted cut has m doubled.
"""

import math
from dataclasses import replace

import numpy as np

from bench.excess_flip import LEAST_PAIRS, mean_flip
from bench.records import Point
from scenes.preset import Preset, load_preset
from scenes.render.display import encoded, exposure_of
from scenes.render.frame import FrameInput
from scenes.render.shutter import render_exposed
from scenes.shot import shoot
from scenes.world import build_world

FRAME = 2
SIZE, WHOLE_PX, WHOLE_DEG = (96, 54), 640, 60.0
SPP, QUICK_SPP = 384, 32
TURN, SHUTTER, FPS = 90.0, 180.0, 24.0

CUTS = {
    "spatial": ("view.smear=off",),
    "motion": (),
    "planted": ("view.detail=2",),
}
"""By size and distance; by motion as well, at the default threshold; and with m doubled."""


def preset_of(cut: str, heading: float, spp: int) -> Preset:
    """The window that looks along a heading in the middle of the frame's time."""
    tangent = math.tan(math.radians(WHOLE_DEG / 2)) * SIZE[0] / WHOLE_PX
    return load_preset(
        "meadow",
        (
            f"render.size={SIZE[0]}x{SIZE[1]}",
            f"render.spp={spp}",
            "render.max_depth=2",
            f"camera.fov={2 * math.degrees(math.atan(tangent))}",
            "camera.speed=0",
            f"camera.turn={TURN}",
            f"camera.heading={heading - TURN / FPS * (FRAME - 1)}",
            f"view.shutter={SHUTTER}",
            *CUTS[cut],
        ),
    )


def measure(pair: int, variant: str, spp: int, seed: int) -> list[Point]:
    """One pair of seeds, one way to look: the cut by motion, and the planted one."""
    heading = 360.0 * pair / LEAST_PAIRS - 180.0
    world = build_world(preset_of("spatial", heading, spp))
    made = {cut: shoot(world, preset_of(cut, heading, spp), FRAME, variant) for cut in CUTS}
    one, two = (seed + 2 * pair + k for k in (0, 1))
    same, other = _picture(made["spatial"], one), _picture(made["spatial"], two)
    exposure = exposure_of(other)
    reference = _shown(other, exposure)
    floor = mean_flip(_shown(same, exposure), reference)
    points = []
    for cut in ("motion", "planted"):
        tested = mean_flip(_shown(_picture(made[cut], one), exposure), reference)
        samples = {"flip": [round(1e6 * tested)], "flip_floor": [round(1e6 * floor)]}
        points.append(Point({"world": "picture", "cut": cut, "spp": spp}, {}, samples))
    return points


def _picture(made: FrameInput, seed: int) -> np.ndarray:
    """Radiance of a blurred picture."""
    quality = replace(made.quality, seed=seed)
    layers = render_exposed(made.instants, made.air, made.light, quality, FRAME)
    return layers.rgb.astype(np.float64)


def _shown(radiance: np.ndarray, exposure: float) -> np.ndarray:
    return encoded(radiance, exposure).astype(np.float32)
