"""Sticks of every representation, batched by tint into chains of points with radii."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from lod.parts import Sticks

MOST_SEGMENTS = 2**23
"""Segments in one shape: the renderer hands back their numbers as float32, exact below 2**24."""

_SHORTEST = 1e-2
"""A stick shorter than this share of its radius is drawn as long: the renderer drops points."""


@dataclass(frozen=True, eq=False)
class Batch:
    """Sticks of one tint.

    tint      (3,) albedo
    points    (p, 4) float32 x, y, z, radius
    segments  (s,) uint32 first point of each stick
    ids       (s, 3) uint32 object, part and level of each stick
    moves     (s, 2, 3) float32 how far both ends go to the next frame [m]; None where none does
    """

    tint: np.ndarray
    points: np.ndarray
    segments: np.ndarray
    ids: np.ndarray
    moves: np.ndarray | None


def batches(sticks: Sequence[tuple[Sticks, np.ndarray, Sticks | None]]) -> Iterator[Batch]:
    """One batch for each distinct tint, even of none, and another whenever one is full.

    Each element is a batch of sticks, (n, 3) ids of the parts that own them, and the same sticks
    in the next frame, where they move.
    """
    if not sticks:
        return
    tints, tint = _shared_tints([shape for shape, _, _ in sticks])
    ends = np.concatenate([_ends(shape) for shape, _, _ in sticks])
    ids = np.concatenate([table[shape.owner] for shape, table, _ in sticks])
    moves = _moves([(shape, later) for shape, _, later in sticks])
    order = np.argsort(tint, kind="stable")
    first = np.searchsorted(tint[order], np.arange(len(tints) + 1))
    for number, colour in enumerate(tints):
        for begin in range(first[number], max(first[number + 1], first[number] + 1), MOST_SEGMENTS):
            rows = order[begin : min(begin + MOST_SEGMENTS, first[number + 1])]
            points, segments = chain(ends[rows])
            moved = moves[rows] if moves is not None and moves[rows].any() else None
            yield Batch(colour, points, segments, ids[rows], moved)


def _shared_tints(shapes: Sequence[Sticks]) -> tuple[np.ndarray, np.ndarray]:
    """The distinct tints of all shapes (k, 3), and the one of each stick (n,)."""
    table = np.concatenate([shape.tints for shape in shapes])
    distinct, number = np.unique(table, axis=0, return_inverse=True)
    number = number.reshape(-1)
    first = np.cumsum([0] + [len(shape.tints) for shape in shapes])
    rows = [number[shape.tint + offset] for shape, offset in zip(shapes, first[:-1], strict=True)]
    return distinct, np.concatenate(rows)


def _moves(shapes: Sequence[tuple[Sticks, Sticks | None]]) -> np.ndarray | None:
    """How far both ends of every stick go, (n, 2, 3) float32 [m]; None where nothing moves."""
    if all(later is None for _, later in shapes):
        return None
    moves = np.zeros((sum(len(shape) for shape, _ in shapes), 2, 3), np.float32)
    first = 0
    for shape, later in shapes:
        rows = slice(first, first + len(shape))
        if later is not None:
            moves[rows, 0], moves[rows, 1] = later.start - shape.start, later.end - shape.end
        first = rows.stop
    return moves


def _ends(shape: Sticks) -> np.ndarray:
    """Both ends of each stick as (n, 2, 4) float32 x, y, z, radius; none of length 0."""
    ends = np.empty((len(shape), 2, 4), np.float32)
    ends[:, 0, :3], ends[:, 0, 3] = shape.start, shape.start_radius
    ends[:, 1, :3], ends[:, 1, 3] = shape.end, shape.end_radius
    length = np.abs(ends[:, 1, :3] - ends[:, 0, :3]).max(axis=1)
    shortest = _SHORTEST * ends[:, :, 3].max(axis=1)
    points = np.flatnonzero(length < shortest)
    ends[points, 1, 2] += np.maximum(
        shortest[points], 4 * np.spacing(np.abs(ends[points, 1, :3]).max(axis=1))
    )
    return ends


def chain(ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points and first-point numbers of sticks (n, 2, 4): a stick that starts where the last one
    ended, with the same radius, shares its point."""
    joined = np.zeros(len(ends), bool)
    joined[1:] = (ends[1:, 0] == ends[:-1, 1]).all(axis=1)
    keep = np.ones((len(ends), 2), bool)
    keep[:, 0] = ~joined
    points = ends.reshape(-1, 4)[keep.reshape(-1)]
    segments = np.cumsum(keep)[1::2] - 2  # one before the stick's end
    return points, segments.astype(np.uint32)
