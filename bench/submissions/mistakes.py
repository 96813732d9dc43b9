"""A pack's view with one honest mistake each, rendered from the pack's recipe, for diagnosis."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from scenes.presets.load import load_preset
from scenes.render.render import render_frame
from scenes.render.variants import choose
from scenes.scene import Scene

SAMPLES = 16
"""Samples of a pixel of these pictures: their noise hardly biases a fit over a whole picture."""

SUN_DEG = 2
SEED = 1_000_003


def rendered_mistakes(
    recipe: Mapping[str, Any], frame: int, size: tuple[int, int]
) -> dict[str, np.ndarray]:
    """Render a frame, from 1, with each mistake that a program or its user may make.

    size   width and height [px]
    """
    variant = choose()

    def scene_with(*more: str) -> Scene:
        words = (*recipe["settings"], f"render.size={size[0]}x{size[1]}", *more)
        return Scene(load_preset(recipe["preset"], words))

    right = scene_with()
    light, fields = right.preset.light, right.world.fields
    turned = f"light.sun_azimuth={light.sun_azimuth + SUN_DEG}"
    lifted = f"light.sun_elevation={light.sun_elevation + SUN_DEG}"

    def without(name: str) -> Scene:
        kept = tuple(each for each in fields if name not in ("things", each.name))
        return right.with_world(replace(right.world, fields=kept))

    wrong = {
        "no haze": (scene_with("air.visibility=clear"), frame),
        f"sun azimuth +{SUN_DEG}°": (scene_with(turned), frame),
        f"sun elevation +{SUN_DEG}°": (scene_with(lifted), frame),
        "one frame late": (right, frame + 1),
        **{f"without {n}": (without(n), frame) for n in ("things", *(f.name for f in fields))},
    }
    made = {}
    for cause, (scene, number) in wrong.items():
        found = scene.input(number, variant)
        quality = replace(found.quality, spp=SAMPLES, seed=SEED)
        made[cause] = render_frame(replace(found, quality=quality)).rgb.astype(np.float64)
    return made
