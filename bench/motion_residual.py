"""What does motion not explain of the change from frame to frame, and which parts pop?

Two things are measured of consecutive frames of a walk. Parts that are displayed in one frame only
and show more than half of themselves there, though both frames have them in view, have popped. And
what a frame displays is moved to where it is a frame later and rendered from where the eye is by
then: what the next frame shows otherwise is the motion-compensated residual.

Its pictures are of albedo under a white sky, without shadow or air. A pixel is the mean over its
samples of the albedo that they meet, in luminance, and 1 where they meet the sky: things are as
bright as they would be in even light from all around, unshaded. The only noise left is that of
sampling. Shaded pictures have the sun in them, too, so that relief is seen by its slopes: a white
face that the sun stands over is as bright as the sky.
"""

import gc
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float32

from lod.air import CLEAR
from lod.arrays import Points, Reals, freeze
from lod.camera import GRID_M, Camera
from lod.motion import eye_relative_to
from lod.pruner import Cut, blend_weights, prune
from lod.shapes import Appearance, Sticks, SticksAndTriangles
from lod.view import View, in_view
from scenes.field.species_field import SpeciesField
from scenes.frame.frame_input import (
    DisplayedRepresentation,
    FrameInput,
    Light,
    Posing,
    Quality,
    display,
)
from scenes.render.render import build_frame, trace
from scenes.scene import Scene, frame_quality
from scenes.sticks.prototype import LUMINANCE

AT_FULL_SIZE = 0.5  # the share of itself from which on a part that comes or goes is said to pop

SKY_SHARE = 0.25
"""The share of the light on a face beneath the sun that comes from the sky, in shaded pictures."""

Picture = Float32[np.ndarray, "h w"]


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


def frames_of(scene: Scene, frames: Sequence[int]) -> Iterator[Frame]:
    """Yield the frames of a walk, one after the other."""
    for number in frames:
        view, shown, seen = scene.view(number), [], {}
        for each in scene.world.representations:
            cut = prune(each, view)
            if isinstance(each, SpeciesField):  # the ground's vertices move; its tiles do not pop
                weights = blend_weights(cut, view)
                size = np.maximum(weights.inner, weights.leaf)
                kept = cut.parts.kept  # whole, each blade of those that are left shows 1 ÷ this
                seen[each.name] = seen_of(cut, size if kept is None else size * kept)
            shown.append(scene.scheduled(number, display(each, cut, view)))
        yield Frame(view, tuple(shown), seen)


def seen_of(cut: Cut, size: Reals) -> Seen:
    """Return the parts of a species' cut, and where they are."""
    parts = cut.parts
    samples, who = parts.state.samples, parts.object
    key = np.stack(
        (samples.cell_x[who], samples.cell_y[who], samples.index[who], parts.part), axis=1
    )
    return Seen(key, size, parts.centre, parts.bound)


def rows_missing(keys: np.ndarray, among: np.ndarray) -> np.ndarray:
    """Return the rows of distinct keys (n, 4) that are not among others (m, 4)."""
    _, first = np.unique(np.concatenate((among, keys)), axis=0, return_index=True)
    rows: np.ndarray = first[first >= len(among)] - len(among)
    return rows


def popped(before: Frame, after: Frame) -> int:
    """Count the parts that appear or vanish at full size, in view before and after."""
    return sum(
        _only_in(before, after, name) + _only_in(after, before, name) for name in before.seen
    )


def _only_in(frame: Frame, next_to: Frame, name: str) -> int:
    """Count the parts of one frame that are not displayed in the other, though in view of both."""
    here, there, view, other = frame.seen[name], next_to.seen[name], frame.view, next_to.view
    alone = rows_missing(here.key, there.key)
    alone = alone[here.size[alone] > AT_FULL_SIZE]
    if not len(alone):
        return 0
    centre, bound = here.centre[alone], here.bound[alone]
    a, b = view.camera.corner, other.camera.corner
    shift = GRID_M * np.array((a.x - b.x, a.y - b.y, 0.0))  # from this frame's corner to the other
    by_then = centre + frame.walked(name, other.time_s)[alone] + shift
    seen = in_view(view, centre, bound) & in_view(other, by_then, bound)
    if not seen.any():
        return 0
    # Limbs swing as their object walks: what has swung out of view is where it is posed by then.
    around = next_to.all_round(name)
    outside = ~in_view(other, around.centre, around.bound)
    return len(rows_missing(here.key[alone[seen]], around.key[outside]))


