"""Appearance of a stand of objects from afar, measured by tracing lines through it, and kept.

The stand has no end and holds every species at its density, in full detail
(``scenes.far_cover.stand_rays``). Lines come from above at a few depressions δ and angles φ from
the sun's azimuth, and light is followed back from where they first meet something
(``scenes.far_cover.stand_paths``). Outlines of whole objects are not sampled: they are measured
exactly (``scenes.sticks.areas``).
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float64

from lod.arrays import ArrayData, FloatArray, Ints, Reals
from lod.shapes import StickTable
from scenes.appearance.sky import Sky, SunAndSky
from scenes.far_cover.stand_paths import GROUND, MAX_DEPTH, randoms_per_path, trace_lines
from scenes.far_cover.stand_rays import StandField, stand_field, stand_layers, stick_extent
from scenes.processes.cache import content_key, kept_data
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.areas import areas_of_parts, mean_outline_areas
from scenes.sticks.prototype import Prototype

DEPRESSIONS_DEG = (3.0, 8.0, 20.0, 40.0, 65.0, 90.0)
AZIMUTHS_DEG = (0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0)
"""Directions that lines come from, as seen from the ground.

Depressions are angles of the eye above the horizon, azimuths are those of the eye from the sun's:
at 0 the sun is behind the viewer.
"""

LINES = 10_000
"""Lines of sight from each depression, each through a stand of its own."""

LEVELS = 33
"""Number of heights at which the share of outlines above is measured."""

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
    bare = [[full_detail_sticks(prototype) for prototype in prototypes] for prototypes, _ in kinds]
    densities = [density for _, density in kinds]
    light = SunAndSky.at_azimuths(sun_elevation_deg, AZIMUTHS_DEG, sky)
    key = content_key(bare, densities, sun_elevation_deg, sky, max_depth, lines)
    return kept_data("stand", key, lambda: _measured(bare, densities, light, max_depth, lines))


def _measured(
    bare: Bare, densities: list[float], light: SunAndSky, max_depth: int, lines: int
) -> StandAppearance:
    """Trace lines of sight from every depression, and take the means of what they meet."""
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


def unit_direction(elevation_deg: float, azimuth_deg: float) -> Reals:
    """Compute the unit vector of an elevation and an azimuth from the x axis, (3,)."""
    e, a = math.radians(elevation_deg), math.radians(azimuth_deg)
    return np.array((math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)))


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
    directions = np.array([unit_direction(e, a) for e in DEPRESSIONS_DEG for a in turns])
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
