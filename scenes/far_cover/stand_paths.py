"""Light in an endless stand on level ground, followed from the eye back to sun and sky.

Paths as a renderer follows them (Kajiya, "The rendering equation", SIGGRAPH 1986): at every surface
the sun, if it is seen from there, and one direction drawn by its cosine, to the sky or to the next
surface. All is in units of the light on unshadowed level ground.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64
from numba import njit

from lod.arrays import Ints
from lod.threads import map_chunks
from scenes.far_cover.sky import Sky
from scenes.far_cover.stand_rays import StandField, intersect_stand

MAX_BOUNCES = 3
"""That light meets on its way, at most: as ``render.max_depth`` = 4 has it."""

RANDOMS_PER_PATH = 2 * MAX_BOUNCES
"""Random numbers that a path needs."""

GROUND = -1

_LIFTED_M = 1e-4

_LEAST = 64
"""Lines for which another thread is worth its start."""


class SunAndSky(NamedTuple):
    """to_sun (t, 3) unit vectors to the sun for every turn looked at, and its azimuth (t,) [rad];
    sun (3,) of the light on level ground, what comes from it; sky (r, c, 3) radiance of its cells
    (``scenes.far_cover.sky``)."""

    to_sun: np.ndarray
    azimuth: np.ndarray
    sun: np.ndarray
    sky: np.ndarray

    @staticmethod
    def at_azimuths(elevation_deg: float, turns_deg: Sequence[float], sky: Sky) -> "SunAndSky":
        """That of a sky and the sun that it goes with, at every turn from the azimuth that lines
        come from: at 0 the sun is behind the viewer."""
        e, a = math.radians(elevation_deg), np.radians(turns_deg)
        level = math.cos(e)
        up = np.full(len(a), math.sin(e))
        to_sun = np.column_stack((level * np.cos(a), level * np.sin(a), up))
        return SunAndSky(to_sun, a, 1 - sky.share, sky.radiance)


class LineSamples(NamedTuple):
    """What lines see.

    stick (n,) which they meet first, GROUND where none; height (n,) at which [m]
    sent (n, t, 3) radiance, by way of sticks alone; ground_bounce (n, t, 3) by way of the ground
    once, over its albedo. Of lines that meet the ground ``sent`` is over its albedo, and
    ground_bounce is 0
    """

    stick: Ints
    height: np.ndarray
    sent: np.ndarray
    ground_bounce: np.ndarray


def trace_lines(
    stand: StandField,
    colour: Float64[np.ndarray, "k 3"],
    light: SunAndSky,
    depression_deg: float,
    draws: Float64[np.ndarray, "n d"],
    first: int = 0,
) -> LineSamples:
    """What is seen on lines that come down to the ground at the origin, each of a stand of its own:
    numbers ``first`` and on. All of one line's light comes by the same ways for every turn of the
    sun, half of the lines with the sun on one side and half on the other.

    colour (k, 3) of each stick of the prototypes; draws (n, RANDOMS_PER_PATH) from 0 to 1
    """
    e = math.radians(depression_deg)
    direction = np.array((math.cos(e), 0.0, math.sin(e)))

    def run(begin: int, end: int) -> tuple[np.ndarray, ...]:
        there = stand, colour, light, direction
        found: tuple[np.ndarray, ...] = _trace(*there, draws[begin:end], first + begin)
        return found

    found = map_chunks(run, len(draws), _LEAST)
    return LineSamples(*(np.concatenate(each) for each in zip(*found, strict=True)))


@njit(cache=True, nogil=True)
def _trace(stand, colour, light, direction, draws, first):  # type: ignore[no-untyped-def]
    n, turns = len(draws), len(light.azimuth)
    stick, height = np.full(n, GROUND), np.zeros(n)
    sent, ground_bounce = np.zeros((n, turns, 3)), np.zeros((n, turns, 3))
    up, level = np.array((0.0, 0.0, 1.0)), np.ones(3)
    above = (max(stand.top, 0.0) + 1.0) / direction[2]
    for i in range(n):
        t, k, normal = intersect_stand(stand, first + i, above * direction, -direction)
        if k >= 0 and t < above:
            p = (above - t) * direction
            stick[i], height[i] = k, p[2]
            way = p, normal, colour[k].copy()
            _follow_path(
                stand, first + i, colour, light, way, True, draws[i], sent[i], ground_bounce[i]
            )
        else:
            way = np.zeros(3), up, level
            _follow_path(
                stand, first + i, colour, light, way, False, draws[i], sent[i], ground_bounce[i]
            )
    return stick, height, sent, ground_bounce


@njit(cache=True)
def _follow_path(stand, number, colour, light, way, may_touch, draws, sent, ground_bounce):  # type: ignore[no-untyped-def]
    """Add up what reaches the eye from a point, by its normal and the colour so far. Of the ground
    on the way there is one touch at most."""
    p, normal, weight = way
    into, side = sent, 1.0 if number % 2 else -1.0
    for turn in range(MAX_BOUNCES):
        q = p + _LIFTED_M * normal
        _add_sun(stand, number, light, side, q, normal, weight, into)
        v = _cosine_direction(normal, draws[2 * turn], draws[2 * turn + 1])
        t, k, met = intersect_stand(stand, number, q, v)
        ground = -q[2] / v[2] if v[2] < 0 else math.inf
        if k >= 0 and t < ground:
            p, normal = q + t * v, met
            weight = weight * colour[k]
        elif ground < math.inf:
            if not may_touch:
                return
            may_touch, into = False, ground_bounce
            p, normal = q + ground * v, np.array((0.0, 0.0, 1.0))
        else:
            _add_sky(light, side, v, weight, into)
            return


@njit(cache=True)
def _add_sun(stand, number, light, side, q, normal, weight, into):  # type: ignore[no-untyped-def]
    for turn in range(len(light.azimuth)):
        x, y, z = light.to_sun[turn]
        to_sun = np.array((x, side * y, z))
        facing = (normal * to_sun).sum() / z
        if facing > 0 and intersect_stand(stand, number, q, to_sun)[1] < 0:
            into[turn] += weight * light.sun * facing


@njit(cache=True)
def _add_sky(light, side, v, weight, into):  # type: ignore[no-untyped-def]
    rises, turns = light.sky.shape[:2]
    row = min(int(v[2] * rises), rises - 1)
    for turn in range(len(light.azimuth)):
        away = math.atan2(v[1], v[0]) - side * light.azimuth[turn]
        away = abs((away + math.pi) % (2 * math.pi) - math.pi) / math.pi
        into[turn] += weight * light.sky[row, min(int(away * turns), turns - 1)]


@njit(cache=True)
def _cosine_direction(normal, u0, u1):  # type: ignore[no-untyped-def]
    """A direction about a normal by its cosine (the frame: Duff et al., JCGT 6(1), 2017)."""
    r, turn = math.sqrt(u0), 2 * math.pi * u1
    x, y, z = normal
    sign = math.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    cos, sin, rise = r * math.cos(turn), r * math.sin(turn), math.sqrt(1 - u0)
    return np.array(
        (
            cos * (1.0 + sign * x * x * a) + sin * b + rise * x,
            cos * sign * b + sin * (sign + y * y * a) + rise * y,
            -cos * sign * x - sin * y + rise * z,
        )
    )
