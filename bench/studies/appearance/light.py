"""How bright is an object, displayed down to a level, against all of it?

It is path traced by the renderer. It stands on grass in the light of sun and sky. The eye is so far
off that its rays are nearly parallel. Of every pixel one sample is taken, and it counts where it
meets the object.
"""

import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from bench.studies.appearance.cuts import LoneObject, shapes_of, unit
from lod.air import CLEAR
from lod.arrays import Reals
from lod.camera import Camera, Corner
from lod.pruner import Cut, Parts, cut_from_parts
from lod.shapes import Triangles
from scenes.appearance.tone import Illumination
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput, Quality
from scenes.ground.shading import GROUND_MATERIALS
from scenes.render.render import render_frame
from scenes.render.variants import choose
from scenes.sticks.prototype import LUMINANCE
from scenes.world.light import Light

SUNS_DEG, EYES_DEG, AZIMUTHS = (10.0, 40.0, 70.0), (0.0, 30.0), 16
"""Elevations of the sun and of the eye, and the number of its azimuths from the sun."""

_SUN_STEPS = 5
"""Steps by which the sun goes on where its angle to the eye goes on by one: pairs lie evenly (a
lattice), with the sun in all azimuths and the eye, which goes on by one step more, in half."""

SIZE_PX, AWAY, GROUND_RADII = 256, 60.0, 6.0
"""Side of a picture; distance of the eye and half the side of the ground, in the object's radii."""


@lru_cache(maxsize=1)
def _whole(one: LoneObject) -> dict[tuple[float, float], float]:
    return _mean_radiance(one, one.finest)


def radiance_ratios(one: LoneObject, level: int) -> Reals:
    """Compute the radiance of a level over that of the whole, for every sun and elevation.

    Both are means over all samples that meet the object from any azimuth.
    """
    whole, found = _whole(one), _mean_radiance(one, level)
    return np.array([found[key] / whole[key] for key in whole])


def _mean_radiance(one: LoneObject, level: int) -> dict[tuple[float, float], float]:
    """Mean luminance of an object down to a level, by elevation of the sun and of the eye."""
    return {
        (sun, eye): float(np.concatenate(list(_samples(one, level, sun, eye))).mean())
        for sun in SUNS_DEG
        for eye in EYES_DEG
    }


def _samples(one: LoneObject, level: int, sun_deg: float, eye_deg: float) -> Iterator[Reals]:
    """Yield the luminance of every sample that meets the object, azimuth by azimuth."""
    quality, tone = Quality(choose(), 1, 0), Illumination(sun_deg)
    for number, (sun_at, turn) in enumerate(azimuths(AZIMUTHS)):
        light = Light((90.0 - sun_at) % 360.0, sun_deg)  # counter-clockwise from the x axis
        seen_from = math.sin(math.radians(eye_deg)), math.cos(math.radians(turn))
        seen = one.shown(level, *seen_from, tone)
        shown = DisplayedRepresentation("object", one.every, seen), _ground(one)
        camera = _camera(one, unit(sun_at + turn, eye_deg))
        layers = render_frame(FrameInput(camera, shown, CLEAR, light, quality), number)
        yield (layers.rgb.astype(np.float64) @ LUMINANCE)[layers.object == 1]


def azimuths(count: int) -> list[tuple[float, float]]:
    """Choose azimuths of the sun, and of the eye from the sun, so many pairs [deg].

    The sun goes round, too, so that no side of the object faces it or the eye more than another.
    """
    step = 360.0 / count
    return [(_SUN_STEPS * k * step % 360.0, (k + 0.5) * step) for k in range(count)]


def _camera(one: LoneObject, toward: Reals) -> Camera:
    """Look at the middle of an object from afar."""
    radius, middle, tall = _cylinder(one)
    half, away = 1.1 * max(radius, tall / 2), AWAY * one.reach
    eye = np.array((0.0, 0.0, middle)) + away * toward
    up = np.array((0.0, 0.0, 1.0)) - toward[2] * toward
    fov = 2 * math.atan(half / away)
    return Camera(Corner(0, 0), eye, -toward, up / np.linalg.norm(up), fov, SIZE_PX, SIZE_PX)


@lru_cache(maxsize=1)
def _cylinder(one: LoneObject) -> tuple[float, float, float]:
    """Radius, middle and height of the upright cylinder that holds all of an object [m]."""
    points, radii = shapes_of(one.shown(one.finest, 0.0)).spheres
    low, high = float((points[:, 2] - radii).min()), float((points[:, 2] + radii).max())
    return float((np.hypot(*points.T[:2]) + radii).max()), (low + high) / 2, high - low


def _ground(one: LoneObject) -> DisplayedRepresentation:
    """Make a square of level grass about an object."""
    s = GROUND_RADII * one.reach
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
