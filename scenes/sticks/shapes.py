"""What is shown of one object: sticks, and the triangles of parts that are meshes."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float64

from lod.arrays import ArrayData, FloatArray, Points
from lod.shapes import MeshTable, StickTable


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
        table, flat = self.sticks, self.corners.reshape(-1, 3)
        radii = table.start_radius, table.end_radius, np.zeros(len(flat))
        return np.concatenate((table.start, table.end, flat)), np.concatenate(radii)
