"""Sticks of every representation as chains of points with radii, batched for curve shapes.

A batch is what one curve shape holds: the sticks of one tint, or those of all tints with a table of
their albedos. JIT variants want the latter: Embree's leaves hold up to eight curves of one shape,
and where tints lie among each other, as a tree's do, a shape for each tint leaves most of those
places empty: three times the memory, and slower to build and to trace.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from lod.shapes import Sticks

MOST_SEGMENTS = 2**23
"""Segments in one shape: the renderer hands back their numbers as float32, exact below 2**24."""

ALIGNMENT = 64
"""Bytes: a cache line, and the widest vector register."""

_SHORTEST = np.float32(1e-2)
"""A stick shorter than this share of its radius is drawn as long: the renderer drops points."""

_LEAST_M = np.float32(1e-4)
"""Nor is any drawn shorter than this: of balls of 2 mm, 0.02 mm long, Embree makes streaks that
cover half as much again, and of 0.2 mm long balls [m]."""


class PlacedSticks(NamedTuple):
    """Sticks of one representation in a frame.

    sticks     as they are at the frame's time
    first_row  row of the representation's first part in the table of all displayed parts
    later      the same sticks a frame later, where they move; None = as now
    """

    sticks: Sticks
    first_row: int
    later: Sticks | None


@dataclass(frozen=True, eq=False)
class Batch:
    """The sticks of one curve shape.

    tints     (k, 3) albedos; where batches are made by tint, k = 1
    counts    (k,) sticks of each tint; they lie tint by tint
    points    (p, 4) float32 x, y, z, radius
    segments  (s,) uint32 first point of each stick
    owners    (s,) uint32 row of the part that each stick belongs to, in a table of all
    moves     (s, 2, 3) float32 how far both ends go to the next frame [m]; None where none does
    """

    tints: np.ndarray
    counts: np.ndarray
    points: np.ndarray
    segments: np.ndarray
    owners: np.ndarray
    moves: np.ndarray | None


def batches(
    placed: Sequence[PlacedSticks], by_tint: bool, most_segments: int = MOST_SEGMENTS
) -> Iterator[Batch]:
    """Batch the sticks of a frame: one batch for each distinct tint, or one for all.

    A tint without sticks has its batch, or its row, too. Another batch begins whenever one has
    ``most_segments``.
    """
    if not placed:
        return
    tints, numbers = _shared_tints([each.sticks for each in placed])
    count = np.zeros((2, len(tints)), np.int64)
    last = np.zeros((len(tints), 4), np.float32)
    for each, number in zip(placed, numbers, strict=True):
        _count(_columns(each.sticks), number, count, last)
    # Tints lie side by side, in exactly the room that their sticks and points take.
    rows = np.append(0, np.cumsum(count[0]))
    laid = np.stack((rows[:-1], np.cumsum(count[1]) - count[1]))
    begin = laid[1].copy()
    points = aligned((int(count[1].sum()), 4))
    segments, owners = (np.empty(int(rows[-1]), np.uint32) for _ in range(2))
    moving = any(each.later is not None for each in placed)
    moves = np.zeros((len(owners), 2, 3), np.float32) if moving else None
    room = _Room(points, segments, owners)
    for each, number in zip(placed, numbers, strict=True):
        place = _lay(_columns(each.sticks), number, each.first_row, begin, laid, room)
        if moves is not None and each.later is not None:
            moves[place, 0] = each.later.start - each.sticks.start
            moves[place, 1] = each.later.end - each.sticks.end
    for group in _groups(rows, by_tint, most_segments):
        yield _batch(tints, group, room, moves)


def aligned(shape: tuple[int, ...]) -> np.ndarray:
    """Make room for float32 numbers where a vector register may load them from."""
    size = 4 * math.prod(shape)
    room = np.empty(size + ALIGNMENT, np.uint8)
    start = -room.ctypes.data % ALIGNMENT
    found: np.ndarray = room[start : start + size].view(np.float32).reshape(shape)
    return found


class _Columns(NamedTuple):
    """What of sticks makes points: ends (n, 3), radii, tints and owners (n,)."""

    start: Any
    end: Any
    start_radius: Any
    end_radius: Any
    tint: Any
    owner: Any


class _Room(NamedTuple):
    """Where sticks are laid down: points (p, 4), segments and owners (s,)."""

    points: Any
    segments: Any
    owners: Any


class _Piece(NamedTuple):
    """Sticks of one tint that are in one batch: rows from ``begin`` to before ``end``."""

    tint: int
    begin: int
    end: int


def _columns(sticks: Sticks) -> _Columns:
    return _Columns(
        sticks.start,
        sticks.end,
        sticks.start_radius,
        sticks.end_radius,
        sticks.tint,
        sticks.owner,
    )


def _groups(rows: np.ndarray, by_tint: bool, most: int) -> Iterator[list[_Piece]]:
    """What each batch holds: the pieces of tints whose rows begin at ``rows`` (k + 1,)."""
    group: list[_Piece] = []
    for tint, (first, last) in enumerate(zip(rows[:-1].tolist(), rows[1:].tolist(), strict=True)):
        for begin in range(first, max(last, first + 1), most):
            piece = _Piece(tint, begin, min(begin + most, last))
            if group and (by_tint or piece.end - group[0].begin > most):
                yield group
                group = []
            group.append(piece)
    if group:
        yield group


def _batch(tints: np.ndarray, group: list[_Piece], room: _Room, moves: np.ndarray | None) -> Batch:
    """The rows of a group of pieces, which lie side by side, as a batch."""
    rows = slice(group[0].begin, group[-1].end)
    own = room.segments[rows]
    low, high = (int(own[0]), int(own[-1]) + 2) if len(own) else (0, 0)
    some = moves is not None and moves[rows].any()
    return Batch(
        tints=tints[group[0].tint : group[-1].tint + 1],
        counts=np.array([each.end - each.begin for each in group]),
        points=room.points[low:high],
        segments=own - np.uint32(low) if low else own,
        owners=room.owners[rows],
        moves=moves[rows] if moves is not None and some else None,
    )


def _shared_tints(shapes: Sequence[Sticks]) -> tuple[np.ndarray, list[np.ndarray]]:
    """The distinct tints of all shapes (k, 3), and for each shape the one of each of its own."""
    table = np.concatenate([shape.tints for shape in shapes])
    distinct, number = np.unique(table, axis=0, return_inverse=True)
    ends = np.cumsum([len(shape.tints) for shape in shapes])
    return distinct, np.split(number.reshape(-1), ends[:-1])


@njit(cache=True)
def _ends(sticks, m):  # type: ignore[no-untyped-def]
    """Both ends of a stick, each x, y, z and radius; none is too short for the renderer."""
    start, end = sticks.start, sticks.end
    x0, y0, z0 = np.float32(start[m, 0]), np.float32(start[m, 1]), np.float32(start[m, 2])
    x1, y1, z1 = np.float32(end[m, 0]), np.float32(end[m, 1]), np.float32(end[m, 2])
    a, b = np.float32(sticks.start_radius[m]), np.float32(sticks.end_radius[m])
    shortest = max(_SHORTEST * max(a, b), _LEAST_M)
    if max(abs(x1 - x0), abs(y1 - y0), abs(z1 - z0)) < shortest:
        coarse = 4 * np.spacing(max(abs(x1), abs(y1), abs(z1)))
        z1 = z1 + max(shortest, coarse)
    return (x0, y0, z0, a), (x1, y1, z1, b)


@njit(cache=True)
def _continues(point, first):  # type: ignore[no-untyped-def]
    """Whether a stick starts where the last one ended, with the same radius."""
    return (
        point[0] == first[0]
        and point[1] == first[1]
        and point[2] == first[2]
        and (point[3] == first[3])
    )


@njit(cache=True)
def _count(sticks, number, count, last):  # type: ignore[no-untyped-def]
    """Add sticks to ``count`` (2, k): sticks and points of each tint; ``last`` (k, 4) is the point
    where each tint's chain ends so far."""
    for m in range(len(sticks.tint)):
        t = number[sticks.tint[m]]
        first, second = _ends(sticks, m)
        if count[0, t] == 0 or not _continues(last[t], first):
            count[1, t] += 1
        last[t, 0], last[t, 1], last[t, 2], last[t, 3] = second
        count[0, t] += 1
        count[1, t] += 1


@njit(cache=True)
def _lay(sticks, number, first_row, begin, laid, room):  # type: ignore[no-untyped-def]
    """Lay sticks down behind those of their tint; a stick that goes on from the last one shares its
    point. Gives the row of each.

    begin (k,): where each tint's points begin; laid (2, k): where its next stick and point go.
    """
    points = room.points
    place = np.empty(len(sticks.tint), np.int64)
    for m in range(len(sticks.tint)):
        t = number[sticks.tint[m]]
        first, second = _ends(sticks, m)
        row, at = laid[0, t], laid[1, t]
        if at == begin[t] or not _continues(points[at - 1], first):
            points[at, 0], points[at, 1], points[at, 2], points[at, 3] = first
            at += 1
        points[at, 0], points[at, 1], points[at, 2], points[at, 3] = second
        room.segments[row] = at - 1
        room.owners[row] = sticks.owner[m] + first_row
        place[m] = row
        laid[0, t] = row + 1
        laid[1, t] = at + 1
    return place
