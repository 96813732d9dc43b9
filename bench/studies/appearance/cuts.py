"""One tree displayed down to one level of detail, as it looks from one direction.

The trees are of the kinds in ``kinds`` beside this file, to which nothing was ever fitted, and of
the project's own species; those of two seeds that no preset uses stand beside the presets' own.
"""

import math
from dataclasses import dataclass, replace
from importlib import resources

import numpy as np

from bench.fields.scene import FLAT
from lod.arrays import Reals
from lod.camera import Corner, camera_from_heading
from lod.metric.family import METRICS
from lod.pruning.parts import BlendWeights
from lod.pruning.pruner import Cut, prune
from lod.pruning.shapes import Sticks
from lod.pruning.view import View
from lod.stick_table import StickTable
from scenes.field.placed_object import Placed
from scenes.model_files.names import tree_species_names
from scenes.models.catalogue import PROTOTYPE_SEED
from scenes.models.trees.parameters import TreeSpecies
from scenes.models.trees.species_files import read_species, tree_species
from scenes.models.trees.tree import tree_prototypes
from scenes.sticks.appearance.tone import Illumination

UNSEEN = ("poplar", "acacia", "pine")
"""Kinds whose parameters were frozen before the fit that they judge."""

UNSEEN_SEEDS = (71, 72)
"""Seeds that no preset uses."""


@dataclass(frozen=True)
class Case:
    """One tree: a kind's name and the seed that it grew from."""

    kind: str
    seed: int


def cases() -> list[Case]:
    """Return the trees that are judged: of unseen kinds, of unseen seeds, and of presets."""
    own = tree_species_names()
    found = [Case(kind, UNSEEN_SEEDS[0]) for kind in UNSEEN]
    found += [Case(kind, seed) for seed in UNSEEN_SEEDS for kind in own]
    return found + [Case(kind, PROTOTYPE_SEED) for kind in own]


def species_of(kind: str) -> TreeSpecies:
    """Return the species of a kind of this study, or of the project's own of that name."""
    if kind not in UNSEEN:
        return tree_species(kind)
    folder = resources.files("bench.studies.appearance") / "kinds"
    return read_species(folder / f"{kind}.toml")


@dataclass(frozen=True, eq=False)
class LoneTree:
    """A tree alone on level ground, with all of its parts.

    placed  the object; every: the cut that displays all of it
    """

    placed: Placed
    every: Cut

    @property
    def finest(self) -> int:
        """Return the finest level of detail."""
        return int(self.every.level.max())

    @property
    def reach(self) -> float:
        """Return the radius about its foot that holds all of it [m]."""
        return float(self.placed.prototypes.part_tables.bound[0])

    def sticks(
        self,
        level: int,
        sin_elevation: float,
        cos_azimuth: float = math.nan,
        light: Illumination | None = None,
    ) -> Sticks:
        """Return what is displayed while parts down to a level are, seen from one direction.

        cos_azimuth  of the angle between the lines to the eye and to the sun on the map
        light        that it is displayed in; None: shapes have their own albedo
        """
        parts = self.every.parts
        n, owns = len(parts), np.zeros(len(parts), np.bool_)
        owns[parts.parent[parts.parent >= 0]] = True
        inner = (parts.level < level) & owns
        leaf = (parts.level == level) | ((parts.level < level) & ~owns)
        weights = BlendWeights(
            inner.astype(np.float64),
            leaf.astype(np.float64),
            np.full(n, sin_elevation),
            np.full(n, cos_azimuth),
        )
        return self.placed.prototypes.sticks(parts, weights, light)


def lone_tree(case: Case) -> LoneTree:
    """Grow the tree of a case in summer, and display all of it."""
    (prototype,) = tree_prototypes(case.seed, 1, species_of(case.kind))
    placed = Placed(case.kind, prototype, 0.0, 0.0, 90.0, FLAT)
    away = np.array((0.0, -30.0, 2.0))
    camera = camera_from_heading(Corner(0, 0), away, 0.0, 0.0, 60.0, (64, 64))
    view = View(camera, METRICS["full"], look_around=True)
    return LoneTree(placed, prune(placed, replace(view, fade=0.0)))


def as_one_part(sticks: Sticks) -> StickTable:
    """Return sticks as the table of a single part."""
    columns = sticks.start, sticks.end, sticks.start_radius, sticks.end_radius, sticks.tint
    return StickTable(np.array((0, len(sticks))), *columns)


def unit(azimuth_deg: Reals | float, elevation_deg: Reals | float) -> np.ndarray:
    """Compute unit vectors of azimuths from the x axis and of elevations, (…, 3)."""
    a, e = np.radians(azimuth_deg), np.radians(elevation_deg)
    a, e = np.broadcast_arrays(a, e)
    return np.stack((np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)), axis=-1)
