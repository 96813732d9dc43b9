"""A grown tree, and its sticks: those of its branches and leaves, and all that a branch bears."""

from dataclasses import dataclass

import numpy as np

from lod.arrays import Ints
from lod.stick_table import StickTable
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

    def ancestor(self, level: int, depth: int) -> Ints:
        """Find the branch of level ``depth`` that each branch of a level has grown from, (n,)."""
        rows = np.arange(len(self.levels[level]))
        for k in range(level, depth, -1):
            rows = self.levels[k].parent[rows]
        return rows

    def wood_tint(self, level: int) -> int:
        """Give the row of the palette of a level; twigs among leaves are half green."""
        young = 0 < level == len(self.levels) - 1 and len(self.foliage.twig) > 0
        return len(self.palette) - 1 if young else min(level, 1)

    def branch_sticks(self, level: int, keep: int | None = None) -> StickTable:
        """Make the sticks of the branches of one level, each branch a part of its own.

        They are all sticks, or ``keep`` of each branch: of the trunk those below the crown.
        """
        branches = self.levels[level]
        segments = branches.nodes.shape[1] - 1
        keep = segments if keep is None else min(keep, segments)
        clear = self.species.leaf_appearance.clear_trunk_segments
        reach = segments if level or keep == segments else clear
        stops = np.rint(np.linspace(0, reach, keep + 1)).astype(np.int64)
        nodes, radii = branches.nodes[:, stops], branches.radii[:, stops]
        owner = np.repeat(np.arange(len(branches)), keep)
        ends = nodes[:, :-1].reshape(-1, 3), nodes[:, 1:].reshape(-1, 3)
        radii_of_ends = radii[:, :-1].ravel(), radii[:, 1:].ravel()
        tint = np.full(len(owner), self.wood_tint(level))
        return StickTable.of(len(branches), owner, *ends, *radii_of_ends, tint)

    def foliage_sticks(self) -> StickTable:
        """Make the sticks of the foliage, each leaf a part of its own."""
        foliage, n = self.foliage, len(self.foliage.twig)
        ends = foliage.start, foliage.end, foliage.start_radius, foliage.end_radius
        return StickTable.of(n, np.arange(n), *ends, self.foliage_tint)

    def borne_sticks(self, depth: int, own: bool = True) -> StickTable:
        """Collect all sticks that each branch of one depth bears.

        They are those of the branches that grow from it, of their foliage, and its own if ``own``.
        """
        n, twigs = len(self.levels[depth]), len(self.levels) - 1
        tables = []
        for level in range(depth if own else depth + 1, twigs + 1):
            sticks = self.branch_sticks(level)
            tables.append(sticks.with_owner(n, self.ancestor(level, depth)[sticks.owner]))
        owner = self.ancestor(twigs, depth)[self.foliage.twig]
        return StickTable.merge([*tables, self.foliage_sticks().with_owner(n, owner)])
