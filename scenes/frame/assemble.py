"""From a preset to the input of a frame: what is displayed, air, light and quality."""

import time
from dataclasses import replace

from lod.errors import InputError
from lod.pruner import prune
from scenes.frame.displayed import display
from scenes.frame.frame_input import FrameInput
from scenes.frame.quality import Quality
from scenes.frame.schedule import update_counts, with_schedule
from scenes.frame.subframes import subframe_inputs
from scenes.frame.window import Window
from scenes.ground.far_cover import turbid_canopy
from scenes.preset.tables import Preset
from scenes.processes.progress import steps, work
from scenes.world.light import Light, sun_and_sky
from scenes.world.view import preset_air, view_at
from scenes.world.world import World


def assemble_frame(world: World, preset: Preset, frame: int, variant: str) -> FrameInput:
    """Prune every representation for a frame, and make the shapes of the parts displayed.

    ``frame`` counts from 1; ``variant`` is a Mitsuba variant that works here.
    """
    view, displayed = view_at(world, preset, frame), []
    after = view_at(world, preset, frame + 1) if preset.output.motion else None
    seconds = {"prune": 0.0, "appearance": 0.0}
    with work("fitting brightness", len(world.representations)):
        for each in world.representations:
            start = time.perf_counter()
            cut = prune(each, view)
            pruned = time.perf_counter()
            with steps(1):
                one = with_schedule(world, preset, frame, display(each, cut, view))
            displayed.append(one.at(view.time_s, after.time_s) if after else one)
            seconds["prune"] += pruned - start
            seconds["appearance"] += time.perf_counter() - pruned
    frame_input = FrameInput(
        camera=view.camera,
        displayed=tuple(displayed),
        air=preset_air(preset),
        light=frame_light(world, preset),
        quality=frame_quality(preset, variant),
        after=after.camera if after else None,
        denoise=preset.output.denoise,
        seconds=seconds,
        counts=update_counts([each.drawn for each in displayed if each.drawn]),
    )
    inputs = subframe_inputs(world, preset, frame, frame_input)
    if inputs:
        return replace(frame_input, subframes=inputs)
    at_rest = tuple(replace(each, posing=None) for each in displayed)  # which holds memory
    return replace(frame_input, displayed=at_rest)


def frame_light(world: World, preset: Preset) -> Light:
    """Return the sun and sky, with the canopy that shades the air where haze is scattered light."""
    light = sun_and_sky(preset)
    if preset.render.haze != "scattered":
        return light
    return replace(light, canopy=turbid_canopy(tuple(each.species for each in world.fields)))


def frame_quality(preset: Preset, variant: str) -> Quality:
    """Return how frames of a preset are sampled, in a variant that works here.

    Raises InputError for a panorama in a scalar variant, which has no such camera.
    """
    render = preset.render
    if preset.camera.projection == "panorama" and variant.startswith("scalar_"):
        rule = f"a panorama needs a JIT variant, as llvm_ad_rgb, and not {variant}"
        raise InputError("camera.projection", "panorama", rule, "see `lodbench doctor`")
    window = None if render.crop is None else Window(*render.window)
    return Quality(
        variant,
        render.spp,
        preset.seed,
        render.max_depth,
        render.haze,
        coverage=preset.output.cryptomatte,
        window=window,
    )
