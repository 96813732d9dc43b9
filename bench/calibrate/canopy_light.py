"""The light that a stand of one species of tree sends, its trees displayed down to one level.

The trees are the prototypes that presets have. They stand on grass in the light of a sun 40° up and
its sky (``scenes.far_cover.stand_paths``). Paths of light and places of trees are the same whatever
the level, so that stands at two levels are compared path by path.
"""

from dataclasses import dataclass

import numpy as np

from lod.arrays import Flags
from lod.stick_table import StickTable
from scenes.far_cover.sky import sky_at
from scenes.far_cover.stand_paths import GROUND, MAX_DEPTH, SunAndSky, randoms_per_path, trace_lines
from scenes.far_cover.stand_rays import stand_field
from scenes.models.catalogue import PROTOTYPE_SEED
from scenes.models.trees.parameters import TreeSpecies
from scenes.models.trees.tree import tree_prototypes
from scenes.sticks.contrast import LUMINANCE
from scenes.sticks.prototype import Prototype
from scenes.sticks.view_dependent_area import with_area_share
from scenes.terrain.colour import GROUND_MATERIALS

SUN_DEG, TURBIDITY = 40.0, 3.0
"""Elevation of the sun and turbidity of the air."""

VIEW_ELEVATIONS_DEG = (4.0, 10.0, 18.0, 30.0, 50.0)
"""Elevations of the eye for a mean over all views."""

VIEW_AZIMUTHS_DEG = (22.5, 67.5, 112.5, 157.5)
"""Azimuths between eye and sun for a mean over all views: each is the middle of an eighth of the
circle. Right before the sun nothing shows its shade, but hardly an eye is there."""

TREES = {"tree": 4}
"""Different trees in a stand, where they are not FEWEST_TREES, as presets have them: trees of a
species differ, and few stand for all of them."""

FEWEST_TREES = 3

SPACING = 1.0
"""√ of the area that each tree has, over its height."""

LINES = 12000
"""Lines of sight from each elevation."""

_GROUND_ALBEDO = np.array((GROUND_MATERIALS["grassy"].moist, GROUND_MATERIALS["grassy"].dry)).mean(
    axis=0
)


_SEED = 0x1EAF


@dataclass(frozen=True, eq=False)
class OutgoingLight:
    """Luminance that a stand sends to each elevation and azimuth, (e, a).

    leaf_appearances  by the shapes that stand for hidden parts
    true_parts        by all that is displayed as itself
    """

    leaf_appearances: np.ndarray
    true_parts: np.ndarray

    @property
    def total(self) -> np.ndarray:
        """The luminance of both, (e, a)."""
        return self.leaf_appearances + self.true_parts


def calibration_trees(species: TreeSpecies, season: str) -> tuple[Prototype, ...]:
    """The prototypes that presets have of a species, their leaf appearances uncorrected."""
    count = TREES.get(species.name, FEWEST_TREES)
    return tree_prototypes(PROTOTYPE_SEED, count, species.uncorrected(), season)


def cut_at_level(tree: Prototype, species: TreeSpecies, level: int) -> tuple[StickTable, Flags]:
    """A tree displayed down to a level, as one part, and which of its sticks (k,) stand for hidden
    parts."""
    h, leaf, inner = tree.hierarchy, tree.leaf, tree.inner
    ends = (h.level == level) | ((h.level < level) & (h.part_count == 0))
    kept = np.array((*species.leaf_appearance.kept_segments, 0))[h.level[leaf.owner]]
    hides = (np.arange(len(leaf)) - leaf.first[leaf.owner] >= kept) & (h.part_count[leaf.owner] > 0)
    rows = [(h.level < level)[inner.owner] & ~ends[inner.owner], ends[leaf.owner]]
    names = ("start", "end", "start_radius", "end_radius", "tint")
    tables = (inner, leaf)
    columns = [
        np.concatenate([getattr(t, k)[r] for t, r in zip(tables, rows, strict=True)]) for k in names
    ]
    flags = np.concatenate((np.zeros(rows[0].sum(), bool), hides[rows[1]]))
    return StickTable(np.array((0, len(flags))), *columns), flags


def outgoing(
    trees: tuple[Prototype, ...],
    species: TreeSpecies,
    level: int,
    area_share: float = 1.0,
    elevations_deg: tuple[float, ...] = VIEW_ELEVATIONS_DEG,
    azimuths_deg: tuple[float, ...] = VIEW_AZIMUTHS_DEG,
    lines: int = LINES,
) -> OutgoingLight:
    """Light of a stand of these trees, every one displayed down to a level.

    area_share  of the shapes that stand for hidden parts; lines: of sight from each elevation
    """
    rng = np.random.Generator(np.random.Philox(_SEED))
    tables, colours, flags = [], [], []
    for tree in trees:
        table, hides = cut_at_level(tree, species, level)
        if area_share != 1:
            table = with_area_share(table, np.where(hides, area_share, 1.0))
        tables.append(table)
        colours.append(tree.tints[table.tint])
        flags.append(hides)
    side = species.scale * SPACING
    stand = stand_field(tables, np.full(len(trees), 1 / (len(trees) * side**2)), side)
    light = SunAndSky.at_azimuths(SUN_DEG, azimuths_deg, sky_at(SUN_DEG, TURBIDITY))
    colour, hides = np.concatenate(colours), np.concatenate(flags)
    luminance = np.zeros((2, len(elevations_deg), len(azimuths_deg)))
    for row, elevation in enumerate(elevations_deg):
        randoms = rng.random((lines, randoms_per_path(MAX_DEPTH)))
        seen = trace_lines(stand, colour, light, elevation, randoms, row * lines)
        met = seen.stick != GROUND
        shapes = met & hides[seen.stick]
        of_line = seen.radiance @ LUMINANCE + seen.ground_bounce @ (_GROUND_ALBEDO * LUMINANCE)
        luminance[:, row] = of_line[shapes].sum(axis=0), of_line[met & ~shapes].sum(axis=0)
    return OutgoingLight(*luminance)
