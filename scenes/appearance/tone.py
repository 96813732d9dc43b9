"""How brightly leaf appearances shine: the multiple of their albedo that what they hide asks for.

``docs/appearance.md`` has the procedure. Light is followed from far eyes back to sun and sky, along
paths as of ``scenes.ground.stand``, through a single object on level ground. Paths that meet shapes
which stand for hidden parts are kept apart by how often they do, so that the light for any albedo
of these shapes is a polynomial in it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from lod.arrays import Flags, Points, Reals
from lod.kernels import map_chunks, njit
from scenes.appearance.fit import CODE
from scenes.appearance.ray_grid import Grids, intersect_ray, make_grids, normal_at
from scenes.appearance.sky import GRASS, SunAndSky, cosine_direction, sky_at
from scenes.processes.cache import kept, rounded_key
from scenes.processes.progress import tell
from scenes.sticks.areas import AZIMUTHS_DEG, ELEVATIONS_DEG, with_area_share
from scenes.sticks.prototype import LUMINANCE, Prototype, Shapes

LINES = 80_000  # lines of sight from each elevation, over all objects that are fitted together

SIZE_M = 10.0
"""Range R that objects are scaled to, so that rays go through boxes of a like size [m]."""

BOUNDS = 0.05, 2.5  # least and greatest tone
FAINT = 0.03  # share of an object's light below which shapes keep their own albedo

_SEED = 0x70E
_NEWTON_STEPS = 12
_CIRCLE = np.array((0.5, *(1.0,) * (len(AZIMUTHS_DEG) - 2), 0.5)) / (len(AZIMUTHS_DEG) - 1)
"""Share of the circle that each of AZIMUTHS_DEG stands for."""

_OFFSET_M = 1e-4  # distance from a surface at which rays leave it [m]
_BLOCK = 1024  # number of lines whose light is added up at once

_GOLDEN = (math.sqrt(5) - 1) / 2


@dataclass(frozen=True)
class Illumination:
    """The light that leaf appearances are fitted in.

    sun_elevation_deg, turbidity  as a preset has them; max_depth: longest path, in segments
    """

    sun_elevation_deg: float
    turbidity: float = 3.0
    max_depth: int = 4


def fit_tone(
    objects: Sequence[Prototype], illumination: Illumination, lines: int = LINES
) -> Float64[np.ndarray, "c h t"]:
    """Fit one table of tones for objects of a kind, or find it where it is kept.

    It is (levels, elevations, azimuths + 1) in size. The last column holds the mean over all
    azimuths (``scenes.sticks.areas``).
    """
    shapes = [each.scaled(SIZE_M / float(each.hierarchy.R[0])) for each in objects]
    looks = []  # rounded, so that the size of an object does not tell
    for each in shapes:
        sticks = (each.inner.first, *each.inner.columns, each.leaf.first, *each.leaf.columns)
        meshes = () if each.meshes is None else each.meshes.surface
        rest = each.tints, each.view_dependence.area_share, each.hierarchy.level
        looks.append((*sticks, *meshes, *rest))
    key = rounded_key(looks, illumination, lines)
    return kept("tone", key, lambda: {"tone": _fit(shapes, illumination, lines)}, CODE)["tone"]


def _fit(
    objects: Sequence[Prototype], illumination: Illumination, lines: int
) -> Float64[np.ndarray, "c h t"]:
    """Fit the tones of objects whose range is SIZE_M."""
    levels = max(len(each.view_dependence.area_share) for each in objects)
    tell()
    full = _light(objects, None, illumination, lines).sum(axis=1)
    tones = np.empty((levels, len(ELEVATIONS_DEG), len(AZIMUTHS_DEG) + 1))
    for level in range(levels):
        tell(1 / (levels + 1))
        parts = _light(objects, level, illumination, lines)
        wanted = np.concatenate((full, (full @ _CIRCLE)[:, None]), axis=1)
        around = (parts @ _CIRCLE)[:, :, None]
        tones[level] = _solve(np.concatenate((parts, around), axis=2), wanted)
    return tones


def _solve(parts: Float64[np.ndarray, "h s t"], wanted: Float64[np.ndarray, "h t"]) -> np.ndarray:
    """Find T with Σ Lₛ·Tˢ = L by Newton's method, kept within BOUNDS.

    It is 1 where the shapes send less than FAINT of the light, and no T could make up for the rest.
    """
    powers = np.arange(parts.shape[1])[:, None]
    tone = np.ones_like(wanted)
    for _ in range(_NEWTON_STEPS):
        value = (parts * tone[:, None] ** powers).sum(axis=1) - wanted
        slope = (parts * powers * tone[:, None] ** np.maximum(powers - 1, 0)).sum(axis=1)
        tone = np.clip(tone - value / np.maximum(slope, 1e-12), *BOUNDS)
    return np.where(parts[:, 1:].sum(axis=1) < FAINT * wanted, 1.0, tone)


def _light(
    objects: Sequence[Prototype], level: int | None, illumination: Illumination, lines: int
) -> Float64[np.ndarray, "h s t"]:
    """Light that objects send down to a level, or in full detail, in the sum over them.

    The shapes of the level show the share of their area that they do from each elevation.
    """
    sky = sky_at(illumination.sun_elevation_deg, illumination.turbidity)
    light = SunAndSky.at_azimuths(illumination.sun_elevation_deg, AZIMUTHS_DEG, sky)
    ground = np.add(*GRASS) / 2
    rng = np.random.Generator(np.random.Philox(_SEED))
    surfaces = max(illumination.max_depth - 1, 1)
    total = np.zeros((len(ELEVATIONS_DEG), surfaces + 1, len(AZIMUTHS_DEG)))
    for each in objects:
        randoms = rng.random((max(lines // len(objects), 1), 2 * surfaces + 2))
        for row in range(len(ELEVATIONS_DEG)):
            shown, shape = displayed_to(each, level, row)
            alone = lone_object(shown, shown.albedos(each.tints), shape, ground)
            total[row] += outgoing_light(alone, light, ELEVATIONS_DEG[row], randoms)
    return total


def displayed_to(one: Prototype, level: int | None, elevation: int) -> tuple[Shapes, Flags]:
    """Collect what an object displays down to a level; None: in full detail.

    Returns it as it looks from a row of ELEVATIONS_DEG, and which of its shapes (k,) stand for
    hidden parts.
    """
    h, views = one.hierarchy, one.view_dependence
    finest = int(h.level.max())
    level = finest if level is None else level
    ends = (h.level == level) | ((h.level < level) & (h.part_count == 0))
    inner = one.inner.only((h.level < level) & ~ends)
    rows = views.rows(len(one.leaf))
    shares: Reals = np.append(views.area_share[:, elevation], 1.0)[rows]
    leaf = with_area_share(one.leaf, np.maximum(shares, 1e-6))
    shown = (ends & ~one.has_mesh)[leaf.owner]
    meshes = one.meshes.only(ends) if one.meshes is not None else None
    found = Shapes.of(inner, meshes).with_sticks(leaf.take(shown))
    hides = np.zeros(len(found), np.bool_)
    hides[len(inner) : len(found.sticks)] = rows[shown] >= 0
    return found, hides


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
