"""The sticks of every part of an object as one table: round cones, part after part."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from lod.arrays import check_columns, freeze
from lod.errors import InputError

Table = TypeVar("Table", bound="StickTable")

_COLUMNS = ("owner", "start", "end", "start_radius", "end_radius", "tint")


@dataclass(frozen=True, eq=False)
class StickTable:
    """The sticks of n parts, part after part: each is the convex hull of two spheres.

    Whatever holds the table says in which frame it is. Prototypes have their origin where the
    object stands on the ground, z up, x the way it faces, y to its left; the compiled tables of an
    actor (``lod.actors.compile``) have the own frame of each part.

    first (n + 1,)  the sticks of part i are rows first[i]:first[i + 1]; there may be none
    start, end (k, 3) centres of the two spheres [m]
    start_radius, end_radius (k,) above 0 [m]
    tint (k,)  row of the object's tints

    Raises InputError for columns of other shapes, a radius that is not above 0, or a number that
    is not finite.
    """

    first: np.ndarray
    start: np.ndarray
    end: np.ndarray
    start_radius: np.ndarray
    end_radius: np.ndarray
    tint: np.ndarray

    def __post_init__(self) -> None:
        freeze(self, first=np.int64, start=np.float64, end=np.float64, tint=np.int64)
        freeze(self, start_radius=np.float64, end_radius=np.float64)
        _check(self)

    def __len__(self) -> int:
        return len(self.tint)

    @property
    def count(self) -> np.ndarray:
        """Number of sticks of each part, (n,)."""
        return np.diff(self.first)

    @property
    def owner(self) -> np.ndarray:
        """Part that each stick belongs to, (k,)."""
        return np.repeat(np.arange(len(self.first) - 1), self.count)

    @staticmethod
    def of(
        parts: int,
        owner: np.ndarray,
        start: np.ndarray,
        end: np.ndarray,
        start_radius: np.ndarray,
        end_radius: np.ndarray,
        tint: np.ndarray,
    ) -> "StickTable":
        """Build the table of ``parts`` parts from sticks in any order and their owners, (k,)."""
        owner = np.asarray(owner, np.int64)
        if len(owner) and not (owner.min() >= 0 and owner.max() < parts):
            raise InputError("sticks.owner", int(owner.max()), f"a part, 0 to {parts - 1}")
        order = np.argsort(owner, kind="stable")
        columns = (start, end, start_radius, end_radius, tint)
        count = np.bincount(owner, minlength=parts)
        return StickTable(
            np.concatenate(([0], np.cumsum(count))), *(np.asarray(c)[order] for c in columns)
        )

    @staticmethod
    def merge(tables: Sequence["StickTable"]) -> "StickTable":
        """Build the table of parts whose sticks stand in several tables of the same parts."""
        columns = [np.concatenate([getattr(t, name) for t in tables]) for name in _COLUMNS]
        return StickTable.of(len(tables[0].count), *columns)

    def with_owner(self, parts: int, owner: np.ndarray) -> "StickTable":
        """Return the table of ``parts`` parts with these sticks, each with its owner, (k,)."""
        return StickTable.of(parts, owner, *(getattr(self, name) for name in _COLUMNS[1:]))

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
