"""Light in an endless stand of sticks on level ground, followed from the eye back to sun and sky.

Paths as a renderer follows them (Kajiya, "The rendering equation", SIGGRAPH 1986): at every surface
the sun, if it is seen from there, and one direction drawn by its cosine, to the sky or to the next
surface. All is in units of the light on unshadowed level ground, of a sun in one direction and a
sky that is even.
"""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64
from numba import njit

from lod.arrays import Ints, Points
from scenes.stick_grid import Grid, meet

SURFACES = 3
"""That light meets on its way, at most: as ``render.max_depth`` = 4 has it."""

DRAWS = 2 * SURFACES
"""Random numbers that a path needs."""

GROUND = -1

_LIFTED_M = 1e-4


class Seen(NamedTuple):
    """What lines see.

    stick (n,) which they meet first, GROUND where none; height (n,) at which [m]
    sent (n, 3) radiance, by way of sticks alone; lifted (n, 3) by way of the ground once, over its
    albedo. Of lines that meet the ground ``sent`` is over its albedo, and lifted is 0
    """

    stick: Ints
    height: np.ndarray
    sent: Points
    lifted: Points


def seen_along(
    grid: Grid,
    colour: Float64[np.ndarray, "k 3"],
    light: tuple[np.ndarray, np.ndarray],
    start: Points,
    direction: np.ndarray,
    draws: np.ndarray,
) -> Seen:
    """What is seen of a stand along a direction (3,), which points up to the eye, on lines that
    come down to ``start`` (n, 3) on the ground.

    colour (k, 3) of each stick; light: unit vector to the sun and the sky's share, (3,) each;
    draws (n, DRAWS) from 0 to 1
    """
    return Seen(*_seen(grid, colour, *light, start, direction, draws))


@njit(cache=True)
def _seen(grid, colour, to_sun, sky, start, direction, draws):  # type: ignore[no-untyped-def]
    n = len(start)
    stick, height = np.full(n, GROUND), np.zeros(n)
    sent, lifted = np.zeros((n, 3)), np.zeros((n, 3))
    up, level = np.array((0.0, 0.0, 1.0)), np.ones(3)
    for i in range(n):
        above = (max(grid.high, 0.0) + 1.0) / direction[2]
        t, k, a, b, c = meet(grid, start[i] + above * direction, -direction)
        if k >= 0 and t < above:
            p = start[i] + (above - t) * direction
            stick[i], height[i] = k, p[2]
            way = p, np.array((a, b, c)), colour[k].copy()
            _follow(grid, colour, to_sun, sky, way, True, draws[i], sent[i], lifted[i])
        else:
            way = start[i].copy(), up, level
            _follow(grid, colour, to_sun, sky, way, False, draws[i], sent[i], lifted[i])
    return stick, height, sent, lifted


@njit(cache=True)
def _follow(grid, colour, to_sun, sky, way, may_touch, draws, sent, lifted):  # type: ignore[no-untyped-def]
    """Add up what reaches the eye from a point, by its normal and the colour so far. Of the ground
    on the way there is one touch at most."""
    p, normal, weight = way
    into = sent
    for turn in range(SURFACES):
        q = p + _LIFTED_M * normal
        facing = (normal * to_sun).sum() / to_sun[2]
        if facing > 0 and meet(grid, q, to_sun)[1] < 0:
            into += weight * (1 - sky) * facing
        v = _drawn(normal, draws[2 * turn], draws[2 * turn + 1])
        t, k, a, b, c = meet(grid, q, v)
        ground = -q[2] / v[2] if v[2] < 0 else math.inf
        if k >= 0 and t < ground:
            p, normal = q + t * v, np.array((a, b, c))
            weight = weight * colour[k]
        elif ground < math.inf:
            if not may_touch:
                return
            may_touch, into = False, lifted
            p, normal = q + ground * v, np.array((0.0, 0.0, 1.0))
        else:
            into += weight * sky
            return


@njit(cache=True)
def _drawn(normal, u0, u1):  # type: ignore[no-untyped-def]
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
