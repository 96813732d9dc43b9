"""A pack's view with one honest mistake each, rendered from the pack's recipe, for diagnosis."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from bench.packs.content import Content, load_content
from lod.camera import Camera
from scenes.frame.frame_input import FrameInput
from scenes.render.render import render_frame

SAMPLES = 64
"""Samples of a pixel of these pictures: their noise hardly biases a fit over a whole picture."""

SUN_DEG = 2
SEED = 1_000_003


def content_of(recipe: Mapping[str, Any], size: tuple[int, int], *more: str) -> Content:
    """Make a pack's world from its recipe, with other settings laid over."""
    settings: list[Any] = [*recipe["settings"], *more]
    return load_content(recipe["preset"], tuple(settings), size)


def camera_of(content: Content, frame: int) -> Camera:
    """Return the camera of a frame of the walk, from 1, which is the still's, at its size."""
    made = content.made.camera
    return replace(content.camera(frame), width=made.width, height=made.height)


def rendered_mistakes(
    recipe: Mapping[str, Any], frame: int, size: tuple[int, int]
) -> dict[str, np.ndarray]:
    """Render a frame, from 1, with each mistake that a program or its user may make.

    size   width and height [px]
    """
    right = content_of(recipe, size)
    light, ground = right.scene.preset.light, right.made.displayed[0]
    turned = f"light.sun_azimuth={light.sun_azimuth + SUN_DEG}"
    lifted = f"light.sun_elevation={light.sun_elevation + SUN_DEG}"

    def without(name: str) -> FrameInput:
        return replace(
            right.made, displayed=tuple(d for d in right.made.displayed if d.name != name)
        )

    wrong = {
        "no haze": content_of(recipe, size, "air.visibility=clear").made,
        f"sun azimuth +{SUN_DEG}°": content_of(recipe, size, turned).made,
        f"sun elevation +{SUN_DEG}°": content_of(recipe, size, lifted).made,
        "one frame late": replace(right.made, camera=camera_of(right, frame + 1)),
        **{f"without {each.name}": without(each.name) for each in right.made.displayed[1:]},
        "without things": replace(right.made, displayed=(ground,)),
    }
    made = {}
    for cause, found in wrong.items():
        camera = found.camera if cause == "one frame late" else camera_of(right, frame)
        quality = replace(found.quality, spp=SAMPLES, seed=SEED)
        layers = render_frame(replace(found, camera=camera, quality=quality))
        made[cause] = layers.rgb.astype(np.float64)
    return made
