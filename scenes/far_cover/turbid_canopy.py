"""Species of a field as a turbid medium: outlines by height, and their mean colour."""

from functools import lru_cache

import numpy as np
from jaxtyping import Float64

from lod.arrays import Reals
from lod.canopy import BARE, Canopy
from lod.shapes import StickTable
from scenes.far_cover.stand_appearance import SpeciesDensity, full_detail_sticks
from scenes.field.species_field import Species
from scenes.sticks.areas import areas_of_parts

STEPS = 6
"""Number of layers up to the top of what stands, thinner below, where eyes are."""

_SIDES = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


def turbid_canopy(species: tuple[Species, ...]) -> Canopy:
    """Return the canopy that these species are to the light in the air."""
    return _canopy(tuple((each.prototypes, each.density) for each in species))


@lru_cache(maxsize=4)
def _canopy(kinds: tuple[SpeciesDensity, ...]) -> Canopy:
    if not kinds:
        return BARE
    bare = [
        ([full_detail_sticks(each) for each in prototypes], density)
        for prototypes, density in kinds
    ]
    top = max(float(_tops(table).max()) for tables, _ in bare for table, _ in tables)
    height = top * np.linspace(0, 1, STEPS + 1) ** 2
    depth, sent, weight = np.zeros(STEPS), np.zeros(3), 0.0
    for tables, density in bare:
        for table, tints in tables:
            outline = density / len(tables) * outlines_between(table, height)
            depth += outline
            sent += outline.sum() * _mean_tint(table, tints)
            weight += outline.sum()
    return Canopy(height, depth, sent / weight)


def outlines_between(
    table: StickTable, height: Float64[np.ndarray, " n_plus_1"]
) -> Float64[np.ndarray, " n"]:
    """Measure the area that each layer of height adds to an object's side view, (n,) [m²].

    The layers add up to the whole outline. A stick counts where its middle is.
    """
    middle = (table.start[:, 2] + table.end[:, 2]) / 2
    parts = [table.take(middle < top) for top in height[1:-1]]
    below = [areas_of_parts(each, _SIDES)[0].mean() for each in (*parts, table)]
    return np.maximum(np.diff(below, prepend=0.0), 0.0)


def _tops(table: StickTable) -> Reals:
    return np.maximum(table.start[:, 2] + table.start_radius, table.end[:, 2] + table.end_radius)


def _mean_tint(table: StickTable, tints: np.ndarray) -> Float64[np.ndarray, " 3"]:
    """Mean colour of the sticks, weighted by the area of each regardless of what is before it."""
    radius = (table.start_radius + table.end_radius) / 2
    area = radius * (np.linalg.norm(table.end - table.start, axis=1) + radius)
    return (tints[table.tint] * area[:, None]).sum(axis=0) / area.sum()
