"""Sticks of every representation, batched by tint into chains of points with radii, compiled."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from lod.pruning.shapes import Sticks

MOST_SEGMENTS = 2**23
"""Segments in one shape: the renderer hands back their numbers as float32, exact below 2**24."""

_SHORTEST = np.float32(1e-2)
"""A stick shorter than this share of its radius is drawn as long: the renderer drops points."""

_LEAST_M = np.float32(1e-4)
"""Nor is any drawn shorter than this: of balls of 2 mm, 0.02 mm long, Embree makes streaks that
cover half as much again, and of 0.2 mm long balls [m]."""


ALIGNMENT = 64
"""Bytes: a cache line, and the widest vector register."""


@dataclass(frozen=True, eq=False)
class Batch:
    """Sticks of one tint.

    tint      (3,) albedo
    points    (p, 4) float32 x, y, z, radius
    segments  (s,) uint32 first point of each stick
    owners    (s,) uint32 row of the part that each stick belongs to, in a table of all
    moves     (s, 2, 3) float32 how far both ends go to the next frame [m]; None where none does
    """

    tint: np.ndarray
    points: np.ndarray
    segments: np.ndarray
    owners: np.ndarray
    moves: np.ndarray | None


def batches(sticks: Sequence[tuple[Sticks, int, Sticks | None]]) -> Iterator[Batch]:
    """One batch for each distinct tint, even of none, and another whenever one is full.

    Each element is a batch of sticks, the row of its first part in the table of all, and the same
    sticks in the next frame, where they move.
    """
    if not sticks:
        return
    tints, numbers = _shared_tints([shape for shape, _, _ in sticks])
    count = np.zeros(len(tints), np.int64)
    for (shape, _, _), number in zip(sticks, numbers, strict=True):
        count += np.bincount(number[shape.tint], minlength=len(tints))
    # Room for each tint, side by side: two points a stick, of which chains leave some untouched.
    first = np.cumsum(count) - count
    points = np.empty((2 * int(count.sum()), 4), np.float32)
    segments, owners = (np.empty(len(points) // 2, np.uint32) for _ in range(2))
    moves = np.zeros((len(owners), 2, 3), np.float32) if _moving(sticks) else None
    done = np.zeros((2, len(tints)), np.int64)
    for (shape, part, later), number in zip(sticks, numbers, strict=True):
        axes = shape.start, shape.end, shape.start_radius, shape.end_radius
        place = _lay(
            *axes, shape.tint, shape.owner, part, number, first, done, points, segments, owners
        )
        if moves is not None and later is not None:
            moves[place, 0], moves[place, 1] = later.start - shape.start, later.end - shape.end
    for tint, colour in enumerate(tints):
        rows = slice(int(first[tint]), int(first[tint] + count[tint]))
        laid = points[2 * rows.start : 2 * rows.start + int(done[1, tint])]
        yield from _filled(
            colour, laid, segments[rows], owners[rows], None if moves is None else moves[rows]
        )


def aligned(shape: tuple[int, ...]) -> np.ndarray:
    """Room for points, float32, where a vector register may load them from."""
    size = 4 * math.prod(shape)
    room = np.empty(size + ALIGNMENT, np.uint8)
    start = -room.ctypes.data % ALIGNMENT
    found: np.ndarray = room[start : start + size].view(np.float32).reshape(shape)
    return found


def _filled(
    colour: np.ndarray,
    points: np.ndarray,
    segments: np.ndarray,
    owners: np.ndarray,
    moves: np.ndarray | None,
) -> Iterator[Batch]:
    """The sticks of one tint, in as many batches as they fill."""
    for begin in range(0, max(len(segments), 1), MOST_SEGMENTS):
        rows = slice(begin, begin + MOST_SEGMENTS)
        low, high = (int(segments[rows][k]) if len(segments) else 0 for k in (0, -1))
        own = segments[rows] - np.uint32(low)
        some = moves is not None and moves[rows].any()
        chains = points[low : high + 2]
        yield Batch(
            colour, chains, own, owners[rows], moves[rows] if moves is not None and some else None
        )


def _moving(sticks: Sequence[tuple[Sticks, int, Sticks | None]]) -> bool:
    return any(later is not None for _, _, later in sticks)


def _shared_tints(shapes: Sequence[Sticks]) -> tuple[np.ndarray, list[np.ndarray]]:
    """The distinct tints of all shapes (k, 3), and for each shape the one of each of its own."""
    table = np.concatenate([shape.tints for shape in shapes])
    distinct, number = np.unique(table, axis=0, return_inverse=True)
    ends = np.cumsum([len(shape.tints) for shape in shapes])
    return distinct, np.split(number.reshape(-1), ends[:-1])


@njit(cache=True)
def _lay(start, end, r0, r1, tint, owner, part, number, first, done, points, segments, owners):  # type: ignore[no-untyped-def]
    """Lay sticks down behind those of their tint; a stick that starts where the last one ended,
    with the same radius, shares its point. Gives the row of each.

    done (2, k): sticks and points of each tint so far; points are counted from its own first.
    """
    place = np.empty(len(tint), np.int64)
    for m in range(len(tint)):
        t = number[tint[m]]
        row, at = first[t] + done[0, t], 2 * first[t] + done[1, t]
        x0, y0, z0 = np.float32(start[m, 0]), np.float32(start[m, 1]), np.float32(start[m, 2])
        x1, y1, z1 = np.float32(end[m, 0]), np.float32(end[m, 1]), np.float32(end[m, 2])
        a, b = np.float32(r0[m]), np.float32(r1[m])
        shortest = max(_SHORTEST * max(a, b), _LEAST_M)
        if max(abs(x1 - x0), abs(y1 - y0), abs(z1 - z0)) < shortest:
            coarse = 4 * np.spacing(max(abs(x1), abs(y1), abs(z1)))
            z1 = z1 + max(shortest, coarse)
        joined = False
        if done[0, t] > 0:
            p = points[at - 1]
            joined = p[0] == x0 and p[1] == y0 and p[2] == z0 and p[3] == a
        if not joined:
            points[at, 0], points[at, 1], points[at, 2], points[at, 3] = x0, y0, z0, a
            at += 1
        points[at, 0], points[at, 1], points[at, 2], points[at, 3] = x1, y1, z1, b
        segments[row] = at - 1 - 2 * first[t]
        owners[row] = owner[m] + part
        place[m] = row
        done[0, t] += 1
        done[1, t] = at + 1 - 2 * first[t]
    return place
