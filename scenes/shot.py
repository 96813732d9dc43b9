"""From a preset to what the renderer asks for: cuts and their looks, air, light and quality."""

import time
from dataclasses import replace

import numpy as np

from lod.fade import looks
from lod.parts import Look, Moving, Parts, Representation, Sticks
from lod.prune import Cut, prune
from lod.view import View
from scenes.preset import Preset
from scenes.render.frame import Extras, FileForm, FrameInput, Light, Quality, Visible
from scenes.sight import air_of
from scenes.world import World, view_at


def shoot(world: World, preset: Preset, frame: int, variant: str) -> FrameInput:
    """Prune every representation for a frame, and ask what is displayed for its looks."""
    view, visible, seconds = view_at(world, preset, frame), [], {"prune": 0.0, "appearance": 0.0}
    after = view_at(world, preset, frame + 1) if preset.output.motion else None
    for each in world.representations:
        start = time.perf_counter()
        cut = prune(each, view)
        pruned = time.perf_counter()
        look = looks(cut, view)
        shape = each.appearance(cut.parts, look)
        later = moved(each, cut.parts, look, view, after) if after else None
        visible.append(Visible(each.name, short_ids(cut), shape, later))
        seconds["prune"] += pruned - start
        seconds["appearance"] += time.perf_counter() - pruned
    return FrameInput(
        camera=view.camera,
        visible=tuple(visible),
        air=air_of(preset),
        light=light_of(preset),
        quality=quality_of(preset, variant),
        fps=preset.camera.fps,
        form=form_of(preset),
        extras=Extras(after.camera if after else None, preset.output.denoise),
        seconds=seconds,
    )


def moved(each: Representation, parts: Parts, look: Look, view: View, after: View) -> Sticks | None:
    """The sticks of a cut as they are in the next frame, row by row; None where nothing moves."""
    later = each.later(parts, view, after.time_s) if isinstance(each, Moving) else parts
    shape = each.appearance(later, look) if later is not parts else None
    return shape if isinstance(shape, Sticks) else None


def short_ids(cut: Cut) -> Cut:
    """A frame's ids have 32 bits: parts with longer addresses are numbered in their order."""
    part = cut.part
    if not len(part) or part.max() < 2**32:
        return cut
    numbers = np.unique(part, return_inverse=True)[1]
    return replace(cut, part=numbers)


def light_of(preset: Preset) -> Light:
    """Sun and sky."""
    light = preset.light
    return Light(light.sun_azimuth, light.sun_elevation, light.turbidity)


def form_of(preset: Preset) -> FileForm:
    """How the file is laid out."""
    output = preset.output
    return FileForm(output.compression, output.multipart, output.colour)


def quality_of(preset: Preset, variant: str) -> Quality:
    """How frames are sampled, in a variant that works here."""
    render = preset.render
    return Quality(variant, render.spp, preset.seed, render.max_depth, render.haze)
