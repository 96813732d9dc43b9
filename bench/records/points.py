"""What did one case give? Named columns of raw numbers, beside what was predicted for them.

A column is named by its quantity and by further keys, as ``parts`` with ``air`` hazy and ``size``
over 3 m: claims, tables and plots pick and group columns by these names, and no text is parsed.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lod.arrays import Reals
from lod.errors import InputError

Key = str | int | float | bool
"""The value of a named key of a column."""


@dataclass(frozen=True)
class Column:
    """Raw numbers of one quantity: one for each field, frame, part or repeat that was measured."""

    quantity: str
    values: list[int]
    keys: dict[str, Key] = field(default_factory=dict)


@dataclass(frozen=True)
class Prediction:
    """What the law gives for the mean of a quantity, named as the column that it predicts."""

    quantity: str
    value: float
    keys: dict[str, Key] = field(default_factory=dict)


@dataclass(frozen=True)
class Point:
    """One case, what was predicted for it, and its columns of samples."""

    case: dict[str, Any]
    predicted: tuple[Prediction, ...] = ()
    samples: tuple[Column, ...] = ()

    def column(self, quantity: str, **keys: Key) -> list[int]:
        """Give the numbers of the column with exactly this name.

        Raises InputError where there is none.
        """
        for each in self.samples:
            if each.quantity == quantity and each.keys == keys:
                return each.values
        raise _missing(self, quantity, keys)

    def values(self, quantity: str, **keys: Key) -> Reals:
        """Give a column as float64, (n,). Raises InputError where there is none."""
        return np.array(self.column(quantity, **keys), np.float64)

    def prediction(self, quantity: str, **keys: Key) -> float:
        """Give what was predicted under exactly this name. Raises InputError where nothing was."""
        for each in self.predicted:
            if each.quantity == quantity and each.keys == keys:
                return each.value
        raise _missing(self, quantity, keys)


def columns(samples: Mapping[str, list[int]], **keys: Key) -> tuple[Column, ...]:
    """Make one column of each quantity; all of them have these keys."""
    return tuple(Column(quantity, values, dict(keys)) for quantity, values in samples.items())


def predictions(means: Mapping[str, float], **keys: Key) -> tuple[Prediction, ...]:
    """Make one prediction of each quantity; all of them have these keys."""
    return tuple(Prediction(quantity, float(v), dict(keys)) for quantity, v in means.items())


def where(points: Iterable[Point], **case: Any) -> list[Point]:
    """Give the points whose case has all these values, in their order."""
    return [p for p in points if all(p.case.get(k) == v for k, v in case.items())]


def grouped(points: Iterable[Point], *names: str) -> dict[tuple[Any, ...], list[Point]]:
    """Group points by the values that their cases have under these names, in their order."""
    groups: dict[tuple[Any, ...], list[Point]] = {}
    for point in points:
        groups.setdefault(tuple(point.case.get(name) for name in names), []).append(point)
    return groups


def merge_points(points: Iterable[Point]) -> tuple[Point, ...]:
    """Merge points of one case: equally named columns one after the other, first predictions kept.

    Cases and columns keep the order in which they first come.
    """
    merged: dict[str, tuple[Point, dict[str, Column]]] = {}
    for point in points:
        _, found = merged.setdefault(repr(point.case), (point, {}))
        for each in point.samples:
            name = repr((each.quantity, each.keys))
            before = found[name].values if name in found else []
            found[name] = Column(each.quantity, [*before, *each.values], each.keys)
    return tuple(
        Point(first.case, first.predicted, tuple(found.values()))
        for first, found in merged.values()
    )


def point_json(point: Point) -> dict[str, Any]:
    """Give a point as plain data that shares its lists of numbers: they are large."""
    return {
        "case": point.case,
        "predicted": [vars(each) for each in point.predicted],
        "samples": [vars(each) for each in point.samples],
    }


def point_from_json(data: Mapping[str, Any]) -> Point:
    """Read a point back from plain data."""
    return Point(
        data["case"],
        tuple(Prediction(**each) for each in data["predicted"]),
        tuple(Column(**each) for each in data["samples"]),
    )


def _missing(point: Point, quantity: str, keys: Mapping[str, Key]) -> InputError:
    names = sorted({each.quantity for each in point.samples})
    return InputError("column", (quantity, dict(keys)), f"one of the point's: {', '.join(names)}")
