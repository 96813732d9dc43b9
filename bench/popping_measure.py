"""Popping: what appears or vanishes at full size, and what changes that motion does not explain.

Two figures of a walk, each of pairs of consecutive frames. Parts that are displayed in one frame
only and show more than half of themselves there, though both frames have them in view, have popped.
And of each pixel the surface it shows is looked up in the frame before (by Z and both cameras):
where that frame shows the same surface, their difference is what motion does not explain. The
picture is the albedo alone, a mean of many samples at the same places of every pixel in every
frame: no light, no air and no noise, only what covers what.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64

from lod.air import CLEAR
from lod.arrays import Reals, freeze
from lod.camera import GRID_M, Camera
from lod.fade import looks
from lod.prune import Cut, prune
from lod.view import View, in_view
from scenes.field import SpeciesField
from scenes.preset import Preset
from scenes.render.frame import Layers, Light, Quality, Visible
from scenes.render.render import render_frame
from scenes.shot import short_ids
from scenes.world import World, view_at

AT_FULL_SIZE = 0.5
"""Share of itself from which on a part that comes or goes is said to pop."""

SAME_SURFACE = 0.02
"""Two distances are of one surface when they differ by no more than this share."""

_FARTHEST_M = 1e6

Pixels = Int64[np.ndarray, "h w"]


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
    """One frame of a walk: its view, its parts by representation, and its picture."""

    view: View
    seen: dict[str, Seen]
    layers: Layers


def frames_of(world: World, preset: Preset, frames: Sequence[int], variant: str) -> Iterator[Frame]:
    """The frames of a walk, one after the other."""
    quality = Quality(variant, preset.render.spp, preset.seed, max_depth=1)
    light = Light(preset.light.sun_azimuth, preset.light.sun_elevation)
    for number in frames:
        view, visible, seen = view_at(world, preset, number), [], {}
        for each in world.representations:
            cut = prune(each, view)
            look = looks(cut, view)
            if isinstance(each, SpeciesField):  # the ground's vertices move; its tiles do not pop
                seen[each.name] = seen_of(cut, np.maximum(look.inner, look.leaf))
            shape = each.appearance(cut.parts, look)
            visible.append(Visible(each.name, short_ids(cut), shape))
        # Always frame 0: the same places in every pixel.
        layers = render_frame(view.camera, visible, CLEAR, light, quality, 0)
        yield Frame(view, seen, layers)


def seen_of(cut: Cut, size: Reals) -> Seen:
    """Who the parts of a species' cut are, and where."""
    parts = cut.parts
    draws, who = parts.state.draws, parts.object
    key = np.stack((draws.cell_x[who], draws.cell_y[who], draws.index[who], parts.part), axis=1)
    return Seen(key, size, parts.centre, parts.bound)


def popped(before: Frame, after: Frame) -> int:
    """Parts that appear or vanish at full size, in view before and after."""
    return sum(
        _only_in(before.seen[name], before.view, after.seen[name], after.view)
        + _only_in(after.seen[name], after.view, before.seen[name], before.view)
        for name in before.seen
    )


def _only_in(here: Seen, view: View, there: Seen, other: View) -> int:
    """Parts displayed here and not there, at full size and in view of both."""
    both = np.concatenate((there.key, here.key))
    _, first = np.unique(both, axis=0, return_index=True)
    alone = first[first >= len(there.key)] - len(there.key)
    alone = alone[here.size[alone] > AT_FULL_SIZE]
    centre, bound = here.centre[alone], here.bound[alone]
    seen = in_view(view, centre, bound)
    seen &= in_view(other, centre + shift(view.camera, other.camera), bound)
    return int(np.count_nonzero(seen))


def shift(old: Camera, new: Camera) -> Float64[np.ndarray, "3"]:
    """What to add to a place of the old frame to have it in the new one [m]."""
    a, b = old.corner, new.corner
    return GRID_M * np.array((a.x - b.x, a.y - b.y, 0.0))


def unexplained(before: Frame, after: Frame) -> Reals:
    """Changes that motion does not explain, of every pixel of both frames that can be told.

    Looked up both ways, from either frame to the other: what vanishes shows in one of them alone.
    """
    return np.concatenate((_changes(after, before), _changes(before, after)))


def _changes(here: Frame, there: Frame) -> Reals:
    """By how much each pixel's albedo leaves the range of the 3 × 3 pixels about its place there.

    Left out: what is out of the other picture, or hidden in it by something nearer.
    """
    camera, other = here.view.camera, there.view.camera
    far = np.minimum(here.layers.Z.astype(np.float64), _FARTHEST_M)
    place = camera.eye + _directions(camera) * far[..., None] + shift(camera, other)
    column, row, away = _projected(other, place)
    inside = (np.minimum(column, row) >= 1) & np.isfinite(away)
    inside &= (column < other.width - 1) & (row < other.height - 1)
    column, row, now = column[inside], row[inside], here.layers.albedo[inside].astype(np.float64)
    about = [(row + j, column + i) for j in (-1, 0, 1) for i in (-1, 0, 1)]
    albedo = np.stack([there.layers.albedo[at] for at in about])
    Z = np.stack([np.minimum(there.layers.Z[at], _FARTHEST_M) for at in about]) / away[inside]
    shown = (np.abs(Z - 1) < SAME_SURFACE).any(axis=0) | (Z > 1).all(axis=0)
    beyond = np.maximum(albedo.min(axis=0) - now, now - albedo.max(axis=0))
    return np.maximum(beyond, 0.0).max(axis=1)[shown]


def _directions(camera: Camera) -> Float64[np.ndarray, "h w 3"]:
    """Unit vectors through the middles of the pixels, rows from the top."""
    tan_x, tan_y = camera.tan_half
    x = tan_x * (2 * (np.arange(camera.width) + 0.5) / camera.width - 1)
    y = tan_y * (1 - 2 * (np.arange(camera.height) + 0.5) / camera.height)
    ray = camera.forward + x[None, :, None] * camera.right + y[:, None, None] * camera.up
    return ray / np.linalg.norm(ray, axis=-1, keepdims=True)


def _projected(
    camera: Camera, place: Float64[np.ndarray, "h w 3"]
) -> tuple[Pixels, Pixels, Float64[np.ndarray, "h w"]]:
    """Column and row of places on the film, and how far they are [m]; not ahead: infinitely."""
    ray = place - camera.eye
    depth = ray @ camera.forward
    ahead = depth > 0
    depth = np.where(ahead, depth, 1.0)
    tan_x, tan_y = camera.tan_half
    x = (1 + ray @ camera.right / (depth * tan_x)) * camera.width / 2
    y = (1 - ray @ camera.up / (depth * tan_y)) * camera.height / 2
    pixel = (np.floor(np.clip(v, -1.0, 1e6)).astype(np.int64) for v in (x, y))
    return *pixel, np.where(ahead, np.linalg.norm(ray, axis=-1), np.inf)


@dataclass(frozen=True, eq=False)
class Walk:
    """A measured walk: parts popped between frames (f - 1,), and all unexplained changes (n,)."""

    popped: np.ndarray
    unexplained: np.ndarray

    def __post_init__(self) -> None:
        freeze(self, popped=np.int64, unexplained=np.float64)


def walk(world: World, preset: Preset, frames: Sequence[int], variant: str) -> Walk:
    """Walk once through a world as the preset says."""
    counts, changes, before = [], [], None
    for after in frames_of(world, preset, frames, variant):
        if before is not None:
            counts.append(popped(before, after))
            changes.append(unexplained(before, after))
        before = after
    return Walk(np.array(counts), np.concatenate(changes))
