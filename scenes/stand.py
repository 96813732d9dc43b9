"""How a stand of objects looks from afar: measured once, by lines through a plot of it.

The plot repeats without end and holds every species in proportion to its density, turned at random,
in full detail. Lines come from above at a few depressions δ and angles φ from the sun's azimuth,
and light is followed back from where they first meet something (``stand_light``). Outlines of whole
objects are not sampled: they are measured exactly (``stick_area``).
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from jaxtyping import Float64

from lod.arrays import Reals, freeze
from scenes.prototype import Prototype
from scenes.rig_prototype import RiggedPrototype
from scenes.stand_light import DRAWS, GROUND, seen_along
from scenes.stick_area import mean_outline_areas
from scenes.stick_grid import grid_of
from scenes.stick_raster import areas_of_parts
from scenes.stick_table import StickTable

DEPRESSIONS_DEG = (3.0, 8.0, 20.0, 40.0, 65.0, 90.0)
TURNS_DEG = (0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0)
"""Where lines come from: angle of the eye above the ground's horizon, and of its azimuth as seen
from the ground from the sun's: at 0 the sun is behind the viewer."""

LINES = 1500
"""From each direction."""

OBJECTS = 96
"""In a plot, as near as whole numbers of every species allow."""

LEVELS = 33
"""Heights at which it is told how much is above."""

_ASKEW_DEG = 31.7
"""Of the sun's azimuth to the plot's sides, along which low lines would meet the same again."""

Kind = tuple[tuple[Prototype | RiggedPrototype, ...], float]
"""Equally likely prototypes, and their density [1/m²]."""


@dataclass(frozen=True, eq=False)
class Stand:
    """By kind k, depression δ and turn φ, in units of the light on unshadowed level ground.

    area (k, δ)  mean outline of an object [m²]
    sent (k, δ, φ, 3)  what is met sends; lifted: what it sends besides, of light from the ground
        over the ground's albedo
    ground (δ, φ, 3)  light on the ground where lines come down to it
    height (δ,)  at which lines first meet anything, the ground included, on average [m]
    levels, above (n,)  heights [m], and of all outlines the share that is above each
    """

    area: np.ndarray
    sent: np.ndarray
    lifted: np.ndarray
    ground: np.ndarray
    height: np.ndarray
    levels: np.ndarray
    above: np.ndarray

    def __post_init__(self) -> None:
        freeze(self, **dict.fromkeys(self.__dataclass_fields__, np.float64))


@lru_cache(maxsize=4)
def stand_of(
    kinds: tuple[Kind, ...], sun_elevation_deg: float, sky: tuple[float, float, float]
) -> Stand:
    """The looks of a stand of these kinds under a sun of that elevation; ``sky``: of the light on
    level ground, what comes from the sky."""
    bare = [[bare_of(prototype) for prototype in prototypes] for prototypes, _ in kinds]
    plot, kind, tint, side = _plot(bare, [density for _, density in kinds])
    grid, light = grid_of(plot, side), (toward(sun_elevation_deg, 0.0), np.array(sky))
    rng = np.random.Generator(np.random.Philox(0x57A4D))
    shape = len(DEPRESSIONS_DEG), len(TURNS_DEG)
    sums, met = np.zeros((2, len(kinds), *shape, 3)), np.zeros((len(kinds), *shape))
    bare_seen, ground = np.zeros(shape), np.zeros((1, *shape, 3))
    heights = np.zeros(shape)
    for row, column in np.ndindex(shape):
        direction = toward(DEPRESSIONS_DEG[row], TURNS_DEG[column])
        start = np.zeros((LINES, 3))
        start[:, :2] = rng.random((LINES, 2)) * side
        seen = seen_along(grid, tint, light, start, direction, rng.random((LINES, DRAWS)))
        heights[row, column] = seen.height.mean()
        hit = seen.stick != GROUND
        bare_seen[row, column] = (~hit).sum()
        ground[0, row, column] = seen.sent[~hit].sum(axis=0)
        of_kind = kind[seen.stick]
        for k in range(len(kinds)):
            mine = hit & (of_kind == k)
            met[k, row, column] = mine.sum()
            sums[:, k, row, column] = seen.sent[mine].sum(axis=0), seen.lifted[mine].sum(axis=0)
    lit = _means(ground[:, None], bare_seen[None])[0, 0]
    sent, lifted = _means(sums, met)
    return Stand(_areas(bare), sent, lifted, lit, heights.mean(axis=1), *_above(plot))


