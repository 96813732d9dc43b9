"""From a preset to what the renderer asks for: cuts and their looks, air, light and quality."""

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from lod.camera import Camera
from lod.motion.image_motion import eye_relative_to
from lod.pruning.crossfade import blend_weights
from lod.pruning.parts import BlendWeights, Moving, Parts, Representation, Sticks, Triangles
from lod.pruning.pruner import Cut, prune
from lod.pruning.update_schedule import (
    DrawnState,
    TruePose,
    apply_state,
    refresh_due,
    replay,
    replay_frames,
    threshold_rule,
)
from lod.pruning.view import View
from scenes.far_cover.turbid_canopy import turbid_canopy
from scenes.field.species_field import SpeciesField
from scenes.frame.types import Extras, FileForm, FrameInput, Instant, Light, Quality, Visible
from scenes.preset.load import Preset
from scenes.render.pipeline.subframes import offsets
from scenes.reuse.field_reuse import Hold, cut_after
from scenes.reuse.terrain_reuse import Boxes, ground_after
from scenes.terrain.terrain import Terrain
from scenes.world.camera_path import camera_at
from scenes.world.viewing_conditions import air_of
from scenes.world.world import World, time_of, view_at

Holds = dict[str, Hold | Boxes]
"""What holds of each field, and of the ground, by its name."""


def shoot(
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
        air=air_of(preset),
        light=light_in(world, preset),
        quality=quality_of(preset, variant),
        fps=preset.camera.fps,
        form=form_of(preset),
        extras=Extras(after.camera if after else None, preset.output.denoise),
        seconds=seconds,
        counts=updates([each.drawn for each in shown if each.drawn]),
        instants=instants_of(world, preset, frame, shown, visible),
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


@dataclass(frozen=True, eq=False)
class Shown:
    """What one representation displays in a frame, whenever it is looked at.

    drawn  what of it is kept as it was drawn; None: nothing
    """

    each: Representation
    cut: Cut
    look: BlendWeights
    view: View
    drawn: DrawnState | None = None

    def shape(self, time_s: float) -> Sticks | Triangles:
        """What is drawn at a time, in the frame's coordinates."""
        posed = self.posed(time_s)
        return apply_state(self.drawn, posed) if self.drawn and isinstance(posed, Sticks) else posed

    def posed(self, time_s: float) -> Sticks | Triangles:
        """Its looks at a time, nothing of it kept."""
        return self.each.appearance(self.parts(time_s), self.look)

    def parts(self, time_s: float) -> Parts:
        """The displayed parts as they stand at a time; the very same where nothing moves."""
        if time_s == self.view.time_s or not isinstance(self.each, Moving):
            return self.cut.parts
        return self.each.later(self.cut.parts, self.view, time_s)

    def moves(self, time_s: float) -> bool:
        """Whether anything stands elsewhere at that time."""
        return self.parts(time_s) is not self.cut.parts


def with_schedule(world: World, preset: Preset, frame: int, shown: Shown) -> Shown:
    """The same with what is kept of it, where only sticks past a threshold are drawn anew."""
    threshold = preset.view.update_threshold
    if threshold == 0 or not scheduled(shown, time_of(preset, frame + 1)):
        return shown
    frames = posed_in(world, preset, replay_frames(frame), shown)
    (drawn,) = replay(frames, [threshold_rule(threshold)])
    return replace(shown, drawn=drawn)


def scheduled(shown: Shown, later_s: float) -> bool:
    """Whether it has parts that may be kept: sticks of something that moves."""
    return shown.moves(later_s) and isinstance(shown.posed(shown.view.time_s), Sticks)


def posed_in(
    world: World, preset: Preset, frames: Iterable[int], shown: Shown
) -> Iterator[TruePose]:
    """Its parts as they stand in each of these frames; of what is drawn in sticks."""
    for at in frames:
        shape = shown.posed(time_of(preset, at))
        due, eye = refresh_due(shown.cut.parts.part, at), _camera(world, preset, at, shown.view).eye
        if isinstance(shape, Sticks):
            yield TruePose(shape.start, shape.end, shape.owner, due, eye, shown.view.theta)


def updates(drawn: Sequence[DrawnState]) -> dict[str, int]:
    """How many of the parts that could move are drawn anew, and how far the farthest other is off
    [px/1000]; nothing where there is no schedule.
    """
    if not drawn:
        return {}
    return {
        "parts_scheduled": sum(len(each.anew) for each in drawn),
        "parts_redrawn": sum(int(each.anew.sum()) for each in drawn),
        "farthest_off_mpx": max(round(1000 * float(each.off.max(initial=0))) for each in drawn),
    }


def visible_at(shown: Shown, time_s: float, later_s: float | None) -> Visible:
    """A cut at a time, with its sticks at a later one, row by row, where they move till then."""
    later = shown.posed(later_s) if later_s is not None and shown.moves(later_s) else None
    sticks = later if isinstance(later, Sticks) else None
    return Visible(shown.each.name, short_ids(shown.cut), shown.shape(time_s), sticks)


def instants_of(
    world: World,
    preset: Preset,
    frame: int,
    shown: Sequence[Shown],
    visible: tuple[Visible, ...],
) -> tuple[Callable[[], Instant], ...]:
    """The sub-frames while the shutter is open, of one and the same cut; none where all is still.

    As many as ``render.subframes``, or as there are samples a pixel if those are fewer.
    """
    count = min(preset.render.subframes, preset.render.spp)
    frames = (frame + preset.view.shutter / 360 * offsets(count)).tolist()
    cameras = [_camera(world, preset, at, shown[0].view) for at in frames]
    moves = [any(each.moves(time_of(preset, at)) for each in shown) for at in frames]
    here = shown[0].view.camera
    if not any(moves) and all(_stand_together(here, each) for each in cameras):
        return ()

    def at_one(number: int) -> Instant:
        at, after = frames[number], None
        later = time_of(preset, at + 1) if preset.output.motion else None
        if later is not None:
            after = _camera(world, preset, at + 1, shown[0].view)
        now = visible
        if any(moves) or later is not None:
            now = tuple(visible_at(each, time_of(preset, at), later) for each in shown)
        return Instant(cameras[number], now, after)

    return tuple(partial(at_one, number) for number in range(count))


def _camera(world: World, preset: Preset, frame: float, view: View) -> Camera:
    """The camera between frames, in the coordinates of a frame's view."""
    camera = camera_at(preset.camera, preset.render.size, frame, world.terrain)
    corner = view.camera.corner
    return replace(camera, corner=corner, eye=eye_relative_to(corner, camera))


def _stand_together(a: Camera, b: Camera) -> bool:
    pairs = ((a.eye, b.eye), (a.forward, b.forward), (a.up, b.up))
    return all(np.array_equal(one, other) for one, other in pairs)


def short_ids(cut: Cut) -> Cut:
    """A frame's ids have 32 bits: parts with longer addresses are numbered in their order."""
    part = cut.part
    if not len(part) or part.max() < 2**32:
        return cut
    numbers = np.unique(part, return_inverse=True)[1]
    return replace(cut, part=numbers)


def light_in(world: World, preset: Preset) -> Light:
    """Sun and sky, and what stands in the air where that lights what is seen."""
    light = light_of(preset)
    if preset.render.haze != "scattered":
        return light
    return replace(light, canopy=turbid_canopy(tuple(each.species for each in world.fields)))


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
