"""What appears or vanishes at full size, and what changes that motion does not explain?

Both are measured of consecutive frames of a walk. Parts that are displayed in one frame only and
show more than half of themselves there, though both frames have them in view, have popped. And what
a frame displays is moved to where it is a frame later, and rendered from where the eye is by then
(``silhouettes``): what the next frame shows otherwise, motion does not explain.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64

from bench.experiments.popping.silhouettes import silhouettes
from lod.arrays import Points, Reals, freeze
from lod.camera import GRID_M, Camera
from lod.crossfade import blend_weights
from lod.pruner import Cut, prune
from lod.view import View, in_view
from scenes.field.species_field import SpeciesField
from scenes.frame.frame_input import DisplayedRepresentation, Posing, display
from scenes.presets.schema import Preset
from scenes.scene import frame_quality, view_at, with_schedule
from scenes.world.light import sun_and_sky
from scenes.world.world import World

AT_FULL_SIZE = 0.5
"""The share of itself from which on a part that comes or goes is said to pop."""


@dataclass(frozen=True, eq=False)
class Seen:
    """The parts of one representation in one frame.

    key     (n, 4) integers that identify them in every frame
    size    (n,) share of themselves that they show
    centre  (n, 3) centres of their spheres, from the frame's corner [m]
    bound   (n,) radii of their spheres [m]
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
        """Return how far the objects of displayed parts walk until a time, (n, 3) [m]."""
        posing = self._posing(name)
        now, then = posing.parts, posing.parts_at(time_s)
        gone: Points = then.state.instances.origin - now.state.instances.origin
        return gone[now.object]

    def all_round(self, name: str) -> Seen:
        """Return the parts that would be displayed if every direction were in view."""
        cut = prune(self._posing(name).representation, replace(self.view, look_around=True))
        return seen_of(cut, np.ones(cut.displayed_parts))

    def _posing(self, name: str) -> Posing:
        found = next(each.posing for each in self.shown if each.name == name)
        assert found is not None
        return found


def frames_of(world: World, presets: Sequence[Preset], frames: Sequence[int]) -> Iterator[Frame]:
    """Yield the frames of a walk, one after the other, for each of these presets in turn."""
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
    """Return the parts of a species' cut, and where they are."""
    parts = cut.parts
    samples, who = parts.state.samples, parts.object
    key = np.stack(
        (samples.cell_x[who], samples.cell_y[who], samples.index[who], parts.part), axis=1
    )
    return Seen(key, size, parts.centre, parts.bound)


def popped(before: Frame, after: Frame) -> int:
    """Return the parts that appear or vanish at full size, in view before and after."""
    return sum(
        _only_in(before, after, name) + _only_in(after, before, name) for name in before.seen
    )


def _only_in(frame: Frame, next_to: Frame, name: str) -> int:
    """Return the parts of one frame that are not displayed in the other, though in view of both."""
    here, there, view, other = frame.seen[name], next_to.seen[name], frame.view, next_to.view
    alone = _missing(here.key, there.key)
    alone = alone[here.size[alone] > AT_FULL_SIZE]
    if not len(alone):
        return 0
    centre, bound = here.centre[alone], here.bound[alone]
    by_then = centre + frame.walked(name, other.time_s)[alone] + shift(view.camera, other.camera)
    seen = in_view(view, centre, bound) & in_view(other, by_then, bound)
    if not seen.any():
        return 0
    # Limbs swing as their object walks: what has swung out of view is where it is posed by then.
    around = next_to.all_round(name)
    outside = ~in_view(other, around.centre, around.bound)
    return len(_missing(here.key[alone[seen]], around.key[outside]))


def _missing(keys: np.ndarray, among: np.ndarray) -> np.ndarray:
    """Return the rows of distinct keys (n, 4) that are not among others (m, 4)."""
    _, first = np.unique(np.concatenate((among, keys)), axis=0, return_index=True)
    rows: np.ndarray = first[first >= len(among)] - len(among)
    return rows


def shift(old: Camera, new: Camera) -> Float64[np.ndarray, "3"]:
    """Return what to add to a place in the old frame's coordinates for the new one's [m]."""
    a, b = old.corner, new.corner
    return GRID_M * np.array((a.x - b.x, a.y - b.y, 0.0))


@dataclass(frozen=True, eq=False)
class Walk:
    """A measured walk: columns over its frames but the first, (f − 1, …).

    popped       parts that came or went at full size
    unexplained  change of every pixel that motion does not explain; frames have own samples
    switched     that change where both frames have the same samples, so that no noise is left
    picture      picture of the frame
    """

    popped: np.ndarray
    unexplained: np.ndarray
    switched: np.ndarray
    picture: np.ndarray

    def __post_init__(self) -> None:
        real = np.float32
        freeze(self, popped=np.int64, unexplained=real, switched=real, picture=real)


def walk(
    world: World,
    presets: Sequence[Preset],
    frames: Sequence[int],
    variant: str,
    shaded: bool = False,
) -> Walk:
    """Measure consecutive frames of a walk, for each of these presets in turn.

    ``shaded`` says whether pictures are shaded by the sun.
    """
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
                    shaded,
                )
                for each, samples in ((before, (number - 1, number)), (after, (number,)))
            ]
            (moved, alike), (now,) = both
            counts.append(popped(before, after))
            changes.append((abs(now - moved), abs(now - alike), now))
        before = after
    return Walk(np.array(counts), *(np.stack(each) for each in zip(*changes, strict=True)))
