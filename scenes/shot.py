"""From a preset to what the renderer asks for: cuts and their looks, air, light and quality."""

import time
from dataclasses import replace

import numpy as np

from lod.fade import looks
from lod.prune import Cut, prune
from scenes.preset import Preset
from scenes.render.frame import FileForm, FrameInput, Light, Quality, Visible
from scenes.sight import air_of
from scenes.world import World, view_at


def shoot(world: World, preset: Preset, frame: int, variant: str) -> FrameInput:
    """Prune every representation for a frame, and ask what is displayed for its looks."""
    view, visible, seconds = view_at(world, preset, frame), [], {"prune": 0.0, "appearance": 0.0}
    for each in world.representations:
        start = time.perf_counter()
        cut = prune(each, view)
        pruned = time.perf_counter()
        shape = each.appearance(cut.parts, looks(cut, view))
        visible.append(Visible(each.name, short_ids(cut), shape))
        seconds["prune"] += pruned - start
        seconds["appearance"] += time.perf_counter() - pruned
    return FrameInput(
        camera=view.camera,
        visible=tuple(visible),
        air=air_of(preset),
        light=light_of(preset),
        quality=quality_of(preset, variant),
        fps=preset.camera.fps,
        form=FileForm(**preset.output.model_dump()),
        seconds=seconds,
    )


def short_ids(cut: Cut) -> Cut:
    """A frame's ids have 32 bits: parts with longer addresses are numbered in their order."""
    part = cut.parts.part
    if not len(part) or part.max() < 2**32:
        return cut
    numbers = np.unique(part, return_inverse=True)[1]
    return replace(cut, parts=replace(cut.parts, part=numbers))


def light_of(preset: Preset) -> Light:
    """Sun and sky."""
    light = preset.light
    return Light(light.sun_azimuth, light.sun_elevation, light.turbidity)


def quality_of(preset: Preset, variant: str) -> Quality:
    """How frames are sampled, in a variant that works here."""
    render = preset.render
    return Quality(variant, render.spp, preset.seed, render.max_depth)
