"""Light in an endless stand on level ground, followed from the eye back to sun and sky.

Paths as a renderer follows them (Kajiya, "The rendering equation", SIGGRAPH 1986): at every surface
the sun, if it is seen from there, and one direction drawn by its cosine, to the sky or to the next
surface. All is in units of the light on unshadowed level ground.
"""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64
from numba import njit

from lod.arrays import Ints
from lod.threads import map_chunks
from scenes.appearance.sky import SunAndSky, cosine_direction
from scenes.far_cover.stand_rays import StandField, intersect_layers

MAX_DEPTH = 4
"""Longest path in segments, as presets have it by default (``render.max_depth``)."""

GROUND = -1
"""Row in place of a stick's where a line of sight meets no stick, but the ground."""

_OFFSET_M = 1e-4
"""Distance from a surface at which rays leave it, so that they do not meet it again [m]."""

_LINES_PER_THREAD = 64
"""Number of lines for which another thread is worth its start."""


class LitStand(NamedTuple):
    """A stand in layers, the albedo (k, 3) of every stick of its prototypes, and its light."""

    layers: tuple[StandField, ...]
    albedo: np.ndarray
    light: SunAndSky


class LineSamples(NamedTuple):
    """What n lines of sight see.

    stick (n,)             row of the stick that each meets first, or GROUND
    height (n,)            height at which it does [m]
    radiance (n, t, 3)     light by way of sticks alone
    ground_bounce (n, t, 3)  light by way of the ground once, over the ground's albedo

    The radiance of lines that meet the ground is over its albedo, and their ground_bounce is 0.
    """

    stick: Ints
    height: np.ndarray
    radiance: np.ndarray
    ground_bounce: np.ndarray


class _PathPoint(NamedTuple):
    """A point on a path of light, the outward normal there, and the albedo so far, (3,) each."""

    point: np.ndarray
    normal: np.ndarray
    weight: np.ndarray


def randoms_per_path(max_depth: int) -> int:
    """Count the random numbers that a path of at most ``max_depth`` segments takes.

    It takes two at every surface that it may be scattered from. The first segment ends at the first
    surface, and the last one at the light, so that there is one surface less than segments. At
    least one surface is lit in any case.
    """
    return 2 * max(max_depth - 1, 1)


def trace_lines(
    layers: tuple[StandField, ...],
    albedo: Float64[np.ndarray, "k 3"],
    light: SunAndSky,
    depression_deg: float,
    randoms: Float64[np.ndarray, "n d"],
    first: int = 0,
) -> LineSamples:
    """Trace lines down to the ground at the origin, each through a stand of its own.

    All of one line's light comes by the same paths for every azimuth of the sun; half of the lines
    have the sun on one side and half on the other.

    albedo (k, 3)   of each stick of the prototypes, layer after layer
    randoms (n, d)  numbers from 0 to 1, with d of ``randoms_per_path``
    first           number of the first line's stand; the others' follow
    """
    e = math.radians(depression_deg)
    direction = np.array((math.cos(e), 0.0, math.sin(e)))
    lit = LitStand(layers, albedo, light)

    def run(begin: int, end: int) -> tuple[np.ndarray, ...]:
        found: tuple[np.ndarray, ...] = _trace(lit, direction, randoms[begin:end], first + begin)
        return found

    found = map_chunks(run, len(randoms), _LINES_PER_THREAD)
    return LineSamples(*(np.concatenate(each) for each in zip(*found, strict=True)))


@njit(cache=True, nogil=True)
def _trace(lit, direction, randoms, first):  # type: ignore[no-untyped-def]
    """Columns of LineSamples for the lines of stands ``first`` and on; ``direction`` is upward."""
    n, turns = len(randoms), len(lit.light.azimuth)
    stick, height = np.full(n, GROUND), np.zeros(n)
    radiance, bounce = np.zeros((n, turns, 3)), np.zeros((n, turns, 3))
    up, white = np.array((0.0, 0.0, 1.0)), np.ones(3)
    top = 0.0
    for layer in lit.layers:
        top = max(top, layer.top)
    above = (top + 1.0) / direction[2]
    for i in range(n):
        t, k, normal = intersect_layers(lit.layers, first + i, above * direction, -direction)
        on_stick = k >= 0 and t < above
        if on_stick:
            p = (above - t) * direction
            stick[i], height[i] = k, p[2]
            start = _PathPoint(p, normal, lit.albedo[k].copy())
        else:
            start = _PathPoint(np.zeros(3), up, white)
        _follow_path(lit, first + i, start, on_stick, randoms[i], radiance[i], bounce[i])
    return stick, height, radiance, bounce


@njit(cache=True)
def _follow_path(lit, number, start, may_touch, randoms, radiance, bounce):  # type: ignore[no-untyped-def]
    """Add light that reaches the eye by way of a point to ``radiance``, (t, 3).

    Where the path ``may_touch`` the ground it does so once, and what comes by way of it is added to
    ``bounce`` (t, 3) instead.
    """
    p, normal, weight = start.point, start.normal, start.weight
    into, side = radiance, 1.0 if number % 2 else -1.0
    for turn in range(len(randoms) // 2):
        q = p + _OFFSET_M * normal
        _add_sun(lit, number, side, _PathPoint(q, normal, weight), into)
        v = cosine_direction(normal, randoms[2 * turn], randoms[2 * turn + 1])
        t, k, met = intersect_layers(lit.layers, number, q, v)
        ground = -q[2] / v[2] if v[2] < 0 else math.inf
        if k >= 0 and t < ground:
            p, normal = q + t * v, met
            weight = weight * lit.albedo[k]
        elif ground < math.inf:
            if not may_touch:
                return
            may_touch, into = False, bounce
            p, normal = q + ground * v, np.array((0.0, 0.0, 1.0))
        else:
            _add_sky(lit.light, side, v, weight, into)
            return


@njit(cache=True)
def _add_sun(lit, number, side, at, into):  # type: ignore[no-untyped-def]
    """Add the sun's light at a point, where no stick is before the sun, for every azimuth."""
    for turn in range(len(lit.light.azimuth)):
        x, y, z = lit.light.to_sun[turn]
        to_sun = np.array((x, side * y, z))
        facing = (at.normal * to_sun).sum() / z
        if facing > 0 and intersect_layers(lit.layers, number, at.point, to_sun)[1] < 0:
            into[turn] += at.weight * lit.light.sun * facing


@njit(cache=True)
def _add_sky(light, side, v, weight, into):  # type: ignore[no-untyped-def]
    """Add the light of the cell of the sky in direction v, for every azimuth of the sun."""
    rises, turns = light.sky.shape[:2]
    row = min(int(v[2] * rises), rises - 1)
    for turn in range(len(light.azimuth)):
        away = math.atan2(v[1], v[0]) - side * light.azimuth[turn]
        away = abs((away + math.pi) % (2 * math.pi) - math.pi) / math.pi
        into[turn] += weight * light.sky[row, min(int(away * turns), turns - 1)]
