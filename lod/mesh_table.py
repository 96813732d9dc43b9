"""The triangle meshes of every part of an object as one table, part after part."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from lod.arrays import ArrayData, FloatArray, IntArray, check_columns
from lod.errors import InputError

_PER_VERTEX = ("vertices", "normals", "colours")


@dataclass(frozen=True, eq=False)
class MeshTable(ArrayData):
    """The meshes of n parts, part after part; a part may have none.

    first_vertex (n + 1,)  vertices of part i are rows first_vertex[i]:first_vertex[i + 1]
    first_face (n + 1,)    its faces are rows first_face[i]:first_face[i + 1]
    vertices (v, 3)        corners, in whichever frame the holder of the table says [m]
    normals (v, 3)         unit normals
    colours (v, 3)         linear Rec.709 albedo, 0 to 1
    faces (f, 3)           rows of ``vertices``, counter-clockwise seen from outside

    Raises InputError for columns of other shapes, numbers that are not finite, corners that are not
    of the face's own part, and albedo outside 0 to 1.
    """

    first_vertex: IntArray
    first_face: IntArray
    vertices: FloatArray
    normals: FloatArray
    colours: FloatArray
    faces: IntArray

    def __post_init__(self) -> None:
        super().__post_init__()
        _check(self)

    def __len__(self) -> int:
        return len(self.faces)

    @property
    def count(self) -> np.ndarray:
        """Number of triangles of each part, (n,)."""
        return np.diff(self.first_face)

    @property
    def owner(self) -> np.ndarray:
        """Return the part that each triangle belongs to, (f,)."""
        return np.repeat(np.arange(len(self.count)), self.count)

    @property
    def vertex_owner(self) -> np.ndarray:
        """Return the part that each vertex belongs to, (v,)."""
        return np.repeat(np.arange(len(self.count)), np.diff(self.first_vertex))

    @property
    def face_colours(self) -> np.ndarray:
        """Compute the mean albedo of each triangle over its corners, (f, 3)."""
        colours: np.ndarray = self.colours[self.faces].mean(axis=1)
        return colours

    @property
    def surface(self) -> tuple[np.ndarray, ...]:
        """Return what decides how the triangles look from afar: corners, faces and colours."""
        return self.vertices, self.faces, self.colours

    def only(self, parts: np.ndarray) -> "MeshTable":
        """Return the table with the meshes of the flagged parts (n,) alone."""
        vertex, face = parts[self.vertex_owner], parts[self.owner]
        row = np.cumsum(vertex) - 1
        return MeshTable(
            np.concatenate(([0], np.cumsum(np.diff(self.first_vertex) * parts))),
            np.concatenate(([0], np.cumsum(self.count * parts))),
            **{key: getattr(self, key)[vertex] for key in _PER_VERTEX},
            faces=row[self.faces[face]],
        )

    def with_area_share(self, share: float) -> "MeshTable":
        """Shrink the mesh of each part to a share of its area, about the middle of its corners."""
        if share == 1.0:
            return self
        owner, count = self.vertex_owner, np.maximum(np.diff(self.first_vertex), 1)
        sums = [np.bincount(owner, x, len(count)) / count for x in self.vertices.T]
        middle = np.stack(sums, axis=1)[owner]
        shrunk = middle + np.sqrt(share) * (self.vertices - middle)
        return replace(self, vertices=shrunk)

    @staticmethod
    def of(meshes: Sequence["Mesh | None"]) -> "MeshTable":
        """Lay the meshes of parts end to end; None is a part without a mesh."""
        own = [each for each in meshes if each is not None]
        vertices = [0 if each is None else len(each.vertices) for each in meshes]
        faces = [0 if each is None else len(each.faces) for each in meshes]
        first_vertex = np.concatenate(([0], np.cumsum(vertices, dtype=np.int64)))
        start = first_vertex[:-1][[each is not None for each in meshes]]
        none = np.zeros((0, 3))
        columns = {
            key: np.concatenate([none, *(getattr(each, key) for each in own)])
            for key in _PER_VERTEX
        }
        rows = [each.faces + row for each, row in zip(own, start.tolist(), strict=True)]
        return MeshTable(
            first_vertex,
            np.concatenate(([0], np.cumsum(faces, dtype=np.int64))),
            **columns,
            faces=np.concatenate([none.astype(np.int64), *rows]),
        )

    @staticmethod
    def concatenate(tables: Sequence["MeshTable"]) -> "MeshTable":
        """Lay tables end to end: the parts of one follow those of the one before."""
        vertices = np.cumsum([0] + [len(each.vertices) for each in tables]).tolist()
        faces = np.cumsum([0] + [len(each) for each in tables]).tolist()
        starts = [
            each.first_vertex[:-1] + row for each, row in zip(tables, vertices[:-1], strict=True)
        ]
        firsts = [each.first_face[:-1] + row for each, row in zip(tables, faces[:-1], strict=True)]
        rows = [each.faces + row for each, row in zip(tables, vertices[:-1], strict=True)]
        return MeshTable(
            np.append(np.concatenate(starts), vertices[-1]),
            np.append(np.concatenate(firsts), faces[-1]),
            **{key: np.concatenate([getattr(each, key) for each in tables]) for key in _PER_VERTEX},
            faces=np.concatenate(rows),
        )

    def scaled(self, factor: float) -> "MeshTable":
        """Return the table with every length multiplied by ``factor``."""
        return replace(self, vertices=self.vertices * factor)


@dataclass(frozen=True, eq=False)
class Mesh(ArrayData):
    """The triangle mesh of one part, as in MeshTable: vertices, normals, colours (v, 3); faces."""

    vertices: FloatArray
    normals: FloatArray
    colours: FloatArray
    faces: IntArray


def triangle_areas(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Compute the area of each triangle, (f,) [m²]."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    areas: np.ndarray = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    return areas


def _check(table: MeshTable) -> None:
    v, f = len(table.vertices), len(table.faces)
    points = dict.fromkeys(_PER_VERTEX, (v, 3))
    check_columns("meshes", table, faces=(f, 3), **points)
    for name, size in (("first_vertex", v), ("first_face", f)):
        first = getattr(table, name)
        rises = first.ndim == 1 and len(first) and first[0] == 0 and np.all(np.diff(first) >= 0)
        if not rises or first[-1] != size or len(first) != len(table.first_vertex):
            raise InputError(f"meshes.{name}", first, f"rises from 0 to {size}, part by part")
    low, high = (table.first_vertex[k : len(table.count) + k][table.owner] for k in (0, 1))
    if f and (np.any(table.faces < low[:, None]) or np.any(table.faces >= high[:, None])):
        raise InputError("meshes.faces", "a corner of another part", "rows of its own vertices")
    if v and not (table.colours.min() >= 0 and table.colours.max() <= 1):
        raise InputError("meshes.colours", "an albedo outside 0 to 1", "linear Rec.709, 0 to 1")
