"""What do cuts by motion leave out of a field, and does the blurred picture miss it?

Every field is `meadow` with a seed of its own, 640 pixels wide, cut by size and distance alone and
by motion as well. In a finite world everything is counted too, which is the most there is to gain.

Pictures are windows of the frame, 96 × 54 pixels about the horizon, where most of the parts are, in
another direction for each of eight pairs of seeds. The reference is the same blurred frame, cut by
size and distance alone, whose own errors the experiment `images` measures. The planted cut has m
four times as large.
"""

import math
from dataclasses import asdict, dataclass, replace
from functools import cache

import numpy as np

from bench.images.differences import LEAST_PAIRS, mean_flip
from bench.records.records import Column, Point, columns
from lod.pruner import prune
from scenes.frame.frame_input import FrameInput
from scenes.presets.load import load_preset
from scenes.render.pictures import auto_exposure, to_srgb
from scenes.render.render import render_frame
from scenes.scene import Scene


@dataclass(frozen=True)
class Move:
    """A move of the camera: turn [degrees/s], speed [m/s], and shutter [degrees of 360 a frame]."""

    turn: float
    speed: float
    shutter: float

    @property
    def settings(self) -> tuple[str, ...]:
        """The move as settings of a preset."""
        keys = {"camera.turn": self.turn, "camera.speed": self.speed, "view.shutter": self.shutter}
        return tuple(f"{key}={value}" for key, value in keys.items())


FAST = Move(90.0, 0.0, 180.0)  # the move that is rendered, too

MOVES = (
    *(Move(turn, 0.0, 180.0) for turn in (0.0, 5.0, 15.0, 45.0, FAST.turn, 180.0)),
    Move(0.0, 1.4, 180.0),
)
"""Pans, and a walk ahead."""

BARE = "species.sward.density=0"  # without grass, of which a whole field has too much to count

FINITE = "world.extent=400"
COUNTED_FRAME, PICTURED_FRAME = 5, 2
COUNTED_CUTS: dict[str, dict[str, tuple[str, ...]]] = {
    "endless": {"spatial": ("view.smear=off",), "motion": ()},
    "finite": {
        "everything": ("view.metric=full", FINITE),
        "spatial": ("view.smear=off", FINITE),
        "motion": (FINITE,),
    },
}
"""The settings of every cut of the endless and of the finite world."""

PICTURED_CUTS = {"spatial": ("view.smear=off",), "motion": (), "planted": ("view.detail=4",)}
SIZE, WHOLE_PX, WHOLE_DEG, FPS = (96, 54), 640, 60.0, 24.0
SUBFRAMES = 16
"""A full run has 36 samples of a pixel in each, at which the noise floor is low enough to quote an
excess (``bench.images.differences.FLOOR``)."""


def measure_field(number: int, seed: int) -> list[Point]:
    """Count the parts of one field in both worlds, by each of their cuts, for every camera."""
    own, points = f"seed={seed + number}", []
    for name, moves in (("endless", MOVES), ("finite", (FAST,))):
        cuts = COUNTED_CUTS[name]
        field = Scene(load_preset("meadow", (BARE, own, *cuts["spatial"])))
        for move in moves:
            counts = (
                Column("parts", [displayed_parts(field, own, *move.settings, *each)], {"cut": cut})
                for cut, each in cuts.items()
            )
            named = {"topic": "motion", "world": name, **asdict(move)}
            points.append(Point(named, samples=tuple(counts)))
    return points


def displayed_parts(field: Scene, *settings: str) -> int:
    """Count the parts of all species that a field displays under other settings."""
    scene = field.with_preset(load_preset("meadow", (BARE, *settings)))
    view = scene.view(COUNTED_FRAME)
    return sum(prune(each, view).displayed_parts for each in scene.world.fields)


@cache
def _pictured_field() -> Scene:
    """The field of every picture, which depends neither on camera, cut nor samples."""
    return Scene(load_preset("meadow", (BARE,)))


def measure_pictures(pair: int, variant: str, spp: int, seed: int) -> list[Point]:
    """Measure excess FLIP of one pair of seeds and one heading, for every cut, in the fast pan."""
    cuts = [cut for cut in PICTURED_CUTS if cut != "spatial"]
    # The window looks along the pair's heading in the middle of the frame's time.
    heading = 360.0 * pair / LEAST_PAIRS - 180.0 - FAST.turn / FPS * (PICTURED_FRAME - 1)
    tangent = math.tan(math.radians(WHOLE_DEG / 2)) * SIZE[0] / WHOLE_PX
    window = (
        *(BARE, f"render.size={SIZE[0]}x{SIZE[1]}", f"render.spp={spp}", "render.max_depth=2"),
        f"render.subframes={SUBFRAMES}",
        f"camera.fov={2 * math.degrees(math.atan(tangent))}",
        f"camera.heading={heading}",
    )

    def framed(cut: str) -> FrameInput:
        preset = load_preset("meadow", (*window, *FAST.settings, *PICTURED_CUTS[cut]))
        return _pictured_field().with_preset(preset).input(PICTURED_FRAME, variant)

    def radiance(made: FrameInput, own: int) -> np.ndarray:
        quality = replace(made.quality, seed=own)
        return render_frame(replace(made, quality=quality), PICTURED_FRAME).rgb.astype(np.float64)

    spatial, *tested = (framed(cut) for cut in ("spatial", *cuts))
    one, two = (seed + 2 * pair + k for k in (0, 1))
    other = radiance(spatial, two)
    exposure = auto_exposure(other)
    reference = to_srgb(other, exposure).astype(np.float32)

    def error(made: FrameInput) -> int:
        shown = to_srgb(radiance(made, one), exposure).astype(np.float32)
        return round(1e6 * mean_flip(shown, reference))

    floor, points = error(spatial), []
    for cut, made in zip(cuts, tested, strict=True):
        named = {"topic": "motion", "world": "picture", **asdict(FAST), "cut": cut, "spp": spp}
        points.append(Point(named, samples=columns({"flip": [error(made)], "flip_floor": [floor]})))
    return points
