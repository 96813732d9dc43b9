"""What is shown of one object: sticks, and the triangles of parts that are meshes.

A part that owns parts has sticks of its own, which it shows as an inner node, or none; a part that
owns none has what it always looks like: sticks, or a mesh, which small balls stand for where parts
are gathered into fewer and larger ones.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float64

from lod.arrays import ArrayData, Flags, FloatArray, Ints, Points
from lod.shapes import MeshTable, StickTable
from scenes.sticks.by_view import with_area_share


@dataclass(frozen=True, eq=False)
class Shapes(ArrayData):
    """Sticks of one part, and f flat triangles after them, seen from both sides.

    corners (f, 3, 3)  of each triangle, in the frame of the sticks [m]
    colours (f, 3)     linear Rec.709 albedo of each
    """

    sticks: StickTable
    corners: FloatArray
    colours: FloatArray

    def __len__(self) -> int:
        return len(self.sticks) + len(self.corners)

    @staticmethod
    def of(sticks: StickTable, meshes: MeshTable | None = None) -> "Shapes":
        """Gather sticks, of whichever parts, and the triangles of meshes in the same frame."""
        one = StickTable.as_one_part([sticks])
        if meshes is None:
            return Shapes(one, np.zeros((0, 3, 3)), np.zeros((0, 3)))
        return Shapes(one, meshes.vertices[meshes.faces], meshes.face_colours)

    def with_sticks(self, *tables: StickTable) -> "Shapes":
        """Return the same with the sticks of these tables after its own."""
        table = StickTable.as_one_part([self.sticks, *tables])
        return Shapes(table, self.corners, self.colours)

    def merged(self, other: "Shapes") -> "Shapes":
        """Return these shapes and others together."""
        flat = np.concatenate((self.corners, other.corners))
        colours = np.concatenate((self.colours, other.colours))
        return Shapes(self.with_sticks(other.sticks).sticks, flat, colours)

    def albedos(self, palette: Float64[np.ndarray, "t 3"]) -> Points:
        """Return the albedo of every stick, from a palette, and of every triangle, (k + f, 3)."""
        return np.concatenate((palette[self.sticks.tint], self.colours))

    @cached_property
    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the lowest and the highest corner of the box about all of it, (3,) each [m]."""
        points, reach = self.spheres
        reach = reach[:, None]
        return (points - reach).min(axis=0), (points + reach).max(axis=0)

    @property
    def spheres(self) -> tuple[Points, np.ndarray]:
        """Return centres (n, 3) and radii (n,) of spheres whose hulls hold all of it [m]."""
        (centre, radius), flat = self.sticks.spheres, self.corners.reshape(-1, 3)
        return np.concatenate((centre, flat)), np.append(radius, np.zeros(len(flat)))


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