def bare_of(prototype: Prototype | RiggedPrototype) -> tuple[StickTable, np.ndarray]:
    """All that a prototype is made of at full detail, as one part at rest; and its tints."""
    one = prototype.posed() if isinstance(prototype, RiggedPrototype) else prototype
    ends = one.hierarchy.part_count == 0
    names = ("start", "end", "start_radius", "end_radius", "tint")
    rows = ends[one.leaf.owner]
    leaf = [getattr(one.leaf, name)[rows] for name in names]
    columns = [
        np.concatenate((getattr(one.inner, name), each))
        for name, each in zip(names, leaf, strict=True)
    ]
    return StickTable(np.array((0, len(columns[0]))), *columns), one.tints


def _plot(
    bare: list[list[tuple[StickTable, np.ndarray]]], densities: list[float]
) -> tuple[StickTable, np.ndarray, np.ndarray, float]:
    """The sticks of a plot, the kind and the albedo of each, and the plot's side [m]."""
    rng = np.random.Generator(np.random.Philox(0x9107))
    side = math.sqrt(OBJECTS / sum(densities))
    tables, kinds, tints = [], [], []
    for k, (prototypes, density) in enumerate(zip(bare, densities, strict=True)):
        for n in range(max(1, round(density * side * side))):
            table, palette = prototypes[n % len(prototypes)]
            tables.append(stood(table, rng.random(2) * side, 2 * np.pi * rng.random()))
            kinds.append(np.full(len(table), k))
            tints.append(palette[table.tint])
    names = ("start", "end", "start_radius", "end_radius", "tint")
    columns = [np.concatenate([getattr(table, name) for table in tables]) for name in names]
    plot = StickTable(np.array((0, len(columns[0]))), *columns)
    return plot, np.concatenate(kinds), np.concatenate(tints), side


def stood(table: StickTable, xy: Reals, turn: float) -> StickTable:
    """An object's sticks where it stands, turned by an angle [rad]."""
    cos, sin = math.cos(turn), math.sin(turn)
    spin = np.array(((cos, sin, 0), (-sin, cos, 0), (0, 0, 1)))
    offset = np.append(xy, 0.0)
    return replace(table, start=table.start @ spin + offset, end=table.end @ spin + offset)


def toward(elevation_deg: float, azimuth_deg: float) -> Reals:
    """Unit vector to where the eye or the sun stands in a plot, (3,)."""
    e, a = math.radians(elevation_deg), math.radians(azimuth_deg + _ASKEW_DEG)
    return np.array((math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)))


def _above(plot: StickTable) -> tuple[Reals, Reals]:
    """Heights up to the plot's top [m], and the share of its sticks' outlines above each; a stick
    is where its middle is."""
    middle = (plot.start[:, 2] + plot.end[:, 2]) / 2
    levels = np.linspace(0.0, max(float(middle.max()), 0.0), LEVELS)
    outlines, _ = np.histogram(middle, np.append(levels, np.inf), weights=mean_outline_areas(plot))
    return levels, outlines[::-1].cumsum()[::-1] / outlines.sum()


def _areas(bare: list[list[tuple[StickTable, np.ndarray]]]) -> Float64[np.ndarray, "k d"]:
    """Mean outline of each kind along each depression, over prototypes and two azimuths [m²]."""
    turns = (20.0, 110.0)
    directions = np.array([toward(e, a) for e in DEPRESSIONS_DEG for a in turns])
    rows = []
    for prototypes in bare:
        each = [areas_of_parts(table, directions, 6.0)[0] for table, _ in prototypes]
        rows.append(np.mean(each, axis=0).reshape(len(DEPRESSIONS_DEG), -1).mean(axis=1))
    return np.array(rows)


def _means(
    sums: Float64[np.ndarray, "q k d t 3"], met: Float64[np.ndarray, "k d t"]
) -> Float64[np.ndarray, "q k d t 3"]:
    """Means over what was met; where of a kind that is little, drawn to its mean of all."""
    few = 8.0
    everywhere = sums.sum(axis=(2, 3)) / np.maximum(met.sum(axis=(1, 2)), 1.0)[:, None]
    drawn = sums + few * everywhere[:, :, None, None]
    means: Float64[np.ndarray, "q k d t 3"] = drawn / (met + few)[..., None]
    return means
