"""Appearance of an endless stand of objects from afar, measured by tracing lines through it.

**The stand** is a Poisson process of objects that are turned at random. The land is divided into
square cells. The number of objects in a cell, their places, prototypes and azimuths are functions
of the cell and of the number of the stand, so that nothing is stored and stands of different
numbers are independent.

**Light** is followed from the eye back to sun and sky by paths as a renderer follows them (Kajiya,
"The rendering equation", SIGGRAPH 1986): at every surface the sun, if it is seen from there, and
one direction drawn by its cosine, to the sky or to the next surface. All is in units of the light
on unshadowed level ground.

**From afar** every species stands at its density, in full detail. Lines come from above at a few
depressions δ and angles φ from the sun's azimuth, and light is followed back from where they first
meet something. Outlines of whole objects are not sampled: they are measured exactly
(``scenes.sticks.areas``)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from lod.arrays import ArrayData, FloatArray, Ints, Reals
from lod.kernels import map_chunks, njit
from lod.shapes import StickTable
from scenes.appearance.ray_grid import NOTHING, Grids, intersect_ray, make_grids, normal_at
from scenes.appearance.sky import Sky, SunAndSky, cosine_direction
from scenes.noise import lattice_bits, unit_float
from scenes.processes.cache import kept_data, rounded_key
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.areas import areas_of_parts, mean_outline_areas
from scenes.sticks.prototype import Prototype

_SEED = np.uint64(0x57A4D)

_LAYER = 2**40  # what the numbers of a line's stands in one layer and the next differ by


class StandField(NamedTuple):
    """An endless stand of p prototypes.

    grids       grids of the prototypes' sticks
    chance (p,) probability that an object has this prototype or an earlier one
    reach, high (p,)  radius about an object's axis, and height, that it stays within [m]
    low, top    lowest and highest that any object reaches [m]
    cell        side of a cell [m]
    mean, none  mean number of objects in a cell, and probability that there is none
    """

    grids: Grids
    chance: np.ndarray
    reach: np.ndarray
    high: np.ndarray
    low: float
    top: float
    cell: float
    mean: float
    none: float


def stand_field(
    tables: Sequence[StickTable], densities: Reals, cell: float | None = None
) -> StandField:
    """Make a stand of prototypes with densities (p,) [1/m²].

    Stands of one number have the same objects if their cells and densities are the same. A cell may
    not be smaller than the largest reach; by default it is that, or room for one object.
    """
    reach, low, high = np.array([stick_extent(table) for table in tables]).T
    density, furthest = float(densities.sum()), float(reach.max())
    side = max(furthest, 1 / math.sqrt(density)) if cell is None else cell
    assert side >= furthest, "a cell holds what stands in its middle"
    return StandField(
        make_grids(tables),
        np.cumsum(densities) / density,
        reach,
        high,
        float(low.min()),
        float(high.max()),
        side,
        density * side**2,
        math.exp(-density * side**2),
    )


def stick_extent(table: StickTable) -> tuple[float, float, float]:
    """Find the radius about its axis that an object is within, its lowest and highest [m]."""
    radius = np.tile(np.maximum(table.start_radius, table.end_radius), 2)
    x, y, z = table.spheres[0].T
    away = np.hypot(x, y) + radius
    return float(away.max()), float((z - radius).min()), float((z + radius).max())


CROWDED = 16.0
"""Objects in a cell of the largest from which on smaller ones get a layer of finer cells."""


def stand_layers(reach: Reals, densities: Reals) -> list[np.ndarray]:
    """Share out species of these reaches [m] and densities [1/m²], (k,), to layers: rows of each.

    Rays through the large cells of trees would meet thousands of tufts in each.
    """
    furthest = reach.max()
    crowded = (densities * furthest**2 > CROWDED) & (reach < furthest / 2)
    layers = np.flatnonzero(~crowded), np.flatnonzero(crowded)
    return [each for each in layers if len(each)]


@njit(cache=True)
def intersect_layers(layers, number, origin, v):  # type: ignore[no-untyped-def]
    """Find the first stick that a ray meets in stands one in another, as ``intersect_stand`` does.

    Rows count the sticks of all layers; the stands of layers are independent.
    """
    nearest, row, normal = intersect_stand(layers[0], number, origin, v)
    before = len(layers[0].grids.shapes)
    for k in range(1, len(layers)):
        t, stick, met = intersect_stand(layers[k], number + k * _LAYER, origin, v)
        if stick >= 0 and t < nearest:
            nearest, row, normal = t, before + stick, met
        before += len(layers[k].grids.shapes)
    return nearest, row, normal


@njit(cache=True)
def intersect_stand(stand, number, origin, v):  # type: ignore[no-untyped-def]
    """Find the first stick of a stand that a ray meets: distance, row, outward normal (3,).

    Rows count the sticks of all prototypes. Without a hit they are NOTHING, −1 and 0.
    """
    begin, end = 0.0, math.inf
    if v[2] != 0.0:
        one, two = (stand.low - origin[2]) / v[2], (stand.top - origin[2]) / v[2]
        begin, end = max(begin, min(one, two)), max(one, two)
    elif not stand.low <= origin[2] <= stand.top:
        end = -1.0
    nearest, row, normal = NOTHING, -1, np.zeros(3)
    if begin >= end:
        return nearest, row, normal
    cell, step = np.empty(2, np.int64), np.empty(2, np.int64)
    next_t, delta = np.full(2, math.inf), np.full(2, math.inf)
    for c in range(2):
        at = origin[c] + begin * v[c]
        cell[c] = math.floor(at / stand.cell)
        step[c] = 1 if v[c] > 0 else -1
        if v[c] != 0.0:
            edge = (cell[c] + (1 if v[c] > 0 else 0)) * stand.cell
            next_t[c], delta[c] = begin + (edge - at) / v[c], stand.cell / abs(v[c])
    # What stands in the neighbours of a cell may reach into it, and nothing from further off.
    low_x, high_x, low_y, high_y = cell[0] - 1, cell[0] + 1, cell[1] - 1, cell[1] + 1
    while True:
        for x in range(low_x, high_x + 1):
            for y in range(low_y, high_y + 1):
                nearest, row = _intersect_cell(stand, number, x, y, origin, v, nearest, row, normal)
        axis = 0 if next_t[0] < next_t[1] else 1
        if min(nearest, end) <= next_t[axis]:
            return nearest, row, normal
        cell[axis] += step[axis]
        next_t[axis] += delta[axis]
        low_x, high_x, low_y, high_y = cell[0] - 1, cell[0] + 1, cell[1] - 1, cell[1] + 1
        if axis == 0:
            low_x = high_x = cell[0] + step[0]
        else:
            low_y = high_y = cell[1] + step[1]


@njit(cache=True)
def _intersect_cell(stand, number, x, y, origin, v, nearest, row, normal):  # type: ignore[no-untyped-def]
    """Distance and stick that a ray meets first among ``nearest``, ``row`` and a cell's objects.

    The normal there is written to ``normal``.
    """
    bits = lattice_bits(lattice_bits(_SEED, number, 0), x, y)
    for each in range(_poisson_count(stand, unit_float(bits))):
        px = (x + unit_float(lattice_bits(bits, each, 0))) * stand.cell
        py = (y + unit_float(lattice_bits(bits, each, 1))) * stand.cell
        u = unit_float(lattice_bits(bits, each, 2))
        which = min(np.searchsorted(stand.chance, u, side="right"), len(stand.reach) - 1)
        dx, dy = origin[0] - px, origin[1] - py
        begin, end = _cylinder_interval(dx, dy, v, stand.reach[which])
        lowest = origin[2] + (begin if v[2] > 0 else end) * v[2]
        if begin >= min(end, nearest) or lowest > stand.high[which]:
            continue
        turn = 2 * math.pi * unit_float(lattice_bits(bits, each, 3))
        cos, sin = math.cos(turn), math.sin(turn)
        own = cos * dx + sin * dy, cos * dy - sin * dx, origin[2]
        way = cos * v[0] + sin * v[1], cos * v[1] - sin * v[0], v[2]
        t, stick = intersect_ray(stand.grids, which, own, way, nearest)
        if stick >= 0:
            nearest, row = t, stick
            there = own[0] + t * way[0], own[1] + t * way[1], own[2] + t * way[2]
            a, b, normal[2] = normal_at(stand.grids.shapes[stick], there, way)
            normal[0], normal[1] = cos * a - sin * b, sin * a + cos * b
    return nearest, row


@njit(cache=True, inline="always")
def _cylinder_interval(dx, dy, v, reach):  # type: ignore[no-untyped-def]
    """Interval of a ray, begun (dx, dy) from a vertical axis, within reach of it.

    Its end is before its beginning if there is none.
    """
    across, along = v[0] * v[0] + v[1] * v[1], dx * v[0] + dy * v[1]
    apart = dx * dx + dy * dy - reach * reach
    if across == 0.0:
        return 0.0, math.inf if apart <= 0 else -1.0
    square = along * along - across * apart
    if square <= 0:
        return 0.0, -1.0
    root = math.sqrt(square)
    return max((-along - root) / across, 0.0), (root - along) / across


@njit(cache=True, inline="always")
def _poisson_count(stand, u):  # type: ignore[no-untyped-def]
    """Number of objects in a cell: the first n with u below the Poisson sum Σ mᵏ·exp(−m)/k!."""
    term, below, n = stand.none, stand.none, 0
    while u >= below and term > 0.0:
        n += 1
        term *= stand.mean / n
        below += term
    return n


MAX_DEPTH = 4  # longest path in segments, as presets have it by default (``render.max_depth``)
GROUND = -1  # row in place of a stick's where a line of sight meets no stick, but the ground

_OFFSET_M = 1e-4
"""Distance from a surface at which rays leave it, so that they do not meet it again [m]."""

_LINES_PER_THREAD = 64  # number of lines for which another thread is worth its start


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

    def run(begin: int, end: int) -> tuple[np.ndarray, ...]:
        where = direction, randoms[begin:end], first + begin
        found: tuple[np.ndarray, ...] = _trace(layers, albedo, light, *where)
        return found

    found = map_chunks(run, len(randoms), _LINES_PER_THREAD)
    return LineSamples(*(np.concatenate(each) for each in zip(*found, strict=True)))


@njit(cache=True, nogil=True)
def _trace(layers, albedo, light, direction, randoms, first):  # type: ignore[no-untyped-def]
    """Columns of LineSamples for the lines of stands ``first`` and on; ``direction`` is upward."""
    n, turns = len(randoms), len(light.azimuth)
    stick, height = np.full(n, GROUND), np.zeros(n)
    radiance, bounce = np.zeros((n, turns, 3)), np.zeros((n, turns, 3))
    up, white = np.array((0.0, 0.0, 1.0)), np.ones(3)
    top = 0.0
    for layer in layers:
        top = max(top, layer.top)
    above = (top + 1.0) / direction[2]
    for i in range(n):
        t, k, normal = intersect_layers(layers, first + i, above * direction, -direction)
        on_stick = k >= 0 and t < above
        if on_stick:
            p = (above - t) * direction
            stick[i], height[i] = k, p[2]
            start = p, normal, albedo[k].copy()
        else:
            start = np.zeros(3), up, white
        into = radiance[i], bounce[i]
        _follow_path(layers, albedo, light, first + i, start, on_stick, randoms[i], into)
    return stick, height, radiance, bounce


@njit(cache=True)
def _follow_path(layers, albedo, light, number, start, may_touch, randoms, found):  # type: ignore[no-untyped-def]
    """Add light that reaches the eye by way of a point to the first of ``found``, (t, 3) each.

    start  the point, the outward normal there, and the albedo so far, (3,) each
    Where the path ``may_touch`` the ground it does so once, and what comes by way of it is added to
    the second instead.
    """
    p, normal, weight = start
    into, side = found[0], 1.0 if number % 2 else -1.0
    for turn in range(len(randoms) // 2):
        q = p + _OFFSET_M * normal
        # The sun, where no stick is before it, for every azimuth.
        for k in range(len(light.azimuth)):
            x, y, z = light.to_sun[k]
            to_sun = np.array((x, side * y, z))
            facing = (normal * to_sun).sum() / z
            if facing > 0 and intersect_layers(layers, number, q, to_sun)[1] < 0:
                into[k] += weight * light.sun * facing
        v = cosine_direction(normal, randoms[2 * turn], randoms[2 * turn + 1])
        t, k, met = intersect_layers(layers, number, q, v)
        ground = -q[2] / v[2] if v[2] < 0 else math.inf
        if k >= 0 and t < ground:
            p, normal = q + t * v, met
            weight = weight * albedo[k]
        elif ground < math.inf:
            if not may_touch:
                return
            may_touch, into = False, found[1]
            p, normal = q + ground * v, np.array((0.0, 0.0, 1.0))
        else:
            _add_sky(light, side, v, weight, into)
            return


@njit(cache=True)
def _add_sky(light, side, v, weight, into):  # type: ignore[no-untyped-def]
    rises, turns = light.sky.shape[:2]
    row = min(int(v[2] * rises), rises - 1)
    for turn in range(len(light.azimuth)):
        away = math.atan2(v[1], v[0]) - side * light.azimuth[turn]
        away = abs((away + math.pi) % (2 * math.pi) - math.pi) / math.pi
        into[turn] += weight * light.sky[row, min(int(away * turns), turns - 1)]


DEPRESSIONS_DEG = (3.0, 8.0, 20.0, 40.0, 65.0, 90.0)
AZIMUTHS_DEG = (0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0)
"""Directions that lines come from, as seen from the ground.

