"""The sticks of every part of an object as one table: round cones, part after part."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import TypeVar

import numpy as np

from lod.arrays import ArrayData, Flags, FloatArray, IntArray, Reals, check_columns
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
        _check(self)

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
        """Return the table of the flagged parts (n,) alone, numbered anew in their order."""
        first = np.concatenate(([0], np.cumsum(self.count[parts])))
        return type(self)(first, *(column[parts[self.owner]] for column in self.columns))

    def thickened(self: Table, factor: Reals) -> Table:
        """Return the table with both radii of each stick multiplied by its factor, (k,)."""
        radii = self.start_radius * factor, self.end_radius * factor
        return replace(self, start_radius=radii[0], end_radius=radii[1])

    def scaled(self: Table, factor: float) -> Table:
        """Return the table with every length multiplied by ``factor``."""
        names = ("start", "end", "start_radius", "end_radius")
        return replace(self, **{name: getattr(self, name) * factor for name in names})


def _check(table: StickTable) -> None:
    k = len(table.tint)
    points = {"start": (k, 3), "end": (k, 3)}
    check_columns("sticks", table, **points, start_radius=(k,), end_radius=(k,))
    first = table.first
    if (
        first.ndim != 1
        or len(first) == 0
        or first[0] != 0
        or first[-1] != k
        or np.any(np.diff(first) < 0)
    ):
        raise InputError("sticks.first", first, f"rises from 0 to the number of sticks, {k}")
    for name in ("start_radius", "end_radius"):
        if k and getattr(table, name).min() <= 0:
            raise InputError(f"sticks.{name}", float(getattr(table, name).min()), "above 0 m")
    if k and table.tint.min() < 0:
        raise InputError("sticks.tint", int(table.tint.min()), "a row of the tints, at least 0")
