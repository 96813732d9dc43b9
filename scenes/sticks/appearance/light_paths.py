"""Light from one object alone on level ground, followed from far eyes back to sun and sky.

Paths are those of ``scenes.far_cover.stand_paths``, through a single object. Those that meet shapes
which stand for hidden parts are kept apart by how often they do, so that the light for any albedo
of these shapes is a polynomial in it.
"""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64
from numba import njit

from lod.arrays import Flags, Points
from lod.threads import map_chunks
from scenes.sticks.appearance.sun_and_sky import SunAndSky, cosine_direction
from scenes.sticks.contrast import LUMINANCE
from scenes.sticks.ray_grid import Grids, intersect_ray, make_grids, normal_at
from scenes.sticks.shapes import Shapes

_OFFSET_M = 1e-4
"""Distance from a surface at which rays leave it [m]."""

_BLOCK = 1024
"""Number of lines whose light is added up at once."""

_GOLDEN = (math.sqrt(5) - 1) / 2


class LoneObject(NamedTuple):
    """One object on level ground.

    grids           of its sticks and triangles
    albedo (k, 3), shape (k,)  of each; shape is 1 where it stands for hidden parts, else 0
    radius, low, high  of the upright cylinder that holds it [m]
    ground (3,)     albedo of the ground
    """

    grids: Grids
    albedo: np.ndarray
    shape: np.ndarray
    radius: float
    low: float
    high: float
    ground: np.ndarray


def lone_object(shown: Shapes, albedo: Points, shape: Flags, ground: np.ndarray) -> LoneObject:
    """Put sticks and triangles on ground of an albedo (3,)."""
    points, radii = shown.spheres
    reach = float((np.hypot(points[:, 0], points[:, 1]) + radii).max())
    low, high = (float(corner[2]) for corner in shown.box)
    numbers = shape.astype(np.int64)
    return LoneObject(
        make_grids([shown]), np.ascontiguousarray(albedo), numbers, reach, low, high, ground
    )


def outgoing_light(
    one: LoneObject, light: SunAndSky, elevation_deg: float, randoms: Float64[np.ndarray, "n d"]
) -> Float64[np.ndarray, "s t"]:
    """Measure the luminance that an object sends to an elevation, over that of lit ground [m²].

    It is by how many shapes that stand for hidden parts its path meets (s), and by the azimuth of
    the sun (t), in the mean over the object's own azimuths.

    randoms (n, d)  numbers from 0 to 1 for n lines of sight: two for where each is, and two for
                    every surface that a path may be scattered from
    """
    e, weights = math.radians(elevation_deg), np.array(LUMINANCE)

    # Sums are over blocks of lines, so that they are the same on any number of threads.
    starts = range(0, len(randoms), _BLOCK)

    def run(first: int, last: int) -> list[np.ndarray]:
        blocks = [(start, randoms[start : start + _BLOCK]) for start in starts[first:last]]
        return [_trace(one, light, weights, e, each, start) for start, each in blocks]

    across = 2 * one.radius
    up = (one.high - one.low) * math.cos(e) + across * math.sin(e)
    sums = [each for some in map_chunks(run, len(starts), 1) for each in some]
    total: np.ndarray = np.sum(sums, axis=0)
    return total * (across * up / len(randoms))


@njit(cache=True, nogil=True)
def _trace(one, light, weights, e, randoms, first):  # type: ignore[no-untyped-def]
    """Sum of luminance over lines, by shapes met and by azimuth of the sun, (s, t)."""
    n, d = randoms.shape
    sums = np.zeros((d // 2, len(light.azimuth)))
    middle = (one.low + one.high) / 2
    far = one.radius + one.high - one.low + 1.0
    up = (one.high - one.low) * math.cos(e) + 2 * one.radius * math.sin(e)
    for i in range(n):
        turn = 2 * math.pi * (((first + i) * _GOLDEN) % 1.0)
        cos, sin = math.cos(turn), math.sin(turn)
        eye = np.array((math.cos(e) * cos, math.cos(e) * sin, math.sin(e)))
        aside = (2 * randoms[i, 0] - 1) * one.radius
        along = (randoms[i, 1] - 0.5) * up
        origin = np.array(
            (
                far * eye[0] - aside * sin - along * math.sin(e) * cos,
                far * eye[1] + aside * cos - along * math.sin(e) * sin,
                middle + far * eye[2] + along * math.cos(e),
            )
        )
        t, k = intersect_ray(
            one.grids, 0, (origin[0], origin[1], origin[2]), (-eye[0], -eye[1], -eye[2]), math.inf
        )
        if k >= 0:
            p = origin - t * eye
            if p[2] > 0.0:
                met = p, k, -eye
                _follow(one, light, weights, (turn, first + i), met, randoms[i, 2:], sums)
    return sums


@njit(cache=True)
def _follow(one, light, weights, line, meets, randoms, sums):  # type: ignore[no-untyped-def]
    """Add the luminance of one path from where it meets a shape on.

    ``line``: azimuth, number; ``meets``: the point, the row of the shape, and the way there
    """
    (turn, number), (p, k, v) = line, meets
    side = 1.0 if number % 2 else -1.0
    normal = normal_at(one.grids.shapes[k], p, v)
    weight, met, may_touch = one.albedo[k].copy(), one.shape[k], True
    for step in range(len(randoms) // 2):
        q = p + _OFFSET_M * normal
        _add_sun(one, light, weights, (turn, side), q, normal, weight, sums[met])
        v = cosine_direction(normal, randoms[2 * step], randoms[2 * step + 1])
        t, k = intersect_ray(one.grids, 0, (q[0], q[1], q[2]), (v[0], v[1], v[2]), math.inf)
        ground = -q[2] / v[2] if v[2] < 0 else math.inf
        if k >= 0 and t < ground:
            p = q + t * v
            normal = normal_at(one.grids.shapes[k], p, v)
            weight = weight * one.albedo[k]
            met += one.shape[k]
        elif ground < math.inf:
            if not may_touch:
                return
            may_touch, weight = False, weight * one.ground
            p, normal = q + ground * v, np.array((0.0, 0.0, 1.0))
        else:
            _add_sky(light, weights, (turn, side), v, weight, sums[met])
            return


@njit(cache=True)
def _add_sun(one, light, weights, seen, q, normal, weight, into):  # type: ignore[no-untyped-def]
    """Add the sun's light at a point, where nothing is before the sun, for every azimuth."""
    turn, side = seen
    sent = (weight * light.sun * weights).sum()
    for a in range(len(light.azimuth)):
        high = light.to_sun[a, 2]
        level, at = math.sqrt(1.0 - high * high), turn + side * light.azimuth[a]
        x, y = level * math.cos(at), level * math.sin(at)
        facing = (normal[0] * x + normal[1] * y + normal[2] * high) / high
        if facing > 0:
            k = intersect_ray(one.grids, 0, (q[0], q[1], q[2]), (x, y, high), math.inf)[1]
            if k < 0:
                into[a] += sent * facing


@njit(cache=True)
def _add_sky(light, weights, seen, v, weight, into):  # type: ignore[no-untyped-def]
    """Add the light of the cell of the sky in direction v, for every azimuth of the sun."""
    turn, side = seen
    rises, turns = light.sky.shape[:2]
    row = min(int(v[2] * rises), rises - 1)
    for a in range(len(light.azimuth)):
        away = math.atan2(v[1], v[0]) - turn - side * light.azimuth[a]
        away = abs((away + math.pi) % (2 * math.pi) - math.pi) / math.pi
        cell = light.sky[row, min(int(away * turns), turns - 1)]
        into[a] += (weight * cell * weights).sum()
