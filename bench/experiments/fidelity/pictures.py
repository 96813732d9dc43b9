"""What do the errors of the fidelity experiment look like? Pictures, and maps of FLIP.

They are the cuts of the measurement from the same eye, with MAGNIFIED times as many pixels each
way, so that people see what a pixel of the measurement stands for. Nothing is measured on them.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from bench.experiments.fidelity.scene import VIEWS, Case, displayed, preset_of, reference, view_of
from bench.records.embedded_pictures import pictures
from bench.statistics.excess_flip import PIXELS_PER_DEGREE, flip_map
from scenes.frame.assemble import frame_quality
from scenes.frame.displayed import DisplayedRepresentation
from scenes.frame.frame_input import FrameInput
from scenes.render.pictures.tone_map import auto_exposure, to_srgb
from scenes.render.pipeline.stages import build_frame, trace
from scenes.world.light import sun_and_sky
from scenes.world.view import preset_air

MAGNIFIED = 4
DETAILS = (1.0, 4.0)
"""Values of τ, in pixels of the measurement."""

_EVERYTHING = "everything"


def pictures_of(variant: str, spp: int, seed: int) -> list[dict[str, Any]]:
    """Render for a record's notes, of each view, the whole scene, pruned ones and FLIP maps."""
    return [_one(view, variant, spp, seed) for view in VIEWS]


def _one(view: str, variant: str, spp: int, seed: int) -> dict[str, Any]:
    whole = _picture(view, reference(view), variant, spp, seed)
    exposure = auto_exposure(whole)
    shown = {"everything there is": to_srgb(whole, exposure)}
    for detail in DETAILS:
        cut = displayed(Case(view, "blake", detail, _EVERYTHING))
        shown[f"pruned, τ = {detail:g} px"] = to_srgb(
            _picture(view, cut, variant, spp, seed), exposure
        )
    first, *others = shown.values()
    layers = {name: _bytes(picture) for name, picture in shown.items()}
    for detail, other in zip(DETAILS, others, strict=True):
        name = f"where it differs, τ = {detail:g} px"
        layers[name] = _bytes(flip_map(other, first))
    caption = (
        f"The {view} view of the measurement, each pixel drawn as {MAGNIFIED} × {MAGNIFIED}: "
        f"what one pixel of it stands for. The maps are FLIP of these pictures at "
        f"{PIXELS_PER_DEGREE:g} pixels per degree, dark for no difference and bright for a large "
        f"one; the noise of {spp} samples a pixel is in them."
    )
    alt = f"The {view} view: people and trees on a meadow."
    return pictures(
        f"fidelity-{view.replace(' ', '-')}", (f"Look at it: {view}", caption, alt), layers
    )


def _picture(
    view: str, visible: Sequence[DisplayedRepresentation], variant: str, spp: int, seed: int
) -> np.ndarray:
    preset = preset_of(view)
    camera = view_of(Case(view, "blake", 1.0)).camera
    larger = replace(camera, width=MAGNIFIED * camera.width, height=MAGNIFIED * camera.height)
    quality = replace(frame_quality(preset, variant), spp=spp, seed=seed)
    stage = build_frame(
        FrameInput(larger, tuple(visible), preset_air(preset), sun_and_sky(preset), quality)
    )
    return trace(stage, quality).rgb.astype(np.float64)


def _bytes(picture: np.ndarray) -> np.ndarray:
    return np.rint(255 * np.clip(picture, 0, 1)).astype(np.uint8)
