"""Popping: what appears or vanishes at full size, and what changes that motion does not explain.

Two figures of a walk, each of pairs of consecutive frames. Parts that are displayed in one frame
only and show more than half of themselves there, though both frames have them in view, have popped.
And what a frame displays is moved to where it is a frame later, and seen from where the eye is by
then (``popping_picture``): what the next frame shows otherwise, motion does not explain.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from bench.experiments.popping.silhouettes import silhouettes
from lod.arrays import Points, Reals, freeze
from lod.camera import GRID_M, Camera
from lod.pruning.crossfade import blend_weights
from lod.pruning.pruner import Cut, prune
from lod.pruning.view import View
from lod.pruning.view_geometry import in_view
from scenes.field.species_field import SpeciesField
from scenes.frame.assemble import frame_quality
from scenes.frame.displayed import DisplayedRepresentation, display
from scenes.frame.schedule import with_schedule
from scenes.preset.tables import Preset
from scenes.world.light import sun_and_sky
from scenes.world.view import view_at
from scenes.world.world import World

AT_FULL_SIZE = 0.5
"""Share of itself from which on a part that comes or goes is said to pop."""


@dataclass(frozen=True, eq=False)
class Seen:
    """The parts of one representation in one frame.

    key (n, 4) what identifies them in every frame; size (n,) share of themselves that they show
    centre (n, 3), bound (n,) their spheres, from the frame's corner [m]
    """

    key: np.ndarray
    size: np.ndarray
    centre: np.ndarray
    bound: np.ndarray

    def __post_init__(self) -> None:
        freeze(self, key=np.int64, size=np.float64, centre=np.float64, bound=np.float64)


@dataclass(frozen=True, eq=False)
class Frame:
    """One frame of a walk: its view, what it displays, and the parts of that which can pop."""

    view: View
    shown: tuple[DisplayedRepresentation, ...]
    seen: dict[str, Seen]

    def walked(self, name: str, time_s: float) -> Points:
        """How far the objects of the parts that it displays of a species go until a time, (n, 3)
        [m].
        """
        posing = next(each.posing for each in self.shown if each.name == name)
        assert posing is not None
        now, then = posing.parts, posing.parts_at(time_s)
        gone: Points = then.state.instances.origin - now.state.instances.origin
        return gone[now.object]


def frames_of(world: World, presets: Sequence[Preset], frames: Sequence[int]) -> Iterator[Frame]:
    """The frames of a walk, one after the other, as these presets have them by turns."""
    for number in frames:
        preset = presets[number % len(presets)]
        view, shown, seen = view_at(world, preset, number), [], {}
        for each in world.representations:
            cut = prune(each, view)
            one = display(each, cut, view)
            if isinstance(each, SpeciesField):  # the ground's vertices move; its tiles do not pop
                weights = blend_weights(cut, view)
                seen[each.name] = seen_of(cut, np.maximum(weights.inner, weights.leaf))
            shown.append(with_schedule(world, preset, number, one))
        yield Frame(view, tuple(shown), seen)


def seen_of(cut: Cut, size: Reals) -> Seen:
    """Who the parts of a species' cut are, and where."""
    parts = cut.parts
    samples, who = parts.state.samples, parts.object
    key = np.stack(
        (samples.cell_x[who], samples.cell_y[who], samples.index[who], parts.part), axis=1
    )
    return Seen(key, size, parts.centre, parts.bound)


def popped(before: Frame, after: Frame) -> int:
    """Parts that appear or vanish at full size, in view before and after."""
    return sum(
        _only_in(before, after, name) + _only_in(after, before, name) for name in before.seen
    )


def _only_in(frame: Frame, next_to: Frame, name: str) -> int:
    """Parts displayed here and not there, at full size and in view of both as they are by then."""
    here, there, view, other = frame.seen[name], next_to.seen[name], frame.view, next_to.view
    both = np.concatenate((there.key, here.key))
    _, first = np.unique(both, axis=0, return_index=True)
    alone = first[first >= len(there.key)] - len(there.key)
    alone = alone[here.size[alone] > AT_FULL_SIZE]
    if not len(alone):
        return 0
    centre, bound = here.centre[alone], here.bound[alone]
    by_then = centre + frame.walked(name, other.time_s)[alone] + shift(view.camera, other.camera)
    seen = in_view(view, centre, bound) & in_view(other, by_then, bound)
    return int(np.count_nonzero(seen))


def shift(old: Camera, new: Camera) -> Float64[np.ndarray, "3"]:
    """What to add to a place of the old frame to have it in the new one [m]."""
    a, b = old.corner, new.corner
    return GRID_M * np.array((a.x - b.x, a.y - b.y, 0.0))


@dataclass(frozen=True, eq=False)
class Walk:
    """A measured walk, frame after frame but the first, (f - 1, …).

    popped       parts that came or went at full size
    unexplained  of every pixel, what motion does not explain: each frame has samples of its own
    switched     the same with the same samples in both, so that no noise is left
    picture      of the frame
    """

    popped: np.ndarray
    unexplained: np.ndarray
    switched: np.ndarray
    picture: np.ndarray

    def __post_init__(self) -> None:
        real = np.float32
        freeze(self, popped=np.int64, unexplained=real, switched=real, picture=real)


def walk(world: World, presets: Sequence[Preset], frames: Sequence[int], variant: str) -> Walk:
    """Measure consecutive frames of a walk, as these presets have them by turns."""
    light, quality = sun_and_sky(presets[0]), frame_quality(presets[0], variant)
    counts, changes, before = [], [], None
    for number, after in zip(frames, frames_of(world, presets, frames), strict=True):
        if before is not None:
            camera = after.view.camera
            both = [
                silhouettes(
                    each.shown,
                    camera,
                    after.view.time_s,
                    light,
                    quality,
                    samples,
                )
                for each, samples in ((before, (number - 1, number)), (after, (number,)))
            ]
            (moved, alike), (now,) = both
            counts.append(popped(before, after))
            changes.append((abs(now - moved), abs(now - alike), now))
        before = after
    return Walk(np.array(counts), *(np.stack(each) for each in zip(*changes, strict=True)))
