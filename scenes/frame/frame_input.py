"""From a preset to the input of a frame: what is displayed, air, light and quality."""

import time
from dataclasses import replace

from lod.pruning.crossfade import blend_weights
from lod.pruning.parts import Representation
from lod.pruning.pruner import Cut, prune
from lod.pruning.view import View
from scenes.far_cover.turbid_canopy import turbid_canopy
from scenes.field.species_field import SpeciesField
from scenes.frame.displayed import Shown, visible_at
from scenes.frame.quality import Quality
from scenes.frame.schedule import update_counts, with_schedule
from scenes.frame.subframes import subframes
from scenes.frame.types import Extras, FileForm, FrameInput
from scenes.preset.load import Preset
from scenes.reuse.field_reuse import Hold, cut_after
from scenes.reuse.terrain_reuse import Boxes, ground_after
from scenes.terrain.terrain import Terrain
from scenes.world.light import Light
from scenes.world.view import preset_air, view_at
from scenes.world.world import World

Holds = dict[str, Hold | Boxes]
"""What holds of each field, and of the ground, by its name."""


def assemble_frame(
    world: World, preset: Preset, frame: int, variant: str, holds: Holds | None = None
) -> FrameInput:
    """Prune every representation for a frame, and ask what is displayed for its looks.

    holds: what frames before have left for the next one, which goes on from it and leaves its own;
        the same frame in less time.
    """
    holds = {} if holds is None else holds
    view, shown, seconds = view_at(world, preset, frame), [], {"prune": 0.0, "appearance": 0.0}
    after = view_at(world, preset, frame + 1) if preset.output.motion else None
    for each in world.representations:
        start = time.perf_counter()
        cut = _cut_after(each, view, holds)
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


def _cut_after(each: Representation, view: View, holds: Holds) -> Cut:
    """What of a representation is displayed; taken out first, a hold is never used twice.

    Where things walk all of them must be put in their places anyway, and nothing would be gained.
    """
    before = holds.pop(each.name, None)
    if isinstance(each, Terrain):
        cut, boxes = ground_after(each, view, before if isinstance(before, Boxes) else None)
        holds[each.name] = boxes
        return cut
    if not isinstance(each, SpeciesField) or each.moves:
        return prune(each, view)
    cut, hold = cut_after(each, view, before if isinstance(before, Hold) else None)
    if hold is not None:
        holds[each.name] = hold
    return cut


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
