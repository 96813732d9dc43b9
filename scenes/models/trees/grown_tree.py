"""A grown tree, and the sticks of its branches and leaves."""

from dataclasses import dataclass

import numpy as np

from lod.shapes import StickTable
from scenes.models.trees.growth import Branches, GrownFoliage
from scenes.models.trees.parameters import TreeSpecies


@dataclass(frozen=True, eq=False)
class GrownTree:
    """A grown tree with its colours.

    levels    branches of each level, from the trunk (0) to the twigs
    foliage   leaves of all twigs; foliage_tint (k,) row of the palette of each leaf
    palette   (t, 3) linear Rec.709 albedo; rows 0 and 1 are the bark of trunk and of branches, the
              last one that of young twigs
    """

    species: TreeSpecies
    levels: list[Branches]
    foliage: GrownFoliage
    foliage_tint: np.ndarray
    palette: np.ndarray

    def wood_tint(self, level: int) -> int:
        """Give the row of the palette of a level; twigs among leaves are half green."""
        young = 0 < level == len(self.levels) - 1 and len(self.foliage.twig) > 0
        return len(self.palette) - 1 if young else min(level, 1)

    def branch_sticks(self, level: int) -> StickTable:
        """Make the sticks of the branches of one level, each branch a part of its own."""
        nodes, radii = self.levels[level].nodes, self.levels[level].radii
        owner = np.repeat(np.arange(len(nodes)), nodes.shape[1] - 1)
        ends = nodes[:, :-1].reshape(-1, 3), nodes[:, 1:].reshape(-1, 3)
        radii_of_ends = radii[:, :-1].ravel(), radii[:, 1:].ravel()
        tint = np.full(len(owner), self.wood_tint(level))
        return StickTable.of(len(nodes), owner, *ends, *radii_of_ends, tint)

    def foliage_sticks(self) -> StickTable:
        """Make the sticks of the foliage, each leaf a part of its own."""
        foliage, n = self.foliage, len(self.foliage.twig)
        ends = foliage.start, foliage.end, foliage.start_radius, foliage.end_radius
        return StickTable.of(n, np.arange(n), *ends, self.foliage_tint)
