"""From a preset to the input of a frame: what is displayed, air, light and quality."""

import time
from dataclasses import replace

from lod.pruning.crossfade import blend_weights
from lod.pruning.pruner import prune
from scenes.far_cover.turbid_canopy import turbid_canopy
from scenes.frame.displayed import Shown, visible_at
from scenes.frame.quality import Quality
from scenes.frame.schedule import update_counts, with_schedule
from scenes.frame.subframes import subframes
from scenes.frame.types import Extras, FileForm, FrameInput
from scenes.preset.load import Preset
from scenes.world.light import Light
from scenes.world.view import preset_air, view_at
from scenes.world.world import World


def assemble_frame(world: World, preset: Preset, frame: int, variant: str) -> FrameInput:
    """Prune every representation for a frame, and ask what is displayed for its looks."""
    view, shown, seconds = view_at(world, preset, frame), [], {"prune": 0.0, "appearance": 0.0}
    after = view_at(world, preset, frame + 1) if preset.output.motion else None
    for each in world.representations:
        start = time.perf_counter()
        cut = prune(each, view)
        pruned = time.perf_counter()
        one = Shown(each, cut, blend_weights(cut, view), view)
        shown.append(with_schedule(world, preset, frame, one))
        seconds["prune"] += pruned - start
        seconds["appearance"] += time.perf_counter() - pruned
    start = time.perf_counter()
    later = after.time_s if after else None
    visible = tuple(visible_at(each, view.time_s, later) for each in shown)
    seconds["appearance"] += time.perf_counter() - start
    return FrameInput(
        camera=view.camera,
        visible=visible,
        air=preset_air(preset),
        light=frame_light(world, preset),
        quality=frame_quality(preset, variant),
        fps=preset.camera.fps,
        form=form_of(preset),
        extras=Extras(after.camera if after else None, preset.output.denoise),
        seconds=seconds,
        counts=update_counts([each.drawn for each in shown if each.drawn]),
        instants=subframes(world, preset, frame, shown, visible),
    )


def frame_light(world: World, preset: Preset) -> Light:
    """Sun and sky, and what stands in the air where that lights what is seen."""
    light = sun_and_sky(preset)
    if preset.render.haze != "scattered":
        return light
    return replace(light, canopy=turbid_canopy(tuple(each.species for each in world.fields)))


def sun_and_sky(preset: Preset) -> Light:
    """Sun and sky."""
    light = preset.light
    return Light(light.sun_azimuth, light.sun_elevation, light.turbidity)


def form_of(preset: Preset) -> FileForm:
    """How the file is laid out."""
    output = preset.output
    return FileForm(output.compression, output.multipart, output.colour)


def frame_quality(preset: Preset, variant: str) -> Quality:
    """How frames are sampled, in a variant that works here."""
    render = preset.render
    return Quality(variant, render.spp, preset.seed, render.max_depth, render.haze)
