"""The sticks of a part hierarchy, and which of them each part hides.

A part that owns parts has sticks of its own, which it shows as an inner node, or none; a part that
owns none has what it always looks like.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float64

from lod.arrays import Flags, Ints
from lod.stick_table import StickTable


@dataclass(frozen=True, eq=False)
class PartSticks:
    """Everything that an object of n parts is made of.

    parent (n,)  row of the part that owns each part, −1 for the whole object; wholes before parts
    level (n,)   level of detail, 0 for the whole object and more for the parts of a part
    own          sticks of each part alone
    palette (t, 3)  linear Rec.709 albedo of each tint
    """

    parent: Ints
    level: Ints
    own: StickTable
    palette: Float64[np.ndarray, "t 3"]

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

    def displayed_above(self, level: int) -> Flags:
        """Tell which sticks show whatever becomes of the parts that inner parts of a level own.

        They are those of parts above the level, and of those down to it that own nothing, (k,).
        """
        shown = (self.level < level) | ((self.level == level) & ~self.owns)
        return shown[self.own.owner]

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
