"""The two batched shapes that a frame is made of: sticks and triangles, and both together."""

from dataclasses import dataclass, field

import numpy as np

from lod.arrays import ArrayData, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Sticks(ArrayData):
    """Round cones with round ends: limbs, branches, blobs.

    start, end              (n, 3) ends of the axis, in the frame's coordinates [m]
    start_radius, end_radius (n,) [m]
    tint    (n,)   row of ``tints``
    tints   (k, 3) linear Rec.709 albedo of each tint, 0 to 1
    owner   (n,)   row of the part that each stick belongs to
    """

    start: FloatArray
    end: FloatArray
    start_radius: FloatArray
    end_radius: FloatArray
    tint: IntArray
    tints: FloatArray
    owner: IntArray

    def __len__(self) -> int:
        return len(self.tint)


@dataclass(frozen=True, eq=False)
class Triangles(ArrayData):
    """A triangle mesh with its own normals and colours: terrain, leaves, flames.

    vertices (v, 3) corners [m]
    normals  (v, 3) unit normals
    colours  (v, 3) linear Rec.709 albedo, 0 to 1
    faces    (f, 3) rows of ``vertices``, counter-clockwise seen from outside
    owner    (f,)   row of the part that each face belongs to
    glow     (f,)   row of ``glows``; empty where nothing emits light
    glows    (k, 3) linear Rec.709 radiance outwards, at least 0, in units of the sky's
    """

    vertices: FloatArray
    normals: FloatArray
    colours: FloatArray
    faces: IntArray
    owner: IntArray
    glow: IntArray = field(default_factory=lambda: np.zeros(0))
    glows: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))

    def __len__(self) -> int:
        return len(self.faces)


@dataclass(frozen=True, eq=False)
class SticksAndTriangles:
    """The appearance of parts of which some are sticks and some are meshes."""

    sticks: Sticks
    triangles: Triangles

    def __len__(self) -> int:
        return len(self.sticks) + len(self.triangles)


Appearance = Sticks | Triangles | SticksAndTriangles
"""What a representation gives for the displayed parts."""


def batches_of(shape: Appearance) -> tuple[Sticks | Triangles, ...]:
    """Return the one or two batched shapes of an appearance."""
    if isinstance(shape, SticksAndTriangles):
        return shape.sticks, shape.triangles
    return (shape,)
