"""Does the blurred picture miss what motion leaves out? Excess FLIP says.

`meadow` is panned or flown through, and seen through windows of a frame that is 640 pixels wide: 96
× 54 pixels about the horizon, where most of the parts are, in another direction for each of eight
pairs of seeds. The reference is the same blurred frame, cut by size and distance alone, whose own
errors the experiment ``fidelity`` measures. The planted cut has m four times as large.
"""

import math
from dataclasses import asdict, dataclass, replace
from functools import cache

import numpy as np

from bench.experiments.motion.moves import Move
from bench.images.compare import LEAST_PAIRS, mean_flip
from bench.records.records import Point, columns
from scenes.frame.frame_input import FrameInput
from scenes.presets.load import load_preset
from scenes.presets.schema import Preset
from scenes.render.pictures import auto_exposure, to_srgb
from scenes.render.render import render_frame
from scenes.scene import assemble_frame
from scenes.world.world import World, build_world

FRAME = 2
SIZE, WHOLE_PX, WHOLE_DEG = (96, 54), 640, 60.0
SHOWN_SPP = 64
"""The most samples of a pixel of moves that only show how errors grow.

The fast pan of a full run has 36 in each sub-frame, at which the noise floor is low enough to quote
an excess (``FLOOR``).
"""

SUBFRAMES = 16

FPS = 24.0

CUTS = {
    "spatial": ("view.smear=off",),
    "motion": (),
    "planted": ("view.detail=4",),
}
"""The settings of the cut by size and distance, by motion as well, and with four times the m."""


def preset_of(move: Move, cut: str, heading: float, spp: int) -> Preset:
    """Load the preset of a window that looks along a heading in the middle of the frame's time."""
    tangent = math.tan(math.radians(WHOLE_DEG / 2)) * SIZE[0] / WHOLE_PX
    window = (
        "species.sward.density=0",
        f"render.size={SIZE[0]}x{SIZE[1]}",
        f"render.spp={spp}",
        f"render.subframes={SUBFRAMES}",
        "render.max_depth=2",
        f"camera.fov={2 * math.degrees(math.atan(tangent))}",
        f"camera.heading={heading - move.turn / FPS * (FRAME - 1)}",
    )
    return load_preset("meadow", (*window, *move.settings, *CUTS[cut]))


@dataclass(frozen=True)
class Pictures:
    """A move, a pair of seeds, the cuts that are compared, and how they are rendered."""

    move: Move
    pair: int
    cuts: tuple[str, ...]
    variant: str
    spp: int


def measure(case: Pictures, seed: int) -> list[Point]:
    """Measure excess FLIP of one pair of seeds and one heading, for every cut."""
    move, pair, cuts, spp = case.move, case.pair, case.cuts, case.spp
    heading, world = 360.0 * pair / LEAST_PAIRS - 180.0, _world()
    spatial, *tested = (
        assemble_frame(world, preset_of(move, cut, heading, spp), FRAME, case.variant)
        for cut in ("spatial", *cuts)
    )
    one, two = (seed + 2 * pair + k for k in (0, 1))
    other = _picture(spatial, two)
    exposure = auto_exposure(other)
    reference = _shown(other, exposure)
    floor = mean_flip(_shown(_picture(spatial, one), exposure), reference)
    points = []
    for cut, made in zip(cuts, tested, strict=True):
        flip = mean_flip(_shown(_picture(made, one), exposure), reference)
        samples = {"flip": [round(1e6 * flip)], "flip_floor": [round(1e6 * floor)]}
        named = {"world": "picture", **asdict(move), "cut": cut, "spp": spp}
        points.append(Point(named, samples=columns(samples)))
    return points


@cache
def _world() -> World:
    """Build the field of every picture, which depends neither on camera, cut nor samples."""
    return build_world(load_preset("meadow", ("species.sward.density=0",)))


def _picture(made: FrameInput, seed: int) -> np.ndarray:
    """Render the radiance of a blurred picture."""
    quality = replace(made.quality, seed=seed)
    layers = render_frame(replace(made, quality=quality), FRAME)
    return layers.rgb.astype(np.float64)


def _shown(radiance: np.ndarray, exposure: float) -> np.ndarray:
    return to_srgb(radiance, exposure).astype(np.float32)
