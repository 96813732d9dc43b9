"""Which sticks of what moves are drawn anew in a frame, where small moves may be left out."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from lod.pruning.shapes import Sticks
from lod.pruning.update_schedule import (
    DrawnState,
    TruePose,
    refresh_due,
    replay,
    replay_frames,
    threshold_rule,
)
from scenes.frame.displayed import Shown
from scenes.preset.load import Preset
from scenes.world.view import camera_between, frame_time
from scenes.world.world import World


def with_schedule(world: World, preset: Preset, frame: int, shown: Shown) -> Shown:
    """The same with what is kept of it, where only sticks past a threshold are drawn anew."""
    threshold = preset.view.update_threshold
    if threshold == 0 or not is_scheduled(shown, frame_time(preset, frame + 1)):
        return shown
    frames = poses_over(world, preset, replay_frames(frame), shown)
    (drawn,) = replay(frames, [threshold_rule(threshold)])
    return replace(shown, drawn=drawn)


def is_scheduled(shown: Shown, later_s: float) -> bool:
    """Whether it has parts that may be kept: sticks of something that moves."""
    return shown.moves(later_s) and isinstance(shown.posed(shown.view.time_s), Sticks)


def poses_over(
    world: World, preset: Preset, frames: Iterable[int], shown: Shown
) -> Iterator[TruePose]:
    """Its parts as they stand in each of these frames; of what is drawn in sticks."""
    for at in frames:
        shape = shown.posed(frame_time(preset, at))
        due, eye = (
            refresh_due(shown.cut.parts.part, at),
            camera_between(world, preset, at, shown.view).eye,
        )
        if isinstance(shape, Sticks):
            yield TruePose(shape.start, shape.end, shape.owner, due, eye, shown.view.theta)


def update_counts(drawn: Sequence[DrawnState]) -> dict[str, int]:
    """How many of the parts that could move are drawn anew, and how far the farthest other is off
    [px/1000]; nothing where there is no schedule.
    """
    if not drawn:
        return {}
    return {
        "parts_scheduled": sum(len(each.updated) for each in drawn),
        "parts_redrawn": sum(int(each.updated.sum()) for each in drawn),
        "farthest_off_mpx": max(
            round(1000 * float(each.error_px.max(initial=0))) for each in drawn
        ),
    }
