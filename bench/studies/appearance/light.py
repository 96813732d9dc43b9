"""How bright is a tree, displayed down to a level, against all of it? Path traced by the renderer.

The tree stands on a disc of grass in the light of sun and sky. The eye is so far off that its rays
are nearly parallel. Of every pixel one sample is taken, and it counts where it meets the tree.
"""

import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from bench.studies.appearance.cuts import LoneTree, unit
from lod.arrays import Reals
from lod.atmosphere.air import CLEAR
from lod.camera import Camera, Corner
from lod.pruning.parts import Parts
from lod.pruning.pruner import Cut, cut_from_parts
from lod.pruning.shapes import Triangles
from scenes.frame.displayed import DisplayedRepresentation
from scenes.frame.frame_input import FrameInput
from scenes.frame.quality import Quality
from scenes.render.mitsuba.variants import choose
from scenes.render.pipeline.render import render_frame
from scenes.sticks.appearance.tone import Illumination
from scenes.sticks.contrast import LUMINANCE
from scenes.terrain.colour import GROUND_MATERIALS
from scenes.world.light import Light

SUNS_DEG, EYES_DEG, AZIMUTHS = (10.0, 40.0, 70.0), (0.0, 30.0), 16
"""Elevations of the sun and of the eye, and the number of its azimuths."""

SIZE_PX, AWAY, GROUND_M = 192, 60.0, 60.0
"""Side of a picture, distance of the eye in radii of the tree, and half the side of the ground."""


@lru_cache(maxsize=1)
def _whole(tree: LoneTree) -> dict[tuple[float, float], float]:
    return _mean_radiance(tree, tree.finest)


def radiance_ratios(tree: LoneTree, level: int) -> Reals:
    """Compute the radiance of a level over that of the whole, for every sun and elevation.

    Both are means over all samples that meet the tree from any azimuth.
    """
    whole, found = _whole(tree), _mean_radiance(tree, level)
    return np.array([found[key] / whole[key] for key in whole])


def _mean_radiance(tree: LoneTree, level: int) -> dict[tuple[float, float], float]:
    """Mean luminance of a tree down to a level, by elevation of the sun and of the eye."""
    return {
        (sun, eye): float(np.concatenate(list(_samples(tree, level, sun, eye))).mean())
        for sun in SUNS_DEG
        for eye in EYES_DEG
    }


def _samples(tree: LoneTree, level: int, sun_deg: float, eye_deg: float) -> Iterator[Reals]:
    """Yield the luminance of every sample that meets the tree, azimuth by azimuth."""
    light = Light(90.0, sun_deg)  # the sun is over the x axis
    quality, tone = Quality(choose(), 1, 0), Illumination(sun_deg)
    for turn in (np.arange(AZIMUTHS) + 0.5) * 360.0 / AZIMUTHS:
        seen_from = math.sin(math.radians(eye_deg)), math.cos(math.radians(turn))
        sticks = tree.sticks(level, *seen_from, tone)
        shown = DisplayedRepresentation("tree", tree.every, sticks), _ground()
        camera = _camera(tree, unit(turn, eye_deg))
        layers = render_frame(FrameInput(camera, shown, CLEAR, light, quality), int(turn))
        yield (layers.rgb.astype(np.float64) @ LUMINANCE)[layers.object == 1]


def _camera(tree: LoneTree, toward: Reals) -> Camera:
    """Look at the middle of a tree from afar."""
    at = tree.every.parts.position
    tall = float(at[:, 2].max())
    half = 1.1 * max(float(np.hypot(at[:, 0], at[:, 1]).max()), tall / 2)
    eye = np.array((0.0, 0.0, tall / 2)) + AWAY * tree.reach * toward
    up = np.array((0.0, 0.0, 1.0)) - toward[2] * toward
    fov = 2 * math.atan(half / (AWAY * tree.reach))
    return Camera(Corner(0, 0), eye, -toward, up / np.linalg.norm(up), fov, SIZE_PX, SIZE_PX)


def _ground() -> DisplayedRepresentation:
    """Make a square of level grass."""
    s = GROUND_M
    corners = np.array([(-s, -s, 0.0), (s, -s, 0.0), (s, s, 0.0), (-s, s, 0.0)])
    grass = GROUND_MATERIALS["grassy"]
    colour = (np.array(grass.moist) + np.array(grass.dry)) / 2
    up, faces = np.tile((0.0, 0.0, 1.0), (4, 1)), np.array([[0, 1, 2], [0, 2, 3]])
    shape = Triangles(corners, up, np.tile(colour, (4, 1)), faces, np.zeros(2))
    return DisplayedRepresentation("ground", _one_part(), shape)


def _one_part() -> Cut:
    """Make the cut of something that is one part, and is displayed as it is."""
    zero, row = np.zeros(1), np.zeros(1, np.int64)
    at = np.zeros((1, 3))
    parts = Parts(at, at, zero, zero, zero, row, row, row, row - 1, zero + 1)
    return cut_from_parts(parts, 1, 1)
