"""What parts look like: sticks and triangle meshes, as tables part by part and as batched shapes.

Sticks are round cones with round ends. A table holds the shapes of every part of an object, part
after part; a frame is made of the two batched shapes, sticks and triangles, and both together.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import TypeVar

import numpy as np

from lod.arrays import (
    ArrayData,
    Flags,
    FloatArray,
    IntArray,
    Points,
    Reals,
    SingleArray,
    check_columns,
)
from lod.errors import InputError

Table = TypeVar("Table", bound="StickTable")


@dataclass(frozen=True, eq=False)
class StickTable(ArrayData):
    """The sticks of n parts, part after part: each is the convex hull of two spheres.

    Whatever holds the table says in which frame it is. Prototypes have their origin where the
    object stands on the ground, z up, x the way it faces, y to its left; the compiled tables of an
    actor have the own frame of each part.

    first (n + 1,)  the sticks of part i are rows first[i]:first[i + 1]; there may be none
    start, end (k, 3) centres of the two spheres [m]
    start_radius, end_radius (k,) above 0 [m]
    tint (k,)  row of the object's tints

    Raises InputError for columns of other shapes, a radius that is not above 0, or a number that
    is not finite.
    """

    first: IntArray
    start: FloatArray
    end: FloatArray
    start_radius: FloatArray
    end_radius: FloatArray
    tint: IntArray

    def __post_init__(self) -> None:
        super().__post_init__()
        k, first = len(self.tint), self.first
        points, reals = dict.fromkeys(("start", "end"), (k, 3)), ("start_radius", "end_radius")
        check_columns("sticks", self, **points, **dict.fromkeys(reals, (k,)))
        rises = first.ndim == 1 and len(first) and first[0] == 0 and np.all(np.diff(first) >= 0)
        if not rises or first[-1] != k:
            raise InputError("sticks.first", first, f"rises from 0 to the number of sticks, {k}")
        for name in reals:
            if k and getattr(self, name).min() <= 0:
                raise InputError(f"sticks.{name}", float(getattr(self, name).min()), "above 0 m")
        if k and self.tint.min() < 0:
            raise InputError("sticks.tint", int(self.tint.min()), "a row of the tints, at least 0")

    def __len__(self) -> int:
        return len(self.tint)

    @property
    def count(self) -> np.ndarray:
        """Number of sticks of each part, (n,)."""
        return np.diff(self.first)

    @property
    def owner(self) -> np.ndarray:
        """Return the part that each stick belongs to, (k,)."""
        return np.repeat(np.arange(len(self.first) - 1), self.count)

    @property
    def spheres(self) -> tuple[Points, Reals]:
        """Return centres (2 k, 3) and radii (2 k,) of the spheres at all starts, then at all ends.

        The farthest point of a stick from anywhere is on one of its two.
        """
        radii = np.concatenate((self.start_radius, self.end_radius))
        return np.concatenate((self.start, self.end)), radii

    @property
    def columns(self) -> tuple[np.ndarray, ...]:
        """Return all columns but ``first``, (k, …) each, as ``of`` takes them."""
        return tuple(getattr(self, each.name) for each in fields(self)[1:])

    @classmethod
    def of(cls: type[Table], parts: int, owner: np.ndarray, *columns: np.ndarray) -> Table:
        """Build the table of ``parts`` parts from sticks in any order and their owners, (k,)."""
        owner = np.asarray(owner, np.int64)
        if len(owner) and not (owner.min() >= 0 and owner.max() < parts):
            raise InputError("sticks.owner", int(owner.max()), f"a part, 0 to {parts - 1}")
        order = np.argsort(owner, kind="stable")
        first = np.concatenate(([0], np.cumsum(np.bincount(owner, minlength=parts))))
        return cls(first, *(np.asarray(column)[order] for column in columns))

    @classmethod
    def merge(cls: type[Table], tables: Sequence[Table]) -> Table:
        """Build the table of parts whose sticks stand in several tables of the same parts."""
        owner = np.concatenate([table.owner for table in tables])
        columns = zip(*(table.columns for table in tables), strict=True)
        return cls.of(len(tables[0].count), owner, *map(np.concatenate, columns))

    @staticmethod
    def as_one_part(tables: Sequence["StickTable"]) -> "StickTable":
        """Build the table of a single part that has all the sticks of several tables."""
        return StickTable.merge([t.with_owner(1, np.zeros(len(t), np.int64)) for t in tables])

    def with_owner(self: Table, parts: int, owner: np.ndarray) -> Table:
        """Return the table of ``parts`` parts with these sticks, each with its owner, (k,)."""
        return self.of(parts, owner, *self.columns)

    def take(self: Table, rows: np.ndarray) -> Table:
        """Return the table of the same parts with the sticks at ``rows`` (indices or flags)."""
        columns = (column[rows] for column in self.columns)
        return self.of(len(self.count), self.owner[rows], *columns)

    def only(self: Table, parts: Flags) -> Table:
        """Return the table with the sticks of the flagged parts (n,) alone."""
        return self.take(parts[self.owner])

    def of_parts(self: Table, parts: Flags) -> Table:
        """Return the table of the flagged parts (n,) alone, renumbered in their order."""
        first = np.concatenate(([0], np.cumsum(self.count[parts])))
        return type(self)(first, *(column[parts[self.owner]] for column in self.columns))

    def thickened(self: Table, factor: Reals) -> Table:
        """Return the table with both radii of each stick multiplied by its factor, (k,)."""
        thicker = {k: getattr(self, k) * factor for k in ("start_radius", "end_radius")}
        return replace(self, **thicker)

    def scaled(self: Table, factor: float) -> Table:
        """Return the table with every length multiplied by ``factor``."""
        names = ("start", "end", "start_radius", "end_radius")
        return replace(self, **{name: getattr(self, name) * factor for name in names})


_PER_VERTEX = ("vertices", "spine", "normals", "colours")


@dataclass(frozen=True, eq=False)
class MeshTable(ArrayData):
    """The meshes of n parts, part after part; a part may have none.

    first_vertex (n + 1,)  vertices of part i are rows first_vertex[i]:first_vertex[i + 1]
    first_face (n + 1,)    its faces are rows first_face[i]:first_face[i + 1]
    vertices (v, 3)        corners, in whichever frame the holder of the table says [m]
    spine (v, 3)           where each corner is once the mesh has shrunk to no area, on a line along
                           which it keeps its length, or all in one point [m]
    normals (v, 3)         unit normals
    colours (v, 3)         linear Rec.709 albedo, 0 to 1
    faces (f, 3)           rows of ``vertices``, counter-clockwise seen from outside

    Raises InputError for columns of other shapes, numbers that are not finite, corners that are not
    of the face's own part, and albedo outside 0 to 1.
    """

    first_vertex: IntArray
    first_face: IntArray
    vertices: FloatArray
    spine: FloatArray
    normals: FloatArray
    colours: FloatArray
    faces: IntArray

    def __post_init__(self) -> None:
        super().__post_init__()
        v, f = len(self.vertices), len(self.faces)
        check_columns("meshes", self, faces=(f, 3), **dict.fromkeys(_PER_VERTEX, (v, 3)))
        for name, size in (("first_vertex", v), ("first_face", f)):
            first = getattr(self, name)
            rises = first.ndim == 1 and len(first) and first[0] == 0 and np.all(np.diff(first) >= 0)
            if not rises or first[-1] != size or len(first) != len(self.first_vertex):
                raise InputError(f"meshes.{name}", first, f"rises from 0 to {size}, part by part")
        low, high = (self.first_vertex[k : len(self.count) + k][self.owner] for k in (0, 1))
        if f and (np.any(self.faces < low[:, None]) or np.any(self.faces >= high[:, None])):
            raise InputError("meshes.faces", "a corner of another part", "rows of its own vertices")
        if v and not (self.colours.min() >= 0 and self.colours.max() <= 1):
            raise InputError("meshes.colours", "an albedo outside 0 to 1", "linear Rec.709, 0 to 1")

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

    @cached_property
    def plain_width(self) -> np.ndarray:
        """Compute how much wider than its mesh a triangle of each part's first two corners and its
        last has to be, to have the same area above the ground, where z is above 0, (n,); 1 where it
        has none."""
        first, last = self.first_vertex[:-1], self.first_vertex[1:]
        found, some = np.ones(len(first)), last > first
        corners = np.stack((first, first + 1, last - 1), axis=1)[some]
        area = np.bincount(self.owner, _areas_above(self.vertices, self.faces), len(first))
        plain = _areas_above(self.vertices, corners)
        found[some] = np.divide(area[some], plain, np.ones(len(plain)), where=plain > 0)
        return found

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
        """Shrink the mesh of each part toward its spine, to a share of its area."""
        width = np.where(self.shrinks_to_point, np.sqrt(share), share)[self.vertex_owner, None]
        return replace(self, vertices=self.spine + width * (self.vertices - self.spine))

    @cached_property
    def shrinks_to_point(self) -> np.ndarray:
        """Tell of which parts the spine is one point, (n,)."""
        first = np.minimum(self.first_vertex[:-1], max(len(self.spine) - 1, 0))[self.vertex_owner]
        apart = np.abs(self.spine - self.spine[first]).max(axis=1, initial=0.0)
        found = np.ones(len(self.count), np.bool_)
        found[self.vertex_owner[apart > 1e-9]] = False
        return found

    @staticmethod
    def of(meshes: Sequence["Mesh | MeshTable | None"]) -> "MeshTable":
        """Lay the meshes of parts end to end; None is a part without a mesh."""
        own, none = [each for each in meshes if each is not None], np.zeros((0, 3))
        vertices = [0 if each is None else len(each.vertices) for each in meshes]
        faces = [0 if each is None else len(each.faces) for each in meshes]
        first_vertex, first_face = (np.cumsum([0, *each]) for each in (vertices, faces))
        starts = first_vertex[:-1][[each is not None for each in meshes]]
        moved = [each.faces + row for each, row in zip(own, starts.tolist(), strict=True)]
        return MeshTable(
            first_vertex,
            first_face,
            **{k: np.concatenate([none, *(getattr(p, k) for p in own)]) for k in _PER_VERTEX},
            faces=np.concatenate([none.astype(np.int64), *moved]),
        )

    @staticmethod
    def concatenate(tables: Sequence["MeshTable"]) -> "MeshTable":
        """Lay tables end to end: the parts of one follow those of the one before."""
        first = {
            key: np.cumsum([0, *np.concatenate([np.diff(getattr(t, key)) for t in tables])])
            for key in ("first_vertex", "first_face")
        }
        return replace(MeshTable.of(tables), **first)

    def scaled(self, factor: float) -> "MeshTable":
        """Return the table with every length multiplied by ``factor``."""
        return replace(self, vertices=self.vertices * factor, spine=self.spine * factor)


@dataclass(frozen=True, eq=False)
class Mesh(ArrayData):
    """The mesh of one part, as in MeshTable: vertices, normals, colours (v, 3); faces; and spine
    (v, 3), by default the middle of its corners."""

    vertices: FloatArray
    normals: FloatArray
    colours: FloatArray
    faces: IntArray
    spine: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))

    def __post_init__(self) -> None:
        if not len(self.spine):
            middle = np.mean(self.vertices, axis=0)
            object.__setattr__(self, "spine", np.tile(middle, (len(self.vertices), 1)))
        super().__post_init__()


def middles(first_vertex: np.ndarray, vertices: np.ndarray) -> np.ndarray:
    """Compute the middle of the corners of each part of a MeshTable, once for every corner, (v, 3).

    Raises ValueError for columns that do not fit each other.
    """
    count = np.diff(first_vertex)
    owner = np.repeat(np.arange(len(count)), count)
    sums = [np.bincount(owner, each, len(count)) for each in vertices.T]
    return (np.stack(sums, axis=1) / np.maximum(count, 1)[:, None])[owner]


def triangle_areas(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Compute the area of each triangle, (f,) [m²]."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    areas: np.ndarray = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    return areas


def _areas_above(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Compute the area of each triangle whose z is above 0, by 64 even points of it, (f,) [m²]."""
    u, v = (np.indices((8, 8)).reshape(2, -1) + 0.5) / 8
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    z = vertices[faces, 2] @ np.stack((1 - u - v, u, v))
    above: np.ndarray = triangle_areas(vertices, faces) * (z > 0).mean(axis=1)
    return above


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
    normals  (v, 3) float32 unit normals
    colours  (v, 3) float32 linear Rec.709 albedo, 0 to 1
    faces    (f, 3) rows of ``vertices``, counter-clockwise seen from outside
    owner    (f,)   row of the part that each face belongs to
    glow     (f,)   row of ``glows``; empty where nothing emits light
    glows    (k, 3) linear Rec.709 radiance outwards, at least 0, in units of the sky's
    """

    vertices: FloatArray
    normals: SingleArray
    colours: SingleArray
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


@dataclass(frozen=True, eq=False)
class Instanced(ArrayData):
    """Rigid copies of whole models: placed, and turned about the vertical.

    shape        appearance of all models, each in its own frame; owners are rows of the parts
    model        (m,) which model each part belongs to
    part, level  (m,) what else is known of the parts
    which        (n,) model of each copy
    object       (n,) which object of this frame it is, as of ``lod.pruner.Parts``
    place        (n, 3) where it stands, in the frame's coordinates [m]
    turn         (n, 2) cosine and sine of its angle, counter-clockwise from above
    """

    shape: "Appearance"
    model: IntArray
    part: IntArray
    level: IntArray
    which: IntArray
    object: IntArray
    place: FloatArray
    turn: FloatArray

    def __len__(self) -> int:
        """Return the number of sticks and triangles of all copies together."""
        owner = np.concatenate([each.owner for each in batches_of(self.shape)])
        each = np.bincount(self.model[owner], minlength=int(self.which.max(initial=0)) + 1)
        return int(each[self.which].sum())


Appearance = Sticks | Triangles | SticksAndTriangles
"""What a representation gives for the displayed parts."""


def batches_of(shape: Appearance) -> tuple[Sticks | Triangles, ...]:
    """Return the one or two batched shapes of an appearance."""
    if isinstance(shape, SticksAndTriangles):
        return shape.sticks, shape.triangles
    return (shape,)
