"""What motion does not explain of a lit picture, looked up in the picture before (or after) it.

Of each pixel the surface it shows is looked up in the other frame (by Z and both cameras): where
that frame shows the same surface, their difference is what motion does not explain. The albedo is
compared, a mean of many samples: no light and no air, only what covers what. For pictures whose
parts are no longer there to be moved themselves, as ``popping_measure`` does, which is sharper.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64

from bench.popping_measure import shift
from lod.arrays import Reals
from lod.camera import Camera
from lod.view import View
from scenes.render.frame import Layers

SAME_SURFACE = 0.02
"""Two distances are of one surface when they differ by no more than this share."""

_FARTHEST_M = 1e6

Pixels = Int64[np.ndarray, "h w"]


@dataclass(frozen=True, eq=False)
class Shot:
    """A frame: its view, and its picture."""

    view: View
    layers: Layers


def unexplained(before: Shot, after: Shot) -> Reals:
    """Changes that motion does not explain, of every pixel of both frames that can be told.

    Looked up both ways, from either frame to the other: what vanishes shows in one of them alone.
    """
    return np.concatenate((_changes(after, before), _changes(before, after)))


def _changes(here: Shot, there: Shot) -> Reals:
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