@dataclass(frozen=True, eq=False)
class Walk:
    """A measured walk: columns over its frames but the first, (f − 1, …).

    popped    parts that came or went at full size
    switched  change of every pixel after motion compensation; both frames have the same samples, so
              that no noise is left
    """

    popped: np.ndarray
    switched: np.ndarray

    def __post_init__(self) -> None:
        freeze(self, popped=np.int64, switched=np.float32)


def measure_walk(scene: Scene, frames: Sequence[int], variant: str, shaded: bool = False) -> Walk:
    """Measure consecutive frames of a walk; ``shaded``: whether pictures are shaded by the sun."""
    light, quality = scene.light, frame_quality(scene.preset, variant)
    counts, changes, before = [], [], None
    for number, after in zip(frames, frames_of(scene, frames), strict=True):
        if before is not None:
            at = after.view.camera, after.view.time_s, light, quality, (number,), shaded
            (moved,), (now,) = (silhouettes(each.shown, *at) for each in (before, after))
            counts.append(popped(before, after))
            changes.append(abs(now - moved))
        before = after
    return Walk(np.array(counts), np.stack(changes))


def silhouettes(
    shown: Sequence[DisplayedRepresentation],
    camera: Camera,
    time_s: float,
    light: Light,
    quality: Quality,
    samples: tuple[int, ...],
    shaded: bool = False,
) -> tuple[Picture, ...]:
    """Render what a frame displays, as it is at a time, from any camera near it.

    There is one picture for each of ``samples``, which are numbers of frames: pixels are sampled at
    the places of that frame. Where they are ``shaded``, the sun is that of ``light``.
    """
    corner = next(each.posing.view.camera.corner for each in shown if each.posing)
    here = replace(camera, corner=corner, eye=eye_relative_to(corner, camera))
    visible = []
    for each in shown:
        now = each.at(time_s)
        visible.append(replace(now, shape=_white_shape(now.shape)))
    gc.collect()  # the renderer numbers shapes from 1 only where none before are left
    stage = build_frame(
        FrameInput(here, tuple(visible), CLEAR, light, replace(quality, max_depth=1))
    )
    if not shaded:
        return tuple(_lit(trace(stage, quality, number).albedo, 1.0) for number in samples)
    pictures = []
    for number in samples:
        passes = []  # of one sample a pixel each, so that every sample has a normal of its own
        for k in range(quality.spp):
            seen = trace(stage, replace(quality, spp=1), number * quality.spp + k)
            lit = SKY_SHARE + (1 - SKY_SHARE) * np.maximum(seen.N @ light.to_sun, 0.0)
            passes.append(_lit(seen.albedo, lit))
        pictures.append(np.asarray(np.mean(passes, axis=0), np.float32))
    return tuple(pictures)


def _lit(albedo: np.ndarray, lit: np.ndarray | float) -> Picture:
    """Return luminance from white albedo (h, w, 3), and how lit it is; the sky is white."""
    return np.asarray(albedo[..., 0] * lit + (1 - albedo[..., 1]), np.float32)


def _white_shape(shape: Appearance) -> Appearance:
    """Return a shape whose colours are its luminance, and 1 for its coverage."""
    if isinstance(shape, SticksAndTriangles):
        sticks, triangles = shape.sticks, shape.triangles
        return SticksAndTriangles(
            replace(sticks, tints=_white(sticks.tints)),
            replace(triangles, colours=_white(triangles.colours)),
        )
    if isinstance(shape, Sticks):
        return replace(shape, tints=_white(shape.tints))
    return replace(shape, colours=_white(shape.colours))


def _white(colours: np.ndarray) -> np.ndarray:
    one = np.ones(len(colours))
    return np.column_stack((colours @ LUMINANCE, one, one))
