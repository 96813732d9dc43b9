"""What covers what in a frame? Pictures under a white sky, without shadow or air, show popping.

A pixel is the mean over its samples of the albedo that they meet, in luminance, and 1 where they
meet the sky: things are as bright as they would be in even light from all around, unshaded. The
only noise left is that of sampling. Shaded pictures have the sun in them, too, so that relief is
seen by its slopes: a white face that the sun stands over is as bright as the sky.
"""

import gc
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float32

from lod.air import CLEAR
from lod.camera import Camera
from lod.motion import eye_relative_to
from lod.shapes import Appearance, Sticks, SticksAndTriangles
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput, Quality
from scenes.render.render import BuiltFrame, build_frame, trace
from scenes.sticks.prototype import LUMINANCE
from scenes.world.light import Light

SKY_SHARE = 0.25
"""The share of the light on a face beneath the sun that comes from the sky, in shaded pictures."""

Picture = Float32[np.ndarray, "h w"]


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
    visible = [whitened(each.at(time_s)) for each in shown]
    gc.collect()  # the renderer numbers shapes from 1 only where none before are left
    stage = build_frame(
        FrameInput(here, tuple(visible), CLEAR, light, replace(quality, max_depth=1))
    )
    if shaded:
        return tuple(_shaded(stage, quality, number, light.to_sun) for number in samples)
    return tuple(_lit(trace(stage, quality, number).albedo, 1.0) for number in samples)


def _lit(albedo: np.ndarray, lit: np.ndarray | float) -> Picture:
    """Return luminance from whitened albedo (h, w, 3), and how lit it is; the sky is white."""
    return np.asarray(albedo[..., 0] * lit + (1 - albedo[..., 1]), np.float32)


def _shaded(stage: BuiltFrame, quality: Quality, number: int, to_sun: np.ndarray) -> Picture:
    """Return the mean of pictures of one sample a pixel, each of which has a normal of its own."""
    pictures = []
    for k in range(quality.spp):
        seen = trace(stage, replace(quality, spp=1), number * quality.spp + k)
        lit = SKY_SHARE + (1 - SKY_SHARE) * np.maximum(seen.N @ to_sun, 0.0)
        pictures.append(_lit(seen.albedo, lit))
    return np.asarray(np.mean(pictures, axis=0), np.float32)


def whitened(visible: DisplayedRepresentation) -> DisplayedRepresentation:
    """Return a displayed representation whose colours are its luminance, and 1 for its coverage."""
    return replace(visible, shape=_white_shape(visible.shape))


def _white_shape(shape: Appearance) -> Appearance:
    if isinstance(shape, SticksAndTriangles):
        sticks, triangles = shape.sticks, shape.triangles
        return SticksAndTriangles(
            replace(sticks, tints=_whitened(sticks.tints)),
            replace(triangles, colours=_whitened(triangles.colours)),
        )
    if isinstance(shape, Sticks):
        return replace(shape, tints=_whitened(shape.tints))
    return replace(shape, colours=_whitened(shape.colours))


def _whitened(colours: np.ndarray) -> np.ndarray:
    one = np.ones(len(colours))
    return np.column_stack((colours @ LUMINANCE, one, one))
