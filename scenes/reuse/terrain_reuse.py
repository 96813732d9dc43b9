"""The ground's cut from that of the frame before: tiles that were examined keep their boxes, and
points that were drawn what is known of them (``terrain_known``).

Nearly all that pruning the ground takes is to bound its heights, tile by tile, and that depends on
the tile and on the frame's corner alone. So the walk itself is done anew in every frame, by the
same code, and only tiles that it has not met in the frame before are bounded: the same cut as from
scratch, to the last bit.
"""

from dataclasses import dataclass, field

import numpy as np

from lod.arrays import Ints, Points, Reals, freeze
from lod.camera import Corner
from lod.pruning.parts import BlendWeights, Parts, Triangles
from lod.pruning.pruner import Cut, prune_by_level
from lod.pruning.view import View
from scenes.terrain.point_cache import Shelf
from scenes.terrain.quadtree import Squares
from scenes.terrain.terrain import Terrain, TileGrid


@dataclass(frozen=True, eq=False)
class Boxes:
    """Boxes of the tiles that a frame examined.

    place  corner of the frame, and where its root tile (0, 0) begins: what they hold for
    names  (n,) of the tiles, ascending; low, high (n, 3) of their boxes [m]
    top    (n,) height that their ground rarely exceeds [m]
    shelf  what is known of the ground's points, once the frame is looked at
    """

    place: tuple[Corner, float, float]
    names: np.ndarray
    low: np.ndarray
    high: np.ndarray
    top: np.ndarray
    shelf: Shelf

    def __post_init__(self) -> None:
        freeze(self, names=np.int64, low=np.float64, high=np.float64, top=np.float64)


@dataclass(frozen=True, eq=False)
class Recalled:
    """The ground as a Representation that looks boxes up before it bounds a tile."""

    terrain: Terrain
    before: Boxes | None
    shelf: Shelf
    met: list[Boxes] = field(default_factory=list)

    @property
    def name(self) -> str:
        """The ground's."""
        return self.terrain.name

    def roots(self, view: View) -> Parts:
        """The root tiles."""
        return self.terrain.roots(view, self.boxes, self.shelf)

    def parts_of(self, parts: Parts, view: View) -> Parts:
        """The four quarters of each tile."""
        return self.terrain.parts_of(parts, view)

    def appearance(self, parts: Parts, look: BlendWeights) -> Triangles:
        """One mesh of all tiles."""
        return self.terrain.appearance(parts, look)

    def boxes(
        self, grid: TileGrid, tiles: Squares, lowest: Reals, highest: Reals
    ) -> tuple[Points, Points, Reals]:
        """``Terrain.boxes`` of tiles; those that the frame before examined are not bounded anew."""
        place, names = _place(grid), _names(tiles)
        (low, high), top = np.empty((2, len(names), 3)), np.empty(len(names))
        new = np.ones(len(names), bool)
        if self.before is not None and self.before.place == place:
            known = self.before
            row = np.minimum(np.searchsorted(known.names, names), len(known.names) - 1)
            new = known.names[row] != names
            row = row[~new]
            low[~new], high[~new], top[~new] = known.low[row], known.high[row], known.top[row]
        if new.any():
            level, x, y = (column[new] for column in tiles)
            found = self.terrain.boxes(grid, (level, x, y), lowest[new], highest[new])
            low[new], high[new], top[new] = found
        self.met.append(Boxes(place, names, low, high, top, self.shelf))
        return low, high, top

    def all_met(self) -> Boxes:
        """Of every tile that was asked for."""
        names = np.concatenate([each.names for each in self.met])
        order = np.argsort(names)
        columns = [
            np.concatenate([getattr(each, name) for each in self.met])[order]
            for name in ("low", "high", "top")
        ]
        low, high, top = columns
        return Boxes(self.met[0].place, names[order], low, high, top, self.shelf)


def ground_after(terrain: Terrain, view: View, before: Boxes | None) -> tuple[Cut, Boxes]:
    """What of the ground is displayed, as ``prune`` finds it; and boxes for the frame after it."""
    recalled = Recalled(terrain, before, before.shelf if before else Shelf())
    cut = prune_by_level(recalled, view)
    return cut, recalled.all_met()


def _place(grid: TileGrid) -> tuple[Corner, float, float]:
    return grid.view.camera.corner, grid.west, grid.south


def _names(tiles: Squares) -> Ints:
    level, x, y = tiles
    return (level << 58) | (x << 29) | y
