"""What do the errors of the fidelity experiment look like? Pictures, and maps of FLIP."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from bench.experiments.fidelity.scene import (
    EVERYTHING,
    Field,
    displayed,
    field_view,
    reference,
    world_of,
)
from bench.experiments.fidelity.shipped.displayed import Shown
from bench.records.records import pictures
from bench.statistics.excess_flip import PIXELS_PER_DEGREE, flip_map
from scenes.frame.frame_input import FrameInput
from scenes.render.pictures import auto_exposure, to_srgb
from scenes.render.render import render_frame
from scenes.scene import frame_quality, preset_air
from scenes.world.light import sun_and_sky

DETAILS = (1.0, 4.0)
"""Values of τ that are shown [px]."""


def pictures_of(fields: Sequence[Field], variant: str, spp: int, seed: int) -> list[dict[str, Any]]:
    """Render for a record's notes, of the first field in each view: whole, pruned, FLIP maps."""
    return [_one(each, variant, spp, seed) for each in fields if each.number == 0]


def _one(field: Field, variant: str, spp: int, seed: int) -> dict[str, Any]:
    world, view = world_of(field, seed), field_view(field, seed)
    whole = _picture(field, reference(world, view), variant, spp, seed)
    exposure = auto_exposure(whole)
    layers = {"the reference": _bytes(to_srgb(whole, exposure))}
    maps = {}
    for detail in DETAILS:
        shown = displayed(world, view, EVERYTHING, "blake", detail)
        pruned = to_srgb(_picture(field, shown, variant, spp, seed), exposure)
        layers[f"pruned, τ = {detail:g} px"] = _bytes(pruned)
        difference = flip_map(pruned, to_srgb(whole, exposure))
        maps[f"where it differs, τ = {detail:g} px"] = _bytes(difference)
    caption = (
        f"The first field in the {field.view} view. The maps are FLIP of these pictures at "
        f"{PIXELS_PER_DEGREE:g} pixels per degree, dark for no difference and bright for a large "
        f"one; the noise of {spp} samples a pixel is in them."
    )
    alt = f"The {field.view} view: people and trees on a meadow."
    name = f"fidelity-{field.view.replace(' ', '-')}"
    return pictures(name, (f"Look at it: {field.view}", caption, alt), layers | maps)


def _picture(field: Field, shown: Shown, variant: str, spp: int, seed: int) -> np.ndarray:
    preset = field.preset(seed)
    quality = replace(frame_quality(preset, variant), spp=spp, seed=seed)
    camera = field_view(field, seed).camera
    made = FrameInput(camera, shown, preset_air(preset), sun_and_sky(preset), quality)
    return render_frame(made).rgb.astype(np.float64)


def _bytes(picture: np.ndarray) -> np.ndarray:
    return np.rint(255 * np.clip(picture, 0, 1)).astype(np.uint8)
