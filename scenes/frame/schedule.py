"""Which sticks of what moves are drawn anew in a frame, where small moves may be left out."""

from collections.abc import Iterable, Iterator, Sequence

from lod.shapes import Sticks
from lod.update_schedule import (
    DrawnState,
    TruePose,
    refresh_due,
    replay,
    replay_frames,
    threshold_rule,
)
from scenes.frame.displayed import DisplayedRepresentation
from scenes.preset.tables import Preset
from scenes.world.view import camera_between, frame_time
from scenes.world.world import World


def with_schedule(
    world: World, preset: Preset, frame: int, displayed: DisplayedRepresentation
) -> DisplayedRepresentation:
    """Leave sticks as they were drawn earlier, where they have moved less than the threshold."""
    threshold = preset.view.update_threshold
    if threshold == 0 or not is_scheduled(displayed, frame_time(preset, frame + 1)):
        return displayed
    poses = poses_over(world, preset, replay_frames(frame), displayed)
    (drawn,) = replay(poses, [threshold_rule(threshold)])
    return displayed.with_drawn(drawn)


def is_scheduled(displayed: DisplayedRepresentation, later_s: float) -> bool:
    """Tell whether it has sticks of something that moves, which may stay as they were drawn."""
    return displayed.moves(later_s) and isinstance(displayed.shape, Sticks)


def poses_over(
    world: World, preset: Preset, frames: Iterable[int], displayed: DisplayedRepresentation
) -> Iterator[TruePose]:
    """Compute where its sticks truly are in each of these frames; nothing of what is no sticks."""
    if displayed.posing is None:
        return
    posing, view = displayed.posing, displayed.posing.view
    for frame in frames:
        shape = posing.shape_at(frame_time(preset, frame))
        due = refresh_due(posing.parts.part, frame)
        eye = camera_between(world, preset, frame, view.camera.corner).eye
        if isinstance(shape, Sticks):
            yield TruePose(shape.start, shape.end, shape.owner, due, eye, view.theta)


def update_counts(drawn: Sequence[DrawnState]) -> dict[str, int]:
    """Count the parts that could move and those drawn anew; nothing where there is no schedule.

    ``farthest_off_mpx`` is the largest error of those that stay as they were drawn [px/1000].
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