Depressions are angles of the eye above the horizon, azimuths are those of the eye from the sun's:
at 0 the sun is behind the viewer.
"""

LINES = 10_000  # lines of sight from each depression, each through a stand of its own
LEVELS = 33  # number of heights at which the share of outlines above is measured

SpeciesDensity = tuple[tuple[Prototype | RiggedPrototype, ...], float]
"""Equally likely prototypes, and their density [1/m²]."""


@dataclass(frozen=True, eq=False)
class StandAppearance(ArrayData):
    """Tables by species k, depression δ and azimuth φ, in units of the light on open level ground.

    area (k, δ)  mean outline of an object [m²]
    radiance (k, δ, φ, 3)  of what is met; ground_bounce: what light from the ground adds to
        it, over the ground's albedo
    ground (δ, φ, 3)  light on the ground where lines come down to it
    height (δ,)  at which lines first meet anything, the ground included, on average [m]
    levels, above (n,)  heights [m], and of all outlines the share that is above each
    """

    area: FloatArray
    radiance: FloatArray
    ground_bounce: FloatArray
    ground: FloatArray
    height: FloatArray
    levels: FloatArray
    above: FloatArray


Bare = list[list[tuple[StickTable, np.ndarray]]]
"""Sticks and tints of every prototype of every species."""


@lru_cache(maxsize=4)
def measure_stand(
    kinds: tuple[SpeciesDensity, ...],
    sun_elevation_deg: float,
    sky: Sky,
    max_depth: int = MAX_DEPTH,
    lines: int = LINES,
) -> StandAppearance:
    """Measure the appearance of a stand of these species under its sky and sun; it is kept.

    max_depth  longest path of light, in segments
    lines      lines of sight from each depression
    """
    bare = [[_above_ground(*full_detail_sticks(each)) for each in group] for group, _ in kinds]
    densities = [density for _, density in kinds]
    light = SunAndSky.at_azimuths(sun_elevation_deg, AZIMUTHS_DEG, sky)
    key = rounded_key(bare, densities, sun_elevation_deg, sky, max_depth, lines)
    return kept_data("stand", key, lambda: _measured(bare, densities, light, max_depth, lines))


def _measured(
    bare: Bare, densities: list[float], light: SunAndSky, max_depth: int, lines: int
) -> StandAppearance:
    layers, kind, colour = _layers(bare, densities)
    rng = np.random.Generator(np.random.Philox(0x57A4D))
    shape, species = (len(DEPRESSIONS_DEG), len(AZIMUTHS_DEG)), len(bare)
    sums, met = np.zeros((2, species, *shape, 3)), np.zeros((species, *shape[:1]))
    bare_seen, ground = np.zeros((1, *shape[:1])), np.zeros((1, *shape, 3))
    heights = np.zeros(shape[:1])
    for row, depression in enumerate(DEPRESSIONS_DEG):
        randoms = rng.random((lines, randoms_per_path(max_depth)))
        seen = trace_lines(layers, colour, light, depression, randoms, row * lines)
        heights[row] = seen.height.mean()
        hit, of_kind = seen.stick != GROUND, kind[seen.stick]
        bare_seen[0, row] = (~hit).sum()
        ground[0, row] = seen.radiance[~hit].sum(axis=0)
        for k in range(species):
            mine = hit & (of_kind == k)
            met[k, row] = mine.sum()
            sums[0, k, row], sums[1, k, row] = (
                each[mine].sum(axis=0) for each in (seen.radiance, seen.ground_bounce)
            )
    radiance, ground_bounce = (_means(each, met) for each in sums)
    lit = _means(ground, bare_seen)[0]
    return StandAppearance(
        _areas(bare), radiance, ground_bounce, lit, heights, *_above(bare, densities)
    )


def _layers(bare: Bare, densities: list[float]) -> tuple[tuple[StandField, ...], Ints, np.ndarray]:
    """The stand in layers, and species (k,) and albedo (k, 3) of every stick of its prototypes."""
    reach = np.array([max(stick_extent(table)[0] for table, _ in each) for each in bare])
    layers, kinds, colours = [], [], []
    for rows in stand_layers(reach, np.array(densities)):
        each = [(table, tints, int(k)) for k in rows for table, tints in bare[k]]
        share = [densities[k] / len(bare[k]) for _, _, k in each]
        layers.append(stand_field([table for table, _, _ in each], np.array(share)))
        kinds += [np.full(len(table), k) for table, _, k in each]
        colours += [tints[table.tint] for table, tints, _ in each]
    return tuple(layers), np.concatenate(kinds), np.concatenate(colours)


def full_detail_sticks(prototype: Prototype | RiggedPrototype) -> tuple[StickTable, np.ndarray]:
    """Return the sticks of a prototype in full detail as one part, and its tints (t, 3)."""
    one = prototype.posed() if isinstance(prototype, RiggedPrototype) else prototype
    leaves = one.leaf.only(one.hierarchy.part_count == 0)
    return StickTable.as_one_part([one.inner, leaves]), one.tints


def _above_ground(table: StickTable, tints: np.ndarray) -> tuple[StickTable, np.ndarray]:
    """Cut sticks off where they go into the ground; roots would count as cover."""
    table = table.take(np.maximum(table.start[:, 2], table.end[:, 2]) > 0)
    rise = table.end[:, 2] - table.start[:, 2]
    share = np.clip(-table.start[:, 2] / np.where(rise == 0, 1.0, rise), 0.0, None)[:, None]
    rooted = (table.start[:, 2] < 0)[:, None]
    start = np.where(rooted, table.start + share * (table.end - table.start), table.start)
    return replace(table, start=start), tints


def _above(bare: Bare, densities: list[float]) -> tuple[Reals, Reals]:
    """Heights up to the top of the stand [m], and the share of outlines above each, (LEVELS,) each.

    A stick counts where its middle is.
    """
    middles, outlines = [], []
    for prototypes, density in zip(bare, densities, strict=True):
        for table, _ in prototypes:
            middles.append((table.start[:, 2] + table.end[:, 2]) / 2)
            outlines.append(density / len(prototypes) * mean_outline_areas(table))
    middle = np.concatenate(middles)
    levels = np.linspace(0.0, max(float(middle.max()), 0.0), LEVELS)
    edges = np.append(levels, np.inf)
    outline, _ = np.histogram(middle, edges, weights=np.concatenate(outlines))
    return levels, outline[::-1].cumsum()[::-1] / outline.sum()


def _areas(bare: Bare) -> Float64[np.ndarray, "k d"]:
    """Mean outline of each species by depression, over prototypes and two azimuths, (k, d) [m²]."""
    turns = (20.0, 110.0)
    elevations, azimuths = (tuple(map(math.radians, each)) for each in (DEPRESSIONS_DEG, turns))
    directions = np.array(
        [
            (math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e))
            for e in elevations
            for a in azimuths
        ]
    )
    rows = []
    for prototypes in bare:
        each = [areas_of_parts(table, directions, 6.0)[0] for table, _ in prototypes]
        rows.append(np.mean(each, axis=0).reshape(len(DEPRESSIONS_DEG), -1).mean(axis=1))
    return np.array(rows)


def _means(
    sums: Float64[np.ndarray, "k d t 3"], met: Float64[np.ndarray, "k d"]
) -> Float64[np.ndarray, "k d t 3"]:
    """Means over the lines that met a species, shrunk to its overall mean where those are few."""
    few = 8.0
    everywhere = sums.sum(axis=1) / np.maximum(met.sum(axis=1), 1.0)[:, None, None]
    means: Float64[np.ndarray, "k d t 3"] = (sums + few * everywhere[:, None]) / (
        met[:, :, None, None] + few
    )
    return means
