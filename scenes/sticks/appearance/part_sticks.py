"""The sticks of a part hierarchy, and which of them each part hides.

A part that owns parts has sticks of its own, which it shows as an inner node, or none; a part that
owns none has what it always looks like: sticks, or a mesh, which small balls stand for where parts
are gathered into fewer and larger ones.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float64

from lod.arrays import Flags, Ints
from lod.shapes import MeshTable, StickTable
from scenes.sticks.shapes import Shapes
from scenes.sticks.view_dependent_area import with_area_share


@dataclass(frozen=True, eq=False)
class PartSticks:
    """Everything that an object of n parts is made of.

    parent (n,)  row of the part that owns each part, −1 for the whole object; wholes before parts
    level (n,)   level of detail, 0 for the whole object and more for the parts of a part
    own          sticks of each part alone, and of a mesh the balls that stand for its surface
    palette (t, 3)  linear Rec.709 albedo of each tint
    meshes       of parts that own none, in the same frame; None where none has one
    chosen       leaf appearances of the parts that own parts, where they are chosen and only their
                 thickness and tint are fitted; None where all is
    """

    parent: Ints
    level: Ints
    own: StickTable
    palette: Float64[np.ndarray, "t 3"]
    meshes: MeshTable | None = None
    chosen: StickTable | None = None

    @cached_property
    def owns(self) -> Flags:
        """Tell whether each part owns parts, (n,)."""
        found = np.zeros(len(self.parent), np.bool_)
        found[self.parent[self.parent >= 0]] = True
        return found

    @property
    def finest(self) -> int:
        """Return the finest level of detail."""
        return int(self.level.max())

    def inner_rows(self, level: int) -> Ints:
        """Find the parts of a level that own parts, (m,)."""
        return np.flatnonzero((self.level == level) & self.owns)

    @cached_property
    def shows_sticks(self) -> Flags:
        """Tell which sticks of ``own`` are seen, for no mesh is in their place, (k,)."""
        if self.meshes is None:
            return np.ones(len(self.own), np.bool_)
        found: Flags = (self.meshes.count == 0)[self.own.owner]
        return found

    def shown(self, parts: Flags, share: float = 1.0) -> Shapes:
        """Return what the flagged parts (n,) themselves look like, with a share of their area."""
        sticks = self.own.take(parts[self.own.owner] & self.shows_sticks)
        sticks = sticks if share == 1.0 else with_area_share(sticks, share)
        meshes = None if self.meshes is None else self.meshes.only(parts).with_area_share(share)
        return Shapes.of(sticks, meshes)

    def above(self, level: int) -> Flags:
        """Tell which parts show whatever becomes of the parts that inner parts of a level own.

        They are those above the level, and those down to it that own nothing, (n,).
        """
        return (self.level < level) | ((self.level == level) & ~self.owns)

    def bearer(self, level: int) -> Ints:
        """Find which of ``inner_rows`` each stick is part of, itself or by its parts, (k,).

        It is −1 for sticks of none.
        """
        whole = np.arange(len(self.parent))
        for _ in range(self.finest - level):
            whole = np.where(self.level[whole] > level, self.parent[whole], whole)
        rows = self.inner_rows(level)
        number = np.full(len(self.parent), -1)
        number[rows] = np.arange(len(rows))
        found: Ints = number[whole[self.own.owner]]
        return found
