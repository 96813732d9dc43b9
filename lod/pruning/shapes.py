"""The two batched shapes that a frame is made of: sticks and triangles."""

from dataclasses import dataclass, field

import numpy as np

from lod.arrays import freeze


@dataclass(frozen=True, eq=False)
class Sticks:
    """Round cones with round ends: limbs, branches, blobs.

    start, end              (n, 3) ends of the axis, in the frame's coordinates [m]
    start_radius, end_radius (n,) [m]
    tint    (n,)   row of ``tints``
    tints   (k, 3) linear Rec.709 albedo of each tint, 0 to 1
    owner   (n,)   row of the part that each stick belongs to
    """

    start: np.ndarray
    end: np.ndarray
    start_radius: np.ndarray
    end_radius: np.ndarray
    tint: np.ndarray
    tints: np.ndarray
    owner: np.ndarray

    def __post_init__(self) -> None:
        freeze(self, start=np.float64, end=np.float64, tints=np.float64)
        freeze(self, start_radius=np.float64, end_radius=np.float64)
        freeze(self, tint=np.int64, owner=np.int64)

    def __len__(self) -> int:
        return len(self.tint)


@dataclass(frozen=True, eq=False)
class Triangles:
    """A triangle mesh with its own normals and colours: terrain, leaves, flames.

    vertices (v, 3) corners [m]
    normals  (v, 3) unit normals
    colours  (v, 3) linear Rec.709 albedo, 0 to 1
    faces    (f, 3) rows of ``vertices``, counter-clockwise seen from outside
    owner    (f,)   row of the part that each face belongs to
    glow     (f,)   row of ``glows``; empty where nothing emits light
    glows    (k, 3) linear Rec.709 radiance outwards, at least 0, in units of the sky's
    """

    vertices: np.ndarray
    normals: np.ndarray
    colours: np.ndarray
    faces: np.ndarray
    owner: np.ndarray
    glow: np.ndarray = field(default_factory=lambda: np.zeros(0))
    glows: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))

    def __post_init__(self) -> None:
        freeze(self, vertices=np.float64, normals=np.float64, colours=np.float64)
        freeze(self, faces=np.int64, owner=np.int64, glow=np.int64, glows=np.float64)

    def __len__(self) -> int:
        return len(self.faces)
